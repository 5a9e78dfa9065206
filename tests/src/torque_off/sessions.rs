//! End of a session that drives the arm, by another session's hello or by a goodbye,
//! behind a flood of frames in the same write: torque is off, however many there are.

use armbridge_link::message::{Command, Mode, Refusal, ToBoard};
use armbridge_servo::Firmware;

use super::cases::{all, check, run_cases};
use super::rig::{Rig, STOP_US, World, bench, between_obstacles, with_rig};

/// Torques that drive the arm.
const DRIVE: Command = Command::Torque([0.2, 0.1]);
/// Most frames before the end in one write.
const FLOOD_MAX: usize = 64;
/// Time for which motors that are off are watched, in ms.
const WATCH_MS: u64 = 50;
/// Until a fault is cleared, in µs.
const CLEARED_US: u64 = 1_000_000;

/// Frame that ends the session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Another session begins.
    Hello,
    /// The host leaves.
    Goodbye,
}

/// Frames of the session that ends, in the same write.
#[derive(Clone, Copy, Debug)]
enum Flood {
    Heartbeats,
    Commands,
}

impl Rig<'_> {
    /// Makes the board idle, whatever it was before.
    fn make_idle(&mut self) {
        assert_eq!(self.command(Command::Idle), Ok(()));
        self.pass_ms(10);
        if matches!(self.mode(), Some(Mode::Fault(_))) {
            assert_eq!(self.command(Command::ClearFault), Ok(()));
        }
        self.until("idle", CLEARED_US, |rig| rig.mode() == Some(Mode::Idle));
    }

    /// Ends a session that drives the arm behind so many frames.
    fn end_session(&mut self, end: End, flood: Flood, frames: usize) -> Result<(), String> {
        self.drive(DRIVE);
        self.pass_ms(20);
        assert_eq!(self.is_on(), [true; 2], "{frames} frames: driven");
        let off_us = self.now_us() + STOP_US;
        for _ in 0..frames {
            self.host().send(match flood {
                Flood::Heartbeats => ToBoard::Heartbeat,
                Flood::Commands => ToBoard::Command(DRIVE),
            });
        }
        match end {
            End::Hello => self.host().begin_session(),
            End::Goodbye => {
                self.host().send(ToBoard::Goodbye);
                self.host().is_silent = true;
            }
        }
        let off = self.stays_off(off_us, WATCH_MS);
        if end == End::Goodbye {
            self.host().begin_session();
            self.pass_ms(WATCH_MS);
        }
        let mode = self.mode();
        let answer = self.command(DRIVE);
        let is_refused = matches!(answer, Err(Refusal::Disarmed | Refusal::Faulted));
        all([
            off,
            check(mode.is_some_and(|mode| !mode.is_armed()), || {
                format!("the next session finds {mode:?}")
            }),
            check(is_refused, || {
                format!("the next session's command to drive is answered {answer:?}")
            }),
            self.reports_are_true(),
        ])
    }
}

/// One board, session after session.
pub fn sessions_end(world: World, end: End) {
    let bench = bench(&between_obstacles(), Firmware::Morpheus);
    let floods = [Flood::Heartbeats, Flood::Commands];
    let cases = floods
        .into_iter()
        .flat_map(|flood| (0..=FLOOD_MAX).map(move |frames| (flood, frames)));
    with_rig(world, bench, |rig| {
        run_cases(cases, |(flood, frames)| {
            rig.make_idle();
            rig.end_session(end, *flood, *frames)
        });
    });
}
