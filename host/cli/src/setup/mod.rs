//! Guide from an assembled board to the first motion: what is missing is named with its remedy,
//! and the first thing missing ends it.
//!
//! Each step first checks whether it is done, so that a second run goes on where the first
//! ended. Every step is another command's work, and leaves the board disarmed:
//!
//! | step        | check                               | work                                        |
//! |-------------|-------------------------------------|---------------------------------------------|
//! | computer    | permissions, as `doctor`            |                                             |
//! | board       | it answers, without a fault         | `status`                                    |
//! | servos      | it has found ids 1 and 2            | `scan`, `servo ID set-id`; see [`servos`]   |
//! | calibration | zeros and signs are not the default | `calibrate`                                 |
//! | direction   | each motor's, by the motor check    | `arm`: three counts either way, at most 0.06 rad |
//! | hold        | the arm stays where it is           | the same arming goes on; torque off at its end |
//!
//! The last two are one arming, as an arm that is let go between them would fall. Whatever
//! goes wrong in it ends with torque off: [`Arm`] disarms, and a board that does not hear from
//! it does so by itself.
//!
//! [`Arm`]: crate::board_tasks::arm::Arm

mod motion;
pub mod servos;

use std::time::Duration;

use armbridge_client::servo_bus::Port;
use armbridge_client::status::BoardStatus;
use armbridge_client::transport::usb::UsbError;
use armbridge_client::transport::{self, LinkOptions, LinkUri, TransportError};
use armbridge_client::{LinkError, ctrl_c, fault_text};
use armbridge_control::actuator::Joint;
use armbridge_control::encoder::Encoder;
use armbridge_link::message::{SettingsGroups, Setup as BoardSetup};
use armbridge_servo::JOINTS;

use crate::board_tasks::calibrate::{Calibrate, CalibrationOptions, Guide};
use crate::board_tasks::status::Status;
use crate::board_tasks::{Task, TaskError, TaskHost};
use crate::device_permissions;
use crate::finding::Finding;

/// Time between two looks for an answer.
const LOOK: Duration = Duration::from_millis(20);

/// Reason for which the guide cannot go on at all, in a line for the user.
pub type Error = Box<dyn std::error::Error>;

/// Where the board is, and how much is asked.
#[derive(Clone, Debug)]
pub struct SetupOptions {
    /// The board's link.
    pub link: LinkUri,
    /// The servo bus, on the board's transparent port.
    pub port: Option<Port>,
    /// Time-out of a servo's reply beyond its time on the wire.
    pub patience: Duration,
    /// Permanent changes are made without a question. Motions are asked for all the same.
    pub is_sure: bool,
    /// Duration of the hold.
    pub hold: Duration,
}

/// A step, by its name.
type Step<'a> = (&'static str, fn(&mut Setup<'a>) -> Result<Finding, Error>);

/// The guide at work.
pub struct Setup<'a> {
    options: &'a SetupOptions,
    guide: &'a mut dyn Guide,
    /// The board's, as it was last seen.
    status: BoardStatus,
    /// Firmware of the servos needs wheel mode first.
    needs_wheel_mode: bool,
    /// The hold that went with the motor check.
    hold: Option<Finding>,
}

impl<'a> Setup<'a> {
    /// Nothing done yet.
    pub fn new(options: &'a SetupOptions, guide: &'a mut dyn Guide) -> Self {
        Self {
            options,
            guide,
            status: BoardStatus::default(),
            needs_wheel_mode: false,
            hold: None,
        }
    }

