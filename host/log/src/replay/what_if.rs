//! Replay with other settings: the board's reaction to the same inputs.
//!
//! Open-loop: the arm's motion is the recorded one, so the
//! farther the torques diverge, the less the rest means. It shows the effect of a change
//! on estimate and torque, tick by tick, and the limits that would have
//! tripped, but not the motion of the arm.

use std::collections::BTreeMap;
use std::fmt;

use armbridge_client::params;
use armbridge_client::params::ParameterError;
use armbridge_link::message::{Record, Settings, TickOutput};
use armbridge_servo::JOINTS;
use serde::Serialize;
use toml::Value;

use crate::text_table;

/// Changed settings, applied wherever the log has settings.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    table: toml::Table,
    pairs: Vec<(String, Value)>,
}

/// Reason for which settings cannot be changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ChangeError {
    /// Error of the parameter.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// Error of the settings as a whole.
    #[error(
        "`setup.period_us` is that of the recorded ticks, {0}; `armbridge trials` tries others"
    )]
    Period(u32),
}

impl Changes {
    /// A table of tables, as in a file, and then single parameters.
    pub fn new(table: toml::Table, pairs: Vec<(String, Value)>) -> Self {
        Self { table, pairs }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.table.is_empty() && self.pairs.is_empty()
    }

    /// The settings with the changes.
    ///
    /// # Errors
    /// If one of them is not valid.
    pub fn apply(&self, settings: &Settings) -> Result<Settings, ChangeError> {
        let mut changed = *settings;
        params::apply_table(&mut changed, &self.table)?;
        let pairs = self.pairs.iter().map(|(key, value)| (key.as_str(), value));
        params::apply(&mut changed, pairs)?;
        let period_us = settings.setup.period_us;
        if changed.setup.period_us != period_us {
            return Err(ChangeError::Period(period_us));
        }
        Ok(changed)
    }
}

/// Changed settings with their new values, as typed.
pub(super) fn changed(
    before: &Settings,
    after: &Settings,
) -> impl Iterator<Item = (&'static str, String)> {
    let changed = params::changed(before, after).into_iter();
    changed.map(|(parameter, value)| (parameter.key, params::to_text(&value)))
}

/// A joint's torque and estimate, as recorded and as computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct JointChange {
    /// Torque in N m, rms, as recorded.
    pub torque_rms_recorded_nm: f64,
    /// The same as computed.
    pub torque_rms_computed_nm: f64,
    /// Largest torque in N m, as recorded.
    pub torque_max_recorded_nm: f64,
    /// The same as computed.
    pub torque_max_computed_nm: f64,
    /// Rms difference of the two, in N m.
    pub torque_difference_rms_nm: f64,
    /// Largest difference, in N m.
    pub torque_difference_max_nm: f64,
    /// Rms difference of the estimated angles, in rad.
    pub angle_difference_rms_rad: f64,
    /// Rms difference of the estimated speeds, in rad/s.
    pub speed_difference_rms_rad_s: f64,
}

/// Effect of other settings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WhatIf {
    /// The settings, as `key=value`.
    pub changes: Vec<String>,
    /// Ticks that were compared.
    pub ticks: u64,
    /// Those in which motors could be driven: all further values are about these.
    pub driven: u64,
    /// Driven ticks in which a monitor trips as computed, and none did as recorded.
    pub faults: u64,
    /// The first of those, and its fault.
    pub first_fault: Option<(u32, String)>,
    /// Ticks in which a limiter changed the torque, as recorded and as computed.
    pub guarded: [u64; 2],
    /// Commands with another reply.
    pub other_answers: u64,
    /// Joint by joint.
    pub joints: [JointChange; JOINTS],
}

/// Sums for the result.
#[derive(Debug, Default)]
pub(super) struct Sums {
    ticks: u64,
    driven: u64,
    faults: u64,
    first_fault: Option<(u32, String)>,
    guarded: [u64; 2],
    joints: [JointChange; JOINTS],
}

