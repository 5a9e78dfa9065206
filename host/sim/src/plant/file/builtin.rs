//! Virtual arms with a name: the files of `host/plants`, compiled into the program.

use std::path::PathBuf;

/// A virtual arm that ships.
#[derive(Clone, Copy, Debug)]
pub struct BuiltinPlant {
    /// Its name.
    pub name: &'static str,
    /// Text of its file.
    pub text: &'static str,
}

impl BuiltinPlant {
    /// The one with this name.
    pub fn find(name: &str) -> Option<&'static Self> {
        PLANTS.iter().find(|plant| plant.name == name)
    }

    /// Path of the file in the project.
    pub fn file(&self) -> PathBuf {
        format!("host/plants/{}.toml", self.name).into()
    }

    /// Description: the comment at the beginning of the file, up to its first full stop.
    pub fn about(&self) -> String {
        let lines = self.text.lines();
        let words: Vec<&str> = lines.map_while(|line| line.strip_prefix("# ")).collect();
        let words = words.join(" ");
        words
            .split_once(". ")
            .map_or(words.trim_end_matches('.'), |(first, _)| first)
            .into()
    }
}

macro_rules! plants {
    ($($name:literal),* $(,)?) => {
        &[$(BuiltinPlant {
            name: $name,
            text: include_str!(concat!("../../../../plants/", $name, ".toml")),
        }),*]
    };
}

/// All of them in the order of the list.
pub const PLANTS: &[BuiltinPlant] = plants![
    "default",
    "dead-zone",
    "heavy",
    "late",
    "pendulum",
    "rough",
    "weak-motor",
    "xl330",
    "xl430",
];
