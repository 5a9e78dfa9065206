//! A joint that slides one way, from tick to tick, with the derivatives of its motion.
//!
//! Second-order Runge-Kutta at the tick's period, which is a hundredth of the fastest
//! time constant. Within a tick the PWM changes once, when the delay has passed: the
//! joint feels the mean. Where the other joint is, and how fast, is read off its
//! encoder: it enters through cosines and products that hardly change.
//!
//! Dry friction is what it is as long as the joint slides one way, so a motion depends
//! smoothly on all numbers. Where a joint stops, and whether it stays, does not; such
//! moments are not followed.

use num_dual::DualNum;

use super::arm::{Joint, Known};
use super::trace::Trace;

/// A joint in motion.
pub(super) struct Motion<'a, D> {
    joint: Joint<D>,
    index: usize,
    trace: &'a Trace,
    period_s: f64,
    /// Ticks from a PWM's arrival in the servo to the sample behind its torque.
    whole: i64,
    share: D,
    /// Coulomb friction with its sign.
    dry: D,
    q: D,
    v: D,
    /// The PWM that acted last and its torque.
    last: Option<(u16, D)>,
}

impl<'a, D: DualNum<Primitive = f64> + Copy> Motion<'a, D> {
    pub(super) fn new(
        joint: Joint<D>,
        index: usize,
        known: &Known,
        trace: &'a Trace,
        [q, v]: [D; 2],
        way: f64,
    ) -> Self {
        let ticks = joint.delay_ticks(known);
        let whole = ticks.re().floor();
        Self {
            joint,
            index,
            trace,
            period_s: known.period_s,
            whole: whole as i64,
            share: ticks - whole,
            dry: joint.coulomb * way,
            q,
            v,
            last: None,
        }
    }

    /// Encoder position in counts.
    pub(super) fn position(&self) -> D {
        self.joint.position(self.q)
    }

    /// Mean torque of the motor from tick `k` to the next.
    fn torque(&mut self, k: usize) -> D {
        let later = k as i64 - self.whole;
        let [before, after] = [later - 1, later].map(|tick| self.trace.pwm_at(tick, self.index));
        let of = |pwm: u16| match self.last {
            Some((last, torque)) if last == pwm => torque,
            Some(_) | None => self.joint.torque(pwm),
        };
        let first = of(before);
        if before == after {
            self.last = Some((after, first));
            return first;
        }
        let second = of(after);
        self.last = Some((after, second));
        second + (first - second) * self.share
    }

    /// Torque in N m that pushes the joint from tick `k` to the next, dry friction apart.
    pub(super) fn push(&mut self, k: usize) -> D {
        let other = self.trace.smooth[k][1 - self.index];
        self.torque(k) + self.joint.push(self.q, self.v, other).0
    }

    /// Moves on from tick `k` to the next.
    pub(super) fn step(&mut self, k: usize) {
        let torque = self.torque(k) - self.dry;
        let other = self.trace.smooth[k][1 - self.index];
        let half = 0.5 * self.period_s;
        let (push, mass) = self.joint.push(self.q, self.v, other);
        let first = (push + torque) / mass;
        let (push, mass) = self
            .joint
            .push(self.q + self.v * half, self.v + first * half, other);
        let next = self.v + (push + torque) / mass * self.period_s;
        self.q += (self.v + next) * half;
        self.v = next;
    }
}
