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
    /// Flags of the compiler without which two builds differ.
    pub(crate) flags: &'static [&'static str],
    /// Linker that is to be called with relative paths; none for the compiler's own choice.
    pub(crate) linker: Option<&'static str>,
}

/// Not macOS: a program is linked with parts of Apple's SDK, which is for Apple's machines.
pub(crate) const SYSTEMS: &[System] = &[
    System {
        name: "linux-x86_64",
        target: "x86_64-unknown-linux-gnu",
        extension: "",
        flags: &[],
        linker: None,
    },
    System {
        name: "windows-x86_64",
        target: "x86_64-pc-windows-gnu",
        extension: ".exe",
        // Otherwise the file has the time at which it was linked.
        flags: &["-Clink-arg=-Wl,--no-insert-timestamp"],
        // It orders imports by the paths of archives, before or after the system's own.
        linker: Some("x86_64-w64-mingw32-gcc"),
    },
];
