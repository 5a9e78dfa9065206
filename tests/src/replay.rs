//! Replays recorded exchanges against virtual servos and collects what they
//! did in the form of the record.

use armbridge_sim::half_duplex_bus::{Mechanics, MotorDrive, Record, Wire};
use armbridge_sim::morpheus_servo::{Reading, Servo};

use crate::trace::{EventKind, Exchange};

/// Nanoseconds of a recorded time.
fn ns(us: f64) -> u64 {
    (us * 1e3).round() as u64
}

fn us(ns: i64) -> f64 {
    ns as f64 / 1e3
}

/// Sensor angles of the servos, and their PWM changes since the last call.
#[derive(Debug, Default)]
struct Sensors {
    readings: Vec<Reading>,
    changes: Vec<(usize, u64, u16)>,
}

impl Mechanics for Sensors {
    fn convert(&mut self, servo: usize, _at_ns: u64) -> Reading {
        self.readings[servo]
    }

    fn drive(&mut self, servo: usize, at_ns: u64, drive: MotorDrive) {
        self.changes.push((servo, at_ns, drive.pwm));
    }
}

/// A packet that a virtual servo sent.
#[derive(Debug, Clone, PartialEq)]
pub struct Packet {
    /// Which servo.
    pub servo: usize,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// End of the master's last stop bit to its first start bit.
    pub latency_us: f64,
    /// Longest pause between its bytes.
    pub max_gap_us: f64,
    /// Last stop bit to the moment the servo stopped driving the wire.
    pub release_us: Option<f64>,
    /// All of it was sent before the window ended.
    pub complete: bool,
    start_ns: u64,
    end_ns: u64,
}

/// Result of one exchange.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Packets, in order of their first bit.
    pub packets: Vec<Packet>,
    /// Two senders were on the wire at the same time.
    pub collision: bool,
    /// Bytes decoded by a receiver that is always on.
    pub wire: Vec<u8>,
    /// PWM changes: servo, time after the master's last bit, PWM.
    pub pwm_changes: Vec<(usize, f64, u16)>,
    /// Bytes lost in each servo's receiver.
    pub overruns: Vec<u32>,
    /// The servos at the end of the window.
    pub servos: Vec<Servo>,
}

/// One scenario being replayed.
#[derive(Debug)]
pub struct Replay {
    wire: Wire,
    sensors: Sensors,
    open: Vec<Option<Packet>>,
}

impl Replay {
    /// Powers up the servos of a scenario's first exchange. `position` is
    /// where the first servo's sensor stands if the record does not have it.
    ///
    /// # Panics
    /// If the exchange lacks the contents of the servos' EEPROMs.
    pub fn new(first: &Exchange, position: Option<u16>) -> Self {
        let roms = first.power_up.as_ref().expect("a first exchange");
        let servos = roms
            .iter()
            .map(|rom| Servo::new(rom.0.as_slice().try_into().expect("11 EEPROM registers")))
            .collect();
        let mut readings: Vec<_> = first
            .bus
            .iter()
            .map(|servo| Reading {
                position: servo.position,
                temperature: servo.temperature,
            })
            .collect();
        if let Some(position) = position {
            readings[0].position = position;
        }
        let mut wire = Wire::new(servos);
        wire.record();
        Self {
            open: vec![None; first.bus.len()],
            wire,
            sensors: Sensors {
                readings,
                changes: Vec::new(),
            },
        }
    }

