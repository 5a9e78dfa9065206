//! A stock servo that releases its shaft reports an alarm, and the board acts on it.

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_board::bridge::Channels;
use armbridge_link::message::{Drive, Fault, Mode, Setup};
use armbridge_servo::{Alarms, Firmware};
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::Cosim;
use armbridge_tests::plant;
use armbridge_tests::transparent_port::bench;

#[test]
fn a_servo_that_is_too_hot_ends_the_run_with_its_name_in_the_log() {
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).unwrap();
    let bench = bench(&plant([0.1, -0.1], true), [Firmware::Stock; 2], 1_000_000);
    let script = Script::upright(Setup::best(), 2_000_000);
    let mut cosim = Cosim::new(board, bench, PlanRunner::new(script));
    while cosim.now_us() < 1_000_000 {
        cosim.step().unwrap();
    }
    assert_eq!(cosim.board.mode(), Mode::Running(Drive::Regulate));
    let hot = cosim.bench.servo_mut(1).stock_mut().expect("a stock servo");
    hot.set_temperature(90.0);
    while cosim.board.mode() == Mode::Running(Drive::Regulate) {
        cosim.step().unwrap();
    }
    let tripped_us = cosim.now_us();
    while [0, 1].map(|servo| cosim.bench.applied_pwm(servo)) != [1000; 2] {
        cosim.step().unwrap();
    }
    // The stop sequence goes on meanwhile.
    let off_ns = [0, 1].map(|servo| {
        cosim
            .bench
            .last_on_ns(servo)
            .1
            .expect("a motor that is off")
    });
    let off_us = off_ns[0].max(off_ns[1]).div_ceil(1_000);
    assert!(
        off_us - tripped_us < 2_000,
        "off after {} us",
        off_us - tripped_us
    );
    cosim.run().unwrap();

    let records = cosim.host.into_parts().0;
    let first = records
        .iter()
        .position(|record| record.input.alarms != [0; 2]);
    let first = first.expect("an alarm");
    let alarms = records[first].input.alarms.map(Alarms::from_bits);
    assert_eq!(alarms, [Alarms::NONE, Alarms::OVERHEATING]);
    // In the next tick, for both motors: one sample may be damage.
    let after = &records[first + 1..];
    assert_eq!(after[0].mode, Mode::Fault(Fault::ServoAlarm));
    assert!(after.iter().all(|record| record.output.pwm == [1000; 2]));
}
