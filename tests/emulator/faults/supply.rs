//! The output for the servos' supply, in lockstep: which stops cut it, and when.
//!
//! The virtual servos keep their power, so that the stop on the bus is seen as well.

use armbridge_link::message::{Command, Fault, Mode, StopSource, ToBoard};
use armbridge_sim::cosim::Cosim;

use super::driving_host::DrivingHost;
use super::tap::{OFF, Tap, pwm, run, until};

/// From the cause to the supply off, in µs: the turn of the real-time loop that finds it.
const CUT_US: f64 = 1_000.0;
/// The same from a fault after which motors are not confirmed off.
const UNCONFIRMED_US: f64 = 100_000.0;

type Run = Cosim<Tap, DrivingHost>;

/// A board that drives its arm.
fn driving() -> Run {
    let mut run = run(DrivingHost::new(Command::Regulate([0.0; 2])));
    until(&mut run, 3_000_000, |run| {
        run.board.is_driven() && pwm(run) != OFF
    });
    assert!(matches!(run.board.supply()[..], [(_, true)]));
    run
}

fn wait(run: &mut Run, us: u64) {
    let end_us = run.now_us() + us;
    until(run, us + 1_000, |run| run.now_us() >= end_us);
}

/// The board's last change of the supply was off, so many µs after `begun_us`; the fault is
/// `fault`, and the motors are off on the bus, too.
#[track_caller]
fn assert_cut(run: &Run, begun_us: u64, allowed_us: std::ops::Range<f64>, fault: Fault) {
    assert_eq!(run.board.trips.last().unwrap().fault, fault);
    let supply = run.board.supply();
    let Some((at_us, false)) = supply.last() else {
        panic!("{supply:?}")
    };
    // Of a whole nanosecond, so that nothing is negative by rounding.
    let took_us = ((at_us - begun_us as f64) * 1e3).round() * 1e-3;
    assert!(allowed_us.contains(&took_us), "{took_us} µs");
    assert_eq!(pwm(run), OFF);
}

/// Clears the fault, and sees the supply on and the servos found again.
#[track_caller]
fn clear(run: &mut Run) {
    run.host.client.command(Command::ClearFault);
    until(run, 1_000_000, |run| {
        let last = run.board.records.last();
        last.is_some_and(|record| record.mode == Mode::Idle)
    });
    let supply = run.board.supply();
    assert!(matches!(supply.last(), Some((_, true))), "{supply:?}");
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn every_emergency_stop_cuts_the_supply_until_it_is_cleared() {
    let mut run = driving();
    let begun_us = run.now_us();
    run.board.is_stop_pressed = true;
    wait(&mut run, 50_000);
    // What the host clears while the switch is open does not come back for a moment.
    run.host.client.command(Command::ClearFault);
    wait(&mut run, 50_000);
    let fault = |source| Fault::EmergencyStop(source);
    assert_cut(&run, begun_us, 0.0..CUT_US, fault(StopSource::Pin));
    run.board.is_stop_pressed = false;
    clear(&mut run);

    let begun_us = run.now_us();
    run.host.client.send(ToBoard::Stop);
    wait(&mut run, 50_000);
    assert_cut(&run, begun_us, 0.0..CUT_US, fault(StopSource::Host));
    clear(&mut run);

    let begun_us = run.now_us();
    run.host.is_flooding = true;
    wait(&mut run, 50_000);
    run.host.is_flooding = false;
    // 4096 bytes take 3.4 ms.
    assert_cut(
        &run,
        begun_us,
        3_000.0..4_000.0 + CUT_US,
        fault(StopSource::Flood),
    );
}

/// The host falls silent: motors are confirmed off, and the supply stays on.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_fault_with_motors_confirmed_off_leaves_the_supply_on() {
    let mut run = driving();
    run.host.is_silent = true;
    until(&mut run, 1_000_000, |run| !run.board.trips.is_empty());
    wait(&mut run, 1_000_000);
    assert_eq!(run.board.trips[0].fault, Fault::HostSilent);
    assert_eq!(run.board.supply().len(), 1, "{:?}", run.board.supply());

    // An emergency stop after it counts, although the fault is latched already.
    let begun_us = run.now_us();
    run.board.is_stop_pressed = true;
    wait(&mut run, 50_000);
    assert_cut(&run, begun_us, 0.0..CUT_US, Fault::HostSilent);
}

/// The wire to the servos is cut, which keep their last command.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn motors_that_are_not_confirmed_off_lose_their_supply() {
    let mut run = driving();
    run.board.is_cut = true;
    wait(&mut run, 200_000);
    let trip = run.board.trips[0];
    assert_eq!(trip.fault, Fault::ServoSilent);
    assert_ne!(pwm(&run), OFF, "they cannot have heard the stop");
    let supply = run.board.supply();
    let [(_, true), (at_us, false)] = supply[..] else {
        panic!("{supply:?}")
    };
    let took_us = at_us - trip.at_us as f64;
    let allowed_us = UNCONFIRMED_US..UNCONFIRMED_US + 2.0 * CUT_US;
    assert!(allowed_us.contains(&took_us), "{took_us} µs");
}