    /// Replays the scenario's next exchange.
    pub fn exchange(&mut self, exchange: &Exchange) -> Outcome {
        let before: Vec<_> = self.wire.morpheus().map(Servo::overruns).collect();
        for event in &exchange.events {
            self.wire.advance(ns(event.t_us), &mut self.sensors);
            let reading = &mut self.sensors.readings[event.servo];
            match event.kind {
                EventKind::Position => reading.position = event.counts.unwrap_or_default(),
                EventKind::Temperature => reading.temperature = event.counts.unwrap_or_default(),
                EventKind::PowerCycle => {
                    self.wire.power_cycle(event.servo, &mut self.sensors);
                }
                EventKind::Disconnect => self.wire.connect(event.servo, false),
                EventKind::Connect => self.wire.connect(event.servo, true),
            }
        }
        self.wire.advance(ns(exchange.t_us), &mut self.sensors);
        self.sensors.changes.clear();
        self.skip_records();
        // The recorded master kept the servos' rates: 0.5 us times a whole number.
        let divisor = (2e6 / f64::from(exchange.baud)).round();
        let byte_us = 5.0 * divisor;
        let baud = (2e6 / divisor) as u32;
        let mut sent = Vec::new();
        for (i, &byte) in exchange.tx.0.iter().enumerate() {
            let start = exchange.t_us + i as f64 * (byte_us + exchange.byte_gap_us);
            self.wire.send(ns(start), byte, baud);
            sent.push((ns(start), ns(start + byte_us)));
        }
        let end = sent.last().map_or(ns(exchange.t_us), |&(_, end)| end);
        let until = end + ns(exchange.window_us);
        self.wire.advance(until, &mut self.sensors);

        let mut outcome = Outcome {
            packets: Vec::new(),
            collision: false,
            wire: Vec::new(),
            pwm_changes: Vec::new(),
            overruns: Vec::new(),
            servos: self.wire.morpheus().cloned().collect(),
        };
        let mut senders: Vec<_> = sent.into_iter().map(|(s, e)| (usize::MAX, s, e)).collect();
        for record in self.wire.take_records() {
            match record {
                Record::Decoded(byte) => outcome.wire.push(byte),
                Record::Released { servo, at_ns } => {
                    let last = outcome.packets.iter_mut().rev().find(|p| p.servo == servo);
                    if let Some(packet) = last {
                        packet.release_us = Some(us(at_ns as i64 - packet.end_ns as i64));
                    }
                }
                Record::Sent {
                    servo,
                    byte,
                    start_ns,
                    end_ns,
                } => {
                    senders.push((servo, start_ns, end_ns));
                    self.byte_sent(servo, byte, start_ns, end_ns, end, &mut outcome);
                }
            }
        }
        outcome.packets.extend(self.open.iter().flatten().cloned());
        for packet in &mut outcome.packets {
            packet.complete &= packet.end_ns <= until;
        }
        // One that began in an earlier exchange was counted there.
        let began = |packet: &Packet| packet.start_ns >= ns(exchange.t_us);
        outcome.packets.retain(began);
        outcome.packets.sort_by_key(|packet| packet.start_ns);
        outcome.collision = senders
            .iter()
            .any(|a| senders.iter().any(|b| a.0 < b.0 && a.1 < b.2 && b.1 < a.2));
        outcome.pwm_changes = self
            .sensors
            .changes
            .iter()
            .map(|&(servo, at, pwm)| (servo, us(at as i64 - end as i64), pwm))
            .collect();
        outcome.overruns = self
            .wire
            .morpheus()
            .zip(before)
            .map(|(servo, before)| servo.overruns() - before)
            .collect();
        outcome
    }

    /// Bytes sent between two exchanges belong to none.
    fn skip_records(&mut self) {
        let records = self.wire.take_records();
        let mut nobody = Outcome {
            packets: Vec::new(),
            collision: false,
            wire: Vec::new(),
            pwm_changes: Vec::new(),
            overruns: Vec::new(),
            servos: Vec::new(),
        };
        for record in records {
            if let Record::Sent {
                servo,
                byte,
                start_ns,
                end_ns,
            } = record
            {
                self.byte_sent(servo, byte, start_ns, end_ns, 0, &mut nobody);
            }
        }
    }

    fn byte_sent(
        &mut self,
        servo: usize,
        byte: u8,
        start_ns: u64,
        end_ns: u64,
        request_end_ns: u64,
        outcome: &mut Outcome,
    ) {
        let packet = self.open[servo].get_or_insert_with(|| Packet {
            servo,
            bytes: Vec::new(),
            latency_us: us(start_ns as i64 - request_end_ns as i64),
            max_gap_us: 0.0,
            release_us: None,
            complete: false,
            start_ns,
            end_ns: start_ns,
        });
        let gap = us(start_ns as i64 - packet.end_ns as i64);
        packet.max_gap_us = packet.max_gap_us.max(gap);
        packet.bytes.push(byte);
        packet.end_ns = end_ns;
        let complete = packet
            .bytes
            .get(1)
            .is_some_and(|&len| packet.bytes.len() == usize::from(len) + 3);
        if complete {
            packet.complete = true;
            outcome.packets.extend(self.open[servo].take());
        }
    }
}
