//! A case: a scenario and injected faults, derived from the seed.
//!
//! Seed 2k has one fault, seed 2k + 1 a pair. Kinds, pairs and scenarios alternate, so
//! that any sequence of seeds covers all evenly: 34 kinds in six scenarios are 204
//! singles, and there are 561 pairs. All other properties are random.

use armbridge_shared::JOINTS;
use armbridge_shared::arm::State;
use armbridge_shared::link::message::{Command, Limits, Setup};
use armbridge_shared::link::motion::Motion;
use armbridge_shared::servo::Firmware;
use nalgebra::Vector2;
use serde::Serialize;

use super::draw::Random;
use super::kind::{DamageKind, Kind};
use crate::plant::PlantConfig;

/// Observation time of a fault, in µs: three times the longest time that a limit
/// permits, which is the host's silence.
const OBSERVATION_US: u64 = 1_500_000;
/// The same for heat: a Morpheus servo reads its temperature every 0.8 s.
const OBSERVATION_HOT_US: u64 = 3_000_000;

/// Motion of the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scenario {
    /// It holds an angle near upright, after a step there.
    Regulate,
    /// It follows a sine.
    Sine,
    /// It moves from point to point.
    MinimumJerk,
    /// A small constant torque, which dry friction holds.
    Torque,
    /// Armed, with zero torque; dry friction holds the arm.
    Armed,
    /// Disarmed; dry friction holds the arm.
    Idle,
}

impl Scenario {
    const ALL: [Self; 6] = [
        Self::Regulate,
        Self::Sine,
        Self::MinimumJerk,
        Self::Torque,
        Self::Armed,
        Self::Idle,
    ];

    /// Whether the motors are driven.
    pub fn is_driven(self) -> bool {
        !matches!(self, Self::Armed | Self::Idle)
    }

    /// Whether a controller closes the loop.
    pub fn is_closed(self) -> bool {
        matches!(self, Self::Regulate | Self::Sine | Self::MinimumJerk)
    }
}

/// One fault, with its time and magnitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Injection {
    /// Kind of fault.
    pub kind: Kind,
    /// Delay after the start of the scenario, in µs.
    pub after_us: u64,
    /// Duration, in µs.
    pub lasts_us: u64,
    /// Servo or joint, for kinds that affect one.
    pub servo: usize,
    /// Magnitude: share of bytes, N m, counts a second, ms.
    pub amount: f64,
    /// Delay of late bytes, in µs.
    pub late_us: u64,
    /// Seed of its random numbers.
    pub seed: u64,
}

/// One run.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is drawn independently, and they do not exclude each other"
)]
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// Seed of everything but the servos.
    pub seed: u64,
    /// Firmware of the servos.
    pub servos: Firmware,
    /// Motion of the arm.
    pub scenario: Scenario,
    /// [`Setup::best`] rather than the default.
    pub is_best: bool,
    /// Dry friction in the joints.
    pub friction: bool,
    /// Tighter limits than the default.
    pub is_tight: bool,
    /// The fault is cleared at the end.
    pub is_cleared: bool,
    /// Initial joint angles, in rad.
    pub initial_rad: [f64; JOINTS],
    /// Target angles, or amplitudes, in rad.
    pub to_rad: [f32; JOINTS],
    /// Injected faults, earliest first.
    pub injections: Vec<Injection>,
}

impl Case {
    /// The case of a seed, with servos of this firmware.
    pub fn new(seed: u64, servos: Firmware) -> Self {
        let mut draw = Random::new(seed);
        let index = seed / 2;
        let (kinds, rounds) = if seed.is_multiple_of(2) {
            let kinds = Kind::ALL.len() as u64;
            (vec![Kind::ALL[(index % kinds) as usize]], index / kinds)
        } else {
            let (a, b, pairs) = pair(index);
            // The next occurrence of a pair has another scenario.
            (vec![a, b], 2 * (index / pairs) + index)
        };
        let scenario = Scenario::ALL[(rounds % Scenario::ALL.len() as u64) as usize];
        // Without a closed loop only friction holds the arm.
        let holds = !scenario.is_closed();
        let reach = if holds { 0.02 } else { 0.25 };
        let mut angles = |reach: f64| [0; JOINTS].map(|_| draw.uniform(-reach, reach));
        let (initial_rad, to_rad) = (angles(reach), angles(0.3).map(|q| q as f32));
        let first_us = draw.log_uniform_us(300.0, 800.0);
        let mut injections: Vec<Injection> = kinds
            .iter()
            .enumerate()
            .map(|(nth, kind)| {
                let later_us = if nth == 0 { 0 } else { draw.below(100_000) };
                draw_injection(*kind, first_us + later_us, &mut draw)
            })
            .collect();
        injections.sort_by_key(|injection| injection.after_us);
        Self {
            seed,
            servos,
            scenario,
            is_best: draw.coin(),
            friction: draw.coin() || holds,
            is_tight: draw.below(4) == 0,
            is_cleared: draw.coin(),
            initial_rad,
            to_rad,
            injections,
        }
    }

    /// Set-up of the board.
    pub fn setup(&self) -> Setup {
        if self.is_best {
            Setup::best()
        } else {
            Setup::default()
        }
    }

    /// Limits of the board.
    pub fn limits(&self) -> Limits {
        if self.is_tight {
            Limits {
                pwm_counts: 800,
                torque_nm: [0.8; JOINTS],
                ..Limits::default()
            }
        } else {
            Limits::default()
        }
    }

    /// The virtual arm.
    pub fn plant(&self) -> PlantConfig {
        PlantConfig {
            friction_on: self.friction,
            initial: State::at_rest(Vector2::from(self.initial_rad)),
            ..PlantConfig::default()
        }
    }

