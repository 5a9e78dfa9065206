//! Steps of the host's lane that are more than lines for cargo.

use crate::output::{Output, cargo};

/// The documentation of every crate, warnings being errors. Links to private items are
/// for readers of the source. Examples are named so that dependencies have the features of
/// the steps before.
pub(crate) fn documentation(out: &Output) -> Result<(), String> {
    let mut doc =
        cargo("doc --workspace --no-deps --lib --examples --bin verify --bin panic-calls");
    out.run(doc.env(
        "RUSTDOCFLAGS",
        "-D warnings -A rustdoc::private-intra-doc-links",
    ))
}

/// Every test that is built with the workspace, ignored ones included: what they need is
/// there. Two more at a time than there are processors, because tests on the wall clock and
/// on emulated boards mostly wait: see `.config/nextest.toml`.
pub(crate) fn tests(out: &Output) -> Result<(), String> {
    let processors = std::thread::available_parallelism().map_or(2, usize::from);
    let mut tests = cargo("nextest run --workspace --run-ignored all --test-threads");
    tests.arg((processors + 2).to_string());
    out.run(tests.args(["--filterset", &format!("not ({BOARD_IMAGE})")]))
}

/// Tests that execute the image of a board.
const BOARD_IMAGE: &str = "binary(emulator) & test(/^board_image::/)";

/// Runs the board's image on the emulated chip: a step of its own, for its time.
pub(crate) fn board_image(out: &Output) -> Result<(), String> {
    let mut tests = cargo("nextest run --package armbridge-tests --run-ignored all");
    out.run(tests.args(["--filterset", BOARD_IMAGE]))
}
