//! Settings of a log: those in force when the motors were first driven, in one place.

use std::path::{Path, PathBuf};

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_link::message::Setup;
use armbridge_log::inspect::Head;
use armbridge_log::recorder::Recorder;
use armbridge_log::recording::Reader;
use armbridge_sim::link::{BoardUri, Options};
use armbridge_sim::plant::{Plant, PlantConfig};
use armbridge_sim::{Bench, link};
use mcap::records::Record;

use super::{facts, folder};

/// Period of the run; that of the board before and after it is 1000.
const PERIOD_US: u32 = 2_000;

/// A run of 2 s on the bench, which begins with other settings and ends with them.
fn recorded(name: &str) -> PathBuf {
    let path = folder(name).join("run.mcap");
    let recorder = Recorder::create_waiting(&path, &facts()).unwrap();
    let mut options = Options::new(Bench::new(Plant::new(PlantConfig::default(), 1)));
    options.link.taps.push(recorder.tap());
    let setup = Setup {
        period_us: PERIOD_US,
        ..Setup::default()
    };
    let runner = PlanRunner::new(Script::demo(setup, 2_000_000));
    let (_, done) = link::drive(&BoardUri::Sim, options, runner);
    done.map_err(|error| error.to_string()).unwrap();
    recorder.finish().unwrap();
    path
}

fn metadata_records(path: &Path, name: &str) -> usize {
    let bytes = std::fs::read(path).unwrap();
    let records = mcap::read::LinearReader::new(&bytes).unwrap();
    let is_named = |record: &mcap::McapResult<Record<'_>>| match record {
        Ok(Record::Metadata(metadata)) => metadata.name == name,
        _ => false,
    };
    records.filter(is_named).count()
}

fn period_us(path: &Path) -> Option<u32> {
    let reader = Reader::open(path).unwrap();
    let settings = reader.settings()?;
    assert_eq!(reader.facts().period_us, settings.setup.period_us);
    assert_eq!(
        Head::read(path, |_| ()).unwrap().settings.as_ref(),
        Some(settings)
    );
    Some(settings.setup.period_us)
}

#[test]
fn a_log_has_one_record_of_its_run_and_one_of_its_settings() {
    let path = recorded("one_record");
    for name in ["run", "parameters", "board", "build", "clock", "end"] {
        assert_eq!(metadata_records(&path, name), 1, "{name}");
    }
    assert_eq!(period_us(&path), Some(PERIOD_US));
}

#[test]
fn a_log_that_was_cut_has_them_too() {
    let path = recorded("cut_settings");
    let whole = std::fs::read(&path).unwrap();
    let cut = path.with_file_name("cut.mcap");
    for share in [30, 50, 80, 99] {
        std::fs::write(&cut, &whole[..whole.len() * share / 100]).unwrap();
        assert_eq!(period_us(&cut), Some(PERIOD_US), "{share} %");
    }
    assert_eq!(Reader::open(&cut).unwrap().facts().name, "test");
}
