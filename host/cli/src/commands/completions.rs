//! `armbridge completions`: from the definitions that command lines are read with.

use std::io::Write;
use std::process::ExitCode;

use clap::Args;
use clap_complete::Shell;

use super::Outcome;
use crate::cli;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge completions bash > ~/.local/share/bash-completion/completions/armbridge
  armbridge completions zsh > ~/.zfunc/_armbridge
  armbridge completions fish > ~/.config/fish/completions/armbridge.fish
  armbridge completions powershell >> $PROFILE";

/// Completions.
#[derive(Args, Debug)]
pub(crate) struct CompletionsArgs {
    /// Shell that is to complete the command lines of armbridge.
    #[arg(value_enum)]
    pub(crate) shell: Shell,
}

pub(crate) fn run(args: &CompletionsArgs) -> Outcome {
    let mut script = Vec::new();
    let mut command = cli::command();
    clap_complete::generate(args.shell, &mut command, "armbridge", &mut script);
    std::io::stdout().write_all(&script)?;
    Ok(ExitCode::SUCCESS)
}
