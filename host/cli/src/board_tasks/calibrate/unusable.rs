//! Reasons for which a measurement or an answer of a calibration cannot be used, with remedies.

/// Why a measurement or an answer is unusable, and a remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unusable {
    /// No model, or more than one, has this name.
    #[error("{0:?} is not the name of one model, as XL430-W250")]
    Model(String),
    /// The servos do not measure their current.
    #[error("{0} has no current control mode, which takes a servo that measures its current")]
    NoCurrentMode(String),
    /// It crept.
    #[error(
        "joint {joint} was not still: it crept by {drift:.1} counts where {allowed:.1} are \
         allowed; hold it"
    )]
    Moved {
        /// From 1.
        joint: usize,
        /// Mean of the second half minus that of the first, in counts.
        drift: f64,
        /// Allowed difference, in counts.
        allowed: f64,
    },
    /// It trembled, or its encoder is noisy.
    #[error(
        "joint {joint} was not still: its counts scatter by {scatter:.1} rms where {allowed:.1} \
         are allowed; hold it, and look at its encoder if it was held"
    )]
    Noisy {
        /// From 1.
        joint: usize,
        /// Rms deviation from the mean, in counts.
        scatter: f64,
        /// Allowed deviation, in counts.
        allowed: f64,
    },
    /// Its servo did not answer often enough.
    #[error("{missing} of {of} samples of joint {joint} are missing; check its bus wiring")]
    Missing {
        /// From 1.
        joint: usize,
        /// Missing samples.
        missing: u32,
        /// Ticks.
        of: u32,
    },
    /// It is at an end of the encoder's counts.
    #[error(
        "joint {joint} is at count {count}, where the encoder's counts end; mount its horn so that \
         it stays within {least} and {most}"
    )]
    AtEnd {
        /// From 1.
        joint: usize,
        /// Its count.
        count: u16,
        /// Least count that it may have.
        least: u16,
        /// Largest count that it may have.
        most: u16,
    },
    /// It was not turned, or hardly.
    #[error(
        "joint {joint} was turned by {} counts only; turn it by 0.3 rad ({least:.0} counts) or more",
        moved.round() as i64
    )]
    TooLittle {
        /// From 1.
        joint: usize,
        /// In counts.
        moved: f64,
        /// Least turn in counts.
        least: f64,
    },
    /// Another joint was.
    #[error(
        "joint {joint} was turned by {moved:.0} counts, but joint {other} by {other_moved:.0}: \
         turn one joint alone; if you did, the servos' ids are swapped"
    )]
    OtherJoint {
        /// From 1.
        joint: usize,
        /// In counts.
        moved: f64,
        /// From 1.
        other: usize,
        /// In counts.
        other_moved: f64,
    },
    /// Both were: swapped ids cannot be distinguished from right ones.
    #[error(
        "joint {joint} was turned by {moved:.0} counts and joint {other} by {other_moved:.0}: \
         turn one joint alone, and hold the other one in line with it"
    )]
    Both {
        /// From 1.
        joint: usize,
        /// In counts.
        moved: f64,
        /// From 1.
        other: usize,
        /// In counts.
        other_moved: f64,
    },
}
