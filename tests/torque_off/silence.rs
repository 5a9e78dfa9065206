//! Silence of a client of the transparent port that has driven the motors: its turn
//! on the bus ends.

use crate::cases::{all, check, run_cases};
use crate::client::Method;
use crate::rig::{STOP_US, World, bench, between_obstacles, with_rig};

/// Silence of a client after which its turn ends, in µs: the default.
const SILENCE_US: u64 = 500_000;
/// Silence of a client that is only slow, in µs.
const SLOW_US: u64 = 250_000;
/// Time between two packets of the client, in µs.
const STREAM_US: u64 = 10_000;
/// Time between two questions of a client that only asks, in µs.
const ASK_US: u64 = 100_000;

/// Packets of a client before it hangs.
#[derive(Clone, Copy, Debug)]
enum Writes {
    Once,
    Stream,
}

fn is_ended(world: World, method: Method, writes: Writes) -> Result<(), String> {
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

fn cases() -> impl Iterator<Item = (Method, Writes)> {
    let both = |method| [Writes::Once, Writes::Stream].map(|writes| (method, writes));
    Method::ALL.into_iter().flat_map(both)
}

#[test]
fn a_client_that_hangs_is_ended() {
    run_cases(cases(), |(method, writes)| {
        is_ended(World::Bench, *method, *writes)
    });
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_client_that_hangs_is_ended_by_the_firmware() {
    run_cases(cases(), |(method, writes)| {
        is_ended(World::Emulator, *method, *writes)
    });
}

/// A client that drives once and then only asks is not silent.
#[test]
fn a_client_that_asks_keeps_the_bus() {
    run_cases(Method::ALL, |method| {
        let bench = bench(&between_obstacles(), method.firmware());
        with_rig(World::Bench, bench, |rig| {
            rig.client_prepares(*method);
            rig.client.send(&method.packets());
            rig.client.stream(method.question(), ASK_US);
            rig.pass_ms(100);
            let before_us = rig.on_us();
            rig.pass_ms(3_000);
            let on_us = [0, 1].map(|servo| rig.on_us()[servo] - before_us[servo]);
            check(on_us == [3_000_000; 2], || {
                format!("motors on for {on_us:?} µs of 3 s")
            })
        })
    });
}
