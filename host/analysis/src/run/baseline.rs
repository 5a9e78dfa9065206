//! Baseline: the same run on the same simulated arm and seed with another control, for
//! comparison in plots, page and summary.

use armbridge_log::summary::Summary;
use armbridge_sim::link::{BoardUri, Options, drive};

use super::{RunError, RunHost, RunSpec};
use crate::plan_runner::plan::Base;
use crate::run_folder::RunFolder;
use crate::scenario::BenchSpec;

/// Name of the baseline's log in the run folder.
pub const BASELINE_LOG: &str = "baseline.mcap";

/// A baseline that has run.
#[derive(Clone, Debug)]
pub struct Baseline {
    /// Control.
    pub control: Base,
    /// Summary.
    pub summary: Summary,
}

impl Baseline {
    /// Name of its control.
    pub fn name(&self) -> &'static str {
        match self.control {
            Base::Board => "the board's own control",
            Base::Paper => "the paper's weights and observer",
            Base::Compensated => "Kalman filter and friction compensation",
        }
    }

    /// Runs it on the bench, as fast as possible; `spec` has its control, and names its log.
    ///
    /// # Errors
    /// If the run does not begin, or its log cannot be written.
    pub fn run(
        control: Base,
        spec: RunSpec,
        bench: &BenchSpec,
        folder: RunFolder,
    ) -> Result<Self, RunError> {
        let mut host = RunHost::in_folder(spec, folder)?;
        let mut options = Options::new(bench.build());
        options.link.taps.push(host.tap());
        options.interactions = Some(host.interactions());
        let (host, result) = drive(&BoardUri::Sim, options, host);
        let summary = host.finish(result)?.summary;
        Ok(Self { control, summary })
    }
}
