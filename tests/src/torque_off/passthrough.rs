//! Emergency stops while a client of the transparent port drives the motors: they are
//! off and stay off, whatever the client does.

use armbridge_link::message::{Fault, StopSource, ToBoard};
use armbridge_servo::Firmware;

use super::cases::{all, check};
use super::client::Method;
use super::rig::{Rig, STOP_US, World, bench, between_obstacles, with_rig};

/// Time between two packets of the client, in µs.
const STREAM_US: u64 = 10_000;
/// Time between two bursts of a flood, in µs, and questions in each: more than the
/// bus carries.
const FLOOD_US: u64 = 1_000;
const FLOOD_PACKETS: usize = 5;
/// Rates with the value that sets them in an AX-12A of either firmware.
const RATES: [(u32, u8); 2] = [(500_000, 3), (57_600, 34)];
/// The same for the X series, one above and one below that of the board.
const X_RATES: [(u32, u8); 2] = [(2_000_000, 4), (57_600, 1)];
/// Garbage that is an emergency stop, in bytes.
const GARBAGE: u32 = 8_000;
/// Time from one stop to the next, in ms.
const BETWEEN_MS: u64 = 1_000;

/// Action of the client before the stop, beside driving the motors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Before {
    /// Only drives.
    Nothing,
    /// It asks more than the bus carries.
    Floods,
    /// It sets its port to another rate; the servos keep theirs.
    SetsLine(usize),
    /// It gives the first servo another rate, and keeps its own.
    SetsServo(usize),
    /// It gives the first servo another rate, and follows.
    SetsBoth(usize),
}

/// Source of a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The switch, pressed for 20 ms.
    Pin,
    /// The switch, pressed from then on.
    PinHeld,
    /// The host's message.
    Host,
    /// Garbage on the link.
    Garbage,
}

/// Action of the client after the stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum After {
    /// Goes on.
    Streams,
    /// Sends nothing more.
    Hangs,
    /// Closes the port.
    Closes,
}

#[derive(Clone, Copy, Debug)]
/// A client, a stop and what comes after it.
pub struct Case {
    method: Method,
    before: Before,
    stops: &'static [Stop],
    after: After,
}

const PLAIN: Case = Case {
    method: Method::Pwm,
    before: Before::Nothing,
    stops: &[Stop::Host],
    after: After::Streams,
};

/// Rates that a client gives these servos.
fn rates(method: Method) -> [(u32, u8); 2] {
    match method.firmware() {
        Firmware::Morpheus | Firmware::Stock => RATES,
        Firmware::XSeries => X_RATES,
    }
}

/// Stops of each kind, alone and after others, of this client.
pub fn stops(method: Method) -> Vec<Case> {
    use Stop::{Garbage, Host, Pin, PinHeld};
    const STOPS: [&[Stop]; 7] = [
        &[Pin],
        &[PinHeld],
        &[Host],
        &[Garbage],
        &[Host, Pin],
        &[Pin, Host, Host],
        &[Garbage, Host, Pin],
    ];
    let plain = Case { method, ..PLAIN };
    let streams = STOPS.map(|stops| Case { stops, ..plain });
    let after = [After::Hangs, After::Closes].map(|after| Case { after, ..plain });
    streams.into_iter().chain(after).collect()
}

/// Stops of this client after other actions.
pub fn befores(method: Method) -> Vec<Case> {
    let mut befores = vec![Before::Floods];
    for rate in 0..rates(method).len() {
        befores.extend([Before::SetsLine(rate), Before::SetsBoth(rate)]);
    }
    if method == Method::Pwm {
        // A stock or X servo that is driven takes no rate. At a lower one, the rest of a
        // packet that a servo waits for lasts longer than a stop may.
        befores.push(Before::SetsServo(0));
    }
    let cases = befores.into_iter().flat_map(|before| {
        [After::Streams, After::Closes].map(|after| Case {
            method,
            before,
            after,
            ..PLAIN
        })
    });
    cases.collect()
}

impl Rig<'_> {
    /// The client opens its port and makes the servos ready.
    pub fn client_prepares(&mut self, method: Method) {
        self.client.open(1_000_000);
        for packet in method.preparation() {
            self.client.send(&packet);
            self.pass_ms(50);
        }
    }

    /// The client drives both motors.
    pub fn client_drives(&mut self, method: Method) {
        self.client_prepares(method);
        self.client.stream(method.packets(), STREAM_US);
        self.pass_ms(200);
    }

    fn client_does(&mut self, method: Method, before: Before) {
        let rates = rates(method);
        match before {
            Before::Nothing => {}
            Before::Floods => {
                let burst = method.question().repeat(FLOOD_PACKETS);
                self.client.stream(burst, FLOOD_US);
            }
            Before::SetsLine(rate) => self.client.open(rates[rate].0),
            Before::SetsServo(rate) => self.client.send(&method.rate(0, rates[rate].1)),
            Before::SetsBoth(rate) => {
                let (baud, register) = rates[rate];
                self.client.send(&method.rate(0, register));
                self.pass_ms(50);
                self.client.open(baud);
                self.pass_ms(50);
                self.client.send(&method.again(0));
            }
        }
        self.pass_ms(200);
        if let Before::SetsServo(rate) | Before::SetsBoth(rate) = before {
            let register = u16::from(rates[rate].1);
            assert_eq!(self.rate_register(0), Some(register.into()), "{method:?}");
        }
    }

    /// Presses, sends or causes a stop.
    pub fn stop(&mut self, stop: Stop) {
        match stop {
            Stop::Pin | Stop::PinHeld => self.cosim.is_stop_pressed = true,
            Stop::Host => _ = self.host().send(ToBoard::Stop),
            Stop::Garbage => self.host().garbage(GARBAGE),
        }
    }
}

/// The fault that a stop is.
fn fault(stop: Stop) -> Fault {
    Fault::EmergencyStop(match stop {
        Stop::Pin | Stop::PinHeld => StopSource::Pin,
        Stop::Host => StopSource::Host,
        Stop::Garbage => StopSource::Flood,
    })
}

/// Runs a case: motors are off in time and stay off, and the reports are true.
pub fn is_stopped(world: World, case: &Case) -> Result<(), String> {
    let method = case.method;
    let bench = bench(&between_obstacles(), method.firmware());
    with_rig(world, bench, |rig| {
        rig.client_drives(method);
        rig.client_does(method, case.before);
        assert_eq!(rig.is_on(), [true; 2], "{case:?}: driven by the client");
        let off_us = rig.now_us() + STOP_US;
        let mut before_us = None;
        for (index, stop) in case.stops.iter().enumerate() {
            if index > 0 {
                rig.pass_ms(BETWEEN_MS);
            }
            rig.stop(*stop);
            rig.until_us(rig.now_us() + STOP_US);
            before_us.get_or_insert(rig.on_us());
            if *stop == Stop::Pin {
                rig.cosim.is_stop_pressed = false;
            }
        }
        match case.after {
            After::Streams => {}
            After::Hangs => rig.client.hang(),
            After::Closes => rig.client.close(),
        }
        rig.pass_ms(world.watch_ms());
        let (reported, first) = (rig.fault(), fault(case.stops[0]));
        all([
            rig.was_off(off_us, before_us.unwrap_or_default()),
            rig.reports_are_true(),
            check(reported == Some(first), || {
                format!("reported fault {reported:?}")
            }),
        ])
    })
}
