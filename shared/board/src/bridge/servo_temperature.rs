//! Temperatures of the servos: limits, and the baseline of each since it was powered up.
//!
//! A stock servo and one of the X series report °C. A Morpheus servo reports counts of a converter that is not
//! calibrated, so that its limit is mostly a change: since its first reading after power-up,
//! either way, because some sensors fall with heat. A fault that is cleared takes no new
//! baseline; otherwise each would allow another step. A reading at either end of the
//! converter is a sensor that is open or shorted, and no baseline.
//!
//! An arm with a pose for it is parked when a servo comes near a limit, by that same margin.
//!
//! A servo that was too hot must have come down by a margin before its fault is cleared, and
//! be within its limits before the board is armed.

use armbridge_link::limits::hard;
use armbridge_link::message::{Fault, Limits};
use armbridge_link::record::Violation;
use armbridge_servo::{Firmware, JOINTS};

/// Margin in °C by which a stock servo must have cooled.
const COOLED_C: u16 = 5;

/// Share of the permitted change by which a Morpheus servo must have come back.
const COOLED_SHARE: u16 = 5;

/// Readings of each servo since it was powered up.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Temperatures {
    servos: [Option<Readings>; JOINTS],
}

/// Readings since a servo was powered up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Readings {
    /// The first within the converter's range.
    first: Option<u16>,
    latest: u16,
    /// Side on which a limit was exceeded first, until the servo has cooled.
    exceeded: Option<Side>,
}

/// Side of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Above,
    Below,
}

impl Temperatures {
    /// Takes a reading of this joint's servo. Returns the violation if it is beyond a limit.
    pub(super) fn take(
        &mut self,
        joint: usize,
        value: u16,
        firmware: Firmware,
        limits: &Limits,
    ) -> Option<Violation> {
        let readings = self.servos.get_mut(joint)?;
        let before = *readings;
        let first = before.and_then(|readings| readings.first);
        let readings = readings.insert(Readings {
            first: first.or((!is_at_end(value)).then_some(value)),
            latest: value,
            exceeded: before.and_then(|readings| readings.exceeded),
        });
        let violated = readings.violated(firmware, limits);
        if violated.is_none() && readings.has_cooled(firmware, limits) {
            readings.exceeded = None;
        }
        let (limit, side) = violated?;
        // A servo that was switched on hot is beyond the other limit when it has cooled.
        readings.exceeded.get_or_insert(side);
        Some(Violation {
            fault: Fault::Temperature,
            joint: Some(joint as u8),
            value: value.into(),
            limit: limit.into(),
        })
    }

    /// Whether the latest reading of this joint's servo is within the margin of a limit.
    pub(super) fn is_nearly_hot(&self, joint: usize, firmware: Firmware, limits: &Limits) -> bool {
        let readings = self.servos.get(joint).copied().flatten();
        readings.is_some_and(|readings| readings.is_near_limit(firmware, limits))
    }

    /// Forgets the readings of a servo that was powered up again.
    pub(super) fn power_up(&mut self, joint: usize) {
        if let Some(readings) = self.servos.get_mut(joint) {
            *readings = None;
        }
    }

    /// The first joint whose servo is beyond a limit.
    pub(super) fn hot_joint(&self, firmware: Firmware, limits: &Limits) -> Option<u8> {
        self.first(|readings| readings.violated(firmware, limits).is_some())
    }

    /// The first joint whose servo has exceeded a limit, and not come back by the margin.
    pub(super) fn uncooled_joint(&self, firmware: Firmware, limits: &Limits) -> Option<u8> {
        self.first(|readings| !readings.has_cooled(firmware, limits))
    }

    fn first(&self, is_hot: impl Fn(Readings) -> bool) -> Option<u8> {
        let mut servos = self.servos.iter();
        let joint = servos.position(|readings| readings.is_some_and(&is_hot));
        joint.map(|joint| joint as u8)
    }
}

impl Readings {
    /// Limits of a servo, the lower and the upper.
    fn limits(self, firmware: Firmware, limits: &Limits) -> [u16; 2] {
        match firmware {
            Firmware::Stock | Firmware::XSeries => [0, limits.temperature_c.into()],
            Firmware::Morpheus => {
                let drift = limits.temperature_drift_counts;
                let [coldest, hottest] = limits.temperature_counts;
                let first = self.first.unwrap_or(self.latest);
                [
                    coldest.max(first.saturating_sub(drift)),
                    hottest.min(first.saturating_add(drift)),
                ]
            }
        }
    }

    /// The limit that the latest reading exceeds, and on which side.
    fn violated(self, firmware: Firmware, limits: &Limits) -> Option<(u16, Side)> {
        let (value, [low, high]) = (self.latest, self.limits(firmware, limits));
        let is_sensor_broken = firmware == Firmware::Morpheus && is_at_end(value);
        if value > high || (is_sensor_broken && value > 0) {
            Some((high, Side::Above))
        } else if value < low || is_sensor_broken {
            Some((low, Side::Below))
        } else {
            None
        }
    }

