//! Time that the log of a run takes, written and read, and all its figures.
//!
//! `cargo run --release -p armbridge-analysis --example report_speed`
//!
//! The recorder is fed with frames of a link as fast as it takes them. Its thread's
//! work is what counts: decoding, making messages, writing.

use std::error::Error;
use std::time::Instant;

use armbridge_analysis::plot;
use armbridge_client::event::Direction;
use armbridge_link::frame::Encoder;
use armbridge_link::message::{Record, Settings, ToHost};
use armbridge_log::output_file::Existing;
use armbridge_log::recorder::Recorder;
use armbridge_log::recording::Reader;
use armbridge_log::run_info::RunFacts;

#[path = "../../../tests/src/synthetic.rs"]
#[expect(unreachable_pub, reason = "public to the tests")]
mod synthetic;

/// Ten minutes at 1 kHz.
const TICKS: usize = 600_000;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::temp_dir().join(format!("armbridge-{}.mcap", std::process::id()));
    let records = synthetic::run(0.06);
    let facts = RunFacts::from_settings("report_speed", "simulated: nothing", &Settings::default());
    let mut board = Encoder::default();
    let mut link = vec![
        board
            .encode(&ToHost::Settings(Settings::default()))
            .1
            .to_vec(),
    ];
    for (tick, record) in records.iter().cycle().take(TICKS).enumerate() {
        let mut record = *record;
        record.tick = tick as u32;
        record.input.start_us = tick as u64 * 1_000;
        link.push(board.encode(&ToHost::Record(record)).1.to_vec());
    }

    let start = Instant::now();
    let recorder = Recorder::create_waiting(&path, &facts)?;
    let mut tap = recorder.tap();
    for (tick, frame) in link.iter().enumerate() {
        tap.bytes(Direction::ToHost, tick as u64 * 1_000_000, frame);
    }
    drop(tap);
    let report = recorder.finish()?;
    let wrote_s = start.elapsed().as_secs_f64();
    assert_eq!((report.records, report.lost), (TICKS as u64, 0));
    say("written", wrote_s);
    let per_tick = report.size as f64 / TICKS as f64;
    println!(
        "size     {per_tick:.0} bytes per tick, {:.2} GB per hour at 1 kHz",
        per_tick * 3.6e6 / 1e9
    );

    let start = Instant::now();
    let mut reader = Reader::open(&path)?;
    let ticks = reader.by_ref().filter_map(|event| event.record()).count();
    let read_s = start.elapsed().as_secs_f64();
    assert!(ticks == TICKS && reader.damage().is_empty());
    say("read", read_s);
    std::fs::remove_file(&path)?;
    figures(&records)
}

fn figures(records: &[Record]) -> Result<(), Box<dyn Error>> {
    let folder = std::env::temp_dir().join(format!("armbridge-report-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let start = Instant::now();
    let files = plot::draw_all(
        &folder,
        Existing::Number,
        &synthetic::facts(Some(0.06)),
        records,
    )?;
    let took_ms = start.elapsed().as_secs_f64() * 1e3;
    println!(
        "plots    {took_ms:.0} ms for {} files of {} records",
        files.len(),
        records.len()
    );
    std::fs::remove_dir_all(&folder)?;
    Ok(())
}

fn say(what: &str, seconds: f64) {
    println!(
        "{what:8} {:.2} us per tick, {:.0} times real time at 1 kHz",
        seconds * 1e6 / TICKS as f64,
        TICKS as f64 * 1e-3 / seconds
    );
}
