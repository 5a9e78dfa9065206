//! Random arms, for tests of identification and for policies that have to cope with many.
//!
//! Each number is drawn independently, for each joint and, where it has one, each direction. The result depends only on the seed.

use armbridge_control::actuator::{Direction, Joint};
use armbridge_control::arm::Parameters;
use armbridge_servo::JOINTS;
use rand_distr::{Distribution, StandardUniform, Uniform};
use rand_pcg::Pcg32;

use super::{Friction, PlantConfig};

/// Stream of the generator; the encoders' noise, faults and campaigns use 0 to 6.
const STREAM: u64 = 7;
/// Limit of the spread, so that masses stay positive.
const SPREAD_MAX: f64 = 0.9;
/// Offset of the encoder's zero from the middle in counts, for a spread of 1.
const ZERO_COUNTS: f64 = 50.0;
/// Nominal dead zone: part of the paper's, which includes friction.
const DEAD_ZONE_COUNTS: f64 = 30.0;
/// Nominal delay: three ticks at 1 kHz.
const DELAY_US: f64 = 3_000.0;
/// Minimum ratio of static friction to Coulomb friction.
const STATIC_RATIO: f64 = 1.1;

impl PlantConfig {
    /// The default arm, each of whose numbers is off by a factor from `1 - spread` to
    /// `1 + spread`, all equally likely.
    ///
    /// These are lengths, masses, both large inertias, viscous and dry friction, the
    /// motors' gain, offset, dead zone (nominally 30 counts) and delay (3 ms). Dry
    /// friction at rest is at least 1.1 times that of sliding. The encoders' zeros are
    /// within 50 `spread` counts of the middle, the servos turn either way, and noise
    /// is 1 count rms. A spread beyond 0 to 0.9 counts as the nearest of these.
    pub fn drawn(seed: u64, spread: f64) -> Self {
        let mut draw = Draw::new(seed, spread);
        let nominal = Self::default();
        let arm = nominal.arm;
        Self {
            arm: Parameters {
                l1: draw.about(arm.l1),
                l2: draw.about(arm.l2),
                m1: draw.about(arm.m1),
                m2: draw.about(arm.m2),
                i1x: draw.about(arm.i1x),
                i2y: draw.about(arm.i2y),
                b1: draw.about(arm.b1),
                b2: draw.about(arm.b2),
                ..arm
            },
            joints: nominal.joints.map(|joint| draw.joint(joint)),
            friction_on: true,
            friction: nominal.friction.map(|friction| draw.friction(friction)),
            dead_zone_counts: [[DEAD_ZONE_COUNTS; 2]; JOINTS]
                .map(|counts| counts.map(|counts| draw.about(counts).round() as u16)),
            // In whole microseconds, as plant files have it.
            input_delay_ns: [DELAY_US; JOINTS].map(|us| draw.about(us).round() as u64 * 1_000),
            noise_lsb_rms: 1.0,
            ..nominal
        }
    }

    /// This arm, each of whose numbers is off by a factor from `1 - spread` to `1 + spread`, all
    /// equally likely: both masses, both large inertias, viscous and dry friction, and the motors'
    /// gain. Lengths, calibration, dead zones and delays are as they are. A spread beyond 0 to 0.9
    /// counts as the nearest of these.
    #[must_use]
    pub fn varied(&self, seed: u64, spread: f64) -> Self {
        let mut draw = Draw::new(seed, spread);
        let arm = self.arm;
        Self {
            arm: Parameters {
                m1: draw.about(arm.m1),
                m2: draw.about(arm.m2),
                i1x: draw.about(arm.i1x),
                i2y: draw.about(arm.i2y),
                b1: draw.about(arm.b1),
                b2: draw.about(arm.b2),
                ..arm
            },
            friction: self.friction.map(|friction| {
                // The same factor for both: one is not below the other.
                let factor = draw.about(1.0);
                Friction {
                    coulomb_nm: friction.coulomb_nm * factor,
                    static_nm: friction.static_nm * factor,
                    load: (friction.load * factor).min(Friction::LOAD_MAX),
                    ..friction
                }
            }),
            torque_gain: draw.about(self.torque_gain),
            ..*self
        }
    }
}

/// Generator of the numbers of an arm.
struct Draw {
    random: Pcg32,
    /// From -spread to spread.
    off: Uniform<f64>,
}

impl Draw {
    fn new(seed: u64, spread: f64) -> Self {
        let spread = if spread > 0.0 {
            spread.min(SPREAD_MAX)
        } else {
            0.0
        };
        Self {
            random: Pcg32::new(seed, STREAM),
            off: Uniform::new_inclusive(-spread, spread).expect("a finite spread"),
        }
    }

    fn off(&mut self) -> f64 {
        self.off.sample(&mut self.random)
    }

    fn about(&mut self, nominal: f64) -> f64 {
        nominal * (1.0 + self.off())
    }

