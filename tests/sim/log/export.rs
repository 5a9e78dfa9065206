//! Exported logs as other programs read them: every column of every tick, bit for
//! bit.
//!
//! The expected values are written beside the exported files, column by column, straight
//! from the records; `tests/python/columns.py` reads both with pyarrow, polars, `SciPy` and
//! Python's own csv, and compares.

use std::fs;
use std::path::{Path, PathBuf};

use armbridge_analysis::monte_carlo::Trial;
use armbridge_analysis::plan_runner::Script;
use armbridge_client::enum_names;
use armbridge_link::message::{
    Fault, Guards, Mode, Record, Sample, Settings, Setup, TickInput, TickOutput,
};
use armbridge_log::export::column::{self, Quantity, Values};
use armbridge_log::export::{self, About, Format};
use armbridge_log::inspect::settings;
use armbridge_log::output_file::{Existing, OutputFile};
use armbridge_log::recording::Row;
use armbridge_log::run_info::RunFacts;
use armbridge_log::simulation::TrueState;
use armbridge_sim::plant::{PlantConfig, Push};
use armbridge_tests::paths;

/// Numbers that are hard to write down.
const HARD: [f32; 6] = [
    f32::NAN,
    f32::NEG_INFINITY,
    -0.0,
    f32::MIN_POSITIVE / 8.0,
    f32::MAX,
    0.1,
];

/// A run on the bench in which a fifth of the samples is missing and the arm is
/// pushed over its limit, then whatever else a record can hold.
fn records() -> Vec<Record> {
    let setup = Setup::best();
    let push = Push {
        joint: 0,
        torque_nm: 3.0,
        start_ns: 1_000_000_000,
        duration_ns: 300_000_000,
    };
    let trial = Trial {
        pushes: vec![push],
        loss: 0.2,
        ..Trial::new(PlantConfig::default(), Script::demo(setup, 2_000_000))
    };
    let mut records = trial.run(1).unwrap().records;
    let is_faulty = |record: &Record| enum_names::fault_of(record.mode).is_some();
    assert!(records.iter().any(is_faulty), "no fault on the way");
    // A gap.
    records.drain(500..520);
    let last = *records.last().unwrap();
    let modes = Fault::ALL
        .into_iter()
        .map(Mode::Fault)
        .chain(enum_names::MODES);
    for (i, mode) in modes.enumerate() {
        let missing = enum_names::MISSING[i % enum_names::MISSING.len()];
        let hard = |by: usize| HARD[(i + by) % HARD.len()];
        records.push(Record {
            tick: last.tick + 2 + i as u32,
            mode,
            dropped: u32::MAX,
            input: TickInput {
                // A year of the board's time, to the microsecond.
                start_us: 31_557_600_000_000 + i as u64,
                samples: [Sample::Missing(missing), Sample::Counts(i as u16)],
                alarms: [(i as u8) & 0x7f, 1 << (i % 7)],
                ..last.input
            },
            output: TickOutput {
                guards: Guards::BRAKED.or(Guards::PWM),
                reference_rad: [hard(0), hard(1)],
                reference_speed_rad_s: [hard(2), hard(3)],
                angle_rad: [hard(4), hard(5)],
                speed_rad_s: [hard(1), hard(0)],
                torque_nm: [hard(3), hard(2)],
                disturbance_nm: [hard(5), hard(4)],
                ..last.output
            },
            ..last
        });
    }
    records
}

/// A number for each true quantity.
fn true_value(record: &Record, quantity: usize, joint: usize) -> f32 {
    record.tick as f32 + 0.25 * quantity as f32 - 1e6 * joint as f32
}

/// True state of the tick; every third is not known.
fn truth(record: &Record) -> Option<TrueState> {
    let pair = |quantity| [0, 1].map(|joint| true_value(record, quantity, joint));
    (!record.tick.is_multiple_of(3)).then(|| TrueState {
        at_ns: record.input.start_us * 1_000,
        angle_rad: pair(0),
        speed_rad_s: pair(1),
        torque_nm: pair(2),
        friction_nm: pair(3),
        push_nm: pair(4),
    })
}

/// Writes a column as the bytes of its numbers, or as words.
struct Expected<'a> {
    folder: PathBuf,
    records: &'a [Record],
}

