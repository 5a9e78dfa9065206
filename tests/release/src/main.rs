//! `cargo release`: firmware images and host programs to download, in one folder.
//!
//! | file                            | contents                                              |
//! |---------------------------------|-------------------------------------------------------|
//! | `armbridge-BOARD.elf`           | image with debug information, for a debug probe        |
//! | `armbridge-BOARD.bin`           | bytes from the beginning of flash on                   |
//! | `armbridge-BOARD.dfu`           | the same for the ROM loader on USB                     |
//! | `armbridge-SYSTEM`              | host program with all features, stripped               |
//! | `images.json`                   | images by the checksum that a board reports            |
//! | `SHA256SUMS`                    | checksums of all files                                 |
//!
//! Files are equal bit for bit wherever the sources lie, see [`compile`]. Exit code 0: all
//! were written; 1: a build or a file failed; 2: wrong arguments.

mod compile;
mod dfu;
mod folder;
mod systems;

use std::path::PathBuf;
use std::process::ExitCode;

use armbridge_verify::boards::BOARDS;
use compile::Compiler;
use folder::Folder;
use systems::SYSTEMS;

const USAGE: &str = "\
Build the firmware images and the host programs to download, with their checksums.

usage: cargo release [--out DIR] [--sources DIR] [--help]

  --out DIR      folder to write to [default: target/downloads]
  --sources DIR  sources to build, in their folder `target` [default: this project]
  --help         print this help";

/// Action that the arguments ask for.
#[derive(Debug, Default, PartialEq)]
struct Arguments {
    out: Option<PathBuf>,
    sources: Option<PathBuf>,
    help: bool,
}

fn main() -> ExitCode {
    let arguments = match parse(std::env::args().skip(1)) {
        Ok(arguments) => arguments,
        Err(what) => {
            eprintln!("{what}\n\n{USAGE}");
            return ExitCode::from(2);
        }
    };
    if arguments.help {
        println!("{USAGE}");
        return ExitCode::SUCCESS;
    }
    match release(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("cargo release: {why}");
            ExitCode::FAILURE
        }
    }
}

fn parse(mut words: impl Iterator<Item = String>) -> Result<Arguments, String> {
    let mut arguments = Arguments::default();
    while let Some(word) = words.next() {
        let place = match &*word {
            "--help" | "-h" => {
                arguments.help = true;
                continue;
            }
            "--out" => &mut arguments.out,
            "--sources" => &mut arguments.sources,
            _ => return Err(format!("unknown argument `{word}`")),
        };
        let folder = words.next().filter(|folder| !folder.is_empty());
        *place = Some(
            folder
                .ok_or_else(|| format!("{word} needs a folder"))?
                .into(),
        );
    }
    Ok(arguments)
}

/// Builds everything, and fills the folder.
fn release(arguments: Arguments) -> Result<(), String> {
    let compiler = Compiler::new(arguments.sources.as_deref())?;
    let out = arguments.out.unwrap_or_else(|| compiler.downloads());
    let mut folder = Folder::new(&out, &compiler.commit)?;
    for board in BOARDS.iter().filter(|board| board.chip.is_some()) {
        println!("image for {}", board.name);
        folder.add_image(board.name, &compiler.image(board)?)?;
    }
    for system in SYSTEMS {
        println!("program for {}", system.name);
        let name = format!("armbridge-{}{}", system.name, system.extension);
        folder.add_program(&name, &compiler.program(system)?)?;
    }
    folder.finish()?;
    println!("files in {}", out.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_understood_or_refused() {
        let parse = |line: &str| parse(line.split_whitespace().map(str::to_owned));
        assert_eq!(parse(""), Ok(Arguments::default()));
        let both = parse("--out a --sources b").unwrap();
        assert_eq!(
            (both.out, both.sources),
            (Some("a".into()), Some("b".into()))
        );
        for (wrong, words) in [
            ("--out", "--out needs a folder"),
            ("--into a", "unknown argument `--into`"),
            ("--out a b", "unknown argument `b`"),
        ] {
            assert_eq!(parse(wrong), Err(words.to_owned()));
        }
    }
}
