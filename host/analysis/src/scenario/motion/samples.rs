//! Samples of a motion in a CSV file: time and angles of both joints, optionally speeds.
//!
//! The header names each column with its unit, as [`COLUMNS`] lists; columns are in any
//! order. Empty lines, and lines that begin with `#`, are left out.

use std::f64::consts::PI;
use std::ops::Range;

use armbridge_board::bridge::limits::REFERENCE_MAX_RAD;
use armbridge_servo::JOINTS;

/// A sample, and the line that it is in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    /// Time in s, of the file's clock.
    pub(super) at_s: f64,
    /// Angles in rad.
    pub(super) angle_rad: [f64; JOINTS],
    /// Speeds in rad/s, if the file has them.
    pub(super) speed_rad_s: Option<[f64; JOINTS]>,
    /// First byte of the line.
    pub(super) byte: usize,
}

/// A mistake at a byte of the text.
pub(super) type Mistake = (usize, String);

/// Meaning of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    Time,
    Angle(usize),
    Speed(usize),
}

/// Names of columns, their meaning, and the factor to s, rad and rad/s.
const COLUMNS: [(&str, Column, f64); 14] = [
    ("time_s", Column::Time, 1.0),
    ("time_ms", Column::Time, 1e-3),
    ("time_us", Column::Time, 1e-6),
    ("t_s", Column::Time, 1.0),
    ("t_ms", Column::Time, 1e-3),
    ("t_us", Column::Time, 1e-6),
    ("q1_rad", Column::Angle(0), 1.0),
    ("q2_rad", Column::Angle(1), 1.0),
    ("q1_deg", Column::Angle(0), PI / 180.0),
    ("q2_deg", Column::Angle(1), PI / 180.0),
    ("dq1_rad_s", Column::Speed(0), 1.0),
    ("dq2_rad_s", Column::Speed(1), 1.0),
    ("dq1_deg_s", Column::Speed(0), PI / 180.0),
    ("dq2_deg_s", Column::Speed(1), PI / 180.0),
];

/// Largest number of samples: an hour at 1 kHz.
const SAMPLES_MAX: usize = 3_600_000;

/// Parses the text of a file.
pub(super) fn parse(text: &str) -> Result<Vec<Sample>, Mistake> {
    let mut lines = lines(text);
    let Some(head) = lines.next() else {
        return Err((
            0,
            format!("the file is empty; expected a header: {}", accepted()),
        ));
    };
    let columns = header(text, head)?;
    let mut samples: Vec<Sample> = Vec::new();
    for line in lines {
        let sample = sample(text, line.clone(), &columns)?;
        if let Some(before) = samples.last()
            && sample.at_s <= before.at_s
        {
            let message = format!(
                "times grow from line to line: {} s comes after {} s",
                sample.at_s, before.at_s
            );
            return Err((place_of(text, &line, &columns, Column::Time), message));
        }
        if samples.len() == SAMPLES_MAX {
            return Err((line.start, format!("more than {SAMPLES_MAX} samples")));
        }
        if let Some(joint) = beyond(&sample) {
            let message = format!(
                "joint {} would be at {:.4} rad, outside the board's range from \
                 -{REFERENCE_MAX_RAD} to {REFERENCE_MAX_RAD} rad",
                joint + 1,
                sample.angle_rad[joint]
            );
            return Err((
                place_of(text, &line, &columns, Column::Angle(joint)),
                message,
            ));
        }
        samples.push(sample);
    }
    if samples.len() < 2 {
        let message = format!(
            "a motion has at least 2 samples, and this file has {}",
            samples.len()
        );
        return Err((text.len(), message));
    }
    Ok(samples)
}

fn beyond(sample: &Sample) -> Option<usize> {
    let limit = f64::from(REFERENCE_MAX_RAD);
    sample.angle_rad.iter().position(|q| q.abs() > limit)
}

/// Lines with something in them, as byte ranges.
fn lines(text: &str) -> impl Iterator<Item = Range<usize>> + Clone {
    // Some programs put a byte order mark first.
    let mut next = if text.starts_with('\u{feff}') { 3 } else { 0 };
    let lines = std::iter::from_fn(move || {
        let rest = text.get(next..).filter(|rest| !rest.is_empty())?;
        let length = rest.find('\n').unwrap_or(rest.len());
        let line = next..next + length;
        next = (line.end + 1).min(text.len());
        Some(line)
    });
    let lines: Vec<Range<usize>> = lines
        .filter(|line| {
            let line = text[line.clone()].trim();
            !line.is_empty() && !line.starts_with('#')
        })
        .collect();
    lines.into_iter()
}

/// Fields of a line, as byte ranges without the space around them.
fn fields(text: &str, line: Range<usize>) -> Vec<Range<usize>> {
    let mut at = line.start;
    let fields = text[line].split(',').map(|field| {
        let start = at + field.len() - field.trim_start().len();
        at += field.len() + 1;
        start..start + field.trim().len()
    });
    fields.collect()
}

fn accepted() -> String {
    let names: Vec<&str> = COLUMNS.iter().map(|(name, ..)| *name).collect();
    names.join(", ")
}

