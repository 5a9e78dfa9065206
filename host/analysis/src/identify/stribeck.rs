//! Dry friction that falls with speed, after Stribeck, where the logs show that it does.
//!
//! ```text
//! F(v) = coulomb + drop exp(-(v / speed)²)
//! ```
//!
//! Two numbers of a joint more, which most arms do without: of a dry friction that does not
//! fall, the speed at which it does is not identifiable. So they are sought after all others,
//! and only where [`Checks`](super::Checks)' linear test of such a torque is sure. For a drop
//! and a speed the search goes down once more, in the joint's own windows; what it comes to
//! is, near the bottom, a quadratic form in their logarithms, whose least is found in a few
//! steps of Newton's and whose curvature gives their covariance.

use armbridge_shared::JOINTS;
use nalgebra::{Matrix2, SMatrix, Vector2};
use serde::Serialize;

use super::arm::Known;
use super::cost::Stretch;
use super::quantity::{COUNT, PER_JOINT};
use super::stage::Round;
use super::stribeck_curve::Falling;

/// What was found of a joint whose dry friction falls.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stribeck {
    /// By how much from rest to full speed, in N m.
    pub drop_nm: f64,
    /// Its standard error.
    pub drop_error_nm: f64,
    /// Where most of it is gone, in rad/s.
    pub speed_rad_s: f64,
    /// Its standard error.
    pub speed_error_rad_s: f64,
}

impl Stribeck {
    pub(super) fn falling(&self) -> Falling {
        Falling {
            drop_nm: self.drop_nm,
            speed_rad_s: self.speed_rad_s,
        }
    }
}

/// What the search has come to.
pub(super) struct Sought {
    pub(super) stribeck: Stribeck,
    /// The joint's own coordinates, where the drop and the speed want them.
    pub(super) own: [f64; PER_JOINT],
    /// What not knowing the two better adds to the covariance of the others.
    pub(super) covariance: SMatrix<f64, COUNT, COUNT>,
}

/// Step of a logarithm over which slopes and curvatures are taken.
const STEP: f64 = 0.15;
/// Farthest that a step of Newton's goes.
const FARTHEST: f64 = 0.8;
/// Steps of Newton's, and by how much the loss falls with the last: a third of a standard
/// error.
const STEPS: usize = 8;
const CLOSE: f64 = 0.1;
/// Standard errors by which a drop is more than none, and largest error of a speed as a
/// share of it.
const SURE: f64 = 3.0;
const VAGUE: f64 = 0.5;

/// Losses about a place, and the coordinates that they are at.
struct About<'a> {
    round: &'a Round<'a>,
    own: Vec<Stretch>,
    joint: usize,
}

impl About<'_> {
    fn look(&self, logarithms: Vector2<f64>, at: [f64; COUNT]) -> (f64, [f64; COUNT]) {
        let mut known = *self.round.known;
        known.falling[self.joint] = Some(falling(logarithms));
        let round = Round {
            known: &known,
            stretches: Vec::new(),
            ..*self.round
        };
        let search = round.begin_in(self.own.clone(), at).try_once();
        (search.loss(), search.at())
    }
}

/// Seeks how a joint's dry friction falls; `None` if that is not identifiable after all.
pub(super) fn sought(
    round: &Round<'_>,
    at: [f64; COUNT],
    joint: usize,
    begin: Falling,
) -> Option<Sought> {
    let own = round.stretches.iter().filter(|s| s.window.joint == joint);
    let about = About {
        round,
        own: own.cloned().collect(),
        joint,
    };
    let mut place = Vector2::new(begin.drop_nm, begin.speed_rad_s).map(f64::ln);
    let mut at = at;
    let [e1, e2] = [Vector2::x(), Vector2::y()].map(|e| e * STEP);
    for _ in 0..STEPS {
        let (loss, here) = about.look(place, at);
        at = here;
        let sides = [e1, -e1, e2, -e2, e1 + e2, -e1 - e2];
        let looks = sides.map(|side| about.look(place + side, at));
        let [right, left, up, down, one, two] = looks.map(|look| look.0);
        let slope = Vector2::new(right - left, up - down) / (2.0 * STEP);
        let square = STEP * STEP;
        let by_drop = (right + left - 2.0 * loss) / square;
        let by_speed = (up + down - 2.0 * loss) / square;
        let by_both = ((one + two - 2.0 * loss) / square - by_drop - by_speed) / 2.0;
        let curve = Matrix2::new(by_drop, by_both, by_both, by_speed);
        let inverse = curve.cholesky().map(|cholesky| cholesky.inverse());
        // Without a bottom near by: straight down.
        let newton = inverse.map_or(slope * -1e6, |inverse| -(inverse * slope));
        let step = newton * (FARTHEST / newton.norm()).min(1.0);
        let best = looks.iter().min_by(|a, b| a.0.total_cmp(&b.0));
        place += step;
        // By how much the loss is less there: the last step is as good as a look at it.
        let gain = -0.5 * slope.dot(&step);
        if inverse.is_none() || gain > CLOSE {
            at = best.map_or(at, |best| best.1);
            continue;
        }
        // The loss is twice the negative logarithm of the likelihood.
        let covariance = inverse? * 2.0;
        let falling = falling(place);
        let [drop, speed] = [0, 1].map(|i| covariance[(i, i)].sqrt());
        let slopes = SMatrix::<f64, COUNT, 2>::from_fn(|i, j| {
            let is_own = i / PER_JOINT == joint;
            let [more, less] = [looks[2 * j].1[i], looks[2 * j + 1].1[i]];
            if is_own {
                (more - less) / (2.0 * STEP)
            } else {
                0.0
            }
        });
        let stribeck = Stribeck {
            drop_nm: falling.drop_nm,
            drop_error_nm: falling.drop_nm * drop,
            speed_rad_s: falling.speed_rad_s,
            speed_error_rad_s: falling.speed_rad_s * speed,
        };
        return (SURE * drop < 1.0 && speed < VAGUE).then(|| Sought {
            stribeck,
            own: core::array::from_fn(|i| {
                let i = joint * PER_JOINT + i;
                at[i] + (slopes.row(i) * step)[0]
            }),
            covariance: slopes * covariance * slopes.transpose(),
        });
    }
    None
}

/// The curve of these logarithms of drop and speed.
fn falling(logarithms: Vector2<f64>) -> Falling {
    let [drop_nm, speed_rad_s] = logarithms.map(f64::exp).into();
    Falling {
        drop_nm,
        speed_rad_s,
    }
}

impl Known {
    /// With dry friction that falls as it was found to.
    #[must_use]
    pub(super) fn with(&self, found: &[Option<Stribeck>; JOINTS]) -> Self {
        Self {
            falling: found.map(|stribeck| stribeck.map(|of| of.falling())),
            ..*self
        }
    }
}
