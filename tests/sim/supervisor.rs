//! The supervisor on the whole bench, one fault at a time: who may arm, what stops the arm,
//! what is reported to the host, and what brings it back.

use std::convert::Infallible;

use armbridge_board::bridge::{Channels, MemoryRegion};
use armbridge_client::Host;
use armbridge_client::session::{BoardMessage, CommandLink};
use armbridge_link::message::{
    Command, Drive, Fault, Limits, Mode, OffReport, OffState, Refusal, Setup, StopSource, ToBoard,
    ToHost, Trip,
};
use armbridge_link::motion::Motion;
use armbridge_servo::Firmware;
use armbridge_sim::Bench;
use armbridge_sim::board::VirtualBoard;
use armbridge_sim::cosim::Cosim;
use armbridge_sim::plant::Plant;
use armbridge_sim::servo_kind::ServoKind;
use armbridge_tests::plant;

/// A host that sends what a test requests, and keeps every message.
#[derive(Default)]
struct Talker {
    client: CommandLink,
    is_silent: bool,
    /// Sent before anything else, once.
    noise: Vec<u8>,
    out: Vec<u8>,
    messages: Vec<(u64, BoardMessage)>,
}

impl Host for Talker {
    type Error = Infallible;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Infallible> {
        self.out.clear();
        self.out.append(&mut self.noise);
        if !self.is_silent {
            self.out.extend_from_slice(self.client.transmit(now_us));
        }
        Ok(&self.out)
    }

    fn receive(&mut self, now_us: u64, mut bytes: &[u8]) -> Result<(), Infallible> {
        while let Some(message) = self.client.receive(&mut bytes) {
            self.messages.push((now_us, message));
        }
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        if self.is_silent {
            u64::MAX
        } else {
            self.client.wake_at_us()
        }
    }

    fn is_done(&self) -> bool {
        false
    }
}

struct Table<'a> {
    run: Cosim<VirtualBoard<'a>, Talker>,
}

impl<'a> Table<'a> {
    fn new(channels: &'a mut Channels) -> Self {
        let board = VirtualBoard::new(channels.split()).unwrap();
        let bench = Bench::new(Plant::new(plant([0.0; 2], true), 1));
        let mut table = Self {
            run: Cosim::new(board, bench, Talker::default()),
        };
        table.until(|mode| mode == Mode::Idle);
        table
    }

    fn mode(&self) -> Mode {
        self.run.board.mode()
    }

    fn until(&mut self, is_there: impl Fn(Mode) -> bool) {
        let latest_us = self.run.now_us() + 4_000_000;
        while !is_there(self.mode()) {
            self.run.step().unwrap();
            assert!(self.run.now_us() < latest_us, "still {:?}", self.mode());
        }
    }

    fn pass_ms(&mut self, ms: u64) {
        let until_us = self.run.now_us() + ms * 1_000;
        while self.run.now_us() < until_us {
            self.run.step().unwrap();
        }
    }

    /// Result of a command.
    fn order(&mut self, command: Command) -> Result<(), Refusal> {
        self.run.host.client.command(command);
        let before = self.run.host.messages.len();
        for _ in 0..100_000 {
            self.run.step().unwrap();
            let answer = self.run.host.messages[before..]
                .iter()
                .find_map(|(_, message)| match message {
                    BoardMessage::Done => Some(Ok(())),
                    BoardMessage::Refused(refusal) => Some(Err(*refusal)),
                    _ => None,
                });
            if let Some(answer) = answer {
                return answer;
            }
        }
        panic!("no answer to {command:?}");
    }

    fn session(&self) -> u32 {
        let reports = self.run.host.messages.iter().rev();
        let mut sessions = reports.filter_map(|(_, message)| match message {
            BoardMessage::Other(ToHost::Board(report)) => Some(report.session),
            _ => None,
        });
        sessions.next().expect("the board has reported")
    }

    fn arm(&mut self) {
        let session = self.session();
        assert_eq!(self.order(Command::Arm { session }), Ok(()));
        self.until(|mode| mode == Mode::Armed);
        // The first tick without torque.
        self.pass_ms(3);
        assert_eq!(self.mode(), Mode::Armed);
    }

    /// Upright and standing for a while.
    fn stand(&mut self) {
        assert_eq!(self.order(Command::Configure(Setup::best())), Ok(()));
        self.arm();
        assert_eq!(self.order(Command::Regulate([0.0; 2])), Ok(()));
        self.pass_ms(300);
        assert_eq!(self.mode(), Mode::Running(Drive::Regulate));
    }

    fn trip(&self) -> Trip {
        let mut messages = self.run.host.messages.iter().rev();
        messages
            .find_map(|(_, message)| match message {
                BoardMessage::Other(ToHost::Tripped(trip)) => Some(*trip),
                _ => None,
            })
            .expect("the board has reported why")
    }

