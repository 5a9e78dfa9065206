//! Judge of the true arm: contact with the table and the stops, and its distance from the
//! reference.
//!
//! # Contact
//!
//! No joint may reach a stop of its own while its motor is on. With torque off an arm falls;
//! how fast it may then meet the table follows from its energy: it can have no more than at
//! rest in the worst admissible posture, which is upright, for gravity alone drives it down
//! from there. So an arm that meets a stop with more energy than that was thrown. The bound
//! is computed once, from the plant without friction, and compared with the kinetic and
//! potential energy at each impact.
//!
//! # Distance
//!
//! While a reference drives the motors, no joint may be further than [`FAR_RAD`] from it for
//! more than [`FAR_US`].
//!
//! # Exempt
//!
//! Pushes, which overpower the motors; clients of the transparent port, a second master and
//! obstacles, for which contact is what was asked for; and the time in which a servo cannot
//! be reached, with what follows from it within [`AFTERMATH_US`]: a servo keeps its last
//! command.

use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Drive, Record};

use super::activity::Activity;
use super::case::Case;
use super::fixture::Fixture;
use super::kind::Kind;
use super::outcome::Outcome;

/// Distance from the reference, in rad, at which the arm is elsewhere.
const FAR_RAD: f64 = 0.5;
/// Longest time for which it may be, in µs.
const FAR_US: u64 = 50_000;
/// Time in µs after which nothing follows any more from a servo that could not be reached.
const AFTERMATH_US: u64 = 2_000_000;
/// Share by which an energy may exceed its bound: the integration's error.
const ENERGY_TOLERANCE: f64 = 1.001;
/// Period of the comparison in µs; impacts are found at any time.
const CHECK_US: u64 = 500;
/// Speed in rad/s at which a joint comes to a stop without an impact worth the name.
const TOUCH_RAD_S: f64 = 0.01;

/// See the [module](self).
#[derive(Debug)]
pub(super) struct Truth {
    /// Energy in J of the arm at rest upright.
    most_j: f64,
    checked_us: u64,
    record: Option<Record>,
    /// Since when the arm is far from its reference.
    far_since_us: Option<u64>,
    /// Contact is judged, and so is the distance.
    judges_contact: bool,
    judges_distance: bool,
}

impl Truth {
    pub(super) fn new(case: &Case, fixture: &Fixture<'_>) -> Self {
        let is_handed_over = case.activity == Activity::Port
            || case.injections.iter().any(|it| it.kind.has_client())
            || case.has(Kind::SecondMaster);
        Self {
            most_j: fixture.cosim.bench.plant().energy_at_rest([0.0; JOINTS]),
            checked_us: 0,
            record: None,
            far_since_us: None,
            judges_contact: !case.has(Kind::Push) && !case.is_obstructed && !is_handed_over,
            judges_distance: !case.has(Kind::Push),
        }
    }

    /// Compares the arm with what it may do.
    pub(super) fn observe(&mut self, fixture: &mut Fixture<'_>, outcome: &mut Outcome) {
        let now_us = fixture.now_us();
        if let Some(record) = fixture.cosim.board.take_record() {
            self.record = Some(record);
        }
        if now_us < self.checked_us + CHECK_US {
            return;
        }
        self.checked_us = now_us;
        let q = fixture.state().q;
        self.check_contact(fixture, outcome, now_us);
        self.check_distance(fixture, outcome, now_us, [q.x, q.y]);
    }

    fn check_contact(&self, fixture: &mut Fixture<'_>, outcome: &mut Outcome, now_us: u64) {
        let Some(impact) = fixture.take_impact() else {
            return;
        };
        let is_excused = !self.judges_contact || fixture.reach.is_cut_off(now_us, AFTERMATH_US);
        if is_excused || impact.speed_rad_s < TOUCH_RAD_S {
            return;
        }
        outcome.contact_rad_s = outcome.contact_rad_s.max(impact.speed_rad_s);
        if fixture.is_on(impact.joint) {
            outcome.fail(format!(
                "joint {} was driven against its stop, at {:.1} rad/s",
                impact.joint, impact.speed_rad_s
            ));
        } else if impact.energy_j > self.most_j * ENERGY_TOLERANCE {
            outcome.fail(format!(
                "the arm was thrown: joint {} met its stop at {:.1} rad/s with {:.3} J, {:.3} J \
                 from rest",
                impact.joint, impact.speed_rad_s, impact.energy_j, self.most_j
            ));
        }
    }

    fn check_distance(
        &mut self,
        fixture: &Fixture<'_>,
        outcome: &mut Outcome,
        now_us: u64,
        q: [f64; JOINTS],
    ) {
        let is_referred = |drive| matches!(drive, Drive::Regulate | Drive::Track | Drive::Hold);
        let is_driven =
            fixture.mode().drive().is_some_and(is_referred) && !fixture.cosim.board.is_down();
        let far_rad = match self.record {
            Some(record) if is_driven && self.judges_distance => {
                let far_rad =
                    |joint: usize| (q[joint] - f64::from(record.reference_rad[joint])).abs();
                (0..JOINTS).map(far_rad).fold(0.0, f64::max)
            }
            _ => 0.0,
        };
        if far_rad <= FAR_RAD {
            self.far_since_us = None;
            return;
        }
        let since_us = *self.far_since_us.get_or_insert(now_us);
        outcome.far_ms = outcome.far_ms.max((now_us - since_us) as f64 * 1e-3);
        if now_us - since_us > FAR_US {
            outcome.fail(format!(
                "the arm was driven {FAR_RAD} rad from its reference"
            ));
        }
    }
}
