//! Arms drawn at random, from the default plan to control.

use armbridge_tests::random_arms::kind::Kind;
use armbridge_tests::random_arms::{
    Arm, ParameterError, arms, check_forecasts, check_parameters, compare_control,
};

fn are_found_and_controlled_as_if_they_were_known(kind: Kind, count: u64) {
    let seeds: Vec<u64> = (1..=count).collect();
    let arms = arms(kind, &seeds);
    let errors: Vec<ParameterError> = arms.iter().flat_map(Arm::parameter_errors).collect();
    check_parameters(&errors);
    check_forecasts(&arms);
    let [worst, at_rest] = compare_control(&arms);
    assert!(worst <= 1.1, "{worst:.3}");
    assert!(at_rest <= 1.1, "{at_rest:.3}");
}

#[test]
fn twenty_arms_are_found_and_controlled_as_if_they_were_known() {
    are_found_and_controlled_as_if_they_were_known(Kind::Ax12a, 20);
}

#[test]
fn ten_arms_with_x_servos_are_found_and_controlled_as_if_they_were_known() {
    are_found_and_controlled_as_if_they_were_known(Kind::Xl430, 10);
}
