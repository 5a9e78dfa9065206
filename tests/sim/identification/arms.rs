//! An arm drawn at random, from the default plan to control; the campaign has twenty.

use armbridge_tests::random_arms::kind::Kind;
use armbridge_tests::random_arms::{
    Arm, ParameterError, arms, check_forecasts, check_parameters, compare_control,
};

#[test]
fn an_arm_is_found() {
    let arms = arms(Kind::Ax12a, &[2]);
    let errors: Vec<ParameterError> = arms.iter().flat_map(Arm::parameter_errors).collect();
    check_parameters(&errors);
    check_forecasts(&arms);
    let [worst, _] = compare_control(&arms);
    assert!(worst <= 1.1, "{worst:.3}");
}
