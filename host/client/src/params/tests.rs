//! Compares the table with the types behind it, and with the checks of the board.

use armbridge_board::bridge::can_run;
use armbridge_link::message::Refusal;
use proptest::{prop_assert_eq, proptest};

use super::*;

fn of_kinds() -> Vec<Settings> {
    let choices = |key: &'static str| {
        let kind = find(key).unwrap();
        kind.choices().iter().map(move |word| (kind, *word))
    };
    let with_controller =
        choices("controller.kind").map(|(kind, word)| kind.with_choice(Settings::default(), word));
    with_controller
        .flat_map(|settings| {
            choices("estimator.kind").map(move |(kind, word)| kind.with_choice(settings, word))
        })
        .collect()
}

#[test]
fn every_kind_runs_with_its_defaults() {
    assert_eq!(of_kinds().len(), 16);
    for settings in of_kinds() {
        assert_eq!(check(&settings), Ok(()), "{:?}", pairs(&settings));
    }
}

/// A number in the range of every parameter that these settings have.
fn settings(kinds: usize, mut places: impl FnMut() -> f64) -> Settings {
    /// Bound of a range without an end.
    const FAR: f64 = 1e30;

    let mut settings = of_kinds()[kinds];
    for (parameter, _) in pairs(&settings) {
        let value = match parameter.takes {
            Takes::Numbers { shape, range } => {
                let (low, high) = (range.low.max(-FAR), range.high.min(FAR));
                let mut number = || {
                    let number = low + (0.001 + 0.998 * places()) * (high - low);
                    if range.whole {
                        Value::Integer(number.round() as i64)
                    } else {
                        Value::Float(number)
                    }
                };
                match shape {
                    Shape::One => number(),
                    Shape::List(_) | Shape::Rows(..) => {
                        Value::Array((0..shape.count()).map(|_| number()).collect())
                    }
                }
            }
            // Kinds are selected already, and other names are not the last in their group.
            Takes::OneOf(words) if parameter.name() != "kind" => {
                words[(places() * words.len() as f64) as usize % words.len()].into()
            }
            Takes::OneOf(_) => continue,
            Takes::Poles => {
                let (radius, angle) = (0.99 * places() as f32, places() as f32);
                let [re, im] = [radius * angle.cos(), radius * angle.sin()];
                let text = format!("{re}±{im}i,{},{}", places() as f32, places() as f32);
                Value::String(text)
            }
        };
        parameter.set_value(&mut settings, &value).unwrap();
    }
    settings
}

proptest! {
    #[test]
    fn values_make_the_same_settings_again_to_the_bit(
        kinds in 0..16_usize,
        places in proptest::collection::vec(0.0..1.0, 100),
    ) {
        let mut places = places.into_iter().cycle();
        let before = settings(kinds, || places.next().unwrap_or_default());
        let typed: Vec<(&str, Value)> = pairs(&before)
            .iter()
            .map(|(parameter, value)| (parameter.key, of_text(&to_text(value))))
            .collect();
        let mut after = Settings::default();
        // In any order.
        apply(&mut after, typed.iter().rev().map(|(key, value)| (*key, value))).unwrap();
        prop_assert_eq!(after, before);
        // No number is -0 or NaN, whose bits do not compare as equal.
        prop_assert_eq!(format!("{after:?}"), format!("{before:?}"));
        let table: toml::Table = to_table(pairs(&before)).to_string().parse().unwrap();
        let mut read = Settings::default();
        apply_table(&mut read, &table).unwrap();
        prop_assert_eq!(read, before);
    }
}

/// Numbers in some JSON.
fn leaves(value: &serde_json::Value) -> usize {
    match value {
        serde_json::Value::Number(_) => 1,
        serde_json::Value::Array(values) => values.iter().map(leaves).sum(),
        serde_json::Value::Object(fields) => fields.values().map(leaves).sum(),
        serde_json::Value::Null | serde_json::Value::Bool(_) | serde_json::Value::String(_) => 0,
    }
}

#[test]
fn every_number_of_the_settings_has_a_name() {
    for settings in of_kinds() {
        let there = leaves(&serde_json::to_value(settings).unwrap());
        let named: usize = pairs(&settings)
            .iter()
            .map(|(_, value)| leaves(&serde_json::to_value(value).unwrap()))
            .sum();
        assert_eq!(named, there);
    }
    for parameter in all() {
        assert!(parameter.default_value().is_some(), "{}", parameter.key);
        assert!(parameter.about.ends_with('.'), "{}", parameter.key);
        let same = all().iter().filter(|other| other.key == parameter.key);
        assert_eq!(same.count(), 1, "{}", parameter.key);
    }
}

/// Writes without the parameter's own check; returns whether the number changed.
fn force(parameter: &Parameter, settings: &mut Settings, number: f64) -> bool {
    let Access::Numbers(numbers) = parameter.access else {
        return false;
    };
    let Some(kept) = numbers(settings) else {
        return false;
    };
    kept.into_iter().all(|kept| {
        kept.write(number);
        let read = match kept.read() {
            Value::Integer(count) => count as f64,
            other => other.as_float().unwrap_or(f64::NAN),
        };
        (read - number).abs() < 1e-6 * number.abs().max(1.0)
    })
}

