//! Logs for tests, made of given ticks.

use std::path::Path;

use armbridge_client::event::Direction;
use armbridge_link::frame::Encoder;
use armbridge_link::message::{Record, Settings, ToHost};
use armbridge_log::recorder::Recorder;
use armbridge_log::run_info::RunFacts;
use armbridge_log::simulation::{Push, SimulationEvent};

/// Writes a log of these ticks; the pushes are in it before all of them, as a recorder writes
/// what it takes from its queue at once.
pub(crate) fn write_log(path: &Path, pushes: &[Push], records: &[Record]) {
    let facts = RunFacts::from_settings("test", "simulated: bench", &Settings::default());
    let recorder = Recorder::create_waiting(path, &facts).unwrap();
    let (mut tap, mut encoder) = (recorder.tap(), Encoder::default());
    for push in pushes {
        tap.simulated(&SimulationEvent::Push(*push));
    }
    for record in records {
        let frame = encoder.encode(&ToHost::Record(*record)).1;
        tap.bytes(Direction::ToHost, record.input.start_us * 1_000, frame);
    }
    drop(tap);
    let report = recorder.finish().unwrap();
    assert_eq!(
        (report.records, report.trouble),
        (records.len() as u64, None)
    );
}
