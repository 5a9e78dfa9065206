//! The end of a run: its summary, and its exit code.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use armbridge_analysis::plan_runner::PlanError;
use armbridge_analysis::run::{Finished, RunHost};
use armbridge_client::LinkError;

use super::Outcome;
use crate::args::OutputArgs;

/// Ends a run: its files, its summary, its exit code.
pub(super) fn finish(
    player: RunHost,
    result: Result<(), LinkError<PlanError>>,
    output: &OutputArgs,
) -> Outcome {
    let Finished {
        summary,
        folder,
        verdict,
    } = player.finish(result)?;
    let path = folder.display();
    if output.json {
        print(&serde_json::to_string(&summary)?, &folder)?;
    } else if !output.quiet {
        print(&format!("{}\n{path}", summary.table()), &folder)?;
    }
    if let Some(ended) = &summary.ended {
        eprintln!("armbridge: the run ended early: {ended}");
    }
    Ok(ExitCode::from(verdict.exit_code()))
}

/// Prints the summary; an error names the run's folder.
fn print(text: &str, folder: &Path) -> Result<(), String> {
    writeln!(std::io::stdout(), "{text}").map_err(|error| {
        let path = folder.display();
        format!("cannot print the summary: {error}; the run is in {path}")
    })
}
