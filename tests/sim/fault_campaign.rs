//! The fault campaign, small: every kind of fault once, and as many pairs.
//!
//! `armbridge fault-campaign --seeds 10000` is the same with more.

use armbridge_servo::Firmware;
use armbridge_sim::fault_campaign;
use armbridge_sim::fault_campaign::{Case, Kind, Origin};
use armbridge_tests::fault_campaign::campaign;

/// Every kind in one activity, and as many pairs.
const SEEDS: u64 = 2 * Kind::ALL.len() as u64;

#[test]
fn whatever_goes_wrong_is_named_and_ends_with_motors_off() {
    ends_with_motors_off(Case::new);
}

#[test]
fn whatever_goes_wrong_with_x_servos_is_named_and_ends_with_motors_off() {
    ends_with_motors_off(|seed| Case::new(seed).with_x_servos());
}

fn ends_with_motors_off(case: fn(u64) -> Case) {
    let (outcomes, report) = campaign(0..SEEDS, case);
    let table = fault_campaign::table(&report);
    assert_eq!(report.singles.len(), Kind::ALL.len());
    assert!(report.singles.iter().all(|row| row.cases == 1), "{table}");
    assert!(report.activities.len() == 12, "{table}");
    // It is a campaign: much has gone wrong, and the board has come back from it.
    let faults = outcomes.iter().filter(|outcome| outcome.fault.is_some());
    let (faults, cleared) = (faults.count() as u64, report.cleared as u64);
    assert!(faults > SEEDS / 4 && cleared > SEEDS / 8, "{table}");
    assert!(
        table
            .lines()
            .take(report.singles.len())
            .all(|line| line.len() <= 120),
        "{table}"
    );
}

/// Seeds of the first singles of a kind, in each activity twenty times.
fn singles(name: &str) -> impl Iterator<Item = u64> {
    let kind: Kind = name.parse().unwrap();
    let index = Kind::ALL.iter().position(|it| *it == kind).unwrap();
    (0..240).map(move |round| 2 * (index + round * Kind::ALL.len()) as u64)
}

/// The torque enable that shows the reset is read every 80 to 90 ms, and again at once if the
/// reading is lost.
#[test]
fn a_reset_of_stock_servos_is_noticed_within_100_ms() {
    let mut noticed = 0;
    for seed in singles("servo-reset").chain(singles("servos-reset")) {
        let case = Case::new(seed);
        let is_late = case.injections.iter().all(|it| it.origin == Origin::Ready);
        let is_fast = case.servos() == Firmware::Stock && case.set_up.period_us <= 2_000;
        if is_fast && is_late && case.activity.is_driven() {
            let detected_ms = fault_campaign::run(&case).detected_ms;
            assert!(
                detected_ms.is_some_and(|ms| ms < 100.0),
                "seed {seed}: {detected_ms:?} ms"
            );
            noticed += 1;
        }
    }
    assert!(noticed >= 10, "{noticed}");
}

/// Ends of a session after which an arm with a pose is parked.
const PARKED: [&str; 5] = [
    "host-vanish",
    "host-stall",
    "host-hello",
    "host-heartbeats",
    "goodbye",
];

/// 2.2 rad/s where it has no pose and falls.
#[test]
fn an_arm_with_a_pose_meets_the_table_at_no_more_than_300_mrad_s() {
    let mut parked = 0;
    for seed in PARKED.into_iter().flat_map(|kind| singles(kind).take(40)) {
        let outcome = fault_campaign::run(&Case::new(seed).with_pose());
        assert_eq!(outcome.failures, [""; 0], "{seed}");
        let contact_rad_s = outcome.contact_rad_s;
        assert!(contact_rad_s <= 0.3, "{seed}: {contact_rad_s}");
        parked += usize::from(contact_rad_s > 0.1);
    }
    assert!(parked > 40, "{parked}");
}

/// The bus echoes at power-up, and no longer when the servos are looked for again.
#[test]
fn servos_are_found_again_after_an_echo_has_ended() {
    for seed in [832, 859, 1_296, 1_847, 2_456] {
        let case = Case::new(seed);
        assert!(case.has("echo-on".parse().unwrap()), "{seed}");
        assert_eq!(fault_campaign::run(&case).failures, [""; 0], "{seed}");
    }
}

/// Runs these cases, none of which violates a requirement or has an unexpected fault.
fn assert_right(seeds: impl IntoIterator<Item = u64>) {
    for seed in seeds {
        let outcome = fault_campaign::run(&Case::new(seed));
        assert_eq!(outcome.failures, [""; 0], "{seed}");
        assert!(outcome.is_fault_expected, "{seed}: {:?}", outcome.fault);
    }
}

/// A servo that was cut off inside a packet waits for up to 254 bytes, which ticks of 5 and
/// 10 ms do not carry in time; at 57 600 baud a stop sequence lasts longer than its interval.
#[test]
fn motors_are_off_in_time_after_a_packet_was_cut_off() {
    assert_right([
        1_396, 4_967, 5_309, 9_555, 10_261, 12_373, 15_552, 17_069, 17_983,
    ]);
}

/// Lines that lose bytes, a mute servo whose successor answers late on a slow bus, and stock
/// servos that did not receive their torque enable.
#[test]
fn servos_that_were_not_reset_are_not_called_so() {
    assert_right([6_032, 6_514, 10_454, 10_456, 12_912, 13_122, 14_304]);
    assert_right([4_634, 12_078, 12_250, 14_918, 17_174]);
}

/// A second master drives motors while the board looks for servos, or prepares them.
#[test]
fn a_second_master_does_not_keep_motors_on() {
    assert_right([608, 2_116, 2_928, 9_540, 14_296, 15_108]);
}

/// A push that balances the motor, a gap of samples between obstacles, a command that is
/// repeated before a turned bit of it is compared, a damaged packet that changes a servo's
/// rate.
#[test]
fn faults_of_rare_cases_have_a_right_name() {
    assert_right([12_090, 13_507, 14_469, 15_062, 15_416]);
}

/// On a slow bus the control steps of a stock servo lengthen its replies.
#[test]
fn stock_servos_at_57_600_baud_are_prepared_and_driven() {
    let is_slow = |seed: &u64| {
        let bus = Case::new(*seed).bus;
        (bus.servos, bus.baud) == (Firmware::Stock, 57_600)
    };
    let kinds = ["host-vanish", "host-range", "client-hang"];
    let seeds: Vec<u64> = kinds
        .into_iter()
        .flat_map(singles)
        .filter(is_slow)
        .collect();
    assert!(seeds.len() > 40, "{}", seeds.len());
    assert_right(seeds);
}

#[test]
fn a_seed_is_the_same_case_whenever_it_is_run() {
    // One of each kind of randomness: bytes, a second master, sensors, host, client, plant.
    let kinds = [
        "lost-to-servos",
        "second-master",
        "encoder-noise",
        "host-flood",
        "client-baud",
    ];
    for name in kinds {
        let seed = singles(name).next().unwrap();
        let case = Case::new(seed);
        let (outcome, story) = fault_campaign::run_with_trace(&case);
        assert_eq!(
            (outcome.clone(), story.clone()),
            fault_campaign::run_with_trace(&case)
        );
        assert_eq!(outcome, fault_campaign::run(&case));
        for injection in case.injections {
            let name = injection.kind.name();
            assert!(story.matches(name).count() >= 2, "{name}: {story}");
        }
    }
}
