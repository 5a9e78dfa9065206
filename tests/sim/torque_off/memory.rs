//! Memory faults: a flipped bit in the arming state or in the settings switches the motors
//! off, in every state.

use armbridge_board::bridge::MemoryRegion;
use armbridge_link::message::{Command, Drive, Fault, Limits, Mode, Refusal};
use armbridge_link::motion::Motion;
use armbridge_servo::Firmware;
use armbridge_tests::torque_off::cases::{all, check, run_cases};
use armbridge_tests::torque_off::client::Method;
use armbridge_tests::torque_off::rig::{
    AnyBoard, Rig, STOP_US, World, bench, between_obstacles, with_rig,
};

/// Bits of the state's word, and of the words of what drives: the torques, the source and
/// the time of the command.
const STATE_BITS: u32 = 32;
const DRIVE_DRAWS: [std::ops::Range<u32>; 3] = [0..96, 96..128, 352..384];
/// Longest time until a fault may be cleared, in ms.
const CLEAR_MS: u64 = 400;

/// State of the board when a bit flips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Doing {
    Idle,
    Armed,
    Torque,
    Regulate,
    Track,
    Stream,
    Passthrough,
}

impl Doing {
    const ALL: [Self; 7] = [
        Self::Idle,
        Self::Armed,
        Self::Torque,
        Self::Regulate,
        Self::Track,
        Self::Stream,
        Self::Passthrough,
    ];

    /// Has the board do it.
    fn begin(self, rig: &mut Rig<'_>) {
        let torque = Command::Torque([0.2, -0.2]);
        match self {
            Self::Idle => {}
            Self::Armed => rig.arm(),
            Self::Torque => rig.drive(torque),
            Self::Regulate => rig.drive(Command::Regulate([0.2, -0.2])),
            Self::Track => rig.drive(Command::Follow(Motion::MinimumJerk {
                to_rad: [0.3, -0.3],
                duration_s: Some(2.0),
            })),
            Self::Stream => {
                let stream = Command::Stream {
                    at_us: rig.now_us() + 500_000,
                    angle_rad: [0.2, -0.2],
                    speed_rad_s: None,
                };
                rig.drive(stream);
            }
            Self::Passthrough => {
                // The host's own commands keep clients off the bus for a while.
                rig.pass_ms(2_100);
                rig.client.open(1_000_000);
                rig.client.stream(Method::Pwm.packets(), 10_000);
            }
        }
        // A motion from rest to rest needs no torque at first.
        rig.pass_ms(if self == Self::Track { 400 } else { 100 });
        let mode = rig.mode();
        let is_at_it = match self {
            Self::Idle => mode == Some(Mode::Idle),
            Self::Armed => mode == Some(Mode::Armed),
            Self::Torque => mode == Some(Mode::Running(Drive::Torque)),
            Self::Regulate => mode == Some(Mode::Running(Drive::Regulate)),
            Self::Track | Self::Stream => mode == Some(Mode::Running(Drive::Track)),
            Self::Passthrough => mode == Some(Mode::Passthrough),
        };
        assert!(is_at_it, "{self:?}: {mode:?}");
        let is_on = !matches!(self, Self::Idle | Self::Armed);
        assert_eq!(rig.is_on().contains(&true), is_on, "{self:?}");
    }
}

/// Turns a bit, and checks that motors go off and the fault is named; then clears it.
fn turn(rig: &mut Rig<'_>, doing: Doing, region: MemoryRegion, draw: u32) -> Result<(), String> {
    // Obstacles hold the arm: there is no motion to compare with the model's.
    let unchecked = Limits {
        check_rad_s2: 0,
        ..Limits::default()
    };
    assert_eq!(rig.command(Command::Limit(unchecked)), Ok(()));
    doing.begin(rig);
    let AnyBoard::Virtual(board) = &mut rig.cosim.board else {
        unreachable!("the bench's board")
    };
    board.inject_error(region, draw);
    let turned_us = rig.now_us();
    let off = rig.stays_off(turned_us + STOP_US, 50);
    let mode = rig.mode();
    let named = check(mode == Some(Mode::Fault(Fault::Corrupted)), || {
        format!("then {mode:?}")
    });
    rig.client.close();
    for _ in 0..CLEAR_MS {
        match rig.command(Command::ClearFault) {
            Ok(()) => break,
            refused => assert_eq!(refused, Err(Refusal::NotOff)),
        }
        rig.pass_ms(1);
    }
    rig.until("idle again", 2_000_000, |rig| {
        rig.mode() == Some(Mode::Idle)
    });
    all([off, named])
}

#[test]
fn every_turned_bit_of_the_state_switches_off() {
    for doing in Doing::ALL {
        let bench = bench(&between_obstacles(), Firmware::Morpheus);
        with_rig(World::Bench, bench, |rig| {
            run_cases((0..STATE_BITS).map(|bit| (doing, bit)), |(doing, bit)| {
                turn(rig, *doing, MemoryRegion::State, *bit)
            });
        });
    }
}

#[test]
fn every_turned_bit_of_a_reference_switches_off() {
    for doing in [Doing::Armed, Doing::Regulate, Doing::Track, Doing::Stream] {
        let bench = bench(&between_obstacles(), Firmware::Morpheus);
        with_rig(World::Bench, bench, |rig| {
            run_cases((0..u32::BITS).map(|bit| (doing, bit)), |(doing, bit)| {
                turn(rig, *doing, MemoryRegion::Reference, *bit)
            });
        });
    }
}

#[test]
fn every_turned_bit_of_what_drives_switches_off() {
    for doing in [Doing::Armed, Doing::Torque, Doing::Regulate, Doing::Track] {
        let bench = bench(&between_obstacles(), Firmware::Morpheus);
        with_rig(World::Bench, bench, |rig| {
            let draws = DRIVE_DRAWS.into_iter().flatten();
            run_cases(draws.map(|draw| (doing, draw)), |(doing, draw)| {
                turn(rig, *doing, MemoryRegion::Drive, *draw)
            });
        });
    }
}
