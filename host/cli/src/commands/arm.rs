//! `armbridge arm`: ready to move, and held so.

use std::io::Write;
use std::process::ExitCode;

use armbridge::tasks::arm::{Arm, Outcome as Ending};
use armbridge_sim::link::Pace;
use serde_json::json;

use super::{Outcome, errand};
use crate::cli::ArmedArgs;

pub(crate) fn run(args: &ArmedArgs) -> Outcome {
    let mut task = Arm::new(args.lasts, args.prepare);
    if !args.quiet && !args.errand.json {
        task = task.reporting(|line| eprintln!("{line}"));
    }
    let (uri, host) = errand::go(&args.errand, "arm", Pace::WallClock, task)?;
    let ending = host.task.outcome().unwrap_or(&Ending::Disarmed);
    let mut out = std::io::stdout();
    if args.errand.json {
        let report = json!({
            "link": uri.to_string(),
            "ended_by": ending.name(),
            "held_s": host.task.held().as_secs_f64(),
            "in_words": ending.in_words(),
        });
        writeln!(out, "{report}")?;
    } else {
        let held_s = host.task.held().as_secs_f64();
        writeln!(out, "armed for {held_s:.1} s; {}", ending.in_words())?;
    }
    Ok(ExitCode::from(match ending {
        Ending::Disarmed => 0,
        Ending::Tripped(_) | Ending::Reset(_) | Ending::Parted => 1,
    }))
}
