//! Motions: samples of both joints in a CSV file, as a scenario.
//!
//! The arm is moved to where the motion begins, streams it, and is brought to rest at its
//! end. The reference that the board will make of the points is computed beforehand, by the
//! board's own code, and compared with its bounds; an error names the line of the samples
//! that it comes from.

mod resample;
mod run_up;
mod samples;

use armbridge_board::bridge::limits::{MOTION, REFERENCE_MAX_RAD};
use armbridge_client::number_text::beside_limit;
use armbridge_control::arm::Posture;
use armbridge_control::trajectory::Reference;
use armbridge_link::message::{Command, Settings};
use armbridge_link::motion::Motion;
use armbridge_servo::JOINTS;

use super::file::{BenchKeys, Expect, Pair};
use super::mistake::{KeyPath, Mistake, Text};
use super::reference::ReferenceSource;
use super::{Overrides, Scenario, ScenarioError, Success, check};
use crate::plan_runner::plan::{Action, Base, InitialSettings, Plan, Point, Step, Stop};
use resample::Knot;
use samples::Sample;

/// Ending of a file with a motion.
pub(super) const EXTENSION: &str = "csv";

/// Longest text in bytes: an hour at 1 kHz in lines of 74 bytes.
pub(super) const TEXT_MAX: u64 = 256 << 20;

/// Time between points in s. The board keeps eight, and five are sent ahead: 250 ms for the
/// link to be late.
const SPACING_S: f64 = 0.05;
/// Time between points in ticks, at least: a point is acknowledged before the next is sent.
const SPACING_TICKS: f64 = 3.0;
/// Duration in s of the way to the beginning: from one end of the board's range to the
/// other, 2.4 rad, it takes a speed of 2.3 rad/s.
const APPROACH_S: f32 = 2.0;
/// Time in s for the arm to come to rest, before the motion and after it.
const REST_S: f64 = 1.0;
/// Longest motion in s.
const DURATION_MAX_S: f64 = 3_600.0;
/// Interval in s at which the reference is compared with its bounds.
const CHECK_S: f64 = 0.001;

/// The scenario of a motion.
pub(super) fn scenario(
    text: Text<'_>,
    name: &str,
    overrides: &Overrides,
) -> Result<Scenario, ScenarioError> {
    let wrong = |(byte, message)| ScenarioError::from(text.error(byte, message));
    let located = |wrong: check::Wrong| wrong.located(|mistake| text.error(0, mistake.message));
    let mut samples = samples::parse(text.text).map_err(wrong)?;
    change_speed(&mut samples, overrides.speed.unwrap_or(1.0));
    let duration_s = samples[samples.len() - 1].at_s - samples[0].at_s;
    if duration_s > DURATION_MAX_S {
        let message = format!("the motion takes {duration_s} s; at most {DURATION_MAX_S} s");
        return Err(wrong((samples[samples.len() - 1].byte, message)));
    }
    let base = overrides.control.unwrap_or(Base::Compensated);
    let bench = check::bench(&BenchKeys::default(), None, overrides).map_err(located)?;
    let (change, settings) =
        check::settings(base, &[], &bench.plant, overrides).map_err(located)?;

    let path = Path::new(&samples, &settings);
    let line_of = |at_s: f64| Path::sample(&samples, at_s).byte;
    // A run-up to such a motion would have no sensible length.
    if let Some((at_s, message)) = path.beyond() {
        return Err(wrong((line_of(at_s), message)));
    }
    for knot in [path.knots.first(), path.knots.last()]
        .into_iter()
        .flatten()
    {
        let beyond = |q: &f64| q.abs() > f64::from(REFERENCE_MAX_RAD);
        if let Some(joint) = knot.q.iter().position(beyond) {
            let message = format!(
                "the motion begins or ends with a speed, and the way from or to rest would reach \
                 {:.3} rad of joint {}, outside the board's range from -{REFERENCE_MAX_RAD} to \
                 {REFERENCE_MAX_RAD} rad; let it begin and end more slowly",
                knot.q[joint],
                joint + 1
            );
            return Err(wrong((line_of(knot.at_s), message)));
        }
    }
    let initial_rad: Pair = bench.plant.initial.q.map(|q| q as f32).into();
    let steps = path.steps();
    let mut reference = ReferenceSource::unknown(initial_rad);
    for step in &steps {
        let place = KeyPath::default();
        let applied = reference.apply(step, &settings, &place);
        let checked = applied.and_then(|()| reference.check_limits(&settings.limits, &place));
        checked.map_err(|Mistake { place, message }| {
            let knot = place
                .first_index()
                .and_then(|number| path.knots.get(number + 1));
            wrong((knot.map_or(0, |knot| line_of(knot.at_s)), message))
        })?;
    }
    let peaks = path.peaks(&steps[1], &settings);
    if let Some(peak) = peaks.iter().flatten().find(|peak| peak.is_beyond()) {
        return Err(wrong((line_of(peak.at_s), peak.message())));
    }
    let cycle_s = f64::from(APPROACH_S) + REST_S + path.length_s() + REST_S;
    let repeats = overrides.repeats.unwrap_or(1);
    let end_s = overrides.duration_s.unwrap_or(cycle_s * f64::from(repeats));
    let mut notes = check::notes(base, overrides);
    notes.extend(path.describe(&samples, &peaks));
    Ok(Scenario {
        name: name.into(),
        title: format!("Motion of {}", text.file.display()),
        about: String::new(),
        plan: Plan {
            begin: InitialSettings::Changed(change),
            steps: repeated(&steps, cycle_s, repeats),
            pushes: Vec::new(),
            leads: Vec::new(),
            stop: Stop::after((end_s * 1e6).round() as u64),
            is_clearing: false,
            is_releasing: false,
        },
        settings,
        baseline: None,
        bench,
        success: vec![Success::Time],
        expect: Expect::default(),
        notes,
    })
}

