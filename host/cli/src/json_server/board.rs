//! A request carried out by a board client.

use std::sync::Arc;
use std::time::{Duration, Instant};

use armbridge_client::experiment_text;
use armbridge_client::params;
use armbridge_client::params::ReplaceError;
use armbridge_client::status_summary::StatusSummary;
use armbridge_link::message::{Command, Settings};
use armbridge_link::server::Touch;
use armbridge_servo::JOINTS;
use armbridge_sim::link::{BoardClient, SetpointSender};
use serde_json::{Map, Value, json};

use super::answer::{Failure, Fields};
use super::block;
use super::request::Request;

/// Time by which a setpoint is sent ahead: network and programs delay some.
const LEAD: Duration = Duration::from_millis(30);
/// Longest wait for a motion, beyond its duration if it has one.
const MOTION: Duration = Duration::from_secs(30);
/// Longest wait for ticks, beyond the time that they take at 1 kHz.
const TICKS: Duration = Duration::from_secs(5);

/// A board, and a stream of setpoints to it.
pub(super) struct Board {
    client: Arc<BoardClient>,
    setpoints: SetpointSender,
    /// Time of a stream's first setpoint in s, by the program's clock.
    first_s: Option<f64>,
}

impl Board {
    pub(super) fn new(client: Arc<BoardClient>) -> Self {
        Self {
            client,
            setpoints: SetpointSender::new(LEAD),
            first_s: None,
        }
    }

    /// Carries out a request.
    pub(super) fn perform(&mut self, request: Request) -> Result<Fields, Failure> {
        let client = Arc::clone(&self.client);
        if !matches!(
            request,
            Request::Stream { .. } | Request::Status {} | Request::Take { .. }
        ) {
            self.setpoints.end();
            self.first_s = None;
        }
        match request {
            // By the way in which the link was opened.
            Request::Observe {} => {}
            Request::Arm {} => client.arm()?,
            Request::Disarm {} => client.disarm()?,
            Request::Park {} => client.park()?,
            Request::Stop {} => client.stop()?,
            Request::Clear {} => client.clear()?,
            Request::Float {} => client.command(Command::Float)?,
            Request::Regulate { angle_rad } => {
                client.command(Command::Regulate(finite(angle_rad)?))?;
            }
            Request::Move {
                angle_rad,
                duration_s,
                wait,
            } => {
                let motion = client.move_to(finite(angle_rad)?, duration_s)?;
                if wait {
                    let lasts = duration_s.map_or(Ok(Duration::ZERO), seconds)?;
                    client.wait_for(&motion, lasts.saturating_add(MOTION))?;
                }
            }
            Request::Stream {
                t_s,
                angle_rad,
                speed_rad_s,
            } => return self.stream(t_s, finite(angle_rad)?, speed_rad_s),
            Request::Torque { torque_nm } => client.command(Command::Torque(finite(torque_nm)?))?,
            Request::Experiment { experiment } => {
                let conclusion = client.experiment(&experiment)?;
                return Ok(Map::from_iter([
                    (
                        "whole".into(),
                        experiment_text::is_whole(&conclusion).into(),
                    ),
                    (
                        "text".into(),
                        experiment_text::conclusion(&conclusion).into(),
                    ),
                ]));
            }
            Request::Set { parameters, save } => {
                let after = changed(&self.in_force(), &parameters)
                    .map_err(|error| Failure::request(error.to_string()))?;
                client.set(&after, save)?;
            }
            Request::Get {} => return Ok(parameters(&self.in_force())),
            Request::Status {} => return Ok(self.status()),
            Request::Take {
                ticks,
                columns,
                timeout_s,
            } => return self.take(ticks, columns.as_deref(), timeout_s),
            Request::Push {
                joint,
                torque_nm,
                duration_s,
            } => client.push(joint, torque_nm, seconds(duration_s)?)?,
            Request::Lift {} => client.thread().touch(Touch::Lift),
        }
        Ok(Fields::new())
    }

    fn in_force(&self) -> Settings {
        self.client.status().settings.unwrap_or_default()
    }

    fn status(&self) -> Fields {
        let summary = StatusSummary::from(&self.client.status());
        let mut fields = match serde_json::to_value(summary) {
            Ok(Value::Object(fields)) => fields,
            // A structure is an object.
            _ => Fields::new(),
        };
        fields.insert("lost".into(), self.client.telemetry().lost().into());
        fields
    }

    fn take(
        &self,
        ticks: Option<usize>,
        columns: Option<&[String]>,
        timeout_s: Option<f32>,
    ) -> Result<Fields, Failure> {
        let waiting = || self.client.telemetry().waiting().min(block::TICKS_MAX);
        let ticks = ticks.unwrap_or_else(waiting);
        if ticks > block::TICKS_MAX {
            let max = block::TICKS_MAX;
            return Err(Failure::request(format!(
                "a block has at most {max} ticks, not {ticks}: take several"
            )));
        }
        let columns = block::columns(columns)?;
        let lasts = Duration::from_millis(ticks as u64);
        let timeout = timeout_s.map_or(Ok(lasts.saturating_add(TICKS)), seconds)?;
        let records = self.client.take(ticks, timeout)?;
        let mut fields = block::fields(&records, &columns);
        fields.insert("lost".into(), self.client.telemetry().lost().into());
        Ok(fields)
    }

    fn stream(
        &mut self,
        t_s: Option<f64>,
        angle_rad: [f32; JOINTS],
        speed_rad_s: Option<[f32; JOINTS]>,
    ) -> Result<Fields, Failure> {
        let first_s = *self.first_s.get_or_insert(t_s.unwrap_or(0.0));
        let since = t_s.map(|t_s| Duration::try_from_secs_f64(t_s - first_s));
        let deadline = match since {
            Some(Ok(since)) => self.setpoints.deadline(since),
            Some(Err(_)) => return Err(Failure::request("times of a stream do not go back")),
            None => Instant::now(),
        };
        let speed_rad_s = speed_rad_s.map(finite).transpose()?;
        let setpoints = &mut self.setpoints;
        let is_late = setpoints.send(&self.client, deadline, angle_rad, speed_rad_s)?;
        Ok(Map::from_iter([("late".into(), is_late.into())]))
    }
}

/// Numbers of single precision, as the board has them.
fn finite(values: [f32; JOINTS]) -> Result<[f32; JOINTS], Failure> {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(values);
    }
    Err(Failure::request("the numbers are too large"))
}

fn seconds(value: f32) -> Result<Duration, Failure> {
    Duration::try_from_secs_f32(value)
        .map_err(|_| Failure::request(format!("expected a time in s, got {value}")))
}

/// These settings with parameters replaced. A JSON value is written as one of TOML.
fn changed(before: &Settings, parameters: &Map<String, Value>) -> Result<Settings, ReplaceError> {
    let value = |value: &Value| params::of_text(&value.to_string());
    let pairs = parameters.iter().map(|(key, it)| (key.as_str(), value(it)));
    let pairs: Vec<_> = pairs.collect();
    params::replaced(before, pairs.iter().map(|(key, value)| (*key, value)))
}

fn parameters(settings: &Settings) -> Fields {
    let pairs = params::pairs(settings).into_iter();
    let all: Map<String, Value> = pairs
        .map(|(parameter, value)| (parameter.key.to_owned(), json!(value)))
        .collect();
    Map::from_iter([("parameters".into(), Value::Object(all))])
}