    fn motors(&self) -> [u16; 2] {
        [0, 1].map(|servo| self.run.bench.applied_pwm(servo))
    }

    /// The fault, once latched, and motors off 20 ms later.
    fn fault(&mut self) -> Fault {
        self.until(|mode| matches!(mode, Mode::Fault(_)));
        self.pass_ms(20);
        assert_eq!(self.motors(), [1000; 2]);
        let Mode::Fault(fault) = self.mode() else {
            panic!("not latched: {:?}", self.mode());
        };
        assert_eq!(self.trip().fault, fault);
        fault
    }

    /// The cause is gone: cleared, armed, standing again.
    fn comes_back(&mut self) {
        assert_eq!(
            self.order(Command::Regulate([0.0; 2])),
            Err(Refusal::Faulted)
        );
        self.clear();
        self.until(|mode| mode == Mode::Idle);
        self.arm();
    }

    /// Clears the fault, as soon as motors are seen to be off, or reported not to be.
    fn clear(&mut self) {
        for _ in 0..400 {
            match self.order(Command::ClearFault) {
                Ok(()) => return,
                refused => assert_eq!(refused, Err(Refusal::NotOff)),
            }
            self.pass_ms(1);
        }
        panic!("not cleared within 0.4 s");
    }
}

#[test]
fn nothing_moves_before_it_is_armed_and_only_this_session_arms() {
    let mut channels = Channels::new();
    let mut table = Table::new(&mut channels);
    assert_eq!(
        table.order(Command::Torque([0.3; 2])),
        Err(Refusal::Disarmed)
    );
    assert_eq!(
        table.order(Command::Regulate([0.0; 2])),
        Err(Refusal::Disarmed)
    );
    let session = table.session();
    let stale = Command::Arm {
        session: session.wrapping_sub(1),
    };
    assert_eq!(table.order(stale), Err(Refusal::OtherSession));
    table.arm();
    table.pass_ms(100);
    assert_eq!(table.motors(), [1000; 2], "armed is zero torque");
    assert_eq!(table.order(Command::Torque([0.1, 0.0])), Ok(()));
    table.pass_ms(20);
    assert_ne!(table.motors()[0], 1000);

    // A second hello is another host: what the first has armed is not its.
    table.run.host.client = CommandLink::default();
    table.until(|mode| mode == Mode::Idle);
    table.pass_ms(20);
    assert_eq!(table.motors(), [1000; 2]);
    assert_ne!(table.session(), session);
}

#[test]
fn limits_are_set_while_idle_and_within_hard_bounds_only() {
    let mut channels = Channels::new();
    let mut table = Table::new(&mut channels);
    let wide = Limits {
        speed_rad_s: [1e3; 2],
        ..Limits::default()
    };
    assert_eq!(table.order(Command::Limit(wide)), Err(Refusal::OutOfRange));
    let weak = Limits {
        pwm_counts: 100,
        ..Limits::default()
    };
    assert_eq!(table.order(Command::Limit(weak)), Ok(()));
    table.arm();
    assert_eq!(table.order(Command::Limit(weak)), Err(Refusal::NotIdle));
    assert_eq!(table.order(Command::Torque([0.5, 0.0])), Ok(()));
    table.pass_ms(50);
    assert_eq!(table.motors()[0], 1100);
    assert_eq!(table.fault(), Fault::PwmLimit);
}

#[test]
fn a_silent_host_brakes_the_arm_then_lets_it_go() {
    let mut channels = Channels::new();
    let mut table = Table::new(&mut channels);
    table.stand();
    let wave = Motion::Sinusoid {
        centre_rad: [0.0; 2],
        amplitude_rad: [0.2; 2],
        frequency_hz: [0.5; 2],
        phase_rad: [0.0; 2],
        ramp_s: 0.5,
        duration_s: 20.0,
    };
    assert_eq!(table.order(Command::Follow(wave)), Ok(()));
    table.pass_ms(1_000);
    assert_eq!(table.mode(), Mode::Running(Drive::Track));
    table.run.host.is_silent = true;
    let begun_us = table.run.now_us();
    table.until(|mode| mode.drive() == Some(Drive::Hold));
    let held_us = table.run.now_us() - begun_us;
    assert!((75_000..102_000).contains(&held_us), "{held_us}");
    table.pass_ms(300);
    let speed = table.run.bench.plant().state().dq;
    assert!(speed.amax() < 0.1, "at rest by then: {speed}");
    table.until(|mode| matches!(mode, Mode::Fault(_)));
    let off_us = table.run.now_us() - begun_us;
    assert!((475_000..502_000).contains(&off_us), "{off_us}");
    table.run.host.is_silent = false;
    assert_eq!(table.fault(), Fault::HostSilent);
    table.comes_back();
}

