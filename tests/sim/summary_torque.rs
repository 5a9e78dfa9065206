//! Motion and torque in the summary, against ones known beforehand.

use armbridge_client::LinkStats;
use armbridge_link::message::{Drive, Guards, Mode, Record, Sample};
use armbridge_log::summary::Summary;
use armbridge_tests::synthetic;

/// Records at rest at zero, 1 ms apart.
fn resting(ticks: u32) -> Vec<Record> {
    let mut record = synthetic::run(0.0)[100];
    record.mode = Mode::Running(Drive::Regulate);
    record.output.guards = Guards::NONE;
    record.input.samples = [Sample::Counts(512); 2];
    record.output.torque_nm = [0.2, -0.4];
    record.output.reference_rad = [0.0; 2];
    record.output.reference_speed_rad_s = [0.0; 2];
    record.output.angle_rad = [0.0; 2];
    let tick = |k: u32| {
        record.tick = k;
        record.input.start_us = 5_000_000 + u64::from(k) * 1_000;
        record
    };
    (0..ticks).map(tick).collect()
}

fn summary(records: &[Record]) -> Summary {
    let mut facts = synthetic::facts(None);
    facts.torque_limits_nm = [[-1.18, 1.22]; 2];
    Summary::from_records(records, &facts, LinkStats::default(), 4.0, 0.1)
}

/// A motion of 1 s with an error of 3 mrad, then rest without an error for so many ticks.
fn moved(rest_ticks: u32) -> Summary {
    let mut records = resting(1_000 + rest_ticks);
    for (k, record) in records.iter_mut().enumerate() {
        record.mode = Mode::Running(Drive::Track);
        record.output.reference_rad[0] = k.min(1_000) as f32 * 1e-4;
        record.output.reference_speed_rad_s[0] = if k < 1_000 { 0.1 } else { 0.0 };
        record.output.angle_rad[0] =
            record.output.reference_rad[0] + if k <= 1_000 { 3e-3 } else { 0.0 };
    }
    summary(&records)
}

#[test]
fn the_error_in_motion_does_not_depend_on_the_rest_that_follows() {
    for rest_ticks in [1, 4_000] {
        let [first, second] = moved(rest_ticks).tracking_rms_mrad.unwrap();
        assert!((first - 3.0).abs() < 1e-3, "{rest_ticks}: {first}");
        assert!(second.abs() < 1e-9);
    }
    assert_eq!(summary(&resting(1_000)).tracking_rms_mrad, None);
}

#[test]
fn a_torque_stands_beside_the_limit_of_its_direction() {
    let mut records = resting(1_000);
    records[500].output.torque_nm = [1.22, -1.1];
    let text = summary(&records).totals();
    assert!(
        text.contains("torque at most 1.22 and 1.10 of 1.22 and 1.18 N m"),
        "{text}"
    );
    records[500].output.torque_nm = [-1.1, -1.18];
    let text = summary(&records).totals();
    assert!(
        text.contains("torque at most 1.10 and 1.18 of 1.18 N m"),
        "{text}"
    );
}

/// Remarks on the torque at rest.
fn at_rest(records: &[Record]) -> Vec<String> {
    let remarks = summary(records).remarks.into_iter();
    remarks.filter(|it| it.starts_with("at rest ")).collect()
}

#[test]
fn torque_that_chatters_or_is_limited_at_rest_is_remarked() {
    let steady = resting(2_000);
    assert_eq!(at_rest(&steady), [""; 0]);

    let mut noisy = steady.clone();
    let mut chattering = steady.clone();
    for k in (0..2_000).step_by(2) {
        noisy[k].output.torque_nm[0] += 0.1;
        chattering[k].output.torque_nm[0] += 0.2;
    }
    assert_eq!(at_rest(&noisy), [""; 0]);
    assert_eq!(
        at_rest(&chattering),
        [
            "at rest the torque chatters: it changes by 0.20 and 0.00 N m rms from tick to tick; \
          lower the gains"
        ]
    );

    // 1500 of the ticks are at rest; what limits do before is not rest.
    let mut limited = steady;
    for record in &mut limited[..507] {
        record.output.guards = Guards::TORQUE;
    }
    assert_eq!(at_rest(&limited), [""; 0]);
    for record in &mut limited[1_000..1_015] {
        record.output.guards = Guards::RATE;
    }
    let remarks = at_rest(&limited);
    assert!(
        remarks[0].contains("at rest limits hold the torque back in 1.5 % of the ticks"),
        "{remarks:?}"
    );
}
