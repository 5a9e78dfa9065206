//! The control link between board and host.
//!
//! [`message`] says what is said; the frame codec says how it is put on a wire.

pub mod message;
