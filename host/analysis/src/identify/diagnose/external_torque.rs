//! Torque that neither the motor nor the arm explains: a hand, a stop, a cable.
//!
//! With the numbers that were found, what accelerates a joint over a stretch of a quarter
//! of a second is compared with motor, gravity and friction. Where it stands, or turns
//! round, dry friction may be anything up to what it is at most.

use armbridge_shared::JOINTS;

use super::super::arm::{Joint, Known};
use super::super::dataset::{FAIR_COUNTS, OFF, Trace};
use super::super::fit_result::Found;
use super::super::quantity::Quantity;
use super::bump::Bump;

/// Half a stretch, and from one to the next, in ticks.
const HALF: usize = 120;
const STRIDE: usize = 30;
/// Speed in rad/s above which the way a joint slides is sure.
const SLIDES_RAD_S: f64 = 0.17;
/// Unexplained torque above this is external, in N m: 5 standard deviations with
/// noise of a count and the inertia of the paper's arm.
const SURE_NM: f64 = 0.15;
/// Dry friction at rest, as a multiple of that in motion, at most.
const STATIC: f64 = 2.5;
/// PWM counts about a dead zone's edges in which the motor may give its torque or none.
const EDGE_COUNTS: f64 = 6.0;
/// Torque in N m that is in doubt there.
const EDGE_NM: f64 = 0.03;
/// A push is one that lasts so long, in ticks.
const LASTS: usize = 300;

/// Longest pause in ticks within one push.
const PAUSE: usize = 1_000;

/// A stretch of ticks in which something turns a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// Index of the trace.
    pub trace: usize,
    /// From 0.
    pub joint: usize,
    /// First tick.
    pub first: usize,
    /// Ticks.
    pub len: usize,
    /// The largest torque that nothing explains, with its sign.
    pub torque_nm: f64,
}

/// All pushes, in traces that are smoothed.
pub(super) fn pushes(traces: &[Trace], known: &Known, found: &Found) -> Vec<Push> {
    let bump = Bump::new(HALF);
    let mut pushes = Vec::new();
    for joint in 0..JOINTS {
        let model = Model::new(known, found, joint);
        for (index, trace) in traces.iter().enumerate() {
            let mut push: Option<Push> = None;
            let firsts = (0..trace.smooth.len().saturating_sub(bump.len())).step_by(STRIDE);
            for first in firsts {
                let torque_nm = model.unexplained(trace, first, &bump);
                if torque_nm == 0.0 {
                    keep(&mut push, &mut pushes);
                    continue;
                }
                let middle = first + HALF;
                let push = push.get_or_insert(Push {
                    trace: index,
                    joint,
                    first: middle,
                    len: 0,
                    torque_nm,
                });
                push.len = middle + STRIDE - push.first;
                if torque_nm.abs() > push.torque_nm.abs() {
                    push.torque_nm = torque_nm;
                }
            }
            keep(&mut push, &mut pushes);
        }
    }
    pushes
}

/// A push has ended: it is one with that before if it began soon after.
fn keep(push: &mut Option<Push>, pushes: &mut Vec<Push>) {
    let Some(push) = push.take().filter(|push| push.len >= LASTS) else {
        return;
    };
    match pushes.last_mut() {
        Some(before)
            if (before.trace, before.joint) == (push.trace, push.joint)
                && push.first <= before.first + before.len + PAUSE =>
        {
            before.len = push.first + push.len - before.first;
            if push.torque_nm.abs() > before.torque_nm.abs() {
                before.torque_nm = push.torque_nm;
            }
        }
        Some(_) | None => pushes.push(push),
    }
}

/// A joint as it was found.
struct Model<'a> {
    joint: usize,
    known: &'a Known,
    arm: Joint<f64>,
    delay_ticks: i64,
    /// PWM counts below and above off up to which there is no torque.
    dead: [f64; 2],
}

impl<'a> Model<'a> {
    fn new(known: &'a Known, found: &Found, joint: usize) -> Self {
        let number = |quantity: Quantity| found.number(joint, quantity).0;
        let arm = Joint::of(known, &found.at, joint);
        Self {
            joint,
            known,
            delay_ticks: arm.delay_ticks(known).round() as i64,
            arm,
            dead: [number(Quantity::DeadBelow), number(Quantity::DeadAbove)],
        }
    }

    /// Torque in N m over a stretch beyond all that may be; 0 for what is explained.
    fn unexplained(&self, trace: &Trace, first: usize, bump: &Bump) -> f64 {
        let joint = self.joint;
        // Some samples are lost here and there; a stretch without most is not judged.
        let seen = |tick: &usize| !trace.counts[*tick].contains(&None);
        if 2 * (first..first + bump.len()).filter(seen).count() < bump.len() {
            return 0.0;
        }
        let state = |tick: usize| trace.smooth[tick][joint];
        let push = |tick: usize| {
            let [q, v] = state(tick);
            self.arm.push(q, v, trace.smooth[tick][1 - joint])
        };
        let motor = |tick: usize| {
            let pwm = trace.pwm_at(tick as i64 - self.delay_ticks, joint);
            let torque = self.arm.torque(pwm);
            let counts = f64::from(pwm) - 1_000.0;
            let edge = self.dead[usize::from(counts > 0.0)];
            let is_at_edge = counts != 0.0 && (counts.abs() - edge).abs() < EDGE_COUNTS;
            // The torque of nearly full PWM is not known.
            let fair = pwm.clamp(OFF - FAIR_COUNTS, OFF + FAIR_COUNTS);
            let beyond = (torque - self.arm.torque(fair)).abs();
            (torque, beyond + if is_at_edge { EDGE_NM } else { 0.0 })
        };
        let dry = |tick: usize| {
            let v = state(tick)[1];
            if v.abs() > SLIDES_RAD_S {
                (self.arm.dry(v) * v.signum(), 0.0)
            } else {
                (0.0, STATIC * self.arm.dry(f64::INFINITY))
            }
        };
        let mass = push(first + bump.len() / 2).1;
        let needed = mass * bump.rate(first, |tick| state(tick)[1]) / self.known.period_s;
        let given = bump.mean(first, |tick| push(tick).0 + motor(tick).0 - dry(tick).0);
        let unsure = bump.mean(first, |tick| motor(tick).1 + dry(tick).1);
        let rest = needed - given;
        if rest.abs() > SURE_NM + unsure {
            rest - unsure.copysign(rest)
        } else {
            0.0
        }
    }
}
