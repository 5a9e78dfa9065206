//! Time from a command to its acknowledgement, on the simulated board at the pace of the wall
//! clock: the median of a thousand.
//!
//! `cargo run --release -p armbridge-sim --example command_latency`

use std::time::{Duration, Instant};

use armbridge_link::message::Command;
use armbridge_sim::Bench;
use armbridge_sim::link::{BoardClient, BoardUri, Options, Pace};
use armbridge_sim::plant::{Plant, PlantConfig};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let options = || Options {
        pace: Pace::WallClock,
        ..Options::new(Bench::new(Plant::new(PlantConfig::default(), 1)))
    };
    let client = BoardClient::open(BoardUri::Sim, options, || false)?;
    client.arm()?;
    let mut times = Vec::new();
    for _ in 0..1_000 {
        let begun = Instant::now();
        client.command(Command::Regulate([0.0; 2]))?;
        times.push(begun.elapsed());
        std::thread::sleep(Duration::from_millis(2));
    }
    times.sort();
    println!(
        "{} us in the median, {} us for nine of ten",
        times[500].as_micros(),
        times[900].as_micros()
    );
    client.close()?;
    Ok(())
}
