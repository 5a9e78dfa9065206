//! A run from its plan to its folder, on any link: a plan runner performs the plan, the
//! recorder writes the log, and at the end come plots and a summary.
//!
//! | module     | contents                                                     |
//! |------------|--------------------------------------------------------------|
//! | `assessment` | success, fault and missed expectations of a run            |
//! | `baseline` | the same run with another control, for comparison            |
//! | `finish`   | end of a run: log, plots, summary, verdict                   |
//! | `run_stats`| counts and expectations of the run in progress               |
//!
//! Memory does not grow with the length of the run.

mod assessment;
mod baseline;
mod finish;
mod headline;
mod run_stats;

pub use assessment::{Assessment, assess};
pub use baseline::{BASELINE_LOG, Baseline};
pub use finish::{Finished, Verdict};
pub use headline::{headline, settled};

use std::path::Path;
use std::sync::mpsc::Receiver;
use std::time::Instant;

use armbridge_client::simulation::SimulationEvent;
use armbridge_client::{Host, LinkError, Tap, ctrl_c, enum_names};
use armbridge_log::LogError;
use armbridge_log::recorder::Recorder;
use armbridge_log::run_info::RunFacts;
use armbridge_sim::cosim::Interaction;

use crate::plan_runner::{Plan, PlanError, PlanRunner};
use crate::progress::Progress;
use crate::run_folder::{RunFolder, RunFolderError};
use crate::scenario::{ExpectationMonitor, Success};
use run_stats::RunStats;

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
    /// Command that makes the run, to repeat it.
    pub made_by: String,
    /// Files to write.
    pub files: Files,
    /// The run waits for the disk, which only virtual time permits.
    pub is_patient: bool,
    /// No progress bar.
    pub is_quiet: bool,
}

/// Name of a run's log in its folder.
pub const RUN_LOG: &str = "run.mcap";

/// Files of a run.
#[derive(Clone, Copy, Debug)]
pub struct Files {
    /// Name of the log.
    pub log: &'static str,
    /// `run.csv`, written where the link is served: for virtual time.
    pub csv: bool,
    /// The plots and the page.
    pub plots: bool,
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
    /// The link or the plan failed before the arm was armed.
    #[error(transparent)]
    Link(LinkError<PlanError>),
    /// A signal before the arm was armed.
    #[error(
        "ended by {} before the arm was armed; nothing moved",
        ctrl_c::in_words()
    )]
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
    files: Files,
    made_by: String,
    baseline: Option<Baseline>,
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
        let path = folder.path().to_path_buf();
        // Where the disk is full, an empty folder would be all that is left.
        Self::begin(spec, folder).inspect_err(|_| {
            let _ = std::fs::remove_dir(path);
        })
    }

    fn begin(spec: RunSpec, folder: RunFolder) -> Result<Self, RunError> {
        let RunSpec {
            plan,
            facts,
            success,
            judge,
            made_by,
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
            recorder: begin_log(&folder.file(files.log), &facts)?,
            progress: Progress::new(duration_s, is_quiet),
            folder,
            facts,
            success,
            duration_s,
            files,
            made_by,
            baseline: None,
            look_us: 0,
            begun: Instant::now(),
        })
    }

    /// Adds a baseline to compare with.
    pub fn compare_with(&mut self, baseline: Baseline) {
        self.baseline = Some(baseline);
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

    fn disarm(&mut self, now_us: u64) -> bool {
        self.runner.disarm(now_us)
    }

    fn disconnected(&mut self, now_us: u64) {
        self.progress.set_message("the link broke; waiting for it");
        self.runner.disconnected(now_us);
    }

    fn takes_true_states(&self) -> bool {
        self.runner.sink().takes_true_states()
    }

    fn simulated(&mut self, event: &SimulationEvent) {
        self.runner.sink_mut().simulated(event);
    }
}
