//! Result of a fit: the parameters, their covariance, and the windows that they explain.

use armbridge_shared::JOINTS;
use nalgebra::SMatrix;

use super::cost::Stretch;
use super::quantity::{COUNT, Quantity};
use super::search::Prior;
use super::stiction::Static;
use super::stribeck::Stribeck;

/// What was found.
#[derive(Clone, Debug)]
pub struct Found {
    /// Coordinates of the numbers.
    pub at: [f64; COUNT],
    /// Their covariance.
    pub covariance: SMatrix<f64, COUNT, COUNT>,
    /// Standard deviation of each coordinate without the weight's prior.
    pub unweighed: [f64; COUNT],
    /// Standard deviation of an encoder's noise in counts, rounding included.
    pub noise_counts: f64,
    /// How dry friction of each joint falls with speed, if the logs show that it does.
    pub stribeck: [Option<Stribeck>; JOINTS],
    /// Static friction of each joint, if it gave way often enough.
    pub friction: [Option<Static>; JOINTS],
    /// The windows, as they are explained.
    pub stretches: Vec<Stretch>,
    /// Mean square of a window's errors beyond which it is not explained, in counts
    /// squared.
    pub most: f64,
}

impl Found {
    /// A number, and its standard error.
    pub fn number(&self, joint: usize, quantity: Quantity) -> (f64, f64) {
        let i = quantity.at(joint);
        let deviation = self.covariance[(i, i)].max(0.0).sqrt();
        let value: f64 = quantity.value(self.at[i]);
        // An edge on the wrong side of off is that of no dead zone.
        let value = if self.has_none(i) { 0.0 } else { value };
        (value, deviation * quantity.slope(self.at[i]).abs())
    }

    /// Whether this is the place of an edge of a dead zone that there is not.
    pub(super) fn has_none(&self, place: usize) -> bool {
        Quantity::edges().any(|edge| edge == place) && self.at[place] <= 0.0
    }

    /// Whether a number is known by the arm's weight alone: without it the logs tell it to
    /// less than a tenth.
    pub fn rests_on_weight(&self, joint: usize, quantity: Quantity) -> bool {
        let i = quantity.at(joint);
        quantity.is_relative() && self.unweighed[i] > 0.1 && self.covariance[(i, i)].sqrt() < 0.1
    }

    /// Whether the logs say hardly more of a number than was believed before.
    pub fn is_unseen(&self, prior: &Prior, joint: usize, quantity: Quantity) -> bool {
        let i = quantity.at(joint);
        quantity != Quantity::Gravity && self.covariance[(i, i)].sqrt() > 0.5 * prior.deviation[i]
    }

    /// Windows that are not explained.
    pub fn odd(&self) -> usize {
        let is_odd = |stretch: &&Stretch| stretch.squares > self.most * stretch.count as f64;
        self.stretches.iter().filter(is_odd).count()
    }
}
