//! Runs steps: two lanes side by side, or some one after the other.

use std::process::ExitCode;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::output::Output;
use crate::paths;
use crate::steps::{Lane, Step, named};

/// Lines shown of a step that failed.
const SHOWN: usize = 80;

/// Steps that have ended.
#[derive(Default)]
struct Progress {
    /// Steps that passed, with the time they took.
    passed: Vec<(&'static str, Duration)>,
    /// Steps that failed, with the time they took.
    failed: Vec<(&'static str, Duration)>,
}

/// Steps in two lanes.
struct Lanes<'a> {
    steps: &'a [Step],
    progress: Mutex<Progress>,
    changed: Condvar,
}

/// Runs these steps in their lanes, and prints how long each took.
pub(crate) fn run(steps: &[Step]) -> ExitCode {
    let begin = Instant::now();
    let logs = paths::target().join("verify");
    println!(
        "{} steps in two lanes; logs in {}",
        steps.len(),
        logs.display()
    );
    if let Err(error) = std::fs::create_dir_all(&logs) {
        eprintln!("cannot make {}: {error}", logs.display());
        return ExitCode::FAILURE;
    }
    let lanes = Lanes {
        steps,
        progress: Mutex::default(),
        changed: Condvar::new(),
    };
    std::thread::scope(|scope| {
        scope.spawn(|| lanes.work(Lane::Board));
        lanes.work(Lane::Host);
    });
    let progress = lanes.progress();
    println!();
    for step in steps {
        let is_it = |(name, _): &&(&str, Duration)| *name == step.name;
        let passed = progress.passed.iter().find(is_it);
        let failed = progress.failed.iter().find(is_it);
        match (passed, failed) {
            (Some((name, time)), _) => println!("{name:<16}{:>8.1} s", time.as_secs_f64()),
            (_, Some((name, time))) => {
                println!("{name:<16}{:>8.1} s  FAILED", time.as_secs_f64());
            }
            _ => println!("{:<16}{:>10}", step.name, "not run"),
        }
    }
    println!("{:<16}{:>8.1} s", "all", begin.elapsed().as_secs_f64());
    let (passed, failed) = (progress.passed.len(), progress.failed.len());
    println!("steps: {passed} passed, {failed} failed");
    ExitCode::from(u8::from(passed < steps.len()))
}

impl Lanes<'_> {
    fn progress(&self) -> MutexGuard<'_, Progress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Works through one lane, until a step fails in either.
    fn work(&self, lane: Lane) {
        for step in self.steps.iter().filter(|step| step.lane == lane) {
            let is_early = |progress: &mut Progress| {
                let has_passed = |it: &&str| progress.passed.iter().any(|(name, _)| name == it);
                progress.failed.is_empty() && !step.needs.iter().all(has_passed)
            };
            let progress = self.changed.wait_while(self.progress(), is_early);
            let progress = progress.unwrap_or_else(PoisonError::into_inner);
            if !progress.failed.is_empty() {
                return;
            }
            println!("      {:<16}{}", step.name, step.what);
            drop(progress);

            let begin = Instant::now();
            let done = perform(step);
            let time = begin.elapsed();
            let mut progress = self.progress();
            match done {
                Ok(()) => {
                    println!("ok    {:<16}{:>8.1} s", step.name, time.as_secs_f64());
                    progress.passed.push((step.name, time));
                }
                Err(why) => {
                    println!("{why}\nverify: step `{}` failed", step.name);
                    println!("repeat it with:    cargo verify --only {}", step.name);
                    progress.failed.push((step.name, time));
                }
            }
            self.changed.notify_all();
        }
    }
}

/// Performs a step, its output in a log file. The error has the end of the log.
fn perform(step: &Step) -> Result<(), String> {
    let log = paths::target().join(format!("verify/{}.log", step.name));
    let out = Output::file(&log).map_err(|e| format!("cannot write {}: {e}", log.display()))?;
    step.work.perform(&out).map_err(|why| {
        let text = std::fs::read(&log).unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        let lines: Vec<&str> = text.lines().collect();
        let end = &lines[lines.len().saturating_sub(SHOWN)..];
        format!(
            "\n{}\n\n{why}; the whole log is {}",
            end.join("\n"),
            log.display()
        )
    })
}

/// Runs the steps with these names, their output in the terminal.
pub(crate) fn run_only(names: &[String]) -> ExitCode {
    for step in names.iter().filter_map(|name| named(name)) {
        println!("{}: {}", step.name, step.what);
        let begin = Instant::now();
        if let Err(why) = step.work.perform(&Output::Terminal) {
            println!("verify: step `{}` failed: {why}", step.name);
            return ExitCode::FAILURE;
        }
        println!(
            "ok    {:<16}{:>8.1} s",
            step.name,
            begin.elapsed().as_secs_f64()
        );
    }
    ExitCode::SUCCESS
}
