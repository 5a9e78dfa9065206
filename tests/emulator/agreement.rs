//! The firmware image under QEMU, in lockstep with the bench.
//!
//! No clock is involved: how busy the machine is changes how long these tests
//! take, and nothing else.

use armbridge_analysis::plan_runner::{PlanRunner, Script};
use armbridge_board::bridge::Channels;
use armbridge_client::endpoint::{Endpoint, Exposure};
use armbridge_client::tcp_pump;
use armbridge_control::estimate::Config;
use armbridge_link::limits::{Limits, Milliradians};
use armbridge_link::message::{Command, Drive, Fault, Mode, Record, Setup, StopSource};
use armbridge_link::motion::Motion;
use armbridge_servo::Pwm;
use armbridge_sim::Bench;
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::Cosim;
use armbridge_sim::link_server::LinkServer;
use armbridge_sim::plant::{Grip, Lead, LeadPoint, Plant};
use armbridge_tests::{computed_torque, emulated_board, plant, records, settling_s, sinusoid};

fn script() -> Script {
    let duration_us = 2_000_000;
    Script {
        setup: Setup::default(),
        limits: Script::limits(),
        commands: vec![
            (0, Command::Regulate([0.0, 0.0])),
            (1_500_000, Command::Regulate([0.1, -0.1])),
        ],
        duration_us,
    }
}

/// Everything there is, on an arm with friction: Kalman filter and LQR, a
/// motion, computed torque and an observer taken over in mid run, a wave, a
/// stream.
fn tour() -> Script {
    let computed_torque = computed_torque(15.0);
    let observer = Setup {
        estimator: Config::standing(),
        ..computed_torque
    };
    let there = Motion::MinimumJerk {
        to_rad: [0.3, -0.3],
        duration_s: Some(0.6),
    };
    let mut commands = vec![
        (0, Command::Regulate([0.0, 0.0])),
        (800_000, Command::Follow(there)),
        (1_600_000, Command::Configure(computed_torque)),
        (1_700_000, Command::Follow(sinusoid(1.6))),
        (2_600_000, Command::Configure(observer)),
    ];
    for point in 0..10_u64 {
        let at_us = 3_400_000 + 40_000 * point;
        let angle_rad = [0.005 * point as f32, -0.01 * point as f32];
        let stream = Command::Stream {
            at_us: at_us + 200_000,
            angle_rad,
            speed_rad_s: None,
        };
        commands.push((at_us, stream));
    }
    Script {
        setup: Setup::best(),
        limits: Script::limits(),
        commands,
        duration_us: 4_200_000,
    }
}

fn bench(friction_on: bool) -> Bench {
    Bench::new(Plant::new(plant([0.2, -0.2], friction_on), 1))
}

fn emulate(icount: bool) -> Vec<Record> {
    let mut run = Cosim::new(
        emulated_board(icount),
        bench(false),
        PlanRunner::new(script()),
    );
    run.run().unwrap();
    run.host.into_parts().0
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn all_controllers_and_motions_agree_with_the_bench() {
    let mut run = Cosim::new(emulated_board(false), bench(true), PlanRunner::new(tour()));
    run.run().unwrap();
    let emulated = without_measured_times(run.host.into_parts().0);
    let bench = without_measured_times(records(plant([0.2, -0.2], true), 1, tour()));
    assert_same(&emulated, &bench);

    let in_mode = |drive| driven_by(&bench, drive);
    assert!(in_mode(Drive::Regulate).count() > 700 && in_mode(Drive::Track).count() > 3_000);
    let furthest = |joint: usize| {
        let angles = in_mode(Drive::Track).map(|record| record.output.angle_rad[joint]);
        angles.fold(0.0_f32, |most, angle| most.max(angle.abs()))
    };
    assert!(furthest(0) > 0.29 && furthest(1) > 0.29, "it moved");
}

/// A hand leads an arm that floats; then it is parked, and lies on the table.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_float_and_a_park_agree_with_the_bench() {
    let script = Script {
        setup: Setup::best(),
        limits: Limits {
            park: Some([Milliradians(1_200), Milliradians(-200)]),
            ..Script::limits()
        },
        commands: vec![
            (0, Command::Regulate([0.2, -0.2])),
            (500_000, Command::Float),
            (3_500_000, Command::Park),
        ],
        duration_us: 13_000_000,
    };
    let hand = Lead {
        grip: Grip {
            link: 1,
            stiffness_n_m: 300.0,
            damping_n_s_m: 10.0,
        },
        start_ns: 1_500_000_000,
        path: vec![LeadPoint {
            after_ns: 1_200_000_000,
            angle_rad: [-0.2, 0.2],
        }],
        release_ns: 1_300_000_000,
    };
    let led = || {
        let mut bench = bench(true);
        bench.lead(&hand);
        bench
    };
    let mut run = Cosim::new(
        emulated_board(false),
        led(),
        PlanRunner::new(script.clone()),
    );
    run.run().unwrap();
    let emulated = without_measured_times(run.host.into_parts().0);
    let mut channels = Channels::new();
    let virtual_board = VirtualBoard::new(channels.split()).unwrap();
    let mut run = Cosim::new(virtual_board, led(), PlanRunner::new(script));
    run.run().unwrap();
    let bench = without_measured_times(run.host.into_parts().0);
    assert_same(&emulated, &bench);

    let in_mode = |drive| driven_by(&bench, drive);
    let angles = |mode| in_mode(mode).map(|record| record.output.angle_rad[0]);
    assert!(
        angles(Drive::Float).fold(1.0_f32, f32::min) < -0.1,
        "it was led"
    );
    assert!(
        angles(Drive::Park).fold(0.0_f32, f32::max) > 1.5,
        "it was lowered"
    );
    assert_eq!(bench.last().map(|record| record.mode), Some(Mode::Idle));
}

