//! Figs. 9 and 10: tracking a trajectory, with observer and with differences.

mod claims;

use armbridge_shared::JOINTS;
use armbridge_shared::arm::Parameters;
use armbridge_shared::estimate::{Estimator, Form};
use armbridge_sim::plant::Friction;

use super::printed::{PERIOD_S, PERIOD_US};
use super::sim::{Delay, EstimatorInput, Loop, Run, Start, arm_at};
use super::tracking::{computed_torque, goal};
use super::{BOARD_US, FindError, observers};

/// Gain of the runs that are drawn, in rad/s.
pub const OMEGA: f64 = 16.0;
/// Gains of the sweep in rad/s.
const SWEEP: [f64; 13] = [
    6.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 24.0, 26.0, 28.0, 30.0,
];
const DURATION_S: f64 = 12.0;
/// Errors count from here: the sines have swelled.
const FROM_S: f64 = 4.0;
/// An arm that is this far off, root mean square, does not track: a fifth of
/// the amplitude.
const LOST_RAD: f64 = 0.1;
/// One that is this near does.
const TRACKS_RAD: f64 = 0.05;

/// What the run finds.
#[derive(Clone, Debug)]
pub struct Track {
    /// Worse joint's error in rad (RMS) at [`OMEGA`] with a period of delay:
    /// differences, printed observer, printed poles on (7), the same on the
    /// exact model; infinite where the arm falls.
    pub delayed_rad: [f64; 4],
    /// The same without delay.
    pub prompt_rad: [f64; 4],
    /// The same with the board's observer and the delay predicted, at 45 ms and
    /// at 1 ms.
    pub mended_rad: [f64; 2],
    /// Largest gain of the sweep without delay at which the printed poles track:
    /// on (7), and on the exact model.
    pub last_omega: [f64; 2],
    /// The first gain beyond the former, and the error there when the observer
    /// is given what was sent, in rad.
    pub with_sent_torque: (f64, f64),
    runs: [Run; 3],
    /// Error in mrad over gain with delay, in the order above.
    sweep: [Vec<(f64, f64)>; 4],
    /// The same with the board's observer at 45 ms, delay predicted.
    sweep_mended: Vec<(f64, f64)>,
    /// The same as `sweep` without delay.
    sweep_prompt: [Vec<(f64, f64)>; 4],
}

impl Track {
    /// Tracks at all gains, with and without delay.
    ///
    /// # Errors
    ///
    /// See [`FindError`].
    pub fn find() -> Result<Self, FindError> {
        let candidates = [
            observers::difference(),
            observers::printed()?,
            observers::placed(false, Form::Current)?,
            observers::placed(true, Form::Current)?,
        ];
        let mended = observers::standing(PERIOD_S)?;
        let fast = observers::standing(f64::from(BOARD_US) * 1e-6)?;
        let sweep = |delay| {
            candidates.each_ref().map(|estimator| {
                let error = |omega| worse(&run(estimator, omega, delay, PERIOD_US));
                SWEEP.map(|omega| (omega, error(omega))).to_vec()
            })
        };
        let (delayed, prompt) = (sweep(Delay::Unmodelled), sweep(Delay::None));
        let at_omega = |sweep: &[Vec<(f64, f64)>; 4]| {
            [0, 1, 2, 3].map(|i| {
                let at = sweep[i].iter().find(|(omega, _)| *omega >= OMEGA);
                at.map_or(f64::NAN, |(_, error)| *error)
            })
        };
        let last = |points: &Vec<(f64, f64)>| {
            let good = points.iter().take_while(|(_, error)| *error < TRACKS_RAD);
            good.last().map_or(0.0, |(omega, _)| *omega)
        };
        let last_omega = [last(&prompt[2]), last(&prompt[3])];
        let beyond = SWEEP.into_iter().find(|omega| *omega > last_omega[0]);
        let beyond = beyond.unwrap_or(f64::NAN);
        let with_sent_torque = Loop {
            input: EstimatorInput::Sent,
            ..control(Delay::None, PERIOD_US)
        };
        let mended_run = run(&mended, OMEGA, Delay::Predicted, PERIOD_US);
        let board_run = run(&fast, OMEGA, Delay::Predicted, BOARD_US);
        Ok(Self {
            delayed_rad: at_omega(&delayed),
            prompt_rad: at_omega(&prompt),
            mended_rad: [worse(&mended_run), worse(&board_run)],
            last_omega,
            with_sent_torque: (
                beyond,
                worse(&track(&with_sent_torque, &candidates[2], beyond)),
            ),
            runs: [
                run(&candidates[0], OMEGA, Delay::Unmodelled, PERIOD_US),
                run(&candidates[1], OMEGA, Delay::Unmodelled, PERIOD_US),
                mended_run,
            ],
            sweep: delayed,
            sweep_mended: SWEEP
                .map(|omega| {
                    (
                        omega,
                        worse(&run(&mended, omega, Delay::Predicted, PERIOD_US)),
                    )
                })
                .to_vec(),
            sweep_prompt: prompt,
        })
    }
}

fn run(estimator: &Estimator<f64>, omega: f64, delay: Delay, period_us: u32) -> Run {
    track(&control(delay, period_us), estimator, omega)
}

/// The paper's loop; the board's where the delay is predicted.
fn control(delay: Delay, period_us: u32) -> Loop {
    Loop {
        period_us,
        duration_s: DURATION_S,
        plant: arm_at([0.0; JOINTS], Friction::NONE),
        delay,
        input: if delay == Delay::Predicted {
            EstimatorInput::Sent
        } else {
            EstimatorInput::Requested
        },
        start: Start::Sampled,
        compensate: false,
    }
}

fn track(control: &Loop, estimator: &Estimator<f64>, omega: f64) -> Run {
    let arm = Parameters::paper();
    control.run(estimator, |time_s, state| {
        computed_torque(&arm, omega, state, &goal(time_s))
    })
}

/// The worse joint's error in rad (RMS).
fn worse(run: &Run) -> f64 {
    let error = |joint| run.rms(joint, FROM_S, |time_s| goal(time_s).q[joint]);
    error(0).max(error(1))
}
