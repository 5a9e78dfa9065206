//! The scenarios that ship: the files of `host/scenarios`, in the program itself.

use std::path::PathBuf;

/// A scenario that ships.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// As `armbridge run` takes it.
    pub name: &'static str,
    /// The file.
    pub text: &'static str,
}

impl Shipped {
    /// The one of this name.
    pub fn find(name: &str) -> Option<&'static Self> {
        SHIPPED.iter().find(|shipped| shipped.name == name)
    }

    /// Where it is in the project.
    pub fn file(&self) -> PathBuf {
        format!("host/scenarios/{}.toml", self.name).into()
    }
}

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        &[$(Shipped {
            name: $name,
            text: include_str!(concat!("../../../scenarios/", $name, ".toml")),
        }),*]
    };
}

/// All of them, in the order in which they are listed.
pub const SHIPPED: &[Shipped] = shipped![
    "demo",
    "upright",
    "push",
    "pick",
    "sinusoid",
    "chirp",
    "stream",
    "hold",
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
