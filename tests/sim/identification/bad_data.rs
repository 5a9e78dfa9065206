//! Data that tell no arm are told by name; good ones are not.
//!
//! Simulated: a drawn arm swings for half a minute, and what was recorded is spoilt.

use std::sync::LazyLock;

use armbridge_analysis::identify::{
    Diagnosis, Known, Prior, Tally, Trace, examine, identify, judge, traces,
};
use armbridge_shared::JOINTS;
use armbridge_shared::arm::Mounting;
use armbridge_shared::link::limits::Limits;
use armbridge_shared::link::message::{Drive, Missing, Mode, Record, Sample};
use armbridge_sim::plant::PlantConfig;

use super::hands::{Hands, LEAD_S};
use super::{believed, multisine, servos};

const SEED: u64 = 5;

fn arm() -> PlantConfig {
    PlantConfig::drawn(SEED, 0.4)
}

/// Both joints swing; `meanwhile` is told how many seconds have passed, each second.
pub(crate) fn swing(
    config: &PlantConfig,
    seconds: f64,
    mut meanwhile: impl FnMut(f64, &mut Hands),
) -> Trace {
    let mut hands = Hands::on(config, servos(&believed(config)), SEED);
    for second in 0..seconds as usize {
        let from = second as f64;
        meanwhile(from, &mut hands);
        hands.track(1.0, |t| {
            let t = from + t;
            [multisine(t, 0.25, 0.1, 0.0), multisine(t, 0.3, 0.13, 1.0)]
        });
    }
    hands.trace
}

/// Half a minute of nothing but motors.
static GOOD: LazyLock<Trace> = LazyLock::new(|| swing(&arm(), 30.0, |_, _| ()));

fn known() -> (Known, Prior) {
    let setup = believed(&arm());
    let known = Known {
        lead_s: LEAD_S,
        ..Known::of(&setup)
    };
    (known, Prior::of(&setup, 0.01))
}

/// What is said of traces before anything is sought in them.
fn said(traces: &[Trace]) -> Option<Diagnosis> {
    let (known, prior) = known();
    let said = examine(traces, &Tally::of_traces(traces), &known, &prior).err();
    println!(
        "{}",
        said.as_ref().map_or("good".into(), ToString::to_string)
    );
    said
}

/// What is said of traces in the end.
fn said_at_last(trace: Trace) -> Option<Diagnosis> {
    let (known, prior) = known();
    let traces = [trace];
    let said = identify(&traces, &Tally::of_traces(&traces), &known, &prior).err();
    println!(
        "{}",
        said.as_ref().map_or("good".into(), ToString::to_string)
    );
    said
}

/// A log with these ticks.
fn records(trace: &Trace, is_recorded: impl Fn(usize) -> bool) -> Vec<Record> {
    let ticks = trace.pwm.iter().zip(&trace.counts).enumerate();
    let record =
        |(tick, (pwm, counts)): (usize, (&[u16; JOINTS], &[Option<u16>; JOINTS]))| Record {
            tick: tick as u32,
            start_us: tick as u64 * 1_000,
            mode: Mode::Running(Drive::Experiment),
            samples: counts
                .map(|counts| counts.map_or(Sample::Missing(Missing::Silence), Sample::Counts)),
            pwm_in_force: *pwm,
            pwm_next: *pwm,
            ..Record::NONE
        };
    ticks
        .filter(|(tick, _)| is_recorded(*tick))
        .map(record)
        .collect()
}

#[test]
fn an_arm_left_to_its_motors_is_found() {
    let (known, prior) = known();
    let traces = [GOOD.clone()];
    let tally = Tally::of_traces(&traces);
    let mut found = identify(&traces, &tally, &known, &prior).unwrap();
    assert_eq!(judge(&traces, &known, &found), Ok(()));
    // Had it left twice as much as the encoders' noise, the model would not be this arm.
    found.noise_counts = 2.2;
    let said = judge(&traces, &known, &found);
    let is_right = matches!(said, Err(Diagnosis::NotThisArm { noise_counts, .. })
        if (1.0..1.1).contains(&noise_counts));
    assert!(is_right, "{said:?}");
}

#[test]
fn nothing_at_all_is_empty() {
    assert_eq!(said(&[]), Some(Diagnosis::Empty));
    assert!(traces(&[]).is_empty());
}

#[test]
fn a_second_is_too_short() {
    let mut trace = GOOD.clone();
    trace.pwm.truncate(1_500);
    trace.counts.truncate(1_500);
    let said = said(&[trace]);
    assert!(matches!(said, Some(Diagnosis::TooShort { .. })), "{said:?}");
}

#[test]
fn samples_that_did_not_come_are_counted() {
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
        missed,
        ..
    }) = said(&[trace])
    else {
        panic!("not told");
    };
    assert_eq!((joint, missed), (2, 0));
    assert!((29.0..31.0).contains(&percent), "{percent}");
}

