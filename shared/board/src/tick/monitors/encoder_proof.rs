//! Proof of an encoder: its samples are believed while they change, or a small motion changes them.
//!
//! An encoder that has stopped repeats one count. One with [noise](super::encoder_noise) cannot do
//! so for long; one without repeats its count on any joint that stands, and the samples alone
//! do not tell the two apart. So while a controller holds the arm, a joint that repeats a count for
//! `limits.quiet_ms` is moved until the count changes:
//!
//! ```text
//! torque beyond gravity
//!  +A           /\             A: `limits.stuck_nm`, which is sure to move a joint
//!              /  \
//!   controller/    \           the ramps end when the count changes, and the controller
//!  ----------'      \          goes on
//!  -A                \__ no change: encoder frozen
//!            80 ms  140 ms
//! ```
//!
//! The first ramp goes the way the controller pushes, so that a joint that sticks short of its
//! setpoint is moved toward it; the second goes back, away from what may obstruct the first. On
//! the paper's arm, with 0.06 N m of static friction, a count is gone through after some 60 ms.
//!
//! # When
//!
//! | joint                                                          | equal samples for    |
//! |----------------------------------------------------------------|----------------------|
//! | stands                                                         | `quiet_ms`, 400 ms   |
//! | is to move: the torque is beyond half of `limits.external_nm`  | two fifths of it     |
//! | is to move: its reference has gone on by 0.05 rad              | four ticks           |
//! | floats                                                         | four times it, 1.6 s |
//!
//! Where the reference has gone on, the first ramp goes against the controller, which is driving
//! the joint. Of one that floats, it goes up and down in turn, so that the joint stays where it is.
//!
//! # What it shows, and what it costs
//!
//! A frozen encoder is found within these times and the ramps, 0.22 s and two ticks: after 0.62 s
//! at rest at 1 kHz, 0.9 s at 45 ms. There is no false alarm as long as `stuck_nm` moves the joint
//! one way or the other; one that is blocked both ways has the same fault. An encoder with a
//! count of noise changes every other sample: it is never moved at 1 kHz, and at 45 ms once in
//! some minutes. A quiet one that stands is moved by a count or two every half second; with
//! `quiet_ms` 0 it is not, and is not known to work.
//!
//! # What remains
//!
//! Constant torque and experiments are not disturbed: there the [stall monitor](super::stall)
//! finds a joint that does not move under more than `stuck_nm`, and nothing finds less.

use super::debounce::ticks;
use super::encoder_noise::{EncoderNoise, RunConfig};
use armbridge_control::check_word::checked;
use armbridge_link::fault::Fault;
use armbridge_link::limits::Limits;
use armbridge_link::record::Violation;

/// Lengths of the ramps in µs, and in ticks: the torque acts a tick after its decision, and its
/// motion shows a tick later.
const FORTH_US: u32 = 80_000;
const FORTH_TICKS: u32 = 3;
const BACK_US: u32 = 140_000;
const BACK_TICKS: u32 = 4;
const DELAY_TICKS: u32 = 2;

/// Least number of equal samples before the ramps, at any period.
const QUIET_TICKS: u32 = 4;

/// Share of `quiet_ms` after which a joint that must move is tested.
const MOVING_SHARE: f32 = 0.4;

/// Share of `external_nm` beyond which a torque is to move the joint.
const PUSHED_SHARE: f32 = 0.5;

/// Way in rad that a reference may go while the joint stands: ten counts.
const WAY_RAD: f32 = 0.05;

/// Ratio of the time after which a joint that floats is tested to that of one that stands.
const FLOAT_RATIO: u32 = 4;

/// Parameters of the proof for one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ProofConfig {
    run: RunConfig,
    /// Equal samples until the ramps, of a joint that stands and of one that must move; `None`
    /// if there are none.
    quiet: Option<[u32; 2]>,
    forth: u32,
    back: u32,
    /// Torque beyond gravity at the ends of the ramps, in N m.
    amplitude_nm: f32,
    period_s: f32,
}

checked!(ProofConfig {
    run,
    quiet,
    forth,
    back,
    amplitude_nm,
    period_s,
});

