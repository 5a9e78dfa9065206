//! The board's end of the control link: bytes in, frames out.
//!
//! Runs in thread mode, beside the tick. It answers hellos, checks commands and
//! designs the gains they ask for, so that the tick is handed only what it can
//! use at once. Nothing but a hello is answered before the host has shown that
//! it has the same schema, and nothing but an emergency stop is executed. A frame
//! that is older than an earlier one is not executed either, and garbage that
//! outweighs the frames is an emergency stop: see [`SPOILED_MAX`].

use super::channels::{LinkEnd, Notification};
use super::command::{ValidatedCommand, validate};
use crate::control::Trajectory;
use crate::control_loop::limits::MOTION;
use crate::control_loop::reference::{self, StartPoint, TimedTrajectory};
use crate::link::board::HELLO_BITS;
use crate::link::frame::{Decoder, Encoder, FrameError, Received};
use crate::link::message::{
    BoardReport, Command, Limits, Moment, Refusal, Settings, Setup, Stack, StopSource, ToBoard,
    ToHost,
};
use crate::link::motion::Motion;
use crate::link::schema;

/// Bytes of garbage that are an emergency stop. A frame of the host that arrives
/// whole outweighs [`FRAME_WEIGHT`] of them. At 12 Mbaud of USB a flood is detected
/// within 4 ms, at 115200 baud within 400; a host that loses every other frame on
/// a poor line is not taken for one.
const SPOILED_MAX: u32 = 4_096;
/// See [`SPOILED_MAX`].
const FRAME_WEIGHT: u32 = 512;

/// The board's end of the link.
pub struct LinkPort<'a> {
    end: LinkEnd<'a>,
    decoder: Decoder,
    encoder: Encoder,
    /// The host has sent a hello with our schema.
    is_greeted: bool,
    pending: PendingMessages,
    /// A motion that waits for its start point.
    waiting: Option<(u16, Motion)>,
    /// The answer to a command that never got to the tick.
    answered: Option<(u16, Result<(), Refusal>)>,
    report: BoardReport,
    /// Number of the newest frame received since the hello.
    newest: Option<u16>,
    /// Bytes of garbage, less the weight of frames.
    spoiled: u32,
    /// Settings of the tick, and those it has been offered.
    settings: Settings,
    offered: Offered,
    /// State of a save, with its sequence number.
    saving: Option<(u16, Saving)>,
}

/// Messages about the board itself that are due to the host.
#[derive(Clone, Copy, Debug, Default)]
struct PendingMessages {
    hello: bool,
    report: bool,
    settings: bool,
}

/// Settings that come into force if the tick agrees, with the sequence numbers of their
/// commands.
#[derive(Clone, Copy, Debug, Default)]
struct Offered {
    setup: Option<(u16, Setup)>,
    limits: Option<(u16, Limits)>,
}

/// State of a save.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Saving {
    Asked,
    Allowed,
    Begun,
}

impl<'a> LinkPort<'a> {
    /// A port that has received nothing, of a board with this report and these settings.
    /// The report's session counts resets.
    pub fn new(end: LinkEnd<'a>, mut report: BoardReport, settings: Settings) -> Self {
        report.session <<= HELLO_BITS;
        Self {
            end,
            decoder: Decoder::default(),
            encoder: Encoder::default(),
            is_greeted: false,
            pending: PendingMessages::default(),
            waiting: None,
            answered: None,
            report,
            newest: None,
            spoiled: 0,
            settings,
            offered: Offered::default(),
            saving: None,
        }
    }

    /// Sets the use of the stack; the host gets a new report when it grows.
    pub fn set_stack(&mut self, stack: Stack) {
        let stack = Some(stack);
        self.pending.report |= self.is_greeted && self.report.stack != stack;
        self.report.stack = stack;
    }

    /// Settings that are to be written now, with their number for [`LinkPort::saved`]:
    /// torque is off and stays off meanwhile.
    pub fn take_save(&mut self) -> Option<(u16, Settings)> {
        let (sequence, saving) = self.saving.as_mut()?;
        if *saving != Saving::Allowed {
            return None;
        }
        *saving = Saving::Begun;
        Some((*sequence, self.settings))
    }

