//! Minutes without a false fault; the campaign has hours.

use armbridge_tests::endurance::{Activity, Arm, drive_for};

#[test]
fn an_arm_that_stands_or_moves_for_a_minute_has_no_fault() {
    for activity in [Activity::Standing, Activity::Moving] {
        let driven = drive_for(Arm::DEFAULT, activity, 60);
        assert!(driven > 59_900, "{activity:?}");
    }
}

#[test]
fn arms_with_0_to_2_counts_of_noise_have_no_fault() {
    for (seed, noise_counts) in (0..).zip([0.0, 0.25, 0.5, 0.75, 1.0, 2.0]) {
        for activity in [Activity::Standing, Activity::Moving] {
            let arm = Arm { seed, noise_counts };
            assert!(
                drive_for(arm, activity, 20) > 19_900,
                "{arm:?} {activity:?}"
            );
        }
    }
}
