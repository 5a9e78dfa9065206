//! The recorded board, run again: the core that boards run, with the inputs of records.
//!
//! What the bus would have brought, and when, is taken from a [`Record`]; everything that
//! is decided in a tick is decided by the very code that runs on a board. So what results
//! is what the board must have sent, to the bit, or the record is not of this code, these
//! settings or these commands.
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
//! | faults from outside the tick      | `ToHost::Tripped`, see [`is_external`]      |
//! | the host's silence                | the mode of the record that shows it        |
//!
//! A hello, arming and bring-up make estimator, monitors and reference begin anew, so that
//! nothing before them has to be known.
//!
//! The caller keeps the order: what happened before a tick, the tick's beginning, what
//! happened before it was decided, the decision.

use std::collections::VecDeque;

use armbridge_shared::actuator::Pwm;
use armbridge_shared::arm::State as ArmState;
use armbridge_shared::bridge::app_core::{BusFacts, Core, TickSamples};
use armbridge_shared::bridge::command::{ValidatedCommand, validate};
use armbridge_shared::control::Trajectory;
use armbridge_shared::control_loop::limits::MOTION;
use armbridge_shared::control_loop::reference::{StartPoint, TimedTrajectory, refusal};
use armbridge_shared::control_loop::{LoopConfig, Violation};
use armbridge_shared::flow_token::FlowToken;
use armbridge_shared::link::experiment::Conclusion;
use armbridge_shared::link::message::{
    Command, Drive, Fault, Mode, Moment, Record, Refusal, Settings, Trip,
};
use armbridge_shared::link::motion::Motion;
use armbridge_shared::servo::Firmware;
use armbridge_shared::servo::master::Readiness;
use armbridge_shared::servo::master::timing::tick_us;
use armbridge_shared::servo::protocol1::Alarms;
use armbridge_shared::supervisor::{Event, State};

