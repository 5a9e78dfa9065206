//! Lays out the image for the board of this build. The memory map is
//! `memory.x` at the root of the project.

use std::{env, error::Error, fs, path::PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let has = |feature| env::var_os(feature).is_some();
    let emulated = has("CARGO_FEATURE_MPS2_AN386");
    let real = has("CARGO_FEATURE_FEATHER_F405");
    if emulated && real {
        return Err("choose one board: their memory maps differ".into());
    }
    if !emulated && !real {
        // The library alone, on the host.
        return Ok(());
    }
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?).join("..");
    // With these, cargo's list of the image's sources is complete: `emulate:` compares it
    // with the image.
    for path in [
        "../memory.x",
        "../Cargo.toml",
        "../Cargo.lock",
        "../.cargo/config.toml",
        "../shared/Cargo.toml",
        "Cargo.toml",
        "build.rs",
    ] {
        println!("cargo:rerun-if-changed={path}");
    }
    println!("cargo:rustc-link-search={}", root.display());
    if emulated {
        println!("cargo:rustc-link-arg-bins=--defsym=_flash_origin=0");
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
