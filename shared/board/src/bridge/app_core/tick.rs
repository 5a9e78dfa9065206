//! A tick of the core: its beginning, its decision when the samples are in, its record.

use super::{Core, OFF, TickSamples};
use crate::checkpoints::Machine;
use crate::supervisor::{Event, State};
use crate::tick::limits::LATE_MAX_US;
use crate::tick::{host_silence, step};
use armbridge_link::experiment::{Conclusion, ExperimentEnd};
use armbridge_link::message::{Fault, Record};
use armbridge_link::record::{Fallback, TickInput, TickOutput, Violation};
use armbridge_servo::{Alarms, JOINTS, Pwm};

impl Core {
    /// Whether the tick may feed the watchdog: it began in time, and passed every state
    /// machine.
    pub(crate) fn may_feed_watchdog(&self) -> bool {
        self.overruns_in_row == 0 && self.checkpoints.is_complete(self.schedule.tick)
    }

    /// Period in µs, at least the shortest that the bus allows. A bus that is too slow
    /// for the configured period is read at its own; motors cannot be armed then.
    pub(crate) fn period_us(&self, least_period_us: u32) -> u32 {
        self.config.period_us().get().max(least_period_us)
    }

    /// Begins a tick with at least the period that the bus allows: puts the last
    /// decided command in force, and plans the next tick.
    pub(crate) fn begin_tick(&mut self, least_period_us: u32) -> [Pwm; JOINTS] {
        let period_us = u64::from(self.period_us(least_period_us));
        let (late_us, missed) = self.schedule.plan_next(period_us);
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
        if !self.permission().drives_motors() {
            self.next = OFF;
        }
        self.schedule.begin_tick(late_us, missed);
        self.in_force = self.next;
        self.in_force
    }

    /// Decides the tick that has begun, and makes its record of inputs and outputs.
    pub(crate) fn decide(&mut self, sampled: &TickSamples, record: &mut Record) {
        let schedule = &mut self.schedule;
        schedule.timing.bus_us = sampled.bus_us;
        record.tick = schedule.tick;
        record.timing = schedule.timing;
        let is_armed = self.supervisor.state().is_armed();
        record.input = TickInput {
            start_us: schedule.start_us,
            lead_us: schedule.lead_us(),
            permission: self.supervisor.permission(),
            is_first: core::mem::take(&mut self.is_first),
            is_config_intact: !is_armed || self.integrity.tick(&self.config),
            host_silent_ms: schedule.ms_since(self.host_frame_us),
            samples: sampled.samples,
            alarms: sampled.alarms.map(Alarms::bits),
            pwm_in_force: self.in_force.map(Pwm::counts),
        };
        let mut checkpoints = sampled.checkpoints;
        record.output = step(
            &self.config,
            &mut self.control_loop,
            &record.input,
            &mut checkpoints,
        );
        self.next = self.control_loop.pwm();
        self.apply_output(&record.output);
        self.checkpoints = checkpoints.pass(Machine::Supervisor);
        self.schedule.decided = self.schedule.tick;
        record.mode = self.mode();
    }

    /// Passes the outputs of a tick to the supervisor.
    fn apply_output(&mut self, output: &TickOutput) {
        // Samples change no other state.
        let samples = match (self.state(), output.is_complete) {
            (State::Running, false) => Some(Event::SampleLost),
            (State::Degraded, true) => Some(Event::SamplesBack),
            _ => None,
        };
        if let Some(sample) = samples {
            // Never refused.
            let _ = self.apply(sample);
        }
        let Some(events) = output.events else {
            return;
        };
        let fallback = events.fallback.map(|fallback| match fallback {
            Fallback::Brake => Event::Brake,
            Fallback::Release => Event::ZeroTorque,
            Fallback::Park => Event::Park,
            Fallback::Parked => Event::Parked,
        });
        self.are_motors_checked |=
            events.are_motors_checked && self.control_loop.is_motor_check_conclusive(&self.config);
        let checked = events.are_motors_checked.then_some(Event::MotorsChecked);
        for event in [fallback, checked].into_iter().flatten() {
            // Never refused.
            let _ = self.apply(event);
        }
        if let Some(end) = events.experiment_end {
            self.conclude_experiment(end);
        }
        match events.fallback {
            Some(Fallback::Park) => {
                self.after_park.is_silence_fault = true;
                self.after_park.is_takeover = true;
            }
            Some(Fallback::Parked) => self.end_park(),
            Some(Fallback::Brake | Fallback::Release) | None => {}
        }
        if let Some(violation) = events.fault {
            self.trip(violation);
        }
    }

    /// The arm has been parked: what has been put off until then follows.
    #[inline(never)]
    fn end_park(&mut self) {
        let after = core::mem::take(&mut self.after_park);
        self.is_first |= after.is_restart;
        let silent_ms = self.schedule.ms_since(self.host_frame_us);
        let silence = host_silence(self.config.limits(), silent_ms);
        if let Some(violation) = silence.filter(|_| after.is_silence_fault) {
            self.trip(violation);
        }
    }

    /// Notes the end of an experiment for the host.
    pub(super) fn conclude_experiment(&mut self, end: ExperimentEnd) {
        let tick = self.schedule.tick;
        self.conclusion = Some(Conclusion { tick, end });
    }

    /// Begins ticks now: the servos have been found and set up.
    pub(crate) fn begin_ticking(&mut self) {
        self.schedule.start_now();
        self.control_loop.restart();
        self.is_first = true;
        self.overruns_in_row = 0;
        self.are_motors_checked = false;
        // Never refused.
        let _ = self.apply(Event::BusReady);
    }
}
