//! Nominal calibration of a model of the X series: what a board begins with whose calibration is of
//! other servos.
//!
//! A count is a turn over 4096. Of a command in PWM control mode 1000 counts are full duty, which gives
//! the stall torque at the model's nominal supply; in current control mode a count is one of the
//! goal current.

use armbridge_control::actuator::Joint;
use armbridge_servo::ControlMode;
use armbridge_servo::protocol2::model::{MODELS, Model};

/// Asks for the model.
pub(super) fn question() -> String {
    format!(
        "The board's calibration is of other servos, or of another control mode. Model of these, as \
         printed on them [{}]",
        MODELS.map(|model| model.name).join(", ")
    )
}

/// What its calibration begins with.
pub(super) fn description(model: &Model, gain: Gain) -> String {
    let Model {
        name,
        stall_nm,
        nominal_v,
        ..
    } = model;
    match gain {
        Gain::Duty(counts) => format!(
            "{name}: {stall_nm:.2} N m at full PWM and {nominal_v} V (e-Manual), {counts:.0} PWM counts \
             per N m. At another supply, or for control by an identified arm: armbridge identify run."
        ),
        Gain::Current(counts, most) => format!(
            "{name}: {counts:.0} counts of the goal current per N m (stall torque over stall current, \
             e-Manual). Its current limit is at most {most} counts, which limits.pwm_counts must not \
             exceed. For control by an identified arm: armbridge identify run."
        ),
    }
}

/// Nominal counts of a command per N m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Gain {
    /// In PWM control mode.
    Duty(f32),
    /// In current control mode, with the largest current limit.
    Current(f32, u16),
}

impl Gain {
    /// That of a model in this mode; `None` if it does not have it.
    pub(super) fn of(model: &Model, mode: ControlMode) -> Option<Self> {
        match mode {
            ControlMode::Pwm => Some(Self::Duty(model.pwm_counts_per_nm())),
            ControlMode::Current => {
                let current = model.current?;
                Some(Self::Current(current.counts_per_nm(), current.most_counts))
            }
        }
    }
}

/// The one model whose name begins with this, in letters of either case.
pub(super) fn find(name: &str) -> Option<&'static Model> {
    let name = name.trim().to_uppercase();
    let mut meant = MODELS.iter().filter(|model| model.name.starts_with(&name));
    meant.next().filter(|_| meant.next().is_none())
}

/// Its calibration, upright in the middle of the turn.
pub(super) fn calibration(gain: Gain) -> Joint<f32> {
    let (Gain::Duty(gain_counts_per_nm) | Gain::Current(gain_counts_per_nm, _)) = gain;
    Joint {
        gain_counts_per_nm,
        ..Joint::x_series()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_is_found_by_as_much_of_its_name_as_tells_it_apart() {
        let name = |typed: &str| find(typed).map(|model| model.name);
        assert_eq!(name("xl430\n"), Some("XL430-W250"));
        assert_eq!(name(" XL330-M288"), Some("XL330-M288"));
        for typed in ["", "XL330", "AX-12A", "XL430-W250-T"] {
            assert_eq!(name(typed), None, "{typed}");
        }
        for model in &MODELS {
            assert_eq!(name(model.name), Some(model.name));
            for mode in [ControlMode::Pwm, ControlMode::Current] {
                let gain = Gain::of(model, mode);
                assert_eq!(
                    gain.is_some(),
                    mode == ControlMode::Pwm || model.current.is_some()
                );
                assert!(
                    gain.is_none_or(|gain| calibration(gain).is_valid()),
                    "{model:?}"
                );
            }
        }
    }
}
