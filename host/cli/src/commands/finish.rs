//! The end of a run: its summary on one screen of 80x24, and its exit code.
//!
//! ```text
//! name, world, time
//! headline: the result in one sentence
//! setpoints, pushes, motion
//! baseline: the same with another control
//! loop, bus, torque
//! picture, log
//! remarks, or the next commands
//! ```

use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;

use armbridge_analysis::plan_runner::PlanError;
use armbridge_analysis::plan_runner::plan::Base;
use armbridge_analysis::run::{Baseline, Finished, RUN_LOG, RunHost, Verdict, headline, settled};
use armbridge_analysis::run_page;
use armbridge_client::{LinkError, stdio};
use armbridge_log::summary::Summary;
use armbridge_log::text_table::{self, WIDTH};
use serde::Serialize;

use super::{Error, Outcome};
use crate::args::OutputArgs;

/// Commands to go on with after the demo.
const NEXT: &str = "\
Next:
 armbridge watch        steer and push it in this terminal; space stops
 armbridge run push     four pushes, each recovered from
 armbridge run --list   all scenarios, the paper's experiments among them
";

/// Description of a run.
pub(super) struct Description<'a> {
    /// Purpose of the scenario.
    pub(super) title: &'a str,
    /// Expected events if all goes well; none where they are not known to apply.
    pub(super) about: Option<&'a str>,
    /// Nothing real moves.
    pub(super) is_simulated: bool,
    /// It is the demo, which a newcomer runs first.
    pub(super) is_demo: bool,
}

/// Output of `--json`.
#[derive(Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    verdict: &'static str,
    folder: &'a Path,
    baseline: Option<&'a Summary>,
}

/// Ends a run: its files, its summary, its exit code.
pub(super) fn finish(
    player: RunHost,
    result: Result<(), LinkError<PlanError>>,
    output: &OutputArgs,
    description: &Description,
) -> Outcome {
    let finished = player.finish(result)?;
    let folder = &finished.folder;
    if output.json {
        print(&(json(&finished)? + "\n"), folder)?;
    } else if !output.quiet {
        print(&screen(&finished, description, output.verbose), folder)?;
    }
    if let Some(ended) = &finished.summary.ended {
        stdio::note(format_args!("armbridge: the run ended early: {ended}"));
    } else if output.quiet && finished.verdict == Verdict::Failed {
        let failure = failure(&finished.summary);
        stdio::note(format_args!("armbridge: the run failed: {failure}"));
    }
    Ok(ExitCode::from(finished.verdict.exit_code()))
}

/// Why a run failed, in one line: its first fault, or the first expectation that it misses.
fn failure(summary: &Summary) -> String {
    let fault = summary.faults.first();
    let fault = fault.map(|it| format!("fault {} at {:.3} s", it.fault, it.time_s));
    fault
        .or_else(|| summary.missed_expectations.first().cloned())
        .unwrap_or_else(|| "it did not end as expected".into())
}

fn json(finished: &Finished) -> Result<String, Error> {
    Ok(serde_json::to_string(&Printed {
        summary: &finished.summary,
        verdict: match finished.verdict {
            Verdict::Done => "done",
            Verdict::Failed => "failed",
            Verdict::Interrupted => "interrupted",
        },
        folder: &finished.folder,
        baseline: finished.baseline.as_ref().map(|baseline| &baseline.summary),
    })?)
}

fn screen(finished: &Finished, description: &Description, is_verbose: bool) -> String {
    let Finished {
        summary,
        folder,
        verdict,
        baseline,
        is_free,
    } = finished;
    let about = description.about.filter(|_| *verdict == Verdict::Done);
    let run = &summary.run;
    let seed = run
        .seed
        .map_or_else(String::new, |seed| format!(" · seed {seed}"));
    let mut blocks = vec![
        format!(
            "armbridge {} · {}{}{seed} · {} in {:.1} s\n",
            run.name,
            run.world,
            if description.is_simulated {
                ", nothing real moves"
            } else {
                ""
            },
            seconds(summary.simulated_s),
            summary.wall_s
        ),
        paragraph(&format!(
            "{} {}",
            headline(summary, *verdict, *is_free),
            about.unwrap_or(description.title)
        )),
        summary.results(),
    ];
    // A run that was cut short has nothing to compare with it.
    let is_whole = summary.faults.is_empty() && summary.ended.is_none();
    if let Some(baseline) = baseline.as_ref().filter(|_| is_whole) {
        blocks.push(baseline_text(baseline, &run.name));
    }
    blocks.push(summary.totals() + &files(folder, summary));
    if is_verbose {
        blocks.push(summary.details());
    }
    blocks.push(remarks(summary, is_verbose));
    if description.is_demo && *verdict == Verdict::Done && !is_verbose {
        blocks.push(NEXT.into());
    }
    blocks.retain(|block| !block.is_empty());
    blocks.join("\n")
}

