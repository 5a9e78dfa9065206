//! `armbridge man`: manual pages, from the definitions of the command line.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_client::stdio;
use armbridge_client::stdio::Stdout;
use armbridge_log::output_file;
use clap::{Args, Command};
use clap_mangen::Man;

use super::{Error, Outcome};
use crate::args::ForceArgs;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge man | man -l -
  armbridge man --out ~/.local/share/man/man1

One page for the program, armbridge(1), and one for each command, such as
armbridge-run(1).";

/// Manual pages.
#[derive(Args, Debug)]
pub(crate) struct ManArgs {
    /// Write the pages of all commands to this folder instead of printing the first one.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
}

/// `program` is the program with all its commands.
pub(crate) fn run(args: &ManArgs, mut program: Command) -> Outcome {
    program.build();
    let Some(folder) = &args.out else {
        Stdout.write_all(&page(&program)?)?;
        return Ok(ExitCode::SUCCESS);
    };
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder {}: {error}", folder.display()))?;
    let written = write_all(folder, args.force, &program)?;
    let folder = folder.display();
    stdio::print_line(format_args!("{written} pages written to {folder}"))?;
    Ok(ExitCode::SUCCESS)
}

/// The pages of a command and of those below it; how many.
fn write_all(folder: &Path, force: ForceArgs, command: &Command) -> Result<usize, Error> {
    let path = folder.join(format!("{}.1", name(command)));
    output_file::write(&path, &page(command)?, force.chosen())
        .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    let inner = command.get_subcommands();
    let mut written = 1;
    for command in inner.filter(|inner| inner.get_name() != "help" && !inner.is_hide_set()) {
        written += write_all(folder, force, command)?;
    }
    Ok(written)
}

/// As `armbridge-servo-read`.
fn name(command: &Command) -> String {
    let name = command.get_display_name();
    name.unwrap_or_else(|| command.get_name()).to_owned()
}

fn page(command: &Command) -> Result<Vec<u8>, Error> {
    let mut page = Vec::new();
    Man::new(command.clone()).render(&mut page)?;
    Ok(page)
}
