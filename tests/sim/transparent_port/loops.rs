//! A control loop with a client that never stops asking.

use armbridge_servo::Firmware;
use armbridge_tests::transparent_port::loops::{hammered, on_bench};

#[test]
fn a_loop_does_not_notice_a_client_and_the_client_is_answered() {
    for firmware in Firmware::ALL {
        hammered(firmware, on_bench);
    }
}
