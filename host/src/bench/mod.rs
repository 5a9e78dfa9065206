//! The virtual bench: servos, wire, arm and clock.