/// Whether a fault comes from what no record shows, so that it has to be replayed with
/// [`Board::trip`]. The others are decided again.
pub(super) const fn is_external(fault: Fault) -> bool {
    match fault {
        Fault::EmergencyStop(_)
        | Fault::Temperature
        | Fault::ServoReset
        | Fault::Clock
        | Fault::FirmwareChanged => true,
        // The first two are taken from the mode: they belong into the middle of a
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

/// When a recorded tick was planned to begin, in µs.
pub(super) const fn planned_us(record: &Record) -> u64 {
    record
        .start_us
        .saturating_sub(record.timing.start_error_us as u64)
}

/// Whether the motors are off in this tick.
pub(super) fn is_off(record: &Record) -> bool {
    let off = Pwm::OFF.counts();
    record.pwm_in_force.iter().all(|pwm| *pwm == off)
}

/// Whether every joint has a sample: an estimator that begins anew needs them.
pub(super) fn is_complete(record: &Record) -> bool {
    record
        .samples
        .iter()
        .all(|sample| sample.counts().is_some())
}

/// What a record's mode shows that cannot be decided again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HostEvent {
    /// Nothing of that kind.
    Nothing,
    /// The host was silent for so long that the arm was braked, or let go.
    Silence,
    /// For so long that it was a fault.
    LongSilence,
    /// Numbers in memory had changed.
    Corruption,
}

/// A board that lives through recorded ticks.
pub(super) struct Board {
    core: Core,
    bus: BusFacts,
    is_ticking: bool,
    concluded: VecDeque<Conclusion>,
}

impl Board {
    /// A board that has just begun with these settings.
    ///
    /// # Errors
    /// A [`Refusal`] if no controller exists for the set-up.
    pub(super) fn new(settings: &Settings) -> Result<Self, Refusal> {
        Ok(Self {
            core: Core::new(LoopConfig::build(settings)?, 0),
            bus: BusFacts {
                is_prepared: true,
                least_period_us: 0,
                is_stop_settled: true,
            },
            is_ticking: false,
            concluded: VecDeque::new(),
        })
    }

    /// These settings are in force, whatever was before.
    ///
    /// # Errors
    /// A [`Refusal`] if no controller exists for the set-up; nothing changes then.
    pub(super) fn set(&mut self, settings: &Settings) -> Result<(), Refusal> {
        self.core.replace_config(LoopConfig::build(settings)?);
        Ok(())
    }

    /// What the servos are: a bus that is too slow for the period stretches it.
    pub(super) fn set_line(&mut self, firmware: Firmware, baud: u32, is_ready: bool) {
        let is_prepared = is_ready || firmware == Firmware::Morpheus;
        let readiness = if is_prepared {
            Readiness::Prepared
        } else {
            Readiness::Unknown
        };
        self.bus = BusFacts {
            is_prepared,
            least_period_us: tick_us(firmware, baud, readiness),
            is_stop_settled: true,
        };
    }

    /// The mode is that of this record, whatever it was. After [`Self::begin`], before
    /// its decision.
    pub(super) fn assume(&mut self, record: &Record) {
        let trip = match record.mode {
            Mode::Fault(fault) => {
                let same = self.core.cause().filter(|trip| trip.fault == fault);
                same.or(Some(Trip {
                    fault,
                    joint: None,
                    tick: record.tick,
                    at_us: record.start_us,
                    value: 0.0,
                    limit: 0.0,
                }))
            }
            _ => None,
        };
        self.core.resume_mode(record.mode, trip);
    }

    /// What the record shows of what was before it, for one that is not known to
    /// follow from the one before. After [`Self::begin`], before its decision.
    pub(super) fn assume_before(&mut self, record: &Record) {
        self.core
            .resume_before(record.timing.missed, is_off(record));
    }

    /// Nothing is known of what went on, but that nothing drives the motors.
    pub(super) fn forget(&mut self) {
        self.core.forget();
    }

    /// Goes on from this record, of whose tick all else is unknown.
    pub(super) fn adopt(&mut self, record: &Record) {
        self.assume(record);
        self.is_ticking = true;
        let state = ArmState {
            q: record.angle_rad.into(),
            dq: record.speed_rad_s.into(),
        };
        let reference = [
            record.reference_rad.into(),
            record.reference_speed_rad_s.into(),
        ];
        self.core.resume_after(state, reference);
    }

    /// Bring-up is over, unless ticks go on already.
    pub(super) fn begin_ticking(&mut self) {
        if !self.is_ticking {
            self.is_ticking = true;
            self.core.begin_ticking();
            self.drain();
        }
    }

    /// The bus was another's, and is lined up again: between two ticks of a board that
    /// reported neither.
    pub(super) fn begin_again(&mut self) {
        self.is_ticking = false;
        self.begin_ticking();
    }

    /// Whether ticks go on; otherwise bring-up comes before the next.
    pub(super) fn is_ticking(&self) -> bool {
        self.is_ticking
    }

    /// When the next tick was planned to begin, in µs.
    pub(super) fn planned_us(&self) -> u64 {
        self.core.next_start_us()
    }

    /// What it is doing.
    pub(super) fn mode(&self) -> Mode {
        self.core.mode()
    }

    /// Why it is in a fault.
    pub(super) fn cause(&self) -> Option<Trip> {
        self.core.cause()
    }

    /// What its mode shows beside what is decided again, for the board as it is
    /// before the decision.
    pub(super) fn host_event(&self, recorded: Mode) -> HostEvent {
        let state = self.core.state();
        let before = self.core.drive();
        match (recorded, before) {
            _ if !state.is_armed() => HostEvent::Nothing,
            // It ended by its age.
            (Mode::Running(_) | Mode::Degraded(_) | Mode::Armed, _)
                if self.core.is_command_aged() =>
            {
                HostEvent::Nothing
            }
            (Mode::Fault(Fault::HostSilent), _) => HostEvent::LongSilence,
            (Mode::Fault(Fault::Corrupted), _) => HostEvent::Corruption,
            // An experiment that ends by itself in this tick does so before it heeds that.
            (
                Mode::Running(Drive::Hold) | Mode::Degraded(Drive::Hold),
                Drive::Track | Drive::Experiment,
            )
            | (Mode::Armed, Drive::Torque)
                if state.is_driven() =>
            {
                HostEvent::Silence
            }
            _ => HostEvent::Nothing,
        }
    }

    /// The tick of this record begins.
    pub(super) fn begin(&mut self, inputs: &Record) {
        self.core
            .resume_tick(inputs.tick, inputs.start_us, planned_us(inputs));
        self.core.begin_tick(self.bus.least_period_us);
        self.drain();
    }

    /// Decides the tick that has begun. What is returned is the record as it should
    /// be; what was measured of the tick is copied from `inputs`.
    pub(super) fn decide(&mut self, inputs: &Record, event: HostEvent) -> Record {
        let limits = self.core.config().limits();
        let silent_ms = match event {
            HostEvent::Nothing | HostEvent::Corruption => None,
            HostEvent::Silence => Some(limits.hold_ms),
            HostEvent::LongSilence => Some(limits.silence_ms),
        };
        self.core
            .set_silence(silent_ms.map_or(0, |ms| u64::from(ms) * 1_000 + 1));
        let sampled = TickSamples {
            samples: inputs.samples,
            alarms: inputs.alarms.map(Alarms::from_bits),
            bus_us: inputs.timing.bus_us,
            token: FlowToken::default(),
        };
        let mut record = Record::NONE;
        self.core
            .decide_with(&sampled, event != HostEvent::Corruption, &mut record);
        let missed = record.timing.missed;
        record.dropped = inputs.dropped;
        record.timing = inputs.timing;
        record.timing.missed = missed;
        self.drain();
        record
    }

    /// A host says hello.
    pub(super) fn greet(&mut self, moment: Moment) {
        self.set_time(moment);
        self.core.greet();
        self.drain();
    }

    /// The host leaves.
    pub(super) fn goodbye(&mut self) {
        self.apply(Event::Disarm);
    }

    /// A client of the transparent port takes the bus.
    pub(super) fn hand_over(&mut self) {
        self.apply(Event::ClientCame);
    }

    fn apply(&mut self, event: Event) {
        // Never refused.
        let _ = self.core.apply(event);
        self.drain();
    }

    /// A fault that is decided elsewhere; see [`is_external`].
    pub(super) fn trip(&mut self, trip: &Trip) {
        self.core.set_time(trip.at_us);
        self.core.trip(Violation {
            fault: trip.fault,
            joint: trip.joint,
            value: trip.value,
            limit: trip.limit,
        });
        self.drain();
    }

    /// A motion is asked for at this moment: where does it begin?
    ///
    /// # Errors
    /// Why it cannot be.
    pub(super) fn start_point(&mut self, moment: Moment) -> Result<StartPoint, Refusal> {
        self.set_time(moment);
        self.core.start_point()
    }

    /// The motion is planned, and taken at this moment.
    ///
    /// # Errors
    /// Why it cannot be.
    pub(super) fn follow(
        &mut self,
        motion: &Motion,
        start: StartPoint,
        moment: Moment,
    ) -> Result<(), Refusal> {
        let trajectory = Trajectory::plan(start.from, &motion.shape(), &MOTION)
            .map_err(|error| refusal(&error))?;
        let motion = TimedTrajectory {
            trajectory,
            starts_us: start.at_us,
        };
        self.perform(ValidatedCommand::Follow(motion), moment)
    }

    /// Any other command is taken at this moment. A fault cannot be cleared while motors
    /// are not seen to be off, which no record shows: `recorded` is what the board answered.
    ///
    /// # Errors
    /// Why it cannot be.
    pub(super) fn command(
        &mut self,
        command: Command,
        moment: Moment,
        recorded: Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        self.bus.is_stop_settled = recorded != Err(Refusal::NotOff);
        let session = match command {
            // Whose the session is has been checked.
            Command::Arm { session } => session,
            _ => 0,
        };
        self.perform(validate(command, session, false)?, moment)
    }

    fn perform(&mut self, command: ValidatedCommand, moment: Moment) -> Result<(), Refusal> {
        self.set_time(moment);
        let result = self.core.command(command, self.bus);
        self.drain();
        result
    }

    fn set_time(&mut self, moment: Moment) {
        self.core.set_time(moment.at_us);
    }

    /// How an experiment ended, in order.
    pub(super) fn take_conclusion(&mut self) -> Option<Conclusion> {
        self.concluded.pop_front()
    }

    /// Takes what the core would have the bus do and the host hear.
    fn drain(&mut self) {
        if self.core.take_bus_action().is_some() {
            let state = self.core.state();
            self.is_ticking &= !matches!(state, State::Boot | State::Passthrough);
        }
        let _ = self.core.take_trip();
        self.concluded.extend(self.core.take_conclusion());
    }
}
