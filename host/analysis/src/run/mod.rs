//! A run from its plan to its folder, on any link: a plan runner performs the plan, the
//! recorder writes the log, and at the end come plots and a summary.
//!
//! Memory does not grow with the length of the run.

mod run_stats;

use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use armbridge_client::Host;
use armbridge_client::ctrl_c;
use armbridge_client::enum_names;
use armbridge_client::{LinkError, Tap};
use armbridge_log::LogError;
use armbridge_log::recorder::Recorder;
use armbridge_log::run_info::RunFacts;
use armbridge_log::summary::{LogSummary, ServoSummary, Summary};
use armbridge_shared::link::message::PortCounters;
use armbridge_sim::cosim::Interaction;

use crate::plan_runner::{Ending, Plan, PlanError, PlanRunner};
use crate::plot;
use crate::plot::PlotError;
use crate::progress::Progress;
use crate::run_folder::{RunFolder, RunFolderError};
use crate::scenario::{ExpectationMonitor, Success};
use run_stats::{DecimatedRecords, RunStats};

/// Time in µs between updates of the progress bar.
const PROGRESS_PERIOD_US: u64 = 50_000;

/// Specification of a run and its files.
#[derive(Debug)]
pub struct RunSpec {
    /// Plan.
    pub plan: Plan,
    /// Facts known before the first tick.
    pub facts: RunFacts,
    /// Ends that count as success.
    pub success: Vec<Success>,
    /// Monitor of the expectations.
    pub judge: Option<ExpectationMonitor>,
    /// Files beside the log.
    pub files: Files,
    /// The run waits for the disk, which only virtual time permits.
    pub is_patient: bool,
    /// No progress bar.
    pub is_quiet: bool,
}

/// Files beside the log.
#[derive(Clone, Copy, Debug)]
pub struct Files {
    /// `run.csv`, written where the link is served: for virtual time.
    pub csv: bool,
    /// The plots.
    pub plots: bool,
}

/// Verdict on a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Success.
    Done,
    /// Failure; the summary has the reason.
    Failed,
    /// Ctrl-C ended it.
    Interrupted,
}

impl Verdict {
    /// The program's exit code.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Failed => 1,
            // The shell's convention: 128 plus the signal's number.
            Self::Interrupted => 130,
        }
    }
}

/// A finished run.
#[derive(Debug)]
pub struct Finished {
    /// Summary.
    pub summary: Summary,
    /// Folder of its files.
    pub folder: PathBuf,
    /// Verdict.
    pub verdict: Verdict,
}

/// Failure of a run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The folder could not be created.
    #[error(transparent)]
    Folder(#[from] RunFolderError),
    /// The log could not be written.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The plots could not be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// The link or the plan failed before the arm was armed.
    #[error(transparent)]
    Link(LinkError<PlanError>),
    /// Ctrl-C before the arm was armed.
    #[error("ended by ctrl-c before the arm was armed; nothing moved")]
    Interrupted,
}

/// A run in progress.
pub struct RunHost {
    runner: PlanRunner<RunStats>,
    recorder: Recorder,
    progress: Progress,
    folder: RunFolder,
    facts: RunFacts,
    success: Vec<Success>,
    duration_s: f64,
    has_plots: bool,
    look_us: u64,
    begun: Instant,
}

impl RunHost {
    /// Creates the run folder, in `base` or the default folder, and the log.
    ///
    /// # Errors
    /// If either cannot be created.
    pub fn new(spec: RunSpec, base: Option<&Path>) -> Result<Self, RunError> {
        let folder = RunFolder::create(base, &spec.facts.name)?;
        Self::in_folder(spec, folder)
    }

    /// Creates the log in an existing folder.
    ///
    /// # Errors
    /// If it cannot be created.
    pub fn in_folder(spec: RunSpec, folder: RunFolder) -> Result<Self, RunError> {
        let RunSpec {
            plan,
            facts,
            success,
            judge,
            files,
            is_patient,
            is_quiet,
        } = spec;
        let csv = files.csv.then(|| folder.file("run.csv"));
        let duration_s = plan.stop.after_us as f64 * 1e-6;
        let stats = RunStats::new(judge, csv.as_deref())?;
        let begin_log = if is_patient {
            Recorder::create_waiting
        } else {
            Recorder::create
        };
        Ok(Self {
            runner: PlanRunner::with_sink(plan, stats).interrupted_by(ctrl_c::is_raised),
            recorder: begin_log(&folder.file("run.mcap"), &facts)?,
            progress: Progress::new(duration_s, is_quiet),
            folder,
            facts,
            success,
            duration_s,
            has_plots: files.plots,
            look_us: 0,
            begun: Instant::now(),
        })
    }

    /// Tap that logs the link.
    pub fn tap(&self) -> Box<dyn Tap> {
        self.recorder.tap()
    }

    /// Channel of the plan's pushes, see [`PlanRunner::interactions`].
    pub fn interactions(&mut self) -> Receiver<Interaction> {
        self.runner.interactions()
    }

