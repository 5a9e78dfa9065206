//! Any record is read back from the table.

use armbridge_client::enum_names;
use armbridge_link::message::{
    Drive, Fault, Guards, Missing, Mode, Record, Sample, TickInput, TickOutput, Timing,
};
use armbridge_log::simulation::TrueState;
use armbridge_log::{CsvWriter, recording};
use armbridge_tests::synthetic;
use serde::Deserialize;

use super::folder;

/// A row as a script reads it: columns by name.
#[derive(Deserialize)]
struct Row {
    time_s: f64,
    tick: u32,
    board_mode: String,
    fault: String,
    guards: String,
    reference_rad_1: f32,
    reference_speed_rad_s_1: f32,
    angle_rad_1: f32,
    speed_rad_s_1: f32,
    encoder_counts_1: Option<u16>,
    missing_1: String,
    alarms_1: String,
    torque_nm_1: f32,
    disturbance_nm_1: f32,
    pwm_counts_1: u16,
    pwm_next_counts_1: u16,
    reference_rad_2: f32,
    reference_speed_rad_s_2: f32,
    angle_rad_2: f32,
    speed_rad_s_2: f32,
    encoder_counts_2: Option<u16>,
    missing_2: String,
    alarms_2: String,
    torque_nm_2: f32,
    disturbance_nm_2: f32,
    pwm_counts_2: u16,
    pwm_next_counts_2: u16,
    start_error_us: u32,
    bus_us: u32,
    compute_ns: u32,
    missed_ticks: u32,
    dropped_records: u32,
    true_push_nm_2: Option<f32>,
}

fn mode(name: &str, fault: &str) -> Option<Mode> {
    let mut modes = enum_names::MODES.into_iter();
    let mut faults = Fault::ALL.into_iter();
    match name {
        "fault" => faults.find(|known| known.name() == fault).map(Mode::Fault),
        name => modes.find(|known| enum_names::mode(*known) == name),
    }
}

fn guards(names: &str) -> Option<Guards> {
    let mut names = names.split('+').filter(|name| !name.is_empty());
    names.try_fold(Guards::NONE, |all, name| {
        let guard = match name {
            "braked" => Guards::BRAKED,
            "torque" => Guards::TORQUE,
            "rate" => Guards::RATE,
            "pwm" => Guards::PWM,
            _ => return None,
        };
        Some(all.or(guard))
    })
}

fn sample(count: Option<u16>, missing: &str) -> Option<Sample> {
    let mut kinds = enum_names::MISSING.into_iter();
    let kind: Option<Missing> = kinds.find(|kind| enum_names::missing(*kind) == missing);
    match count {
        Some(counts) => missing.is_empty().then_some(Sample::Counts(counts)),
        None => kind.map(Sample::Missing),
    }
}

fn alarms(names: &str) -> Option<u8> {
    (0..=u8::MAX).find(|bits| enum_names::alarms(*bits) == names)
}

impl Row {
    /// The record that the row was made from; none if a word in it is unknown.
    fn record(&self) -> Option<Record> {
        Some(Record {
            tick: self.tick,
            mode: mode(&self.board_mode, &self.fault)?,
            timing: Timing {
                start_error_us: self.start_error_us,
                bus_us: self.bus_us,
                compute_ns: self.compute_ns,
                missed: self.missed_ticks,
            },
            dropped: self.dropped_records,
            input: TickInput {
                start_us: (self.time_s * 1e6).round() as u64,
                samples: [
                    sample(self.encoder_counts_1, &self.missing_1)?,
                    sample(self.encoder_counts_2, &self.missing_2)?,
                ],
                alarms: [alarms(&self.alarms_1)?, alarms(&self.alarms_2)?],
                pwm_in_force: [self.pwm_counts_1, self.pwm_counts_2],
                ..TickInput::AT_REST
            },
            output: TickOutput {
                guards: guards(&self.guards)?,
                pwm: [self.pwm_next_counts_1, self.pwm_next_counts_2],
                reference_rad: [self.reference_rad_1, self.reference_rad_2],
                reference_speed_rad_s: [self.reference_speed_rad_s_1, self.reference_speed_rad_s_2],
                angle_rad: [self.angle_rad_1, self.angle_rad_2],
                speed_rad_s: [self.speed_rad_s_1, self.speed_rad_s_2],
                torque_nm: [self.torque_nm_1, self.torque_nm_2],
                disturbance_nm: [self.disturbance_nm_1, self.disturbance_nm_2],
                ..TickOutput::NONE
            },
        })
    }
}

