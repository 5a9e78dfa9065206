//! A board with its bridge and servos that answer, and a host and a client that send
//! anything: every record is checked, nothing unsafe may be in it.

use armbridge_board::bridge::transparent_port::{ClientLine, PortEnd};
use armbridge_board::bridge::{Bridge, Channels, LinkPort, Progress};
use armbridge_link::frame::{Decoder, Encoder, MAX, Received};
use armbridge_link::message::{
    BoardReport, Command, Fault, Limits, Mode, PortCounters, Record, Settings, ToBoard, ToHost,
};
use armbridge_link::schema;
use armbridge_servo::serial_bus::SerialBus;
use armbridge_servo::{Firmware, Pwm};
use armbridge_tests::random::Random;
use armbridge_tests::streams::checks::frames::frame;

use super::client;
use super::commands::{is_acceptable, message};
use super::line::Port;
use super::servos::Servos;

/// A board's queues hold no more frames than this.
const MOST_FRAMES: usize = 100;
/// Times that the bridge may ask to be polled again at one instant.
const MOST_POLLS: usize = 16;

/// Observations of the board.
#[derive(Default)]
pub(crate) struct Seen {
    pub(crate) records: usize,
    pub(crate) torque_on: usize,
    pub(crate) installed: usize,
    pub(crate) refused: usize,
    pub(crate) faults: Vec<Fault>,
    pub(crate) port: PortCounters,
}

/// A board whose host sends anything.
pub(crate) struct Test<'a> {
    port: Port,
    bridge: Bridge<'a, SerialBus<Port, Port>>,
    link: LinkPort<'a>,
    client: PortEnd<'a>,
    pub(crate) servos: Servos,
    pub(crate) random: Random,
    encoder: Encoder,
    /// Decodes what the board receives.
    tapped_run: Decoder,
    /// Received since the last stream, with its number.
    received: Vec<Received<ToBoard>>,
    records: Decoder,
    pub(crate) seen: Seen,
    /// As last reported by the board.
    session: u32,
}

impl<'a> Test<'a> {
    pub(crate) fn new(channels: &'a mut Channels, seed: u64) -> Self {
        let (end, link, client) = channels.split();
        let port = Port::new(false, 1000);
        // Motors that have been checked: these servos move as they like.
        let settings = Settings {
            limits: Limits {
                check_rad_s2: 0,
                ..Limits::default()
            },
            ..Settings::default()
        };
        let report = BoardReport {
            session: 7,
            ..BoardReport::default()
        };
        Self {
            bridge: Bridge::new(
                SerialBus::new(port.clone(), port.clone()),
                end,
                0,
                &settings,
            )
            .unwrap(),
            link: LinkPort::new(link, report, settings),
            client,
            port,
            servos: Servos {
                counts: [512; 2],
                fail_once_in: 100,
            },
            random: Random::new(seed),
            encoder: Encoder::default(),
            tapped_run: Decoder::default(),
            received: Vec::new(),
            records: Decoder::default(),
            seen: Seen::default(),
            session: 0,
        }
    }

    pub(crate) fn frame(&mut self, message: &ToBoard) -> Vec<u8> {
        self.encoder.encode(message).1.to_vec()
    }

    pub(crate) fn stream(&mut self) -> Vec<u8> {
        match self.random.below(10) {
            0 => self.random.bytes(MAX as u64, &[]),
            1 => self.random.bytes(40, &[0, 0, 1, 2, 3, 0xFF, b'B']),
            2 => {
                let sequence = self.random.below(0x1_0000) as u16;
                let body = self.random.bytes(40, &[0, 1, 2, 3, 4, 0x7F, 0x80, 0xFF]);
                frame(1, b'B', sequence, &body)
            }
            3 => {
                let message = message(&mut self.random, self.session);
                let mut frame = self.frame(&message);
                self.random.damage(&mut frame);
                frame
            }
            // Rarely: a session needs 48 ticks before it arms.
            4 if self.random.once_in(15) => self.frame(&ToBoard::Hello(schema::HELLO)),
            _ => {
                let count = 1 + self.random.below(3);
                (0..count)
                    .flat_map(|_| {
                        let message = message(&mut self.random, self.session);
                        self.frame(&message)
                    })
                    .collect()
            }
        }
    }

