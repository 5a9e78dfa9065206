//! What viewers wish, until the board has said what became of it.
//!
//! A viewer is answered when the board's own words show that it is so: settings when the
//! board tells them as they were wanted, a stop when a fault is latched. What the board
//! refuses, or does not answer within two seconds, is told as that.

use std::time::{Duration, Instant};

use armbridge_client::refusal_text;
use armbridge_client::session::Request;
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Command, Mode, Settings};
use armbridge_shared::link::motion::Motion;
use foxglove::websocket::service::Responder;
use foxglove::websocket::{GetParametersResponder, Parameter, SetParametersResponder};

use super::board::{Asked, Board};
use super::values;

/// How long the board may take.
const PATIENCE: Duration = Duration::from_secs(2);

/// What a viewer can call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Service {
    /// Emergency stop.
    Stop,
    /// Torque off.
    Disarm,
    /// Leave a fault.
    ClearFault,
    /// Be ready to move, with zero torque.
    Arm,
    /// Arm if need be, and hold the arm where it is.
    Hold,
    /// Arm if need be, and move upright.
    Upright,
}

impl Service {
    /// All of them; those from [`Service::Arm`] on let motors come on.
    pub const ALL: [Self; 6] = [
        Self::Stop,
        Self::Disarm,
        Self::ClearFault,
        Self::Arm,
        Self::Hold,
        Self::Upright,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stop => "/stop",
            Self::Disarm => "/disarm",
            Self::ClearFault => "/clear_fault",
            Self::Arm => "/arm",
            Self::Hold => "/hold",
            Self::Upright => "/upright",
        }
    }

    /// Whether motors may come on by it.
    pub fn energises(self) -> bool {
        match self {
            Self::Stop | Self::Disarm | Self::ClearFault => false,
            Self::Arm | Self::Hold | Self::Upright => true,
        }
    }

    fn requests(self, board: &Board) -> Vec<Request> {
        let drive = |command| {
            let arm = match board.status.mode() {
                Some(mode) if mode.is_armed() => None,
                Some(_) | None => Some(Request::Arm),
            };
            arm.into_iter().chain([Request::Command(command)]).collect()
        };
        match self {
            Self::Stop => vec![Request::Stop],
            Self::Disarm => vec![Request::Command(Command::Idle)],
            Self::ClearFault => vec![Request::Command(Command::ClearFault)],
            Self::Arm => vec![Request::Arm],
            Self::Hold => board.status.record.map_or_else(Vec::new, |record| {
                drive(Command::Regulate(record.angle_rad))
            }),
            Self::Upright => drive(Command::Follow(Motion::MinimumJerk {
                to_rad: [0.0; JOINTS],
                duration_s: None,
            })),
        }
    }

    /// Whether the board's mode shows that it is done.
    fn is_done(self, mode: Mode) -> bool {
        match self {
            Self::Stop => matches!(mode, Mode::Fault(_)),
            Self::Disarm => !mode.is_armed(),
            Self::ClearFault => !matches!(mode, Mode::Fault(_)),
            Self::Arm => mode.is_armed(),
            Self::Hold | Self::Upright => mode.drive().is_some(),
        }
    }

    fn asked(self) -> Option<Asked> {
        match self {
            Self::Stop => None,
            Self::Disarm => Some(Asked::Disarm),
            Self::ClearFault => Some(Asked::Clear),
            Self::Arm | Self::Hold | Self::Upright => Some(Asked::Drive),
        }
    }
}

/// What a viewer wishes.
#[derive(Debug)]
pub enum Wish {
    /// To know parameters.
    Get(Vec<String>, GetParametersResponder),
    /// To change parameters.
    Set(Vec<Parameter>, SetParametersResponder),
    /// To have something done.
    Call(Service, Responder),
}

/// What follows from wishes: for the link, and for all viewers.
#[derive(Debug, Default)]
pub struct Outcome {
    /// To be asked of the board.
    pub requests: Vec<Request>,
    /// To be told to everybody.
    pub complaints: Vec<String>,
}

#[derive(Debug)]
struct Waiting {
    since: Instant,
    /// Refusals before it.
    refusals: u64,
    what: What,
}

