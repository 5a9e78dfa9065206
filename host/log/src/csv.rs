//! `run.csv`: one row per tick, for spreadsheets and scripts.
//!
//! Column names carry units; `1` and `2` are the joints. `time_s` is the
//! board's clock. A missing sample leaves `count` empty and says why in
//! `missing`; `alarms` are a stock servo's, with `+` between them; `fault` is
//! empty but in mode `fault`; `guards` says what the supervisor changed of the
//! wanted torque. Rows end in a line feed.

use std::borrow::Cow;
use std::fs::File;
use std::path::{Path, PathBuf};

use armbridge_client::enum_names;
use armbridge_shared::link::message::{Record, Sample, Timing};
use serde::{Deserialize, Serialize};

use super::LogError;

/// One row; the fields are the columns, in this order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row<'a> {
    time_s: f64,
    tick: u32,
    mode: Cow<'a, str>,
    fault: Cow<'a, str>,
    guards: Cow<'a, str>,
    q1_ref_rad: f32,
    dq1_ref_rad_s: f32,
    q1_rad: f32,
    dq1_rad_s: f32,
    count1: Option<u16>,
    missing1: Cow<'a, str>,
    alarms1: Cow<'a, str>,
    torque1_nm: f32,
    disturbance1_nm: f32,
    pwm1_in_force: u16,
    pwm1_next: u16,
    q2_ref_rad: f32,
    dq2_ref_rad_s: f32,
    q2_rad: f32,
    dq2_rad_s: f32,
    count2: Option<u16>,
    missing2: Cow<'a, str>,
    alarms2: Cow<'a, str>,
    torque2_nm: f32,
    disturbance2_nm: f32,
    pwm2_in_force: u16,
    pwm2_next: u16,
    start_error_us: u32,
    bus_us: u32,
    compute_ns: u32,
    missed_ticks: u32,
    dropped_records: u32,
}

/// Writes `run.csv`.
pub struct CsvWriter {
    path: PathBuf,
    writer: csv::Writer<File>,
}

impl CsvWriter {
    /// Creates the file.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub fn create(path: &Path) -> Result<Self, LogError> {
        let writer = csv::WriterBuilder::new()
            .buffer_capacity(1 << 16)
            .from_path(path)
            .map_err(|source| LogError::Csv {
                path: path.to_path_buf(),
                source,
            })?;
        Ok(Self {
            path: path.to_path_buf(),
            writer,
        })
    }

    /// Appends a tick.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn record(&mut self, record: &Record) -> Result<(), LogError> {
        self.writer
            .serialize(Row::from(record))
            .map_err(|source| LogError::Csv {
                path: self.path.clone(),
                source,
            })
    }

    /// Writes what is left and closes the file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<(), LogError> {
        self.writer.flush().map_err(|source| LogError::Io {
            path: self.path,
            source,
        })
    }
}

impl std::fmt::Debug for CsvWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("CsvWriter")
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

/// The two columns of a sample: count and reason.
fn columns(sample: Sample) -> (Option<u16>, Cow<'static, str>) {
    match sample {
        Sample::Counts(counts) => (Some(counts), "".into()),
        Sample::Missing(missing) => (None, enum_names::missing(missing).into()),
    }
}

/// The sample from its two columns.
fn sample(count: Option<u16>, missing: &str) -> Option<Sample> {
    match count {
        Some(counts) => missing.is_empty().then_some(Sample::Counts(counts)),
        None => enum_names::missing_from(missing).map(Sample::Missing),
    }
}

impl From<&Record> for Row<'static> {
    fn from(record: &Record) -> Self {
        let [(count1, missing1), (count2, missing2)] = record.samples.map(columns);
        Self {
            time_s: record.start_us as f64 / 1e6,
            tick: record.tick,
            mode: enum_names::mode(record.mode).into(),
            fault: enum_names::fault_of(record.mode)
                .map_or("", enum_names::fault)
                .into(),
            guards: enum_names::guards(record.guards).into(),
            q1_ref_rad: record.reference_rad[0],
            dq1_ref_rad_s: record.reference_speed_rad_s[0],
            q1_rad: record.angle_rad[0],
            dq1_rad_s: record.speed_rad_s[0],
            count1,
            missing1,
            alarms1: enum_names::alarms(record.alarms[0]).into(),
            torque1_nm: record.torque_nm[0],
            disturbance1_nm: record.disturbance_nm[0],
            pwm1_in_force: record.pwm_in_force[0],
            pwm1_next: record.pwm_next[0],
            q2_ref_rad: record.reference_rad[1],
            dq2_ref_rad_s: record.reference_speed_rad_s[1],
            q2_rad: record.angle_rad[1],
            dq2_rad_s: record.speed_rad_s[1],
            count2,
            missing2,
            alarms2: enum_names::alarms(record.alarms[1]).into(),
            torque2_nm: record.torque_nm[1],
            disturbance2_nm: record.disturbance_nm[1],
            pwm2_in_force: record.pwm_in_force[1],
            pwm2_next: record.pwm_next[1],
            start_error_us: record.timing.start_error_us,
            bus_us: record.timing.bus_us,
            compute_ns: record.timing.compute_ns,
            missed_ticks: record.timing.missed,
            dropped_records: record.dropped,
        }
    }
}

impl Row<'_> {
    /// The record this was made from; none if a word in it is unknown.
    pub fn record(&self) -> Option<Record> {
        Some(Record {
            tick: self.tick,
            start_us: (self.time_s * 1e6).round() as u64,
            mode: enum_names::mode_from(&self.mode, &self.fault)?,
            guards: enum_names::guards_from(&self.guards)?,
            samples: [
                sample(self.count1, &self.missing1)?,
                sample(self.count2, &self.missing2)?,
            ],
            alarms: [
                enum_names::alarms_from(&self.alarms1)?,
                enum_names::alarms_from(&self.alarms2)?,
            ],
            pwm_in_force: [self.pwm1_in_force, self.pwm2_in_force],
            pwm_next: [self.pwm1_next, self.pwm2_next],
            reference_rad: [self.q1_ref_rad, self.q2_ref_rad],
            reference_speed_rad_s: [self.dq1_ref_rad_s, self.dq2_ref_rad_s],
            angle_rad: [self.q1_rad, self.q2_rad],
            speed_rad_s: [self.dq1_rad_s, self.dq2_rad_s],
            torque_nm: [self.torque1_nm, self.torque2_nm],
            disturbance_nm: [self.disturbance1_nm, self.disturbance2_nm],
            timing: Timing {
                start_error_us: self.start_error_us,
                bus_us: self.bus_us,
                compute_ns: self.compute_ns,
                missed: self.missed_ticks,
            },
            dropped: self.dropped_records,
        })
    }
}