/// Plays samples at this speed, relative to their own.
fn change_speed(samples: &mut [Sample], speed: f64) {
    let start_s = samples[0].at_s;
    for sample in samples {
        sample.at_s = start_s + (sample.at_s - start_s) / speed;
        sample.speed_rad_s = sample
            .speed_rad_s
            .map(|speeds| speeds.map(|rad_s| rad_s * speed));
    }
}

/// Steps that are performed so many times, one cycle after the other.
fn repeated(steps: &[Step], cycle_s: f64, repeats: u32) -> Vec<Step> {
    let cycles = (0..repeats).flat_map(|cycle| {
        let after_us = (f64::from(cycle) * cycle_s * 1e6).round() as u64;
        steps.iter().map(move |step| Step {
            at_us: step.at_us + after_us,
            action: step.action.clone(),
        })
    });
    cycles.collect()
}

/// A motion from rest to rest.
struct Path {
    /// All points; the first is at rest, and so is the last.
    knots: Vec<Knot>,
    spacing_s: f64,
    run_up_s: f64,
    run_out_s: f64,
    /// Duration of the samples.
    duration_s: f64,
}

/// Largest value of a quantity of a joint.
struct Peak {
    joint: usize,
    quantity: &'static str,
    unit: &'static str,
    value: f64,
    limit: f64,
    /// Time of the samples, in s.
    at_s: f64,
}

/// Quantities of a reference that are bounded, with their units.
const SPEED: (&str, &str) = ("a speed", "rad/s");
const ACCELERATION: (&str, &str) = ("an acceleration", "rad/s²");
const TORQUE: (&str, &str) = ("a torque", "N m");

impl Peak {
    fn is_beyond(&self) -> bool {
        self.value > self.limit
    }

    fn message(&self) -> String {
        let [value, limit] = beside_limit(self.value as f32, self.limit as f32, 2);
        let (joint, quantity, unit) = (self.joint + 1, self.quantity, self.unit);
        format!(
            "joint {joint} would need {quantity} of {value} {unit} at {:.3} s of the motion, more \
             than {limit} {unit}; move more slowly or more smoothly",
            self.at_s
        )
    }
}

impl Path {
    /// The samples' speed or acceleration that is farthest beyond its bound, if one is: its
    /// time, and the message.
    fn beyond(&self) -> Option<(f64, String)> {
        let samples = self.knots.iter();
        let samples = samples.filter(|knot| (0.0..=self.duration_s).contains(&knot.at_s));
        let peaks = samples.flat_map(|knot| {
            (0..JOINTS).flat_map(move |joint| {
                [
                    (SPEED, knot.dq[joint], MOTION.speed_rad_s),
                    (ACCELERATION, knot.ddq[joint], MOTION.acceleration_rad_s2),
                ]
                .map(|((quantity, unit), value, limit)| Peak {
                    joint,
                    quantity,
                    unit,
                    value: value.abs(),
                    limit: limit.into(),
                    at_s: knot.at_s,
                })
            })
        });
        let worst = peaks
            .filter(Peak::is_beyond)
            .max_by(|a, b| (a.value / a.limit).total_cmp(&(b.value / b.limit)))?;
        Some((worst.at_s, worst.message()))
    }

    fn new(samples: &[Sample], settings: &Settings) -> Self {
        let period_s = f64::from(settings.setup.period_us) * 1e-6;
        let spacing_s = SPACING_S.max(SPACING_TICKS * period_s);
        let acceleration = f64::from(MOTION.acceleration_rad_s2);
        let motion = resample::resample(samples, spacing_s);
        let (first, last) = (&motion[0], &motion[motion.len() - 1]);
        let run_up = run_up::run_up(first, spacing_s, acceleration);
        let run_out = run_up::run_out(last, spacing_s, acceleration);
        let run_up_s = run_up.first().map_or(0.0, |knot| -knot.at_s);
        let run_out_s = run_out.last().map_or(0.0, |knot| knot.at_s - last.at_s);
        let duration_s = last.at_s;
        let mut knots: Vec<Knot> = run_up.into_iter().chain(motion).chain(run_out).collect();
        let count = knots.len();
        for end in [0, count - 1] {
            knots[end].dq = [0.0; JOINTS];
        }
        Self {
            knots,
            spacing_s,
            run_up_s,
            run_out_s,
            duration_s,
        }
    }

