//! `armbridge paper`: the paper's numbers and figures, computed again.

use std::io::Write;
use std::process::ExitCode;

use armbridge_analysis::paper;
use armbridge_analysis::paper::{Claim, Findings, JsonReport};
use armbridge_analysis::run_folder::RunFolder;

use super::Outcome;
use crate::args::OutputArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge paper
  armbridge paper --out reports --json";

pub(crate) fn run(args: &OutputArgs) -> Outcome {
    let folder = RunFolder::create(args.out.as_deref(), "paper")?;
    let claims = Findings::compute()?.claims();
    let path = paper::write(folder.path(), &claims)?;
    let page = path.display();
    let mut out = std::io::stdout();
    let printed = if args.json {
        let report = JsonReport::new(&path, &claims);
        writeln!(out, "{}", serde_json::to_string(&report)?)
    } else if args.quiet {
        Ok(())
    } else {
        writeln!(out, "{}\n{page}", heading(&claims))
    };
    printed.map_err(|error| format!("cannot print the verdicts: {error}; the report is {page}"))?;
    Ok(ExitCode::SUCCESS)
}

fn heading(claims: &[Claim]) -> String {
    format!("armbridge paper · simulated\n{}", paper::table(claims))
}
