//! Events of the bus, and actions of the core on the bus.

use armbridge_servo::bus::Bus;

use super::app_core::{BusAction, TickSamples};
use super::channels::Notification;
use super::{Bridge, Progress};
use crate::sequencer::{BusEvent, Health};
use crate::supervisor::{Event, State};
use armbridge_link::message::{Fault, Refusal};
use armbridge_link::record::Violation;

impl<B: Bus> Bridge<'_, B> {
    /// Takes an event of the bus.
    pub(super) fn take_bus_event(&mut self, event: BusEvent) -> Progress {
        match event {
            BusEvent::Sampled(outcome, checkpoints) => {
                self.sampled = TickSamples {
                    samples: outcome.samples,
                    alarms: outcome.alarms,
                    bus_us: outcome.bus_us,
                    checkpoints,
                };
                return Progress::Sampled;
            }
            BusEvent::Client => {
                self.port.finish(&self.sequencer);
                return Progress::Served;
            }
            BusEvent::Health(health) => {
                self.handle_health(health);
                return Progress::Served;
            }
            BusEvent::Served => return Progress::Served,
            BusEvent::Searching => {
                // Ticks go on with torque off, from now.
                if self.core.state() == State::Fault && self.sequencer.is_ticking() {
                    self.core.set_next_start(self.core.now_us());
                }
            }
            BusEvent::LinedUp => {
                self.announce();
                self.core.begin_ticking();
            }
            BusEvent::Restored => {}
            BusEvent::FirmwareChanged => self.trip(Violation::plain(Fault::FirmwareChanged)),
            BusEvent::Mixed(firmwares) => self.notify(Notification::Mixed(firmwares)),
            BusEvent::Absent(joint, missing) => {
                self.notify(Notification::Absent(joint as u8, missing));
            }
            BusEvent::Unprepared(joint) => self.notify(Notification::Unprepared(joint as u8)),
        }
        Progress::Searching
    }

    /// Queues a notification for the host. It is lost if the host does not fetch it.
    pub(super) fn notify(&mut self, notification: Notification) {
        let _ = self.mailbox.notify(notification);
    }

    /// Notifies the host of firmware, speed and readiness of the servos.
    pub(super) fn announce(&mut self) {
        let bus = &self.sequencer;
        let notification = if bus.is_ticking() {
            Notification::Found(bus.firmware(), bus.baud(), bus.is_prepared())
        } else if self.core.state() == State::Passthrough {
            Notification::Passthrough
        } else {
            return;
        };
        self.notify(notification);
    }

    /// Switches torque off and latches the first cause. The stop sequence follows at once
    /// on the bus.
    pub(super) fn trip(&mut self, violation: Violation) {
        self.core.trip(violation);
        self.apply_core_actions();
    }

    /// Applies an event to the supervisor's state.
    pub(super) fn apply(&mut self, event: Event) -> Result<(), Refusal> {
        let result = self.core.apply(event);
        self.apply_core_actions();
        result
    }

    /// Carries out the core's actions on the bus, and notifies the host.
    pub(super) fn apply_core_actions(&mut self) {
        if self.port.has_relayed() && self.core.state() != State::Passthrough {
            self.port.end_relay();
        }
        if self.core.has_actions() {
            self.take_core_actions();
        }
        if let Some(report) = self.sequencer.take_off_report() {
            self.notify(Notification::Off(report));
        }
    }

    #[inline(never)]
    fn take_core_actions(&mut self) {
        match self.core.take_bus_action() {
            Some(BusAction::Halt) => self.sequencer.force_off(self.core.now_us()),
            Some(BusAction::RepeatOff) => self.sequencer.repeat_off(),
            Some(BusAction::HandOver) => self.notify(Notification::Passthrough),
            Some(BusAction::Search) | None => {}
        }
        if let Some(conclusion) = self.core.take_conclusion() {
            self.notify(Notification::Concluded(conclusion));
        }
        if let Some(trip) = self.core.take_trip() {
            self.notify(Notification::Tripped(trip));
        }
    }

    /// Handles the result of a health poll.
    fn handle_health(&mut self, health: Health) {
        match health {
            Health::Reset { joint } => {
                self.temperatures.power_up(joint);
                let (lost, allowed) = (
                    self.core.lost_in_row(joint),
                    self.core.config().dropout_ticks(),
                );
                self.trip(Violation {
                    fault: Fault::ServoReset,
                    joint: Some(joint as u8),
                    value: lost as f32,
                    limit: allowed as f32,
                });
            }
            Health::Temperature { joint, value } => self.check_temperature(joint, value),
        }
    }

    /// Reports a temperature, and trips if it is out of range.
    fn check_temperature(&mut self, joint: usize, value: u16) {
        self.notify(Notification::Temperature(joint as u8, value));
        let (firmware, limits) = (self.sequencer.firmware(), self.core.config().limits());
        let violation = self.temperatures.take(joint, value, firmware, limits);
        if let (Some(violation), true) = (violation, self.core.state().is_armed()) {
            self.trip(violation);
        }
        let is_nearly_hot = {
            let (firmware, limits) = (self.sequencer.firmware(), self.core.config().limits());
            limits.park.is_some() && self.temperatures.is_nearly_hot(joint, firmware, limits)
        };
        if is_nearly_hot && self.core.state().is_driven() {
            self.leave();
        }
    }
}
