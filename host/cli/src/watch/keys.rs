//! Keys: a small state machine between the person and the board.
//!
//! Stop, disarm and clear act at once. Keys that let motors come on ask first, and work
//! only while frames arrive. Setpoints move in small steps, and stay clear of the angle
//! limit, where the arm would be braked.

use armbridge_client::session::Request;
use armbridge_link::limits::hard;
use armbridge_link::message::{Command, Drive, Mode};
use armbridge_link::motion::Motion;
use armbridge_link::server::LinkRole;
use armbridge_servo::JOINTS;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::hand::Hand;
use super::model::{Line, Model};

/// A step of the setpoint in rad: a tenth of the torque that a joint has, at the
/// default gains less than a thirtieth.
const STEP_RAD: f32 = 0.02;
/// Distance that a setpoint keeps from the angle limit: the arm is braked from 0.1 rad
/// before it.
const MARGIN_RAD: f32 = 0.2;
/// For so long steps are counted from the setpoint asked for, which the board may not
/// have yet; later, from the board's.
const FRESH_NS: u64 = 500_000_000;

/// Effect of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// A request to the board.
    Request(Request),
    /// A hand on the simulated arm.
    Hand(Hand),
    /// Write the motion of the last float.
    Teach,
    /// Replay the motion of the last float.
    Play,
    /// Disarm, and end.
    Quit,
}

/// A question to the person.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Whether to arm.
    Arm,
    /// Whether to set stock servos to wheel mode.
    Prepare,
    /// Where to regulate; the board is armed.
    Regulate,
    /// Whether to arm and regulate, and where.
    ArmAndRegulate,
    /// Whether to float; the board is armed.
    Float,
    /// Whether to replay the motion of the last float; the board is armed.
    Play,
}

impl Question {
    /// In words, with the keys that answer it.
    pub fn text(self) -> &'static str {
        match self {
            Self::Arm => "Arm? The motors may then be driven; keep clear.   y yes   n no",
            Self::Prepare => {
                "Set the servos to wheel mode (X: PWM mode), which they keep?   y yes   n no"
            }
            Self::Regulate => "The motors come on.   h hold here   u move upright   n no",
            Self::ArmAndRegulate => {
                "Arm, and the motors come on?   h hold here   u move upright   n no"
            }
            Self::Float => "The motors carry the arm, for a hand to lead.   y yes   n no",
            Self::Play => "The arm moves as it was led last; keep clear.   y yes   n no",
        }
    }
}

/// The person's side of the dashboard.
#[derive(Clone, Debug, Default)]
pub struct Keys {
    /// The open question.
    pub question: Option<Question>,
    /// Whether the help is shown.
    pub is_helping: bool,
    /// Why a key did nothing, until the next.
    pub note: Option<&'static str>,
    /// Result of a key, until the next.
    pub result: Option<String>,
    /// Whether the arm is a simulated one, which keys can push and lift.
    pub is_touchable: bool,
    /// Commander of a link that is served to several programs.
    pub role: Option<LinkRole>,
    /// The setpoint asked for last, and when.
    setpoint: Option<([f32; JOINTS], u64)>,
}

impl Keys {
    /// Nothing pressed yet.
    pub fn new(is_touchable: bool) -> Self {
        Self {
            is_touchable,
            ..Self::default()
        }
    }

