//! Lays out the image for the board of this build, by its row in `boards.rs`. The memory map is
//! `memory.x` at the root of the project.

use std::error::Error;
use std::path::PathBuf;
use std::{env, fs};

#[expect(unreachable_pub, reason = "the gate's library has it too")]
mod boards;
use boards::{BOARDS, BoardRow};

fn main() -> Result<(), Box<dyn Error>> {
    let is_chosen = |board: &&BoardRow| {
        let feature = board.name.to_uppercase().replace('-', "_");
        env::var_os(format!("CARGO_FEATURE_{feature}")).is_some()
    };
    let mut chosen = BOARDS.iter().filter(is_chosen);
    let Some(board) = chosen.next() else {
        // The library alone, on the host.
        return Ok(());
    };
    if let Some(other) = chosen.next() {
        return Err(format!("choose one board: {} or {}", board.name, other.name).into());
    }
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?).join("..");
    // With these, cargo's list of the image's sources is complete: `emulate:` compares it
    // with the image.
    for path in [
        "../memory.x",
        "../Cargo.toml",
        "../Cargo.lock",
        "../.cargo/config.toml",
        "../shared/board/Cargo.toml",
        "../shared/control/Cargo.toml",
        "../shared/link/Cargo.toml",
        "../shared/servo/Cargo.toml",
        "Cargo.toml",
        "build.rs",
        "boards.rs",
    ] {
        println!("cargo:rerun-if-changed={path}");
    }
    println!("cargo:rustc-link-search={}", root.display());
    let (origin, kib) = (board.flash_origin, board.program_kib);
    println!("cargo:rustc-link-arg-bins=--defsym=_flash_origin={origin}");
    println!("cargo:rustc-link-arg-bins=--defsym=_flash_length={kib}K");
    if board.chip.is_none() {
        // cortex-m-rt asks for weak names of the interrupt handlers here; the
        // emulated board's vectors name theirs directly.
        let out = PathBuf::from(env::var("OUT_DIR")?);
        fs::write(out.join("device.x"), "")?;
        println!("cargo:rustc-link-search={}", out.display());
    }
    // What the firmware logs is rare and worth knowing.
    println!("cargo:rustc-env=DEFMT_LOG=info");
    // Sections stay at their addresses in the map, without padding to pages.
    println!("cargo:rustc-link-arg-bins=--nmagic");
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    Ok(())
}