/// The file's columns with their factors, from its header.
fn header(text: &str, line: Range<usize>) -> Result<Vec<(Column, f64)>, Mistake> {
    let mut columns: Vec<(Column, f64)> = Vec::new();
    for field in fields(text, line.clone()) {
        let name = text[field.clone()].trim_matches('"').to_ascii_lowercase();
        let Some((_, column, factor)) = COLUMNS.iter().find(|(known, ..)| *known == name) else {
            let what = if name.parse::<f64>().is_ok() {
                "the first line is a header".to_owned()
            } else {
                format!("there is no column `{name}`")
            };
            return Err((field.start, format!("{what}; accepted are {}", accepted())));
        };
        if columns.iter().any(|(known, _)| known == column) {
            return Err((field.start, format!("`{name}` repeats a column before it")));
        }
        columns.push((*column, *factor));
    }
    let has = |column| columns.iter().any(|(known, _)| *known == column);
    let missing = [
        (Column::Time, "time_s"),
        (Column::Angle(0), "q1_rad"),
        (Column::Angle(1), "q2_rad"),
    ];
    if let Some((_, name)) = missing.iter().find(|(column, _)| !has(*column)) {
        return Err((
            line.start,
            format!("a column is missing: `{name}`, or its like in another unit"),
        ));
    }
    if has(Column::Speed(0)) != has(Column::Speed(1)) {
        let message = "speeds are those of both joints, or of none";
        return Err((line.start, message.into()));
    }
    Ok(columns)
}

fn sample(text: &str, line: Range<usize>, columns: &[(Column, f64)]) -> Result<Sample, Mistake> {
    let fields = fields(text, line.clone());
    if fields.len() != columns.len() {
        let (count, expected) = (fields.len(), columns.len());
        // The first field too many, or the end of a line that lacks some.
        let at = fields.get(expected).map_or(line.end, |field| field.start);
        return Err((
            at,
            format!("{count} columns, and the header has {expected}"),
        ));
    }
    let mut sample = Sample {
        at_s: 0.0,
        angle_rad: [0.0; JOINTS],
        speed_rad_s: None,
        byte: line.start,
    };
    for (field, (column, factor)) in fields.into_iter().zip(columns) {
        let number = &text[field.clone()];
        let value = number.parse::<f64>().ok().filter(|value| value.is_finite());
        let value = value.ok_or_else(|| (field.start, format!("`{number}` is no number")))?;
        let value = value * factor;
        match *column {
            Column::Time => sample.at_s = value,
            Column::Angle(joint) => sample.angle_rad[joint] = value,
            Column::Speed(joint) => sample.speed_rad_s.get_or_insert([0.0; JOINTS])[joint] = value,
        }
    }
    Ok(sample)
}

/// Byte of a line's field in a column.
fn place_of(text: &str, line: &Range<usize>, columns: &[(Column, f64)], column: Column) -> usize {
    let number = columns.iter().position(|(known, _)| *known == column);
    let fields = fields(text, line.clone());
    let field = number.and_then(|number| fields.get(number));
    field.map_or(line.start, |field| field.start)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_of_the_header() {
        let text = "\u{feff}# made by hand\nt_ms, Q1_deg ,q2_rad\n\n0,0,0.1\n 100 ,90e-1,-0.1\r\n";
        let samples = parse(text).unwrap();
        assert_eq!(samples.len(), 2);
        assert!((samples[1].at_s - 0.1).abs() < 1e-12);
        assert!((samples[1].angle_rad[0] - 0.157_079_632).abs() < 1e-8);
        assert!((samples[1].angle_rad[1] + 0.1).abs() < 1e-12);
        assert_eq!(samples[1].speed_rad_s, None);
        let text = "time_s,q1_rad,q2_rad,dq1_deg_s,dq2_rad_s\n0,0,0,180,1\n1,0,0,0,0";
        let speed = parse(text).unwrap()[0].speed_rad_s.unwrap();
        assert!((speed[0] - PI).abs() < 1e-12 && (speed[1] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn mistakes_have_their_place() {
        let head = "time_s,q1_rad,q2_rad\n";
        for (text, at, words) in [
            ("", 0, "empty"),
            ("0,0,0\n", 0, "header"),
            (
                "time_s,q1,q2_rad\n",
                7,
                "no column `q1`; accepted are time_s",
            ),
            ("time_s,q1_rad\n", 0, "`q2_rad`"),
            ("time_s,t_ms,q1_rad,q2_rad\n", 7, "repeats"),
            ("time_s,q1_rad,q2_rad,dq1_rad_s\n", 0, "both joints"),
        ] {
            let (byte, message) = parse(text).unwrap_err();
            assert!(
                byte == at && message.contains(words),
                "{text}: {byte} {message}"
            );
        }
        for (rows, at, words) in [
            ("0,0,0\n0.1,x,0\n", 10, "`x` is no number"),
            ("0,0,0\n0.1,nan,0\n", 10, "no number"),
            ("0,0,0\n0.1,0\n", 11, "2 columns, and the header has 3"),
            ("0,0,0\n0.1,0,0,0\n", 14, "4 columns"),
            ("0,0,0\n0,0,0\n", 6, "times grow"),
            ("0,0,0\n1,0,1.3\n", 10, "joint 2 would be at 1.3000 rad"),
            ("0,0,0\n", 6, "at least 2 samples"),
        ] {
            let (byte, message) = parse(&format!("{head}{rows}")).unwrap_err();
            let at = head.len() + at;
            assert!(
                byte == at && message.contains(words),
                "{rows}: {byte} {at} {message}"
            );
        }
    }
}