fn assert_same(emulated: &[Record], bench: &[Record]) {
    for (emulated, bench) in emulated.iter().zip(bench) {
        assert_eq!(emulated, bench);
    }
    assert_eq!(emulated.len(), bench.len());
}

fn driven_by(records: &[Record], drive: Drive) -> impl Iterator<Item = &Record> {
    let is_driven = move |record: &&Record| record.mode.drive() == Some(drive);
    records.iter().filter(is_driven)
}

fn without_measured_times(mut records: Vec<Record>) -> Vec<Record> {
    for record in &mut records {
        record.timing.compute_ns = 0;
    }
    records
}

/// One test, so that the runs are compared with each other.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn firmware_balances_and_repeats_and_agrees_with_the_bench() {
    let first = emulate(false);
    let to_first_setpoint: Vec<_> = first
        .iter()
        .copied()
        .take_while(|r| r.output.reference_rad == [0.0, 0.0])
        .collect();
    for joint in 0..2 {
        let settled_s = settling_s(&to_first_setpoint, joint, 0.020);
        assert!(
            settled_s.is_some_and(|s| s < 1.3),
            "joint {joint}: {settled_s:?}"
        );
    }
    assert!(first.iter().all(|record| record.timing.missed == 0));
    assert!(
        first.iter().any(|record| record.timing.compute_ns > 0),
        "compute time is measured"
    );

    let first = without_measured_times(first);
    assert_eq!(
        first,
        without_measured_times(emulate(false)),
        "two runs differ"
    );

    // The same code on another processor: the same bits.
    let bench = records(plant([0.2, -0.2], false), 1, script());
    assert_eq!(
        first,
        without_measured_times(bench),
        "emulator and bench differ"
    );
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn with_icount_measured_times_repeat_too() {
    assert_eq!(emulate(true), emulate(true));
}

/// Presses the stop switch while the arm is held, and watches the servos for the
/// 20 ms after it.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn the_stop_switch_is_heeded() {
    let mut run = Cosim::new(
        emulated_board(false),
        bench(false),
        PlanRunner::new(script()),
    );
    while run.now_us() < 500_000 {
        run.step().unwrap();
    }
    let pwm = |run: &Cosim<_, _>| [0, 1].map(|joint| run.bench.applied_pwm(joint));
    assert_ne!(pwm(&run), [Pwm::OFF.counts(); 2], "the arm is held");
    run.is_stop_pressed = true;
    let pressed_us = run.now_us();
    // A runner gives up when the fault is reported.
    while run.now_us() < pressed_us + 20_000 && run.step().is_ok() {}
    assert_eq!(pwm(&run), [Pwm::OFF.counts(); 2]);
    let fault = Fault::EmergencyStop(StopSource::Pin);
    let last = run.host.into_parts().0.pop();
    assert_eq!(last.map(|record| record.mode), Some(Mode::Fault(fault)));
}

/// Another program at the control link, over TCP: the board's time is held back
/// to the wall clock, and runs slower than it where the machine is busy, so the
/// time-outs of neither side depend on the machine.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn another_program_can_have_the_link() {
    let any_port: Endpoint = "tcp://127.0.0.1:0".parse().unwrap();
    let (listener, at) = any_port.listen(Exposure::Loopback).unwrap();
    let (done, is_done) = std::sync::mpsc::channel();
    let board = std::thread::spawn(move || {
        let mut run = Cosim::new(
            emulated_board(false),
            bench(false),
            LinkServer::new(listener).unwrap(),
        );
        while is_done.try_recv().is_err() {
            run.step().unwrap();
        }
        // The acknowledgement is sent a tick before the servos' packet.
        let later_us = run.now_us() + 20_000;
        while run.now_us() < later_us {
            run.step().unwrap();
        }
        [run.bench.applied_pwm(0), run.bench.applied_pwm(1)]
    });
    let script = Script {
        setup: Setup::default(),
        limits: Script::limits(),
        commands: vec![(0, Command::Regulate([0.0, 0.0]))],
        duration_us: 500_000,
    };
    let mut runner = PlanRunner::new(script);
    tcp_pump::run(&mut at.connect().unwrap(), &mut runner, 1).unwrap();
    done.send(()).unwrap();
    assert_eq!(
        board.join().unwrap(),
        [1000, 1000],
        "the runner switched off"
    );
    let (records, _, link) = runner.into_parts();
    let mut regulated = records
        .iter()
        .filter(|record| record.mode.drive() == Some(Drive::Regulate));
    let last = regulated.next_back().unwrap();
    assert!(
        last.output.angle_rad.iter().all(|angle| angle.abs() < 0.15),
        "{last:?}"
    );
    assert_eq!((link.lost, link.damaged), (0, 0));
}
