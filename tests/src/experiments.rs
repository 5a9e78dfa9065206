//! Experiments that a host may come up with.

use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{Experiment, Role};

use crate::random::Random;

/// A number from 0 to this.
pub type Number = fn(&mut Random, f32) -> f32;

/// One that is even.
pub fn number(random: &mut Random, most: f32) -> f32 {
    most * (random.below(1_000) as f32 * 1e-3)
}

/// A signal that is nowhere beyond `most`, if all numbers are what they should be.
pub fn signal(random: &mut Random, most: f32, number: Number) -> Signal<f32> {
    let half = most * 0.5;
    let [a, b] = [number(random, half), number(random, half)];
    let [time_s, ramp_s] = [0.3, 0.09].map(|most| 0.01 + number(random, most));
    let hz = number(random, 3.0);
    let steps = 1 + random.below(20) as u8;
    match random.below(8) {
        0 => Signal::Constant(a),
        1 => Signal::Triangle {
            offset: a,
            amplitude: b,
            period_s: time_s,
        },
        2 => Signal::Staircase {
            from: a,
            to: -b,
            steps,
            dwell_s: time_s,
        },
        3 => Signal::Steps {
            first: a,
            increment: b * 0.05,
            steps,
            on_s: time_s,
            off_s: ramp_s,
            alternating: random.once_in(2),
        },
        4 => Signal::Sinusoid {
            offset: a,
            amplitude: b,
            frequency_hz: hz,
            ramp_s,
        },
        5 => Signal::Chirp {
            offset: a,
            amplitude: b,
            from_hz: hz,
            to_hz: time_s,
            ramp_s,
        },
        6 => Signal::Multisine {
            amplitude: b,
            lowest_hz: hz,
            lines: steps,
            ramp_s,
        },
        _ => Signal::Prbs {
            amplitude: b,
            hold_s: time_s,
            seed: random.below(1 << 32) as u32,
        },
    }
}

/// One that most boards would begin from near upright.
pub fn experiment(random: &mut Random, number: Number) -> Experiment {
    let roles = [(); 2].map(|()| match random.below(7) {
        0 => Role::Off,
        1 | 2 => Role::Hold,
        3 => Role::Pwm(signal(random, 500.0, number)),
        4 => Role::Torque(signal(random, 0.6, number)),
        5 => Role::Bias(signal(random, 200.0, number)),
        _ => Role::Angle(Signal::Sinusoid {
            offset: number(random, 0.02),
            amplitude: number(random, 0.05),
            frequency_hz: number(random, 1.5),
            ramp_s: 0.09 + number(random, 0.01),
        }),
    });
    Experiment {
        roles,
        duration_s: 0.2 + number(random, 1.0),
        angle_rad: [(); 2].map(|()| [-0.4 - number(random, 0.6), 0.4 + number(random, 0.6)]),
        speed_rad_s: [(); 2].map(|()| 0.5 + number(random, 2.0)),
    }
}
