//! The paper's two experiments in a log of the board.
//!
//! A free fall is joint 1 with its motor off, PWM 1000, in an experiment; a constant input
//! is one constant PWM, in an experiment or as a torque. Both begin with the first tick in
//! which that PWM is in force and end with the last: when the experiment
//! ends, or a guard brakes. Before, the arm is at rest, and its encoder gives the start angle.

use armbridge_link::message::{Drive, Guards, Record};
use armbridge_log::run_info::RunFacts;
use armbridge_servo::Pwm;

use super::sampled_experiment::{ExperimentKind, InitialState, SampledExperiment};

/// Shortest experiment in s: half the time of a fall from half a radian.
const MIN_DURATION_S: f64 = 0.25;
/// Smallest motion in rad: 30 counts.
const MIN_MOTION_RAD: f64 = 0.15;
/// Largest angle of joint 2 from straight, in rad: the gravity torque on joint 1 is then
/// 0.2 % in error.
const STRAIGHT_RAD: f32 = 0.1;
/// Time before the experiment in which the start angle is averaged, in s: an error of the
/// start grows sixfold.
const BEFORE_S: f64 = 0.25;
/// Largest difference between the means of both halves of that time for an arm at rest, in
/// rad: 2 counts.
const AT_REST_RAD: f64 = 0.01;
/// Counts at either end of the encoder's track at which its reading is invalid.
const END_COUNTS: u16 = 3;

/// Reason why a log has no usable experiment.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoExperiment {
    /// Neither experiment is in it.
    #[error(
        "there is neither a free fall nor a constant input that moves joint 1 by {MIN_MOTION_RAD} \
         rad from rest: record them with `armbridge run paper-free-fall` and `armbridge run \
         paper-constant-input`"
    )]
    None,
    /// Joint 2 is not straight.
    #[error(
        "joint 2 is {angle_rad:+.2} rad from straight in the {}: the procedure requires a straight \
         arm; hold joint 2 at 0, as `armbridge run paper-free-fall` does",
        kind.name()
    )]
    Bent {
        /// The experiment.
        kind: ExperimentKind,
        /// Largest angle of joint 2 in rad.
        angle_rad: f32,
    },
}

/// Experiments in a log, in order.
///
/// # Errors
/// If there is none.
pub fn experiments(
    records: &[Record],
    facts: &RunFacts,
) -> Result<Vec<SampledExperiment>, NoExperiment> {
    let mut experiments = Vec::new();
    let mut first = 0;
    for chunk in records.chunk_by(is_same_experiment) {
        if let Some(sampled) = experiment(&records[..first], chunk, facts)? {
            experiments.push(sampled);
        }
        first += chunk.len();
    }
    if experiments.is_empty() {
        return Err(NoExperiment::None);
    }
    Ok(experiments)
}

/// Whether two ticks can belong to one experiment.
fn is_same_experiment(a: &Record, b: &Record) -> bool {
    b.tick == a.tick.wrapping_add(1)
        && a.input.pwm_in_force[0] == b.input.pwm_in_force[0]
        && kind(a) == kind(b)
}

fn kind(record: &Record) -> Option<ExperimentKind> {
    let is_off = record.input.pwm_in_force[0] == Pwm::OFF.counts();
    if record.output.guards != Guards::NONE {
        return None;
    }
    match record.mode.drive()? {
        Drive::Experiment if is_off => Some(ExperimentKind::FreeFall),
        Drive::Experiment | Drive::Torque if !is_off => Some(ExperimentKind::ConstantInput),
        Drive::Experiment
        | Drive::Torque
        | Drive::Regulate
        | Drive::Track
        | Drive::Hold
        | Drive::Float
        | Drive::Park => None,
    }
}

/// Experiment in the ticks `during`, if it is usable.
fn experiment(
    before: &[Record],
    during: &[Record],
    facts: &RunFacts,
) -> Result<Option<SampledExperiment>, NoExperiment> {
    let Some(kind) = during.first().and_then(kind) else {
        return Ok(None);
    };
    let period_s = f64::from(facts.period_us) * 1e-6;
    let angle = |record: &Record| {
        let range = END_COUNTS..=1023 - END_COUNTS;
        let counts = record.input.samples[0].counts()?;
        let on_track = range.contains(&counts);
        on_track.then(|| facts.angle_rad(0, counts))
    };
    let samples_before = (BEFORE_S / period_s).ceil() as usize;
    let first_before = before.len().saturating_sub(samples_before);
    let Some(start_rad) = rest_angle(&before[first_before..], angle) else {
        return Ok(None);
    };
    let angles_rad: Vec<Option<f64>> = during.iter().map(angle).collect();
    let long_enough = during.len() as f64 * period_s >= MIN_DURATION_S;
    let moved = |last: &f64| (last - start_rad).abs() >= MIN_MOTION_RAD;
    if !(long_enough && angles_rad.iter().flatten().next_back().is_some_and(moved)) {
        return Ok(None);
    }
    let angles = during.iter().map(|record| record.output.angle_rad[1]);
    let angle_rad = angles.fold(0.0_f32, |a, b| if b.abs() > a.abs() { b } else { a });
    if angle_rad.abs() > STRAIGHT_RAD {
        return Err(NoExperiment::Bent { kind, angle_rad });
    }
    let pwm = Pwm::saturating(during[0].input.pwm_in_force[0]);
    let commanded_nm = f64::from(facts.setup.joints[0].torque(pwm));
    Ok(Some(SampledExperiment {
        kind,
        period_s,
        angles_rad,
        start_rad,
        start: InitialState::Estimated,
        commanded_nm: (kind == ExperimentKind::ConstantInput).then_some(commanded_nm),
    }))
}

/// Mean angle before the experiment in rad, if the arm is at rest.
fn rest_angle(before: &[Record], angle: impl Fn(&Record) -> Option<f64>) -> Option<f64> {
    let mean = |records: &[Record]| {
        let angles: Vec<f64> = records.iter().filter_map(&angle).collect();
        (!angles.is_empty()).then(|| angles.iter().sum::<f64>() / angles.len() as f64)
    };
    let (early, late) = before.split_at(before.len() / 2);
    let difference_rad = (mean(early)? - mean(late)?).abs();
    (difference_rad < AT_REST_RAD)
        .then(|| mean(before))
        .flatten()
}