    /// Whether the latest reading is within the margin of a limit, or beyond it.
    fn is_near_limit(self, firmware: Firmware, limits: &Limits) -> bool {
        let (value, [low, high]) = (self.latest, self.limits(firmware, limits));
        let margin = margin(firmware, limits);
        value > high.saturating_sub(margin) || (low > 0 && value < low.saturating_add(margin))
    }

    /// Whether the latest reading has come back, by the margin, from the side on which it
    /// exceeded a limit.
    fn has_cooled(self, firmware: Firmware, limits: &Limits) -> bool {
        let (value, [low, high]) = (self.latest, self.limits(firmware, limits));
        let margin = margin(firmware, limits);
        match self.exceeded {
            None => true,
            Some(Side::Above) => value <= high.saturating_sub(margin),
            Some(Side::Below) => value >= low.saturating_add(margin),
        }
    }
}

/// Distance from a limit to which a servo that exceeded it must have come back, and at which an
/// arm is parked before one does.
fn margin(firmware: Firmware, limits: &Limits) -> u16 {
    match firmware {
        Firmware::Stock | Firmware::XSeries => COOLED_C,
        Firmware::Morpheus => limits.temperature_drift_counts / COOLED_SHARE,
    }
}

/// Whether this reading of a Morpheus servo is at an end of its converter.
fn is_at_end(value: u16) -> bool {
    value == 0 || value >= hard::COUNTS
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(temperatures: &mut Temperatures, value: u16) -> Option<f32> {
        let limits = Limits::default();
        let violation = temperatures.take(1, value, Firmware::Morpheus, &limits)?;
        assert_eq!(
            (violation.fault, violation.joint),
            (Fault::Temperature, Some(1))
        );
        Some(violation.limit)
    }

    fn hot(temperatures: &Temperatures, is_after_fault: bool) -> Option<u8> {
        let (firmware, limits) = (Firmware::Morpheus, Limits::default());
        if is_after_fault {
            temperatures.uncooled_joint(firmware, &limits)
        } else {
            temperatures.hot_joint(firmware, &limits)
        }
    }

    /// 349 counts at power-up, 250 of change allowed.
    #[test]
    fn the_baseline_is_that_of_power_up() {
        let mut temperatures = Temperatures::default();
        assert_eq!(fault(&mut temperatures, 349), None);
        assert_eq!(fault(&mut temperatures, 599), None);
        for hotter in [600, 897, 1_022] {
            assert_eq!(fault(&mut temperatures, hotter), Some(599.0));
            assert_eq!(
                (hot(&temperatures, false), hot(&temperatures, true)),
                (Some(1), Some(1))
            );
        }
        // Down, but not by 50 counts.
        assert_eq!(fault(&mut temperatures, 560), None);
        assert_eq!(
            (hot(&temperatures, false), hot(&temperatures, true)),
            (None, Some(1))
        );
        assert_eq!(fault(&mut temperatures, 549), None);
        assert_eq!(hot(&temperatures, true), None);
        // Falling readings are heat as well.
        assert_eq!(fault(&mut temperatures, 98), Some(99.0));
        temperatures.power_up(1);
        assert_eq!(
            (fault(&mut temperatures, 98), hot(&temperatures, true)),
            (None, None)
        );
    }

    /// Its baseline is 582: when it has cooled to 300 its fault can be cleared, but it is not
    /// armed before it has been off and on again.
    #[test]
    fn a_servo_that_was_switched_on_hot_can_cool() {
        let mut temperatures = Temperatures::default();
        assert_eq!(fault(&mut temperatures, 582), None);
        assert_eq!(fault(&mut temperatures, 833), Some(832.0));
        assert_eq!(hot(&temperatures, true), Some(1));
        for _ in 0..3 {
            assert_eq!(fault(&mut temperatures, 300), Some(332.0));
            assert_eq!(
                (hot(&temperatures, true), hot(&temperatures, false)),
                (None, Some(1))
            );
        }
        temperatures.power_up(1);
        assert_eq!(
            (fault(&mut temperatures, 300), hot(&temperatures, false)),
            (None, None)
        );
    }

    #[test]
    fn a_reading_at_an_end_is_a_fault() {
        for end in [0, 1_023] {
            let mut temperatures = Temperatures::default();
            assert!(fault(&mut temperatures, end).is_some(), "{end}");
            assert_eq!(hot(&temperatures, true), Some(1));
            // It is no baseline.
            assert_eq!(fault(&mut temperatures, 300), None);
            assert_eq!(hot(&temperatures, true), None);
        }
    }

    #[test]
    fn a_stock_servo_has_a_scale() {
        let (limits, mut temperatures) = (Limits::default(), Temperatures::default());
        let mut take = |value| {
            let violation = temperatures.take(0, value, Firmware::Stock, &limits);
            let hot = temperatures.uncooled_joint(Firmware::Stock, &limits);
            (violation.is_some(), hot.is_some())
        };
        let taken = [20, 70, 71, 66, 65].map(&mut take);
        let faults = [false, false, true, false, false];
        assert_eq!(taken.map(|(fault, _)| fault), faults);
        assert_eq!(taken.map(|(_, hot)| hot), [false, false, true, true, false]);
    }
}
