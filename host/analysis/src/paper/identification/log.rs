//! The paper's two experiments in a log of the board.
//!
//! A free fall is joint 1 with its motor off, PWM 1000, in an experiment; a constant input
//! is one PWM all the time, in an experiment or as a torque. Both begin with the tick in
//! which that PWM is in force and end with the last in which it is: when the experiment
//! ends, or a guard brakes. Before, the arm is at rest, and its encoder shows where.

use armbridge_log::run_info::RunFacts;
use armbridge_shared::actuator::Pwm;
use armbridge_shared::link::message::{Drive, Guards, Record};

use super::sampled::{Kind, Sampled, Start};

/// Shortest experiment in s: half of what a fall from half a radian takes.
const SHORTEST_S: f64 = 0.25;
/// The least way that is of use, in rad: 30 counts.
const LEAST_RAD: f64 = 0.15;
/// Farthest that joint 2 may be from straight, in rad: gravity on joint 1 is 0.2 % off.
const STRAIGHT_RAD: f32 = 0.1;
/// How long the arm is looked at before, in s: an error of the start grows sixfold.
const BEFORE_S: f64 = 0.25;
/// How far apart the two halves of that may be, in rad, of an arm at rest: 2 counts.
const AT_REST_RAD: f64 = 0.01;
/// Counts from either end of an encoder's track in which its reading is invalid.
const END_COUNTS: u16 = 3;

/// Why a log has nothing of use.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoExperiment {
    /// Neither experiment is in it.
    #[error(
        "there is neither a free fall nor a constant input on joint 1 that moves it by {LEAST_RAD} \
         rad from rest: record them by `armbridge run paper-free-fall` and `armbridge run \
         paper-constant-input`"
    )]
    None,
    /// Joint 2 is not straight.
    #[error(
        "joint 2 is {angle_rad:+.2} rad from straight in the {}: the procedure is for a straight \
         arm; hold joint 2 at 0, as `armbridge run paper-free-fall` does",
        kind.name()
    )]
    Bent {
        /// In which experiment.
        kind: Kind,
        /// How far.
        angle_rad: f32,
    },
}

/// The experiments in a log, in order.
///
/// # Errors
/// If there is none.
pub fn sampled(records: &[Record], facts: &RunFacts) -> Result<Vec<Sampled>, NoExperiment> {
    let mut all = Vec::new();
    let mut first = 0;
    for chunk in records.chunk_by(is_same) {
        if let Some(sampled) = experiment(&records[..first], chunk, facts)? {
            all.push(sampled);
        }
        first += chunk.len();
    }
    if all.is_empty() {
        return Err(NoExperiment::None);
    }
    Ok(all)
}

/// Whether two ticks may be of one experiment.
fn is_same(a: &Record, b: &Record) -> bool {
    b.tick == a.tick.wrapping_add(1) && a.pwm_in_force[0] == b.pwm_in_force[0] && kind(a) == kind(b)
}

fn kind(record: &Record) -> Option<Kind> {
    let is_off = record.pwm_in_force[0] == Pwm::OFF.counts();
    if record.guards != Guards::NONE {
        return None;
    }
    match record.mode.drive()? {
        Drive::Experiment if is_off => Some(Kind::FreeFall),
        Drive::Experiment | Drive::Torque if !is_off => Some(Kind::ConstantInput),
        Drive::Experiment | Drive::Torque | Drive::Regulate | Drive::Track | Drive::Hold => None,
    }
}

/// What these ticks are of, if they are of use.
fn experiment(
    before: &[Record],
    during: &[Record],
    facts: &RunFacts,
) -> Result<Option<Sampled>, NoExperiment> {
    let Some(kind) = during.first().and_then(kind) else {
        return Ok(None);
    };
    let period_s = f64::from(facts.period_us) * 1e-6;
    let angle = |record: &Record| {
        let range = END_COUNTS..=1023 - END_COUNTS;
        let counts = record.samples[0].counts()?;
        let on_track = range.contains(&counts);
        on_track.then(|| facts.angle_rad(0, counts))
    };
    let looks = (BEFORE_S / period_s).ceil() as usize;
    let Some(start_rad) = at_rest(&before[before.len().saturating_sub(looks)..], angle) else {
        return Ok(None);
    };
    let angles_rad: Vec<Option<f64>> = during.iter().map(angle).collect();
    let long_enough = during.len() as f64 * period_s >= SHORTEST_S;
    let moved = |last: &f64| (last - start_rad).abs() >= LEAST_RAD;
    if !(long_enough && angles_rad.iter().flatten().next_back().is_some_and(moved)) {
        return Ok(None);
    }
    let bent = during.iter().map(|record| record.angle_rad[1]);
    let angle_rad = bent.fold(0.0_f32, |a, b| if b.abs() > a.abs() { b } else { a });
    if angle_rad.abs() > STRAIGHT_RAD {
        return Err(NoExperiment::Bent { kind, angle_rad });
    }
    let pwm = Pwm::saturating(during[0].pwm_in_force[0]);
    let told_nm = f64::from(facts.setup.joints[0].torque(pwm));
    Ok(Some(Sampled {
        kind,
        period_s,
        angles_rad,
        start_rad,
        start: Start::Found,
        told_nm: (kind == Kind::ConstantInput).then_some(told_nm),
    }))
}

/// Where the arm is before, if it is at rest there.
fn at_rest(before: &[Record], angle: impl Fn(&Record) -> Option<f64>) -> Option<f64> {
    let mean = |records: &[Record]| {
        let seen: Vec<f64> = records.iter().filter_map(&angle).collect();
        (!seen.is_empty()).then(|| seen.iter().sum::<f64>() / seen.len() as f64)
    };
    let (early, late) = before.split_at(before.len() / 2);
    let apart_rad = (mean(early)? - mean(late)?).abs();
    (apart_rad < AT_REST_RAD).then(|| mean(before)).flatten()
}
