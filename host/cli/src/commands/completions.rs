//! `armbridge completions`: a shell's completions, from the definitions of the command line.

use std::fmt::Write as _;
use std::io::Write;
use std::process::ExitCode;

use armbridge_client::stdio::Stdout;
use clap::{Args, Command};
use clap_complete::Shell;

use super::Outcome;
use crate::args::suggestions::{plant_names, scenario_names};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge completions bash \\
      > ~/.local/share/bash-completion/completions/armbridge
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
    let script = with_files(args.shell, String::from_utf8(script)?);
    Stdout.write_all(script.as_bytes())?;
    Ok(ExitCode::SUCCESS)
}

/// Lets names of scenarios and virtual arms complete beside files, which the generator
/// leaves out; bash falls back to files by itself.
fn with_files(shell: Shell, mut script: String) -> String {
    match shell {
        Shell::Zsh => {
            for names in [scenario_names(), plant_names()] {
                let list = format!("({})", names.join(" "));
                let both = format!("{{_alternative \"names:name:{list}\" \"files:file:_files\"}}");
                script = script.replace(&list, &both);
            }
        }
        Shell::Fish => {
            for names in [scenario_names(), plant_names()] {
                let first = format!("-a \"{}\\t", names[0]);
                script = script.replace(&format!("-f {first}"), &format!("-F {first}"));
            }
            for (command, names) in [
                ("run", scenario_names()),
                ("sweep", scenario_names()),
                ("plants", plant_names()),
            ] {
                let _ = writeln!(
                    script,
                    "complete -c armbridge -n \"__fish_armbridge_using_subcommand {command}\" -a \
                     \"{}\"",
                    names.join(" ")
                );
            }
        }
        _ => {}
    }
    script
}
