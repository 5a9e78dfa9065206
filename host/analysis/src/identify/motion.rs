//! Motion of a sliding joint, tick by tick, with its derivatives.
//!
//! Second-order Runge-Kutta at the tick's period, which is a hundredth of the fastest
//! time constant. Within a tick the PWM changes once, when the delay has passed: the
//! joint feels the mean. Angle and speed of the other joint are those of its encoder: they
//! enter through cosines and products that hardly change.
//!
//! Dry friction reverses when the joint does: at the moment, within the tick, of zero speed.
//! That moment depends on all parameters, and smoothly if the applied torque exceeds dry
//! friction there. If it does not, the joint rests until it does, which depends on static
//! friction; the model lacks that, and windows contain no such rests beyond a few ticks.

use num_dual::DualNum;

use super::arm::{JointModel, KnownParameters};
use super::dataset::Trace;

/// A joint in motion.
pub(super) struct Motion<'a, D> {
    joint: JointModel<D>,
    index: usize,
    trace: &'a Trace,
    period_s: f64,
    /// Delay from a PWM's arrival in the servo to the sample behind its torque: whole ticks,
    /// and the fraction beyond.
    delay_ticks: i64,
    delay_fraction: D,
    /// Sign of the sliding speed; 0 at rest.
    direction: f64,
    q: D,
    v: D,
    /// The last PWM in effect, and its torque.
    last: Option<(u16, D)>,
}

impl<'a, D: DualNum<Primitive = f64> + Copy> Motion<'a, D> {
    pub(super) fn new(
        joint: JointModel<D>,
        index: usize,
        known: &KnownParameters,
        trace: &'a Trace,
        [q, v]: [D; 2],
        direction: f64,
    ) -> Self {
        let delay = joint.delay_ticks(known);
        let whole = delay.re().floor();
        Self {
            joint,
            index,
            trace,
            period_s: known.period_s,
            delay_ticks: whole as i64,
            delay_fraction: delay - whole,
            direction,
            q,
            v,
            last: None,
        }
    }

    /// Encoder position in counts.
    pub(super) fn position(&self) -> D {
        self.joint.position(self.q)
    }

    /// Mean motor torque in N m from tick `k` to the next.
    fn motor_torque(&mut self, k: usize) -> D {
        let delayed = k as i64 - self.delay_ticks;
        let [before, after] =
            [delayed - 1, delayed].map(|tick| self.trace.pwm_at(tick, self.index));
        let torque = |pwm: u16| match self.last {
            Some((last, torque)) if last == pwm => torque,
            Some(_) | None => self.joint.motor_torque(pwm),
        };
        let first = torque(before);
        if before == after {
            self.last = Some((after, first));
            return first;
        }
        let second = torque(after);
        self.last = Some((after, second));
        second + (first - second) * self.delay_fraction
    }

    /// Applied torque in N m in a direction from tick `k` to the next, less the dry friction of
    /// the load on the gears: a joint at rest slides where it exceeds the other dry friction.
    pub(super) fn breakaway_torque(&mut self, k: usize, direction: f64) -> D {
        let other = self.trace.states[k][1 - self.index];
        let motor = self.motor_torque(k);
        let applied = motor + self.joint.passive_dynamics(self.q, self.v, other).0;
        applied * direction - self.joint.load_friction(self.q, self.v, other, motor)
    }

    /// Direction of sliding: towards larger (1) or smaller (-1) angles, or at rest (0).
    pub(super) fn direction(&self) -> f64 {
        self.direction
    }

    /// Integrates from tick `k` to the next.
    pub(super) fn step(&mut self, k: usize) {
        let motor = self.motor_torque(k);
        let other = self.trace.states[k][1 - self.index];
        let period = D::from(self.period_s);
        if self.direction == 0.0 && !self.breaks_away(motor, other) {
            return;
        }
        let next = self.integrate(motor, other, period);
        if next[1].re() * self.direction >= 0.0 {
            [self.q, self.v] = next;
            return;
        }
        // Reversal or stop; over so short a time the speed is linear.
        let until = period * self.v / (self.v - next[1]);
        let until = if (0.0..=self.period_s).contains(&until.re()) {
            until
        } else {
            D::from(0.0)
        };
        self.q += self.v * until * 0.5;
        self.v = D::from(0.0);
        if self.breaks_away(motor, other) {
            [self.q, self.v] = self.integrate(motor, other, period - until);
        }
    }

    /// Whether the applied torque on a resting joint exceeds its dry friction; sets the
    /// direction in which it slides from here on.
    fn breaks_away(&mut self, motor: D, other: [f64; 2]) -> bool {
        let applied = (self.joint.passive_dynamics(self.q, self.v, other).0 + motor).re();
        let load = self.joint.load_friction(self.q, self.v, other, motor);
        let slides = applied.abs() > (self.joint.dry_friction(D::from(0.0)) + load).re();
        self.direction = if slides { applied.signum() } else { 0.0 };
        slides
    }

    /// Angle and speed after sliding for a time.
    fn integrate(&self, motor: D, other: [f64; 2], period: D) -> [D; 2] {
        let acceleration = |q: D, v: D| {
            let (passive, inertia) = self.joint.passive_dynamics(q, v, other);
            let load = self.joint.load_friction(q, v, other, motor);
            (passive + motor - (self.joint.dry_friction(v) + load) * self.direction) / inertia
        };
        let half = period * 0.5;
        let first = acceleration(self.q, self.v);
        let second = acceleration(self.q + self.v * half, self.v + first * half);
        let next = self.v + second * period;
        [self.q + (self.v + next) * half, next]
    }
}
