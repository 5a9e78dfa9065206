//! Performance figures of a run, computed from the true arm.

use armbridge_client::enum_names;
use armbridge_link::message::{Fault, Record, Sample};
use armbridge_log::summary::SETTLED_RAD;
use armbridge_servo::{JOINTS, Pwm};
use serde::Serialize;

use super::{Run, Trial, Truth};

/// Length in s of the end of a run that counts as rest.
pub const REST_S: f64 = 2.0;

/// One value per joint.
pub type Joints = [f64; JOINTS];

/// Performance figures of one run. Errors are true angle minus reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Seed of everything random.
    pub seed: u64,
    /// Time in s until both errors stay below [`SETTLED_RAD`] to the end, or to the first
    /// push, counted from the last change of the reference, or from torque on if it never
    /// changes; `None` for never.
    pub settling_time_s: Option<f64>,
    /// Settling time in s from the beginning of the last push.
    pub recovery_time_s: Option<f64>,
    /// Largest error by magnitude since the first push, in mrad; `None` without
    /// one.
    pub displaced_mrad: Option<Joints>,
    /// Mean error over the last [`REST_S`], in mrad.
    pub mean_error_mrad: Joints,
    /// Root mean square error over the last [`REST_S`], in mrad.
    pub rms_error_mrad: Joints,
    /// Largest minus smallest error over the last [`REST_S`], in mrad.
    pub peak_to_peak_mrad: Joints,
    /// Root mean square error while the reference moves, in mrad; `None` if it
    /// never moves.
    pub tracking_rms_mrad: Option<Joints>,
    /// Root mean square of the motors' torque over the last [`REST_S`], in N m.
    pub torque_rms_nm: Joints,
    /// Largest torque of each motor by magnitude, in N m.
    pub torque_peak_nm: Joints,
    /// Root mean square of estimated minus true speed, in rad/s.
    pub speed_error_rms_rad_s: Joints,
    /// Fraction of ticks with the PWM of either motor saturated, 0 to 1.
    pub saturated_share: f64,
    /// Ticks skipped while torque was on.
    pub missed_ticks: u32,
    /// Samples missing while torque was on.
    pub missing_samples: usize,
    /// Fault that ended the run early.
    pub fault: Option<&'static str>,
}

/// A tick with torque on.
#[derive(Clone, Copy)]
struct Tick<'a> {
    record: &'a Record,
    /// State at the start of the tick, the nominal time of its samples.
    before: &'a Truth,
    /// State at the start of the next tick, to which the reference belongs.
    after: &'a Truth,
    error_rad: Joints,
}

impl Outcome {
    /// Performance figures of a run of `trial`.
    pub fn from_run(trial: &Trial, seed: u64, run: &Run) -> Self {
        let ticks = ticks(run);
        let fault = run
            .records
            .iter()
            .find_map(|r| enum_names::fault_of(r.mode));
        let fault = fault.map(Fault::name);
        let pushed_us = |push: &armbridge_sim::plant::Push| run.begun_us + push.start_ns / 1_000;
        let first_push_us = trial.pushes.iter().map(pushed_us).min();
        let last_push_us = trial.pushes.iter().map(pushed_us).max();
        let (before, after): (Vec<Tick>, Vec<Tick>) = ticks
            .iter()
            .partition(|t| first_push_us.is_none_or(|push_us| t.record.input.start_us < push_us));
        let has_no_fault = fault.is_none();
        let since_us = last_change_us(&before);
        let settling =
            |ticks: &[Tick], since_us| settled_s(ticks, since_us).filter(|_| has_no_fault);
        let end_us = ticks.last().map_or(0, |t| t.record.input.start_us);
        let resting: Vec<Tick> = ticks
            .iter()
            .filter(|t| (end_us - t.record.input.start_us) as f64 * 1e-6 < REST_S)
            .copied()
            .collect();
        let mrad = |joints: Joints| joints.map(|rad| 1e3 * rad);
        Self {
            seed,
            settling_time_s: since_us.and_then(|since_us| settling(&before, since_us)),
            recovery_time_s: last_push_us.and_then(|push_us| settling(&after, push_us)),
            displaced_mrad: last_push_us.map(|_| mrad(peak(&after, |t, j| t.error_rad[j]))),
            mean_error_mrad: mrad(mean(&resting, |t, j| t.error_rad[j])),
            rms_error_mrad: mrad(rms(&resting, |t, j| t.error_rad[j])),
            peak_to_peak_mrad: mrad(peak_to_peak(&resting)),
            tracking_rms_mrad: moving(&ticks).map(|t| mrad(rms(&t, |t, j| t.error_rad[j]))),
            torque_rms_nm: rms(&resting, |t, j| t.after.torque_nm[j]),
            torque_peak_nm: peak(&ticks, |t, j| t.after.torque_nm[j]),
            speed_error_rms_rad_s: rms(&ticks, |t, j| {
                f64::from(t.record.output.speed_rad_s[j]) - t.before.speed_rad_s[j]
            }),
            saturated_share: fraction(&ticks, |t| {
                t.record.input.pwm_in_force.into_iter().any(is_saturated)
            }),
            missed_ticks: missed(&ticks),
            missing_samples: ticks
                .iter()
                .flat_map(|t| t.record.input.samples)
                .fold(0, absent),
            fault,
        }
    }
}

