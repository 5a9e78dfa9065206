//! Loads of the bench's servos: the arm, and a free shaft for those beyond its two
//! joints.

use armbridge_servo::JOINTS;

use super::encoder;
use super::faults::sensor::Sensors;
use super::half_duplex_bus::Mechanics;
use super::morpheus_servo::{MotorDrive, Reading};
use super::plant::Plant;
use armbridge_control::encoder::Encoder;

/// Converter counts of a Morpheus servo at room temperature: any value, the firmware
/// does not use it. A stock servo has a thermal model of its own.
const TEMPERATURE: u16 = 300;
/// No-load speed at full duty: 59 rpm (e-Manual, AX-12A), in counts of 300/1023
/// degree a second.
const NO_LOAD_COUNTS_PER_S: f64 = 59.0 / 60.0 * 360.0 / (300.0 / 1023.0);
/// Counts of a turn, in those of an AX-12A.
const TURN_COUNTS: f64 = encoder::counts_per_turn(Encoder::Ax12a);
/// The PWM that switches a motor off.
const OFF: u16 = 1000;
/// Deviation up to which a motor counts as off: the stop sequence sends a value one
/// count off, which is 1.2 mN m, before 1000.
const OFF_TOLERANCE: u16 = 1;

/// The arm and the shafts.
#[derive(Debug)]
pub(super) struct Joints {
    pub(super) arm: Plant,
    pub(super) sensors: [Sensors; JOINTS],
    /// The arm's servos are swapped.
    is_swapped: bool,
    motors: [Motor; JOINTS],
    shafts: Vec<Shaft>,
}

/// PWM history of one of the arm's servos. A motor without torque is off, also where its PWM
/// balances its back-EMF.
#[derive(Clone, Copy, Debug)]
struct Motor {
    drive: MotorDrive,
    /// Start of the present or the last on-time.
    on_ns: u64,
    /// Start of the present or the last off-time.
    off_ns: u64,
    /// On-time before that.
    earlier_ns: u64,
    /// Largest distance from off since it was read last, in counts.
    most: u16,
}

/// A motor without load: its speed follows its duty without delay.
#[derive(Clone, Copy, Debug)]
struct Shaft {
    at_ns: u64,
    /// Within one turn, in counts of an AX-12A.
    counts: f64,
    counts_per_s: f64,
}

impl Shaft {
    /// Middle position, at rest.
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

    /// Reading of the encoder. That of an AX-12A is at one of its ends in the gap of 60 degrees.
    fn position(&self, encoder: Encoder) -> u16 {
        if encoder == Encoder::XSeries {
            let turns = (self.counts - Self::START.counts) / TURN_COUNTS;
            return encoder::count(encoder, (0.5 + turns) * encoder::counts_per_turn(encoder));
        }
        let middle_of_gap = f64::midpoint(1023.0, TURN_COUNTS);
        if self.counts > middle_of_gap {
            0
        } else {
            self.counts.round().min(1023.0) as u16
        }
    }
}

impl Joints {
    /// The arm's loads, and free shafts for this many more servos.
    pub(super) fn new(arm: Plant, servos: usize) -> Self {
        Self {
            arm,
            sensors: Default::default(),
            is_swapped: false,
            motors: [Motor::OFF; JOINTS],
            shafts: vec![Shaft::START; servos.saturating_sub(JOINTS)],
        }
    }

    /// Swaps the arm's servos with their states. The second call swaps them
    /// back.
    pub(super) fn swap(&mut self, at_ns: u64) {
        self.is_swapped = !self.is_swapped;
        for servo in 0..JOINTS {
            self.arm
                .drive(self.joint(servo), at_ns, self.motors[servo].drive.pwm);
        }
    }

    /// Joint that this servo moves.
    fn joint(&self, servo: usize) -> usize {
        if self.is_swapped {
            JOINTS - 1 - servo
        } else {
            servo
        }
    }

    /// Last time on of this servo's motor; the end is `None` while it is.
    pub(super) fn last_on_ns(&self, servo: usize) -> (u64, Option<u64>) {
        let motor = self.motors[servo];
        (motor.on_ns, motor.is_off().then_some(motor.off_ns))
    }

    /// Total time on of this servo's motor.
    pub(super) fn total_on_ns(&self, servo: usize, now_ns: u64) -> u64 {
        let motor = self.motors[servo];
        let until_ns = if motor.is_off() { motor.off_ns } else { now_ns };
        motor.earlier_ns + until_ns.saturating_sub(motor.on_ns)
    }

