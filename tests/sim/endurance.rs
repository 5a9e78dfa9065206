//! A minute without a false fault; the campaign has hours.

use armbridge_tests::endurance::{Activity, drive_for};

#[test]
fn an_arm_that_stands_or_moves_for_a_minute_has_no_fault() {
    for activity in [Activity::Standing, Activity::Moving] {
        assert!(drive_for(activity, 60) > 59_900, "{activity:?}");
    }
}
