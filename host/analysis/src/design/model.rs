//! Arm, estimator and gain about upright as one linear system.
//!
//! The state s is the arm's [q1, q2, dq1, dq2], followed by up to four states of each joint's
//! estimator and the torque of each joint's integral action. With v the torque that acts and u
//! the requested torque,
//!
//! ```text
//! s(k+1) = open s(k) + input v(k)        u(k) = -output s(k)
//! ```
//!
//! u(k) is computed in tick k-1 from the estimator's prediction for tick k, which is
//! the first half of its states. The estimator's input is u; so `open` contains it, and the
//! loop is broken at the torque alone. In the closed loop, v = u.

use armbridge_control::arm::{Discrete, Linear, Parameters};
use armbridge_control::controller::{IntegralAction, Lqr, Weights};
use armbridge_control::estimate::{Config, Estimator, Kalman, Tuning};
use armbridge_link::message::{Controller, Gains, Refusal, Setup};
use armbridge_servo::JOINTS;
use nalgebra::{Matrix2, Matrix2x4, Matrix4, SMatrix, Vector2, Vector3, Vector4};

/// Dimension of the state.
pub(super) const STATES: usize = INTEGRAL + JOINTS;
/// First state of the integral action.
const INTEGRAL: usize = 4 + JOINTS * MEMORY;
/// Largest dimension of one joint's estimator.
const MEMORY: usize = 4;

pub(super) type Square = SMatrix<f64, STATES, STATES>;
pub(super) type Input = SMatrix<f64, STATES, JOINTS>;
pub(super) type Output = SMatrix<f64, JOINTS, STATES>;

/// The loop, broken at the torque.
#[derive(Clone, Debug)]
pub(super) struct LinearLoop {
    pub(super) period_s: f64,
    pub(super) arm: Linear<f64>,
    pub(super) discrete: Discrete<f64>,
    pub(super) gain: Matrix2x4<f64>,
    pub(super) integral: IntegralAction<f64>,
    pub(super) observers: [Observer; JOINTS],
    pub(super) open: Square,
    pub(super) input: Input,
    pub(super) output: Output,
}

/// One joint's estimator: `m(k+1) = memory m(k) + sample y(k) + torque u(k)`. Its first
/// states are the predicted angle and speed at the next sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Observer {
    pub(super) memory: Matrix4<f64>,
    pub(super) sample: Vector4<f64>,
    pub(super) torque: Vector4<f64>,
    /// Its third state is a disturbance torque, which is subtracted from the torque.
    pub(super) has_disturbance: bool,
    /// Its prediction error is independent of the gain.
    pub(super) is_separate: bool,
}

impl LinearLoop {
    /// Loop of a set-up that a board accepts.
    pub(super) fn from_setup(setup: &Setup) -> Result<Self, Refusal> {
        let period_s = f64::from(setup.period_us) * 1e-6;
        let parameters = setup.arm.map(f64::from);
        let arm = parameters.linearise(Vector2::zeros());
        let discrete = arm.zero_order_hold(period_s);
        let gain = gain(setup, &parameters)?;
        let joints = discrete.joints();
        let inputs = [
            Vector2::new(discrete.b.m11, discrete.b.m31),
            Vector2::new(discrete.b.m22, discrete.b.m42),
        ];
        let observer = |joint: usize| {
            Observer::for_joint(
                setup,
                &parameters,
                period_s,
                joint,
                joints[joint],
                inputs[joint],
            )
        };
        let observers = [observer(0)?, observer(1)?];

        let mut open = Square::zeros();
        let mut input = Input::zeros();
        let mut output = Output::zeros();
        open.fixed_view_mut::<4, 4>(0, 0).copy_from(&discrete.a);
        input
            .fixed_view_mut::<4, JOINTS>(0, 0)
            .copy_from(&discrete.b);
        for (joint, observer) in observers.iter().enumerate() {
            let at = 4 + joint * MEMORY;
            for torque in 0..JOINTS {
                output[(torque, at)] = gain[(torque, joint)];
                output[(torque, at + 1)] = gain[(torque, 2 + joint)];
            }
            if observer.has_disturbance {
                output[(joint, at + 2)] += 1.0;
            }
            // u = -K x + w, and w grows against the predicted angle.
            if setup.integral[joint] != 0.0 {
                let at_integral = INTEGRAL + joint;
                output[(joint, at_integral)] = -1.0;
                open[(at_integral, at_integral)] = 1.0;
                open[(at_integral, at)] = -f64::from(setup.integral[joint]) * period_s;
            }
        }
        for (joint, observer) in observers.iter().enumerate() {
            let at = 4 + joint * MEMORY;
            open.fixed_view_mut::<4, 4>(at, at)
                .copy_from(&observer.memory);
            open.fixed_view_mut::<4, 1>(at, joint)
                .copy_from(&observer.sample);
            let torque = observer.torque * output.row(joint);
            let mut rows = open.fixed_view_mut::<4, STATES>(at, 0);
            rows -= torque;
        }
        Ok(Self {
            period_s,
            arm,
            discrete,
            gain,
            integral: IntegralAction::new(setup.integral.map(f64::from), period_s),
            observers,
            open,
            input,
            output,
        })
    }