    /// Largest distance from off of this servo's motor since the last call,
    /// in counts.
    pub(super) fn take_most_counts(&mut self, servo: usize) -> u16 {
        let motor = &mut self.motors[servo];
        std::mem::replace(&mut motor.most, motor.drive.at_rest.abs_diff(OFF))
    }
}

impl Motor {
    const OFF: Self = Self {
        drive: MotorDrive {
            pwm: OFF,
            at_rest: OFF,
        },
        on_ns: 0,
        off_ns: 0,
        earlier_ns: 0,
        most: 0,
    };

    fn set(&mut self, at_ns: u64, drive: MotorDrive) {
        let was_off = self.is_off();
        self.drive = drive;
        match (was_off, self.is_off()) {
            (true, false) => {
                self.earlier_ns += self.off_ns - self.on_ns;
                self.on_ns = at_ns;
            }
            (false, true) => self.off_ns = at_ns,
            (true, true) | (false, false) => {}
        }
        self.most = self.most.max(drive.at_rest.abs_diff(OFF));
    }

    fn is_off(&self) -> bool {
        self.drive.at_rest.abs_diff(OFF) <= OFF_TOLERANCE
    }
}

impl Mechanics for Joints {
    fn convert(&mut self, servo: usize, at_ns: u64) -> Reading {
        self.convert_with(servo, Encoder::Ax12a, at_ns)
    }

    fn convert_with(&mut self, servo: usize, encoder: Encoder, at_ns: u64) -> Reading {
        let reading = |position| Reading {
            position,
            temperature: TEMPERATURE,
        };
        match servo.checked_sub(JOINTS) {
            None => {
                let joint = self.joint(servo);
                let truth = reading(self.arm.read_with(joint, encoder, at_ns));
                self.sensors[servo].read(truth, encoder, at_ns)
            }
            Some(shaft) => {
                let shaft = &mut self.shafts[shaft];
                shaft.advance(at_ns);
                reading(shaft.position(encoder))
            }
        }
    }

    fn counts_per_s(&mut self, servo: usize, encoder: Encoder, at_ns: u64) -> Option<f64> {
        Some(match servo.checked_sub(JOINTS) {
            None => self.arm.counts_per_s(self.joint(servo)),
            Some(shaft) => {
                let shaft = &mut self.shafts[shaft];
                shaft.advance(at_ns);
                shaft.counts_per_s / TURN_COUNTS * encoder::counts_per_turn(encoder)
            }
        })
    }

    fn drive(&mut self, servo: usize, at_ns: u64, drive: MotorDrive) {
        let pwm = drive.pwm;
        match servo.checked_sub(JOINTS) {
            None => {
                self.motors[servo].set(at_ns, drive);
                self.arm.drive(self.joint(servo), at_ns, pwm);
            }
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
    use crate::plant::PlantConfig;

    #[test]
    fn a_motors_time_on_is_the_sum_of_all_times() {
        let mut joints = Joints::new(Plant::new(PlantConfig::default(), 1), 2);
        // The last is the stop sequence's step off by one.
        for (at_ns, pwm) in [(100, 1200), (150, 800), (300, 1000), (500, 0), (600, 1001)] {
            joints.drive(0, at_ns, u16::into(pwm));
        }
        assert_eq!([0, 1].map(|servo| joints.total_on_ns(servo, 900)), [300, 0]);
        joints.drive(0, 1_000, 2000.into());
        assert_eq!(joints.total_on_ns(0, 1_250), 550);
    }

    #[test]
    fn a_free_shaft_turns_at_its_duty_and_through_the_gap() {
        let mut joints = Joints::new(Plant::new(PlantConfig::default(), 1), 3);
        let at = |joints: &mut Joints, ms: u64| joints.convert(2, ms * 1_000_000).position;
        assert_eq!(at(&mut joints, 0), 512);
        joints.drive(2, 0, 1500.into());
        // 29.5 rpm: 177 degrees, or 604 counts, a second.
        assert_eq!(at(&mut joints, 500), 814);
        assert_eq!(at(&mut joints, 900), 1023);
        assert_eq!(at(&mut joints, 1_100), 0);
        // A whole turn in 2.034 s.
        assert_eq!(at(&mut joints, 2_034), 512);
        joints.drive(2, 2_034_000_000, 1000.into());
        assert_eq!(at(&mut joints, 3_000), 512);
    }
}
