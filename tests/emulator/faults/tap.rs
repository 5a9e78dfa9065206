//! Bytes to and from the emulated board in lockstep, with their times.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use armbridge_client::Host;
use armbridge_link::frame::Decoder;
use armbridge_link::message::{Record, ToHost, Trip};
use armbridge_servo::port::bytes_us;
use armbridge_servo::{JOINTS, Pwm};
use armbridge_sim::Bench;
use armbridge_sim::board::{Board, Input, Output, Wake};
use armbridge_sim::cosim::Cosim;
use armbridge_sim::emulator::{EmulatedBoard, Image, Qemu, QemuError, QemuOptions, Time, log};
use armbridge_sim::plant::Plant;
use armbridge_tests::plant;

use super::slow_motion::supply_changes;
use super::stop;

/// The bus's speed, in bits per second.
const BAUD: u32 = 1_000_000;

/// A board, with a tap on its wires that can cut one.
#[derive(Debug)]
pub(crate) struct Tap {
    board: EmulatedBoard,
    /// The servo bus is cut between board and servos.
    pub(crate) is_cut: bool,
    /// The emergency stop's switch is pressed.
    pub(crate) is_stop_pressed: bool,
    log: Arc<Mutex<Vec<String>>>,
    /// Bytes of the board on the bus, and when each had left, in µs.
    sent: Vec<(u8, u64)>,
    /// When the host last sent bytes.
    pub(crate) host_spoke_us: u64,
    decoder: Decoder,
    /// The board's records.
    pub(crate) records: Vec<Record>,
    pub(crate) trips: Vec<Trip>,
}

/// A tapped board, an arm that leans, and `host`.
pub(crate) fn run<H: Host>(host: H) -> Cosim<Tap, H> {
    let options = QemuOptions {
        image: Image::current().unwrap(),
        time: Time::Lockstep,
        icount: false,
        provoke: None,
    };
    let qemu = Qemu::start(&options).unwrap();
    let log = Arc::<Mutex<Vec<String>>>::default();
    let (stream, lines) = (qemu.log.try_clone().unwrap(), Arc::clone(&log));
    log::spawn(&options.image, stream, move |line| {
        lines.lock().unwrap().push(line);
    })
    .unwrap();
    let tap = Tap {
        board: EmulatedBoard::new(qemu).unwrap(),
        is_cut: false,
        is_stop_pressed: false,
        log,
        sent: Vec::new(),
        host_spoke_us: 0,
        decoder: Decoder::default(),
        records: Vec::new(),
        trips: Vec::new(),
    };
    let bench = Bench::new(Plant::new(plant([0.2, -0.2], true), 1));
    Cosim::new(tap, bench, host)
}

/// Runs until `is_it`, for `most_us` at the most.
pub(crate) fn until<H: Host<Error: std::fmt::Debug>>(
    run: &mut Cosim<Tap, H>,
    most_us: u64,
    mut is_it: impl FnMut(&Cosim<Tap, H>) -> bool,
) {
    let end_us = run.now_us() + most_us;
    while !is_it(run) {
        assert!(
            run.now_us() < end_us,
            "not within {most_us} µs: {:?}",
            run.board.records.last()
        );
        run.step().unwrap();
    }
}

/// PWM of the motors, in counts.
pub(crate) fn pwm<H>(run: &Cosim<Tap, H>) -> [u16; JOINTS]
where
    H: Host,
{
    [0, 1].map(|joint| run.bench.applied_pwm(joint))
}

/// Off, both.
pub(crate) const OFF: [u16; JOINTS] = [Pwm::OFF.counts(); JOINTS];

impl Tap {
    /// Whether the arm is driven, and has been for a while.
    pub(crate) fn is_driven(&self) -> bool {
        let driven = self.records.iter().rev().take(100);
        let driven = driven
            .filter(|record| record.mode.drive().is_some() && record.input.pwm_in_force != OFF);
        driven.count() == 100
    }

    /// When the servos' supply was switched, as of [`supply_changes`].
    pub(crate) fn supply(&self) -> Vec<(f64, bool)> {
        // The log comes by a socket of its own, and takes some ms.
        std::thread::sleep(Duration::from_millis(200));
        supply_changes(&self.log.lock().unwrap())
    }

    /// From when to when the stop sequence was on the bus, first after `since_us`.
    pub(crate) fn stopped_us(&self, since_us: u64) -> Option<(u64, u64)> {
        let first = self.sent.iter().position(|(_, at_us)| *at_us > since_us)?;
        let sent = &self.sent[first..];
        let bytes: Vec<u8> = sent.iter().map(|(byte, _)| *byte).collect();
        let begin = *stop::find(&bytes).first()?;
        let end = begin + stop::sequence().len() - 1;
        Some((sent[begin].1, sent[end].1))
    }
}

impl Board for Tap {
    type Error = QemuError;

    fn run(
        &mut self,
        now_us: u64,
        mut input: Input<'_>,
        output: &mut Output,
    ) -> Result<Wake, QemuError> {
        if self.is_cut {
            input.bus = &[];
        }
        input.is_stop_pressed |= self.is_stop_pressed;
        if !input.link.is_empty() {
            self.host_spoke_us = now_us;
        }
        let wake = self.board.run(now_us, input, output)?;
        for (index, byte) in output.bus.iter().enumerate() {
            self.sent
                .push((*byte, now_us + bytes_us(index as u32 + 1, BAUD)));
        }
        if self.is_cut {
            output.bus.clear();
        }
        for byte in &output.link {
            match self.decoder.push::<ToHost>(*byte) {
                Some(Ok(received)) => match received.message {
                    ToHost::Record(record) => self.records.push(record),
                    ToHost::Tripped(trip) => self.trips.push(trip),
                    _ => {}
                },
                Some(Err(error)) => panic!("{error:?}"),
                None => {}
            }
        }
        Ok(wake)
    }
}