    /// Closed-loop matrix, in which the requested torque acts.
    pub(super) fn closed(&self) -> Square {
        self.with_torque_scaled([1.0; JOINTS])
    }

    /// Closed-loop matrix in which `scale` times the requested torque acts, unknown to the
    /// estimator.
    pub(super) fn with_torque_scaled(&self, scale: [f64; JOINTS]) -> Square {
        let scale = Matrix2::from_diagonal(&scale.into());
        self.open - self.input * scale * self.output
    }

    /// State at rest at angles in rad, with an exact estimate.
    pub(super) fn at_rest(&self, angle_rad: [f64; JOINTS]) -> SMatrix<f64, STATES, 1> {
        let mut state = SMatrix::zeros();
        for (joint, (angle, observer)) in angle_rad.iter().zip(&self.observers).enumerate() {
            state[joint] = *angle;
            let at = 4 + joint * MEMORY;
            state[at] = *angle;
            if !observer.is_separate {
                // The last sample.
                state[at + 3] = *angle;
            }
        }
        state
    }
}

impl Observer {
    fn for_joint(
        setup: &Setup,
        arm: &Parameters<f64>,
        period_s: f64,
        joint: usize,
        a: Matrix2<f64>,
        b: Vector2<f64>,
    ) -> Result<Self, Refusal> {
        match setup.estimator {
            Config::Luenberger { form, poles_45ms } => {
                let poles_45ms = poles_45ms.map(|poles| poles.map(f64::from));
                let config = Config::Luenberger { form, poles_45ms };
                Self::luenberger(&config, arm, period_s, joint, &a, b)
            }
            Config::Gain { form, gain } => {
                let gain = gain.map(|row| row.map(f64::from));
                let config = Config::Gain { form, gain };
                Self::luenberger(&config, arm, period_s, joint, &a, b)
            }
            Config::Kalman(tuning) => {
                let gain =
                    steady_state_gain(arm, period_s, &tuning, joint).ok_or(Refusal::OutOfRange)?;
                let mut step = Matrix4::zeros();
                step.fixed_view_mut::<2, 2>(0, 0).copy_from(&a);
                // A constant disturbance acts like a torque.
                step.fixed_view_mut::<2, 1>(0, 2).copy_from(&b);
                step[(2, 2)] = 1.0;
                let gain = Vector4::new(gain.x, gain.y, gain.z, 0.0);
                Ok(Self::current(&step, gain, b, true))
            }
            Config::FiniteDifference { filter_s } => {
                Ok(Self::difference(&a, b, period_s, f64::from(filter_s)))
            }
        }
    }

    /// Observer with the gains that the board computes.
    fn luenberger(
        config: &Config<f64>,
        arm: &Parameters<f64>,
        period_s: f64,
        joint: usize,
        a: &Matrix2<f64>,
        b: Vector2<f64>,
    ) -> Result<Self, Refusal> {
        let Ok(Estimator::Luenberger(observer)) = config.build(arm, period_s) else {
            return Err(Refusal::OutOfRange);
        };
        let gain = observer.gains()[joint];
        let mut step = Matrix4::zeros();
        step.fixed_view_mut::<2, 2>(0, 0).copy_from(a);
        let gain = Vector4::new(gain.x, gain.y, 0.0, 0.0);
        Ok(Self::current(&step, gain, b, false))
    }

    /// Observer in current form: `m(k+1) = step (m + gain (y - m[0])) + b u`.
    fn current(
        step: &Matrix4<f64>,
        gain: Vector4<f64>,
        b: Vector2<f64>,
        has_disturbance: bool,
    ) -> Self {
        let output = Vector4::new(1.0, 0.0, 0.0, 0.0).transpose();
        Self {
            memory: step * (Matrix4::identity() - gain * output),
            sample: step * gain,
            torque: Vector4::new(b.x, b.y, 0.0, 0.0),
            has_disturbance,
            is_separate: true,
        }
    }

