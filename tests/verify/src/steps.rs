//! Steps of the gate and of the campaign, in order of their cost within each lane.

use crate::output::Output;
use crate::{
    fuzz, host, images, miri, mutations, no_panic, outside, python_package, release, setup, wine,
};

/// A step that must pass.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    /// Its name for `--only`.
    pub(crate) name: &'static str,
    /// Its purpose, in a line.
    pub(crate) what: &'static str,
    /// Steps beside which it runs.
    pub(crate) lane: Lane,
    /// Steps of the other lane that have to be done before.
    pub(crate) needs: &'static [&'static str],
    /// The work itself.
    pub(crate) work: Work,
}

/// Steps that follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lane {
    /// Uses cargo's folder of the host's code.
    Host,
    /// Uses the folders of images, wheel, fuzz targets, Miri and mutations.
    Board,
}

/// Work of a step.
#[derive(Clone, Copy)]
pub(crate) enum Work {
    /// A function.
    Do(fn(&Output) -> Result<(), String>),
    /// Runs of cargo, a line of arguments each.
    Cargo(&'static [&'static str]),
}

impl Work {
    /// Performs it, with all output to `out`.
    pub(crate) fn perform(self, out: &Output) -> Result<(), String> {
        match self {
            Self::Do(work) => work(out),
            Self::Cargo(lines) => lines.iter().try_for_each(|line| out.cargo(line)),
        }
    }
}

/// A step of the host's lane.
const fn host_lines(
    name: &'static str,
    what: &'static str,
    lines: &'static [&'static str],
) -> Step {
    step(Lane::Host, name, what, Work::Cargo(lines))
}

/// A step of the board's lane.
const fn board_lines(
    name: &'static str,
    what: &'static str,
    lines: &'static [&'static str],
) -> Step {
    step(Lane::Board, name, what, Work::Cargo(lines))
}

const fn step(lane: Lane, name: &'static str, what: &'static str, work: Work) -> Step {
    Step {
        name,
        what,
        lane,
        needs: &[],
        work,
    }
}

/// A step after others of the other lane.
const fn after(needs: &'static [&'static str], step: Step) -> Step {
    Step { needs, ..step }
}

/// Steps that each change must pass.
pub(crate) const GATE: &[Step] = &[
    step(
        Lane::Host,
        "rust",
        "formatter, linter, test runner and the targets of board, Windows, macOS and web are there",
        Work::Do(setup::rust),
    ),
    host_lines(
        "format",
        "code is formatted, fuzz targets and the crates outside the workspace included",
        &[
            "fmt --all --check",
            "fmt --manifest-path tests/fuzz/Cargo.toml --check",
            "fmt --manifest-path tests/masters/Cargo.toml --check",
            "fmt --manifest-path tests/outside/Cargo.toml --check",
        ],
    ),
    host_lines(
        "build",
        "all tests build",
        &[
            "nextest run --workspace --no-run",
            // The other programs that tests and checks start; with tests, because without
            // them dependencies have fewer features, and a sixth of all would be built again.
            "build --workspace --bins --tests",
        ],
    ),
    host_lines(
        "lint",
        "no warnings in what runs on the host, campaigns and firmware without a board included",
        &[
            "clippy --workspace --all-targets -- -D warnings",
            "clippy --workspace --test campaign -- -D warnings",
        ],
    ),
    step(
        Lane::Host,
        "doc",
        "documentation has no broken links",
        Work::Do(host::documentation),
    ),
    host_lines(
        "doc-test",
        "examples in the documentation run",
        &["test --workspace --doc"],
    ),
    after(
        &[
            "python",
            "languages",
            "qemu",
            "browser",
            "build-images",
            "masters",
        ],
        step(
            Lane::Host,
            "test",
            "every test: crates, one process, program, emulator, Python packages, clients, pages",
            Work::Do(host::tests),
        ),
    ),
    after(
        &["build-images"],
        step(
            Lane::Host,
            "board-image",
            "the boards' own images, executed on emulated chips from reset on",
            Work::Do(host::board_image),
        ),
    ),
    step(
        Lane::Board,
        "qemu",
        "the emulator of the board's processor is there",
        Work::Do(setup::qemu),
    ),
    step(
        Lane::Board,
        "browser",
        "the browser in which pages are checked is there",
        Work::Do(setup::browser),
    ),
    step(
        Lane::Board,
        "languages",
        "Octave, Node and nc, which the JSON server's clients run in, are there",
        Work::Do(setup::languages),
    ),
    step(
        Lane::Board,
        "compiler",
        "libFuzzer's C++ compiler is there",
        Work::Do(setup::compiler),
    ),
    step(
        Lane::Board,
        "python",
        "the Python programs that work through the board's port are there",
        Work::Do(setup::python),
    ),
    after(
        &["rust"],
        step(
            Lane::Board,
            "build-images",
            "the images of all boards build",
            Work::Do(images::build),
        ),
    ),
    step(
        Lane::Board,
        "masters",
        "the masters of others, which drive the virtual servos, build",
        Work::Do(outside::masters),
    ),
    step(
        Lane::Board,
        "lint-images",
        "no warnings in the images, nor in shared code by itself without the standard library",
        Work::Do(images::lint),
    ),
    board_lines(
        "windows",
        "the program compiles for Windows, without warnings",
        // What Windows lacks is left out there, and has the interface of the others.
        &[
            "clippy --package armbridge --features full --target x86_64-pc-windows-gnu \
             -- -D warnings -A clippy::unnecessary_wraps -A clippy::unused_self",
        ],
    ),
    board_lines(
        "macos",
        "the program compiles for macOS, without warnings; it is not linked",
        &[
            "clippy --package armbridge --features full --target aarch64-apple-darwin \
           -- -D warnings -A clippy::unnecessary_wraps -A clippy::unused_self",
        ],
    ),
    step(
        Lane::Board,
        "outside",
        "a crate outside the workspace closes a loop, and builds for the board and for web pages",
        Work::Do(outside::run),
    ),
    step(
        Lane::Board,
        "python-package",
        "the wheel of the Python package installs, passes its tests, and has the types it states",
        Work::Do(python_package::run),
    ),
    step(
        Lane::Board,
        "fuzz",
        "each fuzz target finds nothing in a few seconds",
        Work::Do(fuzz::short),
    ),
    step(
        Lane::Board,
        "miri",
        "queues between threads and interrupts do with memory only what they may",
        Work::Do(miri::threads),
    ),
    after(
        &["build"],
        step(
            Lane::Board,
            "package",
            "the shared crates make packages, without warnings",
            Work::Do(outside::package),
        ),
    ),
    after(
        &["build"],
        step(
            Lane::Board,
            "no-panic",
            "no panic can be reached from what bus, host or client send",
            Work::Do(no_panic::run),
        ),
    ),
];

