//! Torques of an experiment, tick by tick.

use armbridge_control::experiment::Signal;
use armbridge_link::experiment::{ExperimentEnd, HELD_S, Role};
use armbridge_link::message::{Drive, Guards, Record};
use armbridge_tests::tapped_bench::records;

use super::{after, conclusions, during, expected, experiment, heard_of};

/// One PWM count in N m.
const COUNT_NM: f32 = 1.0 / 834.0;

const PRBS: Signal<f32> = Signal::Prbs {
    amplitude: 150.0,
    hold_s: 0.03,
    seed: 7,
};
const STAIRCASE: Signal<f32> = Signal::Staircase {
    from: -60.0,
    to: 60.0,
    steps: 24,
    dwell_s: 0.02,
};
const PULSES: Signal<f32> = Signal::Steps {
    first: 20.0,
    increment: 20.0,
    steps: 5,
    on_s: 0.05,
    off_s: 0.05,
    alternating: true,
};

/// The last experiment record is that of the tick before the end.
fn assert_lasted(ticks: &[Record], duration_s: f32) {
    assert_eq!(ticks.len(), (duration_s * 1e3).round() as usize);
    let is_without_gap = ticks.windows(2).all(|two| two[1].tick == two[0].tick + 1);
    assert!(is_without_gap);
}

#[test]
fn a_pwm_is_what_the_signal_says_in_every_tick() {
    for signal in [PRBS, STAIRCASE, PULSES, Signal::Constant(70.0)] {
        let duration_s = 1.0;
        let plan = experiment([Role::Hold, Role::Pwm(signal)], duration_s);
        let events = heard_of([0.0, 0.0], plan);
        let ticks = during(&events);
        assert_lasted(&ticks, duration_s);
        for (tick, record) in ticks.iter().enumerate() {
            let counts = (1_000.0 + expected(&signal, tick, duration_s)).round() as u16;
            assert_eq!(record.output.guards, Guards::NONE, "{signal:?} {tick}");
            assert_eq!(record.output.pwm[1], counts, "{signal:?} {tick}");
            // The estimator gets the torque that it stands for; 1000 is off.
            let torque_nm = if counts == 1_000 {
                0.0
            } else {
                (f32::from(counts) - 1_015.0) * COUNT_NM
            };
            assert!((record.output.torque_nm[1] - torque_nm).abs() < 1e-6);
        }
        // The decided PWM was sent.
        let is_sent = ticks
            .windows(2)
            .all(|two| two[1].input.pwm_in_force == two[0].output.pwm);
        assert!(is_sent);
    }
}

/// From the torque that held it, more and more, until it slides.
#[test]
fn a_bias_is_on_top_of_what_held_the_joint() {
    let ramp = Signal::Triangle {
        offset: 0.0,
        amplitude: -200.0,
        period_s: 8.0,
    };
    let plan = experiment([Role::Hold, Role::Bias(ramp)], 1.5);
    let events = heard_of([0.0, 0.8], plan);
    let ticks = during(&events);
    let before = records(&events)
        .take_while(|record| record.mode.drive() != Some(Drive::Experiment))
        .last();
    let (held, pushed) = ticks.split_at((HELD_S * 1e3) as usize);
    let counts = before
        .iter()
        .chain(held)
        .map(|record| f32::from(record.output.pwm[1]));
    let mean = counts.sum::<f32>() / (held.len() + 1) as f32;
    assert!(mean < 950.0, "gravity is held: {mean}");
    for (tick, record) in pushed.iter().enumerate() {
        let counts = mean + expected(&ramp, tick, 1.5);
        let off = f32::from(record.output.pwm[1]) - counts;
        assert!(off.abs() < 0.51, "{tick}: {off}");
    }
    // It gives way.
    assert!(ticks.last().unwrap().output.angle_rad[1] < 0.7);
}

