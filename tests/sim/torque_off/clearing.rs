//! Stops in one write with other commands: the stop wins over commands before and
//! behind it, above all over the clearing of the fault.

use armbridge_link::message::{Command, Fault, Mode, ToBoard};
use armbridge_servo::Firmware;
use armbridge_tests::torque_off::cases::{all, check, run_cases};
use armbridge_tests::torque_off::rig::{Rig, STOP_US, World, bench, between_obstacles, with_rig};

/// Torques that drive the arm.
const DRIVE: Command = Command::Torque([0.2, 0.1]);
/// Time for which the board is watched, in ms: bring-up takes 30.
const WATCH_MS: u64 = 2_000;

/// State of the board before the write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Before {
    Idle,
    Armed,
    Running,
    /// Emergency stop by the host.
    Stopped,
    /// Emergency stop by the switch, released since.
    StoppedByPin,
}

/// A frame of the write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Frame {
    Clear,
    Stop,
    Arm,
    Drive,
    Disarm,
}

use Before::{Armed, Idle, Running, Stopped, StoppedByPin};
use Frame::{Arm, Clear, Disarm, Drive, Stop};

const BEFORE: [Before; 5] = [Idle, Armed, Running, Stopped, StoppedByPin];

const WRITES: [&[Frame]; 10] = [
    &[Stop],
    &[Clear, Stop],
    &[Stop, Clear],
    &[Stop, Clear, Stop],
    &[Clear, Stop, Clear],
    &[Clear, Stop, Arm, Drive],
    &[Stop, Clear, Arm, Drive],
    &[Clear, Arm, Drive, Stop],
    &[Arm, Drive, Stop, Clear],
    &[Disarm, Clear, Stop, Disarm],
];

fn get(rig: &mut Rig<'_>, before: Before) {
    let session = rig.host().session();
    match before {
        Idle => {}
        Armed => assert_eq!(rig.command(Command::Arm { session }), Ok(())),
        Running => {
            rig.drive(DRIVE);
            rig.pass_ms(20);
            assert_eq!(rig.is_on(), [true; 2], "driven");
        }
        Stopped => _ = rig.host().send(ToBoard::Stop),
        StoppedByPin => rig.cosim.is_stop_pressed = true,
    }
    rig.pass_ms(20);
    rig.cosim.is_stop_pressed = false;
    rig.pass_ms(500);
}

fn write(rig: &mut Rig<'_>, frames: &[Frame]) {
    let session = rig.host().session();
    for frame in frames {
        let message = match frame {
            Clear => ToBoard::Command(Command::ClearFault),
            Stop => ToBoard::Stop,
            Arm => ToBoard::Command(Command::Arm { session }),
            Drive => ToBoard::Command(DRIVE),
            Disarm => ToBoard::Command(Command::Idle),
        };
        rig.host().send(message);
    }
}

fn stop_wins(before: Before, frames: &[Frame]) -> Result<(), String> {
    let bench = bench(&between_obstacles(), Firmware::Morpheus);
    with_rig(World::Bench, bench, |rig| {
        get(rig, before);
        write(rig, frames);
        let off_us = rig.now_us() + STOP_US;
        let off = rig.stays_off(off_us, WATCH_MS);
        let modes = rig.modes_from(off_us);
        let is_stopped =
            |mode: &Option<Mode>| matches!(mode, Some(Mode::Fault(Fault::EmergencyStop(_))));
        all([
            check(modes.iter().all(is_stopped), || {
                format!("from {} ms on {modes:?}", STOP_US / 1_000)
            }),
            off,
            rig.reports_are_true(),
        ])
    })
}

#[test]
fn a_stop_wins_over_what_comes_with_it() {
    let cases = BEFORE
        .into_iter()
        .flat_map(|before| WRITES.map(|write| (before, write)));
    run_cases(cases, |(before, write)| stop_wins(*before, write));
}
