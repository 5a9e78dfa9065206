//! Pins (section 8): mode, output, pull, alternate function, and the level that results.
//!
//! A level is what is on the wire: the output's, else what the outside drives, else what
//! the outside's resistor or the pin's own pulls. Changes of pins that a test watches are
//! recorded with their time.

use crate::time::Time;

/// A pin: port from 0 for A, and number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Pin {
    /// Port, 0 for A.
    pub port: u8,
    /// Number, 0 to 15.
    pub number: u8,
}

impl Pin {
    /// The pin of a port by its letter.
    pub const fn new(port: char, number: u8) -> Self {
        Self {
            port: port as u8 - b'A',
            number,
        }
    }
}

/// A change of a watched pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Time of the change.
    pub at: Time,
    /// The pin.
    pub pin: Pin,
    /// Its level from then on.
    pub is_high: bool,
}

#[derive(Clone, Debug, Default)]
struct Port {
    mode: u32,
    kind: u32,
    speed: u32,
    pull: u32,
    output: u32,
    alternate: [u32; 2],
    /// Pins that the outside drives, and to which level.
    driven: u32,
    driven_high: u32,
}

/// Ports of a chip: A to I.
const PORTS: usize = 9;

/// All pins.
#[derive(Clone, Debug)]
pub struct Gpio {
    ports: [Port; PORTS],
    watched: Vec<(Pin, bool)>,
    edges: Vec<Edge>,
}

impl Gpio {
    /// Pins as after a reset (section 8.4), and those to be watched.
    pub fn new(watched: &[Pin]) -> Self {
        let mut ports: [Port; PORTS] = Default::default();
        // The debug port's pins.
        ports[0].mode = 0xA800_0000;
        ports[0].pull = 0x6400_0000;
        ports[1].mode = 0x0000_0280;
        ports[1].pull = 0x0000_0100;
        let mut gpio = Self {
            ports,
            watched: Vec::new(),
            edges: Vec::new(),
        };
        gpio.watched = watched.iter().map(|pin| (*pin, gpio.level(*pin))).collect();
        gpio
    }

    /// All pins float again, as a reset leaves them; what the outside drives stays.
    pub fn reset(&mut self, now: Time) {
        let fresh = Self::new(&[]);
        for (port, fresh) in self.ports.iter_mut().zip(fresh.ports) {
            *port = Port {
                driven: port.driven,
                driven_high: port.driven_high,
                ..fresh
            };
        }
        self.note_edges(now);
    }

    /// Drives a pin from outside, or lets go of it.
    pub fn drive(&mut self, now: Time, pin: Pin, is_high: Option<bool>) {
        let port = &mut self.ports[usize::from(pin.port)];
        let bit = 1 << pin.number;
        match is_high {
            None => port.driven &= !bit,
            Some(is_high) => {
                port.driven |= bit;
                port.driven_high = port.driven_high & !bit | u32::from(is_high) << pin.number;
            }
        }
        self.note_edges(now);
    }

    /// Level of a pin; a floating one is low, as the resistors of the board make it.
    pub fn level(&self, pin: Pin) -> bool {
        let port = &self.ports[usize::from(pin.port)];
        let bit = 1_u32 << pin.number;
        let field = |register: u32| register >> (2 * pin.number) & 3;
        match field(port.mode) {
            1 => port.output & bit != 0,
            _ if port.driven & bit != 0 => port.driven_high & bit != 0,
            _ => field(port.pull) == 1,
        }
    }

    /// Alternate function of a pin, if it has one.
    pub fn alternate(&self, pin: Pin) -> Option<u32> {
        let port = &self.ports[usize::from(pin.port)];
        let number = usize::from(pin.number);
        (port.mode >> (2 * number) & 3 == 2)
            .then(|| port.alternate[number / 8] >> (4 * (number % 8)) & 0xF)
    }

    /// Changes of the watched pins so far.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Reads a register of port `port`.
    pub fn read(&self, port: usize, offset: u32) -> Option<u32> {
        let ports = self.ports.get(port)?;
        Some(match offset {
            0x00 => ports.mode,
            0x04 => ports.kind,
            0x08 => ports.speed,
            0x0C => ports.pull,
            0x10 => (0..16).fold(0, |word, number| {
                let pin = Pin {
                    port: port as u8,
                    number,
                };
                word | u32::from(self.level(pin)) << number
            }),
            0x14 => ports.output,
            0x18 | 0x1C => 0,
            0x20 => ports.alternate[0],
            0x24 => ports.alternate[1],
            _ => return None,
        })
    }

    /// Writes a register of port `port`; `None` if there is none.
    pub fn write(&mut self, now: Time, port: usize, offset: u32, value: u32) -> Option<()> {
        let ports = self.ports.get_mut(port)?;
        match offset {
            0x00 => ports.mode = value,
            0x04 => ports.kind = value & 0xFFFF,
            0x08 => ports.speed = value,
            0x0C => ports.pull = value,
            0x14 => ports.output = value & 0xFFFF,
            // Setting a bit has priority over resetting it (section 8.4.7).
            0x18 => ports.output = ports.output & !(value >> 16) | value & 0xFFFF,
            0x20 => ports.alternate[0] = value,
            0x24 => ports.alternate[1] = value,
            0x10 | 0x1C => {}
            _ => return None,
        }
        self.note_edges(now);
        Some(())
    }

    fn note_edges(&mut self, now: Time) {
        for index in 0..self.watched.len() {
            let (pin, was_high) = self.watched[index];
            let is_high = self.level(pin);
            if is_high != was_high {
                self.watched[index].1 = is_high;
                self.edges.push(Edge {
                    at: now,
                    pin,
                    is_high,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pin_floats_low_until_it_is_an_output() {
        let pin = Pin::new('C', 6);
        let mut gpio = Gpio::new(&[pin]);
        let mut write = |us, offset, value| gpio.write(Time::from_us(us), 2, offset, value);
        assert_eq!(write(1, 0x18, 1 << 6), Some(()));
        assert_eq!(write(2, 0x00, 1 << 12), Some(()));
        assert_eq!(write(3, 0x18, 1 << 22), Some(()));
        assert_eq!(write(3, 0x28, 0), None);
        let edge = |us, is_high| Edge {
            at: Time::from_us(us),
            pin,
            is_high,
        };
        assert_eq!(gpio.edges(), [edge(2, true), edge(3, false)]);
    }

    #[test]
    fn an_input_follows_the_outside_and_else_its_pull() {
        let pin = Pin::new('B', 8);
        let mut gpio = Gpio::new(&[]);
        assert_eq!(gpio.write(Time::ZERO, 1, 0x0C, 1 << 16), Some(()));
        assert!(gpio.level(pin));
        gpio.drive(Time::ZERO, pin, Some(false));
        assert!(!gpio.level(pin));
        assert_eq!(gpio.read(1, 0x10).map(|word| word >> 8 & 1), Some(0));
    }
}
