//! What a board tells unasked: of itself, of its servos, of its faults.

use armbridge_shared::link::message::{
    BoardReport, Missing, OffReport, PortCounters, ToHost, Trip,
};
use armbridge_shared::servo::Firmware;

use super::OperatorError;
use armbridge_client::link::Said;

/// What is known by now.
#[derive(Debug, Default)]
pub(super) struct News {
    /// The servo that was missed last, and what was heard instead.
    pub(super) absent: Option<(u8, Missing)>,
    /// Why the servos are of no use though they answer.
    pub(super) trouble: Option<OperatorError>,
    pub(super) found: Option<(Firmware, u32)>,
    /// Servos that were found take torque.
    pub(super) is_ready: bool,
    pub(super) report: Option<BoardReport>,
    pub(super) trips: Vec<Trip>,
    pub(super) off_reports: Vec<OffReport>,
    pub(super) port: PortCounters,
    /// Points of a stream that came too late.
    pub(super) late_points: u64,
}

impl News {
    /// Remembers what of it is news.
    ///
    /// # Errors
    /// If the board can no longer be worked with.
    pub(super) fn take(&mut self, said: &Said) -> Result<(), OperatorError> {
        match *said {
            Said::OtherSchema(hello) => return Err(OperatorError::OtherSchema(hello)),
            Said::Told(ToHost::Board(report)) => {
                let before = self.report.replace(report);
                if before.is_some_and(|before| before.is_before_reset(&report)) {
                    return Err(OperatorError::Reset(report.last_end));
                }
            }
            // Repeated after a hello.
            Said::Told(ToHost::Tripped(trip)) if self.trips.last() == Some(&trip) => {}
            Said::Told(ToHost::Tripped(trip)) => self.trips.push(trip),
            Said::Told(ToHost::Off(report)) => self.off_reports.push(report),
            Said::Told(ToHost::Absent { joint, missing }) => {
                self.absent = Some((joint, missing));
                self.trouble = None;
            }
            Said::Told(ToHost::Mixed([a, b])) => self.trouble = Some(OperatorError::Mixed(a, b)),
            Said::Told(ToHost::Unprepared { joint }) => {
                self.trouble = Some(OperatorError::Unprepared(joint));
            }
            Said::Told(ToHost::Found {
                firmware,
                baud,
                is_ready,
            }) => {
                if is_ready {
                    self.trouble = None;
                }
                self.found = Some((firmware, baud));
                self.is_ready = is_ready;
            }
            Said::Told(ToHost::Port(counters)) => self.port = counters,
            Said::Hello
            | Said::Done
            | Said::Refused(_)
            | Said::Told(
                ToHost::Hello(_)
                | ToHost::Ack { .. }
                | ToHost::Departs { .. }
                | ToHost::Began(_)
                | ToHost::Settings(_)
                | ToHost::Passthrough
                | ToHost::Concluded(_)
                | ToHost::Temperature { .. }
                | ToHost::Record(_),
            ) => {}
        }
        Ok(())
    }
}
