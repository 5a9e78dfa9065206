//! The paper's two experiments as the program records them, on the bench's arm and others.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use serde_json::Value;

use crate::paths::run_folder;

/// The arm that gives the paper's two values.
pub const DRY: &str = "
[bench.plant.arm]
b1 = 0.239
[bench.plant.joint1]
coulomb_nm = 0.107285
static_nm = 0.134
";
/// One that has no dry friction.
pub const SMOOTH: &str = "
[bench.plant]
friction = false
";

/// A folder of one test, and the program in it.
pub struct Place {
    program: PathBuf,
    /// Where it runs.
    pub folder: PathBuf,
}

impl Place {
    /// With this program, in a folder that exists.
    pub fn new(program: impl Into<PathBuf>, folder: PathBuf) -> Self {
        Self {
            program: program.into(),
            folder,
        }
    }

    /// Runs the program.
    pub fn run(&self, args: &[&str]) -> Output {
        let mut command = Command::new(&self.program);
        let command = command.args(args).current_dir(&self.folder);
        command.env_remove("ARMBRIDGE_LINK").output().unwrap()
    }

    /// Its standard output.
    pub fn printed(&self, args: &[&str]) -> String {
        let output = self.run(args);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{args:?}: {stderr}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// The same as JSON.
    pub fn json(&self, args: &[&str]) -> Value {
        serde_json::from_str(&self.printed(args)).unwrap()
    }

    /// Records a shipped scenario on an arm of these words; the log's folder.
    pub fn record(&self, scenario: &str, seed: &str, arm: &str, torque: &str) -> String {
        let text = self.printed(&["run", scenario, "--show"]);
        let file = format!("{scenario}.toml");
        fs::write(
            self.folder.join(&file),
            text.replace("-0.3924 }", torque) + arm,
        )
        .unwrap();
        let printed = self.printed(&["run", &file, "--seed", seed]);
        run_folder(&printed).to_owned()
    }
}
