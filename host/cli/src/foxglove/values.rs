//! The board's parameters as a viewer has them, and back.
//!
//! Names and ranges are those of [`params`]; lists of numbers are lists.

use armbridge_client::params;
use armbridge_client::params::ParameterError;
use armbridge_link::message::Settings;
use foxglove::websocket::{Parameter, ParameterType, ParameterValue};
use toml::Value;

/// Parameters with these names; all that are in use if there are no names.
pub fn parameters(settings: &Settings, names: &[String]) -> Vec<Parameter> {
    if names.is_empty() {
        let pairs = params::pairs(settings);
        return pairs
            .into_iter()
            .map(|(parameter, value)| to_parameter(parameter.key, &value))
            .collect();
    }
    names
        .iter()
        .filter_map(|name| Some(to_parameter(name, &params::get(settings, name)?)))
        .collect()
}

/// The settings with these parameters changed, all of them or none.
///
/// # Errors
/// At the first that cannot be.
pub fn changed(settings: &Settings, wanted: &[Parameter]) -> Result<Settings, ParameterError> {
    let values: Vec<(&str, Value)> = wanted
        .iter()
        // One without a value is to be unset, which none can be.
        .filter_map(|parameter| Some((parameter.name.as_str(), to_toml(parameter.value.as_ref()?))))
        .collect();
    let mut changed = *settings;
    params::apply(
        &mut changed,
        values.iter().map(|(key, value)| (*key, value)),
    )?;
    Ok(changed)
}

fn to_parameter(name: &str, value: &Value) -> Parameter {
    let is_numbers = |values: &[Value]| {
        let numbers = values.iter().all(|value| as_number(value).is_some());
        numbers && !values.is_empty()
    };
    let r#type = match value {
        Value::Float(_) => Some(ParameterType::Float64),
        Value::Array(values) if is_numbers(values) => Some(ParameterType::Float64Array),
        Value::Integer(_)
        | Value::Array(_)
        | Value::String(_)
        | Value::Boolean(_)
        | Value::Datetime(_)
        | Value::Table(_) => None,
    };
    Parameter {
        name: name.to_owned(),
        r#type,
        value: Some(to_viewer(value)),
    }
}

fn as_number(value: &Value) -> Option<f64> {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|integer| integer as f64))
}

fn to_viewer(value: &Value) -> ParameterValue {
    match value {
        Value::Integer(integer) => ParameterValue::Integer(*integer),
        Value::Float(float) => ParameterValue::Float64(*float),
        Value::Boolean(is_so) => ParameterValue::Bool(*is_so),
        Value::String(text) => ParameterValue::String(text.clone()),
        Value::Datetime(when) => ParameterValue::String(when.to_string()),
        Value::Array(values) => ParameterValue::Array(
            values
                .iter()
                // A list of type `float64[]` has no integers in it.
                .map(|value| {
                    as_number(value).map_or_else(|| to_viewer(value), ParameterValue::Float64)
                })
                .collect(),
        ),
        Value::Table(table) => ParameterValue::Dict(
            table
                .iter()
                .map(|(key, value)| (key.clone(), to_viewer(value)))
                .collect(),
        ),
    }
}

/// Viewers have no integers: a whole number is one here, and every parameter that takes
/// a number takes it.
fn to_toml(value: &ParameterValue) -> Value {
    match value {
        ParameterValue::Integer(integer) => Value::Integer(*integer),
        ParameterValue::Float64(float) if float.fract() == 0.0 && float.abs() < 1e9 => {
            Value::Integer(*float as i64)
        }
        ParameterValue::Float64(float) => Value::Float(*float),
        ParameterValue::Bool(is_so) => Value::Boolean(*is_so),
        ParameterValue::String(text) => Value::String(text.clone()),
        ParameterValue::Array(values) => Value::Array(values.iter().map(to_toml).collect()),
        ParameterValue::Dict(values) => Value::Table(
            values
                .iter()
                .map(|(key, value)| (key.clone(), to_toml(value)))
                .collect(),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_parameters_can_be_set_again() {
        let settings = Settings::default();
        let all = parameters(&settings, &[]);
        assert!(all.len() > 40, "{}", all.len());
        assert_eq!(changed(&settings, &all), Ok(settings));
        // As a viewer writes it, where all numbers are alike.
        let wanted = |name: &str, value| Parameter {
            name: name.to_owned(),
            r#type: None,
            value: Some(value),
        };
        let hold = wanted("limits.hold_ms", ParameterValue::Float64(80.0));
        let longer = changed(&settings, &[hold]).unwrap();
        assert_eq!(longer.limits.hold_ms, 80);
        let text = ParameterValue::String("long".into());
        let error = changed(&settings, &[wanted("limits.hold_ms", text)]).unwrap_err();
        assert!(error.to_string().contains("limits.hold_ms"), "{error}");
    }
}
