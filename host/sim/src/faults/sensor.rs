//! Faults of a servo's sensors, applied to its converter readings.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg32;

use crate::encoder;
use crate::morpheus_servo::Reading;
use armbridge_control::encoder::Encoder;

/// Largest count of the converter of the temperature.
const TEMPERATURE_MAX: u16 = 1023;
/// Range at its ends that the converter reads while the wiper is off the track and its
/// input floats, in counts.
const FLOATING_COUNTS: u16 = 6;

/// Kinds of sensor faults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorFault {
    /// The potentiometer keeps its first reading.
    Frozen,
    /// The wiper has left its track: counts at random near either end.
    OffTrack {
        /// Seed of the counts.
        seed: u64,
    },
    /// The reading is off by a step, and drifts.
    Offset {
        /// Step in counts.
        counts: f64,
        /// Drift in counts a second.
        counts_per_s: f64,
    },
    /// Noise is added to the reading.
    Noise {
        /// Standard deviation in counts.
        counts_rms: f64,
        /// Seed of the noise.
        seed: u64,
    },
    /// The motor heats up from its present temperature.
    Hot {
        /// Converter counts a second.
        counts_per_s: f64,
    },
}

/// Faults of one servo's sensors.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sensors {
    position: Position,
    /// Time of the first reading while it heats up, and the rate.
    heat: Option<(Option<u64>, f64)>,
}

#[derive(Clone, Debug, Default)]
enum Position {
    #[default]
    True,
    Frozen(Option<u16>),
    OffTrack(Pcg32),
    Offset {
        since_ns: Option<u64>,
        counts: f64,
        counts_per_s: f64,
    },
    Noise {
        draw: Pcg32,
        counts_rms: f64,
    },
}

impl Sensors {
    pub(crate) fn fail(&mut self, fault: SensorFault) {
        /// Stream of the generator; the bus uses 0 to 3.
        const STREAM: u64 = 4;

        match fault {
            SensorFault::Frozen => self.position = Position::Frozen(None),
            SensorFault::OffTrack { seed } => {
                self.position = Position::OffTrack(Pcg32::new(seed, STREAM));
            }
            SensorFault::Offset {
                counts,
                counts_per_s,
            } => {
                self.position = Position::Offset {
                    since_ns: None,
                    counts,
                    counts_per_s,
                };
            }
            SensorFault::Noise { counts_rms, seed } => {
                self.position = Position::Noise {
                    draw: Pcg32::new(seed, STREAM),
                    counts_rms,
                };
            }
            SensorFault::Hot { counts_per_s } => self.heat = Some((None, counts_per_s)),
        }
    }

    /// Removes all faults.
    pub(crate) fn mend(&mut self) {
        *self = Self::default();
    }

    /// Reading for a true value of this encoder.
    pub(crate) fn read(&mut self, truth: Reading, encoder: Encoder, at_ns: u64) -> Reading {
        let position = match &mut self.position {
            Position::True => truth.position,
            Position::Frozen(count) => *count.get_or_insert(truth.position),
            Position::OffTrack(draw) => floating_input(draw, encoder),
            Position::Offset {
                since_ns,
                counts,
                counts_per_s,
            } => {
                let since_ns = *since_ns.get_or_insert(at_ns);
                let seconds = at_ns.saturating_sub(since_ns) as f64 * 1e-9;
                shifted(truth.position, encoder, *counts + seconds * *counts_per_s)
            }
            Position::Noise { draw, counts_rms } => {
                let noise: f64 = StandardNormal.sample(draw);
                shifted(truth.position, encoder, noise * *counts_rms)
            }
        };
        let added = self.heat.as_mut().map_or(0.0, |(since_ns, counts_per_s)| {
            let since_ns = *since_ns.get_or_insert(at_ns);
            at_ns.saturating_sub(since_ns) as f64 * 1e-9 * *counts_per_s
        });
        let temperature = f64::from(truth.temperature) + added;
        Reading {
            position,
            temperature: temperature.clamp(0.0, TEMPERATURE_MAX.into()) as u16,
        }
    }
}

/// A reading that is off by this many counts.
fn shifted(position: u16, encoder: Encoder, counts: f64) -> u16 {
    encoder::count(encoder, f64::from(position) + counts)
}

fn floating_input(draw: &mut Pcg32, encoder: Encoder) -> u16 {
    let Ok(all) = Uniform::new(0, 2 * FLOATING_COUNTS) else {
        return 0;
    };
    match all.sample(draw) {
        low @ 0..FLOATING_COUNTS => low,
        high => encoder.counts_max() + FLOATING_COUNTS - high,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_changes_the_readings() {
        let truth = |position| Reading {
            position,
            temperature: 300,
        };
        let mut sensors = Sensors::default();
        let encoder = Encoder::Ax12a;
        assert_eq!(sensors.read(truth(500), encoder, 0), truth(500));
        sensors.fail(SensorFault::Frozen);
        sensors.fail(SensorFault::Hot { counts_per_s: 50.0 });
        assert_eq!(sensors.read(truth(501), encoder, 1_000_000_000), truth(501));
        let later = sensors.read(truth(700), encoder, 3_000_000_000);
        assert_eq!((later.position, later.temperature), (501, 400));
        sensors.fail(SensorFault::OffTrack { seed: 1 });
        let counts: Vec<u16> = (0..1_000)
            .map(|_| sensors.read(truth(512), encoder, 0).position)
            .collect();
        for end in [0..=5, 1018..=1023] {
            assert!(counts.iter().filter(|count| end.contains(*count)).count() > 400);
        }
        assert!(counts.iter().all(|count| !(6..1018).contains(count)));
        sensors.fail(SensorFault::Offset {
            counts: 40.0,
            counts_per_s: -20.0,
        });
        for (seconds, expected) in [(7, 552), (8, 532), (10, 492), (40, 0)] {
            let reading = sensors.read(truth(512), encoder, seconds * 1_000_000_000);
            assert_eq!(reading.position, expected, "{seconds} s");
        }
        sensors.fail(SensorFault::Noise {
            counts_rms: 20.0,
            seed: 1,
        });
        let square = |reading: Reading| (f64::from(reading.position) - 512.0).powi(2);
        let squares: f64 = (0..1_000)
            .map(|_| square(sensors.read(truth(512), encoder, 0)))
            .sum();
        assert!((18.0..22.0).contains(&(squares / 1e3).sqrt()), "{squares}");
        sensors.mend();
        assert_eq!(sensors.read(truth(512), encoder, 9), truth(512));
    }
}
