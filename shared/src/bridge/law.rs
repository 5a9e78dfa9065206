//! Stand-in.
use crate::{
    JOINTS,
    actuator::Pwm,
    link::message::{Refusal, Sample, Setup},
};
#[derive(Clone, Debug)]
pub(super) struct Law {
    period_us: u32,
}
pub(super) struct Estimate {
    pub(super) angle_rad: [f32; JOINTS],
    pub(super) speed_rad_s: [f32; JOINTS],
}
impl Estimate {
    pub(super) fn is_finite(&self) -> bool {
        true
    }
}
impl Law {
    pub(super) fn build(setup: &Setup) -> Result<Self, Refusal> {
        Ok(Self {
            period_us: setup.period_us,
        })
    }
    pub(super) fn period_us(&self) -> u32 {
        self.period_us
    }
    pub(super) fn reset(&mut self, _q: [f32; JOINTS]) {}
    pub(super) fn update(&mut self, _m: [Option<f32>; JOINTS], _t: [f32; JOINTS]) -> Estimate {
        Estimate {
            angle_rad: [0.0; JOINTS],
            speed_rad_s: [0.0; JOINTS],
        }
    }
    pub(super) fn predict(&self, _t: [f32; JOINTS]) -> Estimate {
        Estimate {
            angle_rad: [0.0; JOINTS],
            speed_rad_s: [0.0; JOINTS],
        }
    }
    pub(super) fn regulate(&self, _s: &Estimate, _r: [f32; JOINTS]) -> [f32; JOINTS] {
        [0.0; JOINTS]
    }
    pub(super) fn pwm(&self, _t: [f32; JOINTS]) -> Option<[Pwm; JOINTS]> {
        Some([Pwm::OFF; JOINTS])
    }
    pub(super) fn torque_of(&self, _p: [Pwm; JOINTS]) -> [f32; JOINTS] {
        [0.0; JOINTS]
    }
    pub(super) fn angle_of(&self, _j: usize, s: Sample) -> Option<f32> {
        match s {
            Sample::Counts(c) => Some(c as f32),
            Sample::Missing(_) => None,
        }
    }
}
