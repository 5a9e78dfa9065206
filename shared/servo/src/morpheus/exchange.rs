//! The control tick with Morpheus servos, and their response times.
//!
//! ```text
//! SYNC_WR (16 bytes) | gap | CYCLE (6 bytes) | positions, one after the other (14)
//! ```
//!
//! Times are recorded from the firmware, with two servos on the bus.

use super::codec::LATENCY_US;
use super::{Morpheus, Request};
use crate::exchange::{Exchange, ExpectedReplies, GUARD_US, Line, Readiness, ReplyContent, Step};
use crate::port::bytes_us;
use crate::transaction::Transaction;
use crate::{JOINTS, Pwm};

/// Delay of the answer to START per id, rounded up.
const START_SLOT_US: u64 = 5_000;

/// Longest recorded time of a servo to begin an answer is 105 µs, to a READ of
/// eleven bytes; inside it, gaps of up to 9 µs occur between bytes.
const ANSWER_US: u32 = 150;

/// Pause between SYNC_WR and CYCLE. Of two packets closer than 20 µs a servo
/// processes only the newer. On the bench none is lost with [`GAP_MIN_US`] either,
/// in two seconds of ticks of 600 µs, which slide past the servos' own loops
/// (`tests/sim/transparent_port`); the rest is margin, 5 % of a tick at 1 kHz, until real
/// servos have been measured.
const GAP_US: u32 = 80;
/// The same pause where the period leaves no room for that margin.
const GAP_MIN_US: u32 = 30;

/// From the end of CYCLE to the last byte of two replies takes 310 µs, of which
/// 140 are bytes; with the first servo dead its successor waits 169 µs more
/// before it speaks. The rest, at 1 Mbaud, is reserve.
const POSITIONS_LATENCY_US: u64 = 310;
/// Part of [`POSITIONS_LATENCY_US`] that two servos take when both answer.
const POSITIONS_TYPICAL_US: u64 = 150;
/// Time for which a successor waits longer at each step of the baud register: two steps of
/// the servo's timer. At 57 600 baud that is 3.3 ms.
const SUCCESSOR_STEP_US: u32 = 100;
/// Value of the baud register at 1 Mbaud, and the speed at value 0.
const BAUD_STEP_1M: u32 = 1;
const BAUD_STEP_0: u32 = 2_000_000;
/// Bytes of two positions.
const POSITIONS_BYTES: u32 = 14;
/// Bytes of a tick: SYNC_WR, CYCLE, positions.
const TICK_BYTES: u32 = 16 + 6 + POSITIONS_BYTES;

impl Exchange for Morpheus {
    const LATENCY_US: u32 = LATENCY_US;

    const SAME_SERVO_GUARD_US: u64 = GUARD_US;

    fn reply_latency_us(_baud: u32, answers_soon: bool) -> u32 {
        if answers_soon { ANSWER_US } else { LATENCY_US }
    }

    fn tick_us(baud: u32, _readiness: Readiness) -> u32 {
        let fixed_us = u64::from(GAP_MIN_US) + POSITIONS_TYPICAL_US + GUARD_US;
        (bytes_us(TICK_BYTES, baud) + fixed_us) as u32
    }

    fn step(transaction: Transaction, index: u8, line: &Line) -> Option<Step> {
        match transaction {
            Transaction::Start => start(index, line),
            Transaction::Drive([a, b]) => {
                let [id_a, id_b] = line.ids.filled();
                let b = if line.ids.len() < JOINTS { a } else { b };
                tick(index, Request::Drive([(id_a, a), (id_b, b)]), line)
            }
            Transaction::HoldOff => {
                let off = line.ids.filled().map(|id| (id, Pwm::OFF));
                tick(index, Request::Drive(off), line)
            }
            Transaction::StopWedged {
                joint,
                is_side_step,
            } => {
                let servo = [*line.ids.get(joint)?; JOINTS];
                let off = if is_side_step {
                    Request::SideStep(servo)
                } else {
                    Request::Release(servo)
                };
                match index {
                    0 => tick(0, off, line),
                    // A servo whose packet is cut short takes the next two bytes for its
                    // PWM: 0xFFFF is none.
                    1 => Some(Step::Repeat(0xFF, 2)),
                    _ => tick(index - 1, off, line),
                }
            }
            _ => None,
        }
    }
}

fn tick(index: u8, drive: Request, line: &Line) -> Option<Step> {
    Some(match index {
        0 => Step::Send(drive.encode()),
        1 => Step::Pause {
            us: gap_us(line.available_us, line.least_period_us),
        },
        2 => Step::Send(Request::Cycle.encode()),
        3 => Step::Listen(
            ExpectedReplies::Chain(ReplyContent::Position),
            positions_window_us(line.available_us, line.baud),
        ),
        _ => return None,
    })
}

fn start(index: u8, line: &Line) -> Option<Step> {
    Some(match index {
        0 => Step::Send(Request::Start.encode()),
        1 => {
            let last = line.ids.iter().map(|id| id.get()).max().unwrap_or(0);
            let slots_us = (u64::from(last) + 1) * START_SLOT_US;
            Step::Listen(
                ExpectedReplies::Chain(ReplyContent::Pong),
                slots_us + bytes_us(6, line.baud),
            )
        }
        _ => return None,
    })
}

/// Receive window of two positions. On a slow bus it has room for the wait of a successor, as
/// far as the tick has: otherwise the silence of the first servo looks like that of both.
fn positions_window_us(available_us: u32, baud: u32) -> u64 {
    let steps = (BAUD_STEP_0 / baud.max(1)).saturating_sub(1 + BAUD_STEP_1M);
    let successor_us = if steps > 0 {
        let least_us = Morpheus::tick_us(baud, Readiness::Prepared);
        (steps * SUCCESSOR_STEP_US).min(available_us.saturating_sub(least_us))
    } else {
        0
    };
    bytes_us(POSITIONS_BYTES, baud) + POSITIONS_LATENCY_US + u64::from(successor_us)
}

/// Pause between SYNC_WR and CYCLE: the longer one if the tick has room for it.
fn gap_us(available_us: u32, least_period_us: u32) -> u32 {
    if available_us >= least_period_us + (GAP_US - GAP_MIN_US) {
        GAP_US
    } else {
        GAP_MIN_US
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_is_short_where_the_period_is() {
        let least_us = Morpheus::tick_us(1_000_000, Readiness::Prepared);
        assert_eq!((gap_us(1_000, least_us), gap_us(600, least_us)), (80, 30));
    }

    #[test]
    fn the_window_is_longer_on_a_slow_bus_with_room() {
        let window_us = |period_us, baud| positions_window_us(period_us, baud);
        assert_eq!(window_us(10_000, 1_000_000), 450);
        assert_eq!(window_us(10_000, 500_000), 280 + 310 + 200);
        assert_eq!(window_us(10_000, 57_142), 2_451 + 310 + 3_300);
        assert_eq!(window_us(6_600, 57_142), 2_451 + 310 + 69);
    }
}