impl Expected<'_> {
    fn bytes<const N: usize>(&self, name: &str, kind: &str, of: impl Fn(&Record) -> [u8; N]) {
        let bytes: Vec<u8> = self.records.iter().flat_map(of).collect();
        fs::write(self.folder.join(format!("{name}.{kind}")), bytes).unwrap();
    }

    fn reals(&self, names: [&str; 2], of: impl Fn(&Record) -> [f32; 2]) {
        for (joint, name) in names.into_iter().enumerate() {
            self.bytes(name, "f4", |record| of(record)[joint].to_le_bytes());
        }
    }

    fn words(&self, name: &str, of: impl Fn(&Record) -> String) {
        let words: Vec<String> = self.records.iter().map(of).collect();
        let json = serde_json::to_string(&words).unwrap();
        fs::write(self.folder.join(format!("{name}.json")), json).unwrap();
    }

    fn write(&self) {
        self.bytes("time_s", "f8", |r| {
            (r.input.start_us as f64 / 1e6).to_le_bytes()
        });
        self.bytes("tick", "u4", |r| r.tick.to_le_bytes());
        self.words("board_mode", |r| enum_names::mode(r.mode).to_owned());
        let fault = |r: &Record| enum_names::fault_of(r.mode).map_or("", Fault::name);
        self.words("fault", |r| fault(r).to_owned());
        self.words("guards", |r| enum_names::guards(r.output.guards));
        self.reals(["reference_rad_1", "reference_rad_2"], |r| {
            r.output.reference_rad
        });
        self.reals(
            ["reference_speed_rad_s_1", "reference_speed_rad_s_2"],
            |r| r.output.reference_speed_rad_s,
        );
        self.reals(["angle_rad_1", "angle_rad_2"], |r| r.output.angle_rad);
        self.reals(["speed_rad_s_1", "speed_rad_s_2"], |r| r.output.speed_rad_s);
        self.reals(["torque_nm_1", "torque_nm_2"], |r| r.output.torque_nm);
        self.reals(["disturbance_nm_1", "disturbance_nm_2"], |r| {
            r.output.disturbance_nm
        });
        for joint in 0..2 {
            let name = |quantity: &str| format!("{quantity}_{}", joint + 1);
            // Missing: -1.
            let count = |r: &Record| r.input.samples[joint].counts().map_or(-1, i32::from);
            self.bytes(&name("encoder_counts"), "i4", |r| count(r).to_le_bytes());
            let missing = |r: &Record| {
                r.input.samples[joint]
                    .missing()
                    .map_or("", enum_names::missing)
            };
            self.words(&name("missing"), |r| missing(r).to_owned());
            self.words(&name("alarms"), |r| {
                enum_names::alarms(r.input.alarms[joint])
            });
            let in_force = |r: &Record| r.input.pwm_in_force[joint].to_le_bytes();
            self.bytes(&name("pwm_counts"), "u2", in_force);
            let next = |r: &Record| r.output.pwm[joint].to_le_bytes();
            self.bytes(&name("pwm_next_counts"), "u2", next);
        }
        self.bytes("start_error_us", "u4", |r| {
            r.timing.start_error_us.to_le_bytes()
        });
        self.bytes("bus_us", "u4", |r| r.timing.bus_us.to_le_bytes());
        self.bytes("compute_ns", "u4", |r| r.timing.compute_ns.to_le_bytes());
        self.bytes("missed_ticks", "u4", |r| r.timing.missed.to_le_bytes());
        self.bytes("dropped_records", "u4", |r| r.dropped.to_le_bytes());
        let is_true = |quantity: &&Quantity| matches!(quantity.values, Values::Truth(_));
        let quantities = column::QUANTITIES.iter().filter(is_true);
        for (i, quantity) in quantities.enumerate() {
            for (joint, name) in quantity.columns.iter().enumerate() {
                let value = |r: &Record| truth(r).map_or(f32::NAN, |_| true_value(r, i, joint));
                self.bytes(name, "f4", |r| value(r).to_le_bytes());
            }
        }
    }
}

fn export_all(folder: &Path, records: &[Record], settings: &Settings) {
    let facts = RunFacts::from_settings("demo", "simulated: bench", settings);
    let about = About {
        facts: &facts,
        settings: settings::list(settings),
        damage: &["the log breaks off".to_owned()],
        has_true_states: true,
    };
    for format in [Format::Csv, Format::Parquet, Format::Mat] {
        let path = folder.join("run").with_extension(format.extension());
        let row = |record: &Record| Row {
            record: *record,
            truth: truth(record),
        };
        let rows = || Ok(records.iter().map(row));
        let file = OutputFile::create(&path, Existing::Replace).unwrap();
        let (written, ticks) = export::write(format, file, &about, rows).unwrap();
        assert_eq!(written, path);
        assert_eq!(ticks, records.len() as u64);
    }
}

#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn pyarrow_polars_and_scipy_read_every_column_bit_for_bit() {
    let folder = paths::target().join("tmp/export");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("expected")).unwrap();
    let records = records();
    let expected = Expected {
        folder: folder.join("expected"),
        records: &records,
    };
    expected.write();
    let settings = Settings {
        setup: Setup::best(),
        ..Settings::default()
    };
    export_all(&folder, &records, &settings);

    let output = paths::script("columns.py").arg(&folder).output().unwrap();
    let stdout = String::from_utf8_lossy(&output.stdout);
    let failed = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stdout}{failed}");
    assert!(stdout.contains("42 columns"), "{stdout}");
    print!("{stdout}");
}
