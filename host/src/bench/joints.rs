//! What the servos of the bench turn: the arm, and for those beyond its two
//! joints a shaft with nothing on it.

use super::plant::Plant;
use super::servo::Reading;
use super::wire::Mechanics;
use armbridge_shared::JOINTS;

/// Converter counts of a Morpheus servo at room temperature: any will do, it
/// does nothing with them. A stock servo has a thermal model of its own.
const TEMPERATURE: u16 = 300;
/// Speed without load at full duty: 59 rpm (e-Manual), in counts of 300/1023
/// degree a second.
const NO_LOAD_COUNTS_PER_S: f64 = 59.0 / 60.0 * 360.0 / (300.0 / 1023.0);
/// Counts of a whole turn, of which the converter sees 0..=1023.
const TURN_COUNTS: f64 = 360.0 / (300.0 / 1023.0);
/// The PWM that switches a motor off.
const OFF: u16 = 1000;

/// The arm and the shafts.
#[derive(Debug)]
pub(super) struct Joints {
    pub(super) arm: Plant,
    shafts: Vec<Shaft>,
}

/// A motor without load: its speed follows its duty at once.
#[derive(Clone, Copy, Debug)]
struct Shaft {
    at_ns: u64,
    /// Within one turn.
    counts: f64,
    counts_per_s: f64,
}

impl Shaft {
    /// In the middle, at rest.
    const START: Self = Self {
        at_ns: 0,
        counts: 512.0,
        counts_per_s: 0.0,
    };

    fn advance(&mut self, to_ns: u64) {
        let seconds = to_ns.saturating_sub(self.at_ns) as f64 * 1e-9;
        self.counts = (self.counts + self.counts_per_s * seconds).rem_euclid(TURN_COUNTS);
        self.at_ns = self.at_ns.max(to_ns);
    }

    /// In the gap of 60 degrees the converter is at one of its ends.
    fn position(&self) -> u16 {
        let middle_of_gap = f64::midpoint(1023.0, TURN_COUNTS);
        if self.counts > middle_of_gap {
            0
        } else {
            self.counts.round().min(1023.0) as u16
        }
    }
}

impl Joints {
    /// The arm's, and those of so many more servos.
    pub(super) fn new(arm: Plant, servos: usize) -> Self {
        Self {
            arm,
            shafts: vec![Shaft::START; servos.saturating_sub(JOINTS)],
        }
    }
}

impl Mechanics for Joints {
    fn convert(&mut self, servo: usize, at_ns: u64) -> Reading {
        let position = match servo.checked_sub(JOINTS) {
            None => self.arm.read(servo, at_ns),
            Some(shaft) => {
                let shaft = &mut self.shafts[shaft];
                shaft.advance(at_ns);
                shaft.position()
            }
        };
        Reading {
            position,
            temperature: TEMPERATURE,
        }
    }

    fn drive(&mut self, servo: usize, at_ns: u64, pwm: u16) {
        match servo.checked_sub(JOINTS) {
            None => self.arm.drive(servo, at_ns, pwm),
            Some(shaft) => {
                let shaft = &mut self.shafts[shaft];
                shaft.advance(at_ns);
                let duty = (f64::from(pwm) - f64::from(OFF)) / f64::from(OFF);
                shaft.counts_per_s = duty * NO_LOAD_COUNTS_PER_S;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::plant::PlantConfig;

    #[test]
    fn a_free_shaft_turns_at_its_duty_and_through_the_gap() {
        let mut joints = Joints::new(Plant::new(PlantConfig::default(), 1), 3);
        let at = |joints: &mut Joints, ms: u64| joints.convert(2, ms * 1_000_000).position;
        assert_eq!(at(&mut joints, 0), 512);
        joints.drive(2, 0, 1500);
        // 29.5 rpm: 177 degrees, or 604 counts, a second.
        assert_eq!(at(&mut joints, 500), 814);
        assert_eq!(at(&mut joints, 900), 1023);
        assert_eq!(at(&mut joints, 1_100), 0);
        // A whole turn in 2.034 s.
        assert_eq!(at(&mut joints, 2_034), 512);
        joints.drive(2, 2_034_000_000, 1000);
        assert_eq!(at(&mut joints, 3_000), 512);
    }
}
