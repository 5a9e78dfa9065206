//! Pattern of a check: pulses of torque, as the picture of the [check](super) shows them.

/// Length of a pulse in µs, at least a tick.
const PULSE_US: u32 = 30_000;

/// Signs of the pulses: two motions, there and back, the second mirrored.
const SIGNS: [f32; 8] = [1.0, -1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0];

/// Rest before and after the pulses in µs, at least two ticks.
const REST_US: u32 = 10_000;

/// Samples of each joint in an attempt, and the most repetitions for that.
const SAMPLES: u32 = 100;
const REPETITIONS_MAX: u32 = 3;

/// Lengths of the pattern in ticks.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Pattern {
    pulse: u32,
    rest: u32,
    pub(super) ticks: u32,
}

impl Pattern {
    pub(super) fn new(period_us: u32) -> Self {
        let period_us = period_us.max(1);
        let pulse = ((PULSE_US + period_us / 2) / period_us).max(1);
        let rest = (REST_US / period_us).max(2);
        let pulses = SIGNS.len() as u32 * pulse;
        let repetitions = SAMPLES.div_ceil(pulses.max(1)).min(REPETITIONS_MAX);
        Self {
            pulse,
            rest,
            ticks: pulses * repetitions + 2 * rest,
        }
    }

    /// Sign of the torque in this tick.
    pub(super) fn sign(&self, tick: u32) -> f32 {
        if tick < self.rest || tick + self.rest >= self.ticks {
            return 0.0;
        }
        let pulse = (tick - self.rest) / self.pulse;
        SIGNS[pulse as usize % SIGNS.len()]
    }
}
