//! The processor against the architecture's manual and against QEMU.

mod board;
mod elf;
mod exceptions;
mod faults;
mod float;
mod mps2;
mod nested;
mod qemu;
mod random;
mod single;
mod trace;