    pub(crate) fn receive(&mut self, stream: &[u8]) {
        let received = stream
            .iter()
            .filter_map(|byte| self.tapped_run.push(*byte)?.ok());
        self.received = received.collect();
        self.link.receive(stream);
    }

    /// The client at the transparent port sends something, or nothing.
    pub(crate) fn client_speaks(&mut self) {
        // With torque off it would be given the bus, and most commands refused.
        let random = &mut self.random;
        if !self.bridge.mode().is_armed() && !random.once_in(2_000) {
            return;
        }
        let Some(mut bytes) = client::says(random) else {
            return;
        };
        if random.once_in(5) {
            random.damage(&mut bytes);
        }
        let is_open = !random.once_in(10);
        self.client.set_line(ClientLine { is_open, baud: 0 });
        self.client.receive(&bytes);
        while self.client.transmit().is_some() {}
    }

    /// Runs the board until it has nothing left to do, then goes on to when it
    /// has.
    pub(crate) fn run(&mut self) {
        let now_us = self.port.line().now_us;
        let before = self.bridge.mode();
        let sent_before = self.port.line().sent.len();
        let mut polls = 0;
        while let Ok(progress) = self.bridge.poll(now_us) {
            if progress == Progress::Sampled {
                self.bridge.decide();
                self.bridge.publish(0);
            }
            polls += 1;
            assert!(polls < MOST_POLLS, "the bridge does not come to rest");
        }
        let mode = self.bridge.mode();
        let drives = |mode: Mode| mode.drive().is_some();
        if mode.is_armed() && !before.is_armed() {
            // Only with the word of the session, which a hello changes.
            let is_arm = |command: &Command| matches!(command, Command::Arm { session } if *session == self.session);
            assert!(self.was_sent(is_arm), "{mode:?}: {:?}", self.received);
        }
        if drives(mode) && !drives(before) {
            assert!(
                self.was_sent(Command::is_drive),
                "{mode:?}: {:?}",
                self.received
            );
        }
        self.check_wire(sent_before, before.is_armed() || mode.is_armed());
        if before.is_armed() && mode.is_armed() {
            let line = self.port.line();
            let mut packets = line.sent[sent_before..].windows(4);
            let is_from_client = |head: &[u8]| head[0] == 0xAA && head[3] == client::ADDRESS;
            assert!(!packets.any(is_from_client), "{:02x?}", line.sent);
        }
        self.fetch();

        let wants_bytes = self.bridge.bytes_wanted().is_some();
        let random = &mut self.random;
        let servos = &mut self.servos;
        self.port.edit(|line| {
            if wants_bytes && !line.sent.is_empty() && line.baud == 1_000_000 {
                let script = servos.answer(&line.sent, random);
                line.expect(script);
                line.sent.clear();
            }
            let wake_us = self.bridge.wake_at_us();
            let next_us = line.next_us().filter(|_| wants_bytes);
            line.now_us = line
                .now_us
                .max(next_us.map_or(wake_us, |us| us.min(wake_us)));
        });
    }

    /// Whether such a command came that may be accepted.
    fn was_sent(&self, is_wanted: impl Fn(&Command) -> bool) -> bool {
        self.received.iter().any(|received| match received.message {
            ToBoard::Command(command) => is_wanted(&command) && is_acceptable(&command),
            ToBoard::Hello(_) | ToBoard::Heartbeat | ToBoard::Stop | ToBoard::Goodbye => false,
        })
    }

