//! Diagnosis of defective data; good data get none.
//!
//! Simulated: a drawn arm swings for half a minute, and the recorded data are corrupted.

use std::sync::LazyLock;

use armbridge_analysis::identify::{
    Diagnosis, KnownParameters, Prior, Tally, Trace, check_data, check_fit, identify, traces,
};
use armbridge_control::arm::Mounting;
use armbridge_link::limits::Limits;
use armbridge_link::message::{
    Drive, Missing, Mode, Record, Sample, Settings, Setup, TickInput, TickOutput,
};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::PlantConfig;

use super::tracking_loop::{LEAD_S, TrackingLoop};
use super::{multisine, prior_setup, servos};

const SEED: u64 = 5;

fn arm() -> PlantConfig {
    PlantConfig::drawn(SEED, 0.4)
}

/// Both joints swing; `meanwhile` is called each second, with the time in s.
pub(crate) fn swing(
    config: &PlantConfig,
    seconds: f64,
    mut meanwhile: impl FnMut(f64, &mut TrackingLoop),
) -> Trace {
    let mut arm_loop = TrackingLoop::on(config, servos(&prior_setup(config)), SEED);
    for second in 0..seconds as usize {
        let from = second as f64;
        meanwhile(from, &mut arm_loop);
        arm_loop.track(1.0, |t| {
            let t = from + t;
            [multisine(t, 0.25, 0.1, 0.0), multisine(t, 0.3, 0.13, 1.0)]
        });
    }
    arm_loop.trace
}

/// Half a minute without external torque.
static GOOD: LazyLock<Trace> = LazyLock::new(|| swing(&arm(), 30.0, |_, _| ()));

fn known() -> (KnownParameters, Prior) {
    let setup = prior_setup(&arm());
    let known = KnownParameters {
        lead_s: LEAD_S,
        ..KnownParameters::from_setup(&setup)
    };
    (known, Prior::from_setup(&setup, 0.01))
}

/// Diagnosis of traces before a fit.
fn diagnose(traces: &[Trace]) -> Option<Diagnosis> {
    let (known, prior) = known();
    let diagnosis = check_data(traces, &Tally::from_traces(traces), &known, &prior).err();
    println!(
        "{}",
        diagnosis
            .as_ref()
            .map_or("good".into(), ToString::to_string)
    );
    diagnosis
}

/// Diagnosis of a trace including the fit.
fn diagnose_fit(trace: Trace) -> Option<Diagnosis> {
    let (known, prior) = known();
    let traces = [trace];
    let diagnosis = identify(&traces, &Tally::from_traces(&traces), &known, &prior).err();
    println!(
        "{}",
        diagnosis
            .as_ref()
            .map_or("good".into(), ToString::to_string)
    );
    diagnosis
}

/// Log of a trace, with the recorded ticks.
fn records(trace: &Trace, is_recorded: impl Fn(usize) -> bool) -> Vec<Record> {
    let ticks = trace.pwm.iter().zip(&trace.counts).enumerate();
    let record =
        |(tick, (pwm, counts)): (usize, (&[u16; JOINTS], &[Option<u16>; JOINTS]))| Record {
            tick: tick as u32,
            mode: Mode::Running(Drive::Experiment),
            input: TickInput {
                start_us: tick as u64 * 1_000,
                samples: counts
                    .map(|counts| counts.map_or(Sample::Missing(Missing::Silence), Sample::Counts)),
                pwm_in_force: *pwm,
                ..TickInput::AT_REST
            },
            output: TickOutput {
                pwm: *pwm,
                ..TickOutput::NONE
            },
            ..Record::NONE
        };
    ticks
        .filter(|(tick, _)| is_recorded(*tick))
        .map(record)
        .collect()
}

