//! Links that fail: unplugged, reset, shared, not read, of another version. After each
//! the right words, the right exit code, and no arm that is left energised.

mod board;
mod cable;
mod commands;
mod hosts;
mod identify;
mod program;
mod runs;
mod unplugged;
