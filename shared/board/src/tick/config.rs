//! Loop configuration: all parameters of a tick; no tick changes them.
//!
//! Its construction includes a Riccati solution, too long for a tick. The link's side
//! builds the configuration, and the control loop takes the result as a whole.
//!
//! # Memory faults
//!
//! A configuration lies in RAM for hours. A bit that turns there, by a fault of
//! the memory or of the program, changes the torque without a command.
//! Each part of it carries a [`CheckWord`], taken where the part was built;
//! [`LoopConfig::check_section`] compares one in a tick, so that all are compared
//! within [`CHECK_US`].

mod design;

use core::num::NonZeroU32;
use nalgebra::Vector2;

use super::limits::{PERIOD_MAX_US, PERIOD_MIN_US};
use super::monitors::MonitorConfig;
use armbridge_control::actuator::Joint;
use armbridge_control::arm::Parameters;
use armbridge_control::check_word::{CheckWord, Checked};
use armbridge_control::controller::{Controller, DryFriction, Float, IntegralAction};
use armbridge_control::design::stability::Eigenvalue;
use armbridge_control::encoder::Encoder;
use armbridge_control::estimate::{self, Config, Estimator};
use armbridge_link::limits::Limits;
use armbridge_link::message::{FRICTION_LOAD_PERCENT_MAX, Refusal, Settings, Setup};
use armbridge_servo::{ControlMode, JOINTS};

/// Time constant in s of the fading torque offset: slow beside the loop's own 50 ms,
/// so that the disturbance is small, and over within half a second.
const FADE_S: f32 = 0.1;

/// Time in which every part of the configuration is compared with its check word.
/// With the stop that follows, torque is off within 20 ms.
pub const CHECK_US: u32 = 8_000;

/// Parts of the configuration that are compared one at a time.
const SECTIONS: u32 = 4;

/// Whether a board can run with these settings: every limit is within its hard
/// bound, and there is a controller for the set-up.
pub fn can_run(settings: &Settings) -> bool {
    settings_refusal(settings).is_none()
}

/// The refusal of these settings by a board; `None` if it accepts them.
///
/// ```
/// use armbridge_board::tick::settings_refusal;
/// use armbridge_link::message::{Controller, Gains, Refusal, Settings};
///
/// let mut settings = Settings::default();
/// assert_eq!(settings_refusal(&settings), None);
///
/// settings.setup.controller = Controller::StateFeedback(Gains::Given([[0.0; 4]; 2]));
/// let refusal = settings_refusal(&settings);
/// assert!(matches!(refusal, Some(Refusal::Unstable { re, .. }) if re > 1.0));
///
/// settings = Settings::default();
/// settings.limits.angle_rad[0] = 2.0;
/// assert_eq!(settings_refusal(&settings), Some(Refusal::OutOfRange));
/// ```
pub fn settings_refusal(settings: &Settings) -> Option<Refusal> {
    LoopConfig::build(settings).err()
}

/// All parameters of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopConfig {
    pub(super) control: ControlConfig,
    pub(super) monitors: MonitorConfig,
    monitors_check: CheckWord,
}

/// Estimator, controller and actuators for one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlConfig {
    period_us: NonZeroU32,
    pub(super) arm: Parameters<f32>,
    /// Number of joints, that of `arm`.
    pub(super) joint_count: usize,
    pub(super) joints: [Joint<f32>; JOINTS],
    /// What commands are.
    mode: ControlMode,
    pub(super) estimator: Estimator<f32>,
    /// Whether the estimator's model has dry friction and so gets the whole torque.
    pub(super) knows_friction: bool,
    pub(super) controller: Controller<f32>,
    pub(super) integral: Option<IntegralAction<f32>>,
    pub(super) friction: DryFriction<f32>,
    /// Factor of the torque offset per period.
    pub(super) fade: f32,
    checks: [CheckWord; SECTIONS as usize - 1],
}