/// Ticks with torque on, except the first, which has no true state before it.
fn ticks(run: &Run) -> Vec<Tick<'_>> {
    let pairs = run.records.iter().zip(&run.truth);
    let befores = run.truth.iter();
    pairs
        .skip(1)
        .zip(befores)
        .filter(|((record, _), _)| record.mode.drive().is_some())
        .map(|((record, after), before)| Tick {
            record,
            before,
            after,
            error_rad: std::array::from_fn(|j| {
                after.angle_rad[j] - f64::from(record.output.reference_rad[j])
            }),
        })
        .collect()
}

/// Start of the first tick with the final reference.
fn last_change_us(ticks: &[Tick]) -> Option<u64> {
    let bits = |tick: &Tick| tick.record.output.reference_rad.map(f32::to_bits);
    let end = bits(ticks.last()?);
    let is_other = |tick: &Tick| bits(tick) != end;
    let first = ticks
        .iter()
        .rposition(is_other)
        .map_or(0, |other| other + 1);
    ticks.get(first).map(|tick| tick.record.input.start_us)
}

/// Time in s after `since_us` from which on both errors stay below [`SETTLED_RAD`].
fn settled_s(ticks: &[Tick], since_us: u64) -> Option<f64> {
    let is_outside = |tick: &Tick| tick.error_rad.iter().any(|e| e.abs() >= SETTLED_RAD);
    let inside = match ticks.iter().rposition(is_outside) {
        None => ticks.first()?,
        // Never settled if still outside at the end.
        Some(outside) => ticks.get(outside + 1)?,
    };
    Some(inside.record.input.start_us.saturating_sub(since_us) as f64 * 1e-6)
}

/// Ticks at which the reference has a speed.
fn moving<'a>(ticks: &[Tick<'a>]) -> Option<Vec<Tick<'a>>> {
    let moves = |tick: &&Tick| {
        let speeds = tick.record.output.reference_speed_rad_s;
        speeds.iter().any(|speed| speed.abs() > 0.0)
    };
    let moving: Vec<Tick> = ticks.iter().filter(moves).copied().collect();
    (!moving.is_empty()).then_some(moving)
}

fn mean(ticks: &[Tick], value: impl Fn(&Tick, usize) -> f64) -> Joints {
    let count = ticks.len().max(1) as f64;
    std::array::from_fn(|j| ticks.iter().map(|t| value(t, j)).sum::<f64>() / count)
}

fn rms(ticks: &[Tick], value: impl Fn(&Tick, usize) -> f64) -> Joints {
    mean(ticks, |t, j| value(t, j).powi(2)).map(f64::sqrt)
}

fn peak(ticks: &[Tick], value: impl Fn(&Tick, usize) -> f64) -> Joints {
    std::array::from_fn(|j| ticks.iter().map(|t| value(t, j).abs()).fold(0.0, f64::max))
}

fn peak_to_peak(ticks: &[Tick]) -> Joints {
    std::array::from_fn(|j| {
        let errors = ticks.iter().map(|t| t.error_rad[j]);
        let (low, high) = errors.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), e| {
            (low.min(e), high.max(e))
        });
        (high - low).max(0.0)
    })
}

fn fraction(ticks: &[Tick], condition: impl Fn(&Tick) -> bool) -> f64 {
    let count = ticks.iter().filter(|t| condition(t)).count();
    count as f64 / ticks.len().max(1) as f64
}

fn is_saturated(pwm: u16) -> bool {
    pwm == Pwm::MIN.counts() || pwm == Pwm::MAX.counts()
}

fn missed(ticks: &[Tick]) -> u32 {
    let count = |tick: Option<&Tick>| tick.map_or(0, |t| t.record.timing.missed);
    count(ticks.last()) - count(ticks.first())
}

fn absent(count: usize, sample: Sample) -> usize {
    count + usize::from(sample.lost().is_some())
}
