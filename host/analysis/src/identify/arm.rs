//! Model of the arm in identifiable parameters, and the dynamics of its joints.
//!
//! Equations (1) to (4) of the paper, as in [`armbridge_control::arm`], in base
//! parameters: the combinations of masses, lengths and inertias that the motion depends on.
//! `J` and `g` of each joint are estimated; the geometry, measured by ruler, enters only in
//! terms that are small beside them:
//!
//! ```text
//! M11 = J1 + P cos q2 + E cos² q2      P = 2 L1 g2 / g
//! M22 = J2                             E = (L2 / (2 g) + s) g2, s = (I2x - I2z) / g2
//! G1  = -(g1 + g2 cos q2) sin q1        of an arm that stands; one that hangs
//! G2  = -g2 cos q1 sin q2               has both the other way round
//! ```
//!
//! Dry friction of a joint may grow with the torque that its gears transmit, as in the simulator:
//!
//! ```text
//! gears = |motor - F dq + G(q)|
//! ```
//!
//! The equations are generic over dual numbers, so that a motion carries its derivatives by
//! all parameters.

use armbridge_control::actuator::Direction;
use armbridge_control::arm::Mounting;
use armbridge_link::message::Setup;
use armbridge_servo::JOINTS;
use num_dual::DualNum;

use super::quantity::{COUNT, PER_JOINT, Quantity};
use super::stribeck_curve::StribeckCurve;

/// Parameters that are not estimated: geometry, measured by ruler, directions and timing of
/// the servos, and the forms of dry friction beside Coulomb's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownParameters {
    /// Number of joints, 1 or 2. The parameters of a joint that the arm does not have stay at their prior.
    pub joints: usize,
    /// Length from joint 1 to joint 2 in m.
    pub l1_m: f64,
    /// Length from joint 2 to the end in m.
    pub l2_m: f64,
    /// Gravitational acceleration in m/s².
    pub g_m_s2: f64,
    /// Whether the arm stands or hangs.
    pub mounting: Mounting,
    /// I2x - I2z in kg m² per N m of link 2's gravity torque: both grow with the weight of
    /// the link.
    pub i2_difference_s2: f64,
    /// Angle of an encoder count in rad; negative where counts fall with the angle.
    pub rad_per_count: [f64; JOINTS],
    /// Time in s from the arrival of a joint's PWM in the servo to the sample of its tick's
    /// angle; with 0 the delay is that from the angle to the torque.
    pub lead_s: [f64; JOINTS],
    /// Tick period in s.
    pub period_s: f64,
    /// Stribeck curve of each joint, if it has one; fitted apart from the other parameters.
    pub stribeck: [Option<StribeckCurve>; JOINTS],
    /// Dry friction of each joint in N m per N m that its gears transmit; 0 without, and fitted
    /// apart as well.
    pub load: [f64; JOINTS],
}

impl KnownParameters {
    /// The known parameters of a set-up.
    pub fn from_setup(setup: &Setup) -> Self {
        let arm = &setup.arm;
        // A link without weight has a negligible inertia about its own axes as well.
        let link_nm = Quantity::Gravity.nominal(setup, 1).max(1e-3);
        Self {
            joints: arm.joints(),
            l1_m: arm.l1.into(),
            l2_m: arm.l2.into(),
            g_m_s2: arm.g.into(),
            mounting: arm.mounting,
            i2_difference_s2: (f64::from(arm.i2x) - f64::from(arm.i2z)) / link_nm,
            rad_per_count: setup.joints.map(|joint| match joint.direction {
                Direction::Forward => f64::from(joint.rad_per_count),
                Direction::Reverse => -f64::from(joint.rad_per_count),
            }),
            lead_s: [0.0; JOINTS],
            period_s: f64::from(setup.period_us) * 1e-6,
            stribeck: [None; JOINTS],
            load: [0.0; JOINTS],
        }
    }
}

impl KnownParameters {
    /// Sign of the gravity torques: 1 if the arm stands, -1 if it hangs.
    pub(super) fn gravity_sign(&self) -> f64 {
        match self.mounting {
            Mounting::Upright => 1.0,
            Mounting::Hanging => -1.0,
        }
    }

    /// Coupling terms P and E, for this gravity torque of link 2.
    pub(super) fn coupling<D: DualNum<Primitive = f64> + Copy>(&self, link: D) -> [D; 2] {
        [
            link * (2.0 * self.l1_m / self.g_m_s2),
            link * (0.5 * self.l2_m / self.g_m_s2 + self.i2_difference_s2),
        ]
    }
}

