//! Why there are no numbers: what is wrong with the data, where, and what to do.

/// What is wrong with logs that tell no arm. Joints count from 1, seconds from the first
/// record of a log.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Diagnosis {
    /// No tick in which the motors were driven.
    #[error(
        "empty: in no tick of these logs were the motors driven; record a run in which they are, \
         as `armbridge run multisine` does"
    )]
    Empty,
    /// A joint hardly slides.
    #[error(
        "too short a log: joint {joint} slides for {slid_s:.1} s, and {needed_s:.1} s are the least; \
         let it move for some ten seconds under its motor, as `armbridge run multisine` does"
    )]
    TooShort {
        /// The joint.
        joint: usize,
        /// For how long it slides.
        slid_s: f64,
        /// For how long it must.
        needed_s: f64,
    },
    /// Ticks that were not recorded, or have no angle.
    #[error(
        "lost samples: {percent:.0} % of {ticks} ticks have no angle of joint {joint} ({silent} came \
         without, {missed} are missing in {gaps} gaps); see `armbridge info`, and mend the bus or the \
         link first"
    )]
    LostSamples {
        /// The joint of which most are missing.
        joint: usize,
        /// Share of the ticks without its angle, in percent.
        percent: f64,
        /// Ticks with the motors driven, recorded or not.
        ticks: usize,
        /// Ticks recorded without its angle.
        silent: usize,
        /// Ticks that were not recorded.
        missed: usize,
        /// Stretches of such ticks.
        gaps: usize,
    },
    /// A joint's encoder is where its track ends.
    #[error(
        "clipped: joint {joint}'s encoder is at an end of its track in {percent:.0} % of the ticks, \
         where it tells no angle; move the joint about the middle, or turn its horn"
    )]
    ClippedEncoder {
        /// The joint.
        joint: usize,
        /// In so many percent of the ticks.
        percent: f64,
    },
    /// A joint's motor gives all it may.
    #[error(
        "clipped: joint {joint}'s motor is at its limit in {percent:.0} % of the ticks, and says no \
         more of its own strength there; move more gently, or raise limits.torque_nm"
    )]
    ClippedMotor {
        /// The joint.
        joint: usize,
        /// In so many percent of the ticks.
        percent: f64,
    },
    /// The other joint's PWM explains a joint's motion.
    #[error(
        "wrong joint: the PWM of joint {other} explains {by_other:.0} % of how joint {joint} \
         accelerates, its own {by_own:.0} %; are the servos' ids, or the joints of the arm, swapped?"
    )]
    WrongJoint {
        /// The joint that moves.
        joint: usize,
        /// The joint whose PWM moves it.
        other: usize,
        /// Share that the other's PWM explains, in percent.
        by_other: f64,
        /// Share that its own explains, in percent.
        by_own: f64,
    },
    /// A motor pushes backwards.
    #[error(
        "wrong way: 100 counts of PWM that should push joint {joint} forwards accelerate it by \
         {rad_s2:+.1} rad/s²; is its motor reversed against its encoder?"
    )]
    WrongWay {
        /// The joint.
        joint: usize,
        /// Acceleration for 100 counts.
        rad_s2: f64,
    },
    /// A joint moves, and not by its motor.
    #[error(
        "held by hand: joint {joint} moves, but not as its motor pushes, in all of these logs: was \
         it moved by hand, is its horn loose, its motor without supply, or arm.mounting wrong?"
    )]
    NotDriven {
        /// The joint.
        joint: usize,
    },
    /// For some time something else turns a joint.
    #[error(
        "held by hand: from {from_s:.1} s to {to_s:.1} s of log {log} something other than its motor \
         turns joint {joint} with up to {torque_nm:.2} N m (such stretches in all: {pushes}, of \
         {all_s:.1} s); was the arm held, did it meet a stop, does a cable pull? Record again, or \
         leave that log out"
    )]
    HeldByHand {
        /// The log, from 1.
        log: usize,
        /// The joint that is turned most.
        joint: usize,
        /// From here on.
        from_s: f64,
        /// Up to here.
        to_s: f64,
        /// The largest torque that nothing explains.
        torque_nm: f64,
        /// How often that is so, of either joint.
        pushes: usize,
        /// For how long in all.
        all_s: f64,
    },
    /// The model is not this arm.
    #[error(
        "not this arm: {odd} of {windows} windows move as no numbers of the model explain, errors are \
         {rms_counts:.1} counts at the median, and the encoders' noise {noise_counts:.1}; are lengths, mounting and directions right, \
         is anything loose or touching, and was the arm held all the while?"
    )]
    NotThisArm {
        /// Windows that are not explained.
        odd: usize,
        /// All windows.
        windows: usize,
        /// Root mean square of a window's errors, the median of all.
        rms_counts: f64,
        /// Standard deviation of the encoders' own noise.
        noise_counts: f64,
    },
}
