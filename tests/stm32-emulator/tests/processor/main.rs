//! The processor against the architecture's manual and against QEMU.

mod elf;
mod mps2;
mod qemu;
mod random;
mod trace;
