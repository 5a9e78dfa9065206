//! The safety case names tests and steps as evidence: each exists, and the gate runs it.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Sources in and under a folder, those of other projects left out.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.ends_with("target") {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn every_test_that_the_safety_case_names_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let case = fs::read_to_string(root.join("firmware/SAFETY.md")).unwrap();
    let mut files = Vec::new();
    for folder in ["firmware", "host", "shared", "tests"] {
        sources(&root.join(folder), &mut files);
    }
    // Tests that run with each change: no campaigns, and no other functions of that name.
    files.retain(|file| !file.starts_with(root.join("tests/campaign")));
    let code: Vec<String> = files
        .iter()
        .map(|file| fs::read_to_string(file).unwrap())
        .collect();
    let tests: HashSet<&str> = code
        .iter()
        .flat_map(|code| code.split("#[test]").skip(1))
        .filter_map(|test| test.split_once("fn ")?.1.split_once('('))
        .map(|(name, _)| name)
        .collect();
    let is_name = |word: &&str| {
        let is_snake = |c: char| c.is_ascii_lowercase() || c == '_';
        word.matches('_').count() >= 2 && word.chars().all(is_snake)
    };
    let named: Vec<&str> = case.split('`').filter(is_name).collect();
    assert!(named.len() > 15, "{named:?}");
    for name in named {
        assert!(
            tests.contains(name),
            "SAFETY.md names {name}, which is no test of the gate"
        );
    }
    let steps = fs::read_to_string(root.join("tests/verify/src/steps.rs")).unwrap();
    for step in case.split("`cargo verify --only ").skip(1) {
        let name = step.split('`').next().unwrap();
        assert!(
            steps.contains(&format!("\"{name}\"")),
            "SAFETY.md names {name}, which is no step"
        );
    }
}
