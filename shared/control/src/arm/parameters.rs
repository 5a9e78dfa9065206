//! Table 1 of the paper as data.

use crate::check_word::{CheckWord, Checked, checked};
use crate::real::Real;
use armbridge_servo::JOINTS;
#[cfg(feature = "postcard")]
use postcard::experimental::max_size::MaxSize;
#[cfg(feature = "postcard")]
use postcard_schema::Schema;
#[cfg(feature = "postcard")]
use serde::{Deserialize, Serialize};

/// Orientation of the arm's foot: direction of both links at q = 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
pub enum Mounting {
    /// On the table: straight up, as in the paper.
    #[default]
    Upright,
    /// Upside down: straight down.
    Hanging,
}

/// Parameters of an arm in equations (1) to (4).
///
/// Fields carry the names of Table 1. A value that does not enter the
/// equations (I1y, I1z) is kept so that the table is whole.
///
/// ```
/// use armbridge_control::arm::{Parameters, State};
/// use nalgebra::Vector2;
///
/// let arm = Parameters { b1: 0.0, b2: 0.0, ..Parameters::<f64>::paper() };
/// let leaning = Vector2::new(0.3, -0.25);
/// // Under the torque of gravity the arm stays where it rests.
/// let rest = State::at_rest(leaning);
/// assert!(arm.acceleration(&rest, arm.gravity(leaning)).amax() < 1e-12);
///
/// // Without torque and friction it falls, and keeps its energy.
/// let (mut state, step_s) = (rest, 1e-5);
/// while state.q.amax() < 1.0 {
///     state.dq += arm.acceleration(&state, Vector2::zeros()) * step_s;
///     state.q += state.dq * step_s;
/// }
/// assert!((arm.energy(&state) - arm.energy(&rest)).abs() < 1e-4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "postcard", derive(Serialize, Deserialize, Schema, MaxSize))]
pub struct Parameters<T> {
    /// Length from joint 1 to joint 2 in m.
    pub l1: T,
    /// Length from joint 2 to the end in m.
    pub l2: T,
    /// Mass of link 1 in kg.
    pub m1: T,
    /// Mass of link 2 in kg.
    pub m2: T,
    /// Gravitational acceleration in m/s^2.
    pub g: T,
    /// Inertia of link 1 about x in kg m^2, mostly that of the geared rotor.
    pub i1x: T,
    /// Inertia of link 1 about y in kg m^2; not used by the equations.
    pub i1y: T,
    /// Inertia of link 1 about z in kg m^2; not used by the equations.
    pub i1z: T,
    /// Inertia of link 2 about x in kg m^2.
    pub i2x: T,
    /// Inertia of link 2 about y in kg m^2, mostly that of the geared rotor.
    pub i2y: T,
    /// Inertia of link 2 about z in kg m^2.
    pub i2z: T,
    /// Viscous friction of joint 1 in N m s/rad.
    pub b1: T,
    /// Viscous friction of joint 2 in N m s/rad.
    pub b2: T,
    /// Orientation of the foot.
    pub mounting: Mounting,
}

checked!(Parameters<T> {
    l1, l2, m1, m2, g, i1x, i1y, i1z, i2x, i2y, i2z, b1, b2, mounting,
});

impl Checked for Mounting {
    fn check(&self, sum: &mut CheckWord) {
        sum.word(match self {
            Self::Upright => 0,
            Self::Hanging => 1,
        });
    }
}

impl<T> Parameters<T> {
    /// The same arm in other numbers: `f64::from` for the arm of a board.
    pub fn map<U>(self, mut number: impl FnMut(T) -> U) -> Parameters<U> {
        Parameters {
            l1: number(self.l1),
            l2: number(self.l2),
            m1: number(self.m1),
            m2: number(self.m2),
            g: number(self.g),
            i1x: number(self.i1x),
            i1y: number(self.i1y),
            i1z: number(self.i1z),
            i2x: number(self.i2x),
            i2y: number(self.i2y),
            i2z: number(self.i2z),
            b1: number(self.b1),
            b2: number(self.b2),
            mounting: self.mounting,
        }
    }
}

