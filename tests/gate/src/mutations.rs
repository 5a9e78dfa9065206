//! Mutations: changes of the board's code each of which the fault campaign must notice.
//!
//! A judge that passes a board without its guards proves nothing about a board that has them. So
//! each guard of [`MUTATIONS`] is taken out in turn, in a copy of the tracked files; the program
//! is built from it and runs its fault campaign. A mutation is caught if at least
//! [`CAUGHT_MIN`] cases fail, or have a wrong name, that do not with the code as it is.

mod table;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::output::{Output, cargo, printed};
use crate::paths;
use table::{Cases, MUTATIONS, Mutation};

/// Cases by which a mutation is caught: one or two may be at a limit that any change of the code
/// crosses.
const CAUGHT_MIN: usize = 3;

/// Crates of the program that neither the board nor the bench is made of: optimising them takes
/// longer than the campaign.
const UNOPTIMISED: [&str; 2] = ["armbridge-analysis", "armbridge-log"];

/// Seeds of the cases that fail, or have a wrong name.
type Failed = BTreeSet<u64>;

/// Tries all mutations. The error names those that no case notices.
pub(crate) fn run(out: &Output) -> Result<(), String> {
    let copy = Copy::new()?;
    copy.build(out)?;
    let mut sound: BTreeMap<Cases, Failed> = BTreeMap::new();
    for Mutation { cases, .. } in MUTATIONS {
        if !sound.contains_key(cases) {
            let failed = copy.campaign(cases)?;
            out.line(&format!(
                "unmutated, {}: {} fail",
                cases.join(" "),
                failed.len()
            ));
            sound.insert(cases, failed);
        }
    }
    let mut rows = Vec::new();
    for mutation in MUTATIONS {
        let failed = copy.failed_with(mutation, out)?;
        let caught = failed.difference(&sound[mutation.cases]).count();
        rows.push((mutation.name, caught));
        out.line(&format!("{:<40}{caught:>6}", mutation.name));
    }
    out.line(&format!("\n{:<40}{:<12}cases", "mutation", "caught by"));
    for (name, caught) in &rows {
        let by = if *caught < CAUGHT_MIN {
            "NOTHING"
        } else {
            "campaign"
        };
        out.line(&format!("{name:<40}{by:<12}{caught:>5}"));
    }
    let missed = rows.iter().filter(|(_, caught)| *caught < CAUGHT_MIN);
    let missed: Vec<&str> = missed.map(|(name, _)| *name).collect();
    if missed.is_empty() {
        Ok(())
    } else {
        Err(format!("nothing catches: {}", missed.join(", ")))
    }
}

/// A copy of the tracked files, with one folder of builds for all mutations.
struct Copy {
    tree: PathBuf,
    target: PathBuf,
}

impl Copy {
    fn new() -> Result<Self, String> {
        let folder = paths::target().join("mutations");
        let copy = Self {
            tree: folder.join("tree"),
            target: folder.join("target"),
        };
        let files = printed("git ls-files").ok_or("git cannot list the tracked files")?;
        let _ = fs::remove_dir_all(&copy.tree);
        for file in files.lines() {
            let (from, to) = (paths::root().join(file), copy.tree.join(file));
            // A file that was deleted and not yet committed is not there.
            if from.is_file() {
                let parent = to.parent().unwrap_or(&copy.tree);
                fs::create_dir_all(parent)
                    .and_then(|()| fs::copy(&from, &to))
                    .map_err(|e| format!("cannot copy {file}: {e}"))?;
            }
        }
        Ok(copy)
    }

    /// Seeds that fail with a mutation, which is undone afterwards.
    fn failed_with(&self, mutation: &Mutation, out: &Output) -> Result<Failed, String> {
        let path = self.tree.join(mutation.file);
        let sound = mutation.read(&self.tree)?;
        let write = |text: &str| fs::write(&path, text).map_err(|e| format!("{e}"));
        write(&mutation.apply(&sound)?)?;
        let failed = self.build(out).and_then(|()| self.campaign(mutation.cases));
        write(&sound)?;
        failed.map_err(|why| format!("mutation `{}`: {why}", mutation.name))
    }

    /// Builds the program.
    fn build(&self, out: &Output) -> Result<(), String> {
        let mut build = cargo("build --package armbridge --bin armbridge --manifest-path");
        build
            .arg(self.tree.join("Cargo.toml"))
            .arg("--target-dir")
            .arg(&self.target)
            // Few lines change from one build to the next.
            .env("CARGO_INCREMENTAL", "1")
            .env_remove("CARGO_PROFILE_DEV_CODEGEN_UNITS");
        for package in UNOPTIMISED {
            build.args([
                "--config",
                &format!("profile.dev.package.{package}.opt-level=0"),
            ]);
        }
        out.run(&mut build)
    }

    /// Runs these cases, and returns the seeds of those that fail.
    fn campaign(&self, cases: Cases) -> Result<Failed, String> {
        let campaign = Command::new(self.target.join("debug/armbridge"))
            .args(["fault-campaign", "--json"])
            .args(cases)
            .stdin(Stdio::null())
            // Each panic of a mutated board would fill the log; its case has failed.
            .stderr(Stdio::null())
            .output()
            .map_err(|e| format!("cannot start the campaign: {e}"))?;
        let report = String::from_utf8_lossy(&campaign.stdout);
        match campaign.status.code() {
            Some(0 | 1) => Ok(failed_seeds(&report)),
            _ => Err(format!("the campaign ended with {}", campaign.status)),
        }
    }
}

/// Seeds in the report of a campaign, which names only those that fail.
fn failed_seeds(json: &str) -> Failed {
    let after = json.split("\"seed\":").skip(1);
    let digits = after.filter_map(|text| text.split(|c: char| !c.is_ascii_digit()).next());
    digits.filter_map(|digits| digits.parse().ok()).collect()
}

impl Mutation {
    /// The file that it changes, of this tree.
    fn read(&self, tree: &Path) -> Result<String, String> {
        let file = self.file;
        fs::read_to_string(tree.join(file)).map_err(|e| format!("cannot read {file}: {e}"))
    }

    /// The file's text with the change.
    fn apply(&self, text: &str) -> Result<String, String> {
        match text.matches(self.find).count() {
            1 => Ok(text.replace(self.find, self.replacement)),
            count => Err(format!(
                "mutation `{}` no longer applies: its text occurs {count} times in {}",
                self.name, self.file
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mutation_applies() {
        for mutation in MUTATIONS {
            let text = mutation.read(&paths::root()).unwrap();
            assert_ne!(mutation.apply(&text).unwrap(), text, "{}", mutation.name);
        }
    }

    #[test]
    fn failed_seeds_are_read() {
        let json = r#"{"failures":[{"seed":17,"kinds":[]}],"unguarded":[{"seed":4},{"seed":17}]}"#;
        assert_eq!(failed_seeds(json), Failed::from([4, 17]));
    }
}
