//! Events on the wire, one at a time, in causal order: a byte
//! begins, a receiver has one, a servo acts.

use super::line::{Frame, SenderFilter};
use super::{Device, Mechanics, ReceivedByte, Record, Wire};
use crate::morpheus_servo::Action;

/// The kinds of events.
#[derive(Debug, Clone, Copy)]
pub(super) enum Event {
    /// A byte begins.
    Begin,
    /// The master's receiver.
    Master,
    /// A delayed byte reaches the master.
    LateByte,
    /// The receiver of [`Wire::record`].
    Monitor,
    /// Receivers of servos.
    Receivers,
    /// A servo's own event.
    Servo(usize),
}

impl Wire {
    /// Executes an event that is due now.
    pub(super) fn execute(&mut self, event: Event, to_ns: u64, mechanics: &mut impl Mechanics) {
        let now = self.now_ns;
        match event {
            Event::Begin => self.begin_frame(now),
            Event::Master => self.master_event(now),
            Event::LateByte => self.deliver_late_byte(),
            Event::Monitor => self.monitor_event(now),
            Event::Receivers => {
                self.receive(now);
                self.run_ahead(to_ns);
            }
            Event::Servo(servo) => {
                self.step_servo(servo, now, mechanics);
                self.run_ahead(to_ns);
            }
        }
    }

    fn master_event(&mut self, now: u64) {
        if !self.master.receiving() {
            self.master.process_edge(now, &self.line);
        } else if let Some(decoded) = self.master.finish(now, &self.line) {
            let byte = self.apply_disturbance(decoded.byte, now);
            self.deliver_to_master(ReceivedByte {
                byte,
                end_ns: now,
                framing_error: decoded.framing_error,
            });
        }
    }

    fn monitor_event(&mut self, now: u64) {
        let Some(monitor) = &mut self.monitor else {
            return;
        };
        if !monitor.receiving() {
            monitor.process_edge(now, &self.line);
        } else if let Some(decoded) = monitor.finish(now, &self.line) {
            self.records.push(Record::Decoded(decoded.byte));
        }
    }

    /// A servo's byte as received by the master.
    fn apply_disturbance(&mut self, byte: u8, now: u64) -> u8 {
        let Some(disturbance) = &mut self.disturbance else {
            return byte;
        };
        match self.line.sent_by_servo(self.servos.len(), now) {
            Some(frame) => disturbance.byte(frame.sender, byte),
            None => byte,
        }
    }

    fn begin_frame(&mut self, now: u64) {
        let Some(frame) = self.due.pop_front() else {
            return;
        };
        if self.faults.blocks_sender(frame.sender, now) {
            return;
        }
        if let Some(servo) = self.servos.get(frame.sender) {
            let connected = servo.connected();
            self.records_push(Record::Sent {
                servo: frame.sender,
                byte: frame.byte,
                start_ns: frame.start_ns,
                end_ns: frame.end_ns(),
            });
            if !connected {
                return;
            }
        }
        self.drop_old_frames(now);
        self.line.begin(frame);
        if self.master.waiting() {
            self.master.find_start_bit(now, &self.line);
        }
        if let Some(monitor) = &mut self.monitor
            && monitor.waiting()
        {
            monitor.find_start_bit(now, &self.line);
        }
        for (servo, receiver) in self.receivers.iter_mut().enumerate() {
            if receiver.waiting() && receiver.find_start_bit(now, &self.line) {
                self.servos[servo].start_bit();
            }
        }
    }

    fn records_push(&mut self, record: Record) {
        if self.monitor.is_some() {
            self.records.push(record);
        }
    }

    fn drop_old_frames(&mut self, now: u64) {
        if !self.line.is_full() {
            return;
        }
        let needed = self
            .receivers
            .iter()
            .chain([&self.master])
            .chain(&self.monitor)
            .map(|receiver| receiver.earliest_sample_ns(now))
            .fold(now, u64::min);
        self.line.forget(needed);
    }

    /// Executes the events of servos' receivers that are due.
    fn receive(&mut self, now: u64) {
        for (servo, receiver) in self.receivers.iter_mut().enumerate() {
            if receiver.next_ns() > now {
                continue;
            }
            let device = &mut self.servos[servo];
            if !receiver.receiving() {
                if receiver.process_edge(now, &self.line) {
                    device.start_bit();
                }
            } else if let Some(decoded) = receiver.finish(now, &self.line) {
                device.receive(decoded, now);
                receiver.set_bit(device.bit_ns());
                self.schedule[servo] = device.schedule();
            }
        }
    }

    /// Executes one event of a servo.
    fn step_servo(&mut self, servo: usize, now: u64, mechanics: &mut impl Mechanics) {
        let device = &mut self.servos[servo];
        match device.step(now) {
            None => {}
            Some(Action::Convert) => {
                let encoder = device.encoder();
                device.converted(mechanics.convert_with(servo, encoder, now));
                if let Device::X(x_servo) = device {
                    x_servo.turned(mechanics.counts_per_s(servo, encoder, now));
                }
            }
            Some(Action::Pwm(drive)) => mechanics.drive(servo, now, drive),
            Some(Action::Release) => {
                if let Some(disturbance) = &mut self.disturbance {
                    disturbance.released(servo);
                }
                self.records_push(Record::Released { servo, at_ns: now });
                self.update_receiver(servo);
            }
            Some(Action::Send { byte, start_ns }) => {
                let bit_ns = device.bit_ns();
                self.enqueue(Frame {
                    sender: servo,
                    byte,
                    start_ns,
                    bit_ns,
                });
                self.update_receiver(servo);
            }
        }
        self.servo_changed(servo);
    }

    /// Updates a servo's receiver: enabled while it is connected and not driving the line.
    pub(super) fn update_receiver(&mut self, servo: usize) {
        let device = &self.servos[servo];
        let listens = device.connected() && !device.driving() && !self.faults.is_deaf(servo);
        let filter = if listens {
            SenderFilter::All
        } else {
            SenderFilter::None
        };
        if self.receivers[servo].set_filter(filter, self.now_ns, &self.line) {
            self.servos[servo].start_bit();
        }
    }

    #[inline]
    pub(super) fn servo_changed(&mut self, servo: usize) {
        let device = &self.servos[servo];
        self.receivers[servo].set_bit(device.bit_ns());
        self.schedule[servo] = device.schedule();
    }
}
