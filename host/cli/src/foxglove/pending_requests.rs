//! Viewers' requests, until the board's messages show their result.
//!
//! A request succeeds when the board reports its effect: settings when they are in force as
//! requested, a stop when a fault is latched. It fails when the board refuses it, or shows
//! no effect within two seconds.

use std::time::{Duration, Instant};

use armbridge_client::refusal_text;
use armbridge_client::session::Request;
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Command, Mode, Settings};
use armbridge_shared::link::motion::Motion;
use foxglove::websocket::service::Responder;
use foxglove::websocket::{GetParametersResponder, Parameter, SetParametersResponder};

use super::board::{Board, CommandKind};
use super::values;

/// How long the board may take to show the effect of a request.
const TIMEOUT: Duration = Duration::from_secs(2);

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

    fn command_kind(self) -> Option<CommandKind> {
        match self {
            Self::Stop => None,
            Self::Disarm => Some(CommandKind::Disarm),
            Self::ClearFault => Some(CommandKind::Clear),
            Self::Arm | Self::Hold | Self::Upright => Some(CommandKind::Drive),
        }
    }
}

/// A request of a viewer, and where its response goes.
#[derive(Debug)]
pub enum ViewerRequest {
    /// Read parameters.
    Get(Vec<String>, GetParametersResponder),
    /// Change parameters.
    Set(Vec<Parameter>, SetParametersResponder),
    /// Call a service.
    Call(Service, Responder),
}

/// Result of taking or settling requests: for the link, and for all viewers.
#[derive(Debug, Default)]
pub struct Outcome {
    /// Requests for the board.
    pub requests: Vec<Request>,
    /// Errors, shown to all viewers.
    pub errors: Vec<String>,
}

#[derive(Debug)]
struct Pending {
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
        responder: SetParametersResponder,
    },
    Call {
        service: Service,
        responder: Responder,
    },
}

/// Requests without a response yet.
#[derive(Debug, Default)]
pub struct PendingRequests {
    pending: Vec<Pending>,
}

impl PendingRequests {
    /// Takes a request.
    pub fn take(&mut self, request: ViewerRequest, board: &Board) -> Outcome {
        let mut outcome = Outcome::default();
        match request {
            ViewerRequest::Get(names, responder) => {
                let all = board.status.settings.as_ref();
                responder.respond(all.map_or_else(Vec::new, |all| values::parameters(all, &names)));
            }
            ViewerRequest::Set(wanted, responder) => {
                self.change(&wanted, responder, board, &mut outcome);
            }
            ViewerRequest::Call(service, responder) => {
                outcome.requests = service.requests(board);
                self.wait(board, PendingKind::Call { service, responder });
            }
        }
        outcome
    }

    fn change(
        &mut self,
        requested: &[Parameter],
        responder: SetParametersResponder,
        board: &Board,
        outcome: &mut Outcome,
    ) {
        let names: Vec<_> = requested
            .iter()
            .map(|parameter| parameter.name.clone())
            .collect();
        let Some(settings) = board.status.settings else {
            let error = "parameters cannot be set before the board has reported its own";
            outcome.errors.push(error.into());
            responder.respond(vec![]);
            return;
        };
        let wanted = match values::changed(&settings, requested) {
            Ok(wanted) => wanted,
            Err(error) => {
                outcome.errors.push(error.to_string());
                responder.respond(values::parameters(&settings, &names));
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
            responder,
        };
        self.wait(board, kind);
    }

    fn wait(&mut self, board: &Board, kind: PendingKind) {
        self.pending.push(Pending {
            since: Instant::now(),
            refusals: board.refusals,
            kind,
        });
    }

    /// Responds to requests whose result is known, or that have timed out.
    pub fn settle(&mut self, board: &Board) -> Outcome {
        let mut outcome = Outcome::default();
        for pending in std::mem::take(&mut self.pending) {
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
            match pending.kind {
                PendingKind::Change {
                    wanted,
                    names,
                    responder,
                } => {
                    let is_so = board.status.settings == Some(*wanted);
                    let error = error(Some(CommandKind::Change)).filter(|_| !is_so);
                    if is_so || error.is_some() {
                        let all = board.status.settings.as_ref();
                        let values =
                            all.map_or_else(Vec::new, |all| values::parameters(all, &names));
                        responder.respond(values);
                        outcome.errors.extend(error);
                        continue;
                    }
                    let kind = PendingKind::Change {
                        wanted,
                        names,
                        responder,
                    };
                    self.pending.push(Pending { kind, ..pending });
                }
                PendingKind::Call { service, responder } => {
                    let mode = board.status.mode();
                    if mode.is_some_and(|mode| service.is_done(mode)) {
                        responder.respond_ok(br#"{"success":true,"message":""}"#);
                    } else if let Some(error) = error(service.command_kind()) {
                        responder.respond_err(error);
                    } else {
                        let kind = PendingKind::Call { service, responder };
                        self.pending.push(Pending { kind, ..pending });
                    }
                }
            }
        }
        outcome
    }
}
