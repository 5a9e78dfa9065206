//! Figs. 9 and 10: trajectory tracking with an observer and with differences.

mod claims;

use armbridge_control::arm::Parameters;
use armbridge_control::estimate::{Estimator, Form};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::Friction;

use super::computed_torque::{computed_torque, reference};
use super::printed::{PERIOD_S, PERIOD_US};
use super::sampled_loop::{Delay, EstimatorInput, InitialEstimate, Run, SampledLoop, arm_at};
use super::{BOARD_US, DesignError, observers};

/// Gain of the runs that are drawn, in rad/s.
pub const OMEGA: f64 = 16.0;
/// Gains of the sweep in rad/s.
const SWEEP: [f64; 13] = [
    6.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 24.0, 26.0, 28.0, 30.0,
];
const DURATION_S: f64 = 12.0;
/// Start of the RMS error, in s: the amplitudes are constant.
const FROM_S: f64 = 4.0;
/// Smallest RMS error of an arm that does not track: a fifth of the amplitude.
const LOST_RAD: f64 = 0.1;
/// Largest RMS error of an arm that tracks.
const TRACKS_RAD: f64 = 0.05;

/// Results of the run.
#[derive(Clone, Debug)]
pub struct Tracking {
    /// RMS error of the worse joint in rad at [`OMEGA`] with a period of delay:
    /// differences, printed observer, printed poles on (7), the same on the
    /// exact model; infinite if the arm falls.
    pub delayed_rad: [f64; 4],
    /// RMS error without delay, in the same order.
    pub undelayed_rad: [f64; 4],
    /// RMS error with the board's observer and the delay predicted, at 45 ms and
    /// at 1 ms.
    pub corrected_rad: [f64; 2],
    /// Largest gain of the sweep without delay at which the printed poles track:
    /// on (7), and on the exact model.
    pub last_omega: [f64; 2],
    /// Next larger gain than the former, and the RMS error there in rad if the observer's
    /// input is the torque sent.
    pub with_sent_torque: (f64, f64),
    runs: [Run; 3],
    /// RMS error in rad over gain with delay, in the order above.
    sweep: [Vec<(f64, f64)>; 4],
    /// RMS error with the board's observer at 45 ms, delay predicted.
    sweep_corrected: Vec<(f64, f64)>,
    /// RMS error without delay, in the order of `sweep`.
    sweep_undelayed: [Vec<(f64, f64)>; 4],
}

impl Tracking {
    /// Simulates tracking at all gains, with and without delay.
    ///
    /// # Errors
    ///
    /// See [`DesignError`].
    pub fn compute() -> Result<Self, DesignError> {
        let candidates = [
            observers::difference(),
            observers::printed()?,
            observers::placed(false, Form::Current)?,
            observers::placed(true, Form::Current)?,
        ];
        let corrected = observers::standing(PERIOD_S)?;
        let fast = observers::standing(f64::from(BOARD_US) * 1e-6)?;
        let sweep = |delay| {
            candidates.each_ref().map(|estimator| {
                let rms_error = |omega| worst_rms_error(&run(estimator, omega, delay, PERIOD_US));
                SWEEP.map(|omega| (omega, rms_error(omega))).to_vec()
            })
        };
        let (delayed, undelayed) = (sweep(Delay::Unmodelled), sweep(Delay::None));
        let at_omega = |sweep: &[Vec<(f64, f64)>; 4]| {
            [0, 1, 2, 3].map(|i| {
                let point = sweep[i].iter().find(|(omega, _)| *omega >= OMEGA);
                point.map_or(f64::NAN, |(_, error)| *error)
            })
        };
        let last = |points: &Vec<(f64, f64)>| {
            let tracked = points.iter().take_while(|(_, error)| *error < TRACKS_RAD);
            tracked.last().map_or(0.0, |(omega, _)| *omega)
        };
        let last_omega = [last(&undelayed[2]), last(&undelayed[3])];
        let next_omega = SWEEP.into_iter().find(|omega| *omega > last_omega[0]);
        let next_omega = next_omega.unwrap_or(f64::NAN);
        let with_sent_torque = SampledLoop {
            input: EstimatorInput::Sent,
            ..control(Delay::None, PERIOD_US)
        };
        let corrected_run = run(&corrected, OMEGA, Delay::Predicted, PERIOD_US);
        let board_run = run(&fast, OMEGA, Delay::Predicted, BOARD_US);
        Ok(Self {
            delayed_rad: at_omega(&delayed),
            undelayed_rad: at_omega(&undelayed),
            corrected_rad: [worst_rms_error(&corrected_run), worst_rms_error(&board_run)],
            last_omega,
            with_sent_torque: (
                next_omega,
                worst_rms_error(&track(&with_sent_torque, &candidates[2], next_omega)),
            ),
            runs: [
                run(&candidates[0], OMEGA, Delay::Unmodelled, PERIOD_US),
                run(&candidates[1], OMEGA, Delay::Unmodelled, PERIOD_US),
                corrected_run,
            ],
            sweep: delayed,
            sweep_corrected: SWEEP
                .map(|omega| {
                    (
                        omega,
                        worst_rms_error(&run(&corrected, omega, Delay::Predicted, PERIOD_US)),
                    )
                })
                .to_vec(),
            sweep_undelayed: undelayed,
        })
    }
}

fn run(estimator: &Estimator<f64>, omega: f64, delay: Delay, period_us: u32) -> Run {
    track(&control(delay, period_us), estimator, omega)
}

/// The paper's loop, or the board's if the delay is predicted.
fn control(delay: Delay, period_us: u32) -> SampledLoop {
    SampledLoop {
        period_us,
        duration_s: DURATION_S,
        plant: arm_at([0.0; JOINTS], Friction::NONE),
        delay,
        input: if delay == Delay::Predicted {
            EstimatorInput::Sent
        } else {
            EstimatorInput::Requested
        },
        start: InitialEstimate::FirstSample,
        compensate: false,
    }
}

fn track(control: &SampledLoop, estimator: &Estimator<f64>, omega: f64) -> Run {
    let arm = Parameters::paper();
    control.run(estimator, |time_s, state| {
        computed_torque(&arm, omega, state, &reference(time_s))
    })
}

/// RMS error of the worse joint in rad.
fn worst_rms_error(run: &Run) -> f64 {
    let rms_error = |joint| run.rms_error(joint, FROM_S, |time_s| reference(time_s).q[joint]);
    rms_error(0).max(rms_error(1))
}
