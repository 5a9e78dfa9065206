//! The steps of `cargo verify`, cheapest first.

use crate::{fuzz, miri, no_panic, setup};

/// Something that must pass.
pub(crate) struct Step {
    /// What `--from` calls it.
    pub(crate) name: &'static str,
    /// What it is for.
    pub(crate) what: &'static str,
    /// What it does.
    pub(crate) work: Work,
}

/// What a step does.
pub(crate) enum Work {
    /// Does this; second, how to do so by hand.
    Do(fn() -> Result<(), String>, &'static str),
    /// Runs cargo with these arguments, single spaces between them.
    Cargo(&'static str),
}

impl Work {
    /// The command that does the same.
    pub(crate) fn command(&self) -> String {
        match self {
            Self::Do(_, by_hand) => (*by_hand).to_owned(),
            Self::Cargo(arguments) => format!("cargo {arguments}"),
        }
    }
}

/// A step that is one cargo command.
const fn cargo(name: &'static str, what: &'static str, arguments: &'static str) -> Step {
    Step {
        name,
        what,
        work: Work::Cargo(arguments),
    }
}

/// Every step, in order.
pub(crate) const STEPS: &[Step] = &[
    Step {
        name: "rust",
        what: "formatter, linter and the board's target are there",
        work: Work::Do(setup::rust, setup::RUST_BY_HAND),
    },
    Step {
        name: "qemu",
        what: "the emulator of the board's processor is there",
        work: Work::Do(setup::qemu, "qemu-system-arm --version"),
    },
    Step {
        name: "compiler",
        what: "libFuzzer's C++ compiler is there",
        work: Work::Do(setup::compiler, "c++ --version"),
    },
    Step {
        name: "python",
        what: "the Python programs that work through the board's port are there",
        work: Work::Do(setup::python, setup::PYTHON_BY_HAND),
    },
    cargo("format", "code is formatted", "fmt --all --check"),
    cargo(
        "format-fuzz",
        "and so are the fuzz targets",
        "fmt --manifest-path tests/fuzz/Cargo.toml --check",
    ),
    cargo(
        "lint",
        "no warnings in what runs on the host, firmware without a board included",
        "clippy --workspace --all-targets -- -D warnings",
    ),
    cargo(
        "lint-emulator",
        "no warnings in the emulator's image",
        "clippy --release --package armbridge-firmware --target thumbv7em-none-eabihf \
         --features mps2-an386 --bin mps2-an386 -- -D warnings",
    ),
    cargo(
        "lint-board",
        "no warnings in the board's image",
        "clippy --release --package armbridge-firmware --target thumbv7em-none-eabihf \
         --features feather-f405 --bin feather-f405 -- -D warnings",
    ),
    cargo(
        "lint-no-panic",
        "no warnings in the image that shows that there are no panics",
        "clippy --release --package armbridge-firmware --target thumbv7em-none-eabihf \
         --features no-panic --bin no-panic -- -D warnings",
    ),
    cargo(
        "shared",
        "shared code builds by itself for the board, without the standard library",
        "build --release --package armbridge-shared --target thumbv7em-none-eabihf",
    ),
    cargo(
        "build-emulator",
        "the emulator's image builds",
        "build-emulator",
    ),
    cargo("build-board", "the board's image builds", "build-board"),
    Step {
        name: "no-panic",
        what: "no panic can be reached from what bus, host or client send",
        work: Work::Do(no_panic::run, "cargo verify --only no-panic"),
    },
    cargo(
        "test",
        "every test that needs Rust alone",
        "test --workspace",
    ),
    Step {
        name: "miri",
        what: "what handles bytes does with memory only what it may",
        work: Work::Do(miri::run, "cargo verify --only miri"),
    },
    Step {
        name: "fuzz",
        what: "each fuzz target finds nothing in half a minute",
        work: Work::Do(fuzz::run, "cargo verify --only fuzz"),
    },
    cargo(
        "test-emulator",
        "every test that needs more than Rust",
        "test --workspace -- --ignored",
    ),
];
