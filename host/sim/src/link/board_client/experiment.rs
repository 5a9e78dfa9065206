//! An experiment that the board performs, until it reports how it ended.

use std::time::Duration;

use armbridge_client::status::BoardStatus;
use armbridge_link::experiment::{Conclusion, Experiment};
use armbridge_link::message::{Command, Drive, Mode};

use super::{ANSWER, BoardClient, ClientError, PLANNED_TICKS};

impl BoardClient {
    /// Performs an experiment from where the arm is, and returns how it ended; the arm is held
    /// then.
    ///
    /// # Errors
    /// If the board refuses it, after a fault, and if another command ended it.
    pub fn experiment(&self, experiment: &Experiment) -> Result<Conclusion, ClientError> {
        let after_tick = self.status().record.map_or(0, |record| record.tick);
        let ticks = |tick: u32| tick.wrapping_sub(after_tick) as i32;
        let concluded = |status: &BoardStatus| status.concluded.filter(|it| ticks(it.tick) > 0);
        let is_left = |status: &BoardStatus| {
            let drive = status.mode().and_then(Mode::drive);
            let is_over = !matches!(drive, Some(Drive::Experiment | Drive::Hold));
            is_over
                && status
                    .record
                    .is_some_and(|it| ticks(it.tick) > PLANNED_TICKS)
        };
        self.command(Command::Experiment(*experiment))?;
        let lasts = Duration::try_from_secs_f32(experiment.duration_s).unwrap_or_default();
        self.wait_without_fault(
            lasts.saturating_add(ANSWER),
            "the experiment did not end",
            |status| concluded(status).is_some() || is_left(status),
        )?;
        concluded(&self.status()).ok_or(ClientError::Dropped)
    }
}
