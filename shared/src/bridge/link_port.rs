//! The board's end of the control link: bytes in, frames out.
//!
//! Runs in thread mode, beside the tick. It answers hellos, checks commands and
//! designs the gains they ask for, so that the tick is handed only what it can
//! use at once. Nothing but a hello is answered before the host has shown that
//! it speaks the same schema.

use super::course::{self, Departure, Leg};
use super::law::Law;
use super::limits::{MOTION, REFERENCE_MAX_RAD, TORQUE_MAX_NM};
use super::mailbox::{LinkEnd, Notice, Order, Task};
use crate::JOINTS;
use crate::control::Trajectory;
use crate::control::trajectory::stream::Point;
use crate::link::frame::{Decoder, Encoder, FrameError, Received};
use crate::link::message::{Command, Refusal, ToBoard, ToHost};
use crate::link::motion::Motion;
use crate::link::schema;

/// The board's end of the link.
pub struct LinkPort<'a> {
    end: LinkEnd<'a>,
    decoder: Decoder,
    encoder: Encoder,
    /// The host has said hello with our schema.
    is_greeted: bool,
    /// Our hello is owed.
    hello_due: bool,
    /// A motion that waits to be told where it begins.
    waiting: Option<(u16, Motion)>,
    /// A command refused here, not by the tick.
    refused: Option<(u16, Refusal)>,
}

impl<'a> LinkPort<'a> {
    /// A port that has not been spoken to.
    pub fn new(end: LinkEnd<'a>) -> Self {
        Self {
            end,
            decoder: Decoder::default(),
            encoder: Encoder::default(),
            is_greeted: false,
            hello_due: false,
            waiting: None,
            refused: None,
        }
    }

    /// Takes bytes from the host.
    pub fn receive(&mut self, bytes: &[u8]) {
        for byte in bytes {
            match self.decoder.push::<ToBoard>(*byte) {
                Some(Ok(received)) => self.message(received),
                // Intact but strange: a host of another build. Our hello lets
                // it tell its user so.
                Some(Err(FrameError::Version(_) | FrameError::Schema)) => self.hello_due = true,
                Some(Err(FrameError::Damaged | FrameError::Direction)) | None => {}
            }
        }
    }

    fn message(&mut self, received: Received<ToBoard>) {
        match received.message {
            ToBoard::Hello(hello) => {
                self.is_greeted = hello.schema == schema::HASH;
                self.hello_due = true;
                // What was said to nobody, or to a host before this one, is not
                // for it: an old acknowledgement might be taken for its own.
                self.forget_records();
                while self.end.notices.dequeue().is_some() {}
                // The tick tells it what the servos are.
                let _ = self.end.orders.enqueue(Order::Greeted);
                self.refused = None;
                self.waiting = None;
            }
            _ if !self.is_greeted => self.hello_due = true,
            ToBoard::Heartbeat => {
                // A full queue holds orders, which say the same.
                let _ = self.end.orders.enqueue(Order::Heartbeat);
            }
            ToBoard::Command(command) => {
                // The latest wins: whatever comes after a motion that is not yet
                // planned is instead of it, switching off above all.
                self.waiting = match command {
                    Command::Follow(motion) => Some((received.sequence, motion)),
                    _ => None,
                };
                self.order(received.sequence, task(command));
            }
        }
    }

    fn order(&mut self, sequence: u16, task: Result<Task, Refusal>) {
        let order = task.map(|task| Order::Do(sequence, task));
        let sent = order.and_then(|order| {
            let queued = self.end.orders.enqueue(order);
            queued.map_err(|_| Refusal::Busy)
        });
        if let Err(refusal) = sent {
            self.refused = Some((sequence, refusal));
        }
    }

    /// Plans the motion that waits for this departure.
    fn plan(&mut self, sequence: u16, departure: Departure) {
        let Some((_, motion)) = self.waiting.take_if(|(waiting, _)| *waiting == sequence) else {
            return;
        };
        let planned = Trajectory::plan(departure.from, &motion.shape(), &MOTION);
        let task = planned.map(|trajectory| {
            Task::Follow(Leg {
                trajectory,
                starts_us: departure.at_us,
            })
        });
        self.order(sequence, task.map_err(|error| course::refusal(&error)));
    }

    fn forget_records(&mut self) {
        while self.end.records.dequeue().is_some() {}
    }

    /// The next frame for the host, if there is one.
    pub fn transmit(&mut self) -> Option<&[u8]> {
        let message = self.next_message()?;
        Some(self.encoder.encode(&message).1)
    }

    fn next_message(&mut self) -> Option<ToHost> {
        while let Some(Notice::Departure(sequence, departure)) = self.end.notices.peek().copied() {
            let _ = self.end.notices.dequeue();
            self.plan(sequence, departure);
        }
        if core::mem::take(&mut self.hello_due) {
            return Some(ToHost::Hello(schema::HELLO));
        }
        if let Some((sequence, refusal)) = self.refused.take() {
            return Some(ToHost::Ack {
                sequence,
                result: Err(refusal),
            });
        }
        if !self.is_greeted {
            // Nobody is there to miss them: they do not count as dropped.
            self.forget_records();
            return None;
        }
        if let Some(notice) = self.end.notices.dequeue() {
            return match notice {
                Notice::Ack(sequence, result) => Some(ToHost::Ack { sequence, result }),
                Notice::Absent(joint, missing) => Some(ToHost::Absent { joint, missing }),
                Notice::Found(firmware, baud, is_ready) => Some(ToHost::Found {
                    firmware,
                    baud,
                    is_ready,
                }),
                Notice::Mixed(firmwares) => Some(ToHost::Mixed(firmwares)),
                Notice::Passthrough => Some(ToHost::Passthrough),
                Notice::Unprepared(joint) => Some(ToHost::Unprepared { joint }),
                Notice::Port(counters) => Some(ToHost::Port(counters)),
                // Taken above.
                Notice::Departure(..) => None,
            };
        }
        self.end.records.dequeue().map(ToHost::Record)
    }
}

/// Checks a command and does the work that has no place in the tick.
fn task(command: Command) -> Result<Task, Refusal> {
    let within = |values: [f32; JOINTS], limit: f32| {
        // A NaN is within nothing.
        values
            .iter()
            .all(|value| value.abs() <= limit)
            .then_some(values)
    };
    match command {
        Command::Idle => Ok(Task::Idle),
        Command::Torque(torque) => within(torque, TORQUE_MAX_NM)
            .map(Task::Torque)
            .ok_or(Refusal::OutOfRange),
        Command::Regulate(reference) => within(reference, REFERENCE_MAX_RAD)
            .map(Task::Regulate)
            .ok_or(Refusal::OutOfRange),
        Command::Follow(_) => Ok(Task::Depart),
        Command::Stream {
            at_us,
            angle_rad,
            speed_rad_s,
        } => Ok(Task::Stream(Point {
            at_us,
            q: angle_rad.into(),
            dq: speed_rad_s.map(Into::into),
        })),
        Command::Prepare => Ok(Task::Prepare),
        Command::Release => Ok(Task::Release),
        Command::ClearFault => Ok(Task::ClearFault),
        Command::Configure(setup) => Law::build(&setup).map(Task::Install),
    }
}
