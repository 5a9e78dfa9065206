//! The monitors as a whole.

mod check;
mod limit;
mod plant;
mod soft_stop;

use super::{LimitedTorque, MonitorConfig, MonitorInput, Monitors};
use armbridge_control::actuator::Joint;
use armbridge_control::arm::{Parameters, State};
use armbridge_link::limits::Limits;
use armbridge_link::record::Violation;
use nalgebra::Vector2;

/// Monitors with their numbers.
struct Fixture {
    config: MonitorConfig,
    monitors: Monitors,
}

impl Fixture {
    fn new(limits: Limits, period_us: u32) -> Self {
        Self {
            config: MonitorConfig::new(limits, &[Joint::paper(); 2], period_us),
            monitors: Monitors::default(),
        }
    }

    fn restart(&mut self) {
        self.monitors = Monitors::default();
    }

    fn limits(&self) -> &Limits {
        self.config.limits()
    }

    fn check(&mut self, seen: &MonitorInput<'_>) -> Result<(), Violation> {
        self.monitors.check(&self.config, seen)
    }

    fn limit(
        &mut self,
        arm: &Parameters<f32>,
        state: &State<f32>,
        wanted_nm: Vector2<f32>,
        before_nm: Vector2<f32>,
    ) -> Result<LimitedTorque, Violation> {
        self.monitors
            .limit(&self.config, arm, state, wanted_nm, before_nm, [false; 2])
    }

    fn pwm(&mut self, is_limited: bool) -> Result<(), Violation> {
        self.monitors.note_pwm(&self.config, is_limited)
    }
}
