//! Hours without a false fault: no monitor takes an arm that works for one that does not.

use armbridge_tests::endurance::{Activity, Arm, drive_for};

const HOUR_S: u64 = 3_600;

/// Ten arms, each with 0, 0.5, 1 and 2 counts of noise.
fn arms_have_no_fault_for_an_hour(activity: Activity) {
    for seed in 0..10 {
        for noise_counts in [0.0, 0.5, 1.0, 2.0] {
            let arm = Arm { seed, noise_counts };
            assert!(drive_for(arm, activity, HOUR_S) > 3_590_000, "{arm:?}");
        }
    }
}

#[test]
fn arms_that_stand_for_an_hour_have_no_fault() {
    arms_have_no_fault_for_an_hour(Activity::Standing);
}

#[test]
fn arms_that_move_for_an_hour_have_no_fault() {
    arms_have_no_fault_for_an_hour(Activity::Moving);
}
