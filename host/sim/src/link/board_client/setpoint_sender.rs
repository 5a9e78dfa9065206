//! Setpoints of a program as a stream that the board follows, each due one lead later.

use std::time::{Duration, Instant};

use armbridge_client::setpoint_stream::SetpointStream;
use armbridge_link::message::Record;
use armbridge_servo::JOINTS;

use super::{BoardClient, ClientError, CommandSender};

/// A stream, begun by its first setpoint.
#[derive(Debug)]
pub struct SetpointSender {
    lead: Duration,
    commands: CommandSender,
    begun: Option<(Instant, SetpointStream)>,
}

impl SetpointSender {
    /// A stream whose setpoints are sent this long before the arm follows them.
    pub fn new(lead: Duration) -> Self {
        Self {
            lead,
            commands: CommandSender::default(),
            begun: None,
        }
    }

    /// Ends the stream; the next setpoint begins another one.
    pub fn end(&mut self) {
        self.begun = None;
    }

    /// Deadline of the setpoint at this time in s since the first; that of the first itself is
    /// now.
    pub fn deadline(&self, since: Duration) -> Instant {
        self.begun
            .map_or_else(Instant::now, |(begun, _)| begun + since)
    }

    /// Sends the setpoint of this deadline: angles in rad, and speeds in rad/s unless the board is
    /// to compute them. Returns whether the one before came too late for the board.
    ///
    /// # Errors
    /// If the link has ended, or the board refused the one before for another reason.
    pub fn send(
        &mut self,
        client: &BoardClient,
        deadline: Instant,
        angle_rad: [f32; JOINTS],
        speed_rad_s: Option<[f32; JOINTS]>,
    ) -> Result<bool, ClientError> {
        let due_us = client.telemetry().board_us(Instant::now() + self.lead);
        let (begun, stream) = self.begun.get_or_insert_with(|| {
            let record = client.status().record.unwrap_or(Record::NONE);
            (deadline, SetpointStream::new(&record, due_us))
        });
        let t_s = deadline.saturating_duration_since(*begun).as_secs_f64();
        let command = stream.command(t_s, due_us, angle_rad, speed_rad_s);
        self.commands.send(client, command)
    }
}
