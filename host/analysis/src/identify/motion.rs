//! A joint that slides, from tick to tick, with the derivatives of its motion.
//!
//! Second-order Runge-Kutta at the tick's period, which is a hundredth of the fastest
//! time constant. Within a tick the PWM changes once, when the delay has passed: the
//! joint feels the mean. Where the other joint is, and how fast, is read off its
//! encoder: it enters through cosines and products that hardly change.
//!
//! Where a joint turns round, dry friction does: in the moment, within the tick, in which
//! its speed is none. That moment depends on all numbers, and smoothly so for a joint that
//! is pushed on beyond its friction. One that is not stays until it is; when that is
//! depends on static friction, which is not in here: windows have no such rests, but for a
//! few ticks.

use num_dual::DualNum;

use super::arm::{Joint, Known};
use super::dataset::Trace;

/// A joint in motion.
pub(super) struct Motion<'a, D> {
    joint: Joint<D>,
    index: usize,
    trace: &'a Trace,
    period_s: f64,
    /// Ticks from a PWM's arrival in the servo to the sample behind its torque.
    whole: i64,
    share: D,
    /// Which way it slides; 0 if it rests.
    way: f64,
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
            way,
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
        let torque = |pwm: u16| match self.last {
            Some((last, torque)) if last == pwm => torque,
            Some(_) | None => self.joint.torque(pwm),
        };
        let first = torque(before);
        if before == after {
            self.last = Some((after, first));
            return first;
        }
        let second = torque(after);
        self.last = Some((after, second));
        second + (first - second) * self.share
    }

    /// Torque in N m that pushes the joint from tick `k` to the next, dry friction apart.
    pub(super) fn push(&mut self, k: usize) -> D {
        let other = self.trace.smooth[k][1 - self.index];
        self.torque(k) + self.joint.push(self.q, self.v, other).0
    }

    /// Which way it slides: towards larger (1) or smaller (-1) angles, or not (0).
    pub(super) fn way(&self) -> f64 {
        self.way
    }

    /// Moves on from tick `k` to the next.
    pub(super) fn step(&mut self, k: usize) {
        let torque = self.torque(k);
        let other = self.trace.smooth[k][1 - self.index];
        let period = D::from(self.period_s);
        if self.way == 0.0 && !self.gives_way(torque, other) {
            return;
        }
        let (push, mass) = self.joint.push(self.q, self.v, other);
        let first = (push + torque - self.joint.dry(self.v) * self.way) / mass;
        let next = self.slid(torque, other, first, period);
        if next[1].re() * self.way >= 0.0 {
            [self.q, self.v] = next;
            return;
        }
        // It turns round, or stops; over so short a time its speed is linear.
        let until = period * self.v / (self.v - next[1]);
        let until = if (0.0..=self.period_s).contains(&until.re()) {
            until
        } else {
            D::from(0.0)
        };
        self.q += self.v * until * 0.5;
        self.v = D::from(0.0);
        if self.gives_way(torque, other) {
            let (push, mass) = self.joint.push(self.q, self.v, other);
            let first = (push + torque - self.joint.dry(self.v) * self.way) / mass;
            [self.q, self.v] = self.slid(torque, other, first, period - until);
        }
    }

    /// Whether a joint that stands is pushed on, and from here on slides that way.
    fn gives_way(&mut self, torque: D, other: [f64; 2]) -> bool {
        let push = (self.joint.push(self.q, self.v, other).0 + torque).re();
        let slides = push.abs() > self.joint.dry(D::from(0.0)).re();
        self.way = if slides { push.signum() } else { 0.0 };
        slides
    }

    /// Angle and speed after sliding its way for a time; the first acceleration is known.
    fn slid(&self, torque: D, other: [f64; 2], first: D, period: D) -> [D; 2] {
        let half = period * 0.5;
        let [q, v] = [self.q + self.v * half, self.v + first * half];
        let (push, mass) = self.joint.push(q, v, other);
        let second = (push + torque - self.joint.dry(v) * self.way) / mass;
        let next = self.v + second * period;
        [self.q + (self.v + next) * half, next]
    }
}