    /// A key was pressed.
    pub fn press(&mut self, key: KeyEvent, model: &Model) -> Vec<Action> {
        self.note = None;
        self.result = None;
        if key.modifiers.contains(KeyModifiers::CONTROL) {
            return if key.code == KeyCode::Char('c') {
                vec![Action::Quit]
            } else {
                vec![]
            };
        }
        // These are never waited for, whatever is being asked.
        if let KeyCode::Char(' ' | 's' | 'S') = key.code {
            self.question = None;
            return vec![Action::Request(Request::Stop)];
        }
        if let Some(question) = self.question.take() {
            return self.answer(question, key.code, model);
        }
        if std::mem::take(&mut self.is_helping) {
            return vec![];
        }
        let is_command = matches!(
            key.code,
            KeyCode::Char('a' | 'c' | 'd' | 'f' | 'm' | 'p' | 'r')
                | KeyCode::Left
                | KeyCode::Right
                | KeyCode::Down
                | KeyCode::Up
        );
        if is_command && self.is_observer() {
            self.note = Some("this program observes, and does not command; space still stops");
            return vec![];
        }
        let is_of_joint_2 = matches!(key.code, KeyCode::Char('2') | KeyCode::Up | KeyCode::Down);
        if is_of_joint_2 && model.board.joints() < JOINTS {
            self.note = Some("this arm has one joint");
            return vec![];
        }
        let act = match key.code {
            KeyCode::Char('q') => Some(Action::Quit),
            KeyCode::Char('?') => {
                self.is_helping = true;
                None
            }
            KeyCode::Char('d') => Some(Action::Request(Request::Command(Command::Idle))),
            KeyCode::Char('t') => Some(Action::Teach),
            KeyCode::Char('p') => self.park(model),
            KeyCode::Char('c') => self.clear(model),
            KeyCode::Char('a') => self.ask(arming(model)),
            KeyCode::Char('r') => self.ask(regulating(model)),
            KeyCode::Char('f') => self.ask(floating(model)),
            KeyCode::Char('m') => self.ask(playing(model)),
            KeyCode::Char('1') => self.handle(Hand::Push(0)),
            KeyCode::Char('2') => self.handle(Hand::Push(1)),
            KeyCode::Char('l') => self.lift(model),
            KeyCode::Left => self.step(model, 0, -STEP_RAD),
            KeyCode::Right => self.step(model, 0, STEP_RAD),
            KeyCode::Down => self.step(model, 1, -STEP_RAD),
            KeyCode::Up => self.step(model, 1, STEP_RAD),
            _ => None,
        };
        act.into_iter().collect()
    }

    /// Whether this program does not command.
    pub fn is_observer(&self) -> bool {
        self.role.is_some_and(|role| !role.is_commander)
    }

    fn ask(&mut self, question: Result<Question, &'static str>) -> Option<Action> {
        match question {
            Ok(question) => self.question = Some(question),
            Err(note) => self.note = Some(note),
        }
        None
    }

    fn answer(&mut self, question: Question, key: KeyCode, model: &Model) -> Vec<Action> {
        let command = |command| Some(Action::Request(Request::Command(command)));
        let drive = match key {
            KeyCode::Char('h' | 'H') => model
                .board
                .record
                .and_then(|record| command(Command::Regulate(record.output.angle_rad))),
            KeyCode::Char('u' | 'U') => command(Command::Follow(Motion::MinimumJerk {
                to_rad: [0.0; JOINTS],
                duration_s: None,
            })),
            _ => None,
        };
        let is_yes = matches!(key, KeyCode::Char('y' | 'Y'));
        // The board may not be as it was when this was asked.
        let (still, acts) = match question {
            Question::Arm => (
                arming(model),
                vec![is_yes.then_some(Action::Request(Request::Arm))],
            ),
            Question::Prepare => {
                let prepare = is_yes.then(|| command(Command::Prepare)).flatten();
                (arming(model), vec![prepare])
            }
            Question::Float => {
                let float = is_yes.then(|| command(Command::Float)).flatten();
                (floating(model), vec![float])
            }
            Question::Play => (playing(model), vec![is_yes.then_some(Action::Play)]),
            Question::Regulate => (regulating(model), vec![drive]),
            Question::ArmAndRegulate => (
                regulating(model),
                vec![Some(Action::Request(Request::Arm)), drive],
            ),
        };
        match acts.into_iter().collect::<Option<Vec<_>>>() {
            Some(acts) if still == Ok(question) => acts,
            Some(_) => {
                self.note = Some("not done: the board is not as it was when you were asked");
                vec![]
            }
            None => {
                self.note = Some("not done");
                vec![]
            }
        }
    }

    fn park(&mut self, model: &Model) -> Option<Action> {
        if model.board.has_pose() {
            return Some(Action::Request(Request::Command(Command::Park)));
        }
        self.note = Some("no pose to park in: set park.kind and park.angle_rad; d disarms");
        None
    }

    fn clear(&mut self, model: &Model) -> Option<Action> {
        if let Some(Mode::Fault(_)) = model.board.mode() {
            return Some(Action::Request(Request::Command(Command::ClearFault)));
        }
        self.note = Some("there is no fault to clear");
        None
    }