impl Sums {
    pub(super) fn add(&mut self, recorded: &Record, computed: &TickOutput) {
        self.ticks += 1;
        if !recorded.input.permission.is_armed() {
            return;
        }
        self.driven += 1;
        if let (None, Some(violation)) = (recorded.output.fault(), computed.fault()) {
            self.faults += 1;
            self.first_fault
                .get_or_insert_with(|| (recorded.tick, violation.fault.name().to_owned()));
        }
        let recorded = &recorded.output;
        for (count, output) in self.guarded.iter_mut().zip([recorded, computed]) {
            *count += u64::from(output.guards.bits() != 0);
        }
        for (joint, sums) in self.joints.iter_mut().enumerate() {
            let joint_value =
                |values: [f32; JOINTS]| values.get(joint).copied().map_or(0.0, f64::from);
            let [was, is] = [recorded.torque_nm, computed.torque_nm].map(joint_value);
            sums.torque_rms_recorded_nm += was * was;
            sums.torque_rms_computed_nm += is * is;
            sums.torque_max_recorded_nm = sums.torque_max_recorded_nm.max(was.abs());
            sums.torque_max_computed_nm = sums.torque_max_computed_nm.max(is.abs());
            let difference = (was - is).abs();
            sums.torque_difference_rms_nm += difference * difference;
            sums.torque_difference_max_nm = sums.torque_difference_max_nm.max(difference);
            let angle = joint_value(recorded.angle_rad) - joint_value(computed.angle_rad);
            sums.angle_difference_rms_rad += angle * angle;
            let speed = joint_value(recorded.speed_rad_s) - joint_value(computed.speed_rad_s);
            sums.speed_difference_rms_rad_s += speed * speed;
        }
    }

    pub(super) fn result(
        self,
        changed: BTreeMap<&'static str, String>,
        other_answers: u64,
    ) -> WhatIf {
        let pair = |(key, value)| format!("{key}={value}");
        let changes = changed.into_iter().map(pair).collect();
        let Self {
            ticks,
            driven,
            faults,
            first_fault,
            guarded,
            mut joints,
        } = self;
        let rms = |sum: &mut f64| *sum = (*sum / driven.max(1) as f64).sqrt();
        for joint in &mut joints {
            rms(&mut joint.torque_rms_recorded_nm);
            rms(&mut joint.torque_rms_computed_nm);
            rms(&mut joint.torque_difference_rms_nm);
            rms(&mut joint.angle_difference_rms_rad);
            rms(&mut joint.speed_difference_rms_rad_s);
        }
        WhatIf {
            changes,
            ticks,
            driven,
            faults,
            first_fault,
            guarded,
            other_answers,
            joints,
        }
    }
}

impl WhatIf {
    /// One row for each quantity, one column for each joint.
    fn rows(&self) -> Vec<Vec<String>> {
        let row = |name: &str, cell: &dyn Fn(&JointChange) -> String| {
            let cells = self.joints.iter().map(cell);
            std::iter::once(name.to_owned()).chain(cells).collect()
        };
        let heads = (1..=JOINTS).map(|joint| format!("joint {joint}"));
        let nm = |torque_nm: f64| format!("{torque_nm:.4} N m");
        vec![
            std::iter::once(String::new()).chain(heads).collect(),
            row("torque rms, recorded", &|j| nm(j.torque_rms_recorded_nm)),
            row("torque rms, computed", &|j| nm(j.torque_rms_computed_nm)),
            row("torques apart, rms", &|j| nm(j.torque_difference_rms_nm)),
            row("torques apart, max", &|j| nm(j.torque_difference_max_nm)),
            row("angles apart, rms", &|j| {
                format!("{:.3} mrad", 1e3 * j.angle_difference_rms_rad)
            }),
            row("speeds apart, rms", &|j| {
                format!("{:.4} rad/s", j.speed_difference_rms_rad_s)
            }),
        ]
    }
}

impl fmt::Display for WhatIf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            ticks,
            driven,
            faults,
            ..
        } = self;
        match self.changes.as_slice() {
            [] => writeln!(f, "with the recorded settings: those given are the same")?,
            changes => writeln!(f, "with {}", changes.join(", "))?,
        }
        writeln!(
            f,
            "open-loop: the arm's answers are those to the recorded torques\n"
        )?;
        writeln!(f, "{ticks} ticks, {driven} of them driven:")?;
        f.write_str(&text_table::columns(&self.rows()))?;
        let [was, is] = self.guarded;
        writeln!(
            f,
            "torque held back by a guard: {was} ticks recorded, {is} computed"
        )?;
        match &self.first_fault {
            Some((tick, fault)) => writeln!(
                f,
                "a monitor trips in {faults} ticks more than recorded, first at tick {tick}: {fault}"
            ),
            None => writeln!(f, "no monitor trips that did not as recorded"),
        }
    }
}
