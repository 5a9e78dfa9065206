//! The same ticks again, from what was recorded of them.
//!
//! A [`Replay`] is a [`Bridge`] whose bus nobody polls: what the bus would have
//! brought, and when, is taken from a [`Record`]; everything that is decided in a
//! tick is decided by the very code that runs on a board. So what comes out is what
//! the board must have told, to the bit, or the record is not of this code, these
//! settings or these orders.
//!
//! # What influences a record
//!
//! | what                              | where it comes from                         |
//! |-----------------------------------|---------------------------------------------|
//! | samples, alarms, start, lateness  | the record                                  |
//! | set-up, limits                    | `ToHost::Settings`, `Configure` and `Limit` |
//! | commands                          | the host's frames, at the [`Moment`] of their acknowledgement |
//! | where a motion begins             | decided again at the moment of `ToHost::Departs` |
//! | a hello                           | `ToHost::Began`                             |
//! | what the servos are               | `ToHost::Found`                             |
//! | the host's silence                | the recorded mode: heartbeats are not acknowledged |
//! | faults that no tick decides       | `ToHost::Tripped`: see [`is_external`]      |
//!
//! A hello, arming and the end of bring-up make the estimator, the guard and the
//! reference begin anew, so that nothing before them has to be known.
//!
//! The caller keeps the order: what happened before a tick, the tick's beginning,
//! what happened before it was decided, the decision. Nothing here allocates, waits
//! or panics.

mod heard;
mod inputs;
mod nothing;

pub use heard::Heard;
pub use inputs::{is_complete, is_off, planned_us};

use super::course::{self, Leg};
use super::guard::{Guard, Violation};
use super::law::{Decision, Law};
use super::limits::MOTION;
use super::mailbox::{LinkEnd, Mailboxes, Notice, Task};
use super::schedule::Stage;
use super::supervisor::{Event, State};
use super::{Bridge, check};
use crate::control::Trajectory;
use crate::link::experiment::Conclusion;
use crate::link::message::{Command, Fault, Mode, Moment, Record, Refusal, Settings, Trip};
use crate::link::motion::Motion;
use crate::servo::Firmware;
use heapless::Deque;
use nothing::Nothing;

/// Where a motion begins, as decided when it was asked for.
#[derive(Clone, Copy, Debug)]
pub struct Departure(course::Departure);

/// Whether a fault comes from what no record shows, so that it has to be told with
/// [`Replay::trip`]. The others are decided again.
pub const fn is_external(fault: Fault) -> bool {
    match fault {
        Fault::EmergencyStop(_)
        | Fault::Temperature
        | Fault::ServoReset
        | Fault::Clock
        | Fault::FirmwareChanged => true,
        // The first two are told from the mode: they belong into the middle of a
        // decision.
        Fault::HostSilent
        | Fault::Corrupted
        | Fault::AngleLimit
        | Fault::SpeedLimit
        | Fault::TorqueLimit
        | Fault::TorqueRate
        | Fault::PwmLimit
        | Fault::DeadZone
        | Fault::ServoSilent
        | Fault::SamplesLost
        | Fault::SamplesRare
        | Fault::Overrun
        | Fault::Diverged
        | Fault::Stuck
        | Fault::NotFinite
        | Fault::ServoAlarm => false,
    }
}

/// Experiments that may end between two looks at [`Replay::take_conclusion`].
const CONCLUSIONS: usize = 4;

/// A bridge that lives through recorded ticks.
pub struct Replay<'a> {
    bridge: Bridge<'a, Nothing, Nothing>,
    link: LinkEnd<'a>,
    concluded: Deque<Conclusion, CONCLUSIONS>,
}

impl<'a> Replay<'a> {
    /// A bridge that has just begun with these settings.
    ///
    /// # Errors
    /// A [`Refusal`] if no controller exists for the set-up.
    pub fn new(mailboxes: &'a mut Mailboxes, settings: &Settings) -> Result<Self, Refusal> {
        let (end, link, _) = mailboxes.split();
        Ok(Self {
            bridge: Bridge::new(Nothing, Nothing, end, 0, settings)?,
            link,
            concluded: Deque::new(),
        })
    }

