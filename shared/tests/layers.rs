//! The order of modules: which may import which.

use std::fs;
use std::path::{Path, PathBuf};

/// All source files in this folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths
        .flat_map(|path| {
            if path.is_dir() {
                sources(&path)
            } else {
                vec![path]
            }
        })
        .collect()
}

/// Servo knows neither link nor anything above it, and of the actuator the PWM.
#[test]
fn servo_is_below_the_link() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/servo");
    for path in sources(&folder) {
        let text = fs::read_to_string(&path).expect("text");
        let code = text
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"));
        for import in code.flat_map(|line| line.split("crate::").skip(1)) {
            let allowed = ["servo", "JOINTS", "actuator::Pwm;"];
            let is_allowed = allowed.iter().any(|start| import.starts_with(start));
            assert!(is_allowed, "{} imports {import}", path.display());
        }
    }
}
