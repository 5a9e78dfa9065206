//! A tick of the core: its beginning, its decision when the samples are in, its record.

use super::{Core, TickSamples};
use crate::control_loop::limits::LATE_MAX_US;
use crate::control_loop::{
    ActuatorCommand, CHECK_US, Fallback, Permission, TickInput, TickOutput, Violation,
};
use crate::flow_token::Machine;
use crate::supervisor::{Event, State};
use armbridge_link::experiment::{Conclusion, ExperimentEnd};
use armbridge_link::message::{Fault, Record, Timing};
use armbridge_servo::Alarms;
use armbridge_servo::Pwm;

impl Core {
    /// Whether the tick may feed the watchdog: it began in time, and passed every state
    /// machine.
    pub fn may_feed_watchdog(&self) -> bool {
        self.overruns_in_row == 0 && self.token.is_complete(self.tick)
    }

    /// Period in µs, at least the shortest that the bus allows. A bus that is too slow
    /// for the configured period is read at its own; motors cannot be armed then.
    pub fn period_us(&self, least_period_us: u32) -> u32 {
        self.config.period_us().get().max(least_period_us)
    }

    /// Begins a tick with at least the period that the bus allows: puts the last
    /// decided command in force, and plans the next tick.
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
        if !matches!(
            self.supervisor.permission(),
            Permission::MotorCheck | Permission::Drive
        ) {
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

    /// Decides the tick that has begun, with the result of the integrity check.
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
            host_silent_us: self.now_us.saturating_sub(self.host_frame_us),
            is_config_intact,
            token: sampled.token,
        };
        let output = self.control_loop.step(&self.config, &input);
        self.apply_output(&output);
        self.next = output.command;
        self.decided = self.tick;
        self.record(&input, &output, record);
    }

    /// Passes the outputs of a tick to the supervisor.
    fn apply_output(&mut self, output: &TickOutput) {
        // Samples change no other state.
        let samples = match (self.state(), output.is_complete) {
            (State::Running, false) => Some(Event::SampleLost),
            (State::Degraded, true) => Some(Event::SamplesBack),
            _ => None,
        };
        let fallback = output.fallback.map(|fallback| match fallback {
            Fallback::Brake => Event::Brake,
            Fallback::Release => Event::ZeroTorque,
        });
        self.are_motors_checked |=
            output.are_motors_checked && self.control_loop.is_motor_check_conclusive();
        let checked = output.are_motors_checked.then_some(Event::MotorsChecked);
        for event in [samples, fallback, checked].into_iter().flatten() {
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

    /// Notes the end of an experiment for the host.
    pub(super) fn conclude_experiment(&mut self, end: ExperimentEnd) {
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

    /// Compares sections of the configuration with their check words, in turn, while
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

    /// Begins ticks now: the servos have been found and set up.
    pub fn begin_ticking(&mut self) {
        self.next_start_us = self.now_us;
        self.control_loop.reset_monitors();
        self.control_loop.reset_estimate();
        self.overruns_in_row = 0;
        self.are_motors_checked = false;
        // Never refused.
        let _ = self.apply(Event::BusReady);
    }

    /// Whether the command that drives is too old for the tick under way.
    pub fn is_command_aged(&self) -> bool {
        self.control_loop.is_aged(&self.config, self.next_start_us)
    }
}
