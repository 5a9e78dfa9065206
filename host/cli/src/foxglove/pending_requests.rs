//! Viewers' requests, until the board's messages show their result.
//!
//! A request succeeds when the board reports its effect: settings when they are in force as
//! requested, a stop when a fault is latched. It fails when the board refuses it, or shows
//! no effect within two seconds.

use std::time::{Duration, Instant};

use armbridge_client::refusal_text;
use armbridge_client::session::Request;
use armbridge_link::message::{Command, Drive, Mode, Settings};
use armbridge_link::motion::Motion;
use armbridge_servo::JOINTS;
use foxglove::websocket::Parameter;

use super::board::{Board, CommandKind};
use super::values;
use super::viewer::ViewerId;

/// Timeout for the effect of a request on the board.
const TIMEOUT: Duration = Duration::from_secs(2);
/// Requests of a viewer that wait for the board.
const PENDING_MAX: usize = 32;

/// Services that a viewer can call.
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
    /// Arm if need be, and make the arm weightless, for a hand to lead.
    Float,
    /// Move the arm to its pose, lower it there, and disarm.
    Park,
}

impl Service {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Stop,
        Self::Disarm,
        Self::ClearFault,
        Self::Arm,
        Self::Hold,
        Self::Upright,
        Self::Float,
        Self::Park,
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
            Self::Float => "/float",
            Self::Park => "/park",
        }
    }

    /// Whether any viewer may call it: it switches motors off, at once or when the arm lies.
    pub fn is_free(self) -> bool {
        matches!(self, Self::Stop | Self::Disarm | Self::Park)
    }

    /// Whether motors may come on by it.
    pub fn energises(self) -> bool {
        match self {
            Self::Stop | Self::Disarm | Self::ClearFault | Self::Park => false,
            Self::Arm | Self::Hold | Self::Upright | Self::Float => true,
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
                drive(Command::Regulate(record.output.angle_rad))
            }),
            Self::Upright => drive(Command::Follow(Motion::MinimumJerk {
                to_rad: [0.0; JOINTS],
                duration_s: None,
            })),
            Self::Float => drive(Command::Float),
            Self::Park => vec![Request::Command(Command::Park)],
        }
    }

    /// Whether the board's mode shows that it is done.
    fn is_done(self, mode: Mode) -> bool {
        match self {
            Self::Stop => matches!(mode, Mode::Fault(_)),
            Self::Disarm => !mode.is_armed(),
            Self::Park => !mode.is_armed() || mode.drive() == Some(Drive::Park),
            Self::ClearFault => !matches!(mode, Mode::Fault(_)),
            Self::Arm => mode.is_armed(),
            Self::Hold | Self::Upright => mode.drive().is_some(),
            Self::Float => mode.drive() == Some(Drive::Float),
        }
    }

    fn command_kind(self) -> Option<CommandKind> {
        match self {
            Self::Stop => None,
            Self::Disarm | Self::Park => Some(CommandKind::Disarm),
            Self::ClearFault => Some(CommandKind::Clear),
            Self::Arm | Self::Hold | Self::Upright | Self::Float => Some(CommandKind::Drive),
        }
    }
}

/// A call of a service, as its viewer numbers it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Call {
    /// The service.
    pub service_id: u32,
    /// The call.
    pub call_id: u32,
}

/// A request of a viewer, with its number if the viewer wants an answer.
#[derive(Debug)]
pub enum ViewerRequest {
    /// Read parameters.
    Get(Vec<String>, Option<String>),
    /// Change parameters.
    Set(Vec<Parameter>, Option<String>),
    /// Call a service.
    Call(Service, Call),
}

/// A message to one viewer.
#[derive(Debug)]
pub enum Reply {
    /// Values in force, in answer to the request of this number.
    Parameters(Vec<Parameter>, Option<String>),
    /// The service has done it.
    Done(Call),
    /// The service has not done it.
    Failed(Call, String),
    /// An error.
    Error(String),
}

/// Result of taking or settling requests: for the link, and for viewers.
#[derive(Debug, Default)]
pub struct Outcome {
    /// Requests for the board.
    pub requests: Vec<Request>,
    /// Replies to viewers.
    pub replies: Vec<(ViewerId, Reply)>,
}

#[derive(Debug)]
struct Pending {
    from: ViewerId,
    since: Instant,
    /// The board's refusals before it.
    refusals: u64,
    kind: PendingKind,
}