    /// These settings are in force, whatever was before.
    ///
    /// # Errors
    /// A [`Refusal`] if no controller exists for the set-up; nothing changes then.
    pub fn set(&mut self, settings: &Settings) -> Result<(), Refusal> {
        let bridge = &mut self.bridge;
        let law = Law::build(&settings.setup)?;
        bridge.guard = Guard::new(settings.limits, law.period_us().get() as u32);
        bridge.law = law;
        bridge.keep_originals();
        Ok(())
    }

    /// What the servos are: a bus that is too slow for the period stretches it.
    pub fn set_line(&mut self, firmware: Firmware, baud: u32, is_ready: bool) {
        // Nobody ever begins anything: the master is idle.
        let _ = self.bridge.master.set_line(firmware, baud);
        self.bridge.master.set_prepared(is_ready);
    }

    /// The mode is that of this record, whatever it was. After [`Self::begin`], before
    /// its decision.
    pub fn assume(&mut self, record: &Record) {
        let bridge = &mut self.bridge;
        let trip = bridge.trip.take();
        bridge.state = match record.mode {
            Mode::Boot => State::Boot,
            Mode::Idle => State::Idle,
            Mode::Armed => State::Armed,
            Mode::Running(_) => State::Running,
            Mode::Degraded(_) => State::Degraded,
            Mode::Passthrough => State::Passthrough,
            Mode::Fault(fault) => {
                let same = trip.filter(|trip| trip.fault == fault);
                bridge.trip = same.or(Some(Trip {
                    fault,
                    joint: None,
                    tick: record.tick,
                    at_us: record.start_us,
                    value: 0.0,
                    limit: 0.0,
                }));
                State::Fault
            }
        };
        if let Some(drive) = record.mode.drive() {
            bridge.drive = drive;
        }
    }

    /// What the record shows of what was before it, for one that is not known to
    /// follow from the one before. After [`Self::begin`], before its decision.
    pub fn assume_before(&mut self, record: &Record) {
        let bridge = &mut self.bridge;
        bridge.record.timing.missed = record.timing.missed;
        bridge.record.pwm_in_force = record.pwm_in_force;
        if is_off(record) {
            bridge.in_force = Decision::off();
        }
    }

    /// Nothing is known of what went on, but that nothing drives the motors.
    pub fn forget(&mut self) {
        let bridge = &mut self.bridge;
        bridge.state = State::Idle;
        bridge.trip = None;
        bridge.next = Decision::off();
    }

    /// Goes on from this record, of whose tick all else is unknown.
    pub fn adopt(&mut self, record: &Record) {
        self.assume(record);
        let bridge = &mut self.bridge;
        bridge.stage = Stage::Ticking;
        if !bridge.state.is_driven() {
            bridge.next = Decision::off();
        }
        bridge.record = *record;
        bridge.decided = record.tick;
    }

    /// Bring-up is over, unless ticks go on already.
    pub fn begin_ticking(&mut self) {
        if self.bridge.stage != Stage::Ticking {
            self.bridge.begin_ticking();
            self.forget_notices();
        }
    }

    /// The bus was somebody else's, and is lined up again: between two ticks of a
    /// board that told neither.
    pub fn begin_again(&mut self) {
        self.bridge.stage = Stage::Stop;
        self.begin_ticking();
    }

    /// Whether ticks go on; otherwise bring-up comes before the next.
    pub fn is_ticking(&self) -> bool {
        self.bridge.stage == Stage::Ticking
    }

    /// When the next tick was planned to begin, in µs.
    pub fn planned_us(&self) -> u64 {
        self.bridge.next_start_us
    }

    /// What it is doing.
    pub fn mode(&self) -> Mode {
        self.bridge.mode()
    }

    /// Why it is in a fault.
    pub fn cause(&self) -> Option<Trip> {
        match self.bridge.state {
            State::Fault => self.bridge.trip,
            State::Boot
            | State::Idle
            | State::Armed
            | State::Running
            | State::Degraded
            | State::Passthrough => None,
        }
    }

    /// The tick of this record begins.
    pub fn begin(&mut self, inputs: &Record) {
        let bridge = &mut self.bridge;
        bridge.record.tick = inputs.tick.wrapping_sub(1);
        bridge.now_us = inputs.start_us;
        bridge.next_start_us = planned_us(inputs);
        bridge.begin_tick();
        self.forget_notices();
    }

