//! The board in [`Mode::Exact`](super::Mode::Exact): the whole board behind its link, with servos
//! and wire byte for byte, advanced tick by tick.
//!
//! The session is that of any host: hello, settings, arming with the board's own checks,
//! heartbeats. The motors are checked if the settings ask for it; afterwards the arm is brought
//! back by hand.

use armbridge_board::bridge::Channels;
use armbridge_client::error::SessionError;
use armbridge_client::params::settings_exchange::commands;
use armbridge_client::session::{ARM_TIMEOUT_US, Request, SERVO_TIMEOUT_US, Session};
use armbridge_client::{Host, refusal_text};
use armbridge_control::arm::State;
use armbridge_link::message::{Command, Mode, Record, Refusal, Settings};
use self_cell::{MutBorrow, self_cell};

use super::Observation;
use crate::Bench;
use crate::board::VirtualBoard;
use crate::cosim::{Cosim, CosimError};
use crate::plant::{Plant, PlantConfig};

/// Time between two attempts to arm, in µs: the encoders have to become known before.
const ARM_AGAIN_US: u64 = 10_000;
/// Duration of the return by hand, in µs, and of the rest after it.
const RETURN_US: u64 = 100_000;

/// Why the simulated board does not come up, or has gone.
#[derive(Debug, thiserror::Error)]
pub enum ExactError {
    /// It refuses its settings, or to be armed.
    #[error("the simulated board refuses: {}", refusal_text::in_words(*.0))]
    Refused(Refusal),
    /// Its session has ended.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// It does not come to the next mode.
    #[error(
        "the simulated board is in mode {mode:?}, and does not come to the next in {after_s} s"
    )]
    Stays {
        /// Its mode.
        mode: Option<Mode>,
        /// Time for which it was awaited.
        after_s: f64,
    },
}

/// Host of the board: a session without an end.
#[derive(Debug, Default)]
pub(super) struct SessionHost(pub(super) Session);

impl Host for SessionHost {
    type Error = SessionError;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], SessionError> {
        self.0.transmit(now_us)
    }

    fn receive(&mut self, now_us: u64, mut bytes: &[u8]) -> Result<(), SessionError> {
        while self.0.receive(now_us, &mut bytes)?.is_some() {}
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        self.0.wake_at_us()
    }

    fn is_done(&self) -> bool {
        false
    }
}

pub(super) type Simulation<'a> = Cosim<VirtualBoard<'a>, SessionHost>;

self_cell!(
    struct Cell {
        owner: MutBorrow<Channels>,
        #[not_covariant]
        dependent: Simulation,
    }
);

/// See the [module](self).
pub struct ExactBoard {
    cell: Cell,
}

impl std::fmt::Debug for ExactBoard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ExactBoard").finish_non_exhaustive()
    }
}

impl ExactBoard {
    /// A board that has armed, and the arm at rest. Also returns its last tick.
    ///
    /// # Errors
    /// If it refuses its settings, or cannot be armed.
    pub fn new(
        settings: &Settings,
        plant: PlantConfig,
        seed: u64,
    ) -> Result<(Self, Observation), ExactError> {
        let channels = MutBorrow::new(Channels::new());
        let cell = Cell::try_new(channels, |channels| {
            let board = VirtualBoard::new(channels.borrow_mut().split());
            let bench = Bench::new(Plant::new(plant, seed));
            let board = board.map_err(ExactError::Refused)?;
            Ok::<_, ExactError>(Cosim::new(board, bench, SessionHost::default()))
        })?;
        let mut board = Self { cell };
        let record = board.with(|cosim| {
            for command in commands(&Settings::default(), settings, false) {
                request(cosim, Request::Command(command))?;
            }
            arm(cosim)?;
            // The last torque of the check is over.
            rest(cosim, RETURN_US)?;
            cosim.bench.move_by_hand(plant.initial.q.into(), RETURN_US);
            rest(cosim, 2 * RETURN_US)
        })?;
        Ok((board, Observation::from(&record)))
    }

