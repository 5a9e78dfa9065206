//! Times of a run's ticks and events, in s.
//!
//! Time zero of a run is the first tick in which the arm is armed: the run's plan begins with
//! that tick. Summary, `info` and figures count from it, so a run's own pictures and those of
//! its log have the same axis. The search for servos and the motor check before it have
//! negative times. A log in which the arm is never armed counts from its first tick.

use armbridge_link::message::{Mode, Record};
use armbridge_servo::JOINTS;

/// Finds the first tick of a run, tick by tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct TimeOrigin {
    before: Option<Mode>,
    is_found: bool,
}

impl TimeOrigin {
    /// Adds the mode of the next tick; returns whether time zero is this tick. True once.
    ///
    /// A motor check that ends in a fault is followed by no armed tick: then the fault is
    /// time zero, as for the plan.
    pub fn is_at(&mut self, mode: Mode) -> bool {
        let before = self.before.replace(mode);
        let is_at = match mode {
            Mode::Armed | Mode::Running(_) | Mode::Degraded(_) => true,
            Mode::Fault(_) => before == Some(Mode::MotorCheck),
            Mode::Boot | Mode::Idle | Mode::MotorCheck | Mode::Passthrough => false,
        };
        let is_first = is_at && !self.is_found;
        self.is_found |= is_at;
        is_first
    }
}

/// Event of a run at which times of several runs are aligned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Align {
    /// First tick in which the motors are driven.
    #[default]
    Drive,
    /// First change of the reference after that.
    Setpoint,
    /// Time zero: the first armed tick.
    Start,
}

/// Times of a run's ticks in s after the first tick, and of its events.
///
/// Time continues after a reset of the board, which restarts the board's clock.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunTimes {
    before_s: f64,
    clock_origin_us: u64,
    last_us: Option<u64>,
    /// Of the last tick.
    now_s: f64,
    origin: TimeOrigin,
    origin_s: Option<f64>,
    driven: Option<(f64, [f32; JOINTS])>,
    setpoint_s: Option<f64>,
}

impl RunTimes {
    /// Adds the next tick; returns its time in s after the first.
    pub fn add(&mut self, record: &Record) -> f64 {
        match self.last_us {
            None => self.clock_origin_us = record.input.start_us,
            Some(last_us) if record.input.start_us < last_us => {
                self.before_s = self.now_s;
                self.clock_origin_us = record.input.start_us;
            }
            Some(_) => {}
        }
        self.last_us = Some(record.input.start_us);
        self.now_s = self.at_us(record.input.start_us);
        if self.origin.is_at(record.mode) {
            self.origin_s = Some(self.now_s);
        }
        if record.mode.drive().is_some() {
            let (_, first) = *self
                .driven
                .get_or_insert((self.now_s, record.output.reference_rad));
            if first.map(f32::to_bits) != record.output.reference_rad.map(f32::to_bits) {
                self.setpoint_s.get_or_insert(self.now_s);
            }
        }
        self.now_s
    }

    /// Time of the last tick, in s after the first.
    pub fn now_s(&self) -> f64 {
        self.now_s
    }

    /// Time zero in s after the first tick; none before the arm is armed.
    pub fn origin_s(&self) -> Option<f64> {
        self.origin_s
    }

    /// Time of an event in s after the first tick; none if it did not occur.
    pub fn event_s(&self, event: Align) -> Option<f64> {
        match event {
            Align::Drive => self.driven.map(|(time_s, _)| time_s),
            Align::Setpoint => self.setpoint_s,
            Align::Start => Some(self.origin_s.unwrap_or(0.0)),
        }
    }

    /// Time in s after the first tick of a time of the board's clock, since its last reset.
    pub fn at_us(&self, board_us: u64) -> f64 {
        self.before_s + (board_us as f64 - self.clock_origin_us as f64) * 1e-6
    }

    /// Whether the motors have been driven.
    pub fn is_driven(&self) -> bool {
        self.driven.is_some()
    }
}

#[cfg(test)]
mod tests {
    use armbridge_link::message::{Drive, Fault, TickInput, TickOutput};

    use super::*;

    fn origin(modes: &[Mode]) -> Vec<usize> {
        let mut origin = TimeOrigin::default();
        (0..modes.len())
            .filter(|tick| origin.is_at(modes[*tick]))
            .collect()
    }

    #[test]
    fn time_zero_is_the_first_armed_tick_or_the_fault_of_the_motor_check() {
        let fault = Mode::Fault(Fault::HostSilent);
        let again = [
            Mode::Boot,
            Mode::Idle,
            Mode::MotorCheck,
            Mode::Armed,
            Mode::Armed,
        ];
        assert_eq!(origin(&again), [3]);
        assert_eq!(origin(&[Mode::Idle, Mode::MotorCheck, fault, fault]), [2]);
        assert_eq!(origin(&[Mode::Boot, fault, Mode::Idle]), [0; 0]);
    }

    #[test]
    fn events_have_times_and_time_continues_after_a_reset() {
        let mut times = RunTimes::default();
        let tick = |start_us, mode, reference| Record {
            mode,
            input: TickInput {
                start_us,
                ..TickInput::AT_REST
            },
            output: TickOutput {
                reference_rad: [reference, 0.0],
                ..TickOutput::NONE
            },
            ..Record::NONE
        };
        let held = Mode::Running(Drive::Regulate);
        let ticks = [
            tick(500_000, Mode::Idle, 0.0),
            tick(600_000, Mode::Armed, 0.0),
            tick(700_000, held, 0.1),
            tick(1_000_000, held, 0.1),
            tick(1_250_000, held, 0.2),
            tick(10_000, Mode::Boot, 0.0),
            tick(20_000, Mode::Boot, 0.0),
        ];
        let seconds = ticks.map(|tick| times.add(&tick));
        let expected = [0.0, 0.1, 0.2, 0.5, 0.75, 0.75, 0.76];
        for (is, expected) in seconds.iter().zip(expected) {
            assert!((is - expected).abs() < 1e-9, "{seconds:?}");
        }
        let events = [Align::Start, Align::Drive, Align::Setpoint];
        assert_eq!(
            events.map(|event| times.event_s(event).map(|s| (s * 1e3).round())),
            [Some(100.0), Some(200.0), Some(750.0)]
        );
    }
}
