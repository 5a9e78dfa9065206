//! Numbers of the summary against ones known beforehand.

use armbridge_client::LinkStats;
use armbridge_link::message::{Drive, Fault, Missing, Mode, Record, Sample, Timing};
use armbridge_log::run_info::RunFacts;
use armbridge_log::simulation::Push;
use armbridge_log::summary::{SegmentSummary, Spread, Summary, Tally, segments};
use armbridge_tests::synthetic;

const LINK: LinkStats = LinkStats {
    sent: 4000,
    lost: 0,
    damaged: 0,
    dropped: 0,
};

/// 4 s of regulation: joint 1 decays to 10 mrad above its reference as
/// exp(-t/0.2 s) from 100 mrad, joint 2 stays 30 mrad below. The reference of
/// joint 1 steps after 2 s.
fn decay() -> Vec<Record> {
    let mut record = synthetic::run(0.0)[100];
    record.mode = Mode::Running(Drive::Regulate);
    record.input.samples = [Sample::Counts(512); 2];
    record.input.pwm_in_force = [1000, 1000];
    record.output.torque_nm = [0.1, -0.4];
    let tick = |k: u32| {
        let reference = if k < 2000 { 0.0 } else { 0.2 };
        let t = f64::from(k % 2000) * 1e-3;
        let angle = f64::from(reference) + 0.010 + 0.090 * (-t / 0.2).exp();
        record.tick = k;
        record.input.start_us = 5_000_000 + u64::from(k) * 1000;
        record.output.reference_rad = [reference, 0.0];
        record.output.angle_rad = [angle as f32, -0.030];
        record.timing = Timing {
            start_error_us: k % 100,
            bus_us: 500,
            compute_ns: 0,
            missed: 0,
        };
        record
    };
    (0..4000).map(tick).collect()
}

fn summary(records: &[Record], facts: &RunFacts) -> Summary {
    Summary::from_records(records, facts, LINK, 4.0, 0.1)
}

#[test]
fn settling_and_steady_state_are_those_of_the_decay() {
    let summary = summary(&decay(), &synthetic::facts(None));
    assert_eq!(summary.segments.len(), 2);
    for (i, segment) in summary.segments.iter().enumerate() {
        assert!((segment.start_s - 2.0 * i as f64).abs() < 1e-9);
        assert!((segment.end_s - 2.0 * (i + 1) as f64).abs() < 1e-9);
        // 90 exp(-t/0.2) < 10 from t = 0.2 ln 9 = 0.4394 s on.
        let settles_s = segment.joints[0].settling_time_s.unwrap();
        assert!((settles_s - 0.440).abs() < 1e-6, "{settles_s}");
        assert!(segment.joints[1].settling_time_s.is_none());
        // Mean of the decay's tail, 1.5 s to 2 s: 10 + 0.018 mrad.
        let rest_mrad = segment.joints[0].steady_state_error_mrad;
        assert!((rest_mrad - 10.018).abs() < 0.002, "{rest_mrad}");
        assert!((segment.joints[1].steady_state_error_mrad + 30.0).abs() < 1e-4);
        let counts = segment.joints[1].steady_state_error_counts;
        assert!(
            (counts + 0.030 / synthetic::RAD_PER_COUNT).abs() < 1e-4,
            "{counts}"
        );
    }
}

/// 4 s at one setpoint: joint 1 comes to rest at `rest_rad`, after exp(-t/0.2 s) from 100 mrad
/// more, and is pushed to `pushed_rad` more at 2 s, for 0.1 s.
fn pushed(rest_rad: f64, pushed_rad: f64) -> (Vec<Record>, Push) {
    let mut records = decay();
    for (k, record) in records.iter_mut().enumerate() {
        let t = k as f64 * 1e-3;
        let bump = if k < 2000 { 0.0 } else { pushed_rad };
        let since_s = if k < 2000 { t } else { (t - 2.1).max(0.0) };
        let start_rad = if k < 2000 { 0.1 } else { bump };
        record.output.reference_rad = [0.0; 2];
        record.output.angle_rad = [
            (rest_rad + start_rad * (-since_s / 0.2).exp()) as f32,
            -0.001,
        ];
    }
    let push = Push {
        joint: 0,
        torque_nm: 0.3,
        start_ns: 7_000_000_000,
        duration_ns: 100_000_000,
    };
    (records, push)
}

