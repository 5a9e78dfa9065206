//! The board's Kalman filter over a recording: what real friction does that the model does not.
//!
//! The pendulum is joint 1 of an arm that hangs; joint 2 has neither weight nor length, and rests. The
//! filter is the one of [`armbridge_control`], in double precision and with its tuning for standing,
//! but with an encoder that only rounds, and with the friction that the recordings were fitted with.
//! It is designed anew for the time from each sample to the next, which is uneven. The torque of the
//! motor follows from the goals and the filter's own angle, by the servo's controller.
//!
//! An innovation is the difference of a sample and its prediction from those before. Innovations of
//! the right model are white, and little larger than rounding makes them. What the friction lacks
//! goes into the disturbance first, which may change as fast as on the board; the rest is left in them.

use armbridge_control::arm::{Mounting, Parameters as Arm};
use armbridge_control::encoder::Encoder;
use armbridge_control::estimate::{Config, Estimator, Tuning};
use nalgebra::Vector2;
use serde::Serialize;

use super::Fit;
use super::model::{GRAVITY_M_S2, Goals, Plant, STEP_MAX_S};
use super::parameters::FrictionForm;
use super::recording::Recording;

/// Length of the rod in m that stands for the pendulum: so short that its own inertia is a small
/// part of the pendulum's.
const ROD_M: f64 = 0.01;
/// Inertia of joint 2 in kg m², which rests.
const RESTING_KG_M2: f64 = 1.0;
/// Speed in rad/s below which a sample counts as slow: some 20 counts between samples away from
/// rest, and what the filter's model of friction has its ramp below.
const SLOW_RAD_S: f64 = 0.2;
/// Samples in which the filter converges.
const SETTLING: usize = 20;

/// Innovations of the filter over recordings, with one form of friction.
#[derive(Clone, Debug, Serialize)]
pub struct Innovations {
    /// The form.
    pub form: FrictionForm,
    /// Number of innovations.
    pub count: usize,
    /// Root mean square in counts.
    pub rms_counts: f64,
    /// The same of samples at less than 0.2 rad/s, where the friction reverses or holds.
    pub slow_rms_counts: f64,
    /// The same at more.
    pub fast_rms_counts: f64,
    /// Correlation of an innovation with the next: 0 of white noise.
    pub autocorrelation: f64,
    /// 95 % interval of that of white noise, either side of 0.
    pub autocorrelation_limit: f64,
    /// Root mean square of the estimated disturbance torque in N m.
    pub disturbance_rms_nm: f64,
}

/// Root mean square of a rounded count.
pub(super) fn rounding_counts() -> f64 {
    12.0_f64.sqrt().recip()
}

/// Whether the filter's model can have this friction.
pub(super) fn has_form(form: FrictionForm) -> bool {
    match form {
        FrictionForm::Coulomb | FrictionForm::Load => true,
        FrictionForm::LoadStribeck => false,
    }
}

/// Sums over samples.
#[derive(Default)]
struct Sums {
    count: usize,
    squares: [f64; 2],
    counts: [usize; 2],
    products: f64,
    disturbance: f64,
}

/// Innovations over these recordings, with the parameters of a fit; `None` if no filter has them.
pub(super) fn innovations(recordings: &[&Recording], fit: &Fit) -> Option<Innovations> {
    let mut sums = Sums::default();
    for recording in recordings {
        run(recording, fit, &mut sums)?;
    }
    let rms = |squares: f64, count: usize| (squares / count.max(1) as f64).sqrt();
    let squares: f64 = sums.squares.iter().sum();
    Some(Innovations {
        form: fit.form,
        count: sums.count,
        rms_counts: rms(squares, sums.count),
        slow_rms_counts: rms(sums.squares[0], sums.counts[0]),
        fast_rms_counts: rms(sums.squares[1], sums.counts[1]),
        autocorrelation: sums.products / squares,
        autocorrelation_limit: 1.96 / (sums.count.max(1) as f64).sqrt(),
        disturbance_rms_nm: rms(sums.disturbance, sums.count),
    })
}

