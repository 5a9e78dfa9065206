//! A run from its plan to its folder, on any link: a plan runner works through the
//! plan, the recorder writes the log, and in the end there are plots and a summary.
//!
//! Nothing of it grows with the length of the run.

mod run_stats;

use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use armbridge_client::Host;
use armbridge_client::enum_names;
use armbridge_client::interrupt;
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
use crate::scenario::{Judge, Success};
use run_stats::{RunStats, Thinned};

/// Time of the run between two looks at the progress bar.
const LOOK_US: u64 = 50_000;

/// What is to be done, and what is to be left of it.
#[derive(Debug)]
pub struct RunSpec {
    /// What.
    pub plan: Plan,
    /// What is known before the first tick.
    pub facts: RunFacts,
    /// Ends that are as they should be.
    pub success: Vec<Success>,
    /// What is expected of the arm.
    pub judge: Option<Judge>,
    /// Files beside the log.
    pub files: Files,
    /// Time waits for the disk, as virtual time can.
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

/// How a run went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// As it should.
    Done,
    /// Otherwise: the summary has the reason.
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
            // As a shell has it: 128 and the signal's number.
            Self::Interrupted => 130,
        }
    }
}

/// A run that is over.
#[derive(Debug)]
pub struct Finished {
    /// In a few numbers.
    pub summary: Summary,
    /// Where its files are.
    pub folder: PathBuf,
    /// How it went.
    pub verdict: Verdict,
}

/// Why there is no run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// No folder to write into.
    #[error(transparent)]
    Folder(#[from] RunFolderError),
    /// No log.
    #[error(transparent)]
    Log(#[from] LogError),
    /// No plots.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// The link or the plan failed before the arm was armed.
    #[error(transparent)]
    Link(LinkError<PlanError>),
    /// Ctrl-C before the arm was armed.
    #[error("ended by ctrl-c before the arm was armed; nothing has moved")]
    Interrupted,
}

/// A run under way.
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
    /// Makes the folder, in `base` or where run folders are, and begins the log.
    ///
    /// # Errors
    /// If either cannot be.
    pub fn new(task: RunSpec, base: Option<&Path>) -> Result<Self, RunError> {
        let folder = RunFolder::create(base, &task.facts.name)?;
        Self::in_folder(task, folder)
    }

    /// Begins the log in a folder that is there.
    ///
    /// # Errors
    /// If there can be none.
    pub fn in_folder(task: RunSpec, folder: RunFolder) -> Result<Self, RunError> {
        let RunSpec {
            plan,
            facts,
            success,
            judge,
            files,
            is_patient,
            is_quiet,
        } = task;
        let csv = files.csv.then(|| folder.file("run.csv"));
        let duration_s = plan.stop.after_us as f64 * 1e-6;
        let stats = RunStats::new(judge, csv.as_deref())?;
        let begin_log = if is_patient {
            Recorder::create_waiting
        } else {
            Recorder::create
        };
        Ok(Self {
            runner: PlanRunner::keeping(plan, stats).interrupted_by(interrupt::is_raised),
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

    /// The tap by which the link is logged.
    pub fn tap(&self) -> Box<dyn Tap> {
        self.recorder.tap()
    }

    /// The plan's pushes as they fall due, see [`PlanRunner::interactions`].
    pub fn interactions(&mut self) -> Receiver<Interaction> {
        self.runner.interactions()
    }

    /// Text beside the progress bar.
    fn doing(&self, now_us: u64, now_s: f64) -> String {
        let left_s = (self.duration_s - now_s).max(0.0);
        match self.runner.doing(now_us) {
            Some((number, of, act)) => format!(
                "{left_s:.1} s left · step {number} of {of}: {}",
                act.in_words()
            ),
            None => format!(
                "{now_s:.1} of {:.1} s · {}",
                self.duration_s,
                enum_names::mode(self.runner.mode())
            ),
        }
    }

    /// Closes the log, draws the plots, sums up: after the run came to this end.
    ///
    /// # Errors
    /// If there was no run, or its plots cannot be written.
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
                // Nothing in it is worth keeping.
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
            failure.is_none() && ending.is_some_and(|end| success.iter().any(|s| s.is(end)));
        let ended = failure.or_else(|| match ending {
            // Faults are described in more detail elsewhere.
            Some(Ending::Time | Ending::Fault(_)) | None => None,
            Some(end @ (Ending::Angle { .. } | Ending::Error { .. } | Ending::Interrupted)) => {
                Some(end.in_words())
            }
        });
        let (servos, port) = (runner.status().servos, runner.status().port);
        let (link, trips) = (runner.stats(), runner.trips().to_vec());
        let mut stats = runner.into_keep();
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
            summary.missed_expectations = judge.verdict(tally, &summary);
        }
        let mut summary = summary.with_causes(&trips);
        summary.remarks.append(&mut stats.conclusions);
        summary.remarks.extend(csv_trouble);
        if has_plots {
            let Thinned { records, every, .. } = &stats.plotted;
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

/// What became of the log, whatever became of it.
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
            self.look_us = now_us + LOOK_US;
            let now_s = self.runner.fraction(now_us) * self.duration_s;
            self.progress.at(now_s);
            self.progress.say(self.doing(now_us, now_s));
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

    fn disconnected(&mut self, now_us: u64) {
        self.progress.say("the link broke; waiting for it");
        self.runner.disconnected(now_us);
    }
}
