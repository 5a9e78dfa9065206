//! An arm drawn at random, from the default plan to control; the campaign has twenty.

use armbridge_tests::arms::{Arm, Judged, arms, compare_control, judge, judge_forecasts};

#[test]
fn an_arm_is_found() {
    let arms = arms(&[2]);
    let numbers: Vec<Judged> = arms.iter().flat_map(Arm::numbers).collect();
    judge(&numbers);
    judge_forecasts(&arms);
    let [worst, _] = compare_control(&arms);
    assert!(worst <= 1.1, "{worst:.3}");
}
