//! The replayed board: the core that boards run, with the inputs of records.
//!
//! Samples and their timing come from a [`Record`]; the code that runs on a board decides
//! everything else of a tick. So each output is the recorded one, to the bit, or the record
//! is not of this code, these settings or these commands.
//!
//! # What influences a record
//!
//! | input                             | source                                      |
//! |-----------------------------------|---------------------------------------------|
//! | samples, alarms, start, lateness  | the record                                  |
//! | set-up, limits                    | `ToHost::Settings`, `Configure` and `Limit` |
//! | commands                          | the host's frames, at the `Moment` of their acknowledgement |
//! | start point of a motion           | decided again at the moment of `ToHost::Departs` |
//! | a hello                           | `ToHost::Began`                             |
//! | faults from outside the tick      | `ToHost::Tripped`, see [`is_external`](super::tick_facts::is_external) |
//! | the host's silence                | the mode of the record that shows it        |
//! | motors checked before the log     | the mode of the record after arming         |
//!
//! A hello, arming and bring-up make estimator, monitors and reference begin anew, so that
//! nothing before them has to be known.
//!
//! The caller keeps the order: events before a tick, the tick's beginning, events before
//! its decision, the decision. Commands from outside the tick are in `commands`.

mod commands;

use std::collections::VecDeque;

use armbridge_board::bridge::app_core::{BusAction, BusFacts, Core, TickSamples};
use armbridge_board::control_loop::LoopConfig;
use armbridge_board::flow_token::FlowToken;
use armbridge_board::supervisor::State;
use armbridge_control::arm::State as ArmState;
use armbridge_link::experiment::Conclusion;
use armbridge_link::message::{Drive, Fault, Mode, Record, Refusal, Settings, Trip};
use armbridge_servo::Alarms;
use armbridge_servo::Firmware;
use armbridge_servo::master::Readiness;
use armbridge_servo::master::timing::tick_us;

use super::tick_facts::{HostEvent, is_off, planned_us};

/// A board that replays recorded ticks.
pub(super) struct Board {
    core: Core,
    bus: BusFacts,
    /// Shortest period in µs after a stop, which releases stock servos.
    released_period_us: u32,
    is_ticking: bool,
    concluded: VecDeque<Conclusion>,
}

impl Board {
    /// A board just started with these settings.
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
                hot_joint: None,
                encoder_refusal: None,
            },
            released_period_us: 0,
            is_ticking: false,
            concluded: VecDeque::new(),
        })
    }

    /// Puts these settings in force.
    ///
    /// # Errors
    /// A [`Refusal`] if no controller exists for the set-up; nothing changes then.
    pub(super) fn set(&mut self, settings: &Settings) -> Result<(), Refusal> {
        self.core.replace_config(LoopConfig::build(settings)?);
        Ok(())
    }

    /// Sets the servos' firmware and speed: a bus that is too slow for the period
    /// stretches it.
    pub(super) fn set_line(&mut self, firmware: Firmware, baud: u32, is_ready: bool) {
        let is_prepared = is_ready || firmware == Firmware::Morpheus;
        let [readiness, after_stop] = if is_prepared {
            [Readiness::Prepared, Readiness::Released]
        } else {
            [Readiness::Unknown; 2]
        };
        self.released_period_us = tick_us(firmware, baud, after_stop);
        self.bus = BusFacts {
            is_prepared,
            least_period_us: tick_us(firmware, baud, readiness),
            is_stop_settled: true,
            hot_joint: None,
            encoder_refusal: None,
        };
    }

    /// Adopts the mode of this record. Called after [`Self::begin`], before the decision.
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

    /// Ends a check of the motors that has just begun: they had been checked before the log.
    pub(super) fn skip_motor_check(&mut self) {
        self.core.skip_motor_check();
        self.drain();
    }

    /// Adopts the record's information on the time before it, if the record before is not
    /// known. Called after [`Self::begin`], before the decision.
    pub(super) fn assume_before(&mut self, record: &Record) {
        self.core
            .resume_before(record.timing.missed, is_off(record));
    }

    /// Resets the state, with the motors not driven.
    pub(super) fn forget(&mut self) {
        self.core.forget();
    }

    /// Continues from this record; everything else of its tick is unknown.
    pub(super) fn resume_from(&mut self, record: &Record) {
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

    /// Ends bring-up, unless ticks go on already.
    pub(super) fn begin_ticking(&mut self) {
        if !self.is_ticking {
            if self.core.state() == State::Passthrough {
                self.return_bus();
            }
            self.is_ticking = true;
            self.core.begin_ticking();
            self.drain();
        }
    }

    /// Ends bring-up after a client has had the bus: between two ticks of a board that
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

    /// Its mode.
    pub(super) fn mode(&self) -> Mode {
        self.core.mode()
    }

    /// Cause of its fault.
    pub(super) fn cause(&self) -> Option<Trip> {
        self.core.cause()
    }

    /// The event that the recorded mode shows, for the board before its decision.
    pub(super) fn host_event(&self, recorded: Mode) -> HostEvent {
        let state = self.core.state();
        let before = self.core.drive();
        match (recorded, before) {
            _ if !state.is_armed() => HostEvent::None,
            // The command ended by its age.
            (Mode::Running(_) | Mode::Degraded(_) | Mode::Armed, _)
                if self.core.is_command_aged() =>
            {
                HostEvent::None
            }
            (Mode::Fault(Fault::HostSilent), _) => HostEvent::LongSilence,
            (Mode::Fault(Fault::Corrupted), _) => HostEvent::Corruption,
            // An experiment that ends by itself in this tick does so before the silence counts.
            (
                Mode::Running(Drive::Hold) | Mode::Degraded(Drive::Hold),
                Drive::Track | Drive::Experiment,
            )
            | (Mode::Armed, Drive::Torque)
                if state.is_driven() =>
            {
                HostEvent::Silence
            }
            _ => HostEvent::None,
        }
    }

    /// Begins the tick of this record.
    pub(super) fn begin(&mut self, inputs: &Record) {
        self.core
            .resume_tick(inputs.tick, inputs.start_us, planned_us(inputs));
        self.core.begin_tick(self.bus.least_period_us);
        self.drain();
    }

    /// Decides the tick that has begun. Returns the record as it should be, with the
    /// measured times of `inputs`.
    pub(super) fn decide(&mut self, inputs: &Record, event: HostEvent) -> Record {
        let limits = self.core.config().limits();
        let silent_ms = match event {
            HostEvent::None | HostEvent::Corruption => None,
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

    /// Takes the oldest end of an experiment.
    pub(super) fn take_conclusion(&mut self) -> Option<Conclusion> {
        self.concluded.pop_front()
    }

    /// Takes the core's outputs to bus and host.
    fn drain(&mut self) {
        if let Some(action) = self.core.take_bus_action() {
            if action == BusAction::Halt {
                self.bus.least_period_us = self.released_period_us;
            }
            let state = self.core.state();
            self.is_ticking &= !matches!(state, State::Boot | State::Passthrough);
        }
        let _ = self.core.take_trip();
        self.concluded.extend(self.core.take_conclusion());
    }
}
