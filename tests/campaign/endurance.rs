//! Hours without a false fault: no monitor takes an arm that works for one that does not.

use armbridge_tests::endurance::{Activity, drive_for};

const HOUR_S: u64 = 3_600;

#[test]
fn an_arm_that_stands_for_an_hour_has_no_fault() {
    assert!(drive_for(Activity::Standing, HOUR_S) > 3_590_000);
}

#[test]
fn an_arm_that_moves_for_an_hour_has_no_fault() {
    assert!(drive_for(Activity::Moving, HOUR_S) > 3_590_000);
}
