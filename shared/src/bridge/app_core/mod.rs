//! The core: everything that decides, without bus, queues and clock.
//!
//! ```text
//!   commands --> validated --> Supervisor --- permission ---> ControlLoop --> command
//!                                  ^  |                            |      \-> record
//!   samples  --- TickSamples ------+--+----------------------------+
//!                                  +--- faults, lost samples ------+
//!                                  |
//!                                  +--> BusAction
//! ```
//!
//! [`Core`] joins supervisor, control loop and configuration. Its outputs are the
//! [`ActuatorCommand`] of each tick and a [`BusAction`] for the bus, a record and the
//! `take` functions for the host. Boards run it, and so does the host's replay.
//!
//! # Contract
//!
//! * [`set_time`](Core::set_time) first, then [`check_state`](Core::check_state) and what
//!   has happened; a tick is [`begin_tick`](Core::begin_tick), then
//!   [`decide`](Core::decide) when the samples are in.
//! * The command that a tick decides is in force from the beginning of the next, and only
//!   if the supervisor still permits it then.
//! * Nothing waits here and nothing is sent: [`Bridge`](super::Bridge) carries a
//!   [`BusAction`] to the sequencer, which stops motors without asking the core again.
//!
//! | module     | what                                                    |
//! |------------|---------------------------------------------------------|
//! | `tick`     | a tick begins, is decided, is recorded                  |
//! | `commands` | commands of the host, taken or refused                  |
//! | `resume`   | the state of a recorded tick, for replay                |
//!
//! Time is passed in, in µs: [`Core::set_time`].

mod commands;
mod resume;
mod tick;

use crate::JOINTS;
use crate::control_loop::{ActuatorCommand, ControlLoop, LoopConfig, Violation};
use crate::flow_token::FlowToken;
use crate::link::experiment::Conclusion;
use crate::link::message::{Drive, Fault, Missing, Mode, Moment, Refusal, Sample, Timing, Trip};
use crate::servo::protocol1::Alarms;
use crate::supervisor::{Action, Event, State, Supervisor};

/// What a transition asks of the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusAction {
    /// The stop sequence, again and again until the servos stand.
    Halt,
    /// The stop sequence, then bring-up.
    Search,
    /// The stop sequence; the bus is the client's then.
    HandOver,
}

/// What the bus can do: decides whether motors may be armed.
#[derive(Clone, Copy, Debug)]
pub struct BusFacts {
    /// The servos take torque.
    pub is_prepared: bool,
    /// Shortest period in µs at which they can be asked.
    pub least_period_us: u32,
    /// After a stop, each motor has been seen to be off, or the host has been notified which
    /// has not.
    pub is_stop_settled: bool,
}

/// Memory in which a bit can be turned by [`Core::inject_error`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryRegion {
    /// The configuration.
    Config,
    /// The supervisor's state.
    State,
    /// What drives the motors.
    Drive,
    /// The numbers of the reference source.
    Reference,
}

/// What the bus brought in a tick.
#[derive(Clone, Copy, Debug)]
pub struct TickSamples {
    /// What each servo answered.
    pub samples: [Sample; JOINTS],
    /// What each stock servo complained of.
    pub alarms: [Alarms; JOINTS],
    /// How long the exchange took, in µs.
    pub bus_us: u32,
    /// The tick's token, with the sequencer's stamp.
    pub token: FlowToken,
}

impl TickSamples {
    /// Before anything was asked.
    pub const NONE: Self = Self {
        samples: [Sample::Missing(Missing::NotAsked); JOINTS],
        alarms: [Alarms::NONE; JOINTS],
        bus_us: 0,
        token: FlowToken::begin(0),
    };
}

/// See the [module](self).
#[derive(Clone, Debug)]
pub struct Core {
    supervisor: Supervisor,
    control_loop: ControlLoop,
    config: LoopConfig,
    integrity: IntegrityCheck,
    in_force: ActuatorCommand,
    next: ActuatorCommand,
    /// When the next tick is to begin, in µs.
    next_start_us: u64,
    now_us: u64,
    heard_us: u64,
    tick: u32,
    /// The tick that was decided last.
    decided: u32,
    start_us: u64,
    timing: Timing,
    overruns_in_row: u8,
    /// Of the tick that was decided last.
    token: FlowToken,
    bus_action: Option<BusAction>,
    has_new_trip: bool,
    conclusion: Option<Conclusion>,
}

/// Which part of the configuration is compared with its check word when.
#[derive(Clone, Copy, Debug, Default)]
struct IntegrityCheck {
    section: u32,
    wait: u32,
}

impl Core {
    /// A core that knows nothing of servos and arm, at this time.
    pub fn new(config: LoopConfig, now_us: u64) -> Self {
        Self {
            supervisor: Supervisor::default(),
            control_loop: ControlLoop::new(&config),
            config,
            integrity: IntegrityCheck::default(),
            in_force: ActuatorCommand::OFF,
            next: ActuatorCommand::OFF,
            next_start_us: now_us,
            now_us,
            heard_us: now_us,
            tick: 0,
            decided: 0,
            start_us: 0,
            timing: Timing::default(),
            overruns_in_row: 0,
            token: FlowToken::default(),
            bus_action: None,
            has_new_trip: false,
            conclusion: None,
        }
    }

    /// The time is this, in µs; it never goes back.
    pub fn set_time(&mut self, now_us: u64) {
        self.now_us = now_us;
    }

