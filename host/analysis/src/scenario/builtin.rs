//! Built-in scenarios: the files of `host/scenarios`, compiled into the program.

use std::path::PathBuf;

/// A built-in scenario.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// Name for `armbridge run`.
    pub name: &'static str,
    /// Text of the file.
    pub text: &'static str,
}

impl Builtin {
    /// The built-in scenario with a name.
    pub fn find(name: &str) -> Option<&'static Self> {
        BUILTINS.iter().find(|builtin| builtin.name == name)
    }

    /// Path of the file in the project.
    pub fn file(&self) -> PathBuf {
        format!("host/scenarios/{}.toml", self.name).into()
    }
}

macro_rules! builtin {
    ($($name:literal),* $(,)?) => {
        &[$(Builtin {
            name: $name,
            text: include_str!(concat!("../../../scenarios/", $name, ".toml")),
        }),*]
    };
}

/// All built-in scenarios in the order of the list.
pub const BUILTINS: &[Builtin] = builtin![
    "demo",
    "upright",
    "push",
    "pendulum",
    "pick",
    "sinusoid",
    "chirp",
    "stream",
    "hold",
    "float",
    "teach",
    "park",
    "friction",
    "free-fall",
    "staircase",
    "sweep",
    "multisine",
    "stiction",
    "identify",
    "hour",
    "paper-upright",
    "paper-observer",
    "paper-free-fall",
    "paper-constant-input",
    "paper-constant-input-2",
    "paper-tracking",
    "paper-pushes",
];
