//! Reads and writes parameters: each has the places of its numbers in the settings, from
//! which both directions follow.

use core::fmt;

use armbridge_link::limits::Milliradians;
use armbridge_link::message::Settings;
use armbridge_servo::JOINTS;
use toml::Value;

use super::constraint::{Shape, Takes};
use super::poles::{self, JointPoles};
use super::{Parameter, ParameterError, to_text};

/// Place of a parameter in the settings.
#[derive(Clone, Copy)]
pub(super) enum Access {
    /// Its numbers; `None` if it is not in use.
    Numbers(for<'a> fn(&'a mut Settings) -> Option<Numbers<'a>>),
    /// One of several names.
    Choice {
        /// The selected one; `None` if it is not in use.
        is: fn(&Settings) -> Option<&'static str>,
        /// Selects one.
        choose: fn(&mut Settings, &str),
    },
    /// The poles of each joint's observer; `None` if they are not in use.
    Poles(fn(&mut Settings) -> Option<&mut JointPoles>),
}

/// Numbers within the settings.
pub(super) type Numbers<'a> = Vec<&'a mut dyn Number>;

/// A number in the settings.
pub(super) trait Number {
    /// As a TOML value.
    fn read(&self) -> Value;
    /// From a number that is inside the parameter's range.
    fn write(&mut self, number: f64);
    /// Rounding of a number when it is written.
    fn rounding(&self) -> fn(f64) -> f64;
}

/// Places of a list of numbers.
#[expect(
    clippy::unnecessary_wraps,
    reason = "as `Access` has it: other parameters are not always in use"
)]
pub(super) fn each<N: Number>(numbers: &mut [N]) -> Option<Numbers<'_>> {
    Some(numbers.iter_mut().map(|n| n as &mut dyn Number).collect())
}

/// Place of a single number.
pub(super) fn one<N: Number>(number: &mut N) -> Option<Numbers<'_>> {
    each(core::slice::from_mut(number))
}

impl Number for f32 {
    /// The shortest number with these bits: 0.1, not 0.10000000149011612.
    fn read(&self) -> Value {
        let exact = f64::from(*self);
        let short = self.to_string().parse().unwrap_or(exact);
        // Two roundings can lead to a neighbour.
        let is_same = (short as f32).to_bits() == self.to_bits();
        Value::Float(if is_same { short } else { exact })
    }

    fn write(&mut self, number: f64) {
        *self = number as f32;
    }

    fn rounding(&self) -> fn(f64) -> f64 {
        |number| f64::from(number as f32)
    }
}

/// Shown in rad.
impl Number for Milliradians {
    fn read(&self) -> Value {
        // The nearest to this many thousandths.
        Value::Float(f64::from(self.0) / 1_000.0)
    }

    fn write(&mut self, number: f64) {
        *self = Self((number * 1_000.0).round() as i16);
    }

    fn rounding(&self) -> fn(f64) -> f64 {
        |number| (number * 1_000.0).round() / 1_000.0
    }
}

/// Integers, none of which needs more than 32 bits.
macro_rules! integers {
    ($($integer:ty)*) => {
        $(impl Number for $integer {
            fn read(&self) -> Value {
                Value::Integer((*self).into())
            }

            fn write(&mut self, number: f64) {
                *self = number as $integer;
            }

            fn rounding(&self) -> fn(f64) -> f64 {
                |number| number
            }
        })*
    };
}

integers!(u8 u16 u32);

impl fmt::Debug for Access {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Numbers(_) => "Numbers",
            Self::Choice { .. } => "Choice",
            Self::Poles(_) => "Poles",
        })
    }
}

impl Parameter {
    /// Its value; `None` if it is not in use.
    pub fn value(&self, settings: &Settings) -> Option<Value> {
        match self.access {
            Access::Numbers(numbers) => {
                let mut settings = *settings;
                let values = numbers(&mut settings)?;
                let values: Vec<Value> = values.iter().map(|number| number.read()).collect();
                Some(match self.shape() {
                    Shape::One => values.into_iter().next()?,
                    Shape::List(_) => Value::Array(values),
                    Shape::Rows(_, columns) => {
                        let rows = values.chunks(columns);
                        Value::Array(rows.map(|row| Value::Array(row.to_vec())).collect())
                    }
                })
            }
            Access::Choice { is, .. } => is(settings).map(Into::into),
            Access::Poles(at) => at(&mut settings.clone()).map(|joints| poles::to_value(joints)),
        }
    }

