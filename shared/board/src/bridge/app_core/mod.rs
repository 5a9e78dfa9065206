//! The core: supervisor, control loop and configuration, without bus, queues and clock.
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
//! [`Core`] combines supervisor, control loop and configuration. Its outputs are the
//! PWM of each tick and a [`BusAction`] for the bus, a record and the
//! `take` functions for the host. A replay runs the control loop alone.
//!
//! # Contract
//!
//! * [`set_time`](Core::set_time) first, then [`check_state`](Core::check_state) and the
//!   events; a tick is [`begin_tick`](Core::begin_tick), then
//!   [`decide`](Core::decide) when the samples are in.
//! * The command that a tick decides is in force from the beginning of the next, and only
//!   if the supervisor still permits it then.
//! * No function waits or sends: [`Bridge`](super::Bridge) passes a
//!   [`BusAction`] to the sequencer, which stops motors without another call of the core.
//!
//! | module     | content                                                 |
//! |------------|---------------------------------------------------------|
//! | `tick`     | beginning, decision and record of a tick                |
//! | `commands` | commands of the host, accepted or refused               |
//! | `schedule` | number, beginning and lateness of the ticks             |
//! | `integrity` | comparison of the configuration with its check words   |
//!
//! Time is an input, in µs: [`Core::set_time`].

mod commands;
mod integrity;
mod schedule;
mod tick;

use crate::checkpoints::Checkpoints;
use crate::supervisor::{Action, Event, State, Supervisor};
use crate::tick::{ControlLoop, LoopConfig};
use armbridge_control::encoder::Encoder;
use armbridge_link::experiment::Conclusion;
use armbridge_link::message::{Drive, Fault, Missing, Mode, Moment, Refusal, Sample, Trip};
use armbridge_link::record::{Permission, Violation};
use armbridge_servo::{Alarms, JOINTS, Pwm};
use integrity::IntegrityCheck;
use schedule::Schedule;

/// Motors off.
const OFF: [Pwm; JOINTS] = [Pwm::OFF; JOINTS];

/// Action of a transition on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BusAction {
    /// The stop sequence, repeated until every motor is confirmed off.
    Halt,
    /// Motors that have to be off are commanded off again by the ticks, and read back.
    RepeatOff,
    /// The stop sequence, then bring-up.
    Search,
    /// The stop sequence; then the bus is lent to the client.
    HandOver,
}

/// State of the bus, on which arming depends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BusFacts {
    /// Encoder of the servos that were found.
    pub(crate) encoder: Encoder,
    /// Whether the servos take torque.
    pub(crate) is_prepared: bool,
    /// Shortest period in µs that the bus allows.
    pub(crate) least_period_us: u32,
    /// Whether the last stop has concluded: each motor is confirmed off, or the host has been
    /// notified which is not.
    pub(crate) is_stop_settled: bool,
    /// Joint whose servo is too hot to be armed or, after a fault of its temperature, to clear
    /// that.
    pub(crate) hot_joint: Option<u8>,
    /// Reason against arming that the samples show, see [`Core::encoder_refusal`].
    pub(crate) encoder_refusal: Option<Refusal>,
}

/// Memory in which a bit can be turned by [`Core::inject_error`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryRegion {
    /// The configuration.
    Config,
    /// The supervisor's state.
    State,
    /// The drive command.
    Drive,
    /// The numbers of the reference source.
    Reference,
}

/// Results of the exchange of a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TickSamples {
    /// Sample of each servo.
    pub(crate) samples: [Sample; JOINTS],
    /// Alarms of each stock servo.
    pub(crate) alarms: [Alarms; JOINTS],
    /// Duration of the exchange, in µs.
    pub(crate) bus_us: u32,
    /// The tick's checkpoints; the sequencer's is passed.
    pub(crate) checkpoints: Checkpoints,
}

impl TickSamples {
    /// No samples, before the first exchange.
    pub(crate) const NONE: Self = Self {
        samples: [Sample::Missing(Missing::NotAsked); JOINTS],
        alarms: [Alarms::NONE; JOINTS],
        bus_us: 0,
        checkpoints: Checkpoints::begin(0),
    };
}

