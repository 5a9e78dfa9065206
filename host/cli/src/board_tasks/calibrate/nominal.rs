//! Nominal calibration of a model of the X series: what a board begins with whose calibration is of
//! other servos.
//!
//! A count is a turn over 4096. 1000 PWM counts are full duty, which gives the stall torque at the
//! model's nominal supply.

use armbridge_control::actuator::{Direction, Joint};
use armbridge_control::encoder::Encoder;
use armbridge_servo::protocol2::model::{MODELS, Model};

/// PWM counts of full duty either way.
const FULL_COUNTS: f32 = 1_000.0;

/// Asks for the model.
pub(super) fn question() -> String {
    format!(
        "The board's calibration is of other servos. Model of these, as printed on them [{}]",
        MODELS.map(|model| model.name).join(", ")
    )
}

/// What its calibration begins with.
pub(super) fn description(model: &Model) -> String {
    format!(
        "{}: {:.2} N m at full PWM and {} V (e-Manual), {:.0} PWM counts per N m. At another supply, \
         or for control by an identified arm: armbridge identify run.",
        model.name,
        model.stall_nm,
        model.nominal_v,
        calibration(model).gain_counts_per_nm
    )
}

/// The one model whose name begins with this, in letters of either case.
pub(super) fn find(name: &str) -> Option<&'static Model> {
    let name = name.trim().to_uppercase();
    let mut meant = MODELS.iter().filter(|model| model.name.starts_with(&name));
    meant.next().filter(|_| meant.next().is_none())
}

/// Its calibration, upright in the middle of the turn.
pub(super) fn calibration(model: &Model) -> Joint<f32> {
    Joint {
        zero_count: Encoder::XSeries.middle_count().into(),
        rad_per_count: Encoder::XSeries.nominal_rad_per_count() as f32,
        direction: Direction::Forward,
        gain_counts_per_nm: FULL_COUNTS / model.stall_nm,
        offset_counts: 0.0,
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
            assert!(calibration(model).is_valid(), "{model:?}");
        }
    }
}