    /// Filtered difference: the states are the prediction, the filtered speed v and the last
    /// sample.
    fn difference(a: &Matrix2<f64>, b: Vector2<f64>, period_s: f64, filter_s: f64) -> Self {
        let weight = if filter_s > 0.0 {
            1.0 - (-period_s / filter_s).exp()
        } else {
            1.0
        };
        // v' = (1 - weight) v + rate (y - last); prediction = A (y, v') + b u.
        let rate = weight / period_s;
        let speed = Vector4::new(0.0, 0.0, 1.0 - weight, -rate);
        let mut memory = Matrix4::zeros();
        memory.set_row(0, &(speed * a.m12).transpose());
        memory.set_row(1, &(speed * a.m22).transpose());
        memory.set_row(2, &speed.transpose());
        Self {
            memory,
            sample: Vector4::new(a.m11 + a.m12 * rate, a.m21 + a.m22 * rate, rate, 1.0),
            torque: Vector4::new(b.x, b.y, 0.0, 0.0),
            has_disturbance: false,
            is_separate: false,
        }
    }
}

/// Gain of the set-up's control law, as the board computes it.
fn gain(setup: &Setup, arm: &Parameters<f64>) -> Result<Matrix2x4<f64>, Refusal> {
    let lqr = match setup.controller {
        Controller::StateFeedback(Gains::Paper) => Lqr::paper(),
        Controller::StateFeedback(Gains::Given([first, second])) => Lqr::of_rows(first, second),
        Controller::StateFeedback(Gains::Design { q, r }) => {
            let period_s = setup.period_us as f32 * 1e-6;
            let upright = setup.arm.linearise(Vector2::zeros());
            let weights = Weights { q, r };
            Lqr::design(&upright.zero_order_hold(period_s), &weights)
                .map_err(|_| Refusal::NoGains)?
        }
        Controller::ComputedTorque {
            natural_rad_s,
            damping,
        } => {
            // M (-kd dq - kp q) + F dq + G(q), where G(q) is its slope times q.
            let upright = Vector2::zeros();
            let (mass, slope) = (arm.mass(upright).diagonal(), arm.gravity_slope(upright));
            let mut gain = Matrix2x4::zeros();
            for (joint, viscous) in [arm.b1, arm.b2].into_iter().enumerate() {
                let natural = f64::from(natural_rad_s[joint]);
                let (kp, kd) = (natural * natural, 2.0 * f64::from(damping[joint]) * natural);
                gain[(joint, joint)] = mass[joint] * kp;
                gain[(joint, 2 + joint)] = mass[joint] * kd - viscous;
            }
            let mut angles = gain.fixed_view_mut::<2, 2>(0, 0);
            angles -= slope;
            return Ok(gain);
        }
    };
    Ok(lqr.gain.map(f64::from))
}

/// Steady-state gain of a sliding joint's filter on angle, speed and disturbance: the
/// filter's own response to a small innovation.
fn steady_state_gain(
    arm: &Parameters<f64>,
    period_s: f64,
    tuning: &Tuning<f32>,
    joint: usize,
) -> Option<Vector3<f64>> {
    /// Time in s, longer than the gain of any reasonable tuning takes to settle.
    const SETTLING_S: f64 = 30.0;
    /// Innovation below every limit, exact in binary.
    const INNOVATION_RAD: f64 = 1.0 / 1_048_576.0;

    let tuning = Tuning {
        angle_rad: f64::from(tuning.angle_rad),
        acceleration: f64::from(tuning.acceleration),
        disturbance: f64::from(tuning.disturbance),
        coulomb_nm: 0.0,
        slide_rad_s: f64::from(tuning.slide_rad_s),
    };
    let filter = Estimator::Kalman(Kalman::new(arm, period_s, &tuning)?);
    let mut estimate = filter.at_rest(Vector2::zeros());
    for _ in 0..(SETTLING_S / period_s) as u32 {
        filter.correct(&mut estimate, [Some(0.0); JOINTS]);
        filter.advance(arm, &mut estimate, Vector2::zeros());
    }
    let state = filter.correct(&mut estimate, [Some(INNOVATION_RAD); JOINTS]);
    let correction = Vector3::new(
        state.q[joint],
        state.dq[joint],
        estimate.disturbance()[joint],
    );
    Some(correction / INNOVATION_RAD)
}

/// Spectral radius: the asymptotic growth of a state per period.
pub(super) fn spectral_radius(a: &Square) -> f64 {
    /// 2^40 periods, after which the initial transient is negligible.
    const SQUARINGS: i32 = 40;

    // ln |A^n| / n for n = 1, 2, 4, ..., the norm taken out at each step.
    let mut power = *a;
    let (mut logarithm, mut weight) = (0.0, 1.0);
    for _ in 0..SQUARINGS {
        let norm = power.norm();
        if norm <= 0.0 || !norm.is_finite() {
            return norm;
        }
        logarithm += weight * norm.ln();
        power /= norm;
        power *= power;
        weight *= 0.5;
    }
    logarithm.exp()
}
