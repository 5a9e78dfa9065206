//! The host dies, the bus falls silent, garbage floods the link: in lockstep, to
//! the µs of the board's time.
//!
//! | what              | until the stop sequence begins, in ms                   |
//! |-------------------|---------------------------------------------------------|
//! | host silent       | 500, and the tick in which that is noticed              |
//! | bus silent        | 20 ticks without a sample, and the one that was cut      |
//! | garbage, 12 Mbaud | 4096 bytes take 3.4, and the tick in which it is noticed |
//!
//! The sequence itself takes 7.1, what is on the bus before it 0.6 at the most.

use std::process::{Child, Command as Process, Stdio};

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_client::endpoint::{Endpoint, Exposure};
use armbridge_client::tcp_pump;
use armbridge_link::message::{Command, Drive, Fault, Setup, StopSource};
use armbridge_sim::link_server::LinkServer;
use armbridge_tests::sinusoid;

use super::driving_host::DrivingHost;
use super::tap::{OFF, pwm, run, until};

/// A tick.
const TICK_US: u64 = 1_000;
/// From a fault to the last bit of the stop sequence: what is on the bus is
/// finished, the sequence takes 7.1 ms.
const STOP_US: u64 = 8_000;

/// Where the process that is killed finds the link.
const LINK: &str = "ARMBRIDGE_TEST_LINK";

/// A process, killed when dropped.
struct Doomed(Child);

impl Doomed {
    /// Kills it as nothing can be caught (SIGKILL), and sees it dead.
    fn kill(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }
}

impl Drop for Doomed {
    fn drop(&mut self) {
        // It may be dead already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The other process: lets the arm follow a wave until it is killed.
fn be_the_host(link: &str) {
    let script = Script {
        setup: Setup::default(),
        limits: Script::limits(),
        commands: vec![(0, Command::Follow(sinusoid(60.0)))],
        duration_us: 60_000_000,
    };
    let at: Endpoint = link.parse().unwrap();
    let mut runner = PlanRunner::new(script);
    tcp_pump::run(&mut at.connect().unwrap(), &mut runner, 1).unwrap();
}

/// This test runs itself once more, as the host.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_killed_host_is_a_silent_host() {
    if let Ok(link) = std::env::var(LINK) {
        return be_the_host(&link);
    }
    let any_port: Endpoint = "tcp://127.0.0.1:0".parse().unwrap();
    let (listener, at) = any_port.listen(Exposure::Loopback).unwrap();
    let mut run = run(LinkServer::new(listener).unwrap());
    let name = "faults::external::a_killed_host_is_a_silent_host";
    let host = Process::new(std::env::current_exe().unwrap())
        .args(["--exact", name, "--ignored"])
        .env(LINK, at.to_string())
        .stdout(Stdio::null())
        .spawn();
    let mut host = Doomed(host.unwrap());

    until(&mut run, 10_000_000, |run| {
        let last = run.board.records.last();
        last.is_some_and(|record| record.mode.drive() == Some(Drive::Track)) && pwm(run) != OFF
    });
    host.kill();
    until(&mut run, 1_000_000, |run| !run.board.trips.is_empty());
    let silent_us = run.board.host_spoke_us;
    let later_us = run.now_us() + STOP_US;
    until(&mut run, 1_000_000, |run| run.now_us() > later_us);

    let trip = run.board.trips[0];
    assert_eq!(trip.fault, Fault::HostSilent);
    let allowed = silent_us + 500_000..silent_us + 500_000 + 2 * TICK_US;
    assert!(
        allowed.contains(&trip.at_us),
        "{trip:?}, silent at {silent_us}"
    );
    let (_, stopped_us) = run.board.stopped_us(silent_us).unwrap();
    assert!(stopped_us < silent_us + 500_000 + 2 * TICK_US + STOP_US);
    assert_eq!(pwm(&run), OFF);

    // In between the arm is braked and held.
    let since = |ms: u64| {
        let records = run.board.records.iter();
        records.filter(move |record| record.input.start_us > silent_us + ms * 1_000)
    };
    let until_held = since(0).find(|record| record.mode.drive() == Some(Drive::Hold));
    let held_us = until_held.unwrap().input.start_us - silent_us;
    // A tick is decided after it has begun.
    let allowed = 100_000 - TICK_US..100_000 + 2 * TICK_US;
    assert!(allowed.contains(&held_us), "{held_us}");
    let held = since(105).take_while(|record| record.input.start_us < silent_us + 499_000);
    assert!(held.clone().count() > 380);
    assert!(
        held.clone()
            .all(|record| record.mode.drive() == Some(Drive::Hold))
    );
}

/// The wire between board and servos breaks: the board receives nothing, and the servos
/// keep their last command. Once it is whole again, the next tick switches them off.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_bus_that_stops_is_told_to_stop() {
    let mut run = run(DrivingHost::new(Command::Regulate([0.0; 2])));
    until(&mut run, 3_000_000, |run| {
        run.board.is_driven() && pwm(run) != OFF
    });
    run.board.is_cut = true;
    let cut_us = run.now_us();
    until(&mut run, 28_000, |run| {
        run.board.stopped_us(cut_us).is_some()
    });
    let trip = run.board.trips[0];
    assert_eq!(trip.fault, Fault::ServoSilent);
    let (_, stopped_us) = run.board.stopped_us(cut_us).unwrap();
    assert!(stopped_us <= cut_us + 28_000, "{}", stopped_us - cut_us);
    assert_ne!(pwm(&run), OFF, "they cannot have heard it");

    run.board.is_cut = false;
    let whole_us = run.now_us();
    until(&mut run, 2 * TICK_US, |run| pwm(run) == OFF);
    let later_us = whole_us + 200_000;
    until(&mut run, 300_000, |run| run.now_us() > later_us);
    assert_eq!(pwm(&run), OFF);
}

/// At the full rate of the real board's link, whose bytes come as fast as USB has
/// them.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_flood_of_garbage_is_an_emergency_stop() {
    let mut run = run(DrivingHost::new(Command::Regulate([0.0; 2])));
    until(&mut run, 3_000_000, |run| {
        run.board.is_driven() && pwm(run) != OFF
    });
    run.host.is_flooding = true;
    let begun_us = run.now_us();
    let end_us = begun_us + 50_000;
    until(&mut run, 60_000, |run| run.now_us() > end_us);
    run.host.is_flooding = false;
    until(&mut run, 200_000, |run| {
        let last = run.board.records.last();
        last.is_some_and(|record| record.input.start_us > end_us)
    });

    let trip = run.board.trips[0];
    assert_eq!(trip.fault, Fault::EmergencyStop(StopSource::Flood));
    let (_, stopped_us) = run.board.stopped_us(begun_us).unwrap();
    assert!(trip.at_us <= begun_us + 4_000 + TICK_US, "{trip:?}");
    assert!(stopped_us <= begun_us + 4_000 + TICK_US + STOP_US);
    assert_eq!(pwm(&run), OFF);
    assert!(
        run.board
            .records
            .iter()
            .all(|record| record.timing.missed == 0)
    );
}