/// See the [module](self).
#[derive(Clone, Debug)]
pub(crate) struct Core {
    supervisor: Supervisor,
    control_loop: ControlLoop,
    config: LoopConfig,
    integrity: IntegrityCheck,
    schedule: Schedule,
    /// PWM in force, and that of the next tick.
    in_force: [Pwm; JOINTS],
    next: [Pwm; JOINTS],
    /// Whether the next tick is the first since bring-up.
    is_first: bool,
    /// Time of the last frame of the host, in µs.
    host_frame_us: u64,
    overruns_in_row: u8,
    /// Checkpoints of the last decided tick.
    checkpoints: Checkpoints,
    bus_action: Option<BusAction>,
    has_new_trip: bool,
    conclusion: Option<Conclusion>,
    /// Whether the motors have been checked since bring-up and the last change of the
    /// calibration.
    are_motors_checked: bool,
    after_park: AfterPark,
}

/// What may follow on the park that is under way.
#[derive(Clone, Copy, Debug, Default)]
struct AfterPark {
    /// The fault of a host that is silent at its end: the host's silence or an expired command has
    /// begun it.
    is_silence_fault: bool,
    /// A drive command that takes over, which the present session need not arm for: its silence or
    /// an expired command has begun the park, or it has armed since.
    is_takeover: bool,
    /// The restart of the loop, for a host whose session has begun meanwhile.
    is_restart: bool,
}

impl Core {
    /// A core in its initial state, at this time.
    pub(crate) fn new(config: &LoopConfig, now_us: u64) -> Self {
        Self {
            supervisor: Supervisor::default(),
            control_loop: ControlLoop::new(config),
            config: *config,
            integrity: IntegrityCheck::default(),
            schedule: Schedule::new(now_us),
            in_force: OFF,
            next: OFF,
            is_first: false,
            host_frame_us: now_us,
            overruns_in_row: 0,
            checkpoints: Checkpoints::default(),
            bus_action: None,
            has_new_trip: false,
            conclusion: None,
            are_motors_checked: false,
            after_park: AfterPark::default(),
        }
    }

    /// Sets the time, in µs; it never goes back.
    pub(crate) fn set_time(&mut self, now_us: u64) {
        self.schedule.now_us = now_us;
    }

    /// The time that was set last, in µs.
    pub(crate) fn now_us(&self) -> u64 {
        self.schedule.now_us
    }

    /// Planned beginning of the next tick, in µs.
    pub(crate) fn next_start_us(&self) -> u64 {
        self.schedule.next_start_us
    }

    /// Sets the planned beginning of the next tick, in µs.
    pub(crate) fn set_next_start(&mut self, at_us: u64) {
        self.schedule.next_start_us = at_us;
    }

    /// The supervisor's state.
    pub(crate) fn state(&self) -> State {
        self.supervisor.state()
    }

    /// The supervisor's permission for bus and control loop.
    #[inline]
    pub(crate) fn permission(&self) -> Permission {
        self.supervisor.permission()
    }

    /// Mode of the board.
    #[inline]
    pub(crate) fn mode(&self) -> Mode {
        self.supervisor.mode(self.control_loop.drive())
    }

    /// The fault, if one is latched or the state is corrupted.
    pub(crate) fn fault(&self) -> Option<Fault> {
        self.supervisor.fault()
    }

    /// Source that drives the motors while that is permitted.
    pub(crate) fn drive(&self) -> Drive {
        self.control_loop.drive()
    }

    /// Cause of the fault, if one is latched.
    pub(crate) fn cause(&self) -> Option<Trip> {
        self.supervisor.cause()
    }

    /// The configuration.
    pub(crate) fn config(&self) -> &LoopConfig {
        &self.config
    }

    /// Number of the tick under way.
    pub(crate) fn tick(&self) -> u32 {
        self.schedule.tick
    }

    /// Consecutive missing samples of this joint.
    pub(crate) fn lost_in_row(&self, joint: usize) -> u32 {
        self.control_loop.lost_in_row(joint)
    }

