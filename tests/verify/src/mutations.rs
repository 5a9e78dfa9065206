//! Mutations: changes of the board's code each of which the fault campaign or a test must notice.
//!
//! A judge that passes a board without its guards proves nothing about a board that has them. So
//! each guard of [`MUTATIONS`] is taken out in turn, in a copy of the tracked files, and judged:
//!
//! | judge    | what is built from the copy | a mutation is caught if                            |
//! |----------|-----------------------------|----------------------------------------------------|
//! | campaign | the program                 | at least [`CAUGHT_MIN`] cases fail, or have a wrong name, that do not with the code as it is |
//! | test     | the whole-system tests      | the test with this name fails, and does not with the code as it is |

mod table;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::output::{Output, cargo};
use crate::{paths, tree_copy};
use table::{Cases, Judge, MUTATIONS, Mutation};

/// Cases by which a mutation is caught: one or two may be at a limit that any change of the code
/// crosses.
const CAUGHT_MIN: usize = 3;

/// Crates that neither the board nor the bench is made of: optimising them takes longer than the
/// campaign.
const UNOPTIMISED: [&str; 2] = ["armbridge-analysis", "armbridge-log"];

/// Seeds of the cases that fail, or have a wrong name.
type Failed = BTreeSet<u64>;

/// Tries all mutations. The error names those that nothing notices.
pub(crate) fn run(out: &Output) -> Result<(), String> {
    let copy = Copy::new()?;
    let sound = copy.sound(out)?;
    let mut rows = Vec::new();
    for mutation in MUTATIONS {
        let verdict = copy.verdict_with(mutation, &sound, out)?;
        out.line(&verdict.row(mutation));
        rows.push((mutation, verdict));
    }
    out.line(&format!(
        "\n{:<40}{:<10}cases or test",
        "mutation", "caught by"
    ));
    for (mutation, verdict) in &rows {
        out.line(&verdict.row(mutation));
    }
    let missed = rows.iter().filter(|(_, verdict)| !verdict.is_caught());
    let missed: Vec<&str> = missed.map(|(mutation, _)| mutation.name).collect();
    if missed.is_empty() {
        Ok(())
    } else {
        Err(format!("nothing catches: {}", missed.join(", ")))
    }
}

/// Verdict on a mutation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// Cases that fail with it only.
    Cases(usize),
    /// Whether this test fails with it.
    Test {
        name: &'static str,
        has_failed: bool,
    },
}

impl Verdict {
    fn is_caught(self) -> bool {
        match self {
            Self::Cases(count) => count >= CAUGHT_MIN,
            Self::Test { has_failed, .. } => has_failed,
        }
    }

    /// The line of the table.
    fn row(self, mutation: &Mutation) -> String {
        let (judge, figure) = match self {
            Self::Cases(count) => ("campaign", count.to_string()),
            Self::Test { name, .. } => ("test", name.to_owned()),
        };
        let by = if self.is_caught() { judge } else { "NOTHING" };
        format!("{:<40}{by:<10}{figure}", mutation.name)
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
        tree_copy::make(&copy.tree)?;
        Ok(copy)
    }

    /// Cases that fail with the code as it is.
    ///
    /// # Errors
    /// A test fails with it.
    fn sound(&self, out: &Output) -> Result<BTreeMap<Cases, Failed>, String> {
        let mut sound = BTreeMap::new();
        for program in [Program::Campaign, Program::Tests] {
            self.build(program, out)?;
        }
        for mutation in MUTATIONS {
            match mutation.judge {
                Judge::Campaign(cases) if !sound.contains_key(cases) => {
                    let failed = self.campaign(cases)?;
                    let (cases_line, count) = (cases.join(" "), failed.len());
                    out.line(&format!("unmutated, {cases_line}: {count} fail"));
                    sound.insert(cases, failed);
                }
                Judge::Test(name) if self.has_failed(name)? => {
                    return Err(format!("the test {name} fails without a mutation"));
                }
                Judge::Campaign(_) | Judge::Test(_) => {}
            }
        }
        Ok(sound)
    }

