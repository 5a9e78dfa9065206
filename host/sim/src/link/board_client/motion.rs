//! A motion that the board follows, until its reference rests.

use std::time::Duration;

use armbridge_client::status::BoardStatus;
use armbridge_link::message::{Command, Drive, Mode, Record};
use armbridge_link::motion::Motion;
use armbridge_servo::JOINTS;

use super::{BoardClient, ClientError, PLANNED_TICKS};

/// Distance in rad, and speed in rad/s, at which the reference has arrived: rounding.
const ARRIVED: f32 = 1e-4;
/// A motion that the board has accepted.
#[derive(Clone, Copy, Debug)]
pub struct ActiveMotion {
    goal_rad: [f32; JOINTS],
    /// The last tick before it was sent.
    after_tick: u32,
}

impl ActiveMotion {
    /// Whether the reference rests at the motion's end.
    pub fn has_arrived(&self, status: &BoardStatus) -> bool {
        status.record.is_some_and(|record| {
            let output = &record.output;
            self.ticks(&record) > 1
                && (0..JOINTS).all(|joint| {
                    (output.reference_rad[joint] - self.goal_rad[joint]).abs() < ARRIVED
                        && output.reference_speed_rad_s[joint].abs() < ARRIVED
                })
        })
    }

    /// Whether the board follows something else, or nothing.
    fn is_replaced(&self, status: &BoardStatus) -> bool {
        let is_followed = status.mode().and_then(Mode::drive) == Some(Drive::Track);
        let is_planned = |record: Record| self.ticks(&record) > PLANNED_TICKS;
        !is_followed && status.record.is_some_and(is_planned)
    }

    /// Ticks since it was sent; the numbers wrap.
    fn ticks(&self, record: &Record) -> i32 {
        record.tick.wrapping_sub(self.after_tick) as i32
    }
}

impl BoardClient {
    /// Moves the arm to these angles in rad with least jerk, in this time in s or as fast as the
    /// bounds permit. Returns when the board has accepted the motion.
    ///
    /// # Errors
    /// If the board refuses it.
    pub fn move_to(
        &self,
        to_rad: [f32; JOINTS],
        duration_s: Option<f32>,
    ) -> Result<ActiveMotion, ClientError> {
        let after_tick = self.status().record.map_or(0, |record| record.tick);
        self.command(Command::Follow(Motion::MinimumJerk { to_rad, duration_s }))?;
        Ok(ActiveMotion {
            goal_rad: to_rad,
            after_tick,
        })
    }

    /// Waits until the reference rests at the motion's end.
    ///
    /// # Errors
    /// After the timeout, by a fault, and if another command ended the motion.
    pub fn wait_for(&self, motion: &ActiveMotion, timeout: Duration) -> Result<(), ClientError> {
        self.wait_without_fault(timeout, "the motion did not end", |status| {
            motion.has_arrived(status) || motion.is_replaced(status)
        })?;
        if motion.has_arrived(&self.status()) {
            Ok(())
        } else {
            Err(ClientError::Dropped)
        }
    }
}
