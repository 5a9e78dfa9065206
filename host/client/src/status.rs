//! Status of a board: the latest of each of its messages.

use armbridge_link::experiment::Conclusion;
use armbridge_link::message::{
    BoardReport, Hello, LastEnd, Missing, Mode, OffReport, PortCounters, Record, Settings, ToHost,
    Trip,
};
use armbridge_link::schema;
use armbridge_link::server::LinkRole;
use armbridge_servo::{Firmware, JOINTS};

use crate::error::{end_in_words, likely_cause};

/// Servos that a board has found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FoundServos {
    /// Their firmware.
    pub firmware: Firmware,
    /// Baud rate of the bus.
    pub baud: u32,
    /// They take torque; stock servos do so in wheel mode only.
    pub is_ready: bool,
}

/// Reason for which a board cannot arm although no fault is latched.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Obstacle {
    /// It was built from other message types.
    #[error("the board runs another version: flash it with this one")]
    OtherSchema,
    /// It has been reset.
    #[error("the board has been reset: {}", end_in_words(.0))]
    Reset(LastEnd),
    /// A servo does not answer.
    #[error("servo {} does not answer: {}", u32::from(*joint) + 1, likely_cause(*missing))]
    Absent {
        /// Joint that it moves, counting from 0.
        joint: u8,
        /// Reason for the missing reply.
        missing: Missing,
    },
    /// Stock servos are not in wheel mode, those of the X series not in the board's control mode.
    #[error("the servos are not set up for torque")]
    NotReady,
    /// The servos run different firmwares.
    #[error(
        "servo 1 runs {0} and servo 2 {1}: they disturb each other on one bus; flash both alike"
    )]
    Mixed(Firmware, Firmware),
    /// A stock or X servo rejects its settings.
    #[error(
        "servo {} answers, but does not take the settings for torque: is its EEPROM locked? Switch its \
         power off and on. With `setup.control_mode` \"current\" it must be an X servo that measures \
         its current, with a current limit of at least `limits.pwm_counts`", u32::from(*.0) + 1
    )]
    Unprepared(u8),
}

/// Known state of a board. A message that has not arrived is `None`.
#[derive(Clone, Debug, Default)]
pub struct BoardStatus {
    /// Its version and schema.
    pub hello: Option<Hello>,
    /// Its session, settings' source, last end, stack and image.
    pub report: Option<BoardReport>,
    /// Settings in force.
    pub settings: Option<Settings>,
    /// The latest tick.
    pub record: Option<Record>,
    /// Its servos.
    pub servos: Option<FoundServos>,
    /// Reason for which it cannot arm.
    pub obstacle: Option<Obstacle>,
    /// Cause of the latched fault.
    pub trip: Option<Trip>,
    /// Report on the servos after the stop sequence.
    pub off: Option<OffReport>,
    /// Temperature of each servo, in °C from stock servos, in counts of their converter
    /// from Morpheus.
    pub temperature: [Option<u16>; JOINTS],
    /// Result of the last experiment, until another command drives the arm.
    pub concluded: Option<Conclusion>,
    /// The commanding program, on a link that is served to several.
    pub role: Option<LinkRole>,
    /// Packets on the transparent port.
    pub port: PortCounters,
    /// A client of the transparent port has the bus.
    is_passthrough: bool,
}

impl BoardStatus {
    /// Number of joints, by the settings; as many as there may be while they are not known.
    pub fn joints(&self) -> usize {
        self.settings
            .map_or(JOINTS, |settings| settings.setup.arm.joints())
    }

    /// Mode of the board.
    pub fn mode(&self) -> Option<Mode> {
        if self.is_passthrough {
            return Some(Mode::Passthrough);
        }
        self.record.map(|record| record.mode)
    }

    /// Whether the motors are driven, by the latest tick.
    pub fn is_driven(&self) -> bool {
        self.mode().is_some_and(|mode| mode.drive().is_some())
    }

    /// Whether the board has a pose to park the arm in.
    pub fn has_pose(&self) -> bool {
        self.settings
            .is_some_and(|settings| settings.limits.park.is_some())
    }

    /// Discards everything: the board was reset, or its link broke.
    pub fn forget(&mut self) {
        *self = Self {
            hello: self.hello,
            ..Self::default()
        };
    }

    /// Whether another program commands, or none, but not this one.
    pub fn is_observer(&self) -> bool {
        self.role.is_some_and(|role| !role.is_commander)
    }

    /// Updates the status with a message.
    pub fn take(&mut self, message: &ToHost) {
        match *message {
            ToHost::Hello(hello) => {
                self.hello = Some(hello);
                self.obstacle = (hello.schema != schema::HASH).then_some(Obstacle::OtherSchema);
            }
            ToHost::Settings(settings) => self.settings = Some(settings),
            ToHost::Absent { joint, missing } => {
                self.obstacle = Some(Obstacle::Absent { joint, missing });
            }
            ToHost::Found {
                firmware,
                baud,
                is_ready,
            } => {
                self.servos = Some(FoundServos {
                    firmware,
                    baud,
                    is_ready,
                });
                self.obstacle = (!is_ready).then_some(Obstacle::NotReady);
            }
            ToHost::Mixed([first, second]) => self.obstacle = Some(Obstacle::Mixed(first, second)),
            ToHost::Unprepared { joint } => self.obstacle = Some(Obstacle::Unprepared(joint)),
            ToHost::Passthrough => self.is_passthrough = true,
            ToHost::Board(report) => {
                let before = self.report.replace(report);
                if before.is_some_and(|before| before.is_before_reset(&report)) {
                    self.obstacle = Some(Obstacle::Reset(report.last_end));
                }
            }
            ToHost::Tripped(trip) => self.trip = Some(trip),
            ToHost::Off(report) => self.off = Some(report),
            ToHost::Temperature { joint, value } => {
                if let Some(known) = self.temperature.get_mut(usize::from(joint)) {
                    *known = Some(value);
                }
            }
            ToHost::Record(record) => self.take_record(record),
            ToHost::Concluded(conclusion) => self.concluded = Some(conclusion),
            ToHost::Port(counters) => self.port = counters,
            ToHost::Ack { .. } | ToHost::Departs { .. } | ToHost::Began(_) => {}
        }
    }

    fn take_record(&mut self, record: Record) {
        use armbridge_link::message::Drive::{Experiment, Hold};

        let is_fault = |mode| matches!(mode, Mode::Fault(_));
        let was_fault = self.record.is_some_and(|last| is_fault(last.mode));
        if was_fault && !is_fault(record.mode) {
            (self.trip, self.off) = (None, None);
        }
        if !matches!(record.mode.drive(), Some(Hold | Experiment)) {
            self.concluded = None;
        }
        if record.mode.is_armed() {
            self.obstacle = None;
        }
        self.is_passthrough = false;
        self.record = Some(record);
    }
}
