//! How long the report of a run takes: both log files and all figures.
//!
//! `cargo run --release -p armbridge --example report_speed`

#[path = "../tests/report/synthetic.rs"]
mod synthetic;

use armbridge::log::{CsvWriter, McapWriter};
use armbridge::plot;
use std::error::Error;
use std::time::Instant;

/// Runs of 10 s that are logged; one would be over before the clock is warm.
const REPEATS: usize = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::temp_dir().join(format!("armbridge-report-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let records = synthetic::run(0.06);
    let facts = synthetic::facts(Some(0.06));
    let per_record =
        |start: Instant| start.elapsed().as_secs_f64() * 1e6 / (REPEATS * records.len()) as f64;

    let path = folder.join("run.mcap");
    let start = Instant::now();
    let mut mcap = McapWriter::create(&path, &facts)?;
    for record in records.iter().cycle().take(REPEATS * records.len()) {
        mcap.record(record)?;
    }
    mcap.finish()?;
    let bytes = path.metadata()?.len() as usize / (REPEATS * records.len());
    println!(
        "mcap   {:.2} us and {bytes} bytes per record",
        per_record(start)
    );

    let path = folder.join("run.csv");
    let start = Instant::now();
    let mut csv = CsvWriter::create(&path)?;
    for record in records.iter().cycle().take(REPEATS * records.len()) {
        csv.record(record)?;
    }
    csv.finish()?;
    let bytes = path.metadata()?.len() as usize / (REPEATS * records.len());
    println!(
        "csv    {:.2} us and {bytes} bytes per record",
        per_record(start)
    );

    let start = Instant::now();
    let files = plot::draw_all(&folder, &facts, &records)?;
    let took_ms = start.elapsed().as_secs_f64() * 1e3;
    println!(
        "plots  {took_ms:.0} ms for {} files of {} records",
        files.len(),
        records.len()
    );
    std::fs::remove_dir_all(&folder)?;
    Ok(())
}
