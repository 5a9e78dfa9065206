//! What both masters expect of two servos XL430-W250.

use std::error::Error;
use std::fmt::Debug;
use std::thread::sleep;
use std::time::{Duration, Instant};

pub(crate) type Result<T = (), E = Box<dyn Error>> = std::result::Result<T, E>;

pub(crate) const BAUD: u32 = 1_000_000;
pub(crate) const IDS: [u8; 2] = [1, 2];
/// An id that no servo has.
pub(crate) const ABSENT: u8 = 9;
/// XL430-W250.
pub(crate) const MODEL: u16 = 1060;
pub(crate) const PWM_MODE: u8 = 16;
/// An operating mode that there is not.
pub(crate) const NO_MODE: u8 = 7;
/// Error numbers of status packets.
pub(crate) const DATA_RANGE: u8 = 4;
pub(crate) const ACCESS: u8 = 7;

/// Of what may be late, and the time before the next.
pub(crate) const ATTEMPTS: usize = 5;
pub(crate) const PAUSE: Duration = Duration::from_millis(500);

/// In range, and FF FF FD FF as bytes: it is stuffed, in an instruction and in an answer.
pub(crate) const STUFFED: i32 = -131_073;

/// The arm hangs still, but for the noise of its encoders.
const NOISE_COUNTS: i64 = 8;
/// A third of the greatest: far more than gravity needs.
pub(crate) const PWM: i16 = 300;
/// Far more than noise.
const MOVED_COUNTS: i64 = 100;
const MOVED_WITHIN: Duration = Duration::from_secs(10);
/// Longer than a servo takes to store registers, in which the virtual one hears nothing; unless the
/// computer is busy.
pub(crate) const STORE: Duration = Duration::from_millis(20);
/// Longer than a servo takes to start.
pub(crate) const BOOT: Duration = Duration::from_millis(300);

/// An error unless the two are equal.
pub(crate) fn expect<T: Debug + PartialEq>(what: &str, seen: &T, expected: &T) -> Result {
    if seen == expected {
        return Ok(());
    }
    Err(format!("{what}: {seen:?}, expected {expected:?}").into())
}

/// An error unless the supply, in 0.1 V, is one that the servo works with.
pub(crate) fn expect_supply(volts: u16) -> Result {
    expect("supply is plausible", &(60..=140).contains(&volts), &true)
}

/// An error unless the positions are those read before.
pub(crate) fn expect_still(what: &str, seen: &[i64], before: &[i64]) -> Result {
    let close = |(a, b): (&i64, &i64)| (a - b).abs() <= NOISE_COUNTS;
    if seen.len() == before.len() && seen.iter().zip(before).all(close) {
        return Ok(());
    }
    Err(format!("{what}: {seen:?}, a moment ago {before:?}").into())
}

/// Waits until the position has moved, forth or back.
pub(crate) fn wait_until_moved(
    direction: i64,
    mut position: impl FnMut() -> Result<i64>,
) -> Result {
    let (from, begin) = (position()?, Instant::now());
    loop {
        let moved = position()? - from;
        if moved * direction >= MOVED_COUNTS {
            return Ok(());
        }
        if begin.elapsed() > MOVED_WITHIN {
            return Err(format!("driven by {direction}, it has moved by {moved} counts").into());
        }
        sleep(Duration::from_millis(10));
    }
}

/// A part of the checks, named when it has passed. A board may still be starting, and a busy computer
/// is late sometimes: a part that fails is repeated after a pause.
pub(crate) fn part(name: &str, mut checks: impl FnMut() -> Result) -> Result {
    let mut result = checks();
    for _ in 1..ATTEMPTS {
        if result.is_ok() {
            break;
        }
        sleep(PAUSE);
        result = checks();
    }
    result.map_err(|error| format!("{name}: {error}"))?;
    println!("{name}: as they should be");
    Ok(())
}
