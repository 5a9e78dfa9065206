//! Judge of the true arm: contact with the table and the stops, and its distance from where it
//! should be.
//!
//! # Contact
//!
//! No joint may reach a stop of its own while its motor is on, nor may its motor press it against
//! one with more than [`PRESS_NM`] for more than [`PRESS_US`]. This holds whatever drives: a
//! torque or an experiment has no reference to be far from, and may take the arm anywhere but
//! through the table. With torque off an arm falls;
//! how fast it may then meet the table follows from its energy: it can have no more than at
//! rest in the worst admissible posture, which is upright, for gravity alone drives it down
//! from there. So an arm that meets a stop with more energy than that was thrown. The bound
//! is computed once, from the plant without friction, and compared with the kinetic and
//! potential energy at each impact.
//!
//! A hand may lead an arm that floats to a stop, and one whose encoder drifts sinks there as if a
//! hand led it: the board cannot tell the two apart. So this arm may be lowered onto a stop, with a
//! torque away from it, at [`LOWERED_RAD_S`] at most; the report has the speed of the contact. An
//! arm that is parked may be, at [`PARKED_RAD_S`].
//!
//! # Distance
//!
//! While a reference drives the motors, no joint may be further than [`FAR_RAD`] from it for
//! more than [`FAR_US`]. The motor check may move no joint by more than [`CHECK_RAD`]: no
//! motion has been commanded then.
//!
//! # Rest
//!
//! An arm that floats has no reference, and a hand may take it anywhere. But before a hand, a push
//! or a fault comes, it stays: from [`WEIGHED_US`] on no joint may be further from where it was
//! then than [`SHAKE_RAD`], or [`PROOF_RAD`], and [`DRIFT_RAD_S`] for each second.
//!
//! # Exempt
//!
//! Pushes, which overpower the motors, so that contact and distance are only harm that must have a
//! name ([`Outcome::is_harmed`]); clients of the transparent port, a second master and
//! obstacles, for which contact is what was asked for; and the time in which a servo cannot
//! be reached, with what follows from it within [`AFTERMATH_US`]: a servo keeps its last
//! command.

use armbridge_link::message::{Drive, Mode, Record};
use armbridge_servo::JOINTS;

use super::case::Case;
use super::fixture::Fixture;
use super::kind::Kind;
use super::outcome::Outcome;
use crate::plant::Impact;

/// Distance from the reference, in rad, at which the arm is elsewhere.
const FAR_RAD: f64 = 0.5;
/// Longest time for which it may be, in µs.
const FAR_US: u64 = 50_000;
/// Torque in N m beyond dry friction, and the time in µs for which a motor may have it against a
/// stop: a command that was right before an impact is replaced by then.
const PRESS_NM: f64 = 0.06;
const PRESS_US: u64 = 50_000;
/// Distance in rad for which an arm whose motors are checked needs room.
const CHECK_RAD: f64 = 0.15;
/// Time in µs after which an arm that floats has been weighed.
const WEIGHED_US: u64 = 1_500_000;
/// Distance in rad by which noise may move such an arm, three counts, and its drift in rad/s: two
/// counts a second.
const SHAKE_RAD: f64 = 0.015;
const DRIFT_RAD_S: f64 = 0.01;
/// The distance where an encoder without noise has to prove itself: at 5 ms a joint has moved by up
/// to seven counts before the ramps end.
const PROOF_RAD: f64 = 0.04;
/// Largest speed in rad/s at which an arm that floats may be lowered onto a stop: it is braked
/// beyond.
const LOWERED_RAD_S: f64 = 1.5;
/// The same of an arm that is parked.
const PARKED_RAD_S: f64 = 0.3;
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
    /// Least and largest angle of each joint in rad, and since when it is pressed there, in µs.
    stops_rad: [[f64; 2]; JOINTS],
    pressed_since_us: [Option<u64>; JOINTS],
    /// Angles in rad at which the motor check began.
    check_rad: Option<[f64; JOINTS]>,
    /// Time in µs since when the arm floats, and its angles in rad once it has been weighed.
    floats_since_us: Option<u64>,
    rest_rad: Option<[f64; JOINTS]>,
    shake_rad: f64,
    /// Contact was asked for.
    is_contact_meant: bool,
    /// The arm is pushed.
    is_pushed: bool,
}

