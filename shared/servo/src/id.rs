//! Address of a servo under control.

/// Address of a servo: 1..=253.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ServoId(u8);

impl ServoId {
    /// Checks an address; `None` for 0, for 254 (the Morpheus master: a servo with this id answers
    /// itself for ever; Protocol 1.0's broadcast) and for 255 (Morpheus's
    /// broadcast).
    pub const fn new(id: u8) -> Option<Self> {
        match id {
            1..=253 => Some(Self(id)),
            _ => None,
        }
    }

    /// The address on the wire.
    pub const fn get(self) -> u8 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn servo_ids_exclude_master_and_broadcast() {
        let valid = (0..=255).filter_map(ServoId::new).count();
        assert_eq!(valid, 253);
        assert_eq!(
            (ServoId::new(0), ServoId::new(254), ServoId::new(255)),
            (None, None, None)
        );
    }
}
