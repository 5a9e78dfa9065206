//! The board's end of the link, with the bridge beside it and servos that
//! answer: whatever a host sends, the board ticks on and stays safe.

use armbridge_board::bridge::Channels;
use armbridge_board::bridge::limits::{PERIOD_MAX_US, PERIOD_MIN_US};
use armbridge_control::estimate::Config;
use armbridge_link::message::{Command, Fault, Setup, ToBoard};
use armbridge_link::schema;

use super::session::{Seen, Test};

const STREAMS: usize = 700_000;
/// Records, ticks with torque on, set-ups installed, commands refused, packets passed
/// and packets kept: below these the test has not seen enough to prove anything.
const LEAST: [usize; 6] = [100_000, 10_000, 100, 10_000, 300, 300];
/// Instants after each stream at which the board runs: about a tick.
const RUNS_PER_STREAM: usize = 25;

#[test]
fn a_host_cannot_make_the_board_unsafe() {
    let mut channels = Channels::new();
    let mut test = Test::new(&mut channels, 0x5EED_0005);
    for stream in 0..STREAMS {
        if stream % 500 == 0 {
            test.servos.fail_once_in = test.random.one_of(&[1000, 100, 10, 1]);
        }
        let stream = test.stream();
        test.receive(&stream);
        test.client_speaks();
        for _ in 0..RUNS_PER_STREAM {
            test.run();
        }
    }
    let Seen {
        records,
        torque_on,
        installed,
        refused,
        faults,
        port,
    } = test.seen;
    let (passed, kept) = (port.passed as usize, port.refused as usize);
    let figures = [records, torque_on, installed, refused, passed, kept];
    let is_enough = figures.iter().zip(LEAST).all(|(seen, least)| *seen > least);
    assert!(is_enough, "{figures:?}, expected more than {LEAST:?}");
    for fault in [Fault::AngleLimit, Fault::ServoSilent] {
        assert!(faults.contains(&fault), "never {fault:?}: {faults:?}");
    }
}

/// Servos that stay away leave the estimator alone with its model, whatever
/// the set-up: numbers stay numbers.
#[test]
fn a_long_fault_without_servos_stays_finite() {
    let estimators = [
        Setup::default().estimator,
        Config::FiniteDifference { filter_s: 0.02 },
    ];
    let periods_us = [PERIOD_MIN_US, 10_000, PERIOD_MAX_US];
    for (estimator, period_us) in estimators
        .into_iter()
        .flat_map(|estimator| periods_us.map(|us| (estimator, us)))
    {
        let mut channels = Channels::new();
        let mut test = Test::new(&mut channels, 0x5EED_0006);
        test.servos.fail_once_in = u64::MAX;
        let setup = Setup {
            period_us,
            estimator,
            ..Setup::default()
        };
        let orders = [
            ToBoard::Hello(schema::HELLO),
            ToBoard::Command(Command::Configure(setup)),
        ];
        let stream = orders.map(|order| test.frame(&order)).concat();
        test.receive(&stream);
        while test.seen.records < 100 {
            test.run();
        }
        test.servos.fail_once_in = 1;
        while test.seen.records < 50_000 {
            test.run();
        }
        assert_eq!(test.seen.faults, [Fault::ServoSilent]);
    }
}
