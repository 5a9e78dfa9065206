//! Servo bus: one half-duplex data line, a master and its servos.
//!
//! All events have a virtual time, in nanoseconds from power-up:
//! a byte starts or ends, a servo's converter samples, a step of its
//! program is done. [`Wire::advance`] executes all events up to a time in
//! order. The result does not depend on the division into steps, so the same servos
//! serve a simulation that jumps from event to event and a program that
//! follows the wall clock. There is no randomness unless [`Wire::disturb`] or
//! [`Wire::inject`] enables it, and that is seeded: equal inputs give equal
//! outputs.
//!
//! Bytes are placed bit by bit. When two senders overlap, low wins, and every
//! receiver decodes the result. A servo whose bus driver is on receives
//! nothing; a disconnected one neither receives nor is received.
//!
//! The master does not receive its own bytes: an adapter that echoes adds its echo
//! itself.

mod device;
mod disturbance;
mod events;
mod faults;
mod line;
mod lookahead;
mod receiver;

pub use device::Device;
pub use disturbance::Disturbance;
pub use faults::{BusDirection, ByteDamage, ByteFault};

use std::collections::VecDeque;

pub use super::morpheus_servo::MotorDrive;
use super::morpheus_servo::{Reading, Servo};
use armbridge_control::encoder::Encoder;
use events::Event;
use faults::Faults;
use line::{Frame, Line, MASTER, SenderFilter};
use lookahead::Schedule;
use receiver::Receiver;

/// One bit at 1 Mbaud.
const DEFAULT_BIT_NS: u64 = 1_000;

/// Time of one bit at this rate.
pub(crate) fn bit_ns(baud: u32) -> u64 {
    (1_000_000_000 / u64::from(baud.max(1))).max(1)
}

/// Mechanics and sensors of the servos.
pub trait Mechanics {
    /// Reading of servo `servo`'s converter at `at_ns`.
    fn convert(&mut self, servo: usize, at_ns: u64) -> Reading;
    /// The same of a servo that may have another encoder than an AX-12A.
    fn convert_with(&mut self, servo: usize, _encoder: Encoder, at_ns: u64) -> Reading {
        self.convert(servo, at_ns)
    }
    /// Speed of servo `servo`'s shaft at `at_ns`, in counts of this encoder a second, which its
    /// winding's voltage has; `None` if only the encoder shows it.
    fn counts_per_s(&mut self, _servo: usize, _encoder: Encoder, _at_ns: u64) -> Option<f64> {
        None
    }
    /// The PWM applied to servo `servo`'s motor changes at `at_ns`. It is off at power-up.
    fn drive(&mut self, servo: usize, at_ns: u64, drive: MotorDrive);
}

/// A byte from the servos as the master's receiver decodes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReceivedByte {
    /// The byte.
    pub byte: u8,
    /// Time of reception, three quarters into its stop bit.
    pub end_ns: u64,
    /// The stop bit was not high: bytes collided.
    pub framing_error: bool,
}

/// An event on the wire; see [`Wire::record`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Record {
    /// A servo sent a byte.
    Sent {
        /// The servo.
        servo: usize,
        /// The byte.
        byte: u8,
        /// Start of its start bit.
        start_ns: u64,
        /// End of its stop bit.
        end_ns: u64,
    },
    /// A servo switched its bus driver off.
    Released {
        /// The servo.
        servo: usize,
        /// Its time.
        at_ns: u64,
    },
    /// A byte as decoded by a receiver that is always on.
    Decoded(u8),
}

/// A half-duplex bus with one master and any number of servos.
#[derive(Debug, Clone)]
pub struct Wire {
    now_ns: u64,
    servos: Vec<Device>,
    receivers: Vec<Receiver>,
    master: Receiver,
    monitor: Option<Receiver>,
    records: Vec<Record>,
    /// Bytes not yet begun, in order of their start.
    due: VecDeque<Frame>,
    line: Line,
    received: VecDeque<ReceivedByte>,
    disturbance: Option<Disturbance>,
    faults: Faults,
    /// Of each servo, as last computed.
    schedule: Vec<Schedule>,
}

impl Wire {
    /// A wire with these servos, all powered up at t = 0.
    pub fn new<D: Into<Device>>(servos: Vec<D>) -> Self {
        let servos: Vec<Device> = servos.into_iter().map(Into::into).collect();
        let receivers = servos
            .iter()
            .map(|servo| Receiver::new(SenderFilter::All, servo.bit_ns()))
            .collect();
        let schedule = servos.iter().map(Device::schedule).collect();
        Self {
            now_ns: 0,
            servos,
            receivers,
            master: Receiver::new(SenderFilter::Servos, DEFAULT_BIT_NS),
            monitor: None,
            records: Vec::new(),
            due: VecDeque::new(),
            line: Line::default(),
            received: VecDeque::new(),
            disturbance: None,
            faults: Faults::default(),
            schedule,
        }
    }

