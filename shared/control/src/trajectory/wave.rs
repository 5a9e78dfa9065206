//! Sinusoids of constant or sweeping frequency, ramped in and out.
//!
//! ```text
//! w = e(t) A sin(2 pi (f t + k t^2/2) + phase)
//! ```
//!
//! The [envelope](Envelope) e rises from 0 to 1 and falls back, so that angle, speed
//! and acceleration of w are 0 at both ends whatever the phase. w is added to a path
//! that goes to the centre while it rises.

use super::bounds::PeakTracker;
use super::ramp::Envelope;
use crate::check_word::checked;
use crate::real::Real;
use crate::trajectory::Reference;
use armbridge_servo::JOINTS;
use core::f64::consts::TAU;
use nalgebra::Vector2;

/// Of both joints.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "snapshot", serde(bound = "T: crate::snapshot::Number"))]
pub(super) struct Wave<T> {
    pub(super) amplitude_rad: Vector2<T>,
    /// At t = 0.
    pub(super) start_hz: Vector2<T>,
    /// Growth of the frequency per second.
    pub(super) sweep_hz_s: Vector2<T>,
    /// In -0.5..=0.5 turns.
    pub(super) phase_turns: Vector2<T>,
    /// Of rise and of fall.
    pub(super) ramp_s: T,
    pub(super) duration_s: T,
}

checked!(Wave<T> { amplitude_rad, start_hz, sweep_hz_s, phase_turns, ramp_s, duration_s });

impl<T: Real> Wave<T> {
    /// Adds w to a reference.
    pub(super) fn add(&self, t_s: T, to: &mut Reference<T>) {
        let Envelope { e, de, dde } = self.envelope(t_s);
        for joint in 0..JOINTS {
            let (omega, domega) = self.angular(joint, t_s);
            let half = T::lit(0.5);
            let turns = (self.start_hz[joint] + self.sweep_hz_s[joint] * t_s * half) * t_s;
            // Whole turns are taken off while they are exact; below 65535 of them.
            let turns = turns - T::from_count(turns.to_count()) + self.phase_turns[joint];
            let (sin, cos) = (turns * T::lit(TAU)).sine_cosine();
            let a = self.amplitude_rad[joint];
            let s = a * sin;
            let ds = a * omega * cos;
            let dds = a * domega * cos - omega * omega * s;
            to.q[joint] += e * s;
            to.dq[joint] += de * s + e * ds;
            to.ddq[joint] += dde * s + T::lit(2.0) * de * ds + e * dds;
        }
    }

    /// Shows `tightest` path and wave together, with the wave at its worst phase:
    /// what it reaches at most if it happens to be there.
    ///
    /// The phase taken out, everything changes as slowly as the ramps, and a few
    /// hundred samples are exact to 0.01 %.
    pub(super) fn show(&self, path: impl Fn(T) -> Reference<T>, tightest: &mut PeakTracker<T>) {
        const SAMPLES_PER_RAMP: u16 = 256;
        let fall_s = self.duration_s - self.ramp_s;
        for i in 0..=SAMPLES_PER_RAMP {
            let share = T::from_count(i) / T::from_count(SAMPLES_PER_RAMP);
            for t_s in [share * self.ramp_s, fall_s + share * self.ramp_s] {
                let along = path(t_s);
                let reach = [0, 1].map(|joint| {
                    let [q, dq, ddq] = self.reach(joint, t_s);
                    // The wave adds to whichever sign the path has.
                    [
                        along.q[joint] + q.copysign(along.q[joint]),
                        along.dq[joint] + dq.copysign(along.dq[joint]),
                        along.ddq[joint] + ddq.copysign(along.ddq[joint]),
                    ]
                });
                tightest.see_all(reach, t_s);
            }
        }
    }

    /// Magnitudes of w and its derivatives at their worst phases.
    fn reach(&self, joint: usize, t_s: T) -> [T; 3] {
        let Envelope { e, de, dde } = self.envelope(t_s);
        let (omega, domega) = self.angular(joint, t_s);
        let a = self.amplitude_rad[joint].abs();
        // Amplitudes of the terms with the sine, and with the cosine.
        let of = |sin: T, cos: T| a * (sin * sin + cos * cos).sqrt();
        [
            a * e,
            of(de, e * omega),
            of(
                dde - e * omega * omega,
                T::lit(2.0) * de * omega + e * domega,
            ),
        ]
    }

    /// Angular frequency in rad/s and its derivative.
    fn angular(&self, joint: usize, t_s: T) -> (T, T) {
        let (start, sweep) = (self.start_hz[joint], self.sweep_hz_s[joint]);
        (T::lit(TAU) * (start + sweep * t_s), T::lit(TAU) * sweep)
    }

    fn envelope(&self, t_s: T) -> Envelope<T> {
        Envelope::at(t_s, self.ramp_s, self.duration_s)
    }
}
