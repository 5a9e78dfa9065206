//! Steps on the images of all boards.

use armbridge_verify::boards::BOARDS;
use armbridge_verify::{TARGET, image_arguments};

use crate::output::Output;

/// Builds all images, and the one that counts instructions.
pub(crate) fn build(out: &Output) -> Result<(), String> {
    for board in BOARDS {
        out.cargo(&image_arguments("build", board))?;
    }
    out.cargo("build-instructions")
}

/// Checks all images, and shared code by itself without the standard library.
pub(crate) fn lint(out: &Output) -> Result<(), String> {
    for board in BOARDS {
        let also = if board.chip.is_none() {
            " --bin instruction-count"
        } else {
            ""
        };
        let arguments = image_arguments("clippy", board);
        out.cargo(&format!("{arguments}{also} -- -D warnings"))?;
    }
    for package in [
        "armbridge-firmware --features no-panic --bin no-panic",
        "armbridge-board",
    ] {
        out.cargo(&format!(
            "clippy --profile firmware --package {package} --target {TARGET} -- -D warnings"
        ))?;
    }
    Ok(())
}
