//! Observer poles as values: numbers, or conjugate pairs as text.
//!
//! A real pole is a number; a pair is written `0.6±0.2i`, or as its two poles `0.6+0.2i` and
//! `0.6-0.2i`. Lists may be nested joint by joint, or flat, or one text with commas.

use armbridge_control::design::placement::Poles;
use armbridge_servo::JOINTS;
use toml::Value;

use super::access::Number;

/// Poles of both joints, in z.
pub type JointPoles = [Poles<f32>; JOINTS];

/// One row for each joint: two numbers, or the two poles of a pair as text.
pub(super) fn to_value(joints: &JointPoles) -> Value {
    let row = |poles: &Poles<f32>| {
        let row = match poles {
            Poles::Real(first, second) => vec![first.read(), second.read()],
            Poles::Conjugate { re, im } => ['+', '-']
                .map(|sign| Value::String(format!("{re}{sign}{}i", im.abs())))
                .into(),
        };
        Value::Array(row)
    };
    Value::Array(joints.iter().map(row).collect())
}

/// The poles in a value; `None` if these are not two for each joint, inside the unit circle,
/// real ones not negative and others in conjugate pairs.
pub(super) fn of_value(value: &Value) -> Option<JointPoles> {
    let mut poles = Vec::new();
    collect(value, &mut poles)?;
    let [a, b, c, d]: [(f64, f64); 2 * JOINTS] = poles.try_into().ok()?;
    Some([of_pair(a, b)?, of_pair(c, d)?])
}

/// Complex numbers as they are typed for poles: real and imaginary parts.
pub fn complex_numbers(text: &str) -> Option<Vec<(f64, f64)>> {
    let mut numbers = Vec::new();
    collect(&super::of_text(text), &mut numbers)?;
    Some(numbers)
}

/// Poles of both joints as they are typed, see [`of_value`].
pub fn joint_poles(text: &str) -> Option<JointPoles> {
    of_value(&super::of_text(text))
}

/// Two poles, each a real and an imaginary part.
fn of_pair(first: (f64, f64), second: (f64, f64)) -> Option<Poles<f32>> {
    let single = |(re, im): (f64, f64)| (re as f32, im as f32);
    let ((re, im), (other_re, other_im)) = (single(first), single(second));
    if im == 0.0 && other_im == 0.0 {
        let is_valid = |pole: f32| (0.0..1.0).contains(&pole);
        // No number is -0.
        return (is_valid(re) && is_valid(other_re))
            .then_some(Poles::Real(re + 0.0, other_re + 0.0));
    }
    let is_conjugate = [re, im].map(f32::to_bits) == [other_re, -other_im].map(f32::to_bits);
    let is_pair = is_conjugate && re.hypot(im) < 1.0;
    is_pair.then_some(Poles::Conjugate {
        re: re + 0.0,
        im: im.abs(),
    })
}

/// Appends the poles of a value; `None` if something in it is none.
fn collect(value: &Value, poles: &mut Vec<(f64, f64)>) -> Option<()> {
    match value {
        Value::Integer(number) => poles.push((*number as f64, 0.0)),
        Value::Float(number) => poles.push((*number, 0.0)),
        Value::Array(values) => values.iter().try_for_each(|value| collect(value, poles))?,
        Value::String(text) => {
            for pole in text.split(',') {
                poles.extend(of_text(pole.trim().trim_matches(['[', ']', '"', ' ']))?);
            }
        }
        Value::Boolean(_) | Value::Datetime(_) | Value::Table(_) => return None,
    }
    Some(())
}

/// One pole, or both of a pair with `±`.
fn of_text(text: &str) -> Option<Vec<(f64, f64)>> {
    let Some(complex) = text.strip_suffix(['i', 'j']) else {
        return Some(vec![(text.parse().ok()?, 0.0)]);
    };
    if let Some((re, im)) = complex.split_once('±').or_else(|| complex.split_once("+-")) {
        let (re, im): (f64, f64) = (re.trim().parse().ok()?, im.trim().parse().ok()?);
        return Some(vec![(re, im), (re, -im)]);
    }
    // The sign of the imaginary part, not of an exponent.
    let at = complex
        .char_indices()
        .rev()
        .find(|(at, sign)| {
            let before = complex[..*at].chars().next_back();
            ['+', '-'].contains(sign) && !matches!(before, Some('e' | 'E'))
        })
        .map(|(at, _)| at)?;
    let (re, im) = complex.split_at(at);
    let re = if re.trim().is_empty() { "0" } else { re.trim() };
    let im: String = im.split_whitespace().collect();
    Some(vec![(re.parse().ok()?, im.parse().ok()?)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{of_text as typed, to_text};

    #[test]
    fn pairs_are_read_as_they_are_written() {
        let pair = Poles::Conjugate { re: 0.6, im: 0.2 };
        let real = Poles::Real(0.65, 0.7);
        for text in [
            "0.6±0.2i,0.65,0.7",
            "0.6+-0.2j, 0.65, 0.7",
            "0.6-0.2i,0.6+0.2i,0.65,0.7",
            "[[\"0.6+0.2i\", \"0.6-0.2i\"], [0.65, 0.7]]",
            "[[\"0.6±0.2i\"], [6.5e-1, 0.7]]",
            "[[6e-1+2e-1i, 0.6-0.2i], [0.65, 0.70]]",
        ] {
            assert_eq!(of_value(&typed(text)), Some([pair, real]), "{text}");
        }
        let value = to_value(&[pair, real]);
        assert_eq!(
            to_text(&value),
            "[[\"0.6+0.2i\", \"0.6-0.2i\"], [0.65, 0.7]]"
        );
        assert_eq!(of_value(&value), Some([pair, real]));
        for text in [
            "0.6+0.2i,0.6+0.2i,0.65,0.7",
            "0.6±0.9i,0.65,0.7",
            "0.6±0.2i,0.65",
            "1,0.5,0.5,0.5",
            "-0.1,0.5,0.5,0.5",
            "nan,0.5,0.5,0.5",
            "0.6±xi,0.5,0.5",
        ] {
            assert_eq!(of_value(&typed(text)), None, "{text}");
        }
    }
}