    fn joint(&mut self, nominal: Joint<f64>) -> Joint<f64> {
        Joint {
            zero_count: nominal.zero_count + self.off() * ZERO_COUNTS,
            direction: if StandardUniform.sample(&mut self.random) {
                Direction::Forward
            } else {
                Direction::Reverse
            },
            gain_counts_per_nm: self.about(nominal.gain_counts_per_nm),
            offset_counts: self.about(nominal.offset_counts),
            ..nominal
        }
    }

    fn friction(&mut self, nominal: Friction) -> Friction {
        let coulomb_nm = self.about(nominal.coulomb_nm);
        let static_nm = self.about(nominal.static_nm);
        Friction {
            coulomb_nm,
            static_nm: static_nm.max(STATIC_RATIO * coulomb_nm),
            ..nominal
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::PlantFile;

    const SPREAD: f64 = 0.4;
    const SEEDS: u64 = 500;

    /// Ratio of each number to its nominal one; rounded ones may be off by half a count.
    fn factors(config: &PlantConfig) -> Vec<f64> {
        let nominal = PlantConfig::default();
        let (arm, nominal_arm) = (config.arm, nominal.arm);
        let mut factors = vec![
            arm.l1 / nominal_arm.l1,
            arm.l2 / nominal_arm.l2,
            arm.m1 / nominal_arm.m1,
            arm.m2 / nominal_arm.m2,
            arm.i1x / nominal_arm.i1x,
            arm.i2y / nominal_arm.i2y,
            arm.b1 / nominal_arm.b1,
            arm.b2 / nominal_arm.b2,
        ];
        for j in 0..JOINTS {
            let (joint, nominal_joint) = (config.joints[j], nominal.joints[j]);
            factors.extend([
                config.friction[j].coulomb_nm / nominal.friction[j].coulomb_nm,
                joint.gain_counts_per_nm / nominal_joint.gain_counts_per_nm,
                joint.offset_counts / nominal_joint.offset_counts,
                1.0 + (joint.zero_count - nominal_joint.zero_count) / ZERO_COUNTS,
                config.input_delay_ns[j] as f64 * 1e-3 / DELAY_US,
            ]);
        }
        factors
    }

    #[test]
    fn numbers_are_independent_and_cover_the_spread() {
        let arms: Vec<_> = (0..SEEDS)
            .map(|seed| PlantConfig::drawn(seed, SPREAD))
            .collect();
        let all: Vec<_> = arms.iter().map(factors).collect();
        for number in 0..all[0].len() {
            let values = all.iter().map(|factors| factors[number]);
            let least = values.clone().fold(f64::MAX, f64::min);
            let most = values.clone().fold(f64::MIN, f64::max);
            // Of so many, some come near either end.
            assert!((0.599_9..0.62).contains(&least), "{number}: {least}");
            assert!((1.38..1.400_1).contains(&most), "{number}: {most}");
            let mean = values.sum::<f64>() / SEEDS as f64;
            assert!((mean - 1.0).abs() < 0.04, "{number}: {mean}");
        }
        assert_ne!(arms[0], arms[1]);
        for (arm, factors) in arms.iter().zip(&all) {
            let mut sorted = factors.clone();
            sorted.sort_by(f64::total_cmp);
            sorted.dedup();
            assert!(sorted.len() + 1 >= factors.len(), "{factors:?}");
            for friction in arm.friction {
                assert!(friction.static_nm >= STATIC_RATIO * friction.coulomb_nm);
                assert!(friction.static_nm <= 0.06 * 1.4);
            }
        }
        for zone in 0..2 * JOINTS {
            let counts = arms
                .iter()
                .map(|arm| arm.dead_zone_counts[zone / 2][zone % 2]);
            assert_eq!(counts.clone().min().zip(counts.max()), Some((18, 42)));
        }
        let reversed = |j: usize| {
            arms.iter()
                .filter(move |a| a.joints[j].direction == Direction::Reverse)
        };
        for share in [0, 1].map(|j| reversed(j).count() as f64 / SEEDS as f64) {
            assert!((share - 0.5).abs() < 0.07, "{share}");
        }
    }

    #[test]
    fn every_drawn_arm_is_valid_and_survives_a_file() {
        for seed in 0..SEEDS {
            // Up to the most there is, and beyond.
            let spread = seed as f64 / SEEDS as f64 * 1.1 - 0.1;
            let config = PlantConfig::drawn(seed, spread);
            assert!(config.arm.is_valid(), "seed {seed}: {config:?}");
            assert!(config.joints.iter().all(Joint::is_valid), "seed {seed}");
            let text = toml::to_string(&PlantFile::from_config(&config)).unwrap();
            let file: PlantFile = toml::from_str(&text).unwrap();
            assert_eq!(file.config([9.0; JOINTS]), config, "seed {seed}");
            assert_eq!(config, PlantConfig::drawn(seed, spread));
        }
        assert_eq!(PlantConfig::drawn(1, f64::NAN), PlantConfig::drawn(1, 0.0));
    }
}