#[derive(Debug)]
enum What {
    Change {
        wanted: Box<Settings>,
        names: Vec<String>,
        responder: SetParametersResponder,
    },
    Call {
        service: Service,
        responder: Responder,
    },
}

/// All that is not answered yet.
#[derive(Debug, Default)]
pub struct PendingRequests {
    waiting: Vec<Waiting>,
}

impl PendingRequests {
    /// Takes a wish.
    pub fn take(&mut self, wish: Wish, board: &Board) -> Outcome {
        let mut outcome = Outcome::default();
        match wish {
            Wish::Get(names, responder) => {
                let all = board.status.settings.as_ref();
                responder.respond(all.map_or_else(Vec::new, |all| values::of(all, &names)));
            }
            Wish::Set(wanted, responder) => self.change(&wanted, responder, board, &mut outcome),
            Wish::Call(service, responder) => {
                outcome.requests = service.requests(board);
                self.wait(board, What::Call { service, responder });
            }
        }
        outcome
    }

    fn change(
        &mut self,
        asked: &[Parameter],
        responder: SetParametersResponder,
        board: &Board,
        outcome: &mut Outcome,
    ) {
        let names: Vec<_> = asked
            .iter()
            .map(|parameter| parameter.name.clone())
            .collect();
        let Some(settings) = board.status.settings else {
            let why = "parameters cannot be set before the board has told its own";
            outcome.complaints.push(why.into());
            responder.respond(vec![]);
            return;
        };
        let wanted = match values::changed(&settings, asked) {
            Ok(wanted) => wanted,
            Err(error) => {
                outcome.complaints.push(error.to_string());
                responder.respond(values::of(&settings, &names));
                return;
            }
        };
        // Each is one group for the board: all of it is taken, or nothing.
        if wanted.limits != settings.limits {
            let limit = Command::Limit(wanted.limits);
            outcome.requests.push(Request::Command(limit));
        }
        if wanted.setup != settings.setup {
            let configure = Command::Configure(wanted.setup);
            outcome.requests.push(Request::Command(configure));
        }
        let what = What::Change {
            wanted: Box::new(wanted),
            names,
            responder,
        };
        self.wait(board, what);
    }

    fn wait(&mut self, board: &Board, what: What) {
        self.waiting.push(Waiting {
            since: Instant::now(),
            refusals: board.refusals,
            what,
        });
    }

    /// Answers what has come about, or will not any more.
    pub fn settle(&mut self, board: &Board) -> Outcome {
        let mut outcome = Outcome::default();
        let waiting = std::mem::take(&mut self.waiting);
        for waiting in waiting {
            let is_late = waiting.since.elapsed() > PATIENCE;
            let refused = board.refused.filter(|_| board.refusals > waiting.refusals);
            let why = |asked: Option<Asked>| match refused {
                Some((what, refusal)) if Some(what) == asked => Some(format!(
                    "the board refused: {}",
                    refusal_text::in_words(refusal)
                )),
                Some(_) | None => {
                    is_late.then(|| "the board did not do so within 2 s: is it there?".into())
                }
            };
            match waiting.what {
                What::Change {
                    wanted,
                    names,
                    responder,
                } => {
                    let is_so = board.status.settings == Some(*wanted);
                    let why = why(Some(Asked::Change)).filter(|_| !is_so);
                    if is_so || why.is_some() {
                        let all = board.status.settings.as_ref();
                        let values = all.map_or_else(Vec::new, |all| values::of(all, &names));
                        responder.respond(values);
                        outcome.complaints.extend(why);
                        continue;
                    }
                    let what = What::Change {
                        wanted,
                        names,
                        responder,
                    };
                    self.waiting.push(Waiting { what, ..waiting });
                }
                What::Call { service, responder } => {
                    let mode = board.status.mode();
                    if mode.is_some_and(|mode| service.is_done(mode)) {
                        responder.respond_ok(br#"{"success":true,"message":""}"#);
                    } else if let Some(why) = why(service.asked()) {
                        responder.respond_err(why);
                    } else {
                        let what = What::Call { service, responder };
                        self.waiting.push(Waiting { what, ..waiting });
                    }
                }
            }
        }
        outcome
    }
}