#[derive(Debug)]
enum PendingKind {
    Change {
        wanted: Box<Settings>,
        names: Vec<String>,
        id: Option<String>,
    },
    Call {
        service: Service,
        call: Call,
    },
}

/// Requests without a response yet.
#[derive(Debug, Default)]
pub struct PendingRequests {
    pending: Vec<Pending>,
}

impl PendingRequests {
    /// Takes a request of this viewer.
    pub fn take(&mut self, from: ViewerId, request: ViewerRequest, board: &Board) -> Outcome {
        let mut outcome = Outcome::default();
        let settings = board.status.settings.as_ref();
        let same = self.pending.iter().filter(|pending| pending.from == from);
        let is_too_many = same.count() >= PENDING_MAX;
        match request {
            ViewerRequest::Get(names, id) => {
                let values =
                    settings.map_or_else(Vec::new, |settings| values::parameters(settings, &names));
                outcome.replies.push((from, Reply::Parameters(values, id)));
            }
            ViewerRequest::Set(..) if is_too_many => {
                let error = Reply::Error("too many requests wait for the board".into());
                outcome.replies.push((from, error));
            }
            ViewerRequest::Set(wanted, id) => {
                self.change(from, &wanted, id, board, &mut outcome);
            }
            ViewerRequest::Call(service, call) => {
                outcome.requests = service.requests(board);
                if is_too_many {
                    let error = "too many requests wait for the board".into();
                    outcome.replies.push((from, Reply::Failed(call, error)));
                } else {
                    self.wait(from, board, PendingKind::Call { service, call });
                }
            }
        }
        outcome
    }

    fn change(
        &mut self,
        from: ViewerId,
        requested: &[Parameter],
        id: Option<String>,
        board: &Board,
        outcome: &mut Outcome,
    ) {
        let names: Vec<_> = requested
            .iter()
            .map(|parameter| parameter.name.clone())
            .collect();
        let mut fail = |error: String, values| {
            outcome.replies.push((from, Reply::Error(error)));
            outcome
                .replies
                .push((from, Reply::Parameters(values, id.clone())));
        };
        let Some(settings) = board.status.settings else {
            let error = "parameters cannot be set before the board has reported its own";
            fail(error.into(), vec![]);
            return;
        };
        let wanted = match values::changed(&settings, requested) {
            Ok(wanted) => wanted,
            Err(error) => {
                fail(error.to_string(), values::parameters(&settings, &names));
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
        let kind = PendingKind::Change {
            wanted: Box::new(wanted),
            names,
            id,
        };
        self.wait(from, board, kind);
    }

    fn wait(&mut self, from: ViewerId, board: &Board, kind: PendingKind) {
        self.pending.push(Pending {
            from,
            since: Instant::now(),
            refusals: board.refusals,
            kind,
        });
    }

    /// Replies to requests whose result is known, or that have timed out.
    pub fn settle(&mut self, board: &Board) -> Outcome {
        let mut outcome = Outcome::default();
        let settings = board.status.settings.as_ref();
        self.pending.retain_mut(|pending| {
            let is_late = pending.since.elapsed() > TIMEOUT;
            let refused = board.refused.filter(|_| board.refusals > pending.refusals);
            let error = |kind: Option<CommandKind>| match refused {
                Some((refused, refusal)) if Some(refused) == kind => Some(format!(
                    "the board refused: {}",
                    refusal_text::in_words(refusal)
                )),
                Some(_) | None => {
                    is_late.then(|| "no result from the board within 2 s: is it connected?".into())
                }
            };
            let from = pending.from;
            match &mut pending.kind {
                PendingKind::Change { wanted, names, id } => {
                    let is_so = settings == Some(&**wanted);
                    let error = error(Some(CommandKind::Change)).filter(|_| !is_so);
                    if !is_so && error.is_none() {
                        return true;
                    }
                    let values = settings
                        .map_or_else(Vec::new, |settings| values::parameters(settings, names));
                    let values = Reply::Parameters(values, id.take());
                    outcome.replies.push((from, values));
                    outcome
                        .replies
                        .extend(error.map(|error| (from, Reply::Error(error))));
                }
                PendingKind::Call { service, call } => {
                    let mode = board.status.mode();
                    if mode.is_some_and(|mode| service.is_done(mode)) {
                        outcome.replies.push((from, Reply::Done(*call)));
                    } else if let Some(error) = error(service.command_kind()) {
                        outcome.replies.push((from, Reply::Failed(*call, error)));
                    } else {
                        return true;
                    }
                }
            }
            false
        });
        outcome
    }
}
