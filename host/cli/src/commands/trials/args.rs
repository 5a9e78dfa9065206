//! Options of `armbridge trials`.

use std::path::PathBuf;

use armbridge_analysis::monte_carlo::Maneuver;
use armbridge_client::params::{self, JointPoles};
use armbridge_servo::JOINTS;
use armbridge_sim::plant::Push;
use clap::{Args, ValueEnum};

use crate::args::ForceArgs;
use crate::args::suggestions::plants;
use crate::args::values::{
    Seeds, angles, duration, not_negative, numbers, period, positive, seeds, weights,
};

/// Trials on the bench.
#[derive(Args, Debug)]
pub(crate) struct TrialsArgs {
    /// Use the recommended settings, which are the default.
    #[arg(long, conflicts_with_all = ["controller", "estimator", "friction"])]
    pub(crate) best: bool,
    #[command(flatten)]
    pub(crate) control: ControlArgs,
    #[command(flatten)]
    pub(crate) estimate: EstimateArgs,
    /// Feed-forward torque against dry friction, in N m [default: 0.04,0.04].
    #[arg(long, value_name = "NM,NM", value_parser = weights::<2>)]
    pub(crate) friction: Option<[f32; JOINTS]>,
    /// Tick period in µs.
    #[arg(long, value_name = "US", default_value_t = 1_000, value_parser = period)]
    pub(crate) period_us: u32,
    /// Virtual arm: the name of one that ships (`armbridge plants`), or a file.
    #[arg(long, value_name = "NAME|FILE", value_parser = plants(), hide_possible_values = true)]
    pub(crate) plant: Option<String>,
    /// Reference: upright, hold:Q1,Q2, step:Q1,Q2, min-jerk:Q1,Q2[,S], sine:A1,A2,HZ or
    /// chirp:A1,A2,HZ,HZ; in rad. Motions begin upright, after 2 s.
    #[arg(long, value_name = "WHAT", default_value = "upright")]
    pub(crate) reference: Maneuver,
    /// Joint angles in rad at which the arm is held until torque comes on
    /// [default: 0.49,-0.3, or as the plant file sets them].
    #[arg(long, value_name = "RAD,RAD", value_parser = angles, allow_hyphen_values = true)]
    pub(crate) initial: Option<[f64; JOINTS]>,
    /// Push joint 1 or 2 with this torque, from this time on, for this duration; may be
    /// repeated.
    #[arg(long, value_name = "JOINT,NM,START_S,DURATION_S", value_parser = push,
          allow_hyphen_values = true)]
    pub(crate) disturb: Vec<Push>,
    /// Fraction of the servos' replies that is damaged at random, 0 to 1.
    #[arg(long, value_name = "P", default_value_t = 0.0, value_parser = share)]
    pub(crate) loss: f64,
    /// Random seeds: 1..20, or 1,2,3.
    #[arg(long, default_value = "1..5", value_parser = seeds)]
    pub(crate) seeds: Seeds,
    /// Simulated time in s from the first setpoint on.
    #[arg(long, value_name = "S", default_value_t = 8.0, value_parser = duration)]
    pub(crate) duration: f64,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
    /// Write the first seed's plots and log to this folder.
    #[arg(long, value_name = "DIR")]
    pub(crate) plot: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// No progress bar, no table.
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// From state to torque.
#[derive(Args, Debug)]
pub(crate) struct ControlArgs {
    /// Control law.
    #[arg(long, value_enum, default_value_t = ControllerName::Lqr)]
    pub(crate) controller: ControllerName,
    /// Diagonal of the LQR's Q: both angles, both speeds.
    #[arg(long, value_name = "A,B,C,D", value_parser = weights::<4>)]
    pub(crate) q: Option<[f32; 4]>,
    /// Diagonal of the LQR's R: both torques.
    #[arg(long, value_name = "A,B", value_parser = weights::<2>)]
    pub(crate) r: Option<[f32; 2]>,
    /// Natural frequencies of the computed torque's errors, in rad/s.
    #[arg(long, value_name = "W1,W2", value_parser = weights::<2>)]
    pub(crate) natural: Option<[f32; JOINTS]>,
    /// Damping ratios of the computed torque's errors.
    #[arg(long, value_name = "Z1,Z2", value_parser = weights::<2>)]
    pub(crate) damping: Option<[f32; JOINTS]>,
}

