//! Events on the wire, one at a time, in causal order: a byte
//! begins, a receiver has one, a servo acts.

use super::line::{Frame, SenderFilter};
use super::{Mechanics, ReceivedByte, Record, Wire};
use crate::morpheus_servo::Action;

impl Wire {
    /// Executes one event at `now`. Senders precede receivers, and receivers precede the
    /// servos.
    pub(super) fn execute_event(&mut self, now: u64, to_ns: u64, mechanics: &mut impl Mechanics) {
        if self.due.front().is_some_and(|f| f.start_ns <= now) {
            self.begin_frame(now);
            return;
        }
        if self.master.next_ns() <= now {
            if !self.master.receiving() {
                self.master.process_edge(now, &self.frames);
            } else if let Some(decoded) = self.master.finish(now, &self.frames) {
                let byte = self.apply_disturbance(decoded.byte, now);
                self.deliver_to_master(ReceivedByte {
                    byte,
                    end_ns: now,
                    framing_error: decoded.framing_error,
                });
            }
            return;
        }
        if self.faults.next_ns() <= now {
            self.deliver_late_byte();
            return;
        }
        if let Some(monitor) = &mut self.monitor
            && monitor.next_ns() <= now
        {
            if !monitor.receiving() {
                monitor.process_edge(now, &self.frames);
            } else if let Some(decoded) = monitor.finish(now, &self.frames) {
                self.records.push(Record::Decoded(decoded.byte));
            }
            return;
        }
        for servo in 0..self.servos.len() {
            if self.receivers[servo].next_ns() <= now {
                self.servo_receiver_event(servo, now);
                return;
            }
        }
        for servo in 0..self.servos.len() {
            if self.servo_next_ns[servo] <= now {
                self.run_servo(servo, now, to_ns, mechanics);
                return;
            }
        }
    }

    /// A servo's byte as received by the master.
    fn apply_disturbance(&mut self, byte: u8, now: u64) -> u8 {
        let Some(disturbance) = &mut self.disturbance else {
            return byte;
        };
        let servos = 0..self.servos.len();
        let is_sending =
            |f: &&Frame| servos.contains(&f.sender) && f.start_ns <= now && now < f.end_ns();
        match self.frames.iter().find(is_sending) {
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
        self.frames.push(frame);
        if self.master.waiting() {
            self.master.find_start_bit(now, &self.frames);
        }
        if let Some(monitor) = &mut self.monitor
            && monitor.waiting()
        {
            monitor.find_start_bit(now, &self.frames);
        }
        for (servo, receiver) in self.receivers.iter_mut().enumerate() {
            if receiver.waiting() && receiver.find_start_bit(now, &self.frames) {
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
        let needed = self
            .receivers
            .iter()
            .chain([&self.master])
            .chain(&self.monitor)
            .map(|receiver| receiver.earliest_sample_ns(now))
            .fold(now, u64::min);
        self.frames.retain(|frame| frame.end_ns() + 1 >= needed);
    }

    fn servo_receiver_event(&mut self, servo: usize, now: u64) {
        let receiver = &mut self.receivers[servo];
        if !receiver.receiving() {
            if receiver.process_edge(now, &self.frames) {
                self.servos[servo].start_bit();
            }
        } else if let Some(decoded) = receiver.finish(now, &self.frames) {
            self.servos[servo].receive(decoded, now);
            self.servo_changed(servo);
        }
    }

    /// Runs one servo while its actions are internal and no other event is due.
    fn run_servo(&mut self, servo: usize, now: u64, to_ns: u64, mechanics: &mut impl Mechanics) {
        let own = std::mem::replace(&mut self.servo_next_ns[servo], u64::MAX);
        let others = self.next_event_ns();
        self.servo_next_ns[servo] = own;
        let mut now = now;
        loop {
            let is_internal = self.step_servo(servo, now, mechanics);
            let next = self.servo_next_ns[servo].max(now);
            if !is_internal || next >= others || next > to_ns {
                return;
            }
            now = next;
            self.now_ns = next;
        }
    }

    /// Executes one event of a servo. Returns whether it is internal: the wire does not
    /// change.
    fn step_servo(&mut self, servo: usize, now: u64, mechanics: &mut impl Mechanics) -> bool {
        let mut is_internal = true;
        let device = &mut self.servos[servo];
        match device.step(now) {
            None => {}
            Some(Action::Convert) => device.converted(mechanics.convert(servo, now)),
            Some(Action::Pwm(pwm)) => mechanics.drive(servo, now, pwm),
            Some(Action::Release) => {
                is_internal = false;
                if let Some(disturbance) = &mut self.disturbance {
                    disturbance.released(servo);
                }
                self.records_push(Record::Released { servo, at_ns: now });
                self.update_receiver(servo);
            }
            Some(Action::Send { byte, start_ns }) => {
                is_internal = false;
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
        is_internal
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
        if self.receivers[servo].set_filter(filter, self.now_ns, &self.frames) {
            self.servos[servo].start_bit();
        }
    }

    #[inline]
    pub(super) fn servo_changed(&mut self, servo: usize) {
        let device = &self.servos[servo];
        self.receivers[servo].set_bit(device.bit_ns());
        self.servo_next_ns[servo] = device.next_event_ns();
    }
}
