//! The servo bus as two programs share it: the control loop and a client of the
//! transparent port, on both servo firmwares.

mod alarms;
mod bring_up;
mod loops;
mod passthrough;
