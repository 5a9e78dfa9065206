//! Temperatures that the board reads from X servos while it drives them: how often, how old the
//! last one is, and how late a tick is for the board's readings.

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_board::bridge::Channels;
use armbridge_client::event::{Event, EventKind};
use armbridge_link::message::{Command, Record, Setup, ToHost};
use armbridge_servo::{Firmware, JOINTS};
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::Cosim;
use armbridge_tests::tapped_bench::TappedHost;
use armbridge_tests::transparent_port::bench;
use armbridge_tests::{assert_undisturbed, calibrations, plant, sinusoid};

/// Time for which the arm is driven, in µs.
const DRIVEN_US: u64 = 20_000_000;

/// Readings of a run, and its ticks.
struct Readings {
    /// Readings a second, of both servos.
    per_s: f64,
    /// Longest time without one, of either servo, in s.
    oldest_s: f64,
    /// Latest start of a tick, in µs, and the share of ticks that begin late.
    late_us: u32,
    late_share: f64,
}

fn driven(baud: u32, period_us: u32) -> Readings {
    let script = Script {
        setup: Setup {
            period_us,
            joints: calibrations(Firmware::XSeries),
            ..Setup::best()
        },
        limits: Script::limits(),
        commands: vec![(0, Command::Follow(sinusoid(30.0)))],
        duration_us: DRIVEN_US,
    };
    let bench = bench(&plant([0.1, -0.1], true), [Firmware::XSeries; 2], baud);
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).unwrap();
    let mut cosim = Cosim::new(board, bench, TappedHost::new(PlanRunner::new(script)));
    cosim.run().expect("a run");
    let events = cosim.host.events;
    let is_driven = |record: &Record| record.mode.drive().is_some();
    let records: Vec<Record> = events.iter().filter_map(Event::record).collect();
    let records: Vec<Record> = records.into_iter().filter(is_driven).collect();
    assert_undisturbed(&records);
    let [first_us, last_us] =
        [records.first(), records.last()].map(|record| record.expect("a record").input.start_us);
    let mut count = 0;
    let mut oldest_us = 0;
    let mut read_us = [first_us; JOINTS];
    for event in &events {
        let at_us = event.host_ns / 1_000;
        if let EventKind::Received(_, ToHost::Temperature { joint, .. }) = event.kind
            && (first_us..last_us).contains(&at_us)
        {
            let read_us = &mut read_us[usize::from(joint)];
            oldest_us = oldest_us.max(at_us - *read_us);
            *read_us = at_us;
            count += 1;
        }
    }
    for read_us in read_us {
        oldest_us = oldest_us.max(last_us - read_us);
    }
    let late_us = records.iter().map(|record| record.timing.start_error_us);
    let late = late_us.clone().filter(|late_us| *late_us > 0).count();
    Readings {
        per_s: f64::from(count) * 1e6 / (last_us - first_us) as f64,
        oldest_s: oldest_us as f64 * 1e-6,
        late_us: late_us.max().unwrap_or(0),
        late_share: late as f64 / records.len() as f64,
    }
}

/// Baud rate, period in µs, whether a reading fits a tick, and how late a tick may be for one that
/// does not, of a torque enable or a temperature.
const LINES: [(u32, u32, bool, u32); 10] = [
    (1_000_000, 900, false, 225),
    (1_000_000, 1_000, false, 125),
    (1_000_000, 2_000, true, 0),
    (2_000_000, 600, false, 100),
    (2_000_000, 1_000, true, 0),
    (3_000_000, 550, false, 0),
    (3_000_000, 1_000, true, 0),
    (4_000_000, 450, false, 30),
    (4_000_000, 500, false, 0),
    (4_000_000, 1_000, true, 0),
];

#[test]
fn temperatures_are_read_twice_a_second_of_each_servo_or_every_three_where_a_tick_leaves_no_time() {
    for (baud, period_us, fits, late_most_us) in LINES {
        let Readings {
            per_s,
            oldest_s,
            late_us,
            late_share,
        } = driven(baud, period_us);
        let line = format!(
            "{baud} baud, {period_us} us: {per_s:.2} a second, oldest {oldest_s:.2} s, \
             {:.2} % of ticks late, at most {late_us} us",
            1e2 * late_share
        );
        println!("{line}");
        assert_eq!(fits, per_s > 3.9 && oldest_s < 0.55, "{line}");
        // A tick waits for one that has been due for a second.
        assert!(per_s > 0.7 && oldest_s < 2.7, "{line}");
        assert!(late_us <= late_most_us, "{line}");
        // One in 45 ms and one in 1.25 s, and at the shortest periods the two that each leaves too
        // little time.
        let late_per_s = 3.0 * (1.0 / 44e-3 + if fits { 0.0 } else { 1.0 / 1.25 });
        assert!(
            late_share <= late_per_s * f64::from(period_us) * 1e-6,
            "{line}"
        );
    }
}