    pub(super) fn with<T>(&mut self, run: impl FnOnce(&mut Simulation<'_>) -> T) -> T {
        self.cell.with_dependent_mut(|_, cosim| run(cosim))
    }

    /// Gives a command, lets go of the arm, and runs so many ticks; returns the last.
    ///
    /// # Errors
    /// If the session has ended.
    pub fn advance(&mut self, command: Command, ticks: u32) -> Result<Observation, ExactError> {
        self.with(|cosim| {
            let now_us = cosim.now_us();
            cosim.host.0.request(now_us, Request::Command(command));
            cosim.bench.release();
            let before = cosim.host.0.status().record;
            let until = before.map_or(0, |record| record.tick.wrapping_add(ticks));
            let most_us = SERVO_TIMEOUT_US;
            let record = await_record(cosim, most_us, |record| record.tick >= until)?;
            Ok(Observation::from(&record))
        })
    }

    /// True state of the arm.
    pub fn true_state(&self) -> State<f64> {
        self.cell
            .with_dependent(|_, cosim| cosim.bench.plant().state())
    }
}

/// Runs until the last record is such a one, for at most this time.
fn await_record(
    cosim: &mut Simulation<'_>,
    most_us: u64,
    is_awaited: impl Fn(&Record) -> bool,
) -> Result<Record, ExactError> {
    let until_us = cosim.now_us() + most_us;
    loop {
        let status = cosim.host.0.status();
        if let Some(record) = status.record.filter(|record| is_awaited(record)) {
            return Ok(record);
        }
        if cosim.now_us() >= until_us {
            return Err(ExactError::Stays {
                mode: status.mode(),
                after_s: most_us as f64 * 1e-6,
            });
        }
        advance(cosim)?;
    }
}

/// Runs for this time, and returns the first record after it.
fn rest(cosim: &mut Simulation<'_>, duration_us: u64) -> Result<Record, ExactError> {
    let until_us = cosim.now_us() + duration_us;
    let is_over = |record: &Record| record.input.start_us >= until_us;
    await_record(cosim, duration_us + SERVO_TIMEOUT_US, is_over)
}

/// Runs to the next event.
fn advance(cosim: &mut Simulation<'_>) -> Result<(), ExactError> {
    cosim.step().map_err(|error| match error {
        CosimError::Board(never) => match never {},
        CosimError::Host(error) => error.into(),
    })
}

/// Makes a request, and waits for its answer.
fn request(cosim: &mut Simulation<'_>, request: Request) -> Result<(), ExactError> {
    let now_us = cosim.now_us();
    cosim.host.0.request(now_us, request);
    let until_us = now_us + SERVO_TIMEOUT_US;
    loop {
        advance(cosim)?;
        if let Some(answer) = cosim.host.0.take_answer() {
            return answer.map_err(ExactError::Refused);
        }
        if cosim.now_us() >= until_us {
            return Err(ExactError::Stays {
                mode: cosim.host.0.status().mode(),
                after_s: SERVO_TIMEOUT_US as f64 * 1e-6,
            });
        }
    }
}

/// Makes the servos ready where they are not, arms as soon as the encoders are known, and waits for
/// the check of the motors.
fn arm(cosim: &mut Simulation<'_>) -> Result<(), ExactError> {
    let idle = |record: &Record| record.mode == Mode::Idle;
    await_record(cosim, SERVO_TIMEOUT_US, idle)?;
    let servos = cosim.host.0.status().servos;
    if servos.is_some_and(|servos| !servos.is_ready) {
        request(cosim, Request::Command(Command::Prepare))?;
        rest(cosim, 1)?;
        await_record(cosim, SERVO_TIMEOUT_US, idle)?;
    }
    let until_us = cosim.now_us() + ARM_TIMEOUT_US;
    while let Err(error) = request(cosim, Request::Arm) {
        let is_early = matches!(
            error,
            ExactError::Refused(Refusal::EncoderUnknown { .. } | Refusal::Unprepared)
        );
        if !is_early || cosim.now_us() >= until_us {
            return Err(error);
        }
        rest(cosim, ARM_AGAIN_US)?;
    }
    let armed = |record: &Record| record.mode == Mode::Armed;
    await_record(cosim, ARM_TIMEOUT_US, armed)?;
    Ok(())
}