    /// Takes the result of writing the settings.
    pub fn saved(&mut self, sequence: u16, is_saved: bool) {
        if self
            .saving
            .take_if(|(saving, _)| *saving == sequence)
            .is_some()
        {
            let result = if is_saved {
                Ok(())
            } else {
                Err(Refusal::NotSaved)
            };
            self.answered = Some((sequence, result));
        }
    }

    /// Takes bytes from the host.
    pub fn receive(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.spoiled = self.spoiled.saturating_add(1);
            match self.decoder.push::<ToBoard>(*byte) {
                Some(Ok(received)) => {
                    self.spoiled = self.spoiled.saturating_sub(FRAME_WEIGHT);
                    self.message(received);
                }
                // Intact but unknown: a host of another build. Our hello lets
                // it inform its user.
                Some(Err(FrameError::Version(_) | FrameError::Schema)) => self.pending.hello = true,
                Some(Err(FrameError::Damaged | FrameError::Direction)) | None => {}
            }
        }
        if self.spoiled > SPOILED_MAX {
            self.spoiled = 0;
            self.end.stop(StopSource::Flood);
        }
    }

    fn message(&mut self, received: Received<ToBoard>) {
        let sequence = received.sequence;
        match received.message {
            ToBoard::Hello(hello) => {
                self.is_greeted = hello.schema == schema::HASH;
                self.pending.hello = true;
                self.pending.report = true;
                self.pending.settings = true;
                if self.is_greeted {
                    self.report.session = self.report.session.wrapping_add(1);
                }
                self.newest = Some(sequence);
                // Drops what was meant for an earlier host: an old acknowledgement might
                // be taken for this one's.
                self.forget_records();
                while let Some(notification) = self.end.notifications.dequeue() {
                    if let Notification::Ack(sequence, result, _) = notification {
                        self.settle(sequence, result);
                    }
                }
                if self.is_greeted {
                    // The tick reports the servos.
                    self.end.hello();
                }
                self.answered = None;
                self.waiting = None;
                self.saving = None;
            }
            // From any host, and however late.
            ToBoard::Stop => self.end.stop(StopSource::Host),
            _ if !self.is_greeted => self.pending.hello = true,
            _ if !self.is_newer(sequence) => {
                self.answered = Some((sequence, Err(Refusal::Stale)));
            }
            ToBoard::Goodbye => {
                self.waiting = None;
                self.end.goodbye();
                self.is_greeted = false;
            }
            ToBoard::Heartbeat => self.end.heartbeat(),
            ToBoard::Command(command) => {
                // The latest command replaces a motion that is not yet planned, above all
                // one that switches off.
                self.waiting = match command {
                    Command::Follow(motion) => Some((sequence, motion)),
                    _ => None,
                };
                let validated = validate(command, self.report.session, self.saving.is_some());
                if validated.is_ok() {
                    self.offer(sequence, command);
                }
                self.request(sequence, validated);
            }
        }
    }

    /// Whether a frame is newer than all before it since the hello.
    fn is_newer(&mut self, sequence: u16) -> bool {
        let is_newer = self
            .newest
            .is_none_or(|newest| (sequence.wrapping_sub(newest) as i16) > 0);
        if is_newer {
            self.newest = Some(sequence);
        }
        is_newer
    }

    /// Keeps the settings that come into force if the tick agrees.
    fn offer(&mut self, sequence: u16, command: Command) {
        match command {
            Command::Configure(setup) => self.offered.setup = Some((sequence, setup)),
            Command::Limit(limits) => self.offered.limits = Some((sequence, limits)),
            Command::Save => self.saving = Some((sequence, Saving::Asked)),
            _ => {}
        }
    }

    /// Takes the tick's answer to offered settings.
    fn settle(&mut self, sequence: u16, result: Result<(), Refusal>) {
        let Offered { setup, limits } = &mut self.offered;
        let setup = setup.take_if(|(offered, _)| *offered == sequence);
        let limits = limits.take_if(|(offered, _)| *offered == sequence);
        if result.is_err() {
            return;
        }
        if let Some((_, setup)) = setup {
            self.settings.setup = setup;
            self.pending.settings = true;
        }
        if let Some((_, limits)) = limits {
            self.settings.limits = limits;
            self.pending.settings = true;
        }
    }

    /// The answer to a command, from the tick's; `None` if more is to follow.
    fn ack(
        &mut self,
        sequence: u16,
        result: Result<(), Refusal>,
        moment: Moment,
    ) -> Option<ToHost> {
        self.settle(sequence, result);
        let is_save = matches!(self.saving, Some((saving, Saving::Asked)) if saving == sequence);
        if is_save {
            self.saving = result.ok().map(|()| (sequence, Saving::Allowed));
            // The answer follows when it is written.
            if result.is_ok() {
                return None;
            }
        }
        Some(ToHost::Ack {
            sequence,
            result,
            moment: Some(moment),
        })
    }

    fn request(&mut self, sequence: u16, command: Result<ValidatedCommand, Refusal>) {
        let sent = command.and_then(|command| self.end.request(sequence, command));
        if let Err(refusal) = sent {
            self.answered = Some((sequence, Err(refusal)));
        }
    }

    /// Plans the motion that waits from this start.
    fn plan(&mut self, sequence: u16, start: StartPoint) {
        let Some((_, motion)) = self.waiting.take_if(|(waiting, _)| *waiting == sequence) else {
            return;
        };
        let planned = Trajectory::plan(start.from, &motion.shape(), &MOTION);
        let command = planned.map(|trajectory| {
            ValidatedCommand::Follow(TimedTrajectory {
                trajectory,
                starts_us: start.at_us,
            })
        });
        self.request(
            sequence,
            command.map_err(|error| reference::refusal(&error)),
        );
    }

    fn forget_records(&mut self) {
        while self.end.records.dequeue().is_some() {}
    }

    /// The next frame for the host, if there is one.
    pub fn transmit(&mut self) -> Option<&[u8]> {
        if let Some(message) = self.next_message() {
            return Some(self.encoder.encode(&message).1);
        }
        if !self.is_greeted {
            return None;
        }
        let Self { end, encoder, .. } = self;
        end.records.take(|record| encoder.encode_record(record))
    }

    /// The next message, records apart: they are encoded where they lie.
    fn next_message(&mut self) -> Option<ToHost> {
        if core::mem::take(&mut self.pending.hello) {
            return Some(ToHost::Hello(schema::HELLO));
        }
        if let Some((sequence, result)) = self.answered.take() {
            return Some(ToHost::Ack {
                sequence,
                result,
                moment: None,
            });
        }
        if !self.is_greeted {
            // No host is connected: they do not count as dropped.
            self.forget_records();
            return None;
        }
        if core::mem::take(&mut self.pending.report) {
            return Some(ToHost::Board(self.report));
        }
        if core::mem::take(&mut self.pending.settings) {
            return Some(ToHost::Settings(self.settings));
        }
        while let Some(notification) = self.end.notifications.dequeue() {
            let message = match notification {
                Notification::Dropped(sequence) => {
                    self.settle(sequence, Err(Refusal::Stale));
                    self.saving.take_if(|(saving, _)| *saving == sequence);
                    Some(ToHost::Ack {
                        sequence,
                        result: Err(Refusal::Stale),
                        moment: None,
                    })
                }
                Notification::Ack(sequence, result, moment) => self.ack(sequence, result, moment),
                Notification::Began(moment) => Some(ToHost::Began(moment)),
                Notification::Absent(joint, missing) => Some(ToHost::Absent { joint, missing }),
                Notification::Found(firmware, baud, is_ready) => Some(ToHost::Found {
                    firmware,
                    baud,
                    is_ready,
                }),
                Notification::Mixed(firmwares) => Some(ToHost::Mixed(firmwares)),
                Notification::Passthrough => Some(ToHost::Passthrough),
                Notification::Unprepared(joint) => Some(ToHost::Unprepared { joint }),
                Notification::Port(counters) => Some(ToHost::Port(counters)),
                Notification::Tripped(trip) => Some(ToHost::Tripped(trip)),
                Notification::Off(report) => Some(ToHost::Off(report)),
                Notification::Concluded(conclusion) => Some(ToHost::Concluded(conclusion)),
                Notification::Temperature(joint, value) => {
                    Some(ToHost::Temperature { joint, value })
                }
                Notification::StartPoint(sequence, start, moment) => {
                    self.plan(sequence, start);
                    Some(ToHost::Departs { sequence, moment })
                }
            };
            if message.is_some() {
                return message;
            }
        }
        None
    }
}
