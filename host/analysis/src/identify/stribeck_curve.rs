//! Stribeck curve: dry friction above Coulomb friction, which falls with speed.
//!
//! ```text
//! F(v) = coulomb + drop exp(-(v / speed)²)
//! ```

use num_dual::DualNum;

/// Dry friction in excess of Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StribeckCurve {
    /// Excess at rest, in N m.
    pub drop_nm: f64,
    /// Speed at which it has fallen to 1/e, in rad/s.
    pub speed_rad_s: f64,
}

impl StribeckCurve {
    /// Excess at a speed, in N m.
    pub(super) fn excess_nm<D: DualNum<Primitive = f64> + Copy>(&self, v: D) -> D {
        let ratio = v / self.speed_rad_s;
        (-(ratio * ratio)).exp() * self.drop_nm
    }
}
