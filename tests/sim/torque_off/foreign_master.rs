//! Another master on the servo bus, which sets both motors on while they have to be off: what
//! it does is seen and undone within 100 ms, and by every stop at once.

use armbridge_link::message::{Command, Mode, Setup, ToBoard};
use armbridge_link::schema;
use armbridge_servo::Firmware;
use armbridge_sim::faults::port_client::Method;
use armbridge_tests::torque_off::cases::{all, check, run_cases};
use armbridge_tests::torque_off::rig::{Rig, STOP_US, World, bench, between_obstacles, with_rig};

/// Within which it is undone, in µs.
const UNDONE_US: u64 = 100_000;
/// Packets until one has to have an effect.
const ATTEMPTS: usize = 500;

/// Sets motors on, as another master does: packet by packet, again until one is on. Returns
/// when that was.
fn set_on(rig: &mut Rig<'_>, method: Method) -> u64 {
    let mut packets = method.preparation();
    let drive = method.packets();
    match method {
        Method::Pwm => packets.extend(drive.chunks(drive.len() / 2).map(<[u8]>::to_vec)),
        Method::Speeds | Method::Goals | Method::Duties => packets.push(drive),
    }
    for attempt in 0..ATTEMPTS {
        let packet = &packets[attempt % packets.len()];
        let now_us = rig.now_us();
        rig.cosim.bench.send_foreign(now_us, packet, 1_000_000);
        // Another phase of the ticks each time.
        let until_us = now_us + 1_137;
        while rig.now_us() < until_us {
            rig.until_us(rig.now_us() + 50);
            if rig.is_on() != [false; 2] {
                return rig.now_us();
            }
        }
    }
    panic!("{method:?}: no motor is on after {ATTEMPTS} packets")
}

/// The board stopped or idle, with motors seen to be off.
fn settle(rig: &mut Rig<'_>, method: Method, is_prepared: bool, period_us: u32, is_fault: bool) {
    if method.firmware() != Firmware::Morpheus && is_prepared {
        rig.prepare();
    }
    let setup = Setup {
        period_us,
        ..Setup::default()
    };
    assert_eq!(rig.command(Command::Configure(setup)), Ok(()));
    if is_fault {
        rig.host().send(ToBoard::Stop);
    }
    rig.pass_ms(1_000);
    assert_eq!(is_fault, matches!(rig.mode(), Some(Mode::Fault(_))));
}

fn cases() -> Vec<(Method, bool, u32, bool)> {
    let mut cases = Vec::new();
    for method in Method::AX12A.into_iter().chain([Method::Duties]) {
        for is_prepared in [false, true] {
            // In wheel mode a goal has no effect.
            if is_prepared && method == Method::Goals {
                continue;
            }
            // At 1 kHz the ticks of X servos leave no time for another's packet.
            let shortest_us = if method == Method::Duties {
                2_000
            } else {
                1_000
            };
            for period_us in [shortest_us, 10_000, 45_000] {
                for is_fault in [false, true] {
                    cases.push((method, is_prepared, period_us, is_fault));
                }
            }
        }
    }
    cases
}

#[test]
fn what_another_master_sets_on_is_off_within_100_ms_for_as_long_as_it_tries() {
    run_cases(cases(), |&(method, is_prepared, period_us, is_fault)| {
        let bench = bench(&between_obstacles(), method.firmware());
        with_rig(World::Bench, bench, |rig| {
            settle(rig, method, is_prepared, period_us, is_fault);
            let mut results = Vec::new();
            for wait_ms in [0, 13, 50, 1_000] {
                rig.pass_ms(wait_ms);
                let on_us = set_on(rig, method);
                results.push(rig.stays_off(on_us + UNDONE_US, 300));
            }
            // A report is as old as its read-backs: between them and it the other master may have
            // been faster. The last one is true.
            if is_fault {
                results.push(rig.is_reported_off());
            }
            let failures: Vec<String> = results.into_iter().filter_map(Result::err).collect();
            check(failures.is_empty(), || failures.join("; "))
        })
    });
}

/// An order that ends in motors off.
#[derive(Clone, Copy, Debug)]
enum Order {
    Stop,
    Pin,
    Hello,
    Goodbye,
    Idle,
}

#[test]
fn every_stop_acts_at_once_also_in_a_fault() {
    use Order::{Goodbye, Hello, Idle, Pin, Stop};
    let orders = [Stop, Pin, Hello, Goodbye, Idle];
    let cases = orders.map(|order| [false, true].map(|is_prepared| (order, is_prepared)));
    run_cases(cases.concat(), |&(order, is_prepared)| {
        let method = Method::Speeds;
        let bench = bench(&between_obstacles(), method.firmware());
        with_rig(World::Bench, bench, |rig| {
            settle(rig, method, is_prepared, 1_000, true);
            // The order comes in every phase of the read-backs.
            let results = [0, 7, 14, 21, 28, 35].map(|wait_ms| {
                // After a goodbye only a hello is heard.
                rig.host().begin_session();
                rig.pass_ms(200 + wait_ms);
                let ordered_us = set_on(rig, method);
                match order {
                    Stop => drop(rig.host().send(ToBoard::Stop)),
                    Pin => rig.cosim.is_stop_pressed = true,
                    Hello => drop(rig.host().send(ToBoard::Hello(schema::HELLO))),
                    Goodbye => drop(rig.host().send(ToBoard::Goodbye)),
                    Idle => drop(rig.host().command(Command::Idle)),
                }
                let off = rig.stays_off(ordered_us + STOP_US, 100);
                rig.cosim.is_stop_pressed = false;
                off
            });
            all(results)
        })
    });
}
