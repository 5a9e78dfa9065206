//! The command lines of `config`, `completions` and `man`.

use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;

pub(crate) const CONFIG_EXAMPLES: &str = "\
Examples:
  armbridge config
  armbridge config --init
  armbridge config --explain | less

armbridge.toml is looked for in the working directory and in those above it. Options of a
command go before the environment (ARMBRIDGE_LINK, ARMBRIDGE_OUT), that before the file,
that before the defaults.";

pub(crate) const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  armbridge completions bash > ~/.local/share/bash-completion/completions/armbridge
  armbridge completions zsh > ~/.zfunc/_armbridge
  armbridge completions fish > ~/.config/fish/completions/armbridge.fish
  armbridge completions powershell >> $PROFILE";

pub(crate) const MAN_EXAMPLES: &str = "\
Examples:
  armbridge man | man -l -
  armbridge man --out ~/.local/share/man/man1

A page for the program and one for each command: armbridge(1), armbridge-run(1), ...";

/// What is in force.
#[derive(Args, Debug)]
pub(crate) struct ConfigArgs {
    /// Print every key with meaning, unit, default and range, as an armbridge.toml whose
    /// lines are all comments.
    #[arg(long, conflicts_with_all = ["init", "json"])]
    pub(crate) explain: bool,
    /// Write that into the working directory, as armbridge.toml.
    #[arg(long, conflicts_with = "json")]
    pub(crate) init: bool,
    /// Print one JSON array instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Completions.
#[derive(Args, Debug)]
pub(crate) struct CompletionsArgs {
    /// Shell that is to complete the command lines of armbridge.
    #[arg(value_enum)]
    pub(crate) shell: Shell,
}

/// Manual pages.
#[derive(Args, Debug)]
pub(crate) struct ManArgs {
    /// Write the pages of all commands into this folder, instead of printing the first.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}
