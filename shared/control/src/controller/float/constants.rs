//! Numbers of the float: strengths, speeds and times.

/// Strength of the friction while a joint is weighed, as a share of its weight, the largest
/// gravity torque: masses, lengths and gains that are each a fifth off rarely make half of it.
pub const FIRM_SHARE: f64 = 0.5;
/// Strength of the light friction, as a share of the weight, and of the model's dry friction: with
/// both, it takes what is left of an error of the weight that dry friction at rest has hidden.
pub const LIGHT_SHARE: f64 = 0.055;
/// See [`LIGHT_SHARE`].
pub const LIGHT_DRY_SHARE: f64 = 0.75;
/// Strength of the friction of a joint that has been weighed and not moved since, relative to the
/// light one: a touch does not set it off.
pub const HELD_RATIO: f64 = 2.4;
/// Motion in rad that loads the light friction to its strength: two and a half encoder counts.
pub const REACH_RAD: f64 = 0.0125;
/// Correction of the gravity torque at most, as a share of the weight.
pub const CORRECTION_SHARE: f64 = 0.5;
/// Longest period in µs: campaigns and tests have none beyond.
pub const PERIOD_MAX_US: u32 = 5_000;
/// Gravity torque, as a share of the weight, at which half of a load is taken for scale.
pub(super) const SCALE_AT_SHARE: f64 = 0.45;
/// Part of the model's friction that is compensated.
pub const FRICTION_SHARE: f64 = 0.7;
/// Speed in rad/s from which on all of that part is.
pub(super) const SLIDE_RAD_S: f64 = 0.1;
/// Torque of the motor and friction of the joint, relative to the model's, in the worst case of
/// an arm whose parameters are each a fifth off.
pub const MOTOR_RATIO: f64 = 1.25;
/// See [`MOTOR_RATIO`].
pub const FRICTION_RATIO: f64 = 0.8;
/// Speed in rad/s beyond which no more viscous friction is compensated, at most.
pub(super) const VISCOUS_RAD_S: f64 = 1.0;
/// Viscous friction in N m s/rad below which its compensation makes no difference.
pub(super) const VISCOUS_MIN_NM_S: f64 = 1e-3;
/// Speed in rad/s beyond which the arm is braked.
pub(super) const BRAKE_RAD_S: f64 = 1.5;
/// Torque of the brake for each rad/s beyond, in N m.
pub(super) const BRAKE_NM_S: f64 = 0.5;
/// Angle in rad beyond which the friction is firm for an arm that moves outward, short of where an
/// angle limit of 1.5 rad acts; and the speed in rad/s that it may have for each rad before that.
pub const END_RAD: f64 = 1.2;
pub(super) const END_PER_S: f64 = 6.0;
/// Least weight in N m of which strengths are shares: an arm without weight is held, too.
pub(super) const WEIGHT_MIN_NM: f64 = 0.02;
/// Largest torque of the brake in N m.
pub(super) const BRAKE_NM: f64 = 0.6;
/// Time constants in s over which the angle, and the speed of the slip, are smoothed: an
/// estimator may pass on all of its encoder's noise.
pub(super) const ANGLE_S: f64 = 0.01;
pub(super) const SPEED_S: f64 = 0.02;
/// Speed in rad/s below which a joint is slow.
pub const REST_RAD_S: f64 = 0.05;
/// Time in s for which a joint at rest has been slow.
pub const REST_S: f64 = 0.35;
/// Time in s for which it is weighed at least, from then on.
pub(super) const WEIGH_S: f64 = 0.6;
/// Share of the load that is taken over in a second while a joint is weighed.
pub const TRANSFER_PER_S: f64 = 6.0;
/// Growth of the trim against a slip, in N m/s.
pub const CATCH_NM_S: f64 = 0.02;
/// Time constant in s of the strength.
pub(super) const STRENGTH_S: f64 = 0.15;
/// Motion in rad over which a firm friction becomes light.
pub(super) const SOFTEN_RAD: f64 = 0.03;
/// Motion in rad over which the trim fades.
pub const FADE_RAD: f64 = 0.4;