impl LoopConfig {
    /// Builds the configuration for these settings.
    ///
    /// # Errors
    /// The refusal of a board.
    pub fn build(settings: &Settings) -> Result<Self, Refusal> {
        if !settings.limits.is_valid() {
            return Err(Refusal::OutOfRange);
        }
        let control = ControlConfig::build(&settings.setup)?;
        Ok(Self::from_parts(&control, settings.limits))
    }

    /// The configuration with these [valid](Limits::is_valid) limits.
    pub(crate) fn from_parts(control: &ControlConfig, limits: Limits) -> Self {
        let monitors = MonitorConfig::new(limits, &control.joints, control.period_us.get());
        Self {
            control: *control,
            monitors,
            monitors_check: CheckWord::compute(&monitors),
        }
    }

    /// The same limits with another set-up.
    #[must_use]
    pub fn with_control(&self, control: &ControlConfig) -> Self {
        let is_same_period = control.period_us == self.control.period_us;
        if is_same_period && self.has_joints(control) {
            return Self {
                control: *control,
                ..*self
            };
        }
        Self::from_parts(control, *self.limits())
    }

    /// The same set-up with other [valid](Limits::is_valid) limits.
    #[must_use]
    pub fn with_limits(&self, limits: Limits) -> Self {
        Self::from_parts(&self.control, limits)
    }

    /// Whether the servos, their number, commands and calibration, are those of `control`.
    pub(crate) fn has_joints(&self, control: &ControlConfig) -> bool {
        self.control.joints == control.joints
            && self.control.mode == control.mode
            && self.joints() == control.joint_count
    }

    /// What commands are.
    pub(crate) fn control_mode(&self) -> ControlMode {
        self.control.mode
    }

    /// Number of joints, and of servos.
    #[inline]
    pub fn joints(&self) -> usize {
        self.control.joint_count
    }

    /// Tick period in µs.
    pub fn period_us(&self) -> NonZeroU32 {
        self.control.period_us
    }

    /// The first joint whose calibration is of another encoder.
    pub fn joint_of_other(&self, encoder: Encoder) -> Option<u8> {
        let is_other = |joint: &Joint<f32>| joint.encoder() != Some(encoder);
        let mut joints = self.control.joints.iter().take(self.joints());
        let joint = joints.position(is_other);
        joint.map(|joint| joint as u8)
    }

    /// The limits in force.
    pub fn limits(&self) -> &Limits {
        self.monitors.limits()
    }

    /// Largest number of consecutive missing samples of a joint.
    pub fn dropout_ticks(&self) -> u32 {
        self.monitors.dropout_ticks()
    }

    /// Whether one section of the configuration is as it was built; `section` counts modulo
    /// their number.
    pub fn check_section(&self, section: u32) -> bool {
        match self.control.checks.get((section % SECTIONS) as usize) {
            Some(check) => self.control.section(section % SECTIONS) == *check,
            None => CheckWord::compute(&self.monitors) == self.monitors_check,
        }
    }

    /// Whether the whole configuration is as it was built.
    pub fn is_intact(&self) -> bool {
        (0..SECTIONS).all(|section| self.check_section(section))
    }

    /// Number of sections that a tick compares, and number of ticks from one comparison to
    /// the next.
    pub fn check_pace(&self) -> (u32, u32) {
        let turn_us = CHECK_US / SECTIONS;
        let period_us = self.period_us().get();
        (
            period_us.div_ceil(turn_us).min(SECTIONS),
            (turn_us / period_us).max(1),
        )
    }

    /// Turns a bit of a number that the tick computes with, chosen by `draw`, for
    /// tests.
    pub fn inject_error(&mut self, draw: u32) {
        let [a, b] = &mut self.control.joints;
        let arm = &mut self.control.arm;
        let numbers = [
            &mut arm.i1x,
            &mut arm.l1,
            &mut arm.m2,
            &mut self.control.fade,
            &mut a.zero_count,
            &mut a.gain_counts_per_nm,
            &mut b.rad_per_count,
            &mut b.offset_counts,
        ];
        let count = numbers.len() as u32;
        let bit = 1 << (draw / count % 32);
        if let Some(number) = numbers.into_iter().nth((draw % count) as usize) {
            *number = f32::from_bits(number.to_bits() ^ bit);
        }
    }
}

