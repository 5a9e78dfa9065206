use std::path::PathBuf;

use armbridge_servo::protocol2::model;

use super::*;

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../plants")
        .join(name)
}

#[test]
fn default_toml_is_the_default_and_has_every_key() {
    let path = shipped("default.toml");
    let file = PlantFile::read(&path).unwrap();
    assert_eq!(file.config([9.0; JOINTS]), PlantConfig::default());
    let code_table: toml::Table = serde_json::from_value(
        serde_json::to_value(PlantFile::from_config(&PlantConfig::default())).unwrap(),
    )
    .unwrap();
    let file_table: toml::Table = toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let keys = |table: &toml::Table| {
        let within = |value: &toml::Value| value.as_table().map(|t| t.keys().cloned().collect());
        let keys: Vec<(String, Option<Vec<String>>)> = table
            .iter()
            .map(|(key, value)| (key.clone(), within(value)))
            .collect();
        keys
    };
    assert_eq!(keys(&file_table), keys(&code_table));
}

/// The parser and the table that explains it have the same keys, and defaults are in range.
#[test]
fn the_table_has_the_keys_that_the_parser_takes() {
    let file = PlantFile::from_config(&PlantConfig::default());
    let text = toml::to_string(&file).unwrap();
    toml_file::keys::check(&text, &[KEYS]).unwrap();
    let written: toml::Table = toml::from_str(&text).unwrap();
    let mut written_keys = vec!["dead_zone".to_owned(), "input_delay_us".to_owned()];
    for (key, value) in &written {
        written_keys.push(key.clone());
        let inner = value.as_table().into_iter().flatten();
        written_keys.extend(inner.map(|(name, _)| format!("{key}.{name}")));
    }
    let mut known: Vec<&str> = KEYS.keys.iter().map(|key| key.path).collect();
    written_keys.sort_unstable();
    known.sort_unstable();
    assert_eq!(known, written_keys);
}

#[test]
fn virtual_arms_that_ship_are_those_of_the_folder() {
    let entries = std::fs::read_dir(shipped("")).unwrap();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    let mut names: Vec<PathBuf> = PLANTS
        .iter()
        .map(|plant| shipped(&format!("{}.toml", plant.name)))
        .collect();
    files.sort();
    names.sort();
    assert_eq!(files, names);
    for plant in PLANTS {
        PlantFile::load(plant.name).unwrap();
        let about = plant.about();
        assert!((10..=68).contains(&about.chars().count()), "{about}");
    }
}

#[test]
fn every_shipped_arm_can_be_read() {
    for entry in std::fs::read_dir(shipped("")).unwrap() {
        let file = PlantFile::read(&entry.unwrap().path()).unwrap();
        file.config([0.0; JOINTS]);
    }
    let dead = PlantFile::read(&shipped("dead-zone.toml")).unwrap();
    let expected = PlantConfig {
        friction_on: false,
        dead_zone_counts: [PlantConfig::PAPER_DEAD_ZONE_COUNTS; JOINTS],
        initial: State::at_rest(Vector2::new(0.1, 0.2)),
        ..PlantConfig::default()
    };
    assert_eq!(dead.config([0.1, 0.2]), expected);
}

#[test]
fn arms_of_the_x_series_weigh_a_fourth_of_the_stall_torque() {
    for (name, number) in [("xl430", 1060), ("xl330", 1200)] {
        let config = PlantFile::load(name).unwrap().config([0.0; JOINTS]);
        let model = model::find(number).unwrap();
        let stall_nm = f64::from(model.stall_nm);
        let [weight_nm, _] = config.true_arm().weight_nm();
        assert!((4.0 * weight_nm / stall_nm - 1.0).abs() < 0.01, "{name}");
        for joint in config.joints {
            let turn_rad = joint.rad_per_count * f64::from(model.counts_per_turn);
            assert!((turn_rad - core::f64::consts::TAU).abs() < 1e-9, "{name}");
            let full_nm = 1_000.0 / joint.gain_counts_per_nm;
            assert!((full_nm / stall_nm - 1.0).abs() < 1e-3, "{name}");
        }
    }
}

#[test]
fn keys_of_a_file_set_the_configuration() {
    let config = |text: &str| {
        let file: PlantFile = toml::from_str(text).unwrap();
        assert_eq!(file.conflict(), None);
        file.config([0.0; JOINTS])
    };
    let hanging = config("arm.mounting = 'hanging'").arm;
    let mounting = Mounting::Hanging;
    assert_eq!(
        hanging,
        Parameters {
            mounting,
            ..Parameters::paper()
        }
    );
    assert_eq!(config("input_delay_us = 7").input_delay_ns, [7_000; JOINTS]);
    let own = config("joint2.input_delay_us = 7\njoint1.dead_zone_counts = [3, 4]");
    assert_eq!(own.input_delay_ns, [0, 7_000]);
    assert_eq!(own.dead_zone_counts, [[3, 4], [0, 0]]);
    assert_eq!(
        config("dead_zone = false").dead_zone_counts,
        [[0; 2]; JOINTS]
    );
    let paper = config("dead_zone = true").dead_zone_counts;
    assert_eq!(paper, [PlantConfig::PAPER_DEAD_ZONE_COUNTS; JOINTS]);
}

#[test]
fn errors_have_key_line_and_column() {
    let folder = std::env::temp_dir();
    let path = folder.join(format!("armbridge-plant-{}.toml", std::process::id()));
    for (text, at, words) in [
        ("torque_gian = 1", (1, 1), ["torque_gian", "`torque_gain`"]),
        ("[arm]\nl9 = 1", (2, 1), ["l9", "l1"]),
        (
            "[joint1]\n  coulomb_nm = true",
            (2, 16),
            ["coulomb_nm", "a number from 0"],
        ),
        (
            "held = true\ninertia_scale = 0",
            (2, 17),
            ["inertia_scale", "from 0.1 to 10"],
        ),
        (
            "noise_lsb_rms = nan",
            (1, 17),
            ["noise_lsb_rms", "from 0 to 100"],
        ),
        (
            "[joint2]\nstops_rad = [1, -1]",
            (2, 1),
            ["stops_rad", "smallest"],
        ),
        (
            "[joint1]\ndead_zone_counts = [0, 501]",
            (2, 24),
            ["dead_zone_counts", "from 0 to 500"],
        ),
        (
            "held = true\ndead_zone = false\njoint2.dead_zone_counts = [1, 2]",
            (2, 1),
            ["`dead_zone`", "`joint2.dead_zone_counts`"],
        ),
        (
            "input_delay_us = 1\n[joint1]\ninput_delay_us = 1",
            (1, 1),
            ["`input_delay_us`", "`joint1.input_delay_us`"],
        ),
        (
            "[joint2]\ndirection = 'up'",
            (2, 13),
            ["direction", "\"reverse\""],
        ),
    ] {
        std::fs::write(&path, text).unwrap();
        let error = PlantFile::read(&path).unwrap_err();
        let line = error.to_string();
        let DocumentError::Wrong { place, .. } = error else {
            panic!("{line}");
        };
        assert_eq!((place.line, place.column), at, "{line}");
        assert!(words.iter().all(|word| line.contains(word)), "{line}");
        assert!(!line.contains('\n'), "{line}");
    }
    std::fs::remove_file(&path).unwrap();
    assert!(matches!(
        PlantFile::read(&path),
        Err(DocumentError::Read { .. })
    ));
}