    /// The verdict on a mutation, which is undone afterwards.
    fn verdict_with(
        &self,
        mutation: &Mutation,
        sound: &BTreeMap<Cases, Failed>,
        out: &Output,
    ) -> Result<Verdict, String> {
        let path = self.tree.join(mutation.file);
        let text = mutation.read(&self.tree)?;
        let write = |text: &str| fs::write(&path, text).map_err(|e| format!("{e}"));
        write(&mutation.apply(&text)?)?;
        let verdict = self.verdict(mutation.judge, sound, out);
        write(&text)?;
        verdict.map_err(|why| format!("mutation `{}`: {why}", mutation.name))
    }

    fn verdict(
        &self,
        judge: Judge,
        sound: &BTreeMap<Cases, Failed>,
        out: &Output,
    ) -> Result<Verdict, String> {
        match judge {
            Judge::Campaign(cases) => {
                self.build(Program::Campaign, out)?;
                let failed = self.campaign(cases)?;
                let before = sound.get(cases).ok_or("cases that were not run before")?;
                Ok(Verdict::Cases(failed.difference(before).count()))
            }
            Judge::Test(name) => {
                self.build(Program::Tests, out)?;
                let has_failed = self.has_failed(name)?;
                Ok(Verdict::Test { name, has_failed })
            }
        }
    }

    /// Cargo for the copy, with this subcommand and its arguments.
    fn cargo(&self, arguments: &str) -> Command {
        let mut command = cargo(arguments);
        command
            .arg("--manifest-path")
            .arg(self.tree.join("Cargo.toml"))
            .arg("--target-dir")
            .arg(&self.target)
            // Few lines change from one build to the next.
            .env("CARGO_INCREMENTAL", "1")
            .env_remove("CARGO_PROFILE_DEV_CODEGEN_UNITS");
        for package in UNOPTIMISED {
            let optimisation = format!("profile.dev.package.{package}.opt-level=0");
            command.arg("--config").arg(optimisation);
        }
        command
    }

    /// Builds a program.
    fn build(&self, program: Program, out: &Output) -> Result<(), String> {
        out.run(&mut self.cargo(match program {
            Program::Campaign => "build --package armbridge --bin armbridge",
            Program::Tests => "test --no-run --package armbridge-tests --test sim",
        }))
    }

    /// Runs the test with this name, and returns whether it fails.
    fn has_failed(&self, name: &str) -> Result<bool, String> {
        let mut test = self.cargo("test --package armbridge-tests --test sim");
        let test = test.args(["--", "--exact", name]).stdin(Stdio::null());
        let output = test
            .output()
            .map_err(|e| format!("cannot start the test {name}: {e}"))?;
        let text = String::from_utf8_lossy(&output.stdout);
        match tests_run(&text) {
            Some(1) => Ok(!output.status.success()),
            Some(count) => Err(format!("{count} tests have the name {name}")),
            None => Err(format!("the tests do not start for {name}")),
        }
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

/// Programs that are built from the copy.
#[derive(Clone, Copy)]
enum Program {
    /// The program that runs the campaign.
    Campaign,
    /// The whole-system tests.
    Tests,
}

/// Number of tests that a test program has begun to run, from its output.
fn tests_run(output: &str) -> Option<usize> {
    let counts = output
        .lines()
        .find_map(|line| line.strip_prefix("running "));
    counts?.split(' ').next()?.parse().ok()
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

    #[test]
    fn tests_are_counted() {
        let output = |count| format!("\nrunning {count}\ntest a::b ... FAILED\n");
        assert_eq!(tests_run(&output("1 test")), Some(1));
        assert_eq!(tests_run(&output("0 tests")), Some(0));
        assert_eq!(tests_run("error: no test target\n"), None);
    }

    #[test]
    fn a_mutation_is_caught_by_enough_cases_or_by_its_test() {
        let test = |has_failed| Verdict::Test {
            name: "a::b",
            has_failed,
        };
        for (verdict, is_caught) in [
            (Verdict::Cases(CAUGHT_MIN), true),
            (Verdict::Cases(CAUGHT_MIN - 1), false),
            (test(true), true),
            (test(false), false),
        ] {
            assert_eq!(verdict.is_caught(), is_caught, "{verdict:?}");
        }
    }
}
