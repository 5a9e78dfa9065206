//! The servos' step: both found by the board, or the bus searched for the reason.
//!
//! A servo comes with id 1, so that two new ones answer as one. The board's transparent port
//! lends the bus for a search of every id; [`advice`] decides what follows from its report.

use std::time::Duration;

use armbridge_board::bridge::SERVO_IDS;
use armbridge_board::bridge::limits::CLAIM_US;
use armbridge_client::servo_bus::scan::{Area, Report, scan};
use armbridge_client::servo_bus::{BusMaster, Diagnosis, Port, Servo};
use armbridge_client::status::Obstacle;
use armbridge_client::transport::LinkUri;
use armbridge_link::message::Mode;
use armbridge_servo::JOINTS;

use super::{Error, Setup};
use crate::finding::Finding;

/// Ids of the servos, joint by joint.
const IDS: [u8; JOINTS] = [SERVO_IDS[0].get(), SERVO_IDS[1].get()];
/// Rates of the search.
const BAUDS: [u32; 4] = [1_000_000, 57_600, 115_200, 500_000];
/// Ids of the search: new servos have 1, and those of other arms a low one.
const ID_MAX: u8 = 32;
/// Time from a command of the control link until the transparent port has the bus: the board
/// keeps it back for [`CLAIM_US`], and answers what was asked meanwhile too late.
const CLAIM: Duration = Duration::from_micros(CLAIM_US);
/// Replies by whose time-out that time may be longer on a slow, simulated board.
const CLAIM_REPLIES: u32 = 50;
/// The board finds its servos within this number of looks, of more than a second each.
const LOOKS: usize = 2;

/// Next step after a search.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Advice {
    /// All ids are there.
    Ready,
    /// This servo gets the id that is missing.
    Assign {
        /// Present id.
        id: u8,
        /// New id.
        new: u8,
    },
    /// Which joint this servo moves is to be asked.
    Ask {
        /// Present id.
        id: u8,
    },
    /// A person must do something.
    Stop(Finding),
}

/// Decides, for an arm of this many joints.
pub fn advice(report: &Report, joints: usize) -> Advice {
    let stop = |what: String, remedy: &str| Advice::Stop(Finding::missing(what, remedy));
    if let Some(error) = report.troubles.first() {
        return stop(
            format!("id {}: {}", error.id, error.diagnosis),
            "if both servos have one id, unplug that of joint 1 and run armbridge setup: it gives\n\
             the other one its id; otherwise check wiring and supply",
        );
    }
    if report.is_mixed() {
        return stop(
            "one servo is stock, the other Morpheus: they disturb each other".into(),
            "give both the same firmware",
        );
    }
    let ids: Vec<u8> = report.found.iter().map(|found| found.id).collect();
    if joints == 1 && !ids.is_empty() {
        let [new, ..] = IDS;
        return match ids.as_slice() {
            ids if ids.contains(&new) => Advice::Ready,
            [id] => Advice::Assign { id: *id, new },
            _ => stop(
                format!("{} servos answer, with ids {ids:?}", ids.len()),
                "leave the one of the arm on the bus",
            ),
        };
    }
    let strangers: Vec<u8> = (ids.iter().copied())
        .filter(|id| !IDS.contains(id))
        .collect();
    match (ids.as_slice(), strangers.as_slice()) {
        ([], _) => stop(
            format!("no servo answers: {}", Diagnosis::silence(report.echoes)),
            "switch the servos' supply on; check its fuse, the relay's contact and the cable",
        ),
        ([first, second], _) if first == second => stop(
            format!("two servos have id {first}"),
            "unplug that of joint 1, and run armbridge setup",
        ),
        ([_, _], []) => match report.found.as_slice() {
            [one, other] if one.baud != other.baud => stop(
                "the servos run at two rates".into(),
                "armbridge servo ID set-baud 1000000 --baud RATE --port serial:",
            ),
            _ => Advice::Ready,
        },
        ([id], _) | ([_, _], [id, _]) => Advice::Ask { id: *id },
        ([one, other], [id]) => {
            let kept = if one == id { other } else { one };
            let new = IDS.into_iter().find(|id| id != kept);
            new.map_or(Advice::Ready, |new| Advice::Assign { id: *id, new })
        }
        _ => stop(
            format!("{} servos answer, with ids {ids:?}", ids.len()),
            "leave the two of the arm on the bus",
        ),
    }
}

