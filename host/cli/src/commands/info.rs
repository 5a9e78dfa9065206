//! `armbridge info`: what a log holds.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use armbridge_analysis::run_folder::DEFAULT_BASE;
use armbridge_log::find::find;
use armbridge_log::inspect::Info;

use super::Outcome;
use crate::cli::InfoArgs;

pub(crate) fn run(args: &InfoArgs) -> Outcome {
    let info = Info::read(&find(args.log.as_deref(), Path::new(DEFAULT_BASE))?)?;
    let text = if args.json {
        serde_json::to_string(&info)?
    } else {
        info.table()
    };
    writeln!(std::io::stdout(), "{}", text.trim_end())
        .map_err(|error| format!("cannot print: {error}"))?;
    Ok(ExitCode::SUCCESS)
}