/// From samples to state.
#[derive(Args, Debug)]
pub(crate) struct EstimateArgs {
    /// State estimator.
    #[arg(long, value_enum, default_value_t = EstimatorName::Kalman)]
    pub(crate) estimator: EstimatorName,
    /// Time constant of the filtered difference in s [default: 0.02].
    #[arg(long, value_name = "S", value_parser = positive)]
    pub(crate) filter: Option<f32>,
    /// Poles of the Luenberger observer at 45 ms, two for each joint: real ones, or a pair
    /// as 0.6±0.2i.
    #[arg(long, value_name = "P,P,P,P", value_parser = poles)]
    pub(crate) poles: Option<JointPoles>,
    /// Let the observer see each sample one period late, as the paper prints it.
    #[arg(long)]
    pub(crate) prediction: bool,
    /// Angle noise of the Kalman filter, in rad.
    #[arg(long, value_name = "RAD", value_parser = positive)]
    pub(crate) angle_noise: Option<f32>,
    /// Acceleration noise of the Kalman filter, in rad/s² per root Hz.
    #[arg(long, value_name = "X", value_parser = positive)]
    pub(crate) acceleration_noise: Option<f32>,
    /// Random walk of the Kalman filter's disturbance, in N m per root s.
    #[arg(long, value_name = "X", value_parser = not_negative)]
    pub(crate) walk: Option<f32>,
    /// Coulomb friction in the Kalman filter's model, in N m.
    #[arg(long, value_name = "NM", value_parser = not_negative)]
    pub(crate) coulomb: Option<f32>,
    /// Speed above which that friction is fully developed, in rad/s.
    #[arg(long, value_name = "RAD/S", value_parser = positive)]
    pub(crate) slide: Option<f32>,
}

/// Control laws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ControllerName {
    /// The gain that the paper prints, meant for 45 ms.
    Paper,
    /// LQR, designed for the period.
    Lqr,
    /// Feedback linearisation.
    ComputedTorque,
}

/// Estimators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum EstimatorName {
    /// Plain backward difference.
    Difference,
    /// Backward difference through a low pass.
    Filtered,
    /// The paper's observer (11).
    Luenberger,
    /// Kalman filter with disturbance torques.
    Kalman,
}

fn poles(text: &str) -> Result<JointPoles, String> {
    params::joint_poles(text).ok_or_else(|| {
        "expected two poles for each joint: numbers from 0 and below 1, or a pair as 0.6±0.2i \
         with a magnitude below 1"
            .into()
    })
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("expected a fraction from 0 to 1".into()),
    }
}

fn push(text: &str) -> Result<Push, String> {
    /// Torque in N m beyond which no hand pushes, and the longest run in s.
    const MOST: [f64; 2] = [10.0, 3_600.0];

    let push = || {
        let (joint, rest) = text.split_once(',')?;
        let [torque_nm, start_s, duration_s] = numbers(rest)?;
        let joint = ["1", "2"].into_iter().position(|j| j == joint.trim())?;
        let is_time = |s: f64| (0.0..=MOST[1]).contains(&s);
        let is_push = f64::abs(torque_nm) <= MOST[0] && is_time(start_s) && is_time(duration_s);
        let nanoseconds = |s: f64| (s * 1e9) as u64;
        is_push.then(|| Push {
            joint,
            torque_nm,
            start_ns: nanoseconds(start_s),
            duration_ns: nanoseconds(duration_s),
        })
    };
    push()
        .ok_or_else(|| "expected joint 1 or 2, N m, and two times in s, as 1,0.2,3,0.05".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_what_is_meant() {
        assert_eq!(seeds("2..4"), Ok(Seeds(vec![2, 3, 4])));
        assert_eq!(seeds("7,1"), Ok(Seeds(vec![7, 1])));
        for wrong in ["", "4..2", "1..999999", "a", "1,", "-1"] {
            assert!(seeds(wrong).is_err(), "{wrong}");
        }
        let pushed = push("2,-0.2,3,0.05").unwrap();
        assert_eq!((pushed.joint, pushed.torque_nm), (1, -0.2));
        assert_eq!(
            (pushed.start_ns, pushed.duration_ns),
            (3_000_000_000, 50_000_000)
        );
        for wrong in ["0,1,1,1", "1.5,1,1,1", "1,nan,1,1", "1,1,-1,1", "1,1,1"] {
            assert!(push(wrong).is_err(), "{wrong}");
        }
    }
}