    /// Changes it.
    ///
    /// # Errors
    /// If the value is not permitted, or the parameter is not in use.
    pub(crate) fn set_value(
        &self,
        settings: &mut Settings,
        value: &Value,
    ) -> Result<(), ParameterError> {
        match self.access {
            Access::Numbers(numbers) => {
                let mut changed = *settings;
                let places = numbers(&mut changed).ok_or_else(|| self.not_in_use(settings))?;
                let numbers = self.numbers(value).ok_or_else(|| self.refusal(value))?;
                for (place, number) in places.into_iter().zip(numbers) {
                    if !self.allows(number, place.rounding()) {
                        return Err(self.refusal(value));
                    }
                    place.write(number);
                }
                *settings = changed;
            }
            Access::Choice { is, choose } => {
                let before = is(settings).ok_or_else(|| self.not_in_use(settings))?;
                let word = value.as_str().filter(|word| self.choices().contains(word));
                let word = word.ok_or_else(|| self.refusal(value))?;
                // Selecting the same again keeps its numbers.
                if word != before {
                    choose(settings, word);
                }
            }
            Access::Poles(at) => {
                let mut changed = *settings;
                let place = at(&mut changed).ok_or_else(|| self.not_in_use(settings))?;
                *place = poles::of_value(value).ok_or_else(|| self.refusal(value))?;
                *settings = changed;
            }
        }
        Ok(())
    }

    /// Whether the value is permitted in settings of the kind that the parameter belongs to.
    ///
    /// # Errors
    /// If it is not.
    pub fn accepts(&self, value: &Value) -> Result<(), ParameterError> {
        let mut settings = Settings::default();
        if let Some((kind, with)) = self.goes_with() {
            let word = with.first().copied().unwrap_or_default();
            settings = kind.with_choice(settings, word);
        }
        self.set_value(&mut settings, value)
    }

    /// Names to choose from; empty for numbers.
    pub fn choices(&self) -> &'static [&'static str] {
        match self.takes {
            Takes::OneOf(words) => words,
            Takes::Numbers { .. } | Takes::Poles => &[],
        }
    }

    pub(super) fn with_choice(&self, mut settings: Settings, word: &str) -> Settings {
        match self.access {
            Access::Choice { choose, .. } => choose(&mut settings, word),
            Access::Numbers(_) | Access::Poles(_) => {}
        }
        settings
    }

    pub(super) fn shape(&self) -> Shape {
        match self.takes {
            Takes::Numbers { shape, .. } => shape,
            Takes::OneOf(_) => Shape::One,
            Takes::Poles => Shape::Rows(JOINTS, 2),
        }
    }

    fn allows(&self, number: f64, rounding: fn(f64) -> f64) -> bool {
        match self.takes {
            Takes::Numbers { range, .. } => range.contains(number, rounding),
            Takes::OneOf(_) | Takes::Poles => false,
        }
    }

    /// The numbers in a value of the right shape: rows, or one list.
    fn numbers(&self, value: &Value) -> Option<Vec<f64>> {
        let shape = self.shape();
        let numbers = match (shape, value) {
            (Shape::One, value) => vec![number(value)?],
            (Shape::List(_), Value::Array(list)) => row(list)?,
            (Shape::Rows(_, columns), Value::Array(rows)) => {
                let is_rows = rows.iter().any(Value::is_array);
                if is_rows {
                    let rows = rows.iter().map(|list| row(list.as_array()?));
                    let rows: Vec<Vec<f64>> = rows.collect::<Option<_>>()?;
                    let is_even = rows.iter().all(|row| row.len() == columns);
                    is_even.then(|| rows.concat())?
                } else {
                    row(rows)?
                }
            }
            (Shape::List(_) | Shape::Rows(..), _) => return None,
        };
        (numbers.len() == shape.count()).then_some(numbers)
    }

    fn refusal(&self, value: &Value) -> ParameterError {
        let example = self.default_value();
        let example = example.map_or_else(String::new, |value| format!(", as {}", to_text(&value)));
        let expected = match self.takes {
            Takes::Numbers { .. } | Takes::Poles => format!("{}{example}", self.takes),
            Takes::OneOf(_) => self.takes.to_string(),
        };
        ParameterError::Value {
            key: self.key,
            value: to_text(value),
            expected,
        }
    }

    fn not_in_use(&self, settings: &Settings) -> ParameterError {
        let Some((kind, with)) = self.goes_with() else {
            return super::unknown(self.key);
        };
        let is = kind.value(settings);
        ParameterError::NotInUse {
            key: self.key,
            kind: kind.key,
            is: is.as_ref().and_then(Value::as_str).unwrap_or("").to_owned(),
            needed: format!("\"{}\"", with.join("\" or \"")),
        }
    }
}

fn row(list: &[Value]) -> Option<Vec<f64>> {
    list.iter().map(number).collect()
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Integer(number) => Some(*number as f64),
        Value::Float(number) => Some(*number),
        Value::String(_)
        | Value::Boolean(_)
        | Value::Datetime(_)
        | Value::Array(_)
        | Value::Table(_) => None,
    }
}
