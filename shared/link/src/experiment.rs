//! Experiment in the format of the link: source of each joint, duration, and envelope of
//! angles and speeds.
//!
//! It begins from where the arm is and ends in [`Drive::Hold`](super::mode::Drive), the
//! arm braked to rest, when its time is over, when a joint leaves the envelope, or when
//! the host is silent. All monitors stay in force: they limit the torque, or switch it
//! off, as in every drive.

use super::limits::hard;
use armbridge_control::experiment::{DURATION_MAX_S, Flaw, Signal, TIME_MIN_S};
use armbridge_servo::JOINTS;
use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Time for which a joint is held before its PWM is frozen, in s.
pub const HELD_S: f32 = 0.25;

/// An experiment on the arm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Role of each joint.
    pub roles: [Role; JOINTS],
    /// Duration in s.
    pub duration_s: f32,
    /// Least and most angle of each joint in rad; beyond them the experiment ends.
    pub angle_rad: [[f32; 2]; JOINTS],
    /// Speed of each joint in rad/s; faster for 10 ms, the experiment ends.
    pub speed_rad_s: [f32; JOINTS],
}

/// Source that drives a joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Nothing: its motor is off, PWM 1000 exactly.
    Off,
    /// The controller, which holds it where it is asked to be when the experiment
    /// begins.
    Hold,
    /// A PWM, in counts from off as the servo counts them, rounded; 0 is off exactly.
    Pwm(Signal<f32>),
    /// Held for [`HELD_S`]; and then the PWM that held it on average, plus this many counts,
    /// rounded. The signal begins then. So a joint is released slowly, or pushed harder
    /// and harder, from a torque that need not be known.
    Bias(Signal<f32>),
    /// A torque in N m, by way of the actuator.
    Torque(Signal<f32>),
    /// The controller, which makes it follow an angle in rad from where it is asked to
    /// be when the experiment begins. Only what is smooth and begins at 0: a sinusoid,
    /// a chirp or a multisine with a ramp, or the constant 0.
    Angle(Signal<f32>),
}

impl Role {
    /// The signal, if there is one.
    pub const fn signal(&self) -> Option<&Signal<f32>> {
        match self {
            Self::Off | Self::Hold => None,
            Self::Pwm(signal) | Self::Bias(signal) | Self::Torque(signal) | Self::Angle(signal) => {
                Some(signal)
            }
        }
    }

    /// Whether the controller keeps the joint at a reference.
    pub const fn is_held(&self) -> bool {
        match self {
            Self::Hold | Self::Angle(_) => true,
            Self::Off | Self::Pwm(_) | Self::Bias(_) | Self::Torque(_) => false,
        }
    }
}

/// Quantity of a value of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Measure {
    /// In rad.
    Angle,
    /// In rad/s.
    Speed,
    /// In rad/s^2.
    Acceleration,
    /// In N m.
    Torque,
    /// In PWM counts from off.
    Pwm,
}

/// Reason for the refusal of an experiment. Joints count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub enum Objection {
    /// It would take too long, or no time.
    Duration {
        /// In s.
        value_s: f32,
    },
    /// Not an envelope: the least angle is not below the most, or either of them or
    /// the speed is beyond what any arm is allowed.
    Envelope {
        /// Of this joint.
        joint: u8,
    },
    /// The numbers of this joint's signal make none.
    Signal {
        /// This joint.
        joint: u8,
        /// Why.
        flaw: Flaw,
    },
    /// An angle cannot follow what has edges, or does not begin at 0.
    Rough {
        /// Of this joint.
        joint: u8,
    },
    /// More is asked for than is allowed. An angle, a speed and an acceleration are those
    /// of the reference, but a speed without an angle signal is that of the envelope.
    Beyond {
        /// Of this joint.
        joint: u8,
        /// Measure concerned.
        measure: Measure,
        /// Requested value, in the unit of the measure.
        value: f32,
        /// Allowed value.
        limit: f32,
    },
    /// The envelope reaches beyond where the arm is braked before its angle limit, if it
    /// comes there as fast as the envelope lets it.
    Edge {
        /// Of this joint.
        joint: u8,
        /// The envelope's edge in rad.
        edge_rad: f32,
        /// The envelope's speed in rad/s.
        speed_rad_s: f32,
        /// The farthest that an edge may be at that speed, in rad from upright.
        farthest_rad: f32,
    },
    /// The arm is not in the envelope.
    Outside {
        /// This joint.
        joint: u8,
        /// Where it is, in rad.
        angle_rad: f32,
        /// Where it may be, in rad.
        within_rad: [f32; 2],
    },
    /// The arm moves faster than the experiment allows.
    Moving {
        /// This joint.
        joint: u8,
        /// Speed in rad/s.
        speed_rad_s: f32,
        /// Allowed speed in rad/s.
        limit_rad_s: f32,
    },
}