    fn handle(&mut self, hand: Hand) -> Option<Action> {
        if self.is_touchable {
            return Some(Action::Hand(hand));
        }
        self.note = Some("only a simulated arm can be touched: sim:, or one served on tcp://");
        None
    }

    fn lift(&mut self, model: &Model) -> Option<Action> {
        if model.board.mode().is_some_and(Mode::is_armed) {
            self.note = Some("the motors drive the arm: press d first");
            return None;
        }
        self.handle(Hand::Lift)
    }

    fn step(&mut self, model: &Model, joint: usize, by_rad: f32) -> Option<Action> {
        let record = model
            .board
            .record
            .as_ref()
            .filter(|_| model.line() == Line::Up)?;
        let (Mode::Running(drive) | Mode::Degraded(drive)) = record.mode else {
            self.note = Some("the setpoint moves while the arm regulates: press r first");
            return None;
        };
        let (Drive::Regulate | Drive::Track) = drive else {
            self.note = Some("the setpoint moves while the arm regulates: press r first");
            return None;
        };
        let now_ns = model.now_ns();
        let fresh = self
            .setpoint
            .filter(|(_, at_ns)| now_ns.saturating_sub(*at_ns) < FRESH_NS);
        let mut setpoint = fresh.map_or(record.output.reference_rad, |(setpoint, _)| setpoint);
        let limits = model
            .board
            .settings
            .map(|settings| settings.limits.angle_rad);
        let most = limits.unwrap_or([hard::ANGLE_RAD; JOINTS])[joint] - MARGIN_RAD;
        let wanted = setpoint[joint] + by_rad;
        // On from beyond, only back.
        if wanted.abs() > most && wanted.abs() > setpoint[joint].abs() {
            self.note = Some("no farther: the arm's angle limit is near");
            return None;
        }
        setpoint[joint] = wanted;
        self.setpoint = Some((setpoint, now_ns));
        Some(Action::Request(Request::Command(Command::Regulate(
            setpoint,
        ))))
    }
}

/// Whether the board can be armed, and what to ask.
fn arming(model: &Model) -> Result<Question, &'static str> {
    match (model.line(), model.board.mode()) {
        (Line::Opening | Line::Parted(_), _) | (_, None) => Err("there is no board on the link"),
        (Line::Quiet(_), _) => Err("the board is silent"),
        (Line::Up, Some(Mode::Boot)) => Err("the servos are not found yet"),
        (Line::Up, Some(Mode::MotorCheck | Mode::Armed | Mode::Running(_) | Mode::Degraded(_))) => {
            Err("it is armed already")
        }
        (Line::Up, Some(Mode::Passthrough)) => {
            Err("a program has the bus: press d to take it back first")
        }
        (Line::Up, Some(Mode::Fault(_))) => Err("a fault is latched: press c to clear it first"),
        (Line::Up, Some(Mode::Idle)) => match model.board.servos {
            Some(servos) if !servos.is_ready => Ok(Question::Prepare),
            Some(_) | None => Ok(Question::Arm),
        },
    }
}

/// Whether it can regulate, and what to ask.
fn regulating(model: &Model) -> Result<Question, &'static str> {
    match (model.line(), model.board.mode()) {
        (Line::Up, Some(mode)) if mode.is_armed() => Ok(Question::Regulate),
        _ => arming(model).map(|question| match question {
            Question::Arm
            | Question::Regulate
            | Question::ArmAndRegulate
            | Question::Float
            | Question::Play => Question::ArmAndRegulate,
            Question::Prepare => Question::Prepare,
        }),
    }
}

/// Whether it can float, and what to ask.
fn floating(model: &Model) -> Result<Question, &'static str> {
    match (model.line(), model.board.mode()) {
        (Line::Up, Some(mode)) if mode.is_armed() => Ok(Question::Float),
        _ => arming(model).and(Err("an arm floats once it is armed: press a first")),
    }
}

/// Whether the motion of the last float can be replayed, and what to ask.
fn playing(model: &Model) -> Result<Question, &'static str> {
    if model.lesson.motion().is_err() {
        return Err("no motion to replay: press f, and lead the arm");
    }
    floating(model).map(|_| Question::Play)
}