/// The synthetic run, then one record for each fault and kind of missing
/// sample, with numbers at the ends of their ranges.
fn every_kind_of_record() -> Vec<Record> {
    let mut records = synthetic::run(0.06);
    let last = *records.last().unwrap();
    let modes = Fault::ALL
        .into_iter()
        .map(Mode::Fault)
        .chain([Mode::Idle, Mode::Running(Drive::Torque)]);
    let samples = enum_names::MISSING
        .into_iter()
        .map(Sample::Missing)
        .chain([Sample::Counts(1023)]);
    for (i, (mode, sample)) in modes.cycle().zip(samples).enumerate() {
        let mut record = last;
        record.tick = u32::MAX;
        // A year of board time, to the microsecond.
        record.input.start_us = 31_557_600_000_000 + i as u64;
        record.mode = mode;
        record.input.samples = [sample, Sample::Counts(0)];
        record.output.angle_rad = [f32::MIN_POSITIVE, f32::MAX];
        record.output.speed_rad_s = [-0.1, 1e-9];
        record.timing.missed = 7;
        record.dropped = u32::MAX;
        records.push(record);
    }
    records
}

#[test]
fn csv_gives_back_every_field() {
    let path = folder("csv").join("run.csv");
    let records = every_kind_of_record();
    let mut writer = CsvWriter::create(&path, true).unwrap();
    // Every third state is not known.
    let truth = |i: usize| TrueState {
        push_nm: [0.1, i as f32 * 1e-9],
        ..TrueState::default()
    };
    let truth = |i: usize| (!i.is_multiple_of(3)).then(|| truth(i));
    for (i, record) in records.iter().enumerate() {
        let row = recording::Row {
            record: *record,
            truth: truth(i),
        };
        writer.row(&row).unwrap();
    }
    writer.finish().unwrap();

    let mut reader = ::csv::Reader::from_path(&path).unwrap();
    let header: Vec<_> = reader
        .headers()
        .unwrap()
        .iter()
        .map(str::to_owned)
        .collect();
    assert_eq!(
        header[..9],
        [
            "time_s",
            "tick",
            "board_mode",
            "fault",
            "guards",
            "reference_rad_1",
            "reference_rad_2",
            "reference_speed_rad_s_1",
            "reference_speed_rad_s_2"
        ]
    );
    let rows: Vec<Row> = reader.deserialize().map(Result::unwrap).collect();
    let read: Vec<Record> = rows.iter().map(|row| row.record().unwrap()).collect();
    assert_eq!(read, records);
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row.true_push_nm_2, truth(i).map(|truth| truth.push_nm[1]));
    }

    let text = std::fs::read_to_string(&path).unwrap();
    let row = text
        .lines()
        .find(|line| line.contains("bad_checksum"))
        .unwrap();
    let fields: Vec<&str> = row.split(',').collect();
    let field = |name: &str| fields[header.iter().position(|column| column == name).unwrap()];
    assert_eq!(
        (field("encoder_counts_1"), field("missing_1")),
        ("", "bad_checksum"),
        "{row}"
    );
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let path = folder("no_such").join("gone").join("run.csv");
    let text = CsvWriter::create(&path, false).unwrap_err().to_string();
    assert!(
        text.contains("cannot write") && text.contains("gone"),
        "{text}"
    );
}
