//! Links the image in which no panic may be left, `firmware/src/bin/no-panic.rs`.
//!
//! When it does not link, the same image with a panic handler is searched for
//! the calls that lead there. A check that nobody has seen fail proves nothing,
//! so panics are planted too: they must keep it from linking, and be found in
//! each of the three loops.

use super::callers::{self, Call};
use armbridge_tests::place;
use std::path::Path;
use std::process::Command;

/// What the panic handler calls, and nobody has.
const MISSING: &str = "a_panic_can_be_reached";

/// Where panics are planted, if they are: what each of the loops waits for.
const PLANTED: [&str; 3] = [
    "tasks::tick::real_time",
    "tasks::host_link::link",
    "tasks::client::client",
];

/// Both halves of the check.
pub(crate) fn run() -> Result<(), String> {
    if !links("no-panic")? {
        return Err(report(&reachable("no-panic-locate")?));
    }
    if links("no-panic-planted")? {
        return Err("planted panics do not keep the image from linking".to_owned());
    }
    let planted = reachable("no-panic-locate,no-panic-planted")?;
    for place in PLANTED {
        if !planted.iter().any(|call| call.is_in(place)) {
            return Err(format!(
                "the panic planted in {place} is not found; found are\n{}",
                report(&planted)
            ));
        }
    }
    println!("    none can be reached; planted ones are found in each loop");
    Ok(())
}

/// Builds the image with these features. False if a panic keeps it from linking.
fn links(features: &str) -> Result<bool, String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let arguments = "build --quiet --profile firmware --package armbridge-firmware \
                     --target thumbv7em-none-eabihf --bin no-panic --features";
    let output = Command::new(cargo)
        .args(arguments.split_whitespace())
        .arg(features)
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
        .output()
        .map_err(|e| format!("cannot start cargo: {e}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        Ok(true)
    } else if said.contains(&format!("undefined symbol: {MISSING}")) {
        Ok(false)
    } else {
        Err(format!("the image does not build:\n{said}"))
    }
}

/// The panics in the image with these features, which has a handler.
fn reachable(features: &str) -> Result<Vec<Call>, String> {
    if !links(features)? {
        return Err(format!("with {features}, {MISSING} is still called"));
    }
    let image = place::target().join("thumbv7em-none-eabihf/firmware/no-panic");
    callers::of_panics(&image).map_err(|e| format!("{}: {e}", image.display()))
}

fn report(calls: &[Call]) -> String {
    let mut text = String::from(
        "a panic can be reached from what bus, host or client send; \
         each call below, innermost first, must go (`get`, an iterator, `checked_div`, \
         a bound that the compiler sees):\n",
    );
    for call in calls {
        text.push_str(&call.to_string());
    }
    text
}
