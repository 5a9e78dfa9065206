//! Two independent masters of Dynamixel Protocol 2.0, unmodified: `rustypot` and `dynamixel2`.
//!
//! `masters NAME PORT` drives the two servos of the X series at a port by one of them: exit code 0 if
//! all is as it should be; otherwise 1, and the first thing that is not on stderr. `masters vectors`
//! prints the packets that they make of instructions.

#![forbid(unsafe_code)]

mod check;
mod vectors;
mod with_dynamixel2;
mod with_rustypot;

use std::process::ExitCode;

const USAGE: &str = "usage: masters rustypot PORT | dynamixel2 PORT | vectors";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match arguments[..] {
        ["rustypot", port] => with_rustypot::run(port),
        ["dynamixel2", port] => with_dynamixel2::run(port),
        ["vectors"] => vectors::print(),
        _ => Err(USAGE.into()),
    };
    if let Err(error) = result {
        eprintln!("{error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