    /// Takes the steps in their order, and reports each; false if one found something missing.
    ///
    /// # Errors
    /// If the guide cannot go on at all: no answers come, or ctrl-c was pressed.
    pub fn run(mut self, mut report: impl FnMut(&str, &Finding)) -> Result<bool, Error> {
        let steps: [Step<'a>; 6] = [
            ("computer", |setup| Ok(setup.computer())),
            ("board", |setup| Ok(setup.board())),
            ("servos", Self::servos),
            ("calibration", Self::calibration),
            ("direction", Self::direction),
            ("hold", |setup| Ok(setup.hold())),
        ];
        for (name, take) in steps {
            let finding = take(&mut self)?;
            report(name, &finding);
            if finding.parts().2.is_some() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn computer(&self) -> Finding {
        match self.options.link {
            // The serial port is needed to search the bus alone, and its error names the group.
            LinkUri::Usb(_) | LinkUri::Serial(_) => device_permissions::usb_permission(),
            LinkUri::Tcp(_) | LinkUri::Pty(_) => {
                Finding::Open(format!("{} is no USB", self.options.link))
            }
        }
    }

    fn board(&mut self) -> Finding {
        if let Err(failure) = self.look() {
            return no_board(&failure);
        }
        let (link, status) = (&self.options.link, &self.status);
        if let Some(trip) = &status.trip {
            let fault = fault_text::in_words(trip);
            let remedy = format!("{}:\narmbridge clear --link {link}", fault.remedy);
            return Finding::missing(format!("fault: {}", fault.cause), remedy);
        }
        let lost = status.report.map(|report| report.settings.lost());
        if lost.is_some_and(|lost| lost != SettingsGroups::NONE) {
            let remedy = format!(
                "look at those in force, then confirm them:\narmbridge params --save --link {link}"
            );
            return Finding::missing("saved settings are lost, so that it does not arm", remedy);
        }
        let version = status.hello.map_or([0; 3], |hello| hello.version);
        let version = version.map(|part| part.to_string()).join(".");
        Finding::Ok(format!("{link}, version {version}, no fault"))
    }

    fn calibration(&mut self) -> Result<Finding, Error> {
        let joints = self.status.settings.map(|settings| settings.setup.joints);
        let encoder = (self.status.servos).map(|servos| Encoder::of(servos.firmware));
        let is_other = |joint: &Joint<f32>| joint.encoder() != encoder;
        let count = self.status.joints();
        let is_new = joints.is_some_and(|joints| {
            joints == BoardSetup::default().joints || joints.iter().take(count).any(is_other)
        });
        let joints = if is_new {
            let options = CalibrationOptions {
                joints: [true; JOINTS],
                mode: None,
                checks_motors: false,
                is_sure: self.options.is_sure,
            };
            let calibrate = Calibrate::new(&mut *self.guide, options);
            match drive(self.options, calibrate) {
                Ok(host) => host.task.result().map(|[_, after]| after),
                Err(LinkError::Host(error)) if !is_over(&error) => {
                    let again = "armbridge setup, which goes on from here";
                    return Ok(Finding::missing(error.to_string(), again));
                }
                Err(error) => return Err(error.into()),
            }
        } else {
            joints
        };
        let joints = joints.ok_or("the board reports no settings")?;
        let zeros = joints.iter().take(count).map(|joint| {
            let direction = format!("{:?}", joint.direction).to_lowercase();
            format!("{:.1} {direction}", joint.zero_count)
        });
        let zeros = zeros.collect::<Vec<_>>().join(", ");
        let how = if is_new {
            "saved"
        } else {
            "there; `armbridge calibrate` to renew it"
        };
        Ok(Finding::Ok(format!("zeros {zeros}: {how}")))
    }

    /// Looks at the board.
    fn look(&mut self) -> Result<(), LinkError<TaskError>> {
        let host = drive(self.options, Status::default())?;
        self.status.clone_from(host.session.status());
        Ok(())
    }

    /// Asks, and waits for a line.
    fn ask(&mut self, question: &str) -> Result<String, TaskError> {
        self.guide.say(question);
        loop {
            if ctrl_c::is_raised() {
                return Err(TaskError::Interrupted);
            }
            if let Some(answer) = self.guide.answer()? {
                return Ok(answer.trim().to_lowercase());
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Whether a permanent change may be made.
    fn may(&mut self, change: &str) -> Result<bool, TaskError> {
        if self.options.is_sure {
            self.guide.say(change);
            return Ok(true);
        }
        let answer = self.ask(&format!("{change}. Go on? [y/N]"))?;
        Ok(matches!(answer.as_str(), "y" | "yes"))
    }
}

fn drive<T: Task>(options: &SetupOptions, task: T) -> Result<TaskHost<T>, LinkError<TaskError>> {
    let link_options = LinkOptions {
        intent: task.intent(),
        ..LinkOptions::default()
    };
    let (host, result) = transport::drive(&options.link, link_options, TaskHost::new(task));
    result.map(|()| host)
}

/// Without answers, the guide is over.
fn is_over(error: &TaskError) -> bool {
    matches!(error, TaskError::Interrupted | TaskError::InputEnded)
}

/// Why there is no board, and what to do.
fn no_board(failure: &LinkError<TaskError>) -> Finding {
    let what = failure.to_string();
    let usb = match failure {
        LinkError::Link(error) => match error.downcast_ref() {
            Some(TransportError::Usb(error)) => Some(error),
            _ => None,
        },
        LinkError::Host(_) => None,
    };
    let remedy = match usb {
        Some(UsbError::NoBoard) => {
            "a cable that carries data, not power alone; a chip without firmware: see \"From\n\
             parcel to first motion\" in the book; to practise on a simulated board:\n\
             armbridge setup --help"
        }
        Some(UsbError::RomLoader) => {
            "servo supply off: dfu-util -a 0 -D FILE.dfu\n\
             then take the wire off B0, and press reset"
        }
        _ => "armbridge setup, once that is mended",
    };
    Finding::missing(what, remedy)
}
