//! Axes: positions of values, and tick labels.

/// Scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Linear.
    Linear,
    /// Linear, for whole numbers: no ticks between them.
    Whole,
    /// Logarithmic, for positive values.
    Log,
    /// Logarithmic from one unit on and linear below, for values that may be zero.
    LogFromOne,
}

/// A range of values on a scale.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Mapping of values to positions.
    pub scale: Scale,
    /// Lower end of the range.
    pub low: f64,
    /// Upper end of the range.
    pub high: f64,
}

impl Scale {
    fn apply(self, value: f64) -> f64 {
        match self {
            // `max` would turn a NaN into a number.
            _ if value.is_nan() => value,
            Self::Linear | Self::Whole => value,
            Self::Log => value.max(f64::MIN_POSITIVE).ln(),
            Self::LogFromOne => value.max(0.0).ln_1p(),
        }
    }
}

impl Axis {
    /// Linear axis between two ends.
    pub fn linear(low: f64, high: f64) -> Self {
        Self {
            scale: Scale::Linear,
            low,
            high,
        }
    }

    /// Linear axis that contains values, with a margin `room` at both ends, as a fraction of
    /// the range.
    pub fn around(values: impl Iterator<Item = f64>, room: f64) -> Self {
        let (low, high) = values
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
        if low > high {
            return Self::linear(0.0, 1.0);
        }
        let room = ((high - low) * room).max(1e-3);
        Self::linear(low - room, high + room)
    }

    /// Position of a value: 0 at the low end, 1 at the high end.
    pub fn position(&self, value: f64) -> f64 {
        let (low, high) = (self.scale.apply(self.low), self.scale.apply(self.high));
        (self.scale.apply(value) - low) / (high - low)
    }

    /// Tick values and labels, at most about `max_ticks`.
    pub fn ticks(&self, max_ticks: f64) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Linear => self.even_ticks(max_ticks, 0.0),
            Scale::Whole => self.even_ticks(max_ticks, 1.0),
            Scale::Log | Scale::LogFromOne => self.decade_ticks(max_ticks),
        }
    }

    /// Multiples, no closer than `least`, of 1, 2 or 5 times a power of ten.
    fn even_ticks(&self, max_ticks: f64, least: f64) -> Vec<(f64, String)> {
        let raw = ((self.high - self.low) / max_ticks.max(1.0)).max(least);
        let decade = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|m| m * decade)
            .find(|step| *step >= raw * 0.999)
            .unwrap_or(decade * 10.0);
        let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
        let (first, last) = (
            // The ends are often ticks, up to rounding.
            (self.low / step - 1e-9).ceil() as i64,
            (self.high / step + 1e-9).floor() as i64,
        );
        (first..=last)
            .map(|i| {
                let value = i as f64 * step;
                (value, format!("{value:.decimals$}").replace('-', "−"))
            })
            .collect()
    }

    /// Zero if the scale includes it, powers of ten, and their doubles and halves if there
    /// is room.
    fn decade_ticks(&self, max_ticks: f64) -> Vec<(f64, String)> {
        let zero = (self.scale == Scale::LogFromOne).then(|| (0.0, "0".to_owned()));
        let decades = (self.high / self.low.max(f64::MIN_POSITIVE)).log10();
        let is_roomy = self.scale == Scale::Log && 3.0 * decades <= max_ticks + 1e-9;
        let factors: &[f64] = if is_roomy { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let powers = (-15..=9).flat_map(|power| {
            let power_of_ten = 10f64.powi(power);
            let values = factors.iter().map(move |factor| factor * power_of_ten);
            values.map(move |value| (value, power))
        });
        let shown = powers.filter(|&(value, _)| {
            let within = value >= self.low * 0.999 && value <= self.high * 1.001;
            within && (self.scale == Scale::Log || value >= 1.0)
        });
        let label = |(value, power): (f64, i32)| {
            let text = match value {
                v if v >= 1e6 => format!("{} M", v / 1e6),
                v if v >= 1e4 => format!("{} k", v / 1e3),
                v if v >= 0.999e-3 => format!("{:.*}", (-power).max(0) as usize, v),
                _ => format!("1e−{}", -power),
            };
            (value, text)
        };
        zero.into_iter().chain(shown.map(label)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, low: f64, high: f64) -> Vec<String> {
        Axis { scale, low, high }
            .ticks(6.0)
            .into_iter()
            .map(|(_, label)| label)
            .collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(Scale::Linear, -0.31, 0.33), ["−0.2", "0.0", "0.2"]);
        assert_eq!(
            labels(Scale::Linear, 0.0, 10.0),
            ["0", "2", "4", "6", "8", "10"]
        );
        assert_eq!(
            labels(Scale::LogFromOne, 0.0, 120.0),
            ["0", "1", "10", "100"]
        );
        assert_eq!(labels(Scale::Log, 0.1, 100.0), ["0.1", "1", "10", "100"]);
        assert_eq!(
            labels(Scale::Log, 0.3, 30.0),
            ["0.5", "1", "2", "5", "10", "20"]
        );
        assert_eq!(
            labels(Scale::Log, 1e-6, 1e-3),
            ["1e−6", "1e−5", "1e−4", "0.001"]
        );
    }

    #[test]
    fn positions_meet_the_ends() {
        for scale in [Scale::Linear, Scale::Log, Scale::LogFromOne] {
            let axis = Axis {
                scale,
                low: 0.5,
                high: 80.0,
            };
            assert!(axis.position(0.5).abs() < 1e-12 && (axis.position(80.0) - 1.0).abs() < 1e-12);
            assert!(axis.position(f64::NAN).is_nan());
        }
    }

    #[test]
    fn equal_values_still_span_an_axis() {
        let axis = Axis::around([0.2, 0.2, f64::NAN].into_iter(), 0.1);
        assert!(axis.low < 0.2 && axis.high > 0.2);
    }
}
