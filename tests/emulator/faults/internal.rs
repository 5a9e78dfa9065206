//! The firmware fails by itself: a panic, a hard fault, a stack that overflows, a
//! tick that hangs.
//!
//! Each is provoked while the arm is driven. What is on the bus then is what
//! `firmware::end` documents: the handler's stop sequence, the one at boot, the one of
//! bring-up, with nothing in between. The handler writes a line to the log when it
//! has sent its own, and the board's clock at its head shows how long that took.

use armbridge_client::session::BoardMessage;
use armbridge_link::message::{Command, End, LastEnd, Mode, Refusal, ToHost};
use armbridge_sim::emulator::{Failure, Image, Provocation};
use object::{Object, ObjectSymbol};

use super::slow_motion::Rig;
use super::stop;
use super::tap::OFF;

/// Slow enough for servos and host, which the machine may keep waiting.
const SLOW: u32 = 50;
/// When the firmware fails, in ms of its time: bring-up takes 30, arming two
/// answers of the host, the check of the motors 260.
const AT_MS: u32 = 600;
/// It fails in the first turn of the real-time loop after that: a tick later at the
/// most, and a tick more where the machine wakes QEMU late.
const TURN_MS: f64 = 2.0;
/// From a panic or a fault to the end of the stop sequence, in ms: 7.1, and what
/// polling adds.
const STOP_MS: f64 = 8.0;
/// The same from the last good tick: 161.5 until the watchdog bites.
const HANG_MS: f64 = 170.0;
/// Part of both that the stop sequence takes: the servos' supply is off before it.
const SEQUENCE_MS: f64 = 7.07;
/// Ticks of which the records may be on their way when the board fails.
const TICKS: u32 = 5;

/// Makes the firmware fail while the arm is driven, sees the motors stop within
/// `bound_ms` by the log line with `logged`, and returns the report of the next boot.
fn fail(failure: Failure, bound_ms: f64, logged: &str) -> LastEnd {
    let provocation = Provocation {
        failure,
        at_ms: AT_MS,
    };
    let mut rig = Rig::start(SLOW, Some(provocation));
    let driven_until = rig.until_driven();
    let first = rig.host.report().unwrap();
    assert_eq!(first.last_end.cause, End::PowerUp, "not driven in time");
    let is_reset = |message: &BoardMessage| matches!(message, BoardMessage::Other(ToHost::Board(report)) if first.is_before_reset(report));
    rig.until_message("a reset", is_reset);
    let end = rig.host.report().unwrap().last_end;

    // Driven until the end.
    let last = rig.host.last().unwrap();
    assert!(last.mode.drive().is_some(), "{last:?}");
    assert!(
        (last.tick..=last.tick + TICKS).contains(&end.tick),
        "{end:?} after {last:?}"
    );

    // In time, by the board's own clock.
    let (at_us, line) = rig.logged(logged).unwrap();
    let took_ms = at_us * 1e-3 - f64::from(AT_MS);
    assert!(took_ms <= TURN_MS + bound_ms, "{took_ms} ms: {line}");

    // The supply fell before the stop sequence, and came back with the next program.
    let supply = rig.supply();
    let [(_, true), (off_us, false), (on_us, true)] = supply[..] else {
        panic!("{supply:?}")
    };
    let off_ms = off_us * 1e-3 - f64::from(AT_MS);
    assert!(
        (0.0..=TURN_MS + bound_ms - SEQUENCE_MS).contains(&off_ms),
        "{off_ms} ms"
    );
    // The clock began anew.
    assert!(
        at_us - off_us > SEQUENCE_MS * 1e3 && on_us < off_us,
        "{supply:?}"
    );

    // Disarmed, whatever the host thought of it.
    rig.until("servos", |host| {
        host.last().is_some_and(|record| record.mode == Mode::Idle)
    });
    let old = Command::Arm {
        session: first.session,
    };
    for (command, refusal) in [
        (old, Refusal::OtherSession),
        (Command::Regulate([0.0; 2]), Refusal::Disarmed),
    ] {
        rig.host.client.command(command);
        let answer = rig.until_message("an answer", |message| {
            matches!(message, BoardMessage::Done | BoardMessage::Refused(_))
        });
        assert_eq!(answer, BoardMessage::Refused(refusal));
    }
    let last = rig.host.last().unwrap();
    assert_eq!((last.mode, last.input.pwm_in_force), (Mode::Idle, OFF));

    let bus = rig.bus.lock().unwrap();
    let stops = stop::find(&bus.sent[driven_until..]);
    let len = stop::sequence().len();
    let begin = stops.first().copied().unwrap_or_default();
    let in_a_row = [begin, begin + len, begin + 2 * len];
    assert_eq!(
        stops.get(..3),
        Some(&in_a_row[..]),
        "handler, boot, bring-up"
    );
    assert!(bus.pwm.iter().any(|pwm| *pwm != OFF));
    assert_eq!(bus.pwm.last(), Some(&OFF));
    end
}

/// The function of the firmware that this address is in.
fn function(pc: u32) -> String {
    let image = std::fs::read(Image::current().unwrap().path).unwrap();
    let image = object::File::parse(&*image).unwrap();
    let is_it = |begin: u64, size: u64| (begin..begin + size).contains(&u64::from(pc));
    let mut symbols = image.symbols();
    // The lowest bit of a function's address marks Thumb code.
    let symbol = symbols.find(|symbol| is_it(symbol.address() & !1, symbol.size()));
    symbol
        .and_then(|symbol| symbol.name().ok())
        .unwrap_or("")
        .to_owned()
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_panic_stops_the_motors_first() {
    const SOURCE: &str = include_str!("../../../firmware/src/board/mps2_an386/fault_injection.rs");
    let end = fail(Failure::Panic, STOP_MS, "provoked");
    let line = SOURCE
        .lines()
        .position(|line| line.contains("panic!(\"provoked\")"));
    assert_eq!(
        (end.cause, end.line as usize),
        (End::Panic, line.unwrap() + 1)
    );
    assert!(end.place.ends_with(b"an386/fault_injection.rs"));
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_hard_fault_stops_the_motors_first() {
    let end = fail(Failure::Fault, STOP_MS, "HardFault at");
    // Where it jumped to.
    assert_eq!((end.cause, end.pc), (End::HardFault, 0x1000_0000));
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_stack_overflow_stops_the_motors_first() {
    let end = fail(Failure::Overflow, STOP_MS, "StackOverflow at");
    assert_eq!(end.cause, End::StackOverflow);
    // Where it was is kept on the stack, if there is room.
    let is_known = end.pc == 0 || function(end.pc).contains("recurse");
    assert!(is_known, "{end:?} {}", function(end.pc));
}

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn a_hang_of_the_tick_is_bitten() {
    let end = fail(Failure::Hang, HANG_MS, "Watchdog at");
    assert_eq!(end.cause, End::Watchdog);
    assert!(
        function(end.pc).contains("hang"),
        "{end:?} {}",
        function(end.pc)
    );
}
