//! Files in folders of their own, and what comes of them.

use std::fs;

use armbridge_link::message::{Controller, Gains};

use super::*;

/// A configuration from this text, with these variables.
fn config(text: &str, variables: &[(&str, &str)]) -> Result<Config, ConfigError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(FILE_NAME);
    fs::write(&path, text).unwrap();
    Config::of(Some(&path), |variable| {
        let (_, value) = variables.iter().find(|(name, _)| *name == variable)?;
        Some((*value).to_owned())
    })
}

#[test]
fn options_go_before_environment_before_file_before_defaults() {
    let none = Config::of(None, |_| None).unwrap();
    assert_eq!(none.link(None).unwrap(), BoardUri::Sim);
    assert_eq!(none.out(None), Path::new("runs"));
    assert_eq!(none.patience(), Duration::from_secs(10));
    assert!(
        none.in_force()
            .iter()
            .all(|own| own.source == Source::Default)
    );

    let text = "link = 'usb:A'\npatience_s = 3\nout = 'here'\n[record]\ncsv = false\n";
    let file = config(text, &[]).unwrap();
    assert_eq!(file.link(None).unwrap().to_string(), "usb:A");
    assert_eq!(file.out(None), file.file().unwrap().with_file_name("here"));
    assert_eq!(file.patience(), Duration::from_secs(3));
    assert!(!file.writes_csv() && file.draws_plots());

    let variables = [("ARMBRIDGE_LINK", "usb:B"), ("ARMBRIDGE_OUT", "there")];
    let both = config(text, &variables).unwrap();
    assert_eq!(both.link(None).unwrap().to_string(), "usb:B");
    assert_eq!(both.out(None), Path::new("there"));
    let sources: Vec<String> = both
        .in_force()
        .iter()
        .map(|own| {
            let source = own.source.to_string();
            source.rsplit('/').next().unwrap_or_default().to_owned()
        })
        .collect();
    let expected = [
        "ARMBRIDGE_LINK",
        "armbridge.toml:2",
        "ARMBRIDGE_OUT",
        "armbridge.toml:5",
        "default",
    ];
    assert_eq!(sources, expected);
    assert_eq!(both.link(Some(&BoardUri::Sim)).unwrap(), BoardUri::Sim);
    assert_eq!(both.out(Some(Path::new("x"))), Path::new("x"));
}

#[test]
fn the_nearest_file_upward_is_found() {
    let top = tempfile::tempdir().unwrap();
    let deep = top.path().join("a/b");
    fs::create_dir_all(&deep).unwrap();
    let file = top.path().join("a").join(FILE_NAME);
    fs::write(&file, "").unwrap();
    fs::write(top.path().join(FILE_NAME), "").unwrap();
    assert_eq!(find_file(&deep), Some(file));
    // A folder of that name is a mistake.
    let wrong = deep.join(FILE_NAME);
    fs::create_dir(&wrong).unwrap();
    assert_eq!(find_file(&deep).as_ref(), Some(&wrong));
    let error = Config::of(Some(&wrong), |_| None).unwrap_err();
    assert!(error.to_string().contains("cannot read"), "{error}");
}

#[test]
fn what_the_file_says_for_the_board_replaces_what_it_has() {
    let text = "[controller]\nr = [5, 5]\nq = [30, 30, 0.3, 0.3]\n[limits]\nhold_ms = 80\n";
    let config = config(text, &[]).unwrap();
    assert!(config.has_settings());
    let mut base = Settings::default();
    base.limits.silence_ms = 400;
    let settings = config.settings(base).unwrap();
    let mut expected = base;
    expected.limits.hold_ms = 80;
    expected.setup.controller = Controller::StateFeedback(Gains::Design {
        q: [30.0, 30.0, 0.3, 0.3],
        r: [5.0, 5.0],
    });
    assert_eq!(settings, expected);
    let sources = config.in_force();
    assert_eq!(sources.len(), KEYS.len() + 3);

    base.setup.controller = Controller::StateFeedback(Gains::Paper);
    let error = config.settings(base).unwrap_err().to_string();
    let words = "armbridge.toml:3:1: `controller.q` goes with controller.kind = \"lqr\"";
    assert!(error.contains(words), "{error}");
}

#[test]
fn mistakes_are_told_with_their_place() {
    for (text, words) in [
        (
            "limk = 'sim:'",
            "toml:1:1: there is no key `limk`; is it `link`?",
        ),
        (
            "\n[limits]\n hold = 3",
            "toml:3:2: there is no key `limits.hold`; is it",
        ),
        ("zq = 3", "`armbridge config --explain` lists all"),
        ("link = 'sam:'", "toml:1:8: `link` takes usb:"),
        ("link = 3", "toml:1:8: `link` takes usb:"),
        (
            "patience_s = -1",
            "toml:1:14: `patience_s` takes a number from 0 to 86400",
        ),
        (
            "[record]\ncsv = 1",
            "toml:2:7: `record.csv` takes true or false",
        ),
        (
            "[limits]\nhold_ms = 9999",
            "toml:2:11: `limits.hold_ms` cannot be 9999: it takes an integer from 0 to 2000",
        ),
        // Numbers of a kind that the file does not choose are checked all the same.
        (
            "[controller]\ndamping = [0, 1]",
            "toml:2:11: `controller.damping` cannot be",
        ),
        ("controller = 3", "there is no key `controller`"),
        ("link = = 3", "toml:1:8: "),
    ] {
        let error = config(text, &[]).unwrap_err().to_string();
        assert!(error.contains(words), "{text}: {error}");
        assert!(!error.contains('\n'), "{error}");
    }
    let error = config("", &[("ARMBRIDGE_LINK", "sam:")]).unwrap_err();
    let words = "ARMBRIDGE_LINK=sam: in the environment: expected usb:";
    assert!(error.to_string().contains(words), "{error}");
    let held = config("[limits]\nhold_ms = 600", &[]).unwrap();
    let error = held.settings(Settings::default()).unwrap_err().to_string();
    assert!(
        error.contains("`limits.hold_ms` (600) is longer"),
        "{error}"
    );
}

#[test]
fn the_explanation_is_a_file_that_says_nothing_and_without_its_marks_the_defaults() {
    let text = explain();
    assert_eq!(toml::from_str::<toml::Table>(&text), Ok(toml::Table::new()));
    assert!(
        text.lines().all(|line| line.chars().count() <= 100),
        "{text}"
    );

    // `# x = 1` sets x, `## ...` is its meaning.
    let lines: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("# "))
        .collect();
    // Of several kinds, a file can have one: each key is taken alone, as it stands.
    let everything: toml::Table = toml::from_str(&lines.join("\n")).unwrap();
    let document = Document::parse(Path::new("x"), lines.join("\n")).unwrap();
    check_keys(&document).unwrap();
    for key in KEYS {
        assert_eq!(document.get(key.key).unwrap().value, key.default_value());
    }
    for parameter in params::all() {
        let entry = document.get(parameter.key).unwrap();
        assert_eq!(Some(&entry.value), parameter.default_value().as_ref());
    }
    assert_eq!(document.entries().count(), KEYS.len() + params::all().len());
    assert_eq!(everything.len(), 3 + 9);
    // Values of the default kinds are the default settings.
    let in_use = params::pairs(&Settings::default());
    let table = params::to_table(in_use);
    let mut settings = Settings::default();
    settings.limits.hold_ms = 1;
    params::apply_table(&mut settings, &table).unwrap();
    assert_eq!(settings, Settings::default());
}
