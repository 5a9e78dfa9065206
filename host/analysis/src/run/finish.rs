//! End of a run: the log is closed, the plots are drawn, summary and verdict computed.

use std::path::PathBuf;
use std::time::Duration;

use armbridge_client::{LinkError, ctrl_c};
use armbridge_link::message::PortCounters;
use armbridge_log::recorder::Recorder;
use armbridge_log::summary::{LogSummary, ServoSummary, Summary};

use super::{BASELINE_LOG, Baseline, RunError, RunHost, assess, headline};
use crate::plan_runner::{Ending, PlanError};
use crate::plot;
use crate::run_folder::RunFolder;
use crate::run_page::{self, Beside, PageInput};

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
            Self::Interrupted => ctrl_c::exit_code(),
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
    /// The same run with another control.
    pub baseline: Option<Baseline>,
    /// An experiment drove the arm, or it floated: it need not balance.
    pub is_free: bool,
}

impl RunHost {
    /// Closes the log, draws the plots and computes the summary of a run that ended with
    /// `result`.
    ///
    /// # Errors
    /// If the run did not begin.
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
            files,
            made_by,
            baseline,
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
        let (servos, port) = (runner.status().servos, runner.status().port);
        let (link, trips) = (runner.stats(), runner.trips().to_vec());
        let floats = runner.floats();
        let mut stats = runner.into_sink();
        let csv_trouble = stats.close().map(|error| error.to_string());

        let judge = stats.judge.take();
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
        let mut is_complete = log.is_complete() && csv_trouble.is_none();
        summary.log = Some(log);
        let assessment = assess(ending, failure, &success, judge, tally, &summary);
        summary.ended = assessment.ended;
        summary.missed_expectations = assessment.missed;
        let mut summary = summary.with_causes(&trips);
        let is_free = floats || !stats.conclusions.is_empty();
        summary.remarks.append(&mut stats.conclusions);
        summary.remarks.extend(csv_trouble);
        let verdict = |is_complete: bool, summary: &Summary| {
            if ending == Some(Ending::Interrupted) {
                Verdict::Interrupted
            } else if assessment.is_success && is_complete && summary.missed_expectations.is_empty()
            {
                Verdict::Done
            } else {
                Verdict::Failed
            }
        };
        if files.plots {
            let log = folder.file(files.log);
            let drawn = plot::draw_run(&log).map(drop);
            let input = PageInput {
                // What ended as it should is described by its log.
                headline: match verdict(is_complete, &summary) {
                    Verdict::Done => None,
                    verdict => Some(headline(&summary, verdict, is_free)),
                },
                made_by: Some(&made_by),
                ..PageInput::of_log(&log)
            };
            let page = write_page(&folder, input, baseline.as_ref());
            for trouble in [drawn.err().map(|it| it.to_string()), page.err()]
                .into_iter()
                .flatten()
            {
                summary.remarks.push(trouble);
                is_complete = false;
            }
        }

        let verdict = verdict(is_complete, &summary);
        Ok(Finished {
            summary,
            folder: folder.path().into(),
            verdict,
            baseline,
            is_free,
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

/// Writes the page of a run, with its baseline if there is one.
fn write_page(
    folder: &RunFolder,
    input: PageInput<'_>,
    baseline: Option<&Baseline>,
) -> Result<(), String> {
    let beside = baseline.map(|baseline| (folder.file(BASELINE_LOG), baseline.name()));
    let input = PageInput {
        beside: beside.as_ref().map(|(log, name)| Beside { log, name }),
        ..input
    };
    let written = run_page::write(folder.path(), &input);
    written.map(drop).map_err(|error| error.to_string())
}