/// A joint whose encoder is to prove itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Held {
    /// A controller holds it.
    Controlled {
        /// Torque in N m beyond that which the model has for the motion.
        push_nm: f32,
        /// Speed of the reference in rad/s.
        reference_rad_s: f32,
        /// Torque in N m that the model does not explain and is a fault if it lasts.
        external_nm: f32,
    },
    /// It floats: nothing has to move it, and a hand may hold it.
    Floating,
}

/// Equal samples of one joint, and the ramps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct EncoderProof {
    last: Option<u16>,
    /// Samples that were equal to the one before.
    run: u32,
    /// Way of the reference meanwhile, in rad.
    way_rad: f32,
    ramp: Option<Ramp>,
    /// Whether the first of the last ramps went up.
    was_up: bool,
}

/// Ramps under way.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Ramp {
    tick: u32,
    /// The first one goes up.
    is_up: bool,
}

impl ProofConfig {
    pub(super) fn new(limits: &Limits, period_us: u32) -> Self {
        let quiet_us = u32::from(limits.quiet_ms) * 1_000;
        let moving_us = (quiet_us as f32 * MOVING_SHARE) as u32;
        Self {
            run: RunConfig::new(period_us),
            quiet: (quiet_us > 0)
                .then(|| [quiet_us, moving_us].map(|us| ticks(us, period_us, QUIET_TICKS))),
            forth: ticks(FORTH_US, period_us, FORTH_TICKS),
            back: ticks(BACK_US, period_us, BACK_TICKS),
            amplitude_nm: limits.stuck_nm,
            period_s: period_us as f32 * 1e-6,
        }
    }
}

impl EncoderProof {
    /// Takes a sample. Returns whether it repeats the one before, and is to be
    /// [checked](Self::check); one that does not ends the ramps.
    pub(super) fn is_repeated(&mut self, counts: u16) -> bool {
        let is_repeated = self.last.replace(counts) == Some(counts);
        if !is_repeated && self.run > 0 {
            (self.run, self.way_rad, self.ramp) = (0, 0.0, None);
        }
        is_repeated
    }

    /// Counts a repeated sample, and begins or continues the ramps, for which a controller must
    /// hold the joint.
    ///
    /// # Errors
    /// The encoder has stopped.
    pub(super) fn check(
        &mut self,
        config: &ProofConfig,
        noise: &EncoderNoise,
        joint: u8,
        held: Option<&Held>,
    ) -> Result<(), Violation> {
        self.run = self.run.saturating_add(1);
        if let Some(Held::Controlled {
            reference_rad_s, ..
        }) = held
        {
            self.way_rad += reference_rad_s * config.period_s;
        }
        let longest = config.run.longest(noise);
        let is_too_long = longest.is_some_and(|longest| self.run >= longest);
        self.ramp = match (held, config.quiet) {
            (Some(held), Some(quiet)) => self.next_ramp(held, quiet),
            _ => None,
        };
        let ramps = config.forth + config.back + DELAY_TICKS;
        if is_too_long || self.ramp.is_some_and(|ramp| ramp.tick > ramps) {
            return Err(Violation {
                fault: Fault::EncoderFrozen,
                joint: Some(joint),
                value: self.run as f32 * config.period_s * 1e3,
                limit: longest.unwrap_or(self.run) as f32 * config.period_s * 1e3,
            });
        }
        Ok(())
    }

    fn next_ramp(&mut self, held: &Held, [standing, moving]: [u32; 2]) -> Option<Ramp> {
        if let Some(ramp) = self.ramp {
            return Some(Ramp {
                tick: ramp.tick + 1,
                ..ramp
            });
        }
        let (is_due, is_up) = match *held {
            Held::Controlled {
                push_nm,
                external_nm,
                ..
            } => {
                let is_pushed = push_nm.abs() > external_nm * PUSHED_SHARE;
                let quiet = if is_pushed { moving } else { standing };
                let has_moved = self.way_rad.abs() > WAY_RAD;
                let is_due = self.run >= quiet || (has_moved && self.run >= QUIET_TICKS);
                (is_due, (push_nm >= 0.0) != has_moved)
            }
            Held::Floating => (
                self.run >= standing.saturating_mul(FLOAT_RATIO),
                !self.was_up,
            ),
        };
        if is_due {
            self.was_up = is_up;
        }
        is_due.then_some(Ramp { tick: 0, is_up })
    }

