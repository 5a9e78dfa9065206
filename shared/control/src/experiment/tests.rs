//! Every signal against its closed form, its bounds and its differences.

use super::{Bounds, Flaw, LINES_MAX, Sample, Signal};
use core::f64::consts::{PI, TAU};
use proptest::prelude::*;
extern crate std;
use std::vec::Vec;

const DURATION_S: f64 = 20.0;

fn value(signal: &Signal<f64>, t_s: f64) -> f64 {
    signal.at(t_s, DURATION_S).value
}

fn any_signal() -> impl Strategy<Value = Signal<f64>> {
    let number = -2.0..2.0_f64;
    let time = 0.01..3.0_f64;
    let ramp = prop_oneof![Just(0.0), 0.01..10.0_f64];
    let hz = 0.0..5.0_f64;
    let count = 1..=LINES_MAX;
    (
        number.clone(),
        number,
        time.clone(),
        time,
        ramp,
        hz.clone(),
        hz,
        count,
    )
        .prop_flat_map(|(a, b, one_s, other_s, ramp_s, hz, to_hz, count)| {
            prop_oneof![
                Just(Signal::Constant(a)),
                Just(Signal::Triangle {
                    offset: a,
                    amplitude: b,
                    period_s: one_s,
                }),
                Just(Signal::Staircase {
                    from: a,
                    to: b,
                    steps: count,
                    dwell_s: one_s,
                }),
                any::<bool>().prop_map(move |alternating| Signal::Steps {
                    first: a,
                    increment: b * 0.1,
                    steps: count,
                    on_s: one_s,
                    off_s: other_s,
                    alternating,
                }),
                Just(Signal::Sinusoid {
                    offset: a,
                    amplitude: b,
                    frequency_hz: hz,
                    ramp_s,
                }),
                Just(Signal::Chirp {
                    offset: a,
                    amplitude: b,
                    from_hz: hz,
                    to_hz,
                    ramp_s,
                }),
                Just(Signal::Multisine {
                    amplitude: a,
                    lowest_hz: hz * 0.2,
                    lines: count,
                    ramp_s,
                }),
                any::<u32>().prop_map(move |seed| Signal::Prbs {
                    amplitude: a,
                    hold_s: one_s,
                    seed,
                }),
            ]
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_signal_leaves_its_bounds(signal in any_signal()) {
        prop_assert_eq!(signal.flaw(DURATION_S), None);
        let Bounds { low, high, derivatives } = signal.bounds(DURATION_S);
        for i in 0..=4_000 {
            let Sample { value, first, second } = signal.at(f64::from(i) * 0.005, DURATION_S);
            prop_assert!(value >= low - 1e-9 && value <= high + 1e-9, "{value} {low} {high}");
            if let Some([most, most_second]) = derivatives {
                prop_assert!(first.abs() <= most * 1.000_001 + 1e-9, "{first} {most}");
                prop_assert!(second.abs() <= most_second * 1.000_001 + 1e-9);
            }
        }
    }

    /// So that an angle may follow it: no step in angle or speed, and rest at both ends.
    #[test]
    fn derivatives_are_those_of_the_value(signal in any_signal(), at in 0.0..1.0_f64) {
        if let Some([_, most]) = signal.bounds(DURATION_S).derivatives {
            const STEP_S: f64 = 1e-5;
            let t_s = STEP_S + at * (DURATION_S - 2.0 * STEP_S);
            let here = signal.at(t_s, DURATION_S);
            let (before, after) = (
                signal.at(t_s - STEP_S, DURATION_S),
                signal.at(t_s + STEP_S, DURATION_S),
            );
            let slack = STEP_S * (1.0 + most * 1e3);
            let slope = |before: f64, after: f64| (after - before) / (2.0 * STEP_S);
            prop_assert!((slope(before.value, after.value) - here.first).abs() < slack);
            prop_assert!((slope(before.first, after.first) - here.second).abs() < slack);
            for t_s in [0.0, DURATION_S] {
                let end = signal.at(t_s, DURATION_S);
                prop_assert!(end.value.abs() < 1e-12 && end.first.abs() < 1e-12);
            }
        }
    }

    /// Board and host compute the same, to a part in ten thousand, except for an edge that falls between two ticks.
    #[test]
    fn single_precision_is_enough(signal in any_signal(), tick in 0_u32..20_000) {
        let t_s = tick as f32 * 1e-3;
        if signal.bounds(DURATION_S).derivatives.is_some() {
            let close = single(&signal).at(t_s, DURATION_S as f32);
            let exact = signal.at(t_s.into(), DURATION_S);
            prop_assert!((f64::from(close.value) - exact.value).abs() < 2e-4);
        }
    }
}

fn single(signal: &Signal<f64>) -> Signal<f32> {
    match *signal {
        Signal::Constant(value) => Signal::Constant(value as f32),
        Signal::Sinusoid {
            offset,
            amplitude,
            frequency_hz,
            ramp_s,
        } => Signal::Sinusoid {
            offset: offset as f32,
            amplitude: amplitude as f32,
            frequency_hz: frequency_hz as f32,
            ramp_s: ramp_s as f32,
        },
        Signal::Chirp {
            offset,
            amplitude,
            from_hz,
            to_hz,
            ramp_s,
        } => Signal::Chirp {
            offset: offset as f32,
            amplitude: amplitude as f32,
            from_hz: from_hz as f32,
            to_hz: to_hz as f32,
            ramp_s: ramp_s as f32,
        },
        Signal::Multisine {
            amplitude,
            lowest_hz,
            lines,
            ramp_s,
        } => Signal::Multisine {
            amplitude: amplitude as f32,
            lowest_hz: lowest_hz as f32,
            lines,
            ramp_s: ramp_s as f32,
        },
        Signal::Triangle { .. }
        | Signal::Staircase { .. }
        | Signal::Steps { .. }
        | Signal::Prbs { .. } => unreachable!("it has edges"),
    }
}

#[test]
fn a_triangle_goes_up_first() {
    let signal = Signal::Triangle {
        offset: 1.0,
        amplitude: 0.5,
        period_s: 4.0,
    };
    let eighths = |t_s| (value(&signal, t_s) * 8.0) as i64;
    let at = [0.0, 0.5, 1.0, 2.0, 3.0, 3.5, 4.0, 5.0].map(eighths);
    assert_eq!(at, [8, 10, 12, 8, 4, 6, 8, 12]);
    let slopes = [0.1, 2.1, 3.9].map(|t_s| (signal.at(t_s, DURATION_S).first * 2.0) as i64);
    assert_eq!(slopes, [1, -1, 1]);
}

#[test]
fn a_staircase_goes_there_and_back_until_the_end() {
    let signal = Signal::Staircase {
        from: -30.0,
        to: 60.0,
        steps: 3,
        dwell_s: 0.25,
    };
    let levels: Vec<f64> = (0..14)
        .map(|i| value(&signal, f64::from(i) * 0.25))
        .collect();
    let once = [-30.0, 0.0, 30.0, 60.0, 30.0, 0.0];
    let twice = once.into_iter().chain(once).chain([-30.0, 0.0]);
    assert_eq!(levels, twice.collect::<Vec<_>>());
}

#[test]
fn pulses_grow_and_stop() {
    let signal = |alternating| Signal::Steps {
        first: 0.1,
        increment: 0.2,
        steps: 3,
        on_s: 0.5,
        off_s: 0.25,
        alternating,
    };
    let on = |signal: &Signal<f64>| -> Vec<i64> {
        let in_pulse = |i: i32| value(signal, f64::from(i) * 0.75 + 0.499);
        (0..8)
            .map(|i| (in_pulse(i) * 10.0).round() as i64)
            .collect()
    };
    assert_eq!(on(&signal(false)), [1, 3, 5, 0, 0, 0, 0, 0]);
    assert_eq!(on(&signal(true)), [1, -1, 3, -3, 5, -5, 0, 0]);
    for i in 0..3 {
        assert!(value(&signal(true), f64::from(i) * 0.75 + 0.5).abs() < 1e-12);
    }
}

/// Edges come at the tick that they belong to, whatever `f32` makes of the time.
#[test]
fn edges_are_on_the_grid_of_the_ticks() {
    for dwell_ms in [20_u32, 70, 100, 130, 1_000] {
        let signal = Signal::Staircase {
            from: 0.0_f32,
            to: 200.0,
            steps: 200,
            dwell_s: dwell_ms as f32 * 1e-3,
        };
        for tick in 0..600_000_u32 {
            let t_s = (tick * 1_000) as f32 * 1e-6;
            let step = (tick / dwell_ms) % 400;
            let expected = step.min(400 - step) as f32;
            let is = signal.at(t_s, 600.0).value;
            assert!(
                (is - expected).abs() < 1e-3,
                "{tick} of {dwell_ms}: {is} {expected}"
            );
        }
    }
}

#[test]
fn waves_are_what_their_formulas_say() {
    let sinusoid = Signal::Sinusoid {
        offset: 0.3,
        amplitude: -0.7,
        frequency_hz: 1.3,
        ramp_s: 2.0,
    };
    let chirp = Signal::Chirp {
        offset: 0.3,
        amplitude: 0.7,
        from_hz: 0.5,
        to_hz: 4.5,
        ramp_s: 2.0,
    };
    let multisine = Signal::Multisine {
        amplitude: 0.8,
        lowest_hz: 0.2,
        lines: 12,
        ramp_s: 2.0,
    };
    // Between the ramps.
    for i in 0..1_600 {
        let t = 2.0 + f64::from(i) * 0.01;
        let expected = 0.3 - 0.7 * (TAU * 1.3 * t).sin();
        assert!((value(&sinusoid, t) - expected).abs() < 1e-12);
        let expected = 0.3 + 0.7 * (TAU * (0.5 * t + 0.1 * t * t)).sin();
        assert!((value(&chirp, t) - expected).abs() < 1e-12);
        let line = |k: f64| (TAU * 0.2 * k * t - PI * k * (k - 1.0) / 12.0).cos();
        let sum: f64 = (1..=12).map(|k| line(f64::from(k))).sum();
        let expected = 0.8 / (1.53 * 12_f64.sqrt()) * sum;
        assert!((value(&multisine, t) - expected).abs() < 1e-12);
    }
}

/// A sum of `lines` cosines that was sampled so often is at most `1 / cos(pi/64)` more
/// between the samples (Ehlich and Zeller).
#[test]
fn the_peak_of_a_multisine_is_its_amplitude_at_most() {
    const PER_LINE: u32 = 64;
    for lines in 1..=LINES_MAX {
        let signal = Signal::Multisine {
            amplitude: 1.0,
            lowest_hz: 1.0,
            lines,
            ramp_s: 0.0,
        };
        let samples = PER_LINE * 2 * u32::from(lines);
        let at = |i: u32| value(&signal, f64::from(i) / f64::from(samples)).abs();
        let most = (0..samples).map(at).fold(0.0, f64::max) / (PI / f64::from(PER_LINE)).cos();
        assert!(most <= 1.0 && most > 0.6, "{lines}: {most}");
    }
}

#[test]
fn chance_is_even_and_has_no_memory() {
    for seed in [0, 1, 12_345, u32::MAX] {
        let signal = Signal::Prbs {
            amplitude: 1.0,
            hold_s: 0.01,
            seed,
        };
        let signs: Vec<f64> = (0..2_000)
            .map(|i| value(&signal, f64::from(i) * 0.01 + 0.004))
            .collect();
        assert!(signs.iter().all(|sign| (sign.abs() - 1.0).abs() < 1e-12));
        // Four standard deviations of a fair coin.
        let limit = 4.0 * (signs.len() as f64).sqrt();
        for lag in 0..20 {
            let pairs = signs.iter().zip(signs.iter().skip(lag));
            let sum: f64 = pairs.map(|(a, b)| if lag == 0 { *a } else { a * b }).sum();
            assert!(sum.abs() < limit, "seed {seed}, lag {lag}: {sum}");
        }
    }
}

#[test]
fn what_is_no_signal_is_said() {
    let wave = |frequency_hz, ramp_s| Signal::Sinusoid {
        offset: 0.0,
        amplitude: 1.0,
        frequency_hz,
        ramp_s,
    };
    let lines = |lines| Signal::Multisine {
        amplitude: 1.0,
        lowest_hz: 4.0,
        lines,
        ramp_s: 1.0,
    };
    for (signal, flaw) in [
        (wave(1.0, 0.0), None),
        (wave(1.0, 10.0), None),
        (wave(1.0, 10.1), Some(Flaw::Ramp)),
        (wave(1.0, 0.001), Some(Flaw::Ramp)),
        (wave(-1.0, 1.0), Some(Flaw::Frequency)),
        (wave(51.0, 1.0), Some(Flaw::Frequency)),
        (wave(f64::NAN, 1.0), Some(Flaw::NotFinite)),
        (lines(12), None),
        (lines(13), Some(Flaw::Frequency)),
        (lines(0), Some(Flaw::Count)),
        (lines(33), Some(Flaw::Count)),
        (
            Signal::Prbs {
                amplitude: 1.0,
                hold_s: 0.009,
                seed: 0,
            },
            Some(Flaw::Time),
        ),
        (
            Signal::Staircase {
                from: 0.0,
                to: f64::INFINITY,
                steps: 1,
                dwell_s: 1.0,
            },
            Some(Flaw::NotFinite),
        ),
    ] {
        assert_eq!(signal.flaw(DURATION_S), flaw, "{signal:?}");
    }
}
