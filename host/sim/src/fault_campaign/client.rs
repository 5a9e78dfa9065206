//! Client of the transparent port in a case: it drives both motors, and goes wrong.

use armbridge_servo::Firmware;

use crate::faults::port_client::{ClientHandle, ClientStep, Method};

/// Time between two packets of the client, in µs.
const PACKET_US: u64 = 10_000;
/// Time for each step of making the servos ready, in µs: with a slow bus and the stop
/// sequence before it.
const STEP_US: u64 = 50_000;
/// Time in µs in which the board hands over the bus: a stop sequence at 57 600 baud is 52 ms.
const HANDOVER_US: u64 = 100_000;
/// Value that sets another rate in a servo of either firmware, and the rate.
const OTHER_RATES: [(u8, u32); 2] = [(3, 500_000), (1, 1_000_000)];

/// A client that drives servos of one firmware.
#[derive(Clone, Debug)]
pub(super) struct Client {
    pub(super) port: ClientHandle,
    method: Method,
    baud: u32,
    is_driving: bool,
}

impl Client {
    /// A client that has not opened its port yet.
    pub(super) fn new(servos: Firmware, baud: u32) -> Self {
        Self {
            port: ClientHandle::default(),
            method: match servos {
                Firmware::Morpheus => Method::Pwm,
                Firmware::Stock => Method::Speeds,
                Firmware::XSeries => Method::Duties,
            },
            baud,
            is_driving: false,
        }
    }

    /// Steps by which it opens its port, makes the servos ready and drives them, from this
    /// time on, and the time after them.
    fn drive_steps(&self, from_us: u64) -> (Vec<(u64, ClientStep)>, u64) {
        let mut at_us = from_us;
        let mut steps = vec![(at_us, ClientStep::Open(self.baud))];
        // What comes while the board stops the motors before it hands the bus over is dropped.
        at_us += HANDOVER_US;
        for packet in self.method.preparation() {
            steps.push((at_us, ClientStep::Send(packet)));
            at_us += STEP_US;
        }
        let stream = ClientStep::Stream(self.method.packets(), PACKET_US);
        steps.push((at_us, stream));
        (steps, at_us + STEP_US)
    }

    /// Drives both motors from this time on.
    pub(super) fn drive(&mut self, from_us: u64) {
        self.port.schedule(self.drive_steps(from_us).0);
        self.is_driving = true;
    }

    /// The same, unless it does already; then `go_wrong` has the steps that follow.
    fn drive_then(
        &mut self,
        now_us: u64,
        go_wrong: impl FnOnce(u64) -> Vec<(u64, ClientStep)>,
    ) -> u64 {
        let (mut steps, from_us) = if self.is_driving {
            (Vec::new(), now_us)
        } else {
            self.drive_steps(now_us)
        };
        self.is_driving = true;
        steps.extend(go_wrong(from_us));
        self.port.schedule(steps);
        from_us
    }

    /// It drives, and hangs with its port open.
    pub(super) fn hang(&mut self, now_us: u64) {
        self.drive_then(now_us, |at_us| vec![(at_us, ClientStep::Hang)]);
    }

    /// It drives, sends half a packet and waits; returns when.
    pub(super) fn hang_inside_a_packet(&mut self, now_us: u64) -> u64 {
        let mut half = self.method.packets();
        half.truncate(half.len() / 2);
        self.drive_then(now_us, |at_us| {
            vec![(at_us, ClientStep::Hang), (at_us, ClientStep::Send(half))]
        })
    }

    /// It drives, gives both servos another rate, and drives on at that.
    pub(super) fn change_rate(&mut self, now_us: u64) {
        let is_other = |(_, baud): &&(u8, u32)| *baud != self.baud;
        let (register, baud) = OTHER_RATES
            .iter()
            .find(is_other)
            .copied()
            .unwrap_or_default();
        let method = self.method;
        self.drive_then(now_us, |at_us| {
            let both = |packets: fn(Method, usize, u8) -> Vec<u8>| {
                [0, 1]
                    .map(|servo| packets(method, servo, register))
                    .concat()
            };
            vec![
                (at_us, ClientStep::Hang),
                (at_us, ClientStep::Send(both(Method::rate))),
                (at_us + STEP_US, ClientStep::Open(baud)),
                (
                    at_us + STEP_US,
                    ClientStep::Send(both(|it, servo, _| it.again(servo))),
                ),
                (
                    at_us + 2 * STEP_US,
                    ClientStep::Stream(method.packets(), PACKET_US),
                ),
            ]
        });
    }
}
