//! `armbridge paper`: the paper's numbers and figures, computed again.

use std::process::ExitCode;

use armbridge::config::Config;
use armbridge_analysis::run_folder::RunFolder;
use armbridge_client::stdio;
use armbridge_paper as paper;
use armbridge_paper::{Claim, Findings, JsonReport};

use super::Outcome;
use super::interruptible::interruptible;
use crate::args::OutputArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge paper
  armbridge paper --out reports --json";

pub(crate) fn run(args: &OutputArgs) -> Outcome {
    let base = Config::discover()?.out(args.out.as_deref());
    let folder = RunFolder::create(Some(&base), "paper")?;
    let what = "the paper's numbers were computed; nothing is written";
    let findings = interruptible(what, Findings::compute).inspect_err(|_| {
        // Best effort: it is empty.
        let _ = std::fs::remove_dir(folder.path());
    })??;
    let claims = findings.claims();
    let path = paper::write(folder.path(), &claims)?;
    let page = path.display();
    let printed = if args.json {
        let report = JsonReport::new(&path, &claims);
        stdio::print_line(serde_json::to_string(&report)?)
    } else if args.quiet {
        Ok(())
    } else {
        stdio::print_line(format_args!("{}\n{page}", heading(&claims)))
    };
    printed.map_err(|error| format!("{error}; the report is {page}"))?;
    Ok(ExitCode::SUCCESS)
}

fn heading(claims: &[Claim]) -> String {
    format!("armbridge paper · simulated\n{}", paper::table(claims))
}
