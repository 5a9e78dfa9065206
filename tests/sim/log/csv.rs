//! Any record is read back from the table.

use armbridge_client::enum_names;
use armbridge_log::CsvWriter;
use armbridge_shared::link::message::{Drive, Guards, Missing, Mode, Record, Sample, Timing};
use armbridge_tests::synthetic;
use serde::Deserialize;

use super::folder;

/// A row as a script reads it: columns by name.
#[derive(Deserialize)]
struct Row {
    time_s: f64,
    tick: u32,
    mode: String,
    fault: String,
    guards: String,
    q1_ref_rad: f32,
    dq1_ref_rad_s: f32,
    q1_rad: f32,
    dq1_rad_s: f32,
    count1: Option<u16>,
    missing1: String,
    alarms1: String,
    torque1_nm: f32,
    disturbance1_nm: f32,
    pwm1_in_force: u16,
    pwm1_next: u16,
    q2_ref_rad: f32,
    dq2_ref_rad_s: f32,
    q2_rad: f32,
    dq2_rad_s: f32,
    count2: Option<u16>,
    missing2: String,
    alarms2: String,
    torque2_nm: f32,
    disturbance2_nm: f32,
    pwm2_in_force: u16,
    pwm2_next: u16,
    start_error_us: u32,
    bus_us: u32,
    compute_ns: u32,
    missed_ticks: u32,
    dropped_records: u32,
}

fn mode(name: &str, fault: &str) -> Option<Mode> {
    let mut modes = enum_names::MODES.into_iter();
    let mut faults = enum_names::FAULTS.into_iter();
    match name {
        "fault" => faults
            .find(|known| enum_names::fault(*known) == fault)
            .map(Mode::Fault),
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
            start_us: (self.time_s * 1e6).round() as u64,
            mode: mode(&self.mode, &self.fault)?,
            guards: guards(&self.guards)?,
            samples: [
                sample(self.count1, &self.missing1)?,
                sample(self.count2, &self.missing2)?,
            ],
            alarms: [alarms(&self.alarms1)?, alarms(&self.alarms2)?],
            pwm_in_force: [self.pwm1_in_force, self.pwm2_in_force],
            pwm_next: [self.pwm1_next, self.pwm2_next],
            reference_rad: [self.q1_ref_rad, self.q2_ref_rad],
            reference_speed_rad_s: [self.dq1_ref_rad_s, self.dq2_ref_rad_s],
            angle_rad: [self.q1_rad, self.q2_rad],
            speed_rad_s: [self.dq1_rad_s, self.dq2_rad_s],
            torque_nm: [self.torque1_nm, self.torque2_nm],
            disturbance_nm: [self.disturbance1_nm, self.disturbance2_nm],
            timing: Timing {
                start_error_us: self.start_error_us,
                bus_us: self.bus_us,
                compute_ns: self.compute_ns,
                missed: self.missed_ticks,
            },
            dropped: self.dropped_records,
        })
    }
}

/// The synthetic run, then one record for each fault and kind of missing
/// sample, with numbers at the ends of their ranges.
fn every_kind_of_record() -> Vec<Record> {
    let mut records = synthetic::run(0.06);
    let last = *records.last().unwrap();
    let modes = enum_names::FAULTS
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
        record.start_us = 31_557_600_000_000 + i as u64;
        record.mode = mode;
        record.samples = [sample, Sample::Counts(0)];
        record.angle_rad = [f32::MIN_POSITIVE, f32::MAX];
        record.speed_rad_s = [-0.1, 1e-9];
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
    let mut writer = CsvWriter::create(&path).unwrap();
    for record in &records {
        writer.record(record).unwrap();
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
            "mode",
            "fault",
            "guards",
            "q1_ref_rad",
            "dq1_ref_rad_s",
            "q1_rad",
            "dq1_rad_s"
        ]
    );
    let read: Vec<Record> = reader
        .deserialize::<Row>()
        .map(|row| row.unwrap().record().unwrap())
        .collect();
    assert_eq!(read, records);

    let text = std::fs::read_to_string(&path).unwrap();
    let row = text
        .lines()
        .find(|line| line.contains("bad_checksum"))
        .unwrap();
    assert!(row.contains(",,bad_checksum,"), "{row}");
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let path = folder("no_such").join("gone").join("run.csv");
    let text = CsvWriter::create(&path).unwrap_err().to_string();
    assert!(
        text.contains("cannot write") && text.contains("gone"),
        "{text}"
    );
}