    /// PWM on the wire, new there, are what servos obey, and off unless torque was on.
    fn check_wire(&self, from: usize, torque_may_be_on: bool) {
        let line = self.port.line();
        for drive in line.sent[from..].windows(16) {
            let [
                0xAA,
                13,
                0xFF,
                0xFE,
                0x83,
                0x0F,
                3,
                1,
                0,
                a,
                b,
                2,
                0,
                c,
                d,
                _,
            ] = *drive
            else {
                continue;
            };
            for pwm in [u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])] {
                assert!(pwm <= Pwm::MAX.counts(), "PWM {pwm}");
                assert!(pwm == Pwm::OFF.counts() || torque_may_be_on, "PWM {pwm}");
            }
        }
    }

    /// Fetches the board's messages, and checks them.
    fn fetch(&mut self) {
        if let Some((sequence, _)) = self.link.take_save() {
            self.link.saved(sequence, true);
        }
        for frames in 0.. {
            assert!(frames < MOST_FRAMES, "the board does not stop talking");
            let Some(frame) = self.link.transmit() else {
                return;
            };
            let received = frame
                .iter()
                .find_map(|byte| self.records.push::<ToHost>(*byte))
                .expect("a whole frame")
                .expect("an intact frame");
            match received.message {
                ToHost::Hello(hello) => assert_eq!(hello, schema::HELLO),
                ToHost::Absent { joint, .. } | ToHost::Unprepared { joint } => assert!(joint < 2),
                ToHost::Found {
                    firmware,
                    baud,
                    is_ready,
                } => {
                    let found = (firmware, baud, is_ready);
                    assert_eq!(found, (Firmware::Morpheus, 1_000_000, true));
                }
                ToHost::Mixed(_)
                | ToHost::Passthrough
                | ToHost::Tripped(_)
                | ToHost::Off(_)
                | ToHost::Concluded(_)
                | ToHost::Departs { .. }
                | ToHost::Began(_)
                | ToHost::Settings(_)
                | ToHost::Temperature { .. } => {}
                ToHost::Board(report) => self.session = report.session,
                ToHost::Port(counters) => self.seen.port = counters,
                ToHost::Ack {
                    sequence, result, ..
                } => self.check_ack(sequence, result.is_ok()),
                ToHost::Record(record) => self.check_record(&record),
            }
        }
    }

    fn check_ack(&mut self, sequence: u16, is_accepted: bool) {
        if !is_accepted {
            self.seen.refused += 1;
            return;
        }
        let mut received = self
            .received
            .iter()
            .filter(|received| received.sequence == sequence);
        let is_possible = received.any(|received| match received.message {
            ToBoard::Command(command) => {
                let is_setup = matches!(command, Command::Configure(_));
                self.seen.installed += usize::from(is_setup);
                is_acceptable(&command)
            }
            ToBoard::Hello(_) | ToBoard::Heartbeat | ToBoard::Stop | ToBoard::Goodbye => false,
        });
        assert!(is_possible, "{sequence} accepted of {:?}", self.received);
    }

    fn check_record(&mut self, record: &Record) {
        let Seen {
            records,
            torque_on,
            faults,
            ..
        } = &mut self.seen;
        *records += 1;
        let reals = [
            record.output.reference_rad,
            record.output.angle_rad,
            record.output.speed_rad_s,
            record.output.torque_nm,
        ];
        let is_finite = reals.as_flattened().iter().all(|real| real.is_finite());
        assert!(is_finite, "{record:?}");
        for pwm in record.input.pwm_in_force.iter().chain(&record.output.pwm) {
            assert!(*pwm <= Pwm::MAX.counts(), "{record:?}");
        }
        if record.mode.is_armed() {
            *torque_on += 1;
        } else {
            assert_eq!(record.output.pwm, [Pwm::OFF.counts(); 2], "{record:?}");
        }
        if let Mode::Fault(fault) = record.mode
            && !faults.contains(&fault)
        {
            faults.push(fault);
        }
    }
}
