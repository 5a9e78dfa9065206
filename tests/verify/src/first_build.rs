//! The first build is quick, and stays: cargo's own account of what a plain `cargo build`
//! compiles, compared with what the full build and the tests do.

use std::collections::BTreeSet;
use std::fs;

use crate::output::cargo;
use crate::paths;

/// Crates that take long to build, or bring many others, for jobs that few have.
const HEAVY: [&str; 11] = [
    "addr2line",
    "chrono",
    "defmt-decoder",
    "foxglove",
    "object",
    "parquet",
    "proptest",
    "regex",
    "tokio",
    "tungstenite",
    "zerocopy",
];

/// Crates that may have other features in other builds: small, and below little more than
/// crates of the workspace.
const BUILT_AGAIN: [&str; 1] = ["rand"];

/// Packages of a build, a line each with version and features.
fn tree(arguments: &str) -> BTreeSet<String> {
    let mut cargo = cargo("tree --offline --locked --prefix none --no-dedupe --format {p}|{f}");
    let output = cargo.args(arguments.split(' ')).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let text = String::from_utf8(output.stdout).unwrap();
    let is_external = |line: &&str| !line.contains("armbridge") && !line.is_empty();
    text.lines()
        .filter(is_external)
        .map(str::to_owned)
        .collect()
}

/// The crates that a plain `cargo build` compiles.
fn first_build() -> BTreeSet<String> {
    tree("--edges normal,build")
}

fn name(line: &str) -> &str {
    line.split(' ').next().unwrap_or_default()
}

#[test]
fn it_has_nothing_heavy_that_the_main_job_does_not_use() {
    let crates = first_build();
    let heavy: Vec<_> = crates
        .iter()
        .filter(|line| HEAVY.contains(&name(line)))
        .collect();
    assert!(heavy.is_empty(), "{heavy:?}");
    let of_name = |wanted: &str| crates.iter().filter(|line| name(line) == wanted).count();
    assert_eq!(of_name("nalgebra"), 1);
    // As many as it needs; each heavy crate of the full build would show in the next test.
    assert!(crates.iter().any(|line| name(line) == "mcap"));
    let full = tree("--edges normal,build --features full");
    for heavy in ["defmt-decoder", "foxglove", "parquet"] {
        assert!(full.iter().any(|line| name(line) == heavy), "{heavy}");
    }
}

/// Otherwise cargo compiles it, and all that depends on it, again for the other build.
#[test]
fn its_crates_have_the_same_features_in_the_full_build_and_in_tests() {
    let first = first_build();
    for others in [
        "--edges normal,build --features full",
        "--edges normal,build,dev --workspace",
    ] {
        let others = tree(others);
        let differ = first.difference(&others);
        let differ: Vec<_> = differ
            .filter(|line| !BUILT_AGAIN.contains(&name(line)))
            .collect();
        assert!(differ.is_empty(), "{differ:#?}: see host/cli/Cargo.toml");
    }
}

/// All Rust sources of a folder, as one text.
fn sources(folder: &std::path::Path, text: &mut String) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, text);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            text.push_str(&fs::read_to_string(path).unwrap());
        }
    }
}

#[test]
fn each_dependency_of_the_host_crates_is_used() {
    for package in ["analysis", "cli", "client", "log", "paper", "sim"] {
        let folder = paths::root().join("host").join(package);
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        let (_, table) = manifest.split_once("\n[dependencies]\n").unwrap();
        let entries = table.lines().take_while(|line| !line.starts_with('['));
        let mut text = String::new();
        sources(&folder.join("src"), &mut text);
        for entry in entries.filter(|line| !line.is_empty() && !line.starts_with('#')) {
            let name = entry.split(['.', ' ']).next().unwrap().replace('-', "_");
            // In a path, an attribute or a `use` of the crate itself.
            let forms = [
                format!("{name}::"),
                format!("use {name};"),
                format!("{name}!"),
            ];
            let is_used = forms.iter().any(|form| text.contains(form));
            assert!(is_used, "host/{package} has no use of {name}");
        }
    }
}