    /// Text beside the progress bar.
    fn progress_text(&self, now_us: u64, now_s: f64) -> String {
        let left_s = (self.duration_s - now_s).max(0.0);
        match self.runner.current_step(now_us) {
            Some((number, count, action)) => format!(
                "{left_s:.1} s left · step {number} of {count}: {}",
                action.in_words()
            ),
            None => format!(
                "{now_s:.1} of {:.1} s · {}",
                self.duration_s,
                enum_names::mode(self.runner.mode())
            ),
        }
    }

    /// Closes the log, draws the plots and computes the summary of a run that ended with
    /// `result`.
    ///
    /// # Errors
    /// If the run did not begin, or its plots cannot be written.
    pub fn finish(self, result: Result<(), LinkError<PlanError>>) -> Result<Finished, RunError> {
        let wall: Duration = self.begun.elapsed();
        let Self {
            runner,
            recorder,
            progress,
            folder,
            mut facts,
            success,
            duration_s,
            has_plots,
            ..
        } = self;
        progress.finish();
        let failure = match result {
            _ if runner.begun_us().is_none() => {
                drop(recorder);
                // Best effort: the folder holds no data.
                let _ = std::fs::remove_dir_all(folder.path());
                return Err(result.err().map_or(RunError::Interrupted, RunError::Link));
            }
            Ok(()) => None,
            Err(error) => Some(error.to_string()),
        };
        let log = close(recorder);
        if let Some(settings) = runner.begun_with() {
            facts = facts.with_settings(settings);
        }

        let ending = runner.ending();
        let is_success =
            failure.is_none() && ending.is_some_and(|end| success.iter().any(|s| s.matches(end)));
        let ended = failure.or_else(|| match ending {
            // Faults are described in more detail elsewhere.
            Some(Ending::Time | Ending::Fault(_)) | None => None,
            Some(end @ (Ending::Angle { .. } | Ending::Error { .. } | Ending::Interrupted)) => {
                Some(end.in_words())
            }
        });
        let (servos, port) = (runner.status().servos, runner.status().port);
        let (link, trips) = (runner.stats(), runner.trips().to_vec());
        let mut stats = runner.into_sink();
        let csv_trouble = stats.close().map(|error| error.to_string());

        let tally = &stats.tally;
        let run_s = match ending {
            Some(Ending::Time) => duration_s,
            _ => tally.covered_s(),
        };
        let mut summary = tally.summary(&facts, link, run_s, wall.as_secs_f64());
        summary.servos = servos.map(|servos| ServoSummary {
            firmware: servos.firmware.to_string(),
            baud: servos.baud,
        });
        summary.port = (port != PortCounters::default()).then_some(port);
        let is_complete = log.is_complete() && csv_trouble.is_none();
        summary.log = Some(log);
        summary.ended = ended;
        if let Some(judge) = stats.judge.take()
            && is_success
        {
            summary.missed_expectations = judge.misses(tally, &summary);
        }
        let mut summary = summary.with_causes(&trips);
        summary.remarks.append(&mut stats.conclusions);
        summary.remarks.extend(csv_trouble);
        if has_plots {
            let DecimatedRecords { records, every, .. } = &stats.plotted;
            if *every > 1 {
                let remark = format!("the plots show one tick in {every}");
                summary.remarks.push(remark);
            }
            plot::draw_all(folder.path(), &facts, records)?;
        }

        let verdict = if ending == Some(Ending::Interrupted) {
            Verdict::Interrupted
        } else if is_success && is_complete && summary.missed_expectations.is_empty() {
            Verdict::Done
        } else {
            Verdict::Failed
        };
        Ok(Finished {
            summary,
            folder: folder.path().into(),
            verdict,
        })
    }
}

/// Closes the log; returns its summary, with its error if there is one.
fn close(recorder: Recorder) -> LogSummary {
    let so_far = recorder.report();
    let (report, error) = match recorder.finish() {
        Ok(report) => (report, None),
        Err(error) => (so_far, Some(error.to_string())),
    };
    LogSummary {
        written: report.records,
        lost: report.lost,
        unwritten: report.unwritten,
        size: report.size,
        trouble: error.or(report.trouble),
    }
}

impl Host for RunHost {
    type Error = PlanError;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], PlanError> {
        if now_us >= self.look_us {
            self.look_us = now_us + PROGRESS_PERIOD_US;
            let now_s = self.runner.fraction(now_us) * self.duration_s;
            self.progress.set_position(now_s);
            self.progress.set_message(self.progress_text(now_us, now_s));
        }
        self.runner.transmit(now_us)
    }

    fn receive(&mut self, now_us: u64, bytes: &[u8]) -> Result<(), PlanError> {
        self.runner.receive(now_us, bytes)
    }

    fn wake_at_us(&self) -> u64 {
        self.runner.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.runner.is_done()
    }

    fn emergency_stop(&mut self, now_us: u64) -> bool {
        self.runner.emergency_stop(now_us)
    }

    fn disconnected(&mut self, now_us: u64) {
        self.progress.set_message("the link broke; waiting for it");
        self.runner.disconnected(now_us);
    }
}