fn pushed_summary(rest_rad: f64, pushed_rad: f64) -> Summary {
    let (records, push) = pushed(rest_rad, pushed_rad);
    let mut tally = Tally::default();
    for record in &records {
        if record.input.start_us == push.start_ns / 1_000 {
            tally.push(&push);
        }
        tally.add(record);
    }
    tally.summary(&synthetic::facts(None), LINK, 4.0, 0.1)
}

#[test]
fn settling_ends_with_a_push_and_recovery_begins() {
    let summary = pushed_summary(0.0, 0.08);
    // 100 exp(-t/0.2) < 20 from t = 0.2 ln 5 = 0.3219 s on.
    let settles_s = summary.segments[0].joints[0].settling_time_s.unwrap();
    assert!((settles_s - 0.322).abs() < 1e-6, "{settles_s}");
    let [push] = summary.pushes[..] else {
        panic!("{:?}", summary.pushes);
    };
    // 80 exp(-t/0.2) < 20 from t = 0.2 ln 4 = 0.2773 s after the push on.
    assert!((push.recovered_s.unwrap() - 0.278).abs() < 1e-6, "{push:?}");
    assert!((push.peak_error_mrad - 80.0).abs() < 1e-3, "{push:?}");
    assert!((push.start_s - 2.0).abs() < 1e-9 && (push.duration_s - 0.1).abs() < 1e-9);
    assert_eq!((push.joint, push.torque_nm), (1, 0.3));
    // A push that is not known of is a motion like any other.
    let (records, push) = pushed(0.0, 0.08);
    let segment = &segments(&records)[0];
    let facts = synthetic::facts(None);
    let settles_s = |pushes: &[Push]| {
        SegmentSummary::evaluate_pushed(&records, segment, pushes, &facts).joints[0].settling_time_s
    };
    assert!((settles_s(&[push]).unwrap() - 0.322).abs() < 1e-6);
    assert!((settles_s(&[]).unwrap() - 2.378).abs() < 1e-6);
}

#[test]
fn an_arm_that_stays_away_neither_settles_nor_recovers() {
    let summary = pushed_summary(0.03, 0.08);
    assert_eq!(summary.segments[0].joints[0].settling_time_s, None);
    assert_eq!(summary.pushes[0].recovered_s, None);
    assert!(summary.segments[0].joints[0].is_at_rest);
}

#[test]
fn a_joint_settles_if_it_stays_for_half_a_second() {
    let mut records = decay();
    records.truncate(2000);
    // Joint 2 comes into the band in the last 13 ms.
    for record in &mut records[1987..] {
        record.output.angle_rad[1] = -0.019;
    }
    let summary = summary(&records, &synthetic::facts(None));
    assert_eq!(summary.segments[0].joints[1].settling_time_s, None);
    assert!(summary.segments[0].joints[0].settling_time_s.is_some());
}

#[test]
fn a_fall_is_no_rest() {
    let mut records = decay();
    records.truncate(3000);
    for (k, record) in records[2800..].iter_mut().enumerate() {
        record.output.angle_rad[1] = -0.03 - 0.001 * k as f32;
    }
    let rests = |records: &[Record]| {
        let remarks = summary(records, &synthetic::facts(Some(0.01))).remarks;
        remarks
            .iter()
            .filter(|remark| remark.contains("joint 2 rests"))
            .cloned()
            .collect::<Vec<_>>()
    };
    let before = rests(&records[..2000]);
    assert!(before[0].contains("up to 30.0 mrad"), "{before:?}");
    // The fall is no rest, nor is what a fault ends.
    assert_eq!(rests(&records), before);
    let mut records = decay();
    records[1999].mode = Mode::Fault(Fault::SpeedLimit);
    assert_eq!(rests(&records[..2000]), [""; 0]);
}

#[test]
fn the_run_is_measured_over_all_its_ticks() {
    let mut records = decay();
    records[1000].output.torque_nm[0] = -0.9;
    records[1000].input.pwm_in_force[1] = 300;
    let summary = summary(&records, &synthetic::facts(None));
    assert!((summary.peak_torque_nm[0] - 0.9).abs() < 1e-6);
    assert_eq!(summary.peak_pwm_deviation, [0, 700]);
    // 0 to 99, forty times each: mean 49.5, variance (100^2 - 1) / 12.
    let Spread {
        mean,
        std,
        p99,
        max,
    } = summary.start_error_us;
    assert!((mean - 49.5).abs() < 1e-9);
    assert!((std - (9999.0f64 / 12.0).sqrt()).abs() < 1e-9);
    assert_eq!((p99, max), (98, 99));
    assert!((summary.bus_occupancy_percent - 50.0).abs() < 1e-9);
    assert!(summary.compute_ns.is_none());
    assert!((summary.simulated_s_per_wall_s - 40.0).abs() < 1e-9);
}