#[test]
fn an_arm_without_external_torque_is_identified() {
    let (known, prior) = known();
    let traces = [GOOD.clone()];
    let tally = Tally::from_traces(&traces);
    let mut found = identify(&traces, &tally, &known, &prior).unwrap();
    assert_eq!(check_fit(&traces, &known, &found), Ok(()));
    // Had it left twice as much as the encoders' noise, the model would not be this arm.
    found.noise_counts = 2.2;
    let diagnosis = check_fit(&traces, &known, &found);
    let is_right = matches!(diagnosis, Err(Diagnosis::ModelMismatch { noise_counts, .. })
        if (1.0..1.1).contains(&noise_counts));
    assert!(is_right, "{diagnosis:?}");
}

#[test]
fn no_data_are_empty() {
    assert_eq!(diagnose(&[]), Some(Diagnosis::Empty));
    assert!(traces(&[], &Setup::default()).is_empty());
}

#[test]
fn a_short_log_is_too_short() {
    let mut trace = GOOD.clone();
    trace.pwm.truncate(1_500);
    trace.counts.truncate(1_500);
    let diagnosis = diagnose(&[trace]);
    assert!(
        matches!(diagnosis, Some(Diagnosis::TooShort { .. })),
        "{diagnosis:?}"
    );
}

#[test]
fn missing_samples_are_counted() {
    let mut trace = GOOD.clone();
    for (tick, counts) in trace.counts.iter_mut().enumerate() {
        // 3 of 10, without a rhythm.
        if (tick * 7919) % 101 < 30 {
            counts[1] = None;
        }
    }
    let Some(Diagnosis::LostSamples {
        joint,
        percent,
        unrecorded,
        ..
    }) = diagnose(&[trace])
    else {
        panic!("no diagnosis");
    };
    assert_eq!((joint, unrecorded), (2, 0));
    assert!((29.0..31.0).contains(&percent), "{percent}");
}

#[test]
fn unrecorded_ticks_are_counted() {
    let records = records(&GOOD, |tick| tick % 2_000 >= 500);
    let mut tally = Tally::default();
    tally.add(&records, &Settings::default());
    let (known, prior) = known();
    let diagnosis = check_data(&traces(&records, &Setup::default()), &tally, &known, &prior);
    let Err(Diagnosis::LostSamples {
        percent,
        unrecorded,
        gaps,
        without_angle,
        ..
    }) = diagnosis
    else {
        panic!("{diagnosis:?}");
    };
    // Ticks before the first recorded one do not count.
    assert_eq!((unrecorded, gaps, without_angle), (14 * 500, 14, 0));
    assert!((23.0..25.0).contains(&percent), "{percent}");
}

#[test]
fn an_encoder_at_the_end_of_its_track_is_clipped() {
    let mut trace = GOOD.clone();
    let all = trace.counts.iter().filter_map(|counts| counts[0]);
    let middle = all.clone().map(f64::from).sum::<f64>() / all.count() as f64;
    // As with a horn that is turned so far that half of the way is off the track.
    for counts in &mut trace.counts {
        counts[0] = counts[0].map(|count| (f64::from(count) - middle).clamp(0.0, 1023.0) as u16);
    }
    let diagnosis = diagnose(&[trace]);
    let is_right = matches!(diagnosis, Some(Diagnosis::ClippedEncoder { joint: 1, percent })
        if (30.0..70.0).contains(&percent));
    assert!(is_right, "{diagnosis:?}");
}

#[test]
fn a_motor_at_its_limit_is_clipped() {
    let mut trace = GOOD.clone();
    for (tick, pwm) in trace.pwm.iter_mut().enumerate() {
        if tick % 2_000 < 1_200 {
            pwm[1] = if tick % 4_000 < 2_000 { 0 } else { 2_000 };
        }
    }
    let diagnosis = diagnose(&[trace]);
    let is_right = matches!(diagnosis, Some(Diagnosis::ClippedMotor { joint: 2, percent })
        if (60.0..65.0).contains(&percent));
    assert!(is_right, "{diagnosis:?}");
}

