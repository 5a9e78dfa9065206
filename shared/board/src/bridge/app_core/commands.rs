//! Commands of the host, accepted or refused; see [`Core::command`].

use super::{BusFacts, Core};
use crate::bridge::command::ValidatedCommand;
use crate::supervisor::{Event, State};
use crate::tick::limits::CHECK_PERIOD_MAX_US;
use crate::tick::reference::StartPoint;
use crate::tick::{ControlConfig, DriveRequest, Instant};
use armbridge_link::experiment::ExperimentEnd;
use armbridge_link::message::{Drive, Fault, Limits, Refusal};

impl Core {
    /// The present instant for the control loop.
    fn instant(&self) -> Instant {
        Instant {
            us: self.schedule.now_us,
            acts_us: self.schedule.next_start_us,
            is_driven: self.state().is_driven(),
        }
    }

    /// Start point of a motion that is requested now.
    ///
    /// # Errors
    /// The refusal for the host.
    pub(crate) fn start_point(&self) -> Result<StartPoint, Refusal> {
        self.supervisor.check(Event::Drive)?;
        Ok(self.control_loop.start_point(self.instant()))
    }

    /// Takes a command, all but those that are for the bus alone.
    ///
    /// # Errors
    /// The refusal for the host; the state is unchanged.
    pub(crate) fn command(
        &mut self,
        command: &ValidatedCommand,
        bus: BusFacts,
    ) -> Result<(), Refusal> {
        let now = self.instant();
        match command {
            ValidatedCommand::Idle => {
                self.replace_experiment(now.is_driven);
                self.apply(Event::Disarm)
            }
            ValidatedCommand::Park => {
                self.replace_experiment(now.is_driven);
                self.leave()
            }
            ValidatedCommand::Arm => self.arm(bus),
            // A stop that has not concluded is not cleared.
            ValidatedCommand::ClearFault
                if self.state() == State::Fault && !bus.is_stop_settled =>
            {
                Err(Refusal::NotOff)
            }
            ValidatedCommand::ClearFault => self.clear_fault(bus),
            ValidatedCommand::Drive(request) => self.drive_by(request, now),
            ValidatedCommand::Prepare if bus.is_prepared => self.supervisor.check(Event::Prepare),
            ValidatedCommand::Prepare => self.apply(Event::Prepare),
            ValidatedCommand::Release => self.apply(Event::Release),
            ValidatedCommand::Install(control) => self.install(control),
            ValidatedCommand::Limit(limits) => self.limit(*limits),
            ValidatedCommand::StartPoint => Ok(()),
            ValidatedCommand::Save => self.apply(Event::Keep),
        }
    }

    /// Drives the arm as requested; ends an experiment that the request replaces.
    fn drive_by(&mut self, request: &DriveRequest, now: Instant) -> Result<(), Refusal> {
        self.supervisor.check(Event::Drive)?;
        if self.state() == State::Parking && !self.after_park.is_takeover {
            return Err(Refusal::Disarmed);
        }
        let goes_on = matches!(
            request,
            DriveRequest::Experiment(plan) if self.control_loop.is_running(plan, now.is_driven)
        );
        let is_experimenting = now.is_driven && self.drive() == Drive::Experiment;
        self.control_loop.request(&self.config, request, now)?;
        if is_experimenting && !goes_on {
            self.conclude_experiment(ExperimentEnd::Replaced);
        }
        self.apply(Event::Drive)
    }

    /// Clears the fault; one of a temperature, if the servo has cooled.
    #[inline(never)]
    fn clear_fault(&mut self, bus: BusFacts) -> Result<(), Refusal> {
        let is_heat = self
            .cause()
            .is_some_and(|trip| trip.fault == Fault::Temperature);
        match bus.hot_joint {
            Some(joint) if is_heat => Err(Refusal::Hot { joint }),
            Some(_) | None => self.apply(Event::ClearFault),
        }
    }

