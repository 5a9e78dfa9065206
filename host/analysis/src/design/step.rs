//! Step responses of a set-up: of the linear loop and of the simulated bench.

use armbridge_client::refusal_text;
use armbridge_control::actuator::Joint;
use armbridge_link::message::{Mode, Record, Refusal, Setup};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::PlantConfig;

use super::model::LinearLoop;
use crate::monte_carlo::{Maneuver, Run, Trial, TrialError};

/// Step in rad: large relative to an encoder count, and far from all limits.
pub(super) const STEP_RAD: [f32; JOINTS] = [0.15, -0.15];
/// Time shown after the step, in s.
pub(super) const SHOWN_S: f64 = 2.0;
/// Time before the step in which the bench is upright, in s; see [`Maneuver::Step`].
const BEFORE_S: f64 = 2.0;
/// Seed of the bench's noise.
const SEED: u64 = 1;

/// Reason why there is no response.
#[derive(Debug, thiserror::Error)]
pub enum StepError {
    /// The bench did not run.
    #[error("the bench does not run with this set-up: {0}")]
    Trial(#[from] TrialError),
    /// The board would refuse the set-up.
    #[error("the board would refuse this set-up: {}", refusal_text::in_words(*.0))]
    Refused(Refusal),
}

/// A sample of a response.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// Time since the step, in s.
    pub(super) at_s: f64,
    pub(super) angle_rad: [f64; JOINTS],
    pub(super) torque_nm: [f64; JOINTS],
}

/// Both responses.
#[derive(Clone, Debug)]
pub(super) struct Responses {
    pub(super) linear: Vec<Point>,
    pub(super) bench: Vec<Point>,
    /// Fault that ended the bench's run, if any.
    pub(super) fault: Option<&'static str>,
}

/// Computes the response of the loop and simulates that of the bench.
pub(super) fn responses(setup: &Setup) -> Result<Responses, StepError> {
    let system = LinearLoop::from_setup(setup).map_err(StepError::Refused)?;
    let arm = setup.arm.map(f64::from);
    let plant = PlantConfig {
        arm,
        joints: setup.joints.map(|joint| in_double(&joint)),
        ..PlantConfig::default()
    };
    let length_s = BEFORE_S + SHOWN_S;
    let script = Maneuver::Step(STEP_RAD).script(*setup, length_s);
    let script = script.map_err(|_| StepError::Refused(Refusal::OutOfRange))?;
    let run = Trial::new(plant, script).run(SEED)?;
    let fault = |record: &Record| match record.mode {
        Mode::Fault(fault) => Some(fault.name()),
        _ => None,
    };
    Ok(Responses {
        linear: linear(&system, arm.gravity(STEP_RAD.map(f64::from).into()).into()),
        fault: run.records.iter().find_map(fault),
        bench: bench(&run, f64::from(setup.period_us) * 1e-6),
    })
}

/// Response of the linear loop from rest; `holding_nm` holds the arm at the setpoint.
fn linear(system: &LinearLoop, holding_nm: [f64; JOINTS]) -> Vec<Point> {
    let target = STEP_RAD.map(f64::from);
    let mut state = system.at_rest(target.map(|angle| -angle));
    let closed = system.closed();
    let count = (SHOWN_S / system.period_s) as usize;
    let mut points = Vec::with_capacity(count);
    for tick in 0..count {
        let torque = -(system.output * state);
        points.push(Point {
            at_s: tick as f64 * system.period_s,
            angle_rad: [0, 1].map(|joint| target[joint] + state[joint]),
            torque_nm: [0, 1].map(|joint| holding_nm[joint] + torque[joint]),
        });
        state = closed * state;
    }
    points
}

/// Response of the bench's true arm.
fn bench(run: &Run, period_s: f64) -> Vec<Point> {
    let pairs = run.records.iter().zip(&run.truth);
    pairs
        .map(|(record, truth)| {
            let since_us = record.input.start_us.saturating_sub(run.begun_us);
            Point {
                at_s: since_us as f64 * 1e-6 + period_s - BEFORE_S,
                angle_rad: truth.angle_rad,
                torque_nm: truth.torque_nm,
            }
        })
        .collect()
}

fn in_double(joint: &Joint<f32>) -> Joint<f64> {
    let Joint {
        zero_count,
        rad_per_count,
        direction,
        gain_counts_per_nm,
        offset_counts,
    } = *joint;
    Joint {
        zero_count: zero_count.into(),
        rad_per_count: rad_per_count.into(),
        direction,
        gain_counts_per_nm: gain_counts_per_nm.into(),
        offset_counts: offset_counts.into(),
    }
}
