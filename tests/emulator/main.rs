//! The firmware image under QEMU: agreement with the bench, and what only an image has.
//!
//! Needs QEMU and the image, `cargo build-emulator`; without them,
//! `cargo test -p armbridge-tests --test emulator` runs nothing.

mod agreement;
mod board_image;
mod faults;
mod instructions;
mod replay;
mod settings;
mod torque_off;
mod transparent_port;
