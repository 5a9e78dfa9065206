//! Twenty arms drawn at random, from the default plan to control.

use armbridge_tests::arms::{Arm, Judged, arms, compare_control, judge, judge_forecasts};

#[test]
fn twenty_arms_are_found_and_controlled_as_if_they_were_known() {
    let seeds: Vec<u64> = (1..=20).collect();
    let arms = arms(&seeds);
    let numbers: Vec<Judged> = arms.iter().flat_map(Arm::numbers).collect();
    judge(&numbers);
    judge_forecasts(&arms);
    let [worst, at_rest] = compare_control(&arms);
    assert!(worst <= 1.1, "{worst:.3}");
    assert!(at_rest <= 1.1, "{at_rest:.3}");
}