#[test]
fn a_motor_at_the_boards_limit_is_clipped() {
    let limits = Limits {
        torque_nm: [0.5; JOINTS],
        ..Limits::default()
    };
    let mut records = records(&GOOD, |_| true);
    for record in records.iter_mut().skip(10_000) {
        record.output.torque_nm[0] = -0.499;
    }
    let mut tally = Tally::default();
    let settings = Settings {
        limits,
        ..Settings::default()
    };
    tally.add(&records, &settings);
    let (known, prior) = known();
    let diagnosis = check_data(&traces(&records, &Setup::default()), &tally, &known, &prior);
    let is_right = matches!(diagnosis, Err(Diagnosis::ClippedMotor { joint: 1, percent })
        if (66.0..70.0).contains(&percent));
    assert!(is_right, "{diagnosis:?}");
}

#[test]
fn swapped_servos_are_the_wrong_joint() {
    let mut trace = GOOD.clone();
    for pwm in &mut trace.pwm {
        pwm.swap(0, 1);
    }
    let diagnosis = diagnose(&[trace]);
    let is_right = matches!(diagnosis, Some(Diagnosis::WrongJoint { by_other, by_own, .. })
        if by_other > 80.0 && by_own < 40.0);
    assert!(is_right, "{diagnosis:?}");
}

#[test]
fn a_motor_with_swapped_leads_drives_the_wrong_direction() {
    for joint in 0..JOINTS {
        let mut trace = GOOD.clone();
        for pwm in &mut trace.pwm {
            pwm[joint] = 2_000 - pwm[joint];
        }
        let diagnosis = diagnose(&[trace]);
        let is_right = matches!(diagnosis, Some(Diagnosis::WrongDirection { joint: named, rad_s2 })
            if named == joint + 1 && rad_s2 < 0.0);
        assert!(is_right, "{diagnosis:?}");
    }
}

#[test]
fn a_motor_without_supply_does_not_drive() {
    let mut trace = GOOD.clone();
    // What was sent has nothing to do with how it was moved.
    trace.pwm.rotate_left(7_000);
    let diagnosis = diagnose(&[trace]);
    assert!(
        matches!(diagnosis, Some(Diagnosis::NotDriven { .. })),
        "{diagnosis:?}"
    );
}

#[test]
fn an_external_torque_is_reported_with_its_time() {
    for (joint, torque_nm) in [(0, 0.4), (1, -0.3)] {
        let trace = swing(&arm(), 20.0, |second, arm_loop| {
            if (12.0..15.0).contains(&second) {
                // Intermittent external torque.
                arm_loop.apply_torque(joint, torque_nm, 0.8);
            }
        });
        let Some(Diagnosis::ExternalTorque {
            joint: named,
            from_s,
            to_s,
            torque_nm: found_nm,
            episodes,
            ..
        }) = diagnose_fit(trace)
        else {
            panic!("no diagnosis");
        };
        assert_eq!((named, episodes), (joint + 1, 1));
        assert!(
            (from_s - 12.0).abs() < 0.3 && (to_s - 14.8).abs() < 0.4,
            "{from_s} to {to_s}"
        );
        assert!((found_nm / torque_nm.abs() - 1.0).abs() < 0.4, "{found_nm}");
    }
}

#[test]
fn an_arm_that_is_always_held_is_not_identified() {
    let trace = swing(&arm(), 20.0, |second, arm_loop| {
        let torque_nm = [0.4, 0.5, -0.3, 0.45, -0.4][second as usize % 5];
        arm_loop.apply_torque(second as usize % 2, torque_nm, 0.9);
    });
    let diagnosis = diagnose_fit(trace);
    let is_right =
        matches!(diagnosis, Some(Diagnosis::ExternalTorque { episodes, .. }) if episodes > 3);
    assert!(is_right, "{diagnosis:?}");
}

#[test]
fn a_wrong_mounting_is_a_model_mismatch() {
    let (known, prior) = known();
    let known = KnownParameters {
        mounting: Mounting::Hanging,
        ..known
    };
    let traces = [GOOD.clone()];
    let diagnosis = identify(&traces, &Tally::from_traces(&traces), &known, &prior).err();
    let is_named = matches!(
        diagnosis,
        Some(Diagnosis::NotDriven { .. } | Diagnosis::ModelMismatch { .. })
    );
    assert!(is_named, "{diagnosis:?}");
}
