//! Finding the servos: either firmware, any speed, and what is refused.

use armbridge_analysis::plan_runner::{PlanError, PlanRunner, Script};
use armbridge_board::bridge::Channels;
use armbridge_client::Host;
use armbridge_client::session::{BoardMessage, CommandLink};
use armbridge_client::status::Obstacle;
use armbridge_link::message::{Command, Missing, Setup, ToHost};
use armbridge_servo::Firmware;
use armbridge_servo::master::Readiness;
use armbridge_servo::master::timing::tick_us;
use armbridge_servo::port::{AX12A_BAUD_MAX, BAUD_RATES, bytes_us};
use armbridge_sim::Bench;
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::{Cosim, CosimError};
use armbridge_tests::transparent_port::bench;
use armbridge_tests::{calibrations, plant};

/// Bytes of a tick on the wire: requests and answers of two servos.
fn tick_bytes(firmware: Firmware) -> u32 {
    match firmware {
        Firmware::Morpheus => 16 + 6 + 7 + 7,
        Firmware::Stock => 14 + 8 + 8 + 8 + 8,
        Firmware::XSeries => 20 + 16 + 24,
    }
}

#[test]
fn servos_are_found_at_every_rate_and_driven_as_fast_as_it_allows() {
    for firmware in Firmware::ALL {
        let nominal = [1_000_000, 500_000, 115_200, 57_600];
        let rates = nominal.into_iter().zip(BAUD_RATES);
        let fast = BAUD_RATES.into_iter().filter(|rate| *rate > AX12A_BAUD_MAX);
        for (nominal, rate) in rates.chain(fast.map(|rate| (rate, rate))) {
            let has_rate = match firmware {
                Firmware::Morpheus | Firmware::Stock => rate <= AX12A_BAUD_MAX,
                Firmware::XSeries => rate != 500_000,
            };
            if !has_rate {
                continue;
            }
            let least_us = tick_us(firmware, rate, Readiness::Prepared);
            let grid_us = if firmware == Firmware::XSeries {
                50
            } else {
                100
            };
            let period_us = least_us.next_multiple_of(grid_us);
            let setup = Setup {
                period_us,
                joints: calibrations(firmware),
                ..Setup::best()
            };
            let mut channels = Channels::new();
            let board = VirtualBoard::new(channels.split()).unwrap();
            let bench = bench(&plant([0.1, -0.1], true), [firmware; 2], nominal);
            let runner = PlanRunner::new(Script::upright(setup, 2_000_000));
            let mut cosim = Cosim::new(board, bench, runner);
            cosim
                .run()
                .unwrap_or_else(|error| panic!("{firmware} {nominal}: {error:?}"));
            let servos = cosim.host.status().servos.unwrap();
            assert_eq!((servos.firmware, servos.baud), (firmware, rate));

            let records = cosim.host.into_parts().0;
            let bus_us = records.iter().map(|record| record.timing.bus_us);
            let (mean_us, most_us) = (
                bus_us.clone().sum::<u32>() as f64 / records.len() as f64,
                bus_us.max().unwrap(),
            );
            let wire_us = bytes_us(tick_bytes(firmware), rate);
            let missing = records.iter().flat_map(|record| record.input.samples);
            let missing = missing.filter(|sample| sample.counts().is_none()).count();
            let last = records.last().unwrap();
            println!(
                "{firmware} {nominal}: bytes {wire_us} us, tick {mean_us:.1} us (max {most_us}), \
                 period {period_us} us, missing {missing}, missed {}",
                last.timing.missed
            );
            // On a bus without idle slots a tick waits for the checks of motors that are off.
            let missed = last.timing.missed - records[0].timing.missed;
            assert_eq!((missed, missing), (0, 0), "{firmware} {nominal}");
            assert!(
                u64::from(most_us) <= u64::from(period_us),
                "{firmware} {nominal}"
            );
            // At 57600 baud it sways by some counts.
            let upright = last.output.angle_rad.iter().all(|q| q.abs() < 0.15);
            assert!(upright, "{firmware} {nominal}: {:?}", last.output.angle_rad);
        }
    }
}

fn operate(bench: Bench, setup: Setup) -> Result<PlanRunner, PlanError> {
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).unwrap();
    let mut cosim = Cosim::new(
        board,
        bench,
        PlanRunner::new(Script::upright(setup, 500_000)),
    );
    match cosim.run() {
        Ok(()) => Ok(cosim.host),
        Err(CosimError::Host(error)) => Err(error),
        Err(CosimError::Board(never)) => match never {},
    }
}

