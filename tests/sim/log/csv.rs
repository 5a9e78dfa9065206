//! Any record is read back from the table.

use armbridge_client::enum_names;
use armbridge_log::CsvWriter;
use armbridge_log::csv::Row;
use armbridge_shared::link::message::{Drive, Mode, Record, Sample};
use armbridge_tests::synthetic;

use super::folder;

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