#[test]
fn ranges_are_those_that_the_board_checks() {
    let mut checked = 0;
    for mut base in of_kinds() {
        // One must be shorter than the other.
        base.limits.hold_ms = 0;
        base.limits.silence_ms = 2_000;
        for parameter in all() {
            let Takes::Numbers { range, .. } = parameter.takes else {
                continue;
            };
            // The board takes weights below 0 if there is a gain for them; and these two
            // counts must differ. Ranges of a calibration are those of either kind of servo.
            let others = ["controller.q", "controller.r", "limits.temperature_counts"];
            let is_calibration =
                parameter.key.ends_with("zero_count") || parameter.key.ends_with("rad_per_count");
            let is_other = others.contains(&parameter.key) || is_calibration;
            for (end, is_in, further) in [
                (range.low, range.with_low, -1.0),
                (range.high, range.with_high, 1.0),
            ] {
                let mut settings = base;
                if is_other || end.is_infinite() || !force(parameter, &mut settings, end) {
                    continue;
                }
                let is_refused = |settings: &Settings| match check(settings) {
                    Ok(()) => false,
                    Err(InvalidSettings::Refused(refusal)) => {
                        // Weights, frequencies and gains are refused because of the resulting gain.
                        parameter.group() == "controller" && !is_in
                            || refusal == Refusal::OutOfRange
                    }
                    Err(
                        InvalidSettings::HoldsTooLate { .. }
                        | InvalidSettings::NoTemperature { .. }
                        | InvalidSettings::PoseBeyondLimit
                        | InvalidSettings::NoCurrentMode,
                    ) => true,
                };
                assert_eq!(is_refused(&settings), !is_in, "{} at {end}", parameter.key);
                let step = if range.whole {
                    1.0
                } else {
                    end.abs().max(1e-3) * 1e-3
                };
                let beyond = end + further * step;
                if force(parameter, &mut settings, beyond) {
                    assert!(!can_run(&settings), "{} at {beyond}", parameter.key);
                    let value = Value::Float(beyond);
                    let value = match parameter.shape() {
                        Shape::One => value,
                        Shape::List(_) | Shape::Rows(..) => {
                            Value::Array(vec![value; parameter.shape().count()])
                        }
                    };
                    assert!(parameter.set_value(&mut settings, &value).is_err());
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 16 * 60, "{checked}");
}

#[test]
fn errors_have_the_permitted_values() {
    let message = |key: &str, value: &str| {
        let mut settings = Settings::default();
        let error = set(&mut settings, key, &of_text(value)).unwrap_err();
        assert_eq!(settings, Settings::default());
        assert_eq!(error.key(), key);
        error.to_string()
    };
    for (key, value, expected) in [
        (
            "limits.hold",
            "3",
            "there is no parameter `limits.hold`; is it `limits.hold_ms`?",
        ),
        (
            "zzz",
            "3",
            "there is no parameter `zzz`; `armbridge params --all` lists them",
        ),
        (
            "limits.angle_rad",
            "9",
            "`limits.angle_rad` cannot be 9: it takes 2 numbers above 0 to 1.5, as [1.5, 1.5]",
        ),
        (
            "setup.period_us",
            "1.5",
            "`setup.period_us` cannot be 1.5: it takes an integer from 450 to 100000, as 1000",
        ),
        (
            "joint1.direction",
            "left",
            "`joint1.direction` cannot be \"left\": it takes \"forward\" or \"reverse\"",
        ),
        (
            "arm.mounting",
            "sideways",
            "`arm.mounting` cannot be \"sideways\": it takes \"upright\" or \"hanging\"",
        ),
        (
            "controller.natural_rad_s",
            "20,20",
            "`controller.natural_rad_s` goes with controller.kind = \"computed-torque\", but \
             that is \"lqr\"; set `controller.kind` too",
        ),
        (
            "controller.q",
            "1,nan,1,1",
            "`controller.q` cannot be [1, nan, 1, 1]: it takes 4 numbers from 0 to 1000000, as \
             [15.0, 15.0, 1.0, 1.0]",
        ),
    ] {
        assert_eq!(message(key, value), expected);
    }
}

#[test]
fn several_are_changed_together_or_not_at_all() {
    let typed = |pairs: &[&str]| -> Vec<(String, Value)> {
        pairs.iter().map(|text| pair(text).unwrap()).collect()
    };
    let mut settings = Settings::default();
    let apply = |settings: &mut Settings, pairs: &[&str]| {
        let pairs = typed(pairs);
        apply(
            settings,
            pairs.iter().map(|(key, value)| (key.as_str(), value)),
        )
    };
    assert!(apply(&mut settings, &["limits.hold_ms=80", "limits.lost_ms=0"]).is_err());
    assert_eq!(settings, Settings::default());
    // The kind first, though it comes last; a list of rows as one list.
    let gain = "controller.gain=2,0,0.3,0,0,2,0,0.3";
    apply(&mut settings, &[gain, "controller.kind=gain"]).unwrap();
    let shown: Vec<_> = changed(&Settings::default(), &settings)
        .into_iter()
        .map(|(parameter, value)| format!("{} = {}", parameter.key, to_text(&value)))
        .collect();
    assert_eq!(
        shown,
        [
            "controller.kind = \"gain\"",
            "controller.gain = [[2.0, 0.0, 0.3, 0.0], [0.0, 2.0, 0.0, 0.3]]"
        ]
    );
    // The same kind again keeps its numbers.
    let before = settings;
    apply(&mut settings, &["controller.kind=gain"]).unwrap();
    assert_eq!(settings, before);
}
