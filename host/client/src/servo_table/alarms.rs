//! Names of the alarms of stock and X servos.

use armbridge_servo::Alarms;

/// Names, from bit 0 on (e-Manual, "Error"); the last is the alert of an X servo.
const NAMES: [&str; 8] = [
    "input voltage",
    "angle limit",
    "overheating",
    "range",
    "checksum",
    "overload",
    "instruction",
    "hardware",
];

/// The names of these alarms, from bit 0 on.
pub fn names(alarms: Alarms) -> Vec<&'static str> {
    let is_set = |bit: usize| alarms.bits() & (1 << bit) != 0;
    let names = NAMES.into_iter().enumerate();
    names
        .filter_map(|(bit, name)| is_set(bit).then_some(name))
        .collect()
}

/// The names of these alarms, separated by commas.
pub fn text(alarms: Alarms) -> String {
    if alarms.is_empty() {
        return "none".to_owned();
    }
    names(alarms).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_has_its_name() {
        let alarms = Alarms::OVERLOAD.or(Alarms::OVERHEATING);
        assert_eq!(text(alarms), "overheating, overload");
        assert_eq!(names(Alarms::from_bits(0xFF)).len(), 8);
        assert_eq!(text(Alarms::from_bits(0x80)), "hardware");
        assert_eq!(text(Alarms::from_bits(64)), "instruction");
    }
}
