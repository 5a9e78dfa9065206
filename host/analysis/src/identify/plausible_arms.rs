//! Arms that a fit considers plausible, for policies that have to cope with each of them.
//!
//! All parameters are drawn together from the normal distribution that has the estimates as its
//! mean and their covariance. What the fit does not estimate is as in the settings of the board:
//! lengths, mounting, gravity. A joint without an estimate of static friction has as much as Coulomb
//! friction.

use armbridge_servo::JOINTS;
use armbridge_sim::environment::fast::Delays;
use armbridge_sim::plant::{Friction, PlantConfig};
use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg32;

use super::ArmFit;
use super::board_settings::{UnphysicalArm, identified_settings};
use super::fit_result::FitResult;
use super::quantity::{COUNT, Quantity};

/// Stream of the generator; other generators use 0 to 8.
const STREAM: u64 = 9;
/// Attempts to draw a physical arm.
const ATTEMPTS: usize = 100;

impl ArmFit {
    /// Draws so many arms; the result depends on the fit and the seed alone.
    ///
    /// # Errors
    /// If hardly any draw is a physical arm.
    pub fn plausible_arms(
        &self,
        count: usize,
        seed: u64,
    ) -> Result<Vec<PlantConfig>, UnphysicalArm> {
        let mut random = Pcg32::new(seed, STREAM);
        let spread = square_root(&self.result);
        (0..count)
            .map(|_| self.draw(&spread, &mut random))
            .collect()
    }

    fn draw(
        &self,
        spread: &DMatrix<f64>,
        random: &mut Pcg32,
    ) -> Result<PlantConfig, UnphysicalArm> {
        let mut attempt = || {
            let unit = DVector::from_fn(COUNT, |_, _| StandardNormal.sample(random));
            let step: DVector<f64> = spread * unit;
            let mut result = self.result.clone();
            for (coordinate, step) in result.coordinates.iter_mut().zip(step.iter()) {
                *coordinate += step;
            }
            self.plant(&result)
        };
        let mut drawn = attempt();
        for _ in 1..ATTEMPTS {
            if drawn.is_ok() {
                break;
            }
            drawn = attempt();
        }
        drawn
    }

    /// The arm with the parameters of a fit.
    fn plant(&self, result: &FitResult) -> Result<PlantConfig, UnphysicalArm> {
        let settings = identified_settings(&self.before, result)?;
        let of_joint = |joint: usize, quantity| result.estimate(joint, quantity).0;
        let friction = core::array::from_fn(|joint| {
            let coulomb_nm = of_joint(joint, Quantity::Coulomb);
            let load = result.load[joint].map_or(0.0, |it| it.load);
            let static_nm = result.static_friction[joint].map_or(coulomb_nm, |it| it.torque_nm);
            match result.stribeck[joint] {
                Some(curve) => Friction {
                    coulomb_nm,
                    static_nm: coulomb_nm + curve.drop_nm.max(0.0),
                    stribeck_rad_s: curve.speed_rad_s,
                    load,
                },
                None => Friction {
                    coulomb_nm,
                    static_nm: static_nm.max(coulomb_nm),
                    stribeck_rad_s: 0.0,
                    load,
                },
            }
        });
        let joints: [usize; JOINTS] = core::array::from_fn(|joint| joint);
        let own = PlantConfig::of_board(&settings);
        let simulated_us = Delays::of(own.firmware()).total_us();
        Ok(PlantConfig {
            friction_on: true,
            friction,
            dead_zone_counts: joints.map(|joint| {
                [Quantity::DeadBelow, Quantity::DeadAbove]
                    .map(|edge| of_joint(joint, edge).max(0.0).round() as u16)
            }),
            // What the simulation of wire and servo has of it by itself is left out.
            input_delay_ns: joints.map(|joint| {
                let delay_us = of_joint(joint, Quantity::Delay) * 1e6;
                (delay_us.max(0.0) as u64).saturating_sub(simulated_us) * 1_000
            }),
            ..own
        })
    }
}

/// Matrix whose product with its own transpose is the covariance; rounding may have made that
/// slightly indefinite.
fn square_root(result: &FitResult) -> DMatrix<f64> {
    let covariance = DMatrix::from_fn(COUNT, COUNT, |row, column| {
        0.5 * (result.covariance[(row, column)] + result.covariance[(column, row)])
    });
    let decomposition = covariance.symmetric_eigen();
    let roots = decomposition.eigenvalues.map(|value| value.max(0.0).sqrt());
    decomposition.eigenvectors * DMatrix::from_diagonal(&roots)
}
