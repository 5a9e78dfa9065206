//! Requests of the host, handled in the tick.

use crate::tick::limits::{PERIOD_MIN_AX12A_US, PERIOD_MIN_US};
use armbridge_control::encoder::Encoder;
use armbridge_servo::bus::Bus;

use super::app_core::BusFacts;
use super::channels::{HostRequest, Notification};
use super::command::ValidatedCommand;
use super::{Bridge, SERVO_IDS};
use crate::sequencer::XRequirements;
use crate::supervisor::{Event, State};
use armbridge_link::message::{Fault, Refusal, StopSource};
use armbridge_link::record::Violation;
use armbridge_servo::{Firmware, ServoIds};

impl<B: Bus> Bridge<'_, B> {
    /// Takes stops, goodbyes and hellos, then commands of the present epoch. Not inlined: a
    /// command has variables of some kB, and most polls have none.
    #[inline(never)]
    pub(super) fn take_requests(&mut self) {
        let mut has_left = self.take_signals();
        while let Some(request) = self.mailbox.take_request() {
            if !self.mailbox.is_present(&request) {
                // The signal that began its epoch may be new.
                has_left |= self.take_signals();
            }
            if self.mailbox.is_present(&request) {
                self.core.note_host();
                self.take_command(&request);
            } else {
                let notification = Notification::Dropped(request.sequence);
                self.notify(notification);
            }
        }
        if has_left {
            self.leave();
        }
    }

    /// Takes the signals. Returns whether a host has left, whose last commands precede its
    /// goodbye.
    fn take_signals(&mut self) -> bool {
        let signals = self.mailbox.signals.take();
        if let Some(source) = signals.stop {
            self.emergency_stop(source);
        }
        if signals.heartbeat {
            self.core.note_host();
        }
        if signals.hello {
            if signals.goodbye {
                self.leave();
            }
            self.begin_session();
        }
        signals.goodbye && !signals.hello
    }

    /// Parks or disarms: the host has left, or a servo is nearly too hot.
    pub(super) fn leave(&mut self) {
        // Never refused.
        let _ = self.core.leave();
        self.apply_core_actions();
    }

    /// Takes a hello of the host, which parks or disarms.
    fn begin_session(&mut self) {
        self.core.begin_session();
        self.apply_core_actions();
        self.notify(Notification::Began(self.core.moment()));
        self.announce();
        if let Some(trip) = self.core.cause() {
            self.notify(Notification::Tripped(trip));
            // An earlier host may have had the report.
            if let Some(report) = self.sequencer.last_off_report() {
                self.notify(Notification::Off(report));
            }
        }
    }

    #[inline(never)]
    fn take_command(&mut self, request: &HostRequest) {
        let HostRequest {
            sequence,
            ref command,
            ..
        } = *request;
        self.port.claim(self.core.now_us());
        let moment = self.core.moment();
        let notification = if matches!(command, ValidatedCommand::StartPoint) {
            self.core.start_point().map_or_else(
                |refusal| Notification::Ack(sequence, Err(refusal), moment),
                |start| Notification::StartPoint(sequence, start, moment),
            )
        } else {
            Notification::Ack(sequence, self.perform(command), moment)
        };
        // Lost if the host does not fetch them: it repeats its hello.
        self.notify(notification);
    }

    fn perform(&mut self, command: &ValidatedCommand) -> Result<(), Refusal> {
        let encoder = Encoder::of(self.sequencer.firmware());
        let bus = BusFacts {
            encoder,
            is_prepared: self.sequencer.is_prepared(),
            least_period_us: self.sequencer.least_period_us().max(match encoder {
                Encoder::Ax12a => PERIOD_MIN_AX12A_US,
                Encoder::XSeries => PERIOD_MIN_US,
            }),
            is_stop_settled: self.sequencer.is_settled(),
            hot_joint: self.hot_joint(),
            encoder_refusal: self.core.encoder_refusal(),
        };
        let has_settings = self.sequencer.firmware() != Firmware::Morpheus;
        let prepares = matches!(command, ValidatedCommand::Prepare) && !bus.is_prepared;
        let restores = matches!(command, ValidatedCommand::Release) && has_settings;
        let joints = self.core.config().joints();
        let result = self.core.command(command, bus);
        if self.core.config().joints() != joints {
            self.search_for_joints();
        }
        // Refused while a client has the bus or a search is under way, after which servos are not ready.
        let is_again = self
            .sequencer
            .require(XRequirements::of(self.core.config()))
            && self.core.apply(Event::Prepare).is_ok();
        self.apply_core_actions();
        if (result.is_ok() && prepares) || is_again {
            self.sequencer.prepare();
        } else if result.is_ok() && restores {
            self.sequencer.restore();
        }
        result
    }

    /// Searches for the servos of an arm with another number of joints, whose motors are off.
    fn search_for_joints(&mut self) {
        let joints = self.core.config().joints();
        self.sequencer
            .set_servos(ServoIds::from(SERVO_IDS).of_joints(joints));
        // Refused where a search is under way, or follows.
        let _ = self.core.apply(Event::Prepare);
    }

    /// The joint whose servo is too hot to be armed or, after a fault of its temperature, to
    /// clear that. A servo out of reach has no present temperature, and a cleared fault is what searches
    /// for it; the arm is not armed before it has been read again.
    fn hot_joint(&self) -> Option<u8> {
        let (firmware, limits) = (self.sequencer.firmware(), self.core.config().limits());
        match self.core.cause() {
            Some(trip) if trip.fault == Fault::Temperature => {
                let joint = self.temperatures.uncooled_joint(firmware, limits);
                joint.filter(|joint| !self.sequencer.is_out_of_reach((*joint).into()))
            }
            Some(_) | None => self.temperatures.hot_joint(firmware, limits),
        }
    }

    /// Stops in an emergency: the stop sequence begins when the exchange under way is over,
    /// within a tick. A repeated stop of the host begins it again; a switch that is held, a crystal
    /// that fails, or garbage that goes on, has the order repeated by the ticks.
    pub fn emergency_stop(&mut self, source: StopSource) {
        let is_again = self.core.state() == State::Fault;
        self.trip(Violation::plain(Fault::EmergencyStop(source)));
        self.supply.stop();
        match source {
            _ if !is_again => {}
            StopSource::Host => self.sequencer.force_off(self.core.now_us()),
            StopSource::Pin | StopSource::Flood | StopSource::Crystal => {
                self.sequencer.repeat_off();
            }
        }
    }
}
