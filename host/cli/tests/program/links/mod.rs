//! The program on links that fail: unplugged, reset, shared, not read, of another version.
//! After each the right words, the right exit code, and no arm that is left energised.

mod commands;
mod hands;
pub(crate) mod program;
mod runs;
#[cfg(unix)]
mod stop;
