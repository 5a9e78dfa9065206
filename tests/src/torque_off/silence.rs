//! Silence of a client of the transparent port that has driven the motors: its turn
//! on the bus ends.

use super::METHODS;
use super::cases::{all, check};
use super::client::Method;
use super::rig::{STOP_US, World, bench, between_obstacles, with_rig};

/// Silence of a client after which its turn ends, in µs: the default.
const SILENCE_US: u64 = 500_000;
/// Silence of a client that is only slow, in µs.
const SLOW_US: u64 = 250_000;
/// Time between two packets of the client, in µs.
const STREAM_US: u64 = 10_000;

/// Packets of a client before it hangs.
#[derive(Clone, Copy, Debug)]
pub enum Writes {
    /// One write.
    Once,
    /// A stream of writes.
    Stream,
}

/// Drives the motors, hangs, and has its turn ended.
pub fn is_ended(world: World, method: Method, writes: Writes) -> Result<(), String> {
    let bench = bench(&between_obstacles(), method.firmware());
    with_rig(world, bench, |rig| {
        rig.client_prepares(method);
        match writes {
            Writes::Once => rig.client.send(&method.packets()),
            Writes::Stream => rig.client.stream(method.packets(), STREAM_US),
        }
        rig.pass_ms(100);
        rig.client.hang();
        let hung_us = rig.client.written_us();
        rig.until_us(hung_us + SLOW_US);
        let (is_on, pwm) = (rig.is_on(), rig.motors());
        all([
            check(is_on == [true; 2], || {
                format!("PWM {pwm:?} after {SLOW_US} µs of silence")
            }),
            rig.stays_off(hung_us + SILENCE_US + STOP_US, world.watch_ms()),
            rig.reports_are_true(),
        ])
    })
}

/// Every method, with one write and with a stream.
pub fn cases() -> impl Iterator<Item = (Method, Writes)> {
    let both = |method| [Writes::Once, Writes::Stream].map(|writes| (method, writes));
    METHODS.into_iter().flat_map(both)
}