    fn length_s(&self) -> f64 {
        self.run_up_s + self.duration_s + self.run_out_s
    }

    /// The sample before a time of the motion.
    fn sample(samples: &[Sample], at_s: f64) -> &Sample {
        // Half a nanosecond for rounding.
        let at_s = samples[0].at_s + at_s + 5e-10;
        let after = samples.partition_point(|sample| sample.at_s <= at_s);
        &samples[after.saturating_sub(1)]
    }

    /// The way to the first point, and the stream of all others.
    fn steps(&self) -> Vec<Step> {
        let single = |values: [f64; JOINTS]| values.map(|value| value as f32);
        let motion = Motion::MinimumJerk {
            to_rad: single(self.knots[0].q),
            duration_s: Some(APPROACH_S),
        };
        let start_s = self.knots[0].at_s;
        let points = self.knots[1..].iter().map(|knot| Point {
            after_us: ((knot.at_s - start_s) * 1e6).round() as u64,
            angle_rad: single(knot.q),
            speed_rad_s: Some(single(knot.dq)),
        });
        let step = |at_s: f64, action| Step {
            at_us: (at_s * 1e6) as u64,
            action,
        };
        vec![
            step(0.0, Action::Command(Box::new(Command::Follow(motion)))),
            step(
                f64::from(APPROACH_S) + REST_S,
                Action::Stream(points.collect()),
            ),
        ]
    }

    /// Peaks of each joint's speed, acceleration and torque: of the reference that the board
    /// makes of the points, and of the board's model of the arm.
    fn peaks(&self, stream: &Step, settings: &Settings) -> [[Peak; 3]; JOINTS] {
        let arm = settings.setup.arm.map(f64::from);
        let limits = [
            [MOTION.speed_rad_s; JOINTS],
            [MOTION.acceleration_rad_s2; JOINTS],
            settings.limits.torque_nm,
        ];
        let names = [SPEED, ACCELERATION, TORQUE];
        let mut peaks = core::array::from_fn(|joint| {
            core::array::from_fn(|number| Peak {
                joint,
                quantity: names[number].0,
                unit: names[number].1,
                value: 0.0,
                limit: limits[number][joint].into(),
                at_s: 0.0,
            })
        });
        let Action::Stream(points) = &stream.action else {
            return peaks;
        };
        let start = Reference::at_rest(self.knots[0].q.map(|q| q as f32).into());
        let step_us = (CHECK_S * 1e6) as u64;
        let mut see = |after_us: u64, reference: &Reference<f32>| {
            let [q, dq, ddq] = [reference.q, reference.dq, reference.ddq].map(|v| v.map(f64::from));
            let torque = Posture::of(q).inverse_dynamics(&arm, dq, ddq);
            let at_s = after_us as f64 * 1e-6 - self.run_up_s;
            for (joint, peaks) in peaks.iter_mut().enumerate() {
                for (peak, value) in peaks.iter_mut().zip([dq, ddq, torque]) {
                    let value: f64 = value[joint];
                    if value.abs() > peak.value {
                        (peak.value, peak.at_s) = (value.abs(), at_s);
                    }
                }
            }
        };
        super::reference::follow_stream(&start, points, step_us, &mut see);
        peaks
    }

    /// The preview: duration, and the peaks beside their limits.
    fn describe(&self, samples: &[Sample], peaks: &[[Peak; 3]; JOINTS]) -> Vec<String> {
        let mut lines = vec![format!(
            "motion: {:.3} s, {} samples, sent as {} points {:.0} ms apart",
            self.duration_s,
            samples.len(),
            self.knots.len() - 1,
            1e3 * self.spacing_s
        )];
        if self.run_up_s + self.run_out_s > 0.0 {
            lines.push(format!(
                "  it does not begin or end at rest: {:.2} s of run-up, {:.2} s of run-out",
                self.run_up_s, self.run_out_s
            ));
        }
        for (joint, [speed, acceleration, torque]) in peaks.iter().enumerate() {
            let angles = || self.knots.iter().map(|knot| knot.q[joint]);
            let (low, high) = (
                angles().fold(f64::INFINITY, f64::min),
                angles().fold(f64::NEG_INFINITY, f64::max),
            );
            lines.push(format!(
                "  q{}: {low:+.2} to {high:+.2} rad, {:.2} of {:.0} rad/s, {:.1} of {:.0} \
                 rad/s², {:.2} of {:.2} N m",
                joint + 1,
                speed.value,
                speed.limit,
                acceleration.value,
                acceleration.limit,
                torque.value,
                torque.limit
            ));
        }
        lines
    }
}
