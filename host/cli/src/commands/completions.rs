//! `armbridge completions`: a shell's completions, from the definitions of the command line.

use std::io::Write;
use std::process::ExitCode;

use clap::{Args, Command};
use clap_complete::Shell;

use super::Outcome;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge completions bash > ~/.local/share/bash-completion/completions/armbridge
  armbridge completions zsh > ~/.zfunc/_armbridge
  armbridge completions fish > ~/.config/fish/completions/armbridge.fish
  armbridge completions powershell >> $PROFILE";

/// Completions.
#[derive(Args, Debug)]
pub(crate) struct CompletionsArgs {
    /// Shell that the completions are for.
    #[arg(value_enum)]
    pub(crate) shell: Shell,
}

/// `program` is the program with all its commands.
pub(crate) fn run(args: &CompletionsArgs, mut program: Command) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "armbridge", &mut script);
    std::io::stdout().write_all(&script)?;
    Ok(ExitCode::SUCCESS)
}
