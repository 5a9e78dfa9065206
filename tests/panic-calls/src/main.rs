//! Lists the calls that lead to a panic in an image, by source line.
//!
//! `panic-calls IMAGE` prints every call. With names of functions after the image, each
//! must have such a call. Exit code 0: so it is; 1: a function has none; 2: the image
//! cannot be read.

mod callers;

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(image) = arguments.next() else {
        eprintln!("usage: panic-calls IMAGE [FUNCTION..]");
        return ExitCode::from(2);
    };
    let calls = match callers::of_panics(Path::new(&image)) {
        Ok(calls) => calls,
        Err(error) => {
            eprintln!("{image}: {error}");
            return ExitCode::from(2);
        }
    };
    for call in &calls {
        print!("{call}");
    }
    let is_missing = |name: &String| !calls.iter().any(|call| call.is_in(name));
    let missing: Vec<String> = arguments.filter(is_missing).collect();
    if missing.is_empty() {
        return ExitCode::SUCCESS;
    }
    eprintln!("no call that leads to a panic in {}", missing.join(", "));
    ExitCode::FAILURE
}
