//! Models of the X series as data: what a master has to know of each, found by its model number.
//!
//! Numbers and units are those of the models' control tables and specifications (e-Manual).
//! Torque constants are stall torque over stall current at the recommended supply, from the
//! specifications: a servo at rest has more friction than that shows, so take them as nominal.

use crate::Pwm;

/// How a servo is driven: the codes of [`OPERATING_MODE`](super::register::OPERATING_MODE).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OperatingMode {
    /// Current: torque, within the accuracy of the torque constant.
    Current,
    /// Speed.
    Velocity,
    /// Position within a turn; from the factory.
    Position,
    /// Position of several turns.
    ExtendedPosition,
    /// Position with a limited current.
    CurrentBasedPosition,
    /// Duty: the voltage on the motor.
    Pwm,
}

impl OperatingMode {
    /// Its code in the register.
    pub const fn code(self) -> u8 {
        match self {
            Self::Current => 0,
            Self::Velocity => 1,
            Self::Position => 3,
            Self::ExtendedPosition => 4,
            Self::CurrentBasedPosition => 5,
            Self::Pwm => 16,
        }
    }
}

/// Measurement of the current, of models that have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentSense {
    /// Current of a count, in A.
    pub a_per_count: f32,
    /// Largest current limit, in counts.
    pub most_counts: u16,
    /// Nominal torque constant in N m/A.
    pub nm_per_a: f32,
}

/// A model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Model number, by which a PING finds it.
    pub number: u16,
    /// Name.
    pub name: &'static str,
    /// Position counts of a turn.
    pub counts_per_turn: u16,
    /// PWM counts of full duty.
    pub full_pwm: u16,
    /// Recommended supply in V.
    pub nominal_v: f32,
    /// Stall torque at that, in N m.
    pub stall_nm: f32,
    /// Speed without a load at that, in rpm.
    pub no_load_rpm: f32,
    /// Highest temperature from the factory, in °C.
    pub temperature_c: u8,
    /// Measurement of the current; without, the model has neither current control mode nor a
    /// current limit.
    pub current: Option<CurrentSense>,
}

impl CurrentSense {
    /// Counts of the goal current per N m, by the nominal torque constant.
    pub fn counts_per_nm(&self) -> f32 {
        1.0 / (self.a_per_count * self.nm_per_a)
    }
}

impl Model {
    /// Counts of a command in PWM control mode per N m: 1000 for the stall torque.
    pub fn pwm_counts_per_nm(&self) -> f32 {
        f32::from(Pwm::MAX.counts() - Pwm::OFF.counts()) / self.stall_nm
    }

    /// Back-EMF in N m s/rad, which brakes a motor whose command is a duty: stall torque over the speed
    /// without a load.
    pub fn back_emf_nm_s(&self) -> f32 {
        self.stall_nm / (self.no_load_rpm * core::f32::consts::TAU / 60.0)
    }

    /// The model with current control mode whose nominal torque per count is nearest to this.
    pub fn nearest_by_current(counts_per_nm: f32) -> Option<&'static Self> {
        let distance = |model: &&Self| {
            let nominal = model.current.map(|current| current.counts_per_nm());
            let ratio = nominal.unwrap_or_default() / counts_per_nm;
            ratio.max(1.0 / ratio)
        };
        let with_current = MODELS.iter().filter(|model| model.current.is_some());
        with_current.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

/// Position counts of a turn: 12 bits, in all of them.
pub(super) const TURN: u16 = 4_096;
/// PWM counts of full duty, in all of them.
pub const FULL: u16 = 885;

const fn model(
    number: u16,
    name: &'static str,
    (nominal_v, stall_nm, no_load_rpm, temperature_c): (f32, f32, f32, u8),
    current: Option<CurrentSense>,
) -> Model {
    Model {
        number,
        name,
        counts_per_turn: TURN,
        full_pwm: FULL,
        nominal_v,
        stall_nm,
        no_load_rpm,
        temperature_c,
        current,
    }
}

const fn current(a_per_count: f32, most_counts: u16, stall_nm: f32, stall_a: f32) -> CurrentSense {
    CurrentSense {
        a_per_count,
        most_counts,
        nm_per_a: stall_nm / stall_a,
    }
}

/// The model that a lab is likeliest to have, which the bench has where none is named.
pub const XL430_W250: Model = model(1060, "XL430-W250", (11.1, 1.4, 57.0, 72), None);

/// One that is strong enough to drive the paper's arm by current.
pub const XM430_W210: Model = model(
    1030,
    "XM430-W210",
    (12.0, 3.0, 77.0, 80),
    Some(current(0.002_69, 1_193, 3.0, 2.3)),
);

/// The models, by number.
pub const MODELS: [Model; 6] = [
    model(
        1020,
        "XM430-W350",
        (12.0, 4.1, 46.0, 80),
        Some(current(0.002_69, 1_193, 4.1, 2.3)),
    ),
    XM430_W210,
    XL430_W250,
    model(
        1190,
        "XL330-M077",
        (5.0, 0.215, 383.0, 70),
        Some(current(0.001, 1_750, 0.215, 1.47)),
    ),
    model(
        1200,
        "XL330-M288",
        (5.0, 0.52, 103.0, 70),
        Some(current(0.001, 1_750, 0.52, 1.47)),
    ),
    model(
        1220,
        "XC330-T288",
        (11.1, 0.92, 65.0, 70),
        Some(current(0.001, 910, 0.92, 0.80)),
    ),
];

/// The model with this number, if it is known.
pub fn find(number: u16) -> Option<&'static Model> {
    MODELS.iter().find(|model| model.number == number)
}

/// Baud rates by their code (e-Manual, "Baud Rate").
pub const BAUD_RATES: [u32; 8] = [
    9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000,
];

/// The baud rate of a code.
pub fn baud_rate(code: u8) -> Option<u32> {
    BAUD_RATES.get(usize::from(code)).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_in_order_and_found() {
        assert!(MODELS.windows(2).all(|two| two[0].number < two[1].number));
        assert_eq!(find(1060).map(|model| model.name), Some("XL430-W250"));
        assert_eq!(find(12), None);
        for model in MODELS {
            if let Some(current) = model.current {
                // At the stall current the torque is the stall torque; the limit is near it.
                let most_nm =
                    f32::from(current.most_counts) * current.a_per_count * current.nm_per_a;
                assert!(most_nm > model.stall_nm, "{}: {most_nm}", model.name);
                let nearest = Model::nearest_by_current(1.02 * current.counts_per_nm());
                assert_eq!(nearest.map(|nearest| nearest.name), Some(model.name));
            }
        }
        // The XL430's of a plant that ships.
        assert!((XL430_W250.back_emf_nm_s() - 0.2345).abs() < 1e-4);
    }

    #[test]
    fn baud_rates_have_codes() {
        assert_eq!(baud_rate(3), Some(1_000_000));
        assert_eq!(baud_rate(8), None);
        assert_eq!(OperatingMode::Pwm.code(), 16);
    }
}
