//! Addresses of the servos under control.

use core::ops::Deref;

/// Servos under control at most: one for each joint.
pub const JOINTS: usize = 2;

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

/// Addresses of the servos under control, joint by joint: at least one, at most [`JOINTS`].
///
/// ```
/// use armbridge_servo::{ServoId, ServoIds};
///
/// let [first, second] = [1, 2].map(|id| ServoId::new(id).unwrap());
/// let both = ServoIds::from([first, second]);
/// assert_eq!(*both, [first, second]);
/// assert_eq!(*both.of_joints(1), [first]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServoIds {
    /// Those of the servos under control, then the first again.
    ids: [ServoId; JOINTS],
    count: u8,
}

impl ServoIds {
    /// The first `count` of these servos, at least one.
    #[must_use]
    pub fn of_joints(self, count: usize) -> Self {
        let count = count.clamp(1, JOINTS);
        let [first, ..] = self.ids;
        let mut ids = [first; JOINTS];
        for (slot, id) in ids.iter_mut().zip(self.ids).take(count) {
            *slot = id;
        }
        Self {
            ids,
            count: count as u8,
        }
    }

    /// The joint of the servo with this address.
    pub(crate) fn joint(self, id: u8) -> Option<usize> {
        // The first place with the address, as in `filled`, is that of a servo under control.
        self.ids.iter().position(|servo| servo.get() == id)
    }

    /// A servo for each of [`JOINTS`] places in a packet: with fewer joints the first one again.
    pub(crate) fn filled(self) -> [ServoId; JOINTS] {
        self.ids
    }
}

impl From<[ServoId; JOINTS]> for ServoIds {
    fn from(ids: [ServoId; JOINTS]) -> Self {
        Self {
            ids,
            count: JOINTS as u8,
        }
    }
}

impl Deref for ServoIds {
    type Target = [ServoId];

    #[inline]
    fn deref(&self) -> &[ServoId] {
        self.ids.get(..usize::from(self.count)).unwrap_or(&self.ids)
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