/// A time in s, as "9.5 s", or "0.04 s" of a short one.
fn seconds(time_s: f64) -> String {
    if time_s < 0.1 {
        format!("{time_s:.2} s")
    } else {
        format!("{} s", (time_s * 10.0).round() / 10.0)
    }
}

/// Result of the baseline on the same arm.
fn baseline_text(baseline: &Baseline, name: &str) -> String {
    let option = match baseline.control {
        Base::Board => "board",
        Base::Paper => "paper",
        Base::Compensated => "compensated",
    };
    let summary = &baseline.summary;
    let joints = summary.segments.iter().flat_map(|segment| &segment.joints);
    let off_mrad = joints
        .map(|joint| joint.steady_state_error_mrad.abs())
        .fold(0.0, f64::max);
    let (settled, all) = settled(&summary.segments);
    let result = match (&summary.faults[..], all) {
        ([fault, ..], _) => format!("end in fault {}", fault.fault),
        ([], 0) => "were run, too".into(),
        ([], _) if settled == all => format!("rest up to {off_mrad:.1} mrad off"),
        ([], _) => {
            let is_friction = summary
                .run
                .stiction_offset_mrad
                .is_some_and(|offset_mrad| off_mrad <= offset_mrad.into_iter().fold(0.0, f64::max));
            let cause = if is_friction {
                ": static friction holds it"
            } else {
                ""
            };
            format!("stop up to {off_mrad:.0} mrad short{cause}")
        }
    };
    let control = capitalised(baseline.name());
    paragraph(&format!(
        "{control}, on the same arm and seed, {result}. `armbridge run {name} --control {option}`"
    ))
}

/// Text in lines as wide as a terminal.
fn paragraph(text: &str) -> String {
    text_table::wrap(text.split_whitespace(), " ", WIDTH, "").join("\n") + "\n"
}

/// The text with a capital at its beginning.
fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}

/// Where the files are.
fn files(folder: &Path, summary: &Summary) -> String {
    let mut text = String::new();
    let size_mb = summary
        .log
        .as_ref()
        .map_or(0.0, |log| log.size as f64 * 1e-6);
    for (what, name, note) in [
        ("page", run_page::FILE, "open it in a browser".to_owned()),
        ("log", RUN_LOG, format!("every tick, {size_mb:.1} MB")),
    ] {
        let path = folder.join(name);
        if path.is_file() {
            let _ = writeln!(text, " {what:<8} {}   {note}", path.display());
        }
    }
    text
}

/// Remarks on this run; explanations of small offsets only with `--verbose`.
fn remarks(summary: &Summary, is_verbose: bool) -> String {
    let is_clean = summary.faults.is_empty() && summary.ended.is_none();
    let (settled, all) = settled(&summary.segments);
    if !is_verbose && is_clean && settled == all && summary.missed_expectations.is_empty() {
        let worth = |remark: &String| !remark.starts_with("joint ");
        let summary = Summary {
            remarks: summary
                .remarks
                .iter()
                .filter(|it| worth(it))
                .cloned()
                .collect(),
            ..summary.clone()
        };
        return summary.remarks_text();
    }
    summary.remarks_text()
}

/// Prints the summary; an error names the run's folder.
fn print(text: &str, folder: &Path) -> Result<(), String> {
    stdio::print(text).map_err(|error| format!("{error}; the run is in {}", folder.display()))
}
