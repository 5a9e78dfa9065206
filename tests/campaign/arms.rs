//! Twenty arms drawn at random, from the default plan to control.

use armbridge_tests::random_arms::{
    Arm, ParameterError, arms, check_forecasts, check_parameters, compare_control,
};

#[test]
fn twenty_arms_are_found_and_controlled_as_if_they_were_known() {
    let seeds: Vec<u64> = (1..=20).collect();
    let arms = arms(&seeds);
    let errors: Vec<ParameterError> = arms.iter().flat_map(Arm::parameter_errors).collect();
    check_parameters(&errors);
    check_forecasts(&arms);
    let [worst, at_rest] = compare_control(&arms);
    assert!(worst <= 1.1, "{worst:.3}");
    assert!(at_rest <= 1.1, "{at_rest:.3}");
}
