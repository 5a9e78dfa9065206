//! `cargo build-board [BOARD]` and `cargo flash-board [BOARD]`: builds the image of a board, or
//! builds it and writes it by a debug probe, with probe-rs. Without a name it is the Feather's.

use std::process::{Command, ExitCode};

use armbridge_verify::{TARGET, board_named, image_arguments};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match run(&arguments) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &[&str]) -> Result<ExitCode, String> {
    let (command, name) = match arguments {
        [command] => (*command, None),
        [command, name] => (*command, Some(*name)),
        _ => return Err("give the name of one board, or none".to_owned()),
    };
    let board = board_named(name)?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut cargo = Command::new(cargo);
    match (command, board.chip) {
        ("build", _) => cargo.args(image_arguments("build", board).split_whitespace()),
        ("flash", Some(chip)) => {
            let runner = format!("target.{TARGET}.runner = 'probe-rs run --chip {chip}'");
            cargo.args(image_arguments("run", board).split_whitespace());
            cargo.args(["--config", &runner])
        }
        ("flash", None) => {
            let name = board.name;
            return Err(format!(
                "{name} is emulated: `armbridge run --link emulate:` starts it"
            ));
        }
        (other, _) => return Err(format!("no command `{other}`; there are build and flash")),
    };
    let status = cargo.status();
    let status = status.map_err(|error| format!("cannot start cargo: {error}"))?;
    Ok(if status.success() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}
