//! Dry friction that falls with speed, after Stribeck: the term beside Coulomb friction.
//!
//! ```text
//! F(v) = coulomb + drop exp(-(v / speed)²)
//! ```

use num_dual::DualNum;

/// How dry friction falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Falling {
    /// By how much from rest to full speed, in N m.
    pub drop_nm: f64,
    /// Where most of it is gone, in rad/s.
    pub speed_rad_s: f64,
}

impl Falling {
    /// What is left of the drop at a speed, in N m.
    pub(super) fn at<D: DualNum<Primitive = f64> + Copy>(&self, v: D) -> D {
        let share = v / self.speed_rad_s;
        (-(share * share)).exp() * self.drop_nm
    }
}