impl Setup<'_> {
    pub(super) fn servos(&mut self) -> Result<Finding, Error> {
        if let Some(found) = self.found() {
            return Ok(found);
        }
        // Each joint's id may change once.
        for _ in 0..=JOINTS {
            for _ in 0..LOOKS {
                self.look()?;
                if let Some(found) = self.found() {
                    return Ok(found);
                }
            }
            let Some(port) = self.port() else {
                return Ok(Finding::missing(
                    self.obstacle(),
                    "to search their bus, name it: --port URI",
                ));
            };
            if let Some(stop) = self.search(&port)? {
                return Ok(stop);
            }
        }
        Ok(Finding::missing(
            "the servos answer, and the board does not find them",
            "armbridge status",
        ))
    }

    /// The finding, if the board has found its servos, or knows why it cannot.
    fn found(&mut self) -> Option<Finding> {
        if let Some(Obstacle::Mixed(..)) = self.status.obstacle {
            return Some(Finding::missing(
                self.obstacle(),
                "give both servos the same firmware",
            ));
        }
        let is_idle = self.status.mode() == Some(Mode::Idle);
        let servos = self.status.servos.filter(|_| is_idle)?;
        self.needs_wheel_mode = !servos.is_ready;
        let (firmware, baud) = (servos.firmware, servos.baud);
        let ids = IDS.iter().take(self.status.joints()).map(u8::to_string);
        let ids = match ids.collect::<Vec<_>>() {
            one if one.len() == 1 => format!("id {}", one[0]),
            more => format!("ids {}", more.join(" and ")),
        };
        Some(Finding::Ok(format!(
            "{ids}, firmware {firmware}, {baud} baud"
        )))
    }

    fn obstacle(&self) -> String {
        let obstacle = self.status.obstacle.map(|obstacle| obstacle.to_string());
        obstacle.unwrap_or_else(|| "the board does not find its servos".into())
    }

    fn port(&self) -> Option<Port> {
        let is_usb = matches!(self.options.link, LinkUri::Usb(_) | LinkUri::Serial(_));
        self.options.port.clone().or(is_usb.then_some(Port::Board))
    }

    /// Searches the bus, and changes an id if that helps. What a person must do, if anything.
    fn search(&mut self, port: &Port) -> Result<Option<Finding>, Error> {
        self.guide
            .say("The board does not find its servos: their bus is searched.");
        std::thread::sleep(CLAIM + CLAIM_REPLIES * self.options.patience);
        let line = match port.open(BAUDS[0]) {
            Ok(line) => line,
            Err(error) => {
                let name = "if that does not help, name the port: --port /dev/ttyACM0 or COM3";
                return Ok(Some(Finding::missing(error.to_string(), name)));
            }
        };
        let mut bus = BusMaster::new(line, self.options.patience)?;
        let area = Area {
            ids: 0..=ID_MAX,
            bauds: BAUDS.to_vec(),
        };
        let report = scan(&mut bus, &area, |_| {})?;
        let (id, new) = match advice(&report, self.status.joints()) {
            Advice::Stop(finding) => return Ok(Some(finding)),
            Advice::Ready => return Ok(None),
            Advice::Assign { id, new } => (id, new),
            Advice::Ask { id } => {
                let answer = self.ask(&format!(
                    "A servo answers with id {id}. If both are plugged in and new, they have one \
                     id:\nunplug that of joint 1. Joint that this servo moves [1/2]"
                ))?;
                match answer.parse() {
                    Ok(new) if new == id => return Ok(Some(other_one(id))),
                    Ok(new) if IDS.contains(&new) => (id, new),
                    _ => return Err(format!("expected joint 1 or 2, not {answer:?}").into()),
                }
            }
        };
        if !self.may(&format!("Servo {id} gets id {new}, and keeps it"))? {
            return Ok(Some(Finding::missing(
                "declined: nothing was changed",
                "armbridge setup",
            )));
        }
        if let Some(found) = report.found.iter().find(|found| found.id == id)
            && let Some(baud) = found.baud
        {
            bus.set_baud(baud)?;
        }
        Servo::find(&mut bus, id)?.set_id(new)?;
        self.guide
            .say(&format!("Servo {id} has id {new} now, read back."));
        let is_other_missing = report.found.len() < self.status.joints();
        Ok(is_other_missing.then(|| other_one(new)))
    }
}