#[test]
fn faults_and_losses_are_said() {
    let mut records = decay();
    for record in &mut records[3000..] {
        record.mode = Mode::Fault(Fault::SamplesLost);
    }
    records[10].input.samples[1] = Sample::Missing(Missing::Silence);
    records[11].input.samples = [
        Sample::Missing(Missing::Line),
        Sample::Missing(Missing::Silence),
    ];
    let link = LinkStats {
        sent: 4000,
        lost: 3,
        damaged: 1,
        dropped: 0,
    };
    let summary = Summary::from_records(&records, &synthetic::facts(None), link, 4.0, 0.1);
    assert_eq!(summary.faults.len(), 1);
    assert!((summary.faults[0].time_s - 3.0).abs() < 1e-9);
    assert_eq!(summary.missing_samples["silence"], 2);
    assert_eq!(summary.missing_samples["line"], 1);
    let text = summary.table().replace("\n   ", "");
    for words in [
        "FAULT samples_lost at 3.000 s",
        "3 samples missing: line 1, silence 2",
    ] {
        assert!(text.contains(words), "{text}");
    }
    assert!(text.contains("not complete: 3 lost, 1 damaged"), "{text}");
    // The fault ends the last segment.
    assert!((summary.segments[1].end_s - 3.0).abs() < 1e-9);
}

#[test]
fn the_rest_is_blamed_on_stiction_only_where_it_explains_it() {
    let records = decay();
    let remarks = |friction| {
        summary(&records, &synthetic::facts(friction))
            .remarks
            .join("\n")
    };
    // 30 mrad at joint 2, whose net stiffness is 1.10 - 0.181 N m/rad.
    assert!(remarks(Some(0.06)).contains(
        "joint 2 rests up to 30.0 mrad from its setpoint, within what static friction explains: \
         0.06 N m / 0.919 N m/rad = 65.3 mrad"
    ));
    // 27.2 mrad, and one count is 5.1 mrad.
    assert!(remarks(Some(0.025)).contains("within one encoder count of what static friction"));
    assert!(remarks(Some(0.01)).contains("joint 2 rests up to 30.0 mrad from its setpoint, MORE"));
    assert!(remarks(None).contains("more than one encoder count (5.1 mrad)"));
}

#[test]
fn a_run_without_ticks_has_a_summary_too() {
    let summary =
        Summary::from_records(&[], &synthetic::facts(None), LinkStats::default(), 0.0, 0.0);
    assert!(summary.segments.is_empty() && summary.faults.is_empty());
    assert!(summary.table().contains("0 ticks"));
}

#[test]
fn table_fits_and_json_keeps_its_keys() {
    let records = synthetic::run(0.06);
    let facts = synthetic::facts(Some(0.06));
    assert_eq!(segments(&records).len(), synthetic::SETPOINTS.len());
    let summary = Summary::from_records(&records, &facts, LINK, 10.02, 0.31);
    let text = summary.table();
    let widest = text.lines().map(|line| line.chars().count()).max();
    assert!(widest <= Some(80) && !text.contains('\u{1b}'), "{text}");
    println!("{text}");

    let json = serde_json::to_value(&summary).unwrap();
    let keys: Vec<_> = json
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    let mut expected = vec![
        "run",
        "ticks",
        "simulated_s",
        "wall_s",
        "simulated_s_per_wall_s",
        "segments",
        "segments_left_out",
        "pushes",
        "tracking_rms_mrad",
        "peak_torque_nm",
        "peak_torque_limit_nm",
        "rest_torque",
        "peak_pwm_deviation",
        "start_error_us",
        "bus_us",
        "bus_occupancy_percent",
        "compute_ns",
        "missed_ticks",
        "missing_samples",
        "faults",
        "records",
        "log",
        "ended",
        "missed_expectations",
        "servos",
        "port",
        "remarks",
    ];
    expected.sort_unstable();
    assert_eq!(keys, expected);
    assert!(json["segments"][0]["joints"][0]["steady_state_error_mrad"].is_number());
}
