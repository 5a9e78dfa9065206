//! Link, options and files that a scenario runs with.

use armbridge::config::Config;
use armbridge_analysis::plan_runner::plan::Base;
use armbridge_analysis::run::{BASELINE_LOG, Baseline, Files, RUN_LOG, RunSpec};
use armbridge_analysis::run_folder::RunFolder;
use armbridge_analysis::scenario::{ExpectationMonitor, Scenario};
use armbridge_client::{ctrl_c, shell_text, stdio};
use armbridge_log::run_info::RunFacts;
use armbridge_sim::link::{BoardUri, Options, Pace};

use super::Error;

/// Link and options that a scenario runs with.
pub(in crate::commands) struct Staging<'a> {
    pub(in crate::commands) config: &'a Config,
    pub(in crate::commands) link: &'a BoardUri,
    pub(in crate::commands) pace: Pace,
    /// A link that breaks is not reported.
    pub(in crate::commands) is_quiet: bool,
    /// There is no progress bar.
    pub(in crate::commands) is_silent: bool,
}

impl Staging<'_> {
    /// Options of the link. Pushes and hands are left out where the arm is not simulated here.
    pub(in crate::commands) fn options(&self, scenario: &mut Scenario) -> Options {
        if !self.link.is_simulated() && !scenario.plan.pushes.is_empty() {
            let left_out = match scenario.plan.pushes.len() {
                1 => "push is".to_owned(),
                count => format!("{count} pushes are"),
            };
            stdio::note(format_args!(
                "note: at {} the scenario's {left_out} left out: a run pushes the arm of sim: and \
                 emulate: alone",
                self.link
            ));
            scenario.plan.pushes.clear();
            scenario.expect.recovers_within_s = None;
        }
        if !self.link.is_simulated() && !scenario.plan.leads.is_empty() {
            stdio::note(format_args!(
                "note: at {} the hands of `[[bench.hand]]` are left out: a run leads the arm of \
                 sim: and emulate: alone; lead this one yourself",
                self.link
            ));
            scenario.plan.leads.clear();
            scenario.expect.stays_within_rad = None;
        }
        let mut options = Options::new(scenario.bench.build());
        options.pace = self.pace;
        options.link.patience = self.config.patience();
        options.link.is_quiet = self.is_quiet;
        options.is_stoppable = true;
        if !self.is_silent {
            options.board_log = |line| stdio::note(format_args!("board: {line}"));
        }
        options
    }

    /// Runs a baseline, which leaves its log in the folder and nothing else.
    pub(super) fn baseline(
        &self,
        control: Base,
        scenario: Scenario,
        folder: &RunFolder,
    ) -> Result<Baseline, Error> {
        let staging = Staging {
            link: &BoardUri::Sim,
            pace: Pace::Free,
            is_silent: true,
            ..*self
        };
        let bench = scenario.bench.clone();
        let spec = RunSpec {
            judge: None,
            files: Files {
                log: BASELINE_LOG,
                csv: false,
                plots: false,
            },
            ..staging.task(scenario)?
        };
        Ok(Baseline::run(control, spec, &bench, folder.clone())?)
    }

    /// The run's specification.
    pub(in crate::commands) fn task(&self, scenario: Scenario) -> Result<RunSpec, Error> {
        let is_simulated = self.link.is_simulated();
        let facts = if is_simulated {
            scenario.simulated_facts(&self.link.world())
        } else {
            RunFacts::from_settings(&scenario.name, &self.link.to_string(), &scenario.settings)
        };
        let Scenario {
            plan,
            success,
            expect,
            ..
        } = scenario;
        ctrl_c::listen()?;
        Ok(RunSpec {
            judge: Some(ExpectationMonitor::new(expect, &plan.pushes, &plan.leads)),
            plan,
            facts,
            success,
            made_by: command_line(),
            files: Files {
                log: RUN_LOG,
                csv: self.config.writes_csv() && is_simulated,
                plots: self.config.draws_plots(),
            },
            is_patient: is_simulated && self.pace == Pace::Free,
            is_quiet: self.is_silent,
        })
    }
}

/// This program's command line, as it can be typed again; of the demo, if nothing was typed.
fn command_line() -> String {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words = match &words[..] {
        [] => "run demo".to_owned(),
        words => words
            .iter()
            .map(|word| shell_text::word(word))
            .collect::<Vec<_>>()
            .join(" "),
    };
    format!("armbridge {words}")
}
