//! Maneuvers of the arm, as written on a command line.

use std::str::FromStr;

use armbridge_board::bridge::limits::REFERENCE_MAX_RAD;
use armbridge_link::message::{Command, Setup};
use armbridge_link::motion::Motion;
use armbridge_servo::JOINTS;
use serde::Serialize;

use crate::plan_runner::Script;

/// Time upright before a motion, in s.
const STAND_S: f32 = 2.0;
/// Time of rest after a motion, in s.
const REST_S: f32 = 2.0;
/// Time in which a sine's amplitude grows and decays, in s.
const RAMP_S: f32 = 1.0;

/// A maneuver of the arm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Maneuver {
    /// Holds angles in rad throughout.
    Hold([f32; JOINTS]),
    /// Holds upright for 2 s, then steps to angles in rad.
    Step([f32; JOINTS]),
    /// Holds upright for 2 s, then moves to angles along a minimum-jerk trajectory.
    MinimumJerk {
        /// Final angles in rad.
        to_rad: [f32; JOINTS],
        /// Duration in s; `None` for the shortest that the board permits.
        duration_s: Option<f32>,
    },
    /// Holds upright for 2 s, follows a sine or chirp until 2 s before the end, and holds
    /// upright.
    Swing {
        /// Amplitudes in rad.
        amplitude_rad: [f32; JOINTS],
        /// Initial frequency in Hz.
        from_hz: f32,
        /// Final frequency in Hz.
        to_hz: f32,
    },
}

/// Rejection of a maneuver's text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected upright, hold:Q1,Q2, step:Q1,Q2, min-jerk:Q1,Q2[,S], sine:A1,A2,HZ or \
     chirp:A1,A2,HZ,HZ, angles from -{REFERENCE_MAX_RAD} to {REFERENCE_MAX_RAD} rad"
)]
pub struct ManeuverError;

impl Maneuver {
    /// Holds upright throughout.
    pub const UPRIGHT: Self = Self::Hold([0.0; JOINTS]);

    /// Script for a set-up and a duration.
    ///
    /// # Errors
    ///
    /// Returns the minimum duration in s, if `duration_s` is shorter.
    pub fn script(&self, setup: Setup, duration_s: f64) -> Result<Script, f64> {
        let duration_us = (duration_s * 1e6) as u64;
        let (mut commands, min_duration_s) = (vec![(0, Command::Regulate([0.0; JOINTS]))], STAND_S);
        let then_us = (STAND_S * 1e6) as u64;
        let min_duration_s = match *self {
            Self::Hold(q) => {
                commands = vec![(0, Command::Regulate(q))];
                0.0
            }
            Self::Step(q) => {
                commands.push((then_us, Command::Regulate(q)));
                min_duration_s + REST_S
            }
            Self::MinimumJerk { to_rad, duration_s } => {
                let motion = Motion::MinimumJerk { to_rad, duration_s };
                commands.push((then_us, Command::Follow(motion)));
                min_duration_s + duration_s.unwrap_or(0.0) + REST_S
            }
            Self::Swing {
                amplitude_rad,
                from_hz,
                to_hz,
            } => {
                let motion = Motion::Chirp {
                    centre_rad: [0.0; JOINTS],
                    amplitude_rad,
                    from_hz: [from_hz; JOINTS],
                    to_hz: [to_hz; JOINTS],
                    ramp_s: RAMP_S,
                    duration_s: duration_s as f32 - STAND_S - REST_S,
                };
                commands.push((then_us, Command::Follow(motion)));
                min_duration_s + 2.0 * RAMP_S + REST_S
            }
        };
        let min_duration_s = f64::from(min_duration_s);
        if duration_s < min_duration_s {
            return Err(min_duration_s);
        }
        Ok(Script {
            setup,
            limits: Script::limits(),
            commands,
            duration_us,
        })
    }
}

impl FromStr for Maneuver {
    type Err = ManeuverError;

    fn from_str(text: &str) -> Result<Self, ManeuverError> {
        let (name, numbers) = text.split_once(':').unwrap_or((text, ""));
        let numbers: Vec<f32> = numbers
            .split(',')
            .filter(|number| !(numbers.is_empty() && number.is_empty()))
            .map(|number| number.trim().parse().map_err(|_| ManeuverError))
            .collect::<Result<_, _>>()?;
        let is_angle = |q: &f32| q.abs() <= REFERENCE_MAX_RAD;
        if !numbers.iter().take(JOINTS).all(is_angle) {
            return Err(ManeuverError);
        }
        let positive = |x: f32| x > 0.0 && x.is_finite();
        match (name, numbers.as_slice()) {
            ("upright", []) => Ok(Self::UPRIGHT),
            ("hold", &[a, b]) => Ok(Self::Hold([a, b])),
            ("step", &[a, b]) => Ok(Self::Step([a, b])),
            ("min-jerk", &[a, b]) => Ok(Self::MinimumJerk {
                to_rad: [a, b],
                duration_s: None,
            }),
            ("min-jerk", &[a, b, seconds]) if positive(seconds) => Ok(Self::MinimumJerk {
                to_rad: [a, b],
                duration_s: Some(seconds),
            }),
            ("sine", &[a, b, hz]) if positive(hz) => Ok(Self::Swing {
                amplitude_rad: [a, b],
                from_hz: hz,
                to_hz: hz,
            }),
            ("chirp", &[a, b, from_hz, to_hz]) if positive(from_hz) && positive(to_hz) => {
                Ok(Self::Swing {
                    amplitude_rad: [a, b],
                    from_hz,
                    to_hz,
                })
            }
            _ => Err(ManeuverError),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maneuvers_are_parsed() {
        assert_eq!("upright".parse(), Ok(Maneuver::UPRIGHT));
        assert_eq!("hold:0.2,-0.1".parse(), Ok(Maneuver::Hold([0.2, -0.1])));
        let maneuver: Maneuver = "min-jerk:0.3,0.3,1".parse().unwrap();
        let script = maneuver.script(Setup::best(), 8.0).unwrap();
        assert_eq!(script.commands.len(), 2);
        let min_duration_s = maneuver.script(Setup::best(), 4.0).unwrap_err();
        assert!((min_duration_s - 5.0).abs() < 1e-9);
        for wrong in [
            "",
            "up",
            "upright:1",
            "hold:1",
            "hold:2,0",
            "sine:1,1,0",
            "sine:1,1,nan",
        ] {
            assert_eq!(wrong.parse::<Maneuver>(), Err(ManeuverError), "{wrong}");
        }
    }
}
