//! Steps of a plan, performed on a board that a program has connected to.
//!
//! Times are those of the board's ticks. Of the plan's stop conditions its duration counts, and
//! pushes and hands are left out: the arm is the program's.

use std::time::Duration;

use armbridge_client::params::ParameterError;
use armbridge_client::session::ANSWER_TIMEOUT_US;
use armbridge_link::message::{Command, Record, Settings};
use armbridge_sim::link::{BoardClient, ClientError};

use super::plan::{Action, InitialSettings, Plan};
use super::timeline::{Due, Timeline};

/// Time beyond that of the next step, after which the board is taken to be silent.
const TICK_TIMEOUT: Duration = Duration::from_micros(ANSWER_TIMEOUT_US);

/// Reason for which the steps were not performed.
#[derive(Debug, thiserror::Error)]
pub enum PerformError {
    /// A call to the board failed.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// A setting of the plan is none of the board's.
    #[error(transparent)]
    Setting(#[from] ParameterError),
}

/// A plan that was performed.
#[derive(Debug)]
pub struct Performed {
    /// Settings in force meanwhile.
    pub settings: Settings,
    /// Records of all its ticks.
    pub records: Vec<Record>,
}

/// Performs the steps of a plan, with its settings; after a change of its own the board has those
/// that it had before again. An arm that was not armed is armed for it, and parked or let go of at the end.
///
/// # Errors
/// If the board refuses a command, or finds a fault; the arm is parked or let go of.
pub fn perform(client: &BoardClient, plan: &Plan) -> Result<Performed, PerformError> {
    let before = client.status().settings.unwrap_or_default();
    let settings = match &plan.begin {
        InitialSettings::Fixed(settings) => **settings,
        InitialSettings::Changed(change) => change.apply(&before)?,
    };
    let was_armed = client.is_armed();
    client.set(&settings, false)?;
    client.telemetry().begin_copy();
    let followed = arm(client).and_then(|()| follow(client, plan, &settings));
    let records = client.telemetry().end_copy();
    let left = match &followed {
        Ok(()) if was_armed => Ok(()),
        _ => client.park(),
    };
    let restored = match plan.begin {
        InitialSettings::Changed(_) => client.set(&before, false),
        InitialSettings::Fixed(_) => Ok(()),
    };
    followed?;
    left?;
    restored?;
    Ok(Performed { settings, records })
}

fn arm(client: &BoardClient) -> Result<(), PerformError> {
    if client.is_armed() {
        return Ok(());
    }
    Ok(client.arm()?)
}

fn follow(client: &BoardClient, plan: &Plan, settings: &Settings) -> Result<(), PerformError> {
    let now_us = |record: Option<Record>| record.map_or(0, |record| record.input.start_us);
    let begun_us = now_us(client.status().record);
    let mut timeline = Timeline::new(begun_us);
    loop {
        let elapsed_us = now_us(client.status().record).saturating_sub(begun_us);
        while let Some(due) = timeline.take(elapsed_us, &plan.steps) {
            match due {
                Due::Step(Action::Command(command)) => client.command(*command)?,
                Due::Step(Action::Arm) => client.arm()?,
                Due::Step(Action::Change(change)) => client.set(&change.apply(settings)?, false)?,
                // The timeline has its points.
                Due::Step(Action::Stream(_)) => {}
                Due::Point(point, since_us) => client.command(Command::Stream {
                    at_us: begun_us + since_us + point.after_us,
                    angle_rad: point.angle_rad,
                    speed_rad_s: point.speed_rad_s,
                })?,
            }
        }
        if elapsed_us >= plan.stop.after_us {
            return Ok(());
        }
        let next_us = timeline.due_us(&plan.steps).unwrap_or(u64::MAX);
        let until_us = begun_us + next_us.min(plan.stop.after_us);
        let left_us = until_us.saturating_sub(begun_us + elapsed_us);
        client.wait_without_fault(
            TICK_TIMEOUT.saturating_add(Duration::from_micros(left_us)),
            "no tick came",
            |status| now_us(status.record) >= until_us,
        )?;
    }
}