#[test]
fn what_cannot_work_is_refused_with_its_reason() {
    let arm = plant([0.1, -0.1], true);
    for [first, second] in [
        [Firmware::Stock, Firmware::Morpheus],
        [Firmware::XSeries, Firmware::Stock],
        [Firmware::Stock, Firmware::XSeries],
        [Firmware::XSeries, Firmware::Morpheus],
        [Firmware::Morpheus, Firmware::XSeries],
    ] {
        let mixed = operate(bench(&arm, [first, second], 1_000_000), Setup::default());
        assert_eq!(
            mixed.unwrap_err(),
            PlanError::Servos(Some(Obstacle::Mixed(first, second)))
        );
    }
    let mut lonely = bench(&arm, [Firmware::Stock; 2], 500_000);
    lonely.disconnect(1);
    let absent = operate(lonely, Setup::default()).unwrap_err();
    let obstacle = Obstacle::Absent {
        joint: 1,
        missing: Missing::Silence,
    };
    assert_eq!(absent, PlanError::Servos(Some(obstacle)));
    // As fast as its bytes, but faster than Morpheus servos have been tried at.
    let fast = Setup {
        period_us: 590,
        ..Setup::default()
    };
    let why = operate(bench(&arm, [Firmware::Morpheus; 2], 1_000_000), fast);
    let why = why.unwrap_err().to_string();
    assert!(why.contains("600"), "{why}");
    // 1 kHz at 57600 baud: the answer has a period that works.
    let slow = operate(
        bench(&arm, [Firmware::Morpheus; 2], 57_600),
        Setup::default(),
    );
    let why = slow.unwrap_err().to_string();
    let least = tick_us(Firmware::Morpheus, BAUD_RATES[3], Readiness::Prepared).to_string();
    assert!(why.contains(&least), "{why}");
}

/// A host that gives its commands one by one, whenever the servos are reported
/// found.
struct Commander {
    client: CommandLink,
    commands: Vec<Command>,
    ends_us: u64,
    now_us: u64,
}

impl Host for Commander {
    type Error = std::convert::Infallible;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Self::Error> {
        self.now_us = now_us;
        Ok(self.client.transmit(now_us))
    }

    fn receive(&mut self, _now_us: u64, mut bytes: &[u8]) -> Result<(), Self::Error> {
        let mut is_found = false;
        while let Some(message) = self.client.receive(&mut bytes) {
            is_found |= matches!(message, BoardMessage::Other(ToHost::Found { .. }));
        }
        if is_found && !self.commands.is_empty() {
            self.client.command(self.commands.remove(0));
        }
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        self.client.wake_at_us().min(self.ends_us)
    }

    fn is_done(&self) -> bool {
        self.now_us >= self.ends_us
    }
}

/// Return delay, angle limits and return level, as the servos hold them.
fn settings(bench: &Bench) -> Vec<(u8, [u32; 2], u8)> {
    let servos = bench.servos().iter();
    servos
        .map(|servo| {
            let servo = servo.stock().expect("a stock servo");
            let word = |name| servo.register(name).expect(name);
            (
                word("return_delay_time") as u8,
                [word("cw_angle_limit"), word("ccw_angle_limit")],
                word("status_return_level") as u8,
            )
        })
        .collect()
}

#[test]
fn stock_servos_are_prepared_and_given_back_as_they_were() {
    let as_found = vec![(250, [0, 1023], 2); 2];
    let prepared = vec![(10, [0, 0], 2); 2];
    let cases = [
        (vec![], as_found.clone()),
        (vec![Command::Prepare], prepared),
        (vec![Command::Prepare, Command::Release], as_found.clone()),
    ];
    for (commands, expected) in cases {
        let mut channels = Channels::new();
        let board = VirtualBoard::new(channels.split()).unwrap();
        let bench = bench(&plant([0.0; 2], true), [Firmware::Stock; 2], 1_000_000);
        assert_eq!(settings(&bench), as_found);
        let host = Commander {
            client: CommandLink::default(),
            commands: commands.clone(),
            ends_us: 900_000,
            now_us: 0,
        };
        let mut cosim = Cosim::new(board, bench, host);
        cosim.run().unwrap();
        assert!(cosim.host.commands.is_empty() && cosim.host.client.is_settled());
        assert_eq!(settings(&cosim.bench), expected, "{commands:?}");
    }
}
