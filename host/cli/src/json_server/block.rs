//! Ticks as columns, by the names of every export; a missing number is `null`.

use armbridge_client::params::nearest;
use armbridge_link::message::Record;
use armbridge_log::export::column::{QUANTITIES, Quantity, Values};
use serde_json::{Map, Value};

use super::answer::{Failure, Fields};

/// Most ticks of a block: a second at 1 kHz is 0.5 MB of all columns.
pub(super) const TICKS_MAX: usize = 10_000;

/// A column: its quantity and joint.
pub(super) type Column = (&'static str, &'static Quantity, usize);

/// The named columns, those of a quantity by its own name, or all; true states of a simulated arm
/// are not on the link.
pub(super) fn columns(names: Option<&[String]>) -> Result<Vec<Column>, Failure> {
    let all = || {
        let on_link = QUANTITIES
            .iter()
            .filter(|it| !matches!(it.values, Values::Truth(_)));
        on_link.flat_map(|quantity| {
            let names = quantity.columns.iter().enumerate();
            names.map(move |(joint, name)| (*name, quantity, joint))
        })
    };
    let Some(names) = names else {
        return Ok(all().collect());
    };
    let mut columns = Vec::new();
    for name in names {
        let before = columns.len();
        columns.extend(all().filter(|(column, it, _)| column == name || it.name == name));
        if columns.len() == before {
            let near = nearest(name, all().map(|(column, ..)| column));
            let near = near.map_or_else(String::new, |near| format!("; is it `{near}`?"));
            return Err(Failure::request(format!(
                "there is no column `{name}`{near}"
            )));
        }
    }
    Ok(columns)
}

/// Columns of these ticks.
pub(super) fn fields(records: &[Vec<Record>], columns: &[Column]) -> Fields {
    let arrays = columns.iter().map(|(name, quantity, joint)| {
        let records = records.iter().flatten();
        let values = match quantity.values {
            Values::Word(words, get) => {
                let words = words.all();
                let word = |record| Value::from(words[get(record, *joint)].as_str());
                records.map(word).collect()
            }
            values => records.map(|it| number(values, it, *joint)).collect(),
        };
        ((*name).to_owned(), Value::Array(values))
    });
    let columns: Map<String, Value> = arrays.collect();
    Map::from_iter([("columns".into(), Value::Object(columns))])
}

/// A number; `null` where it is missing.
fn number(values: Values, record: &Record, joint: usize) -> Value {
    match values {
        Values::F64(get) => get(record).into(),
        Values::F32(get) => get(record, joint).into(),
        Values::U32(get) => get(record).into(),
        Values::U16(get) => get(record, joint).into(),
        Values::Sample(get) => get(record, joint).into(),
        Values::Word(..) | Values::Truth(_) => Value::Null,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_named_as_everywhere_and_a_quantity_is_those_of_both_joints() {
        let names = ["tick".into(), "angle_rad".into(), "pwm_counts_2".into()];
        let columns = columns(Some(&names)).unwrap();
        let records = [vec![Record::NONE; 2]];
        let fields = fields(&records, &columns);
        let names: Vec<&String> = fields["columns"].as_object().unwrap().keys().collect();
        assert_eq!(
            names,
            ["angle_rad_1", "angle_rad_2", "pwm_counts_2", "tick"]
        );
        assert_eq!(fields["columns"]["tick"].as_array().unwrap().len(), 2);
        let error = super::columns(Some(&["angel_rad_1".into()])).unwrap_err();
        assert!(format!("{error:?}").contains("is it `angle_rad_1`"));
    }
}
