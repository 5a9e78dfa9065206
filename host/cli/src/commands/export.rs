//! `armbridge export`: a log in another program's format.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_analysis::run_folder::DEFAULT_BASE;
use armbridge_log::export;
use armbridge_log::export::Format;
use armbridge_log::find::find;
use armbridge_log::inspect::{Head, log};

use super::Outcome;
use crate::cli::{ExportArgs, FormatName};

pub(crate) fn run(args: &ExportArgs) -> Outcome {
    let format = match args.format {
        FormatName::Csv => Format::Csv,
        FormatName::Parquet => Format::Parquet,
        FormatName::Mat => Format::Mat,
    };
    let log = find(args.log.as_deref(), Path::new(DEFAULT_BASE))?;
    let out = out(args, &log, format)?;
    // Read to its end first: what is missing of it is written, too.
    let head = Head::read(&log, |_| ())?;
    let records = || Ok(log::records(&log)?);
    let ticks = export::write(format, &out, &head.about(), records)?;
    for damage in &head.damage {
        eprintln!("{}: {damage}", log.display());
    }
    let megabytes = out.metadata().map_or(0.0, |file| file.len() as f64 / 1e6);
    let line = format!("{} · {ticks} ticks, {megabytes:.1} MB", out.display());
    writeln!(std::io::stdout(), "{line}").map_err(|error| format!("cannot print: {error}"))?;
    Ok(ExitCode::SUCCESS)
}

/// Where to write.
fn out(args: &ExportArgs, log: &Path, format: Format) -> Result<PathBuf, String> {
    let beside = || log.with_extension(format.extension());
    let out = args.out.clone().unwrap_or_else(beside);
    if out == log {
        return Err(format!(
            "{} is the log itself; choose another file with --out",
            out.display()
        ));
    }
    Ok(out)
}