/// Long steps: the gate has a shorter form of each.
pub(crate) const CAMPAIGN: &[Step] = &[
    step(
        Lane::Host,
        "campaign-setup",
        "what the campaign needs is there",
        Work::Do(setup::campaign),
    ),
    host_lines(
        "campaign",
        "streams, replays, faults, kills and arms by the thousand",
        &[
            "build --release --workspace --bin armbridge --test campaign",
            "nextest run --release --workspace --test campaign --run-ignored all --no-capture",
        ],
    ),
    step(
        Lane::Host,
        "fuzz-long",
        "each fuzz target finds nothing in ten minutes",
        Work::Do(fuzz::long),
    ),
    step(
        Lane::Board,
        "miri-long",
        "the seeds of the fuzz targets do with memory only what they may",
        Work::Do(miri::seeds),
    ),
    step(
        Lane::Board,
        "release",
        "the files to download are equal bit for bit from two folders",
        Work::Do(release::reproducible),
    ),
    step(
        Lane::Board,
        "wine",
        "the program for Windows runs under Wine, and ctrl-c switches the motors off",
        Work::Do(wine::run),
    ),
    step(
        Lane::Board,
        "mutations",
        "the fault campaign or a test notices each guard that is taken out of the board's code",
        Work::Do(mutations::run),
    ),
];

/// The step with this name.
pub(crate) fn named(name: &str) -> Option<&'static Step> {
    GATE.iter().chain(CAMPAIGN).find(|step| step.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_step_has_a_name_of_its_own() {
        for step in GATE.iter().chain(CAMPAIGN) {
            let all = GATE.iter().chain(CAMPAIGN);
            let named = all.filter(|other| other.name == step.name);
            assert_eq!(named.count(), 1, "{}", step.name);
        }
    }

    /// Otherwise both lanes could wait for each other.
    #[test]
    fn a_step_needs_steps_that_need_none_after_it() {
        for steps in [GATE, CAMPAIGN] {
            let mut done: Vec<&str> = Vec::new();
            while done.len() < steps.len() {
                let before = done.len();
                for lane in [Lane::Host, Lane::Board] {
                    let mut lane = steps.iter().filter(|step| step.lane == lane);
                    let next = lane.find(|step| !done.contains(&step.name));
                    let is_ready = |step: &&Step| step.needs.iter().all(|it| done.contains(it));
                    done.extend(next.filter(is_ready).map(|step| step.name));
                }
                assert!(done.len() > before, "stuck after {done:?}");
            }
        }
    }
}