#[test]
fn off_is_off_and_the_arm_falls() {
    let plan = experiment([Role::Off, Role::Off], 3.0);
    let events = heard_of([0.15, 0.1], plan);
    let ticks = during(&events);
    let guarded = ticks
        .iter()
        .filter(|record| record.output.guards != Guards::NONE);
    assert_eq!(guarded.count(), 0);
    for record in &ticks {
        assert_eq!(record.output.pwm, [1_000, 1_000], "{record:?}");
        assert_eq!(record.output.torque_nm.map(f32::to_bits), [0; 2]);
        assert_eq!(record.output.reference_rad.map(f32::is_finite), [true; 2]);
    }
    // It falls, out of the envelope, and is caught.
    assert!(ticks.last().unwrap().output.speed_rad_s[0] > 0.8);
    let ends = conclusions(&events);
    assert!(
        matches!(ends[..], [end] if matches!(end.end, ExperimentEnd::Angle { joint: 0 | 1, .. })),
        "{ends:?}"
    );
    let rest = after(&events);
    let farthest = rest.iter().map(|record| record.output.angle_rad[0].abs());
    assert!(farthest.fold(0.0, f32::max) < 1.35);
    assert!(rest.last().unwrap().output.speed_rad_s[0].abs() < 0.1);
}

#[test]
fn a_torque_is_what_the_signal_says_to_half_a_count() {
    let multisine = Signal::Multisine {
        amplitude: 0.25,
        lowest_hz: 0.5,
        lines: 8,
        ramp_s: 0.2,
    };
    let triangle = Signal::Triangle {
        offset: 0.0,
        amplitude: 0.08,
        period_s: 1.0,
    };
    let duration_s = 1.0;
    for signal in [multisine, triangle] {
        let plan = experiment([Role::Hold, Role::Torque(signal)], duration_s);
        let ticks = during(&heard_of([0.0, 0.0], plan));
        assert_lasted(&ticks, duration_s);
        for (tick, record) in ticks.iter().enumerate() {
            let torque_nm = expected(&signal, tick, duration_s);
            // PWM 1000 would be off: it is sent as 1001 or 999.
            let error_nm = (record.output.torque_nm[1] - torque_nm).abs();
            assert!(error_nm < 1.01 * COUNT_NM, "{signal:?} {tick}: {error_nm}");
            assert_ne!(record.output.pwm[1], 1_000);
        }
        // The other joint is held meanwhile, against what the first does to it.
        let apart = ticks
            .iter()
            .map(|r| (r.output.angle_rad[0] - r.output.reference_rad[0]).abs());
        assert!(apart.fold(0.0, f32::max) < 0.08);
    }
}

#[test]
fn an_angle_is_followed_from_where_the_joint_is_held() {
    let signal = Signal::Sinusoid {
        offset: 0.0,
        amplitude: 0.3,
        frequency_hz: 0.5,
        ramp_s: 1.0,
    };
    let duration_s = 4.0;
    let events = heard_of(
        [0.2, -0.1],
        experiment([Role::Angle(signal), Role::Hold], duration_s),
    );
    let ticks = during(&events);
    assert_lasted(&ticks, duration_s);
    for (tick, record) in ticks.iter().enumerate() {
        let wanted = 0.2 + expected(&signal, tick, duration_s);
        assert!((record.output.reference_rad[0] - wanted).abs() < 1e-6);
        assert!((record.output.reference_rad[1] + 0.1).abs() < 1e-6);
        // With the friction of the bench, which a law without integral leaves.
        for joint in 0..2 {
            let error_rad = record.output.angle_rad[joint] - record.output.reference_rad[joint];
            assert!(error_rad.abs() < 0.12, "{tick}: {error_rad}");
        }
    }
    let ends = conclusions(&events);
    assert_eq!(ends.len(), 1);
    assert_eq!(ends[0].end, ExperimentEnd::Finished);
    assert_eq!(ends[0].tick, ticks.last().unwrap().tick + 1);
    // No step of the reference at the end.
    let rest = after(&events);
    assert!((rest[0].output.reference_rad[0] - 0.2).abs() < 1e-3);
}
