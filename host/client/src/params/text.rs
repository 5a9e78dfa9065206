//! Values as typed and shown: TOML, and a more lenient form of it.

use toml::Value;

/// Not `KEY=VALUE`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not KEY=VALUE, as limits.hold_ms=80 or controller.q=30,30,0.3,0.3")]
pub struct NotAPair(String);

/// Parses `KEY=VALUE`, as typed on a command line.
///
/// # Errors
/// If there is no `=`, or nothing before it.
pub fn pair(text: &str) -> Result<(String, Value), NotAPair> {
    let pair = text.split_once('=');
    pair.map(|(key, value)| (key.trim(), value.trim()))
        .filter(|(key, _)| !key.is_empty())
        .map(|(key, value)| (key.to_owned(), of_text(value)))
        .ok_or_else(|| NotAPair(text.to_owned()))
}

/// Parses a value as typed: TOML, a list of numbers with commas between, or a name
/// without quotes.
pub fn of_text(text: &str) -> Value {
    let parsed = |text: &str| {
        let table: toml::Table = toml::from_str(&format!("it = {text}")).ok()?;
        // More than one key would need a line feed in the text.
        (table.len() == 1).then(|| table.get("it").cloned())?
    };
    parsed(text)
        .or_else(|| {
            let list = parsed(&format!("[{text}]"))?;
            text.contains(',').then_some(list)
        })
        .unwrap_or_else(|| Value::String(text.to_owned()))
}

/// A value as TOML, in one line.
pub fn to_text(value: &Value) -> String {
    match value {
        Value::Array(values) => {
            let values: Vec<String> = values.iter().map(to_text).collect();
            format!("[{}]", values.join(", "))
        }
        Value::Float(_)
        | Value::Integer(_)
        | Value::String(_)
        | Value::Boolean(_)
        | Value::Datetime(_)
        | Value::Table(_) => value.to_string(),
    }
}
