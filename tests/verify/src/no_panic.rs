//! Links the image in which no panic may be left, `firmware/src/bin/no-panic`.
//!
//! If it does not link, the same image with a panic handler is searched for the calls
//! that lead to it (`tests/panic-calls`). To show that the check can fail, panics are
//! planted: they must keep the image from linking, and be found in each of the three
//! loops.

use std::process::Command;

use crate::output::{Output, cargo};
use crate::paths;

/// Symbol that the panic handler calls and that is defined nowhere.
const MISSING: &str = "a_panic_can_be_reached";

/// Functions with a planted panic: one that each loop waits for.
const PLANTED: [&str; 3] = [
    "tasks::tick::RealTimeLoop",
    "tasks::host_link::link",
    "tasks::client::client",
];

/// Links the image without and with planted panics.
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
    out.line("    none can be reached; planted ones are found in each loop");
    Ok(())
}

/// Builds the image with these features. False if a panic keeps it from linking.
fn links(out: &Output, features: &str) -> Result<bool, String> {
    out.line(&format!("    no-panic, with {features}"));
    let output = cargo(
        "build --quiet --profile firmware --package armbridge-firmware \
         --target thumbv7em-none-eabihf --bin no-panic --features",
    )
    .arg(features)
    .output()
    .map_err(|e| format!("cannot start cargo: {e}"))?;
    let errors = String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        Ok(true)
    } else if errors.contains(&format!("undefined symbol: {MISSING}")) {
        Ok(false)
    } else {
        Err(format!("the image does not build:\n{errors}"))
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
