//! Set-ups of a case: servo bus, tick period, estimator and controller.
//!
//! A case draws one from a short table: every combination that the bus is fast enough
//! for, that a board accepts, and that holds the arm without a fault, as tests show.

use std::fmt;

use armbridge_control::estimate::Config;
use armbridge_link::message::{Controller, Gains, Setup};
use armbridge_servo::master::Readiness;
use armbridge_servo::master::timing::tick_us;
use armbridge_servo::{ControlMode, Firmware, JOINTS};
use serde::{Deserialize, Serialize};

use super::activity::Activity;

/// Estimator and controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Control {
    /// The default: LQR with the paper's weights, and an observer.
    Lqr,
    /// [`Setup::best`]: a stiffer LQR, and a Kalman filter that finds disturbances.
    Kalman,
    /// Computed torque, and the default's observer.
    ComputedTorque,
    /// The default's LQR, and filtered differences.
    Difference,
    /// The paper's printed gain, for its own period, and the default's observer.
    Printed,
}

/// Estimator and controller at a tick period.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct SetUp {
    /// Estimator and controller.
    pub control: Control,
    /// Tick period in µs.
    pub period_us: u32,
}

/// All set-ups.
const SET_UPS: [SetUp; 13] = [
    SetUp::new(Control::Lqr, 1_000),
    SetUp::new(Control::Lqr, 2_000),
    SetUp::new(Control::Lqr, 5_000),
    SetUp::new(Control::Lqr, 10_000),
    SetUp::new(Control::Kalman, 1_000),
    SetUp::new(Control::Kalman, 2_000),
    SetUp::new(Control::Kalman, 5_000),
    SetUp::new(Control::Kalman, 10_000),
    SetUp::new(Control::ComputedTorque, 1_000),
    SetUp::new(Control::ComputedTorque, 5_000),
    SetUp::new(Control::Difference, 1_000),
    SetUp::new(Control::Difference, 5_000),
    SetUp::new(Control::Printed, 45_000),
];

/// Servo firmware and nominal speed of the bus in bits per second, with its share of the
/// cases.
const BUSES: [(Firmware, u32, usize); 8] = [
    (Firmware::Morpheus, 1_000_000, 2),
    (Firmware::Morpheus, 500_000, 1),
    (Firmware::Morpheus, 115_200, 1),
    (Firmware::Morpheus, 57_600, 1),
    (Firmware::Stock, 1_000_000, 2),
    (Firmware::Stock, 57_600, 1),
    (Firmware::Stock, 500_000, 1),
    (Firmware::Stock, 115_200, 1),
];

/// Set-ups of X servos alone, beside the others: too fast for any AX-12A.
const FAST_SET_UPS: [SetUp; 2] = [
    SetUp::new(Control::Lqr, 500),
    SetUp::new(Control::Kalman, 500),
];

/// Speed of a bus of X servos, with its share of the cases.
const X_BUSES: [(u32, usize); 4] = [(1_000_000, 3), (4_000_000, 2), (2_000_000, 1), (115_200, 1)];

/// Servos and the speed of their bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Bus {
    /// Firmware of the servos.
    pub servos: Firmware,
    /// Nominal speed in bits per second.
    pub baud: u32,
    /// What the servos are driven by.
    pub mode: ControlMode,
}

impl Bus {
    /// Servos that are driven by PWM.
    pub(super) const fn new(servos: Firmware, baud: u32) -> Self {
        Self {
            servos,
            baud,
            mode: ControlMode::Pwm,
        }
    }

    /// All buses; the usual ones several times.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        BUSES
            .into_iter()
            .flat_map(|(servos, baud, share)| std::iter::repeat_n(Self::new(servos, baud), share))
    }

    /// All buses of X servos; the usual one several times.
    pub(super) fn of_x_servos() -> impl Iterator<Item = Self> {
        let servos = Firmware::XSeries;
        X_BUSES
            .into_iter()
            .flat_map(move |(baud, share)| std::iter::repeat_n(Self::new(servos, baud), share))
    }

    /// The set-ups that it is fast enough for, and that this work of the board permits.
    pub(super) fn set_ups(self, activity: Activity) -> Vec<SetUp> {
        let least_us = tick_us(self.servos, self.baud, Readiness::Prepared);
        let is_possible =
            |set_up: &SetUp| set_up.period_us >= least_us && activity.permits(set_up.period_us);
        match self.servos {
            Firmware::Morpheus | Firmware::Stock => {
                SET_UPS.into_iter().filter(is_possible).collect()
            }
            Firmware::XSeries => FAST_SET_UPS
                .into_iter()
                .chain(SET_UPS)
                .filter(is_possible)
                .collect(),
        }
    }
}

impl SetUp {
    const fn new(control: Control, period_us: u32) -> Self {
        Self { control, period_us }
    }

    /// Parameters of the board.
    pub fn setup(self) -> Setup {
        let default = Setup::default();
        let of_control = match self.control {
            Control::Lqr => default,
            Control::Kalman => Setup::best(),
            Control::ComputedTorque => Setup {
                controller: Controller::ComputedTorque {
                    natural_rad_s: [15.0; JOINTS],
                    damping: [1.0; JOINTS],
                },
                ..default
            },
            Control::Difference => Setup {
                estimator: Config::FiniteDifference { filter_s: 0.02 },
                ..default
            },
            Control::Printed => Setup {
                controller: Controller::StateFeedback(Gains::Paper),
                ..default
            },
        };
        Setup {
            period_us: self.period_us,
            ..of_control
        }
    }
}

impl fmt::Display for Bus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let firmware = match self.servos {
            Firmware::Morpheus => "morpheus",
            Firmware::Stock => "stock",
            Firmware::XSeries => "x",
        };
        let mode = match self.mode {
            ControlMode::Pwm => "",
            ControlMode::Current => " by current",
        };
        write!(f, "{firmware}{mode} {} Bd", self.baud)
    }
}

impl fmt::Display for SetUp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let control = match self.control {
            Control::Lqr => "lqr",
            Control::Kalman => "kalman",
            Control::ComputedTorque => "computed",
            Control::Difference => "difference",
            Control::Printed => "printed",
        };
        write!(f, "{control} {} ms", f64::from(self.period_us) / 1e3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_board::bridge::settings_refusal;
    use armbridge_link::message::Settings;

    #[test]
    fn every_set_up_is_accepted_and_has_a_bus() {
        let all = || Bus::all().chain(Bus::of_x_servos());
        for set_up in SET_UPS.into_iter().chain(FAST_SET_UPS) {
            let settings = Settings {
                setup: set_up.setup(),
                ..Settings::default()
            };
            assert_eq!(settings_refusal(&settings), None, "{set_up:?}");
            assert!(all().any(|bus| bus.set_ups(Activity::Idle).contains(&set_up)));
        }
        assert!(Bus::all().all(|bus| bus.set_ups(Activity::Idle).len() >= 3));
        assert!(Bus::of_x_servos().all(|bus| bus.set_ups(Activity::Idle).len() >= 2));
    }
}
