//! `export mjcf` and `export urdf`: the arm for simulators.

use std::fs;

use super::folder;
use super::program::{armbridge, printed};

#[test]
fn the_arm_of_a_log_a_file_or_a_plant_becomes_a_robot_description() {
    let folder = folder("robot-description");
    // A board whose settings have another length than the paper's arm.
    printed(&folder, &["run", "upright", "--set", "arm.l1_m=0.12"], 0);
    let of_log = printed(&folder, &["export", "mjcf", "--out", "-"], 0);
    assert!(
        of_log.contains("<mujoco") && of_log.contains(r#"pos="0 0 0.12""#),
        "{of_log}"
    );
    // The same arm as parameters in a file.
    fs::write(folder.join("arm.toml"), "[arm]\nl1_m = 0.12\n").unwrap();
    let of_file = printed(&folder, &["export", "mjcf", "arm.toml", "--out", "-"], 0);
    let without_friction = |text: &str| -> Vec<String> {
        let lines = text.lines().filter(|line| !line.contains("frictionloss"));
        lines.map(ToOwned::to_owned).collect()
    };
    assert_eq!(without_friction(&of_log), without_friction(&of_file));
    assert_eq!(
        printed(&folder, &["export", "urdf", "arm.toml"], 0),
        "arm.urdf\n"
    );
    assert_eq!(
        printed(&folder, &["export", "mjcf", "heavy"], 0),
        "heavy.xml\n"
    );
    // A plant file has more: its friction and its stops.
    let heavy = printed(&folder, &["plants", "heavy"], 0);
    fs::write(folder.join("mine.toml"), heavy).unwrap();
    printed(&folder, &["export", "mjcf", "mine.toml"], 0);
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!(read("heavy.xml"), read("mine.xml"));
    fs::write(folder.join("rotor.toml"), "[arm]\ni1x_kg_m2 = 0.001\n").unwrap();
    for (source, words) in [
        ("none.toml", "none.toml"),
        ("rotor.toml", "write it as mjcf"),
        ("nowhere", "there is no such file"),
    ] {
        let output = armbridge(&folder, &["export", "urdf", source]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(words), "{text}");
    }
}
