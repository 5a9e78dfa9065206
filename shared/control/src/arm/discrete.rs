//! The arm near upright, from one sample to the next.

use crate::real::Real;
use armbridge_servo::JOINTS;
use nalgebra::{Matrix2, Matrix4, Matrix4x2, Vector2, Vector4};

/// `x(k+1) = A x(k) + B u(k)`, equation (6). The output is the two angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrete<T> {
    /// State matrix over one period.
    pub a: Matrix4<T>,
    /// Input matrix over one period.
    pub b: Matrix4x2<T>,
}

impl<T: Real> Discrete<T> {
    /// Equation (7) as printed: forward Euler at 45 ms, rounded to 4 decimals.
    pub fn paper() -> Self {
        let (o, one, period_s) = (T::zero(), T::one(), T::lit(0.045));
        Self {
            #[rustfmt::skip]
            a: Matrix4::new(
                one, o, period_s, o,
                o, one, o, period_s,
                T::lit(0.8355), o, T::lit(0.6486), o,
                o, T::lit(0.3464), o, T::lit(0.6946),
            ),
            #[rustfmt::skip]
            b: Matrix4x2::new(
                o, o,
                o, o,
                T::lit(1.4643), o,
                o, T::lit(1.9085),
            ),
        }
    }

    /// The state matrices of joints 1 and 2 alone, angle before speed. About
    /// upright that is all of A; elsewhere gravity couples the joints.
    pub fn joints(&self) -> [Matrix2<T>; JOINTS] {
        let a = &self.a;
        [
            Matrix2::new(a.m11, a.m13, a.m31, a.m33),
            Matrix2::new(a.m22, a.m24, a.m42, a.m44),
        ]
    }

    /// The state one period after `x` under a constant torque.
    pub fn step(&self, x: Vector4<T>, torque: Vector2<T>) -> Vector4<T> {
        self.a * x + self.b * torque
    }
}
