//! `armbridge merge`: parts of a fault campaign, run apart.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::folder;

fn run(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_armbridge"));
    command.args(args).current_dir(folder).output().unwrap()
}

#[test]
fn parts_are_the_whole_to_the_byte() {
    let folder = folder("merge");
    let campaign = |seeds: &str| run(&folder, &["fault-campaign", "--seeds", seeds, "--json"]);
    let whole = campaign("40");
    for (name, seeds) in [("a.json", "15..40"), ("b.json", "0..15")] {
        fs::write(folder.join(name), campaign(seeds).stdout).unwrap();
    }
    let merged = run(&folder, &["merge", "a.json", "b.json", "--json"]);
    assert_eq!(merged.stdout, whole.stdout);
    assert_eq!(merged.status.code(), whole.status.code());
    let table = run(&folder, &["merge", "a.json", "b.json"]);
    assert_eq!(
        table.stdout,
        run(&folder, &["fault-campaign", "--seeds", "40"]).stdout
    );

    fs::write(folder.join("c.json"), "{}").unwrap();
    for (parts, expected) in [
        (["a.json", "a.json"], "seed 15 is in two parts"),
        (
            ["a.json", "c.json"],
            "c.json: it is no JSON of a fault campaign",
        ),
        (["a.json", "d.json"], "cannot read d.json"),
    ] {
        let output = run(&folder, &[&["merge"][..], &parts].concat());
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.code() == Some(2) && text.contains(expected),
            "{text}"
        );
    }
}
