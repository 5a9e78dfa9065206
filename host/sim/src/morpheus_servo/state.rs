//! States of the main loop: its stage, the message that it executes, its place on the bus.

/// Next stage of the main loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    /// Looks for a message.
    Look,
    /// Acts on the message just opened.
    Obey,
    /// Writes the next byte of a WRITE or `SYNC_WR`.
    Write,
    /// Stores `value`, once the EEPROM is ready. Interrupts are off.
    Store { address: u8, value: u8 },
    /// Applies the written values.
    Settle,
    /// Clears the marker, so that `Load` restores the defaults. Interrupts off.
    Reset,
    /// Loads the variables from the EEPROM, restoring the defaults from place
    /// `restored` on if the marker is wrong. Interrupts are off.
    Load { restored: usize },
    /// The variables are loaded.
    Loaded,
    /// A reply has been built.
    Reply,
    /// The message is done with.
    Done,
    /// The timer tick.
    Tick,
    /// The tick looks for a result of the converter.
    Sample,
    /// The rest of the tick: the PWM changes.
    Control,
    /// Feeds the transmitter.
    Feed,
    /// Switches the bus driver off.
    Release,
}

/// Where the servo stands in START and CYCLE.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Bus {
    /// No START since power-up.
    Unknown,
    /// Waiting for its slot.
    Slot,
    /// Takes part in CYCLE.
    Member,
}

/// A message that takes several stages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Job {
    /// Starting up.
    Boot,
    /// Nothing longer than one stage.
    None,
    /// A reply is being built.
    Reply,
    /// A reply outside any message is being built.
    Unasked,
    Write {
        /// Bytes left, as the firmware counts them: 16 bits, from -1 when the
        /// packet has no address.
        left: u16,
        /// Where the next byte is in the message.
        index: u8,
        /// The register it goes to.
        address: u8,
        sync: bool,
        answer: bool,
        rom_changed: bool,
    },
    /// Defaults are being restored on request.
    Reset { answer: bool },
}
