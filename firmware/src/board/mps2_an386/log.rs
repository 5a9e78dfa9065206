//! The log: defmt frames to QEMU's semihosting console.
//!
//! A frame is collected first and then handed over, since each call stops the
//! core until the host has written it. A frame that is too long is truncated;
//! the decoder drops it and resynchronises at the next.

use core::cell::RefCell;
use critical_section::{Mutex, RestoreState};

/// Longest frame, encoded: a panic message.
const FRAME_MAX: usize = 512;

struct State {
    encoder: defmt::Encoder,
    frame: [u8; FRAME_MAX],
    len: usize,
    /// Frames begun within one another; only the outermost is sent.
    depth: u32,
    restore: RestoreState,
}

static STATE: Mutex<RefCell<State>> = Mutex::new(RefCell::new(State {
    encoder: defmt::Encoder::new(),
    frame: [0; FRAME_MAX],
    len: 0,
    depth: 0,
    restore: RestoreState::invalid(),
}));

impl State {
    fn encode(&mut self, step: impl FnOnce(&mut defmt::Encoder, &mut dyn FnMut(&[u8]))) {
        let Self {
            encoder,
            frame,
            len,
            ..
        } = self;
        step(encoder, &mut |bytes| {
            if let Some(to) = frame.get_mut(*len..*len + bytes.len()) {
                to.copy_from_slice(bytes);
                *len += bytes.len();
            }
        });
    }
}

fn with(act: impl FnOnce(&mut State)) {
    critical_section::with(|cs| {
        if let Ok(mut state) = STATE.borrow(cs).try_borrow_mut() {
            act(&mut state);
        }
    });
}

#[defmt::global_logger]
struct Logger;

// SAFETY: `acquire` enters a critical section that `release` leaves, so no two
// contexts are ever between them. Each function borrows the state only while it
// runs.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // SAFETY: `release`, which defmt calls once for every `acquire` and in
        // reverse order, restores this state.
        let restore = unsafe { critical_section::acquire() };
        with(|state| {
            state.depth += 1;
            if state.depth == 1 {
                state.restore = restore;
                state.len = 0;
                state.encode(|encoder, write| encoder.start_frame(write));
            }
        });
    }

    unsafe fn flush() {
        // A frame is with the host when it is released.
    }

    unsafe fn release() {
        let mut restore = None;
        with(|state| {
            state.depth = state.depth.saturating_sub(1);
            if state.depth == 0 {
                state.encode(|encoder, write| encoder.end_frame(write));
                super::semihosting::print(state.frame.get(..state.len).unwrap_or_default());
                restore = Some(state.restore);
            }
        });
        if let Some(restore) = restore {
            // SAFETY: this is the state that the outermost `acquire` got; the
            // ones within changed nothing, interrupts being masked already.
            unsafe { critical_section::release(restore) };
        }
    }

    unsafe fn write(bytes: &[u8]) {
        with(|state| state.encode(|encoder, write| encoder.write(bytes, write)));
    }
}