    /// Time up to which all events are executed.
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// The servos, in the order given.
    pub fn servos(&self) -> &[Device] {
        &self.servos
    }

    /// Those of them that run Morpheus.
    pub fn morpheus(&self) -> impl Iterator<Item = &Servo> {
        self.servos.iter().filter_map(Device::morpheus)
    }

    /// Mutable access to a servo, for properties that a master cannot change: supply, heat.
    pub fn servo_mut(&mut self, servo: usize) -> &mut Device {
        &mut self.servos[servo]
    }

    /// Starts to record [`Record`]s, for tests and tools.
    pub fn record(&mut self) {
        self.monitor = Some(Receiver::new(SenderFilter::All, DEFAULT_BIT_NS));
    }

    /// The records since the last call.
    pub fn take_records(&mut self) -> Vec<Record> {
        std::mem::take(&mut self.records)
    }

    /// Rate at which the master receives from now on. Each byte that it sends
    /// sets it too.
    pub(crate) fn listen_at(&mut self, baud: u32) {
        let bit_ns = bit_ns(baud);
        self.master.set_bit(bit_ns);
        if let Some(monitor) = &mut self.monitor {
            monitor.set_bit(bit_ns);
        }
    }

    /// Sends a byte of the master whose start bit begins at `start_ns`, which is
    /// not before now nor before the end of its previous byte.
    pub fn send(&mut self, start_ns: u64, byte: u8, baud: u32) {
        self.listen_at(baud);
        self.send_frame(Frame {
            sender: MASTER,
            byte,
            start_ns: start_ns.max(self.now_ns),
            bit_ns: bit_ns(baud),
        });
    }

    fn enqueue(&mut self, frame: Frame) {
        let later = |f: &&Frame| f.start_ns > frame.start_ns;
        match self.due.iter().rev().take_while(later).count() {
            0 => self.due.push_back(frame),
            count => self.due.insert(self.due.len() - count, frame),
        }
    }

    /// The oldest byte received from the servos and not yet taken.
    pub fn take_received(&mut self) -> Option<ReceivedByte> {
        self.received.pop_front()
    }

    /// Disturbs replies at the master's receiver from now on.
    pub fn disturb(&mut self, disturbance: Disturbance) {
        self.disturbance = Some(disturbance);
    }

    /// Connects a servo to the wire or disconnects it. It stays powered.
    pub fn connect(&mut self, servo: usize, connected: bool) {
        self.servos[servo].connect(connected);
        self.update_receiver(servo);
    }

    /// Power-cycles a servo.
    pub fn power_cycle(&mut self, servo: usize, mechanics: &mut impl Mechanics) {
        self.servos[servo].power_cycle(self.now_ns);
        mechanics.drive(servo, self.now_ns, self.servos[servo].pwm().into());
        self.due.retain(|frame| frame.sender != servo);
        self.update_receiver(servo);
        self.servo_changed(servo);
    }

    /// Time of the next event; `u64::MAX` if there is none.
    pub fn next_event_ns(&self) -> u64 {
        self.next_event().0
    }

    /// The next event, and its time. Of several at one time, senders precede receivers, and
    /// receivers precede the servos.
    fn next_event(&self) -> (u64, Event) {
        let due = self.due.front().map_or(u64::MAX, |frame| frame.start_ns);
        let master = self.master.next_ns();
        let late = self.faults.next_ns();
        let monitor = self.monitor.as_ref().map_or(u64::MAX, Receiver::next_ns);
        let (mut received, mut servo, mut servo_ns) = (u64::MAX, 0, u64::MAX);
        for (other, (schedule, receiver)) in self.schedule.iter().zip(&self.receivers).enumerate() {
            received = received.min(receiver.next_ns());
            let next_ns = schedule.next_ns.max(self.now_ns);
            if next_ns < servo_ns {
                (servo, servo_ns) = (other, next_ns);
            }
        }
        let before = due.min(master).min(late).min(monitor).min(received);
        let next = before.min(servo_ns).max(self.now_ns);
        let event = match next {
            _ if next < before => Event::Servo(servo),
            _ if due <= next => Event::Begin,
            _ if master <= next => Event::Master,
            _ if late <= next => Event::LateByte,
            _ if monitor <= next => Event::Monitor,
            _ => Event::Receivers,
        };
        (next, event)
    }

    /// Executes all events up to and including `to_ns`.
    pub fn advance(&mut self, to_ns: u64, mechanics: &mut impl Mechanics) {
        self.advance_until(to_ns, usize::MAX, mechanics);
    }

    /// The same, but stops at the byte after which `received` bytes can be taken.
    pub(crate) fn advance_until(
        &mut self,
        to_ns: u64,
        received: usize,
        mechanics: &mut impl Mechanics,
    ) {
        while self.received.len() < received {
            let (next, event) = self.next_event();
            if next > to_ns {
                self.now_ns = self.now_ns.max(to_ns);
                return;
            }
            self.now_ns = next;
            self.execute(event, to_ns, mechanics);
        }
    }
}
