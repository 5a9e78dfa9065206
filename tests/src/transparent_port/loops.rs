//! A control loop with a client that never stops asking.

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_board::bridge::Channels;
use armbridge_link::message::{PortCounters, Record, Setup};
use armbridge_servo::Firmware;
use armbridge_sim::board::{Board, VirtualBoard};
use armbridge_sim::cosim::{Cosim, NoPortClient, PortClient};

use super::bench;
use super::client::{Hammer, Tally, curious};
use crate::{assert_undisturbed, calibrations, emulated_board, plant, settling_s};

const DURATION_US: u64 = 2_000_000;
/// When the client begins, in µs: stock servos are brought up in 0.18 s, and the
/// loop has been running for a while.
const CLIENT_FROM_US: u64 = 400_000;

/// 1 kHz on Morpheus servos; on others, which may take 0.95 ms of each, there
/// is slack only at half of that.
fn period_us(firmware: Firmware) -> u32 {
    match firmware {
        Firmware::Morpheus => 1_000,
        Firmware::Stock | Firmware::XSeries => 2_000,
    }
}

fn run<B: Board>(
    board: B,
    firmware: Firmware,
    client: Option<Hammer>,
) -> (Vec<Record>, PortCounters)
where
    B::Error: std::fmt::Debug,
{
    let bench = bench(&plant([0.3, -0.25], false), [firmware; 2], 1_000_000);
    let setup = Setup {
        period_us: period_us(firmware),
        joints: calibrations(firmware),
        ..Setup::default()
    };
    let script = Script::upright(setup, DURATION_US);
    let client: Box<dyn PortClient> = match client {
        Some(client) => Box::new(client),
        None => Box::new(NoPortClient),
    };
    let mut cosim = Cosim::new(board, bench, PlanRunner::new(script)).with_client(client);
    cosim.run().expect("a run");
    let port = cosim.host.status().port;
    (cosim.host.into_parts().0, port)
}

/// A run on the bench: its records, and the port's counters.
pub fn on_bench(firmware: Firmware, client: Option<Hammer>) -> (Vec<Record>, PortCounters) {
    let mut channels = Channels::new();
    let board = VirtualBoard::new(channels.split()).unwrap();
    run(board, firmware, client)
}

/// A run of the firmware image under QEMU.
pub fn in_emulator(firmware: Firmware, client: Option<Hammer>) -> (Vec<Record>, PortCounters) {
    run(emulated_board(false), firmware, client)
}

/// Control quality of the loop.
#[derive(Debug)]
struct Control {
    settled_s: f32,
    /// Largest distance from upright in the last 250 ticks, in rad.
    rest_rad: f32,
    /// Mean time of a tick's exchange in µs.
    bus_us: f32,
}

/// Properties of every loop on an arm without friction, with a client or without.
#[track_caller]
fn control(records: &[Record]) -> Control {
    assert!(records.len() > 990, "{} records", records.len());
    assert_undisturbed(records);
    for record in records {
        assert_eq!(record.timing.start_error_us, 0, "{record:?}");
    }
    let settled = [0, 1].map(|joint| settling_s(records, joint, 0.02).expect("settled"));
    let end = &records[records.len() - 250..];
    let far = end
        .iter()
        .flat_map(|record| record.output.angle_rad)
        .map(f32::abs);
    let bus_us = records.iter().map(|record| record.timing.bus_us as f32);
    Control {
        settled_s: settled[0].max(settled[1]) as f32,
        rest_rad: far.fold(0.0, f32::max),
        bus_us: bus_us.sum::<f32>() / records.len() as f32,
    }
}

#[track_caller]
fn answered(tally: &Tally, port: PortCounters, firmware: Firmware) {
    assert_eq!(tally.wrong, [""; 0], "{firmware}");
    let settled = tally.answered + tally.refused + tally.silent;
    assert!(tally.requests - settled <= 1, "{tally:?}");
    assert!(tally.answered > 200 && tally.refused > 20, "{tally:?}");
    // The last report is up to 0.1 s old.
    assert!(port.passed > 150 && port.refused > 20, "{port:?}");
    assert_eq!((port.halves, port.lost), (0, 0), "{port:?}");
}

/// Runs a loop without and with a client that never stops asking, and compares them.
pub fn hammered(
    firmware: Firmware,
    world: fn(Firmware, Option<Hammer>) -> (Vec<Record>, PortCounters),
) {
    let client = client(firmware);
    let (alone, _) = world(firmware, None);
    let (shared, port) = world(firmware, Some(client.clone()));
    let tally = client.tally();
    answered(&tally, port, firmware);
    let (alone, shared) = (control(&alone), control(&shared));
    println!(
        "{firmware}: alone {alone:?}, with a client {shared:?}; asked {}, answered {}, refused {}, \
         silent {}, slowest {} us, {port:?}",
        tally.requests, tally.answered, tally.refused, tally.silent, tally.slowest_us
    );
    // As well as ever: upright within a count and a half of the encoder, in the
    // same time but for the noise of the encoders.
    for control in [&alone, &shared] {
        assert!(
            control.settled_s < 1.1 && control.rest_rad < 0.0077,
            "{control:?}"
        );
    }
    assert!(
        (alone.settled_s - shared.settled_s).abs() < 0.05,
        "{alone:?} {shared:?}"
    );
    // Less margin, while a client waits.
    assert!(shared.bus_us < alone.bus_us + 5.0, "{alone:?} {shared:?}");
}

/// A client for the whole of a run.
pub fn client(firmware: Firmware) -> Hammer {
    Hammer::new(curious(firmware), CLIENT_FROM_US, DURATION_US)
}