/// One has its id.
fn other_one(id: u8) -> Finding {
    let other = IDS.into_iter().find(|other| *other != id).unwrap_or(id);
    Finding::missing(
        format!("servo {id} answers; servo {other} does not"),
        "plug the other servo in as well, and run armbridge setup",
    )
}

#[cfg(test)]
mod tests {
    use armbridge_client::servo_bus::scan::{Details, Found, ScanError};
    use armbridge_servo::{Alarms, Firmware};

    use super::*;

    /// A report of servos with these ids, all Morpheus, at 1 Mbaud.
    fn report(ids: &[u8]) -> Report {
        let found = ids.iter().map(|id| Found {
            baud: Some(1_000_000),
            id: *id,
            firmware: Firmware::Morpheus,
            alarms: Alarms::default(),
            details: Details::default(),
        });
        Report {
            found: found.collect(),
            ..Report::default()
        }
    }

    #[track_caller]
    fn assert_stops(report: &Report, what: &str, remedy: &str) {
        let Advice::Stop(finding) = advice(report, 2) else {
            panic!("{report:?}");
        };
        let (state, text, todo) = finding.parts();
        assert_eq!(state, "missing");
        assert!(text.contains(what), "{text}");
        assert!(todo.is_some_and(|todo| todo.contains(remedy)), "{todo:?}");
    }

    #[test]
    fn an_id_is_changed_only_where_it_is_clear_which_joint_it_moves() {
        assert_eq!(advice(&report(&[1, 2]), 2), Advice::Ready);
        for (ids, id, new) in [([1, 7], 7, 2), ([2, 7], 7, 1), ([0, 2], 0, 1)] {
            assert_eq!(advice(&report(&ids), 2), Advice::Assign { id, new });
        }
        for (ids, id) in [(&[1][..], 1), (&[9], 9), (&[5, 9], 5)] {
            assert_eq!(advice(&report(ids), 2), Advice::Ask { id });
        }
    }

    #[test]
    fn an_arm_of_one_joint_has_one_servo() {
        assert_eq!(advice(&report(&[1]), 1), Advice::Ready);
        assert_eq!(advice(&report(&[7]), 1), Advice::Assign { id: 7, new: 1 });
        assert_eq!(advice(&report(&[1, 2]), 1), Advice::Ready);
        assert!(matches!(advice(&report(&[5, 9]), 1), Advice::Stop(_)));
    }

    #[test]
    fn each_trouble_of_the_bus_has_its_remedy() {
        assert_stops(
            &report(&[]),
            "no servo answers",
            "switch the servos' supply on",
        );
        assert_stops(&report(&[1, 1]), "two servos have id 1", "unplug");
        assert_stops(&report(&[1, 2, 3]), "3 servos answer", "leave the two");
        let mut mixed = report(&[1, 2]);
        mixed.found[1].firmware = Firmware::Stock;
        assert_stops(&mixed, "one servo is stock", "the same firmware");
        let mut rates = report(&[1, 2]);
        rates.found[1].baud = Some(57_600);
        assert_stops(&rates, "two rates", "set-baud");
        let mut collision = report(&[]);
        collision.troubles.push(ScanError {
            baud: None,
            id: 1,
            firmware: Firmware::Stock,
            diagnosis: "an answer with a wrong checksum was received".into(),
        });
        assert_stops(
            &collision,
            "id 1: an answer with a wrong",
            "unplug that of joint 1",
        );
    }
}
