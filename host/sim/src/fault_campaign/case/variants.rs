//! Variants of a case: with a pose to be parked in, or with servos of the X series. Each has draws of
//! its own, so that nothing else of the case changes.

use armbridge_link::limits::hard;
use armbridge_servo::ControlMode;

use super::super::draw::Random;
use super::super::set_up::Bus;
use super::Case;

/// Makes the draws of a pose others than those of its case.
const POSE_SEED: u64 = 0x7061_726B_0000_0000;
/// Makes the draws of X servos others than those of their case.
const X_SEED: u64 = 0x7873_6572_0000_0000;

impl Case {
    /// The same case, of an arm that has a pose to be parked in. Nothing else of it changes.
    #[must_use]
    pub fn with_pose(self) -> Self {
        let mut draw = Random::new(self.seed ^ POSE_SEED);
        let mut angle = |least: f64| {
            let side = if draw.coin() { 1.0 } else { -1.0 };
            side * draw.uniform(least, f64::from(hard::PARK_MRAD))
        };
        let pose = [angle(800.0), angle(0.0)].map(|mrad| mrad as i16);
        Self {
            pose: Some(pose),
            ..self
        }
    }

    /// The same case with servos of the X series, in every third driven by current: bus and set-up
    /// are others, and nothing else.
    #[must_use]
    pub fn with_x_servos(self) -> Self {
        let mut draw = Random::new(self.seed ^ X_SEED);
        let mut pick = |count: usize| draw.below(count as u64) as usize;
        let set_ups = |bus: &Bus| bus.set_ups(self.activity);
        let can_do = |bus: &Bus| !set_ups(bus).is_empty();
        let buses: Vec<Bus> = Bus::of_x_servos().filter(can_do).collect();
        let bus = buses[pick(buses.len())];
        let set_ups = set_ups(&bus);
        let set_up = set_ups[pick(set_ups.len())];
        let mode = match pick(3) {
            0 => ControlMode::Current,
            _ => ControlMode::Pwm,
        };
        Self {
            bus: Bus { mode, ..bus },
            set_up,
            ..self
        }
    }
}