/// The filter over one recording.
fn run(recording: &Recording, fit: &Fit, sums: &mut Sums) -> Option<()> {
    let rad_per_count = Encoder::XSeries.nominal_rad_per_count();
    let plant = Plant::new(recording, &fit.parameters);
    let samples = &recording.samples;
    let mut goals = Goals::new(samples, &fit.parameters);
    let mut time_s = samples.first()?.time_s;
    let mut estimate = None;
    let mut last = 0.0;
    for (index, sample) in samples.iter().enumerate() {
        let steps = ((sample.time_s - time_s) / STEP_MAX_S).ceil().max(1.0);
        let step_s = (sample.time_s - time_s) / steps;
        let angle_rad = sample.angle_rad - plant.zero_rad;
        let Some(estimate) = &mut estimate else {
            // Its first samples correct the speed.
            let filter = filter(&plant, true, STEP_MAX_S)?.0;
            estimate = Some(filter.at_rest(Vector2::new(angle_rad, 0.0)));
            continue;
        };
        let mut corrector = None;
        for step in 0..steps as usize {
            let at_s = time_s + (step as f64 + 0.5) * step_s;
            let (goal_rad, supply_v) = goals.at(at_s);
            let (filter, arm) = filter(&plant, supply_v.is_some(), step_s)?;
            let predicted_rad = filter.correct(estimate, [None, Some(0.0)]).q.x;
            let motor_nm = plant.stall_nm(predicted_rad + plant.zero_rad, goal_rad, supply_v);
            filter.advance(&arm, estimate, Vector2::new(motor_nm, 0.0));
            corrector = Some(filter);
        }
        let filter = corrector?;
        let predicted = filter.correct(estimate, [None, Some(0.0)]);
        filter.correct(estimate, [Some(angle_rad), None]);
        let innovation = (angle_rad - predicted.q.x) / rad_per_count;
        if index >= SETTLING {
            let is_fast = usize::from(predicted.dq.x.abs() > SLOW_RAD_S);
            sums.count += 1;
            sums.counts[is_fast] += 1;
            sums.squares[is_fast] += innovation * innovation;
            sums.products += innovation * last;
            sums.disturbance += estimate.disturbance().x.powi(2);
            last = innovation;
        }
        time_s = sample.time_s;
    }
    Some(())
}

/// The filter for steps of this length, with its arm.
fn filter(plant: &Plant, is_driven: bool, step_s: f64) -> Option<(Estimator<f64>, Arm<f64>)> {
    let back_emf = if is_driven { plant.back_emf } else { 0.0 };
    // A rod with the pendulum's weight, and the rest of its inertia in the rotor.
    let m1 = plant.gravity_nm / (GRAVITY_M_S2 * ROD_M / 2.0);
    let arm = Arm {
        l1: ROD_M,
        l2: 0.0,
        m1,
        m2: 0.0,
        g: GRAVITY_M_S2,
        i1x: plant.inertia_kg_m2 - m1 * ROD_M * ROD_M / 4.0,
        i1y: 0.0,
        i1z: 0.0,
        i2x: 0.0,
        i2y: RESTING_KG_M2,
        i2z: 0.0,
        b1: plant.viscous + back_emf,
        b2: 0.0,
        mounting: Mounting::Hanging,
    };
    let tuning = Tuning {
        angle_rad: rounding_counts() * Encoder::XSeries.nominal_rad_per_count(),
        coulomb_nm: plant.coulomb_nm,
        ..Tuning::standing()
    };
    let filter = Config::Kalman(tuning).build_with_load(&arm, step_s, [plant.load, 0.0]);
    Some((filter.ok()?, arm))
}

#[cfg(test)]
mod tests {
    use super::super::model::simulate;
    use super::super::parameters::{Parameters, Quantity};
    use super::super::recording::Sample;
    use super::*;

    /// A driven pendulum of 0.48 N m that follows slow sines, simulated; its angles are counts.
    fn recording(parameters: &Parameters) -> Recording {
        let sample = |i: usize| {
            let time_s = i as f64 * 0.005;
            Sample {
                time_s,
                angle_rad: 0.0,
                goal_rad: 0.9 * (2.0 * time_s).sin() + 0.5 * (5.3 * time_s).sin(),
                is_driven: true,
                supply_v: 7.4,
            }
        };
        let mut recording = Recording {
            name: String::new(),
            trajectory: String::new(),
            gain: 400.0,
            gravity_nm: 0.48,
            inertia_kg_m2: 0.0049,
            initial_speed_rad_s: 0.0,
            samples: (0..2_000).map(sample).collect(),
        };
        let count = Encoder::XSeries.nominal_rad_per_count();
        let angles_rad = simulate(&recording, parameters);
        for (sample, angle_rad) in recording.samples.iter_mut().zip(angles_rad) {
            sample.angle_rad = (angle_rad / count).round() * count;
        }
        recording
    }

    #[test]
    fn the_right_friction_leaves_half_the_disturbance_and_the_same_innovations() {
        let load = Parameters::default()
            .with(Quantity::StallTorque, 0.09)
            .with(Quantity::BackEmf, 0.036)
            .with(Quantity::RotorInertia, 0.0016)
            .with(Quantity::Coulomb, 0.01)
            .with(Quantity::Viscous, 0.004)
            .with(Quantity::Load, 0.17)
            .with(Quantity::Delay, 0.004);
        let recording = recording(&load);
        let over = |form, parameters| {
            let fit = Fit {
                form,
                parameters,
                error_deg: 0.0,
            };
            innovations(&[&recording], &fit).unwrap()
        };
        let right = over(FrictionForm::Load, load);
        let coulomb = load.with(Quantity::Coulomb, 0.05).with(Quantity::Load, 0.0);
        let wrong = over(FrictionForm::Coulomb, coulomb);
        println!("{right:?}\n{wrong:?}");
        // The disturbance follows what the friction lacks from sample to sample.
        assert!((right.rms_counts / wrong.rms_counts - 1.0).abs() < 0.01);
        assert!(right.rms_counts < 1.5 * rounding_counts());
        assert!(right.disturbance_rms_nm < 0.6 * wrong.disturbance_rms_nm);
    }
}
