//! Whether the emulated board keeps up with the wall clock: so many seconds of a 1 kHz
//! loop, the link and a script included, held back to it, and then as fast as it goes.
//!
//! `cargo build-emulator && cargo run --release -p armbridge --example emulator_pace 600`

use std::process::ExitCode;
use std::time::Instant;

use armbridge::bench::Bench;
use armbridge::bench::cosim::Host;
use armbridge::bench::plant::{Plant, PlantConfig};
use armbridge::held::Lag;
use armbridge::links::{LinkUri, Options, Pace, drive};
use armbridge::operator::{Operator, OperatorError, Script};
use armbridge_shared::link::message::Setup;

/// An operator who remembers how well time kept up.
struct Timed {
    operator: Operator,
    lag: Lag,
}

impl Host for Timed {
    type Error = OperatorError;

    fn speak(&mut self, now_us: u64) -> Result<&[u8], OperatorError> {
        self.operator.speak(now_us)
    }

    fn hear(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), OperatorError> {
        self.operator.hear(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        self.operator.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.operator.is_done()
    }

    fn kept_up(&mut self, lag: Lag) {
        self.lag = lag;
    }
}

/// Runs it, and says how it went; `None` if it failed.
fn run(duration_s: f64, pace: Pace) -> Option<()> {
    let script = Script::demo(Setup::default(), (duration_s * 1e6) as u64);
    let host = Timed {
        operator: Operator::new(script),
        lag: Lag::default(),
    };
    let options = Options {
        pace,
        ..Options::new(Bench::new(Plant::new(PlantConfig::default(), 1)))
    };
    let begun = Instant::now();
    let (host, result) = drive(&LinkUri::Emulate(None), options, host);
    let wall_s = begun.elapsed().as_secs_f64();
    if let Err(error) = result {
        eprintln!("{error}");
        return None;
    }
    let (records, _, link) = host.operator.into_parts();
    let missed: u32 = records.iter().map(|record| record.timing.missed).sum();
    println!(
        "{pace:?}: {duration_s} s in {wall_s:.1} s = {:.2} times real time; {} records, {} lost, \
         {missed} ticks missed",
        duration_s / wall_s,
        records.len(),
        link.lost,
    );
    if pace == Pace::WallClock {
        let Lag { most, lost } = host.lag;
        println!("behind the wall clock {most:.1?} at the most; {lost:.1?} never made up for");
    }
    Some(())
}

fn main() -> ExitCode {
    let duration_s = std::env::args().nth(1).map_or(Ok(10.0), |s| s.parse());
    let Ok(duration_s) = duration_s else {
        eprintln!("expected a number of seconds");
        return ExitCode::from(2);
    };
    let runs = [Pace::WallClock, Pace::Free].map(|pace| run(duration_s, pace));
    if runs.iter().all(Option::is_some) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
