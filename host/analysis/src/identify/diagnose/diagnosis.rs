//! Diagnosis of data that do not identify an arm: defect, place, and remedy.

/// Defect of logs that do not identify an arm. Joints count from 1, seconds from the first
/// record of a log.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Diagnosis {
    /// No tick in which the motors were driven.
    #[error(
        "empty: in no tick of these logs are the motors driven; record a run in which they are, \
         such as `armbridge run multisine`"
    )]
    Empty,
    /// A joint slides for too short a time.
    #[error(
        "too short a log: joint {joint} slides for {sliding_s:.1} s, and {required_s:.1} s are \
         required; move it for some ten seconds by its motor, as `armbridge run multisine` \
         does"
    )]
    TooShort {
        /// Joint.
        joint: usize,
        /// Duration of sliding.
        sliding_s: f64,
        /// Required duration.
        required_s: f64,
    },
    /// Ticks unrecorded, or without an angle.
    #[error(
        "lost samples: {percent:.0} % of {ticks} ticks have no angle of joint {joint} \
         ({without_angle} recorded without one, {unrecorded} unrecorded in {gaps} gaps); see \
         `armbridge info`, and repair the bus or the link first"
    )]
    LostSamples {
        /// Joint.
        joint: usize,
        /// Ticks without its angle in percent.
        percent: f64,
        /// Ticks with the motors driven, recorded or not.
        ticks: usize,
        /// Ticks recorded without its angle.
        without_angle: usize,
        /// Ticks unrecorded.
        unrecorded: usize,
        /// Gaps of unrecorded ticks.
        gaps: usize,
    },
    /// An encoder at an end of its track.
    #[error(
        "clipped: joint {joint}'s encoder is at an end of its track in {percent:.0} % of the \
         ticks, where it measures no angle; move the joint about the middle, or turn its horn"
    )]
    ClippedEncoder {
        /// Joint.
        joint: usize,
        /// Affected ticks in percent.
        percent: f64,
    },
    /// A motor at its limit.
    #[error(
        "clipped: joint {joint}'s motor is at its limit in {percent:.0} % of the ticks, where its \
         gain is not identifiable; move more gently, or raise limits.torque_nm"
    )]
    ClippedMotor {
        /// Joint.
        joint: usize,
        /// Affected ticks in percent.
        percent: f64,
    },
    /// The other joint's PWM explains a joint's motion.
    #[error(
        "wrong joint: the PWM of joint {other} explains {by_other:.0} % of joint {joint}'s \
         acceleration, its own {by_own:.0} %; are the servos' ids, or the joints of the arm, \
         swapped?"
    )]
    WrongJoint {
        /// Joint that moves.
        joint: usize,
        /// Joint whose PWM moves it.
        other: usize,
        /// Acceleration that the other's PWM explains, in percent.
        by_other: f64,
        /// Acceleration that its own explains, in percent.
        by_own: f64,
    },
    /// A motor drives its joint backwards.
    #[error(
        "wrong direction: 100 counts of PWM accelerate joint {joint} by {rad_s2:+.1} rad/s²; is \
         its motor reversed against its encoder?"
    )]
    WrongDirection {
        /// Joint.
        joint: usize,
        /// Acceleration for 100 counts.
        rad_s2: f64,
    },
    /// A joint that its motor does not move.
    #[error(
        "not driven: joint {joint} moves, but not by its motor, in all of these logs: was it \
         moved by hand, is its horn loose, its motor without supply, or arm.mounting wrong?"
    )]
    NotDriven {
        /// Joint.
        joint: usize,
    },
    /// External torque on a joint for some time.
    #[error(
        "external torque: from {from_s:.1} s to {to_s:.1} s of log {log} up to {torque_nm:.2} N m \
         that its motor does not explain act on joint {joint} (episodes in all: {episodes}, \
         {total_s:.1} s); was the arm held by hand, did it touch a stop, does a cable pull? \
         Record again, or leave that log out"
    )]
    ExternalTorque {
        /// Log, from 1.
        log: usize,
        /// Joint with the largest torque.
        joint: usize,
        /// Start.
        from_s: f64,
        /// End.
        to_s: f64,
        /// Largest unexplained torque.
        torque_nm: f64,
        /// Episodes of either joint.
        episodes: usize,
        /// Their total duration.
        total_s: f64,
    },
    /// The model does not fit this arm.
    #[error(
        "model mismatch: {outliers} of {windows} windows are outliers, the median residual is \
         {rms_counts:.1} counts, and the encoders' noise {noise_counts:.1}; are lengths, mounting \
         and directions right, is anything loose or touching, was the arm held by hand?"
    )]
    ModelMismatch {
        /// Windows that are outliers.
        outliers: usize,
        /// All windows.
        windows: usize,
        /// Median of the windows' root mean square residuals.
        rms_counts: f64,
        /// Standard deviation of the encoders' own noise.
        noise_counts: f64,
    },
}
