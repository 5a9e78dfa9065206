//! The core: everything that decides, without bus, queues and clock.
//!
//! It joins supervisor, control loop and configuration: takes commands, begins ticks,
//! decides them. What it decides for the bus comes out as [`BusAction`], what the host
//! is to be told as [`Record`] and the `take` functions. Board and replay run it.
//!
//! Time is passed in, in µs: [`Core::set_time`].

use super::command::ValidatedCommand;
use crate::JOINTS;
use crate::actuator::Pwm;
use crate::arm::State as ArmState;
use crate::control::Reference;
use crate::control_loop::limits::LATE_MAX_US;
use crate::control_loop::reference::{ReferenceSource, StartPoint};
use crate::control_loop::{
    ActuatorCommand, CHECK_US, ControlConfig, ControlLoop, Fallback, Instant, LoopConfig,
    TickInput, TickOutput, Violation,
};
use crate::flow_token::{FlowToken, Machine};
use crate::link::experiment::{Conclusion, Experiment, ExperimentEnd};
use crate::link::message::{
    Drive, Fault, Limits, Missing, Mode, Moment, Record, Refusal, Sample, Timing, Trip,
};
use crate::servo::protocol1::Alarms;
use crate::supervisor::{Action, Event, State, Supervisor};
use nalgebra::Vector2;

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
    /// After a stop, each motor has been seen to be off, or the host has been told which
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
    trip_news: bool,
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
            trip_news: false,
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

    /// Whether the tick may feed the watchdog: it began in time, and went through every
    /// machine.
    pub fn is_tick_good(&self) -> bool {
        self.overruns_in_row == 0 && self.token.is_complete(self.tick)
    }

    /// Now, as the host is told when a command was taken.
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
        core::mem::take(&mut self.trip_news)
            .then(|| self.cause())
            .flatten()
    }

    /// How an experiment ended, once.
    pub fn take_conclusion(&mut self) -> Option<Conclusion> {
        self.conclusion.take()
    }

    /// The host was heard.
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
            self.trip_news = true;
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
    /// What the host is told.
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

    /// A host says hello: what another host has armed is not for this one.
    pub fn greet(&mut self) {
        if self.state().is_armed() {
            // Never refused.
            let _ = self.apply(Event::Disarm);
        }
        // What was before is in no log of this host.
        self.control_loop.reset_estimate();
        // After a fault the monitors know which servo may be deaf.
        if self.state() != State::Fault {
            self.control_loop.reset_monitors();
        }
    }

    /// The servos are lined up: ticks begin now.
    pub fn begin_ticking(&mut self) {
        self.next_start_us = self.now_us;
        self.control_loop.reset_monitors();
        self.control_loop.reset_estimate();
        self.overruns_in_row = 0;
        // Never refused.
        let _ = self.apply(Event::BusReady);
    }

    // The tick

    /// The period in µs on a bus that allows periods of so much. One that is too slow
    /// for the configured period is read as fast as it goes; no torque comes on then.
    pub fn period_us(&self, least_period_us: u32) -> u32 {
        self.config.period_us().get().max(least_period_us)
    }

    /// Begins a tick on a bus that allows periods of so much: puts the command that
    /// was decided last in force, and plans the next tick.
    pub fn begin_tick(&mut self, least_period_us: u32) -> ActuatorCommand {
        let period_us = u64::from(self.period_us(least_period_us));
        let late_us = self.now_us.saturating_sub(self.next_start_us);
        let missed = if late_us < period_us {
            0
        } else {
            late_us.checked_div(period_us).unwrap_or(0)
        };
        self.next_start_us += (missed + 1) * period_us;
        if missed > 0 && self.state().is_armed() {
            self.overruns_in_row = self.overruns_in_row.saturating_add(1);
            if self.overruns_in_row >= self.config.limits().overruns || late_us > LATE_MAX_US {
                self.trip(Violation {
                    value: late_us as f32 * 1e-6,
                    limit: period_us as f32 * 1e-6,
                    ..Violation::plain(Fault::Overrun)
                });
            }
        } else {
            self.overruns_in_row = 0;
        }
        if !self.state().is_driven() {
            self.next = ActuatorCommand::OFF;
        }
        self.in_force = self.next;
        self.tick = self.tick.wrapping_add(1);
        self.start_us = self.now_us;
        self.timing = Timing {
            start_error_us: late_us as u32,
            missed: self.timing.missed.wrapping_add(missed as u32),
            ..Timing::default()
        };
        self.in_force
    }

    /// Decides the tick that has begun, and makes its record of inputs and outputs.
    pub fn decide(&mut self, sampled: &TickSamples, record: &mut Record) {
        let is_config_intact = self.check_integrity();
        self.decide_with(sampled, is_config_intact, record);
    }

    /// Decides the tick that has begun, with a configuration that is known to be intact
    /// or not.
    pub fn decide_with(
        &mut self,
        sampled: &TickSamples,
        is_config_intact: bool,
        record: &mut Record,
    ) {
        self.timing.bus_us = sampled.bus_us;
        let input = TickInput {
            samples: sampled.samples,
            alarms: sampled.alarms,
            in_force: self.in_force,
            acts_us: self.next_start_us,
            permission: self.supervisor.permission(),
            host_silent_us: self.now_us.saturating_sub(self.heard_us),
            is_config_intact,
            token: sampled.token,
        };
        let output = self.control_loop.step(&self.config, &input);
        self.conclude(&output);
        self.next = output.command;
        self.decided = self.tick;
        self.record(&input, &output, record);
    }

    /// What the supervisor makes of a tick's outputs.
    fn conclude(&mut self, output: &TickOutput) {
        let event = if output.is_complete {
            Event::SamplesBack
        } else {
            Event::SampleLost
        };
        let fallback = output.fallback.map(|fallback| match fallback {
            Fallback::Brake => Event::Brake,
            Fallback::Release => Event::Slacken,
        });
        for event in [Some(event), fallback].into_iter().flatten() {
            // Never refused.
            let _ = self.apply(event);
        }
        if let Some(end) = output.experiment_end {
            self.conclude_experiment(end);
        }
        if let Some(violation) = output.fault {
            self.trip(violation);
        }
        self.token = output.token.stamp(Machine::Supervisor);
    }

    fn conclude_experiment(&mut self, end: ExperimentEnd) {
        let tick = self.tick;
        self.conclusion = Some(Conclusion { tick, end });
    }

    fn record(&self, input: &TickInput, output: &TickOutput, record: &mut Record) {
        *record = Record {
            tick: self.tick,
            start_us: self.start_us,
            mode: self.mode(),
            guards: output.guards,
            samples: input.samples,
            alarms: input.alarms.map(Alarms::bits),
            pwm_in_force: input.in_force.pwm.map(Pwm::counts),
            pwm_next: output.command.pwm.map(Pwm::counts),
            reference_rad: output.reference.q.into(),
            reference_speed_rad_s: output.reference.dq.into(),
            angle_rad: output.estimate.q.into(),
            speed_rad_s: output.estimate.dq.into(),
            torque_nm: output.command.torque_nm.into(),
            disturbance_nm: output.disturbance_nm,
            timing: self.timing,
            dropped: record.dropped,
        };
    }

    /// Compares a part of the configuration with its check word, by turns, while
    /// motors may be driven.
    fn check_integrity(&mut self) -> bool {
        const { assert!(CHECK_US < 10_000) };
        if !self.state().is_armed() {
            return true;
        }
        let check = &mut self.integrity;
        if let Some(wait) = check.wait.checked_sub(1) {
            check.wait = wait;
            return true;
        }
        let (sections, ticks) = self.config.check_pace();
        check.wait = ticks - 1;
        (0..sections).all(|_| {
            check.section = check.section.wrapping_add(1);
            self.config.check_section(check.section)
        })
    }

    /// Turns a bit of the memory that ticks are decided from, chosen by `draw`: for tests
    /// of what becomes of it.
    pub fn inject_error(&mut self, region: MemoryRegion, draw: u32) {
        match region {
            MemoryRegion::Config => self.config.inject_error(draw),
            MemoryRegion::State => self.supervisor.inject_error(draw),
            MemoryRegion::Drive => self.control_loop.inject_error(draw),
        }
    }

    /// A state that is none is a fault.
    pub fn check_state(&mut self) {
        if !self.supervisor.is_intact() {
            self.trip(Violation::plain(Fault::Corrupted));
        }
    }

    /// Whether what drives was commanded too long ago for the tick under way.
    pub fn is_command_aged(&self) -> bool {
        self.control_loop.is_aged(&self.config, self.next_start_us)
    }

    // Commands

    fn instant(&self) -> Instant {
        Instant {
            us: self.now_us,
            acts_us: self.next_start_us,
            is_driven: self.state().is_driven(),
        }
    }

    /// Where a motion that is asked for now would begin.
    ///
    /// # Errors
    /// Why there may be none.
    pub fn start_point(&self) -> Result<StartPoint, Refusal> {
        self.supervisor.check(Event::Drive)?;
        Ok(self.control_loop.start_point(self.instant()))
    }

    /// Takes a command, all but those that are for the bus alone.
    ///
    /// # Errors
    /// Why not; nothing has changed then.
    pub fn command(&mut self, command: ValidatedCommand, bus: BusFacts) -> Result<(), Refusal> {
        let now = self.instant();
        match command {
            ValidatedCommand::Idle => {
                self.replace_experiment(now.is_driven);
                self.apply(Event::Disarm)
            }
            ValidatedCommand::Arm => self.arm(bus),
            // A stop that has come to no end is not cleared.
            ValidatedCommand::ClearFault
                if self.state() == State::Fault && !bus.is_stop_settled =>
            {
                Err(Refusal::NotOff)
            }
            ValidatedCommand::ClearFault => self.apply(Event::ClearFault),
            ValidatedCommand::Torque(torque_nm) => {
                self.begin_drive()?;
                self.control_loop.hold_torque(torque_nm, now.us);
                Ok(())
            }
            ValidatedCommand::Regulate(angle_rad) => {
                let source = ReferenceSource::hold(angle_rad.into());
                self.follow(Drive::Regulate, source)
            }
            ValidatedCommand::Follow(motion) => {
                self.supervisor.check(Event::Drive)?;
                let source = self.control_loop.with_motion(motion, now)?;
                self.follow(Drive::Track, source)
            }
            ValidatedCommand::Stream(point) => {
                self.supervisor.check(Event::Drive)?;
                let source = self.control_loop.with_point(point, now)?;
                self.follow(Drive::Track, source)
            }
            ValidatedCommand::Experiment(plan) => self.begin_experiment(plan),
            ValidatedCommand::Prepare if bus.is_prepared => self.supervisor.check(Event::Prepare),
            ValidatedCommand::Prepare => self.apply(Event::Prepare),
            ValidatedCommand::Release => self.apply(Event::Release),
            ValidatedCommand::Install(control) => self.install(&control),
            ValidatedCommand::Limit(limits) => self.limit(limits),
            ValidatedCommand::StartPoint => Ok(()),
            ValidatedCommand::Save => self.apply(Event::Keep),
        }
    }

    /// The servos can be given torque as often as the set-up wants.
    fn arm(&mut self, bus: BusFacts) -> Result<(), Refusal> {
        self.supervisor.check(Event::Arm)?;
        if !bus.is_prepared {
            return Err(Refusal::Unprepared);
        }
        let least_us = bus.least_period_us;
        if self.config.period_us().get() < least_us {
            return Err(Refusal::TooFast { least_us });
        }
        self.apply(Event::Arm)
    }

    /// Motors may be driven from now on, by something else than before.
    fn begin_drive(&mut self) -> Result<(), Refusal> {
        let was_driven = self.state().is_driven();
        self.apply(Event::Drive)?;
        self.replace_experiment(was_driven);
        Ok(())
    }

    fn follow(&mut self, drive: Drive, source: ReferenceSource) -> Result<(), Refusal> {
        let now = self.instant();
        self.begin_drive()?;
        self.control_loop.follow(&self.config, drive, source, now);
        Ok(())
    }

    /// Something else is asked of the arm.
    fn replace_experiment(&mut self, was_driven: bool) {
        if was_driven && self.control_loop.drive() == Drive::Experiment {
            self.conclude_experiment(ExperimentEnd::Replaced);
        }
    }

    #[inline(never)]
    fn begin_experiment(&mut self, plan: Experiment) -> Result<(), Refusal> {
        self.supervisor.check(Event::Drive)?;
        let now = self.instant();
        if self.control_loop.is_running(&plan, now.is_driven) {
            return Ok(());
        }
        let source = self
            .control_loop
            .admit(&self.config, &plan, now)
            .map_err(Refusal::Experiment)?;
        self.begin_drive()?;
        self.control_loop
            .begin_experiment(&self.config, plan, source, now);
        Ok(())
    }

    /// Replaces the set-up, without a step in the torque if that is on.
    fn install(&mut self, control: &ControlConfig) -> Result<(), Refusal> {
        self.apply(Event::Configure)?;
        let state = self.state();
        let is_driven = state.is_driven();
        let is_experimenting = is_driven && self.control_loop.drive() == Drive::Experiment;
        let is_other_period = control.period_us() != self.config.period_us();
        if is_experimenting || (state.is_armed() && is_other_period) {
            return Err(Refusal::NotIdle);
        }
        let config = self.config.with_control(control);
        self.control_loop
            .install(&self.config, &config, is_driven, self.next_start_us);
        self.config = config;
        Ok(())
    }

    fn limit(&mut self, limits: Limits) -> Result<(), Refusal> {
        self.apply(Event::Keep)?;
        self.config = self.config.with_limits(limits);
        self.control_loop.reset_monitors();
        Ok(())
    }

    // Replay

    /// These settings are in force, whatever was before.
    pub fn replace_config(&mut self, config: LoopConfig) {
        self.control_loop.install(&self.config, &config, false, 0);
        self.control_loop.reset_monitors();
        self.config = config;
    }

    /// The tick of a record begins: `tick` and its times are the record's.
    pub fn resume_tick(&mut self, tick: u32, start_us: u64, planned_us: u64) {
        self.tick = tick.wrapping_sub(1);
        self.now_us = start_us;
        self.next_start_us = planned_us;
    }

    /// The mode is this, whatever it was.
    pub fn resume_mode(&mut self, mode: Mode, trip: Option<Trip>) {
        self.supervisor.resume(mode, trip);
        if let Some(drive) = mode.drive() {
            self.control_loop.set_drive(drive);
        }
    }

    /// Of the tick under way: ticks missed so far, and motors that were off.
    pub fn resume_before(&mut self, missed: u32, is_off: bool) {
        self.timing.missed = missed;
        if is_off {
            self.in_force = ActuatorCommand::OFF;
        }
    }

    /// What the tick under way estimated and asked for is this.
    pub fn resume_after(&mut self, state: ArmState<f32>, reference: [Vector2<f32>; 2]) {
        let [q, dq] = reference;
        let reference = Reference {
            q,
            dq,
            ddq: Vector2::zeros(),
        };
        self.control_loop.resume(state, reference);
        if !self.state().is_driven() {
            self.next = ActuatorCommand::OFF;
        }
    }

    /// Nothing is known of what went on, but that nothing drives the motors.
    pub fn forget(&mut self) {
        self.supervisor.resume(Mode::Idle, None);
        self.next = ActuatorCommand::OFF;
    }

    /// The host has been silent for so long, in µs.
    pub fn set_silence(&mut self, silent_us: u64) {
        self.now_us = self.now_us.max(silent_us);
        self.heard_us = self.now_us.saturating_sub(silent_us);
    }
}