/// Width in counts of the smooth edge of a dead zone.
const EDGE_COUNTS: f64 = 3.0;

/// Dynamics of a joint, over dual numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointModel<D> {
    /// Joint, from 0.
    index: usize,
    inertia: D,
    gravity: D,
    viscous: D,
    coulomb: D,
    stribeck: Option<StribeckCurve>,
    load: f64,
    gain: D,
    offset: D,
    dead: [D; 2],
    zero: D,
    delay: D,
    /// Gravity torque of link 2.
    link: D,
    /// 1 if the arm stands, -1 if it hangs.
    gravity_sign: f64,
    /// Coupling terms P and E.
    coupling: [D; 2],
    /// Angle of a count in rad, with its sign.
    rad_per_count: f64,
}

impl<D: DualNum<Primitive = f64> + Copy> JointModel<D> {
    /// A joint of the arm with these coordinates.
    pub(super) fn from_coordinates(
        known: &KnownParameters,
        coordinates: &[D; COUNT],
        index: usize,
    ) -> Self {
        let own = core::array::from_fn(|i| coordinates[index * PER_JOINT + i]);
        Self::new(known, index, &own, coordinates[Quantity::Gravity.index(1)])
    }

    /// Delay in ticks from the sample of a tick's angle to the torque of its PWM.
    pub(super) fn delay_ticks(&self, known: &KnownParameters) -> D {
        (self.delay - known.lead_s[self.index]) / known.period_s
    }

    /// A joint with these coordinates; `link` is the coordinate of joint 2's gravity.
    pub(super) fn new(
        known: &KnownParameters,
        index: usize,
        coordinates: &[D; PER_JOINT],
        link: D,
    ) -> Self {
        let value = |quantity: Quantity| quantity.value(coordinates[quantity as usize]);
        let link = Quantity::Gravity.value(link);
        Self {
            index,
            inertia: value(Quantity::Inertia),
            gravity: value(Quantity::Gravity),
            viscous: value(Quantity::Viscous),
            coulomb: value(Quantity::Coulomb),
            stribeck: known.stribeck[index],
            load: known.load[index],
            gain: value(Quantity::Gain),
            offset: value(Quantity::Offset),
            dead: [value(Quantity::DeadBelow), value(Quantity::DeadAbove)],
            zero: value(Quantity::Zero),
            delay: value(Quantity::Delay),
            link,
            gravity_sign: known.gravity_sign(),
            coupling: known.coupling(link),
            rad_per_count: known.rad_per_count[index],
        }
    }

    /// Motor torque in N m of a PWM, equation (5) with its dead zone. The edge lies half a
    /// count beyond the last count without torque; here the torque rises over
    /// [`EDGE_COUNTS`] about it, symmetrically, so that it has a derivative by the edge.
    pub(super) fn motor_torque(&self, pwm: u16) -> D {
        let counts = f64::from(pwm) - 1000.0;
        let [below, above] = self.dead;
        let edge = if counts < 0.0 { below } else { above };
        let rise = (-edge + (counts.abs() - 0.5)) / EDGE_COUNTS + 0.5;
        let torque = (-self.offset + counts) / self.gain * self.rad_per_count.signum();
        match rise.re() {
            _ if counts == 0.0 => D::from(0.0),
            value if value <= 0.0 => D::from(0.0),
            value if value < 1.0 => torque * rise * rise * (-rise * 2.0 + 3.0),
            _ => torque,
        }
    }

    /// Magnitude of dry friction at a speed in N m, without that of the load on the gears.
    pub(super) fn dry_friction(&self, v: D) -> D {
        match self.stribeck {
            Some(curve) => self.coulomb + curve.excess_nm(v),
            None => self.coulomb,
        }
    }

    /// Magnitude of the dry friction of the load on the gears in N m, under this torque of the
    /// motor; `other` is the other joint's angle and speed.
    pub(super) fn load_friction(&self, q: D, v: D, other: [f64; 2], motor: D) -> D {
        if self.load == 0.0 {
            return D::from(0.0);
        }
        self.gear_torque(q, v, other, motor) * self.load
    }

    /// Magnitude of the torque in N m that the gears transmit: the motor's, less what it loses
    /// with speed, and that of the weight upon it.
    pub(super) fn gear_torque(&self, q: D, v: D, other: [f64; 2], motor: D) -> D {
        let sin = q.sin();
        let weight = if self.index == 0 {
            sin * (self.gravity + self.link * other[0].cos()) * self.gravity_sign
        } else {
            self.gravity * sin * (other[0].cos() * self.gravity_sign)
        };
        let torque = motor - self.viscous * v - weight;
        if torque.re() < 0.0 { -torque } else { torque }
    }

