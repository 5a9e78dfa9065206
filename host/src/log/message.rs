//! A tick as a JSON message, described by a JSON schema.
//!
//! Field names carry units. What is absent is left out, never a number: a
//! sample is either `{"counts": 512}` or `{"missing": "silence"}`. Viewers
//! take a property that comes and goes as a gap in the plot; unions such as
//! `["integer", "null"]` are what some of them refuse, so the schema has none.
//! A value that is not finite is `null` in JSON and comes back as NaN.

use super::names;
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Command, Limits, Record, Sample, Setup, Timing};
use armbridge_shared::link::motion::Motion;
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;

/// JSON schema of [`TickMessage`].
pub const TICK_SCHEMA: &str = include_str!("tick.schema.json");

/// JSON schema of [`CommandMessage`].
pub const COMMAND_SCHEMA: &str = include_str!("command.schema.json");

/// One [`Record`] in words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TickMessage<'a> {
    tick: u32,
    start_us: u64,
    mode: Cow<'a, str>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fault: Option<Cow<'a, str>>,
    guards: Cow<'a, str>,
    samples: [SampleMessage<'a>; JOINTS],
    alarms: [Cow<'a, str>; JOINTS],
    pwm_in_force: [u16; JOINTS],
    pwm_next: [u16; JOINTS],
    #[serde(deserialize_with = "null_is_nan")]
    reference_rad: [f32; JOINTS],
    #[serde(deserialize_with = "null_is_nan")]
    reference_speed_rad_s: [f32; JOINTS],
    #[serde(deserialize_with = "null_is_nan")]
    angle_rad: [f32; JOINTS],
    #[serde(deserialize_with = "null_is_nan")]
    speed_rad_s: [f32; JOINTS],
    #[serde(deserialize_with = "null_is_nan")]
    torque_nm: [f32; JOINTS],
    #[serde(deserialize_with = "null_is_nan")]
    disturbance_nm: [f32; JOINTS],
    start_error_us: u32,
    bus_us: u32,
    compute_ns: u32,
    missed_ticks: u32,
    dropped_records: u32,
}

/// What a servo answered: exactly one of the two is there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct SampleMessage<'a> {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    counts: Option<u16>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    missing: Option<Cow<'a, str>>,
}

/// A command of the host, at the time it was sent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CommandMessage<'a> {
    /// `idle`, `arm`, `torque`, `regulate`, `follow`, `stream`, `prepare`,
    /// `release`, `clear_fault`, `configure`, `limit` or `save`.
    pub kind: Cow<'a, str>,
    /// Torques of a `torque` command in N m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_nm: Option<[f32; JOINTS]>,
    /// Reference of a `regulate` or `stream` command in rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_rad: Option<[f32; JOINTS]>,
    /// When a `stream` command's reference holds, in µs of the board's clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_us: Option<u64>,
    /// Motion of a `follow` command.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
    /// Set-up of a `configure` command.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setup: Option<Setup>,
    /// Limits of a `limit` command.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<Limits>,
}

/// Serde hook: reads `null` as NaN, as which a number that is not finite was
/// written.
fn null_is_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f32; JOINTS], D::Error> {
    <[Option<f32>; JOINTS]>::deserialize(deserializer).map(|v| v.map(|x| x.unwrap_or(f32::NAN)))
}

impl From<&Record> for TickMessage<'static> {
    fn from(record: &Record) -> Self {
        let fault = names::fault_of(record.mode);
        Self {
            tick: record.tick,
            start_us: record.start_us,
            mode: names::mode(record.mode).into(),
            fault: fault.map(|fault| names::fault(fault).into()),
            guards: names::guards(record.guards).into(),
            samples: record.samples.map(|sample| match sample {
                Sample::Counts(counts) => SampleMessage {
                    counts: Some(counts),
                    missing: None,
                },
                Sample::Missing(missing) => SampleMessage {
                    counts: None,
                    missing: Some(names::missing(missing).into()),
                },
            }),
            alarms: record.alarms.map(|bits| names::alarms(bits).into()),
            pwm_in_force: record.pwm_in_force,
            pwm_next: record.pwm_next,
            reference_rad: record.reference_rad,
            reference_speed_rad_s: record.reference_speed_rad_s,
            angle_rad: record.angle_rad,
            speed_rad_s: record.speed_rad_s,
            torque_nm: record.torque_nm,
            disturbance_nm: record.disturbance_nm,
            start_error_us: record.timing.start_error_us,
            bus_us: record.timing.bus_us,
            compute_ns: record.timing.compute_ns,
            missed_ticks: record.timing.missed,
            dropped_records: record.dropped,
        }
    }
}

impl TickMessage<'_> {
    /// The record this was made from; none if a word in it is unknown.
    pub fn record(&self) -> Option<Record> {
        let [first, second] = &self.samples;
        Some(Record {
            tick: self.tick,
            start_us: self.start_us,
            mode: names::mode_from(&self.mode, self.fault.as_deref().unwrap_or_default())?,
            guards: names::guards_from(&self.guards)?,
            samples: [first.sample()?, second.sample()?],
            alarms: [
                names::alarms_from(&self.alarms[0])?,
                names::alarms_from(&self.alarms[1])?,
            ],
            pwm_in_force: self.pwm_in_force,
            pwm_next: self.pwm_next,
            reference_rad: self.reference_rad,
            reference_speed_rad_s: self.reference_speed_rad_s,
            angle_rad: self.angle_rad,
            speed_rad_s: self.speed_rad_s,
            torque_nm: self.torque_nm,
            disturbance_nm: self.disturbance_nm,
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

impl SampleMessage<'_> {
    fn sample(&self) -> Option<Sample> {
        match (self.counts, &self.missing) {
            (Some(counts), None) => Some(Sample::Counts(counts)),
            (None, Some(name)) => names::missing_from(name).map(Sample::Missing),
            _ => None,
        }
    }
}

impl From<&Command> for CommandMessage<'static> {
    fn from(command: &Command) -> Self {
        let mut message = Self {
            kind: names::command(command).into(),
            torque_nm: None,
            reference_rad: None,
            at_us: None,
            motion: None,
            setup: None,
            limits: None,
        };
        match *command {
            Command::Idle
            | Command::Arm { .. }
            | Command::Prepare
            | Command::Release
            | Command::ClearFault
            | Command::Save => {}
            Command::Torque(torque_nm) => message.torque_nm = Some(torque_nm),
            Command::Regulate(reference_rad) => message.reference_rad = Some(reference_rad),
            Command::Follow(motion) => message.motion = Some(motion),
            Command::Stream {
                at_us, angle_rad, ..
            } => {
                message.at_us = Some(at_us);
                message.reference_rad = Some(angle_rad);
            }
            Command::Configure(setup) => message.setup = Some(setup),
            Command::Limit(limits) => message.limits = Some(limits),
        }
        message
    }
}