    /// The time that was set last, in µs.
    pub fn now_us(&self) -> u64 {
        self.now_us
    }

    /// When the next tick is to begin, in µs.
    pub fn next_start_us(&self) -> u64 {
        self.next_start_us
    }

    /// Has the next tick, or what comes before it, begin at this time.
    pub fn set_next_start(&mut self, at_us: u64) {
        self.next_start_us = at_us;
    }

    /// The supervisor's state.
    pub fn state(&self) -> State {
        self.supervisor.state()
    }

    /// What the board is doing.
    pub fn mode(&self) -> Mode {
        self.supervisor.mode(self.control_loop.drive())
    }

    /// What drives the motors while that is permitted.
    pub fn drive(&self) -> Drive {
        self.control_loop.drive()
    }

    /// Why there is a fault, if there is one.
    pub fn cause(&self) -> Option<Trip> {
        self.supervisor.cause()
    }

    /// What ticks compute with.
    pub fn config(&self) -> &LoopConfig {
        &self.config
    }

    /// Number of the tick under way.
    pub fn tick(&self) -> u32 {
        self.tick
    }

    /// Samples of this joint that are missing in a row.
    pub fn lost_in_row(&self, joint: usize) -> u32 {
        self.control_loop.lost_in_row(joint)
    }

    /// The moment at which a command is taken, for its acknowledgement.
    pub fn moment(&self) -> Moment {
        Moment {
            tick: self.tick,
            is_decided: self.decided == self.tick,
            at_us: self.now_us,
        }
    }

    /// What the bus is to do, once.
    pub fn take_bus_action(&mut self) -> Option<BusAction> {
        self.bus_action.take()
    }

    /// A fault that has just been latched, once.
    pub fn take_trip(&mut self) -> Option<Trip> {
        core::mem::take(&mut self.has_new_trip)
            .then(|| self.cause())
            .flatten()
    }

    /// How an experiment ended, once.
    pub fn take_conclusion(&mut self) -> Option<Conclusion> {
        self.conclusion.take()
    }

    /// A frame of the host was received.
    pub fn note_host(&mut self) {
        self.heard_us = self.now_us;
    }

    // Events

    /// Torque off, latched with its first cause.
    pub fn trip(&mut self, violation: Violation) {
        let violation = self.cause_of(violation);
        let action = self.supervisor.trip(Trip {
            fault: violation.fault,
            joint: violation.joint,
            tick: self.tick,
            at_us: self.now_us,
            value: violation.value,
            limit: violation.limit,
        });
        if let Some(action) = action {
            self.has_new_trip = true;
            self.act(action);
        }
    }

    /// A violation may come of numbers in memory that have changed: such numbers make
    /// an arm run away.
    fn cause_of(&self, violation: Violation) -> Violation {
        let is_of_numbers = match violation.fault {
            Fault::AngleLimit
            | Fault::SpeedLimit
            | Fault::TorqueLimit
            | Fault::TorqueRate
            | Fault::PwmLimit
            | Fault::DeadZone
            | Fault::Diverged
            | Fault::Stuck
            | Fault::NotFinite => true,
            Fault::EmergencyStop(_)
            | Fault::HostSilent
            | Fault::Temperature
            | Fault::ServoSilent
            | Fault::ServoReset
            | Fault::SamplesLost
            | Fault::SamplesRare
            | Fault::Overrun
            | Fault::Clock
            | Fault::ServoAlarm
            | Fault::FirmwareChanged
            | Fault::Corrupted => false,
        };
        if is_of_numbers && !self.config.is_intact() {
            Violation::plain(Fault::Corrupted)
        } else {
            violation
        }
    }

    /// Takes an event.
    ///
    /// # Errors
    /// The refusal for the host; nothing has changed then.
    pub fn apply(&mut self, event: Event) -> Result<(), Refusal> {
        let action = self.supervisor.apply(event)?;
        self.act(action);
        Ok(())
    }

    fn act(&mut self, action: Action) {
        let bus_action = match action {
            Action::Keep | Action::Hold => return,
            Action::SwitchOff => {
                self.next = ActuatorCommand::OFF;
                return;
            }
            Action::Energise => {
                self.next = ActuatorCommand::OFF;
                self.control_loop.reset_command(self.now_us);
                self.control_loop.reset_monitors();
                self.control_loop.reset_estimate();
                return;
            }
            Action::Halt => {
                self.next = ActuatorCommand::OFF;
                BusAction::Halt
            }
            Action::Search => BusAction::Search,
            Action::HandOver => BusAction::HandOver,
        };
        // What is to come does not wait for the next tick.
        self.next_start_us = self.now_us;
        self.bus_action = Some(bus_action);
    }

    /// Turns a bit of the memory that ticks are decided from, chosen by `draw`: for tests
    /// of what becomes of it.
    pub fn inject_error(&mut self, region: MemoryRegion, draw: u32) {
        match region {
            MemoryRegion::Config => self.config.inject_error(draw),
            MemoryRegion::State => self.supervisor.inject_error(draw),
            MemoryRegion::Drive => self.control_loop.inject_error(draw),
            MemoryRegion::Reference => self.control_loop.inject_reference_error(draw),
        }
    }

    /// A state that is none is a fault.
    pub fn check_state(&mut self) {
        if !self.supervisor.is_intact() {
            self.trip(Violation::plain(Fault::Corrupted));
        }
    }

    // Replay
}
