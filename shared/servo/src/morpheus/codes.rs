//! Codes of the firmware: commands and register addresses.

/// Command codes of the firmware (`Serial.h`).
pub(super) mod command {
    pub(in crate::morpheus) const PING: u8 = 0x01;
    pub(in crate::morpheus) const READ: u8 = 0x02;
    pub(in crate::morpheus) const WRITE: u8 = 0x03;
    pub(in crate::morpheus) const START: u8 = 0x06;
    pub(in crate::morpheus) const CYCLE: u8 = 0x07;
    pub(in crate::morpheus) const RESET: u8 = 0x09;
    pub(in crate::morpheus) const SYNC_WR: u8 = 0x83;
}

/// Register addresses (`Eprom.h` of the firmware). Two bytes, low byte first, are
/// position, temperature and PWM.
pub(super) mod register {
    pub(in crate::morpheus) const POSITION: u8 = 0x0B;
    pub(in crate::morpheus) const TEMPERATURE: u8 = 0x0E;
    /// High byte of the temperature: read-only, so that a write to it is void.
    /// SYNC_WR from here reaches the PWM register by the checked path.
    pub(in crate::morpheus) const BEFORE_PWM: u8 = 0x0F;
    pub(in crate::morpheus) const PWM: u8 = 0x10;
    /// End of the registers, exclusive; a READ beyond it is refused.
    pub(in crate::morpheus) const END: u8 = 0x12;
}