impl Truth {
    pub(super) fn new(case: &Case, fixture: &Fixture<'_>) -> Self {
        let is_handed_over = case.has_client() || case.has(Kind::SecondMaster);
        Self {
            most_j: fixture.cosim.bench.plant().energy_at_rest([0.0; JOINTS]),
            checked_us: 0,
            record: None,
            far_since_us: None,
            stops_rad: case.plant().stops_rad,
            pressed_since_us: [None; JOINTS],
            check_rad: None,
            floats_since_us: None,
            rest_rad: None,
            shake_rad: if case.noise_counts > 0.0 {
                SHAKE_RAD
            } else {
                PROOF_RAD
            },
            is_contact_meant: case.is_obstructed || is_handed_over,
            is_pushed: case.has(Kind::Push),
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
        let q = fixture.state().q.into();
        self.check_contact(fixture, outcome, now_us);
        self.check_pressure(fixture, outcome, now_us, q);
        self.check_distance(fixture, outcome, now_us, q);
        self.check_motor_check(fixture, outcome, q);
        self.check_rest(fixture, outcome, now_us, q);
    }

    /// Notes harm to the arm, which violates a requirement unless a push did it: one that
    /// overpowers the motors takes the arm anywhere.
    fn harm(&self, outcome: &mut Outcome, why: String) {
        if !self.is_pushed {
            outcome.is_harmed = true;
            outcome.fail(why);
        }
    }

    /// Whether contact now says nothing about the board.
    fn is_contact_excused(&self, fixture: &Fixture<'_>, now_us: u64) -> bool {
        self.is_contact_meant || fixture.reach.is_cut_off(now_us, AFTERMATH_US)
    }

    fn check_contact(&self, fixture: &mut Fixture<'_>, outcome: &mut Outcome, now_us: u64) {
        let Some(impact) = fixture.take_impact() else {
            return;
        };
        if self.is_contact_excused(fixture, now_us) || impact.speed_rad_s < TOUCH_RAD_S {
            return;
        }
        if !self.is_pushed {
            outcome.contact_rad_s = outcome.contact_rad_s.max(impact.speed_rad_s);
        }
        if fixture.is_on(impact.joint) && !self.is_lowered(fixture, impact) {
            let why = format!(
                "joint {} was driven against its stop, at {:.1} rad/s",
                impact.joint, impact.speed_rad_s
            );
            self.harm(outcome, why);
        } else if !self.is_pushed && impact.energy_j > self.most_j * ENERGY_TOLERANCE {
            outcome.fail(format!(
                "the arm was thrown: joint {} met its stop at {:.1} rad/s with {:.3} J, {:.3} J \
                 from rest",
                impact.joint, impact.speed_rad_s, impact.energy_j, self.most_j
            ));
        }
    }

    /// Whether this is an arm that floats or is parked, whose motor carried it as it touched its
    /// stop.
    fn is_lowered(&self, fixture: &mut Fixture<'_>, impact: Impact) -> bool {
        let [lowest, highest] = self.stops_rad[impact.joint];
        let q = fixture.state().q[impact.joint];
        let towards_nm = fixture.cosim.bench.plant().torque()[impact.joint]
            * (q - f64::midpoint(lowest, highest)).signum();
        let most_rad_s = match fixture.mode().drive() {
            Some(Drive::Float) => LOWERED_RAD_S,
            Some(Drive::Park) => PARKED_RAD_S,
            _ => return false,
        };
        towards_nm <= 0.0 && impact.speed_rad_s <= most_rad_s
    }

    fn check_pressure(
        &mut self,
        fixture: &Fixture<'_>,
        outcome: &mut Outcome,
        now_us: u64,
        q: [f64; JOINTS],
    ) {
        let torque_nm = fixture.cosim.bench.plant().torque();
        let is_excused = self.is_contact_excused(fixture, now_us);
        for joint in 0..JOINTS {
            let [lowest, highest] = self.stops_rad[joint];
            let is_pressed = (q[joint] <= lowest && torque_nm[joint] < -PRESS_NM)
                || (q[joint] >= highest && torque_nm[joint] > PRESS_NM);
            if !is_pressed || is_excused {
                self.pressed_since_us[joint] = None;
                continue;
            }
            let since_us = *self.pressed_since_us[joint].get_or_insert(now_us);
            if now_us - since_us > PRESS_US {
                self.harm(
                    outcome,
                    format!("joint {joint} was pressed against its stop"),
                );
            }
        }
    }

    fn check_motor_check(
        &mut self,
        fixture: &Fixture<'_>,
        outcome: &mut Outcome,
        q: [f64; JOINTS],
    ) {
        if fixture.mode() != Mode::MotorCheck || fixture.is_down() {
            self.check_rad = None;
            return;
        }
        let start_rad = *self.check_rad.get_or_insert(q);
        if (0..JOINTS).any(|joint| (q[joint] - start_rad[joint]).abs() > CHECK_RAD) {
            self.harm(
                outcome,
                format!("the motor check moved the arm by {CHECK_RAD} rad"),
            );
        }
    }

    fn check_rest(
        &mut self,
        fixture: &Fixture<'_>,
        outcome: &mut Outcome,
        now_us: u64,
        q: [f64; JOINTS],
    ) {
        let is_floating = fixture.mode().drive() == Some(Drive::Float);
        if !is_floating || !fixture.is_undisturbed() {
            (self.floats_since_us, self.rest_rad) = (None, None);
            return;
        }
        let weighed_us = *self.floats_since_us.get_or_insert(now_us) + WEIGHED_US;
        if now_us < weighed_us {
            return;
        }
        let rest_rad = *self.rest_rad.get_or_insert(q);
        let allowed_rad = self.shake_rad + DRIFT_RAD_S * (now_us - weighed_us) as f64 * 1e-6;
        for joint in 0..JOINTS {
            let moved_rad = (q[joint] - rest_rad[joint]).abs();
            if moved_rad > allowed_rad {
                self.harm(outcome, format!("joint {joint} floated away"));
            }
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
            Some(record) if is_driven => {
                let far_rad =
                    |joint: usize| (q[joint] - f64::from(record.output.reference_rad[joint])).abs();
                (0..JOINTS).map(far_rad).fold(0.0, f64::max)
            }
            _ => 0.0,
        };
        if far_rad <= FAR_RAD {
            self.far_since_us = None;
            return;
        }
        let since_us = *self.far_since_us.get_or_insert(now_us);
        if !self.is_pushed {
            outcome.far_ms = outcome.far_ms.max((now_us - since_us) as f64 * 1e-3);
        }
        if now_us - since_us > FAR_US {
            let why = format!("the arm was driven {FAR_RAD} rad from its reference");
            self.harm(outcome, why);
        }
    }
}
