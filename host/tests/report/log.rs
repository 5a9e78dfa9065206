//! Whatever a record holds, both log files give it back.

use crate::{folder, synthetic};
use armbridge::log::message::{CommandMessage, TickMessage};
use armbridge::log::{CsvWriter, McapWriter, csv::Row, mcap, names};
use armbridge_shared::link::message::{Command, Drive, Mode, Record, Sample};

/// The synthetic run, then one record for each fault and kind of missing
/// sample, with numbers at the ends of their ranges.
fn every_kind_of_record() -> Vec<Record> {
    let mut records = synthetic::run(0.06);
    let last = *records.last().unwrap();
    let modes = names::FAULTS
        .into_iter()
        .map(Mode::Fault)
        .chain([Mode::Idle, Mode::Running(Drive::Torque)]);
    let samples = names::MISSING
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
fn mcap_gives_back_every_field() {
    let path = folder("mcap").join("run.mcap");
    let records = every_kind_of_record();
    let mut writer = McapWriter::create(&path, &synthetic::facts(None)).unwrap();
    let command = Command::Regulate([0.1, -0.2]);
    writer.command(12_345, &command).unwrap();
    for record in &records {
        writer.record(record).unwrap();
    }
    writer.finish().unwrap();

    let bytes = std::fs::read(&path).unwrap();
    let mut read = Vec::new();
    let mut commands = Vec::new();
    for message in ::mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        assert_eq!(message.channel.message_encoding, "json");
        assert_eq!(
            message.channel.schema.as_ref().unwrap().encoding,
            "jsonschema"
        );
        if message.channel.topic == mcap::COMMAND_TOPIC {
            let command: CommandMessage = serde_json::from_slice(&message.data).unwrap();
            commands.push((message.log_time, command));
            continue;
        }
        assert_eq!(message.channel.topic, mcap::RECORD_TOPIC);
        assert_eq!(message.sequence as usize, read.len());
        let tick: TickMessage = serde_json::from_slice(&message.data).unwrap();
        let record = tick.record().unwrap();
        assert_eq!(message.log_time, record.start_us * 1000);
        read.push(record);
    }
    assert_eq!(read, records);
    assert_eq!(commands, [(12_345_000, CommandMessage::from(&command))]);

    let summary = ::mcap::Summary::read(&bytes).unwrap().unwrap();
    let metadata = ::mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).unwrap();
    assert_eq!(metadata.name, mcap::FACTS_METADATA);
    assert_eq!(metadata.metadata["seed"], "1");
    assert_eq!(metadata.metadata["period_us"], "1000");
    assert_eq!(metadata.metadata["world"], "simulated: bench");
}

#[test]
fn a_number_that_is_not_one_comes_back_as_nan() {
    let mut record = synthetic::run(0.0)[100];
    record.torque_nm = [f32::NAN, 0.25];
    let json = serde_json::to_string(&TickMessage::from(&record)).unwrap();
    let back: TickMessage = serde_json::from_str(&json).unwrap();
    let torque_nm = back.record().unwrap().torque_nm;
    assert!(torque_nm[0].is_nan());
    assert_eq!(torque_nm[1].to_bits(), 0.25f32.to_bits());
}

#[test]
fn schema_and_message_name_the_same_fields() {
    let schema: serde_json::Value =
        serde_json::from_str(armbridge::log::message::TICK_SCHEMA).unwrap();
    let mut record = synthetic::run(0.0)[0];
    record.mode = Mode::Fault(names::FAULTS[0]);
    let message = serde_json::to_value(TickMessage::from(&record)).unwrap();
    let names = |value: &serde_json::Value| {
        value
            .as_object()
            .unwrap()
            .keys()
            .cloned()
            .collect::<std::collections::BTreeSet<_>>()
    };
    assert_eq!(names(&schema["properties"]), names(&message));
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
