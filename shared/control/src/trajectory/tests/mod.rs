//! Continuity, bounds, derivatives, refusals; each for many random inputs.

// What is handed through must come out as it went in, to the bit.
#![allow(clippy::float_cmp)]

mod minimum_jerk;
mod refusals;
mod streams;
mod waves;
mod waypoints;

use super::*;
extern crate std;
use std::vec::Vec as List;

/// A small generator, the same numbers on every machine.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn seeded(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// Uniform in 0..1.
    pub(super) fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Both entries within `limit` of 0.
    pub(super) fn vector(&mut self, limit: f64) -> Vector2<f64> {
        Vector2::new(self.within(-limit, limit), self.within(-limit, limit))
    }

    pub(super) fn reference(&mut self) -> Reference<f64> {
        Reference {
            q: self.vector(1.0),
            dq: self.vector(1.0),
            ddq: self.vector(4.0),
        }
    }
}

pub(super) const WIDE: Bounds<f64> = Bounds {
    angle_rad: 1e6,
    speed_rad_s: 1e6,
    acceleration_rad_s2: 1e6,
    jerk_rad_s3: 1e9,
};

/// Largest difference in angle, speed or acceleration.
pub(super) fn gap(a: &Reference<f64>, b: &Reference<f64>) -> f64 {
    [a.q - b.q, a.dq - b.dq, a.ddq - b.ddq]
        .map(|d| d.amax())
        .into_iter()
        .fold(0.0, f64::max)
}

pub(super) fn single(r: &Reference<f64>) -> Reference<f32> {
    Reference {
        q: r.q.cast(),
        dq: r.dq.cast(),
        ddq: r.ddq.cast(),
    }
}

/// Speed and acceleration are the derivatives of angle and speed, away from
/// `knots`; nothing jumps at `knots`.
pub(super) fn assert_smooth(trajectory: &Trajectory<f64>, knots: &[f64], scale: f64) {
    let h = 1e-5;
    let duration = trajectory.duration_s();
    for i in 0..500 {
        let t = duration * (f64::from(i) + 0.5) / 500.0;
        if knots.iter().any(|knot| (t - knot).abs() < 2.0 * h) {
            continue;
        }
        let (before, at, after) = (trajectory.at(t - h), trajectory.at(t), trajectory.at(t + h));
        let speed = (after.q - before.q) / (2.0 * h) - at.dq;
        let acceleration = (after.dq - before.dq) / (2.0 * h) - at.ddq;
        let worst = speed.amax().max(acceleration.amax());
        assert!(worst < 1e-6 * scale, "{t}: {worst:e}");
    }
    for &knot in knots {
        // What a bounded slope changes in 2e-11 s is far less.
        let (before, after) = (trajectory.at(knot - 1e-11), trajectory.at(knot + 1e-11));
        let jump = gap(&before, &after);
        assert!(jump < 1e-7 * scale, "{knot}: {jump:e}");
    }
}

/// The largest ratio to a bound among fine samples.
pub(super) fn sampled_ratio(trajectory: &Trajectory<f64>, bounds: &Bounds<f64>) -> f64 {
    const SAMPLES: u32 = 5000;
    let ratios = (0..=SAMPLES).map(|i| {
        let t = trajectory.duration_s() * f64::from(i) / f64::from(SAMPLES);
        let r = trajectory.at(t);
        (r.q.amax() / bounds.angle_rad)
            .max(r.dq.amax() / bounds.speed_rad_s)
            .max(r.ddq.amax() / bounds.acceleration_rad_s2)
    });
    ratios.fold(0.0, f64::max)
}
