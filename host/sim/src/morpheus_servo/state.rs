//! States of the main loop: its stage, the message being executed, and the progress of
//! START and CYCLE.

/// Next stage of the main loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    /// Polls the receiver for a message.
    PollMessages,
    /// Dispatches the message just opened.
    Dispatch,
    /// Writes the next byte of a WRITE or `SYNC_WR`.
    WriteByte,
    /// Stores `value`, once the EEPROM is ready. Interrupts are off.
    StoreByte { address: u8, value: u8 },
    /// Applies the written values.
    ApplyWrites,
    /// Clears the marker, so that `LoadEeprom` restores the defaults. Interrupts off.
    ClearMarker,
    /// Loads the variables from the EEPROM, restoring the defaults from index
    /// `restored` on if the marker is wrong. Interrupts are off.
    LoadEeprom { restored: usize },
    /// The variables are loaded.
    EepromLoaded,
    /// Moves a complete reply to the transmit buffer.
    QueueReply,
    /// The message is finished.
    MessageDone,
    /// The timer tick.
    Tick,
    /// The tick polls the converter for a result.
    ReadConverter,
    /// The rest of the tick: the PWM changes.
    ApplyPwm,
    /// Passes a byte to the transmitter.
    Transmit,
    /// Switches the bus driver off.
    ReleaseBus,
}

/// Progress of the servo in START and CYCLE.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CycleState {
    /// No START since power-up.
    NotStarted,
    /// Waiting for its slot.
    AwaitingSlot,
    /// Takes part in CYCLE.
    Member,
}

/// Operation that takes several stages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Job {
    /// Starting up.
    Boot,
    /// Nothing longer than one stage.
    None,
    /// A reply is being built.
    Reply,
    /// A reply without a request is being built.
    UnsolicitedReply,
    Write {
        /// Bytes left, as the firmware counts them: 16 bits, from -1 when the
        /// packet has no address.
        left: u16,
        /// Index of the next byte in the message.
        index: u8,
        /// The register that it is written to.
        address: u8,
        sync: bool,
        answer: bool,
        rom_changed: bool,
    },
    /// Defaults are being restored on request.
    Reset { answer: bool },
}
