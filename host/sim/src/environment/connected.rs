//! A board that is connected, real or served, as the board of an environment.
//!
//! It runs in real time: a step lasts its ticks. The board moves the arm to the start of an
//! episode by itself, from wherever it is, and holds it until the first action. It is armed by the
//! first episode, and stays so: to disarm it is up to the owner of the connection.

use std::sync::Arc;
use std::time::Duration;

use armbridge_link::message::{Command, Mode, Record};
use armbridge_servo::JOINTS;

use super::Observation;
use crate::link::{BoardClient, ClientError, CommandSender};

/// Duration of the motion to the start of an episode, in s.
const MOVE_S: f32 = 1.5;
/// Rest at the start, so that the arm stands still.
const REST: Duration = Duration::from_millis(500);
/// Longest time in which a motion or the ticks of a step come.
const PATIENCE: Duration = Duration::from_secs(5);

/// See the [module](self).
pub(super) struct ConnectedBoard {
    client: Arc<BoardClient>,
    commands: CommandSender,
}

impl std::fmt::Debug for ConnectedBoard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ConnectedBoard").finish_non_exhaustive()
    }
}

impl ConnectedBoard {
    pub(super) fn new(client: Arc<BoardClient>) -> Self {
        Self {
            client,
            commands: CommandSender::default(),
        }
    }

    /// Clears a fault, arms the board, and moves the arm to these angles in rad.
    pub(super) fn reset(&mut self, start_rad: [f64; JOINTS]) -> Result<Observation, ClientError> {
        self.commands = CommandSender::default();
        if let Some(Mode::Fault(_)) = self.client.status().mode() {
            self.client.clear()?;
        }
        if !self.client.is_armed() {
            self.client.arm()?;
        }
        let start_rad = start_rad.map(|angle| angle as f32);
        let motion = self.client.move_to(start_rad, Some(MOVE_S))?;
        self.client.wait_for(&motion, PATIENCE)?;
        let tick_us = self
            .client
            .status()
            .settings
            .unwrap_or_default()
            .setup
            .period_us;
        let ticks = REST.as_micros() as u32 / tick_us.max(1);
        self.await_ticks(ticks)
    }

    /// Sends a command, and waits for so many ticks; returns the last.
    pub(super) fn advance(
        &mut self,
        command: Command,
        ticks: u32,
    ) -> Result<Observation, ClientError> {
        let is_fault = matches!(self.client.status().mode(), Some(Mode::Fault(_)));
        if !is_fault {
            self.commands.send(&self.client, command)?;
        }
        self.await_ticks(ticks)
    }

    fn await_ticks(&self, ticks: u32) -> Result<Observation, ClientError> {
        let before = self.client.status().record.map_or(0, |record| record.tick);
        let has_come = |record: &Record| record.tick.wrapping_sub(before) >= ticks;
        let wait = self
            .client
            .wait(PATIENCE, "the ticks of a step did not come", |status| {
                let is_fault = matches!(status.mode(), Some(Mode::Fault(_)));
                is_fault || status.record.as_ref().is_some_and(has_come)
            });
        wait?;
        let record = self.client.status().record.unwrap_or(Record::NONE);
        Ok(Observation::from(&record))
    }
}
