//! The stock servo as a master meets it on the wire.
