//! Settings as a message of the log: by name, and as exact bytes.

use armbridge_client::params;
use armbridge_link::message::Settings;
use toml::Value;

use super::payload_codec::exact;
use super::proto;

/// Message for the board's settings.
pub(super) fn message(host_ns: u64, sequence: u16, settings: &Settings) -> proto::Parameters {
    proto::Parameters {
        host_ns,
        sequence: sequence.into(),
        parameters: params::pairs(settings)
            .into_iter()
            .map(|(parameter, value)| proto::Parameter {
                key: parameter.key.into(),
                unit: parameter.unit.into(),
                numbers: numbers(&value),
                text: params::to_text(&value),
            })
            .collect(),
        exact: Some(exact(settings)),
    }
}

/// The number, or the numbers of a list or a matrix, row by row.
fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Integer(number) => vec![*number as f64],
        Value::Float(number) => vec![*number],
        Value::Array(values) => values.iter().flat_map(numbers).collect(),
        Value::String(_) | Value::Boolean(_) | Value::Datetime(_) | Value::Table(_) => Vec::new(),
    }
}
