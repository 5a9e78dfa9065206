//! Garbage on the link as fast as QEMU takes it: the tick keeps its schedule.
//!
//! Here link and tick run by the priorities of their interrupts, as they do not in
//! lockstep. QEMU needs 20 to 40 µs of the wall clock for a byte, which is less than
//! a µs of the board's time: more than USB can send. The processor is faster
//! beside that time than a real one by as much as the motion is slow, so this does
//! not show that it can cope with the work, but that the tick does not wait for the
//! end of it.

use armbridge_client::session::BoardMessage;
use armbridge_link::message::{Command, Fault, Mode, Record, StopSource};
use armbridge_tests::random::Random;

use super::slow_motion::Rig;
use super::stop;
use super::tap::OFF;

const SLOW: u32 = 50;
/// Garbage, in bytes: some 80 ms of the board's time.
const GARBAGE: usize = 200_000;
/// Fewest ticks that must be seen in it.
const TICKS: usize = 30;
/// A tick that begins later than that by the board's clock, in µs, is late. While
/// the board rests, a busy machine may wake it late: 100 µs are 5 ms of the wall
/// clock.
const LATE_US: u32 = 100;

#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn garbage_does_not_keep_the_tick_waiting() {
    let mut rig = Rig::start(SLOW, None);
    let driven_until = rig.until_driven();
    let mut random = Random::new(1);
    let garbage = rig.flood((0..GARBAGE).map(|_| random.byte()).collect());
    rig.until("the end of the garbage", |_| garbage.is_finished());
    // A command after it is answered after it.
    rig.host.client.command(Command::Idle);
    rig.until_message("an answer", |message| matches!(message, BoardMessage::Done));

    let fault = Fault::EmergencyStop(StopSource::Flood);
    let trip = rig.host.trip().unwrap();
    assert_eq!(trip.fault, fault);
    {
        let bus = rig.bus.lock().unwrap();
        assert!(!stop::find(&bus.sent[driven_until..]).is_empty());
        assert!(bus.pwm.iter().any(|pwm| *pwm != OFF));
        assert_eq!(bus.pwm.last(), Some(&OFF));
    }

    let flooded = rig.host.records().filter(|record| record.tick > trip.tick);
    let flooded: Vec<Record> = flooded.collect();
    assert!(flooded.len() >= TICKS, "{} ticks", flooded.len());
    assert!(
        flooded
            .iter()
            .all(|record| record.mode == Mode::Fault(fault))
    );
    let last = flooded[flooded.len() - 1];
    assert_eq!(last.dropped, 0);
    let missed = (last.timing.missed - flooded[0].timing.missed) as usize;
    let is_late = |record: &&Record| record.timing.start_error_us > LATE_US;
    let late = flooded.iter().filter(is_late).count();
    assert!(
        late + missed <= flooded.len() / 10,
        "{late} late and {missed} missed of {}",
        flooded.len()
    );

    // And the board is as good as new.
    rig.host.client.command(Command::ClearFault);
    rig.until("servos", |host| {
        host.last().is_some_and(|record| record.mode == Mode::Idle)
    });
}
