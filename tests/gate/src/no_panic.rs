//! Links the image in which no panic may be left, `firmware/src/bin/no-panic.rs`.
//!
//! When it does not link, the same image with a panic handler is searched for
//! the calls that lead there (`tests/panic-calls`). A check that has never failed
//! proves nothing, so panics are planted too: they must keep it from linking, and be
//! found in each of the three loops.

use std::process::Command;

use crate::output::{Output, cargo};
use crate::paths;

/// What the panic handler calls, and nobody has.
const MISSING: &str = "a_panic_can_be_reached";

/// Where panics are planted, if they are: what each of the loops waits for.
const PLANTED: [&str; 3] = [
    "tasks::tick::real_time",
    "tasks::host_link::link",
    "tasks::client::client",
];

/// Both halves of the check.
pub(crate) fn run(out: &Output) -> Result<(), String> {
    // With the features of the whole workspace, so that nothing is built twice.
    out.cargo("build --workspace --bin panic-calls")?;
    if !links(out, "no-panic")? {
        search(out, "no-panic-locate", &[])?;
        return Err(
            "a panic can be reached from what bus, host or client send; each call \
                    listed, innermost first, must go (`get`, an iterator, `checked_div`, \
                    a bound that the compiler sees)"
                .to_owned(),
        );
    }
    if links(out, "no-panic-planted")? {
        return Err("planted panics do not keep the image from linking".to_owned());
    }
    search(out, "no-panic-locate,no-panic-planted", &PLANTED)?;
    out.say("    none can be reached; planted ones are found in each loop");
    Ok(())
}

/// Builds the image with these features. False if a panic keeps it from linking.
fn links(out: &Output, features: &str) -> Result<bool, String> {
    out.say(&format!("    no-panic, with {features}"));
    let output = cargo(
        "build --quiet --profile firmware --package armbridge-firmware \
         --target thumbv7em-none-eabihf --bin no-panic --features",
    )
    .arg(features)
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

/// Lists the panics in the image with these features, which has a handler; there must be
/// one in each of `functions`.
fn search(out: &Output, features: &str, functions: &[&str]) -> Result<(), String> {
    if !links(out, features)? {
        return Err(format!("with {features}, {MISSING} is still called"));
    }
    let target = paths::target();
    let mut search = Command::new(target.join("debug/panic-calls"));
    search
        .arg(target.join("thumbv7em-none-eabihf/firmware/no-panic"))
        .args(functions);
    out.run(&mut search)
}