    /// The torque in N m for a joint whose controller demands `demand_nm`, where gravity takes
    /// `gravity_nm`.
    pub(super) fn torque(&self, config: &ProofConfig, demand_nm: f32, gravity_nm: f32) -> f32 {
        let Some(ramp) = self.ramp else {
            return demand_nm;
        };
        let amplitude_nm = if ramp.is_up {
            config.amplitude_nm
        } else {
            -config.amplitude_nm
        };
        let (forth_nm, back_nm) = (gravity_nm + amplitude_nm, gravity_nm - amplitude_nm);
        let (from_nm, to_nm, tick, ticks) = if ramp.tick < config.forth {
            (demand_nm, forth_nm, ramp.tick, config.forth)
        } else {
            (forth_nm, back_nm, ramp.tick - config.forth, config.back)
        };
        let share = ((tick + 1) as f32 / ticks as f32).min(1.0);
        from_nm + (to_nm - from_nm) * share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIODS_US: [u32; 4] = [600, 1_000, 10_000, 45_000];

    const STANDING: Held = Held::Controlled {
        push_nm: 0.05,
        reference_rad_s: 0.0,
        external_nm: 0.3,
    };

    /// Time in ms until the fault, of an encoder without noise that repeats a count for 10 s.
    fn until_ms(limits: &Limits, period_us: u32, held: Option<Held>) -> Option<u32> {
        let config = ProofConfig::new(limits, period_us);
        let (mut proof, noise) = (EncoderProof::default(), EncoderNoise::default());
        let ticks = 1..10_000_000 / period_us;
        ticks.map(|tick| tick * period_us / 1_000).find(|_| {
            proof.is_repeated(512) && proof.check(&config, &noise, 0, held.as_ref()).is_err()
        })
    }

    #[test]
    fn a_stopped_encoder_without_noise_is_found_while_a_controller_holds_the_joint() {
        let limits = Limits::default();
        let controlled = |push_nm, reference_rad_s| Held::Controlled {
            push_nm,
            reference_rad_s,
            external_nm: 0.3,
        };
        let (reference_moves, is_pushed) = (controlled(0.05, -0.2), controlled(-0.16, 0.0));
        let times_ms = [STANDING, reference_moves, is_pushed, Held::Floating]
            .map(|held| PERIODS_US.map(|period_us| until_ms(&limits, period_us, Some(held))));
        let expected = [
            [623, 624, 660, 900],
            [473, 475, 510, 765],
            [383, 384, 420, 675],
            [1_824, 1_824, 1_860, 2_115],
        ];
        assert_eq!(times_ms, expected.map(|row| row.map(Some)));
        assert_eq!(until_ms(&limits, 1_000, None), None);
        let is_off = Limits {
            quiet_ms: 0,
            ..limits
        };
        assert_eq!(until_ms(&is_off, 1_000, Some(STANDING)), None);
    }

    /// Ramps of a joint that carries 0.1 N m, from the controller's 0.15 N m on, every 20 ms.
    #[test]
    fn the_torque_goes_the_way_of_the_controller_and_back() {
        let config = ProofConfig::new(&Limits::default(), 20_000);
        let (mut proof, noise) = (EncoderProof::default(), EncoderNoise::default());
        let mut take = |counts| {
            if proof.is_repeated(counts) {
                proof.check(&config, &noise, 0, Some(&STANDING)).unwrap();
            }
            (proof.torque(&config, 0.15, 0.1) * 1_000.0 + 0.5) as i32
        };
        for _ in 0..20 {
            assert_eq!(take(512), 150);
        }
        let ramps = core::array::from_fn::<_, 12, _>(|_| take(512));
        let expected = [238, 325, 413, 500, 386, 271, 157, 43, -70, -185, -299, -299];
        assert_eq!(ramps, expected);
        // The count changes.
        assert_eq!([513, 513, 514].map(take), [150; 3]);
    }
}
