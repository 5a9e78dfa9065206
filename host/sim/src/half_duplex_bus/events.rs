//! Events on the wire, one at a time, in causal order: a byte
//! begins, a receiver has one, a servo acts.

use super::line::{Frame, Listening};
use super::{Mechanics, ReceivedByte, Record, Wire};
use crate::morpheus_servo::Action;

impl Wire {
    /// Executes one event at `now`. Senders precede receivers,
    /// and those precede the servos.
    pub(super) fn happen(&mut self, now: u64, to_ns: u64, mechanics: &mut impl Mechanics) {
        if self.due.front().is_some_and(|f| f.start_ns <= now) {
            self.begin_frame(now);
            return;
        }
        if self.master.next_ns() <= now {
            if !self.master.receiving() {
                self.master.look(now, &self.frames);
            } else if let Some(decoded) = self.master.finish(now, &self.frames) {
                let byte = self.disturbed(decoded.byte, now);
                self.plug_out(ReceivedByte {
                    byte,
                    end_ns: now,
                    framing_error: decoded.framing_error,
                });
            }
            return;
        }
        if self.faults.next_ns() <= now {
            self.late_byte();
            return;
        }
        if let Some(monitor) = &mut self.monitor
            && monitor.next_ns() <= now
        {
            if !monitor.receiving() {
                monitor.look(now, &self.frames);
            } else if let Some(decoded) = monitor.finish(now, &self.frames) {
                self.records.push(Record::Decoded(decoded.byte));
            }
            return;
        }
        for servo in 0..self.servos.len() {
            if self.receivers[servo].next_ns() <= now {
                self.servo_hears(servo, now);
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

    /// A byte from a servo as the master receives it.
    fn disturbed(&mut self, byte: u8, now: u64) -> u8 {
        let Some(disturbance) = &mut self.disturbance else {
            return byte;
        };
        let servos = 0..self.servos.len();
        let under_way =
            |f: &&Frame| servos.contains(&f.sender) && f.start_ns <= now && now < f.end_ns();
        match self.frames.iter().find(under_way) {
            Some(frame) => disturbance.byte(frame.sender, byte),
            None => byte,
        }
    }

    fn begin_frame(&mut self, now: u64) {
        let Some(frame) = self.due.pop_front() else {
            return;
        };
        if self.faults.keep_off(frame.sender, now) {
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
        self.forget_old(now);
        self.frames.push(frame);
        if self.master.waiting() {
            self.master.seek(now, &self.frames);
        }
        if let Some(monitor) = &mut self.monitor
            && monitor.waiting()
        {
            monitor.seek(now, &self.frames);
        }
        for (servo, receiver) in self.receivers.iter_mut().enumerate() {
            if receiver.waiting() && receiver.seek(now, &self.frames) {
                self.servos[servo].start_bit();
            }
        }
    }

    fn records_push(&mut self, record: Record) {
        if self.monitor.is_some() {
            self.records.push(record);
        }
    }

    fn forget_old(&mut self, now: u64) {
        let needed = self
            .receivers
            .iter()
            .chain([&self.master])
            .chain(&self.monitor)
            .map(|receiver| receiver.needs_from(now))
            .fold(now, u64::min);
        self.frames.retain(|frame| frame.end_ns() + 1 >= needed);
    }

    fn servo_hears(&mut self, servo: usize, now: u64) {
        let receiver = &mut self.receivers[servo];
        if !receiver.receiving() {
            if receiver.look(now, &self.frames) {
                self.servos[servo].start_bit();
            }
        } else if let Some(decoded) = receiver.finish(now, &self.frames) {
            self.servos[servo].receive(decoded, now);
            self.servo_changed(servo);
        }
    }

    /// Runs one servo, as long as no other event is due and
    /// its actions are internal.
    fn run_servo(&mut self, servo: usize, now: u64, to_ns: u64, mechanics: &mut impl Mechanics) {
        let own = std::mem::replace(&mut self.servo_next_ns[servo], u64::MAX);
        let others = self.next_event_ns();
        self.servo_next_ns[servo] = own;
        let mut now = now;
        loop {
            let inside = self.servo_acts(servo, now, mechanics);
            let next = self.servo_next_ns[servo].max(now);
            if !inside || next >= others || next > to_ns {
                return;
            }
            now = next;
            self.now_ns = next;
        }
    }

    /// One event of a servo. Returns whether the wire stayed as it was.
    fn servo_acts(&mut self, servo: usize, now: u64, mechanics: &mut impl Mechanics) -> bool {
        let mut inside = true;
        let device = &mut self.servos[servo];
        match device.step(now) {
            None => {}
            Some(Action::Convert) => device.converted(mechanics.convert(servo, now)),
            Some(Action::Pwm(pwm)) => mechanics.drive(servo, now, pwm),
            Some(Action::Release) => {
                inside = false;
                if let Some(disturbance) = &mut self.disturbance {
                    disturbance.released(servo);
                }
                self.records_push(Record::Released { servo, at_ns: now });
                self.refresh_ears(servo);
            }
            Some(Action::Send { byte, start_ns }) => {
                inside = false;
                let bit_ns = device.bit_ns();
                self.enqueue(Frame {
                    sender: servo,
                    byte,
                    start_ns,
                    bit_ns,
                });
                self.refresh_ears(servo);
            }
        }
        self.servo_changed(servo);
        inside
    }

    /// A servo receives while it is connected and not driving the line.
    pub(super) fn refresh_ears(&mut self, servo: usize) {
        let device = &self.servos[servo];
        let listens = device.connected() && !device.driving() && !self.faults.is_deaf(servo);
        let listening = if listens {
            Listening::All
        } else {
            Listening::None
        };
        if self.receivers[servo].set_listening(listening, self.now_ns, &self.frames) {
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