    /// Encoder position in counts at an angle.
    pub(super) fn position(&self, angle_rad: D) -> D {
        self.zero + angle_rad / self.rad_per_count
    }

    /// Angle in rad at an encoder position in counts.
    pub(super) fn angle(&self, position: D) -> D {
        (position - self.zero) * self.rad_per_count
    }

    /// Torque in N m of gravity, coupling and viscous friction (without motor and dry
    /// friction), and effective inertia in kg m²; `other` is the other joint's angle and
    /// speed.
    pub(super) fn passive_dynamics(&self, q: D, v: D, other: [f64; 2]) -> (D, D) {
        let [p, e] = self.coupling;
        let (sin, cos) = q.sin_cos();
        if self.index == 0 {
            let (sin2, cos2) = other[0].sin_cos();
            let h = (e * (2.0 * cos2) + p) * sin2;
            let torque = h * v * other[1] - self.viscous * v
                + sin * (self.gravity + self.link * cos2) * self.gravity_sign;
            (torque, self.inertia + (e * cos2 + p) * cos2)
        } else {
            let h = sin * (cos * e * 2.0 + p);
            let torque = self.gravity * sin * (other[0].cos() * self.gravity_sign)
                - h * (0.5 * other[1] * other[1])
                - self.viscous * v;
            (torque, self.inertia)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use armbridge_control::arm::{Parameters, State};
    use nalgebra::Vector2;
    use num_dual::{DualSVec64, DualStruct};

    fn coordinates(setup: &Setup, joint: usize) -> [f64; PER_JOINT] {
        Quantity::ALL.map(|quantity| quantity.coordinate(quantity.nominal(setup, joint)))
    }

    #[test]
    fn base_parameters_move_as_the_arm_does() {
        for mounting in [Mounting::Upright, Mounting::Hanging] {
            let mut setup = Setup::default();
            setup.arm.mounting = mounting;
            let (known, arm) = (
                KnownParameters::from_setup(&setup),
                setup.arm.map(f64::from),
            );
            let link = coordinates(&setup, 1)[Quantity::Gravity as usize];
            for i in 0..100 {
                let at = f64::from(i);
                let state = State {
                    q: Vector2::new(at.sin() * 3.0, (1.7 * at).cos() * 3.0),
                    dq: Vector2::new((0.3 * at).cos() * 5.0, (0.9 * at).sin() * 5.0),
                };
                let torque = Vector2::new((2.3 * at).sin(), (0.6 * at).cos());
                let expected = arm.acceleration(&state, torque);
                for joint in 0..JOINTS {
                    let model = JointModel::new(&known, joint, &coordinates(&setup, joint), link);
                    let other = [state.q[1 - joint], state.dq[1 - joint]];
                    let (passive, inertia) =
                        model.passive_dynamics(state.q[joint], state.dq[joint], other);
                    let off = (passive + torque[joint]) / inertia - expected[joint];
                    assert!(off.abs() < 1e-9, "{mounting:?}, joint {joint}: {off:e}");
                }
            }
        }
    }

    #[test]
    fn a_motor_makes_the_torque_of_its_actuator_beyond_its_dead_zone() {
        let mut setup = Setup::default();
        setup.joints[1].direction = Direction::Reverse;
        let (known, arm) = (
            KnownParameters::from_setup(&setup),
            Parameters::<f64>::paper(),
        );
        assert_eq!(arm.mounting, known.mounting);
        for joint in 0..JOINTS {
            let mut at = coordinates(&setup, joint);
            at[Quantity::DeadBelow as usize] = Quantity::DeadBelow.coordinate(10.0);
            at[Quantity::DeadAbove as usize] = Quantity::DeadAbove.coordinate(20.0);
            let duals =
                core::array::from_fn(|i| DualSVec64::<PER_JOINT>::from_re(at[i]).derivative(i));
            let model = JointModel::new(&known, joint, &duals, duals[Quantity::Gravity as usize]);
            let servo = armbridge_control::actuator::Joint::<f64> {
                direction: setup.joints[joint].direction,
                ..armbridge_control::actuator::Joint::paper()
            };
            for counts in [0, 900, 988, 1022, 1300, 2000] {
                let torque = model.motor_torque(counts);
                let expected = servo.torque(armbridge_servo::Pwm::saturating(counts));
                assert!((torque.re() - expected).abs() < 1e-9, "{counts}");
            }
            for counts in [991, 1000, 1019] {
                assert!(model.motor_torque(counts).re().abs() <= 0.0, "{counts}");
            }
        }
    }
}
