//! Fault injection: failures on demand, for tests of their consequences.
//!
//! The semihosting argument `provoke=KIND@MS` makes the real-time loop fail, in
//! its own interrupt, in its first iteration after that many milliseconds of the
//! board's time. It does so after power-up only, not after the reset that
//! follows.
//!
//! | kind       | failure                                                 |
//! |------------|---------------------------------------------------------|
//! | `panic`    | a panic, in this file                                   |
//! | `fault`    | a jump to where no code may be: a hard fault            |
//! | `overflow` | recursion without end                                   |
//! | `hang`     | a loop without end                                      |
//! | `rot`      | bits of the saved settings turn, and a panic            |

use super::flash;
use super::semihosting::Arguments;
use armbridge_link::message::End;
use core::hint::black_box;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

/// Pending failure, as an index of [`KINDS`], and its time in ms.
static KIND: AtomicU8 = AtomicU8::new(NONE);
static AT_MS: AtomicU32 = AtomicU32::new(0);

const NONE: u8 = u8::MAX;
const KINDS: [(&str, fn()); 5] = [
    ("provoke=panic@", provoked_panic),
    ("provoke=fault@", fault),
    ("provoke=overflow@", overflow),
    ("provoke=hang@", hang),
    ("provoke=rot@", rot),
];

/// Reads the requested failure, after power-up only.
pub fn prepare(arguments: &Arguments, last_end: End) {
    if last_end != End::PowerUp {
        return;
    }
    for (index, (name, _)) in KINDS.iter().enumerate() {
        if let Some(ms) = arguments.number(name) {
            KIND.store(index as u8, Ordering::Relaxed);
            AT_MS.store(ms, Ordering::Relaxed);
        }
    }
}

/// Fails at the requested time.
pub fn if_due(now_us: u64) {
    let kind = KIND.load(Ordering::Relaxed);
    if kind != NONE && now_us / 1_000 >= u64::from(AT_MS.load(Ordering::Relaxed)) {
        KIND.store(NONE, Ordering::Relaxed);
        if let Some((_, fail)) = KINDS.get(usize::from(kind)) {
            fail();
        }
    }
}

fn provoked_panic() {
    panic!("provoked");
}

fn rot() {
    flash::damage();
    provoked_panic();
}

fn fault() {
    // SAFETY: none is claimed: the address is in the region below the stack, of
    // which nothing may be executed (see `stack_guard`). This faults.
    let nowhere: extern "C" fn() = unsafe { core::mem::transmute(0x1000_0001_usize) };
    nowhere();
}

fn overflow() {
    recurse(0);
}

#[expect(unconditional_recursion, reason = "the recursion overflows the stack")]
#[inline(never)]
fn recurse(depth: u32) -> u32 {
    let used = black_box([depth; 16]);
    recurse(depth + 1) + used.iter().sum::<u32>()
}

fn hang() {
    loop {
        cortex_m::asm::nop();
    }
}
