//! The board's end of the control link: bytes in, frames out.
//!
//! Runs in thread mode, beside the tick. It answers hellos, validates commands and
//! designs their gains, so that the tick gets commands that need no further work. Before
//! the host has shown the same schema only a hello is answered, and only an emergency stop
//! is executed. A frame that is older than an earlier one is not executed, and garbage that
//! outweighs the frames is an emergency stop: see [`GARBAGE_MAX`].

mod outgoing;

use super::channels::{LinkEnd, Notification};
use super::command::{ValidatedCommand, validate};
use crate::tick::DriveRequest;
use crate::tick::limits::MOTION;
use crate::tick::reference::{self, StartPoint, TimedTrajectory};
use armbridge_control::trajectory::Trajectory;
use armbridge_link::board::HELLO_BITS;
use armbridge_link::frame::{Decoder, Encoder, FrameError, Received};
use armbridge_link::message::{
    BoardReport, Command, Limits, Moment, Refusal, Settings, SettingsFrom, Setup, Stack,
    StopSource, ToBoard, ToHost,
};
use armbridge_link::motion::Motion;
use armbridge_link::schema;

/// Bytes of garbage that are an emergency stop. A frame of the host that arrives
/// whole outweighs [`FRAME_WEIGHT`] of them. At 12 Mbaud of USB a flood is detected
/// within 4 ms, at 115200 baud within 400; a host that loses every other frame on
/// a poor line is not taken for one.
const GARBAGE_MAX: u32 = 4_096;
/// Weight of a frame against bytes of garbage, see [`GARBAGE_MAX`].
const FRAME_WEIGHT: u32 = 512;

/// The board's end of the link.
pub struct LinkPort<'a> {
    end: LinkEnd<'a>,
    decoder: Decoder,
    encoder: Encoder,
    /// Whether the host has sent a hello with the schema of this build.
    is_greeted: bool,
    pending: PendingMessages,
    /// A motion that waits for its start point.
    waiting_motion: Option<(u16, Motion)>,
    /// The answer to a command that did not reach the tick.
    answer: Option<(u16, Result<(), Refusal>)>,
    report: BoardReport,
    /// Number of the newest frame received since the hello.
    newest: Option<u16>,
    /// Bytes of garbage, less the weight of frames.
    garbage: u32,
    /// Settings in force, and those offered to the tick.
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

/// Settings that come into force if the tick accepts them, with the sequence numbers of their
/// commands.
#[derive(Clone, Copy, Debug, Default)]
struct Offered {
    setup: Option<(u16, Setup)>,
    limits: Option<(u16, Limits)>,
}

/// State of a save.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Saving {
    /// The tick has been asked whether torque is off.
    Requested,
    /// The tick has confirmed that torque is off.
    Permitted,
    /// The settings are being written.
    Writing,
}

/// Puts this into an empty place.
fn put<T>(place: &mut Option<T>, value: T) -> Result<(), Refusal> {
    if place.is_some() {
        return Err(Refusal::Busy);
    }
    *place = Some(value);
    Ok(())
}