    /// Arms, if the servos are cool and take torque at the configured period, if the
    /// encoders are known and within the limits, and if the motors have been checked, can be, or
    /// need not be.
    #[inline(never)]
    fn arm(&mut self, bus: BusFacts) -> Result<(), Refusal> {
        self.supervisor.check(Event::Arm)?;
        if let Some(joint) = bus.hot_joint {
            return Err(Refusal::Hot { joint });
        }
        if !bus.is_prepared {
            return Err(Refusal::Unprepared);
        }
        if let Some(joint) = self.config.joint_of_other(bus.encoder) {
            return Err(Refusal::OtherEncoder { joint });
        }
        let least_us = bus.least_period_us;
        if self.config.period_us().get() < least_us {
            return Err(Refusal::TooFast { least_us });
        }
        bus.encoder_refusal.map_or(Ok(()), Err)?;
        let is_check_due = !self.are_motors_checked && self.config.limits().check_rad_s2 > 0;
        if is_check_due && self.config.period_us().get() > CHECK_PERIOD_MAX_US {
            return Err(Refusal::MotorsUnchecked);
        }
        let was_idle = self.state() == State::Idle;
        self.apply(if is_check_due {
            Event::CheckMotors
        } else {
            Event::Arm
        })?;
        if was_idle {
            self.control_loop.energise();
        }
        self.after_park.is_takeover = true;
        Ok(())
    }

    /// Ends an experiment that another command replaces.
    fn replace_experiment(&mut self, was_driven: bool) {
        if was_driven && self.control_loop.drive() == Drive::Experiment {
            self.conclude_experiment(ExperimentEnd::Replaced);
        }
    }

    /// Replaces the set-up, without a step in the torque.
    #[inline(never)]
    fn install(&mut self, control: &ControlConfig) -> Result<(), Refusal> {
        self.apply(Event::Configure)?;
        let state = self.state();
        let is_driven = state.is_driven();
        let is_experimenting = is_driven && self.control_loop.drive() == Drive::Experiment;
        let is_other_period = control.period_us() != self.config.period_us();
        let is_other_servo = !self.config.has_joints(control);
        if is_experimenting || (state.is_armed() && (is_other_period || is_other_servo)) {
            return Err(Refusal::NotIdle);
        }
        self.are_motors_checked &= !is_other_servo;
        let config = self.config.with_control(control);
        self.control_loop.install(
            &self.config,
            &config,
            is_driven,
            self.schedule.next_start_us,
        );
        self.config = config;
        Ok(())
    }

    /// Replaces the limits.
    #[inline(never)]
    fn limit(&mut self, limits: Limits) -> Result<(), Refusal> {
        self.apply(Event::Keep)?;
        self.config = self.config.with_limits(limits);
        self.control_loop.restart_monitors();
        Ok(())
    }

    /// Ends what drives the arm: parks it if it has a pose for that, and disarms otherwise.
    pub(crate) fn leave(&mut self) -> Result<(), Refusal> {
        let parks = self.state().is_driven() && self.config.limits().park.is_some();
        // A host that leaves, or is new, is not silent; and one that is new has not armed.
        self.after_park.is_silence_fault = false;
        self.after_park.is_takeover = false;
        self.apply(if parks { Event::Park } else { Event::Disarm })
    }

    /// Begins the session of a host: parks the arm or disarms, because another host may have
    /// armed.
    pub(crate) fn begin_session(&mut self) {
        // A client has the bus until it leaves, whichever host there is.
        if self.state() != State::Passthrough {
            // Never refused.
            let _ = self.leave();
        }
        if self.state() == State::Parking {
            // The loop restarts when the arm has been parked.
            self.after_park.is_restart = true;
            return;
        }
        // Earlier estimates are in no log of this host. After a fault the monitors know which servo
        // may be deaf.
        if self.state() == State::Fault {
            self.control_loop.reset_estimate();
        } else {
            self.control_loop.restart();
        }
    }
}