impl<T: Real> Parameters<T> {
    /// The arm that the paper computed with.
    ///
    /// Table 1 prints I1x = I2y = 0.0227, three digits of what was used: the
    /// sixteen entries of (7) come out to all printed digits if, and only if,
    /// I1x = I2y lies in 0.02265346..0.02265434 and M(1,1) contains the term
    /// `M1 L1^2/4` that the printed (3) lacks. 0.022654 is the shortest number
    /// in that interval.
    pub fn paper() -> Self {
        Self {
            i1x: T::lit(0.022654),
            i2y: T::lit(0.022654),
            ..Self::table_1()
        }
    }

    /// Table 1 as printed.
    pub fn table_1() -> Self {
        Self {
            l1: T::lit(0.095),
            l2: T::lit(0.1),
            m1: T::lit(0.095),
            m2: T::lit(0.37),
            g: T::lit(9.81),
            i1x: T::lit(0.0227),
            i1y: T::lit(0.833e-4),
            i1z: T::lit(0.181e-4),
            i2x: T::lit(0.833e-4),
            i2y: T::lit(0.0227),
            i2z: T::lit(0.707e-4),
            b1: T::lit(0.24),
            b2: T::lit(0.16),
            mounting: Mounting::Upright,
        }
    }

    /// The same numbers read with equation (3) as printed.
    ///
    /// (3) omits `M1 L1^2/4`. Taking as much off I1x gives an arm whose mass
    /// matrix, as computed here, is the printed one.
    #[must_use]
    pub fn with_mass_as_printed(self) -> Self {
        Self {
            i1x: self.i1x - self.m1 * self.l1 * self.l1 * T::lit(0.25),
            ..self
        }
    }

    /// Whether these can be the numbers of an arm that such servos move: links
    /// to a metre, masses to 10 kg, some inertia about both axes. NaN never can.
    pub fn is_valid(&self) -> bool {
        let within = |x: T, low: f64, high: f64| x >= T::lit(low) && x <= T::lit(high);
        let inertias = [self.i1y, self.i1z, self.i2x, self.i2z];
        within(self.l1, 0.0, 1.0)
            && within(self.l2, 0.0, 1.0)
            && within(self.m1, 0.0, 10.0)
            && within(self.m2, 0.0, 10.0)
            && within(self.g, 0.0, 100.0)
            && within(self.i1x, 1e-5, 10.0)
            && within(self.i2y, 1e-5, 10.0)
            && inertias.iter().all(|i| within(*i, 0.0, 1.0))
            && within(self.b1, 0.0, 10.0)
            && within(self.b2, 0.0, 10.0)
    }

    /// Number of joints: two, or one without link 2, which has neither length nor mass then.
    ///
    /// Equation (1) is that of a pendulum in this case, and joint 2 an axis by itself, with inertia
    /// and viscous friction but without gravity: it rests at 0, and no motor moves it.
    #[inline]
    pub fn joints(&self) -> usize {
        if self.l2 == T::zero() && self.m2 == T::zero() {
            1
        } else {
            JOINTS
        }
    }

    /// Weight of each joint in N m: its largest gravity torque.
    pub fn weight_nm(&self) -> [T; 2] {
        let (m1, m2) = (self.moment_1(), self.moment_2());
        [self.g * (m1 + m2), self.g * m2]
    }

    /// g as it pulls the links towards the foot, in m/s^2.
    ///
    /// An arm that hangs is one on the table turned over, foot and all. Its angles are
    /// relative to its foot, so that lengths, inertias and friction are the same for it;
    /// of all of equation (1), only gravity is not fixed to the foot, and seen from
    /// there it has turned over.
    pub(super) fn pull_to_foot(&self) -> T {
        match self.mounting {
            Mounting::Upright => self.g,
            Mounting::Hanging => -self.g,
        }
    }

    /// `L1 M1/2 + L1 M2` in kg m: the moment of joint 1 that does not depend
    /// on q2, over g.
    pub(super) fn moment_1(&self) -> T {
        self.l1 * (self.m1 * T::lit(0.5) + self.m2)
    }

    /// `L2 M2/2` in kg m: the moment of link 2 about joint 2, over g.
    pub(super) fn moment_2(&self) -> T {
        self.l2 * self.m2 * T::lit(0.5)
    }
}