impl<'a> LinkPort<'a> {
    /// A port in its initial state, of a board with this report and these settings.
    /// The report's session counts resets.
    pub fn new(end: LinkEnd<'a>, mut report: BoardReport, settings: Settings) -> Self {
        report.session <<= HELLO_BITS;
        Self {
            end,
            decoder: Decoder::default(),
            encoder: Encoder::default(),
            is_greeted: false,
            pending: PendingMessages::default(),
            waiting_motion: None,
            answer: None,
            report,
            newest: None,
            garbage: 0,
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
    pub fn take_save(&mut self) -> Option<(u16, &Settings)> {
        let (sequence, saving) = self.saving.as_mut()?;
        if *saving != Saving::Permitted {
            return None;
        }
        *saving = Saving::Writing;
        Some((*sequence, &self.settings))
    }

    /// Takes the result of writing the settings.
    pub fn saved(&mut self, sequence: u16, is_saved: bool) {
        if self
            .saving
            .take_if(|(saving, _)| *saving == sequence)
            .is_some()
        {
            let result = if is_saved {
                self.report.settings = SettingsFrom::Saved;
                self.pending.report = true;
                Ok(())
            } else {
                Err(Refusal::NotSaved)
            };
            self.answer = Some((sequence, result));
        }
    }

    /// Takes bytes from the host.
    pub fn receive(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.garbage = self.garbage.saturating_add(1);
            match self.decoder.push::<ToBoard>(*byte) {
                Some(Ok(received)) => {
                    self.garbage = self.garbage.saturating_sub(FRAME_WEIGHT);
                    self.handle(received);
                }
                // Intact but unknown: a host of another build. The hello of this build
                // lets it inform its user.
                Some(Err(FrameError::Version(_) | FrameError::Schema)) => self.pending.hello = true,
                Some(Err(FrameError::Damaged | FrameError::Direction)) | None => {}
            }
        }
        if self.garbage > GARBAGE_MAX {
            self.garbage = 0;
            self.end.signals.stop(StopSource::Flood);
        }
    }

    /// Handles a message of the host.
    fn handle(&mut self, received: Received<ToBoard>) {
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
                // Drops messages for an earlier host: an old acknowledgement could match
                // a command of this one.
                self.drop_records();
                while let Some(notification) = self.end.notifications.dequeue() {
                    if let Notification::Ack(sequence, result, _) = notification {
                        self.conclude_offer(sequence, result);
                    }
                }
                // The tick takes no earlier request any more.
                self.offered = Offered::default();
                if self.is_greeted {
                    // The tick reports the servos.
                    self.end.signals.hello();
                }
                self.answer = None;
                self.waiting_motion = None;
                self.saving = None;
            }
            // From any host, at any time.
            ToBoard::Stop => self.end.signals.stop(StopSource::Host),
            _ if !self.is_greeted => self.pending.hello = true,
            _ if !self.is_newer(sequence) => {
                self.answer = Some((sequence, Err(Refusal::Stale)));
            }
            ToBoard::Goodbye => {
                self.waiting_motion = None;
                self.end.signals.goodbye();
                self.is_greeted = false;
            }
            ToBoard::Heartbeat => self.end.signals.heartbeat(),
            ToBoard::Command(command) => {
                // The latest command replaces a motion that is not yet planned, above all
                // one that switches off.
                self.waiting_motion = match command {
                    Command::Follow(motion) => Some((sequence, motion)),
                    _ => None,
                };
                let (session, joints) = (self.report.session, self.settings.setup.arm.joints());
                let validated = validate(command, session, joints, self.arm_refusal());
                let validated = validated
                    .and_then(|validated| self.offer(sequence, command).map(|()| validated));
                self.request(sequence, validated);
            }
        }
    }

    /// Reason for which the board does not arm, as far as its settings are concerned.
    fn arm_refusal(&self) -> Option<Refusal> {
        if !self.report.settings.lost().is_empty() {
            Some(Refusal::SettingsLost)
        } else if self.saving.is_some() {
            // Writing them may hold up the program.
            Some(Refusal::Busy)
        } else {
            None
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

    /// Stores the settings that come into force if the tick accepts them. Refused while the
    /// tick has not answered to others of the kind: it would not be known which are in force.
    fn offer(&mut self, sequence: u16, command: Command) -> Result<(), Refusal> {
        match command {
            Command::Configure(setup) => put(&mut self.offered.setup, (sequence, setup)),
            Command::Limit(limits) => put(&mut self.offered.limits, (sequence, limits)),
            Command::Save => put(&mut self.saving, (sequence, Saving::Requested)),
            _ => Ok(()),
        }
    }

    /// Takes the tick's answer to offered settings.
    fn conclude_offer(&mut self, sequence: u16, result: Result<(), Refusal>) {
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

    /// The answer to a command, from that of the tick; `None` if it follows later.
    fn ack(
        &mut self,
        sequence: u16,
        result: Result<(), Refusal>,
        moment: Moment,
    ) -> Option<ToHost> {
        self.conclude_offer(sequence, result);
        let is_save =
            matches!(self.saving, Some((saving, Saving::Requested)) if saving == sequence);
        if is_save {
            self.saving = result.ok().map(|()| (sequence, Saving::Permitted));
            // The answer follows when the settings are written.
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

    /// Passes a valid command to the tick.
    fn request(&mut self, sequence: u16, command: Result<ValidatedCommand, Refusal>) {
        let sent = command.and_then(|command| self.end.request(sequence, command));
        if let Err(refusal) = sent {
            self.conclude_offer(sequence, Err(refusal));
            self.saving.take_if(|(saving, _)| *saving == sequence);
            self.answer = Some((sequence, Err(refusal)));
        }
    }

    /// Plans the waiting motion from this start.
    fn plan(&mut self, sequence: u16, start: StartPoint) {
        let Some((_, motion)) = self
            .waiting_motion
            .take_if(|(waiting, _)| *waiting == sequence)
        else {
            return;
        };
        let planned = Trajectory::plan(start.from, &motion.shape(), &MOTION);
        let command = planned.map(|trajectory| {
            ValidatedCommand::Drive(DriveRequest::Follow(TimedTrajectory {
                trajectory,
                starts_us: start.at_us,
            }))
        });
        self.request(
            sequence,
            command.map_err(|error| reference::refusal(&error)),
        );
    }
}