/// The end of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub struct Conclusion {
    /// The first tick that did without it, or the last that it decided.
    pub tick: u32,
    /// Why.
    pub end: ExperimentEnd,
}

/// Cause of the end of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema, MaxSize)]
pub enum ExperimentEnd {
    /// Its time is over.
    Finished,
    /// A joint left the envelope.
    Angle {
        /// Index of the joint.
        joint: u8,
        /// Where it was, in rad.
        value_rad: f32,
    },
    /// A joint was faster than the envelope allows.
    Speed {
        /// Index of the joint.
        joint: u8,
        /// Speed in rad/s.
        value_rad_s: f32,
    },
    /// The host was silent for too long.
    HostQuiet,
    /// The host wanted something else.
    Replaced,
}

impl Experiment {
    /// No experiment, of duration 0.
    pub const NONE: Self = Self {
        roles: [Role::Off; JOINTS],
        duration_s: 0.0,
        angle_rad: [[0.0; 2]; JOINTS],
        speed_rad_s: [0.0; JOINTS],
    };

    /// Checks consistency and hard bounds of the experiment.
    ///
    /// # Errors
    /// The reason for the refusal.
    pub fn check(&self) -> Result<(), Objection> {
        let duration_s = self.duration_s;
        if !(TIME_MIN_S as f32..=DURATION_MAX_S as f32).contains(&duration_s) {
            return Err(Objection::Duration {
                value_s: duration_s,
            });
        }
        let envelopes = self.angle_rad.into_iter().zip(self.speed_rad_s);
        for ((joint, role), ([low, high], speed)) in (0..).zip(&self.roles).zip(envelopes) {
            let is_within = low >= -hard::ANGLE_RAD && high <= hard::ANGLE_RAD && low < high;
            if !(is_within && speed > 0.0 && speed <= hard::SPEED_RAD_S) {
                return Err(Objection::Envelope { joint });
            }
            role.check(joint, duration_s)?;
        }
        Ok(())
    }
}

impl Role {
    fn check(&self, joint: u8, duration_s: f32) -> Result<(), Objection> {
        let Some(signal) = self.signal() else {
            return Ok(());
        };
        if let Some(flaw) = signal.flaw(duration_s) {
            return Err(Objection::Signal { joint, flaw });
        }
        let bounds = signal.bounds(duration_s);
        let (measure, limit) = match self {
            Self::Off | Self::Hold => return Ok(()),
            Self::Pwm(_) | Self::Bias(_) => (Measure::Pwm, f32::from(hard::PWM_COUNTS)),
            Self::Torque(_) => (Measure::Torque, hard::TORQUE_NM),
            Self::Angle(_) if bounds.derivatives.is_none() => {
                return Err(Objection::Rough { joint });
            }
            // From one end to the other.
            Self::Angle(_) => (Measure::Angle, 2.0 * hard::ANGLE_RAD),
        };
        let value = bounds.farthest();
        // NaN is beyond every limit.
        if value.abs() <= limit {
            Ok(())
        } else {
            Err(Objection::Beyond {
                joint,
                measure,
                value,
                limit,
            })
        }
    }
}
