//! `armbridge diff`: where two logs differ.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_analysis::run_folder::DEFAULT_BASE;
use armbridge_log::find::find;
use armbridge_log::inspect::{Diff, Head, Log};

use super::Outcome;
use crate::cli::DiffArgs;

pub(crate) fn run(args: &DiffArgs) -> Outcome {
    let load = |path: &PathBuf| Log::load(&find(Some(path), Path::new(DEFAULT_BASE))?);
    let [a, b] = [load(&args.a)?, load(&args.b)?];
    let diff = Diff::of(&a, &b);
    let text = if args.json {
        serde_json::to_string(&diff)?
    } else {
        diff.table()
    };
    for Head { path, damage, .. } in [&a.head, &b.head] {
        for damage in damage {
            eprintln!("{}: {damage}", path.display());
        }
    }
    writeln!(std::io::stdout(), "{}", text.trim_end())
        .map_err(|error| format!("cannot print: {error}"))?;
    Ok(ExitCode::from(u8::from(!diff.is_same())))
}
