//! Systems that the host program is built for. Another is a row here; boards are those of
//! `firmware/boards.rs`.

/// A system that the host program is built for.
pub(crate) struct System {
    /// Its name in that of the file.
    pub(crate) name: &'static str,
    /// The compiler's target.
    pub(crate) target: &'static str,
    /// End of a program's name.
    pub(crate) extension: &'static str,
    /// The linker's arguments without which two builds differ.
    pub(crate) link_args: &'static [&'static str],
}

/// Not macOS: a program is linked with parts of Apple's SDK, which is for Apple's machines.
pub(crate) const SYSTEMS: &[System] = &[
    System {
        name: "linux-x86_64",
        target: "x86_64-unknown-linux-gnu",
        extension: "",
        link_args: &[],
    },
    System {
        name: "windows-x86_64",
        target: "x86_64-pc-windows-gnu",
        extension: ".exe",
        // Otherwise the file has the time at which it was linked.
        link_args: &["-Wl,--no-insert-timestamp"],
    },
];