/// A constant torque is not held without a host: none from 100 ms on.
#[test]
fn a_constant_torque_ends_when_the_host_is_silent() {
    let mut channels = Channels::new();
    let mut table = Table::new(&mut channels);
    table.arm();
    assert_eq!(table.order(Command::Torque([0.1, 0.0])), Ok(()));
    table.run.host.is_silent = true;
    table.pass_ms(110);
    assert_eq!((table.mode(), table.motors()), (Mode::Armed, [1000; 2]));
}

#[test]
fn a_goodbye_is_no_fault() {
    let mut channels = Channels::new();
    let mut table = Table::new(&mut channels);
    table.stand();
    table.run.host.client.send(ToBoard::Goodbye);
    table.pass_ms(20);
    assert_eq!((table.mode(), table.motors()), (Mode::Idle, [1000; 2]));
}

#[test]
fn emergency_stops_from_host_pin_and_flood_are_one_path() {
    let mut channels = Channels::new();
    let mut table = Table::new(&mut channels);
    for source in [StopSource::Host, StopSource::Pin, StopSource::Flood] {
        assert_eq!(table.order(Command::Configure(Setup::best())), Ok(()));
        table.arm();
        assert_eq!(table.order(Command::Torque([0.1, 0.1])), Ok(()));
        table.pass_ms(20);
        match source {
            StopSource::Host => table.run.host.client.send(ToBoard::Stop),
            StopSource::Pin => table.run.is_stop_pressed = true,
            StopSource::Flood => {
                table.run.host.noise = (0..8_000_u32).map(|i| (i * 7 % 251) as u8).collect();
            }
            StopSource::Crystal => unreachable!("a chip's, not of the bench"),
        }
        assert_eq!(table.fault(), Fault::EmergencyStop(source));
        table.run.is_stop_pressed = false;
        assert_eq!(table.order(Command::ClearFault), Ok(()));
        table.until(|mode| mode == Mode::Idle);
    }
}

/// An arm that falls gives no evidence on its motors: the board reports them once they are
/// seen to be off, and does not repeat the stop sequence then.
#[test]
fn the_host_is_told_when_the_motors_are_seen_to_be_off() {
    let mut channels = Channels::new();
    let mut table = Table::new(&mut channels);
    table.stand();
    assert_eq!(table.order(Command::Regulate([0.5, 0.0])), Ok(()));
    table.pass_ms(800);
    table.run.host.client.send(ToBoard::Stop);
    table.pass_ms(50);
    let reports = |table: &Table<'_>| -> Vec<OffReport> {
        let messages = table.run.host.messages.iter();
        messages
            .filter_map(|(_, message)| match message {
                BoardMessage::Other(ToHost::Off(report)) => Some(*report),
                _ => None,
            })
            .collect()
    };
    let report = OffReport {
        stops: 1,
        joints: [OffState::Off; 2],
    };
    assert_eq!(reports(&table), [report]);
    table.pass_ms(3_500);
    assert_eq!(reports(&table), [report], "the arm fell meanwhile");
}

#[test]
fn a_servo_that_was_off_and_on_again_is_told_from_one_that_is_gone() {
    let mut channels = Channels::new();
    let mut table = Table::new(&mut channels);
    table.stand();
    table.run.bench.power_cycle(1);
    assert_eq!(table.fault(), Fault::ServoReset);
    assert_eq!(table.trip().joint, Some(1));
    table.comes_back();
    table.run.bench.disconnect(0);
    assert_eq!(table.fault(), Fault::ServoSilent);
    assert_eq!(table.trip().joint, Some(0));
}

#[test]
fn servos_with_another_firmware_than_before_are_a_fault_until_cleared() {
    let mut channels = Channels::new();
    let mut table = Table::new(&mut channels);
    let stock = [1, 2].map(|id| ServoKind::new(Firmware::Stock, id, 1_000_000).unwrap());
    table.run.bench = Bench::with_servos(Plant::new(plant([0.0; 2], true), 1), &stock);
    assert_eq!(table.fault(), Fault::ServoSilent);
    table.clear();
    table.until(|mode| mode == Mode::Fault(Fault::FirmwareChanged));
    table.clear();
    table.until(|mode| mode == Mode::Idle);
}

#[test]
fn a_turned_bit_in_the_set_up_is_found_within_20_ms() {
    let mut channels = Channels::new();
    let mut table = Table::new(&mut channels);
    table.stand();
    table.run.board.inject_error(MemoryRegion::Config, 8 * 25);
    let turned_us = table.run.now_us();
    assert_eq!(table.fault(), Fault::Corrupted);
    assert!(table.trip().at_us - turned_us < 20_000);
}