#[test]
fn ticks_that_were_not_recorded_are_counted() {
    let records = records(&GOOD, |tick| tick % 2_000 >= 500);
    let mut tally = Tally::default();
    tally.add(&records, &Limits::default());
    let (known, prior) = known();
    let said = examine(&traces(&records), &tally, &known, &prior);
    let Err(Diagnosis::LostSamples {
        percent,
        missed,
        gaps,
        silent,
        ..
    }) = said
    else {
        panic!("{said:?}");
    };
    // What is missing before the first is nobody's.
    assert_eq!((missed, gaps, silent), (14 * 500, 14, 0));
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
    let said = said(&[trace]);
    let is_right = matches!(said, Some(Diagnosis::ClippedEncoder { joint: 1, percent })
        if (30.0..70.0).contains(&percent));
    assert!(is_right, "{said:?}");
}

#[test]
fn a_motor_at_its_limit_is_clipped() {
    let mut trace = GOOD.clone();
    for (tick, pwm) in trace.pwm.iter_mut().enumerate() {
        if tick % 2_000 < 1_200 {
            pwm[1] = if tick % 4_000 < 2_000 { 0 } else { 2_000 };
        }
    }
    let said = said(&[trace]);
    let is_right = matches!(said, Some(Diagnosis::ClippedMotor { joint: 2, percent })
        if (60.0..65.0).contains(&percent));
    assert!(is_right, "{said:?}");
}

#[test]
fn a_motor_at_the_boards_limit_is_clipped() {
    let limits = Limits {
        torque_nm: [0.5; JOINTS],
        ..Limits::default()
    };
    let mut records = records(&GOOD, |_| true);
    for record in records.iter_mut().skip(10_000) {
        record.torque_nm[0] = -0.499;
    }
    let mut tally = Tally::default();
    tally.add(&records, &limits);
    let (known, prior) = known();
    let said = examine(&traces(&records), &tally, &known, &prior);
    let is_right = matches!(said, Err(Diagnosis::ClippedMotor { joint: 1, percent })
        if (66.0..70.0).contains(&percent));
    assert!(is_right, "{said:?}");
}

#[test]
fn swapped_servos_are_the_wrong_joint() {
    let mut trace = GOOD.clone();
    for pwm in &mut trace.pwm {
        pwm.swap(0, 1);
    }
    let said = said(&[trace]);
    let is_right = matches!(said, Some(Diagnosis::WrongJoint { by_other, by_own, .. })
        if by_other > 80.0 && by_own < 40.0);
    assert!(is_right, "{said:?}");
}

#[test]
fn a_motor_with_its_leads_swapped_pushes_the_wrong_way() {
    for joint in 0..JOINTS {
        let mut trace = GOOD.clone();
        for pwm in &mut trace.pwm {
            pwm[joint] = 2_000 - pwm[joint];
        }
        let said = said(&[trace]);
        let is_right = matches!(said, Some(Diagnosis::WrongWay { joint: named, rad_s2 })
            if named == joint + 1 && rad_s2 < 0.0);
        assert!(is_right, "{said:?}");
    }
}

#[test]
fn a_motor_without_supply_does_not_drive() {
    let mut trace = GOOD.clone();
    // What was sent has nothing to do with how it was moved.
    trace.pwm.rotate_left(7_000);
    let said = said(&[trace]);
    assert!(
        matches!(said, Some(Diagnosis::NotDriven { .. })),
        "{said:?}"
    );
}

#[test]
fn a_hand_is_named_with_its_seconds() {
    for (joint, torque_nm) in [(0, 0.4), (1, -0.3)] {
        let trace = swing(&arm(), 20.0, |second, hands| {
            if (12.0..15.0).contains(&second) {
                // A hand that comes and goes.
                hands.push(joint, torque_nm, 0.8);
            }
        });
        let Some(Diagnosis::HeldByHand {
            joint: named,
            from_s,
            to_s,
            torque_nm: told,
            pushes,
            ..
        }) = said_at_last(trace)
        else {
            panic!("not told");
        };
        assert_eq!((named, pushes), (joint + 1, 1));
        assert!(
            (from_s - 12.0).abs() < 0.3 && (to_s - 14.8).abs() < 0.4,
            "{from_s} to {to_s}"
        );
        assert!((told / torque_nm.abs() - 1.0).abs() < 0.4, "{told}");
    }
}

#[test]
fn an_arm_that_is_never_let_go_is_not_found() {
    let trace = swing(&arm(), 20.0, |second, hands| {
        let torque_nm = [0.4, 0.5, -0.3, 0.45, -0.4][second as usize % 5];
        hands.push(second as usize % 2, torque_nm, 0.9);
    });
    let said = said_at_last(trace);
    let is_right = matches!(said, Some(Diagnosis::HeldByHand { pushes, .. }) if pushes > 3);
    assert!(is_right, "{said:?}");
}

#[test]
fn an_arm_the_other_way_up_is_not_this_one() {
    let (known, prior) = known();
    let known = Known {
        mounting: Mounting::Hanging,
        ..known
    };
    let traces = [GOOD.clone()];
    let said = identify(&traces, &Tally::of_traces(&traces), &known, &prior).err();
    let is_named = matches!(
        said,
        Some(Diagnosis::NotDriven { .. } | Diagnosis::NotThisArm { .. })
    );
    assert!(is_named, "{said:?}");
}