impl ControlConfig {
    /// Designs estimator and controller of `setup`.
    ///
    /// # Errors
    /// The reason why one does not exist.
    pub fn build(setup: &Setup) -> Result<Self, Refusal> {
        if !(PERIOD_MIN_US..=PERIOD_MAX_US).contains(&setup.period_us) {
            return Err(Refusal::OutOfRange);
        }
        let period_us = NonZeroU32::new(setup.period_us).ok_or(Refusal::OutOfRange)?;
        let period_s = setup.period_us as f32 * 1e-6;
        let arm = setup.arm;
        let load_percent = setup.friction_load_percent;
        let friction_is_valid = setup.friction_nm.iter().all(|nm| (0.0..=1.0).contains(nm))
            && load_percent
                .iter()
                .all(|load| *load <= FRICTION_LOAD_PERCENT_MAX);
        if !(arm.is_valid() && setup.joints.iter().all(Joint::is_valid) && friction_is_valid) {
            return Err(Refusal::OutOfRange);
        }
        let estimator = setup
            .estimator
            .build_with_load(&arm, period_s, setup.friction_load())
            .map_err(|error| match error {
                estimate::Error::Unstable(Eigenvalue { re, im }) => {
                    Refusal::UnstableObserver { re, im }
                }
                _ => Refusal::OutOfRange,
            })?;
        let model = arm.linearise(Vector2::zeros()).zero_order_hold(period_s);
        let controller = design::controller(setup, &model, period_s)?;
        let integral = design::integral(
            setup.integral,
            &controller.upright_gain(&arm),
            &model,
            period_s,
        )?;
        let knows_friction =
            matches!(setup.estimator, Config::Kalman(tuning) if tuning.coulomb_nm > 0.0);
        let mut config = Self {
            period_us,
            arm,
            joint_count: arm.joints(),
            joints: setup.joints,
            mode: setup.control_mode,
            estimator,
            knows_friction,
            controller,
            integral,
            friction: DryFriction::of(setup.friction_nm).with_load(setup.friction_load()),
            fade: FADE_S / (period_s + FADE_S),
            checks: [CheckWord::compute(&0_u32); SECTIONS as usize - 1],
        };
        config.checks = core::array::from_fn(|section| config.section(section as u32));
        Ok(config)
    }

    /// Tick period in µs.
    pub fn period_us(&self) -> NonZeroU32 {
        self.period_us
    }

    /// The float of this arm. It is derived in each tick that floats, so that no other tick has
    /// parameters of it to compare.
    pub(super) fn float(&self) -> Float<f32> {
        let period_s = self.period_us.get() as f32 * 1e-6;
        Float::new(&self.arm, self.friction.torque_nm, period_s)
    }

    /// Check word of one section.
    fn section(&self, section: u32) -> CheckWord {
        let mut sum = CheckWord::compute(&section);
        match section {
            0 => {
                self.period_us.get().check(&mut sum);
                self.arm.check(&mut sum);
                (self.joint_count as u32).check(&mut sum);
                self.joints.check(&mut sum);
                (self.mode as u32).check(&mut sum);
                self.fade.check(&mut sum);
            }
            1 => {
                self.estimator.check(&mut sum);
                self.knows_friction.check(&mut sum);
            }
            _ => {
                self.controller.check(&mut sum);
                self.integral.check(&mut sum);
                self.friction.check(&mut sum);
            }
        }
        sum
    }

    /// Joint angles in rad for encoder counts.
    pub(super) fn angles(&self, counts: [Option<u16>; JOINTS]) -> [Option<f32>; JOINTS] {
        core::array::from_fn(|i| counts[i].map(|count| self.joints[i].angle(count)))
    }
}