    /// Reason against arming, as far as the samples of this session show.
    pub(crate) fn encoder_refusal(&self) -> Option<Refusal> {
        self.control_loop.encoder_refusal(&self.config)
    }

    /// The present moment, for the acknowledgement of a command.
    pub(crate) fn moment(&self) -> Moment {
        Moment {
            tick: self.schedule.tick,
            is_decided: self.schedule.decided == self.schedule.tick,
            at_us: self.schedule.now_us,
            mode: self.mode(),
        }
    }

    /// Whether there is an action on the bus, a new fault or the end of an experiment to take;
    /// most polls have none.
    pub(crate) fn has_actions(&self) -> bool {
        self.bus_action.is_some() || self.has_new_trip || self.conclusion.is_some()
    }

    /// Takes the pending action on the bus.
    pub(crate) fn take_bus_action(&mut self) -> Option<BusAction> {
        self.bus_action.take()
    }

    /// Takes the fault that has been latched since the last call.
    pub(crate) fn take_trip(&mut self) -> Option<Trip> {
        core::mem::take(&mut self.has_new_trip)
            .then(|| self.cause())
            .flatten()
    }

    /// Takes the end of an experiment since the last call.
    pub(crate) fn take_conclusion(&mut self) -> Option<Conclusion> {
        self.conclusion.take()
    }

    /// Notes a frame of the host.
    pub(crate) fn note_host(&mut self) {
        self.host_frame_us = self.schedule.now_us;
    }

    // Events

    /// Latches a fault with its first cause: torque off.
    pub(crate) fn trip(&mut self, violation: Violation) {
        let violation = self.cause_of(violation);
        let action = self.supervisor.trip(Trip {
            fault: violation.fault,
            joint: violation.joint,
            tick: self.schedule.tick,
            at_us: self.schedule.now_us,
            value: violation.value,
            limit: violation.limit,
        });
        if let Some(action) = action {
            self.has_new_trip = true;
            self.perform(action);
        }
    }

    /// The cause of a violation: corrupted parameters, if these may have caused it.
    fn cause_of(&self, violation: Violation) -> Violation {
        if violation.fault.may_be_corruption() && !self.config.is_intact() {
            Violation::plain(Fault::Corrupted)
        } else {
            violation
        }
    }

    /// Applies an event to the supervisor.
    ///
    /// # Errors
    /// The refusal for the host; the state is unchanged.
    pub(crate) fn apply(&mut self, event: Event) -> Result<(), Refusal> {
        let action = self.supervisor.apply(event)?;
        self.perform(action);
        Ok(())
    }

    /// Carries out an action of the supervisor.
    fn perform(&mut self, action: Action) {
        let bus_action = match action {
            Action::Keep | Action::Hold => return,
            Action::SwitchOff | Action::Energise => {
                self.next = OFF;
                return;
            }
            Action::Repeat => {
                // The next tick is soon enough, and an action before it goes further.
                self.bus_action.get_or_insert(BusAction::RepeatOff);
                return;
            }
            Action::Halt => {
                self.next = OFF;
                BusAction::Halt
            }
            Action::Search => BusAction::Search,
            Action::HandOver => BusAction::HandOver,
        };
        // The bus action does not wait for the next tick.
        self.schedule.start_now();
        self.bus_action = Some(bus_action);
    }

    /// Turns a bit of the memory on which ticks depend, chosen by `draw`, for tests.
    pub(crate) fn inject_error(&mut self, region: MemoryRegion, draw: u32) {
        match region {
            MemoryRegion::Config => self.config.inject_error(draw),
            MemoryRegion::State => self.supervisor.inject_error(draw),
            MemoryRegion::Drive => self.control_loop.inject_error(draw),
            MemoryRegion::Reference => self.control_loop.inject_reference_error(draw),
        }
    }

    /// Trips if the state word is invalid.
    pub(crate) fn check_state(&mut self) {
        if !self.supervisor.is_intact() {
            self.trip(Violation::plain(Fault::Corrupted));
        }
    }
}