    /// Decides the tick that has begun. What comes back is the record as it should
    /// be; what was measured of the tick is copied from `inputs`.
    pub fn decide(&mut self, inputs: &Record, heard: Heard) -> Record {
        let bridge = &mut self.bridge;
        let missed = bridge.record.timing.missed;
        bridge.record.samples = inputs.samples;
        bridge.record.alarms = inputs.alarms;
        bridge.record.dropped = inputs.dropped;
        bridge.record.timing = inputs.timing;
        bridge.record.timing.missed = missed;
        let limits = bridge.guard.limits();
        let silent_ms = match heard {
            Heard::Nothing => None,
            Heard::Silence => Some(limits.hold_ms),
            Heard::LongSilence => Some(limits.silence_ms),
            Heard::Corruption => {
                bridge.originals.spoil();
                None
            }
        };
        let silent_us = silent_ms.map_or(0, |ms| u64::from(ms) * 1_000 + 1);
        bridge.now_us = bridge.now_us.max(silent_us);
        bridge.heard_us = bridge.now_us.saturating_sub(silent_us);
        bridge.decide();
        let record = bridge.record;
        if heard == Heard::Corruption {
            bridge.keep_originals();
        }
        self.forget_notices();
        record
    }

    /// A host says hello.
    pub fn greet(&mut self, moment: Moment) {
        self.now(moment);
        self.bridge.greet();
        self.forget_notices();
    }

    /// The host leaves.
    pub fn goodbye(&mut self) {
        // Never refused.
        let _ = self.bridge.apply(Event::Disarm);
        self.forget_notices();
    }

    /// A client of the transparent port takes the bus.
    pub fn hand_over(&mut self) {
        // Never refused.
        let _ = self.bridge.apply(Event::ClientCame);
        self.forget_notices();
    }

    /// A fault that is decided elsewhere; see [`is_external`].
    pub fn trip(&mut self, trip: &Trip) {
        self.bridge.now_us = trip.at_us;
        self.bridge.trip(Violation {
            fault: trip.fault,
            joint: trip.joint,
            value: trip.value,
            limit: trip.limit,
        });
        self.forget_notices();
    }

    /// A motion is asked for at this moment: where does it begin?
    ///
    /// # Errors
    /// Why it cannot be.
    pub fn depart(&mut self, moment: Moment) -> Result<Departure, Refusal> {
        self.now(moment);
        self.bridge.departure().map(Departure)
    }

    /// The motion is planned, and taken at this moment.
    ///
    /// # Errors
    /// Why it cannot be.
    pub fn follow(
        &mut self,
        motion: &Motion,
        departure: Departure,
        moment: Moment,
    ) -> Result<(), Refusal> {
        let Departure(from) = departure;
        let trajectory = Trajectory::plan(from.from, &motion.shape(), &MOTION)
            .map_err(|error| course::refusal(&error))?;
        let leg = Leg {
            trajectory,
            starts_us: from.at_us,
        };
        self.perform(Task::Follow(leg), moment)
    }

    /// Any other command is taken at this moment.
    ///
    /// # Errors
    /// Why it cannot be.
    pub fn command(&mut self, command: Command, moment: Moment) -> Result<(), Refusal> {
        let session = match command {
            // Whose the session is has been seen to.
            Command::Arm { session } => session,
            _ => 0,
        };
        let task = check::task(command, session, false)?;
        self.perform(task, moment)
    }

    fn perform(&mut self, task: Task, moment: Moment) -> Result<(), Refusal> {
        self.now(moment);
        let result = self.bridge.perform(task);
        self.forget_notices();
        result
    }

    fn now(&mut self, moment: Moment) {
        self.bridge.now_us = moment.at_us;
    }

    /// How an experiment ended, in order.
    pub fn take_conclusion(&mut self) -> Option<Conclusion> {
        self.concluded.pop_front()
    }

    /// Nobody fetches them here.
    fn forget_notices(&mut self) {
        while let Some(notice) = self.link.notices.dequeue() {
            if let Notice::Concluded(conclusion) = notice {
                // One that nobody has looked at for so long is of no interest.
                if self.concluded.is_full() {
                    self.concluded.pop_front();
                }
                let _ = self.concluded.push_back(conclusion);
            }
        }
    }
}