    /// Command that starts the scenario; `None` where there is none.
    pub fn command(&self) -> Option<Command> {
        Some(match self.scenario {
            Scenario::Regulate => Command::Regulate(self.to_rad),
            Scenario::Sine => Command::Follow(Motion::Sinusoid {
                centre_rad: [0.0; JOINTS],
                amplitude_rad: self.to_rad,
                frequency_hz: [0.8, 0.6],
                phase_rad: [0.0; JOINTS],
                ramp_s: 1.0,
                duration_s: 10.0,
            }),
            Scenario::MinimumJerk => Command::Follow(Motion::MinimumJerk {
                to_rad: self.to_rad,
                duration_s: Some(1.5),
            }),
            Scenario::Torque => Command::Torque([0.01; JOINTS]),
            Scenario::Armed | Scenario::Idle => return None,
        })
    }

    /// Whether the master receives its echo from the beginning.
    pub fn echoes(&self) -> bool {
        self.has(Kind::EchoOff)
    }

    /// Whether a fault of this kind is injected.
    pub fn has(&self, kind: Kind) -> bool {
        self.injections.iter().any(|i| i.kind == kind)
    }

    /// Observation time after the last injection, in µs.
    pub(crate) fn observation_us(&self) -> u64 {
        if self.has(Kind::Hot) {
            OBSERVATION_HOT_US
        } else {
            OBSERVATION_US
        }
    }
}

/// Pair of kinds with this index, and the number of pairs.
fn pair(index: u64) -> (Kind, Kind, u64) {
    let kinds = Kind::ALL.len();
    let pairs = (kinds * (kinds - 1) / 2) as u64;
    // A stride coprime to the number of pairs visits all of them, and separates those
    // of one kind.
    let mut left = (index.wrapping_mul(271) % pairs) as usize;
    let mut first = 0;
    while left >= kinds - 1 - first {
        left -= kinds - 1 - first;
        first += 1;
    }
    (Kind::ALL[first], Kind::ALL[first + 1 + left], pairs)
}

/// Draws duration and amount of a fault.
fn draw_injection(kind: Kind, after_us: u64, draw: &mut Random) -> Injection {
    /// Duration of faults that last until they are removed.
    const UNTIL_REMOVED_US: u64 = u64::MAX / 4;

    let (lasts_us, amount) = match kind {
        Kind::Bytes(..) => match draw.below(3) {
            // Rarely, without end.
            0 => (UNTIL_REMOVED_US, draw.log_uniform(1e-4, 5e-3)),
            // Often, for a while.
            1 => (draw.log_uniform_us(5.0, 800.0), draw.log_uniform(0.02, 0.9)),
            // All or nearly all.
            _ => (draw.log_uniform_us(1.0, 800.0), draw.uniform(0.95, 1.0)),
        },
        Kind::EchoOn | Kind::EchoOff => (draw.log_uniform_us(1.0, 1_000.0), 0.0),
        Kind::LineLow | Kind::LineHigh | Kind::ServoMute | Kind::ServoDeaf => {
            (draw.log_uniform_us(0.05, 800.0), 0.0)
        }
        Kind::Hot => (UNTIL_REMOVED_US, draw.uniform(300.0, 1_000.0)),
        Kind::HostVanish => {
            let is_short = draw.coin();
            let short_us = draw.log_uniform_us(30.0, 450.0);
            (if is_short { short_us } else { UNTIL_REMOVED_US }, 0.0)
        }
        Kind::HostFlood => (draw.log_uniform_us(20.0, 500.0), 0.0),
        // Beside the host's own frames, or instead of them.
        Kind::HostReplay => (UNTIL_REMOVED_US, draw.below(2) as f64),
        Kind::ClockAhead | Kind::ClockBack => (0, draw.log_uniform(1.0, 100.0)),
        Kind::Push => {
            let torque_nm = draw.uniform(0.3, 3.0);
            let sign = if draw.coin() { 1.0 } else { -1.0 };
            (draw.log_uniform_us(50.0, 500.0), sign * torque_nm)
        }
        Kind::ServosSwapped
        | Kind::Frozen
        | Kind::DeadZone
        | Kind::HostGarbage
        | Kind::HostSchema
        | Kind::HostRange => (UNTIL_REMOVED_US, 0.0),
        Kind::ServoReset | Kind::Goodbye | Kind::Corrupt | Kind::StopHost | Kind::StopPin => {
            (0, 0.0)
        }
    };
    let late_us = match kind {
        Kind::Bytes(_, DamageKind::Late) => draw.log_uniform_us(0.02, 2.0),
        _ => 0,
    };
    Injection {
        kind,
        after_us,
        lasts_us,
        servo: draw.below(JOINTS as u64) as usize,
        amount,
        late_us,
        seed: draw.below(1 << 32),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn kinds_pairs_and_scenarios_take_turns() {
        let mut singles = HashMap::new();
        let mut pairs = HashMap::new();
        for seed in 0..2 * 561 * 6 {
            let case = Case::new(seed, Firmware::Morpheus);
            assert_eq!(case, Case::new(seed, Firmware::Morpheus));
            let scenario = case.scenario as usize;
            match case.injections.as_slice() {
                [only] => *singles.entry((only.kind, scenario)).or_insert(0) += 1,
                [a, b] => {
                    assert!(b.after_us - a.after_us <= 100_000);
                    let mut names = [a.kind.name(), b.kind.name()];
                    names.sort_unstable();
                    *pairs.entry((names, scenario)).or_insert(0) += 1;
                }
                _ => panic!("{case:?}"),
            }
        }
        assert_eq!((singles.len(), pairs.len()), (34 * 6, 561 * 6));
        assert!(singles.values().all(|cases| (16..=17).contains(cases)));
        assert!(pairs.values().all(|cases| *cases == 1));
    }
}
