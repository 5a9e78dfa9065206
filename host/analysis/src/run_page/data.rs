//! Data of the page as JSON; `data.js` reads it.

use std::collections::BTreeMap;

use armbridge_control::arm::{Mounting, Parameters};
use armbridge_log::summary::SETTLED_RAD;
use armbridge_servo::JOINTS;
use serde::Serialize;

use super::PageInput;
use super::collect::{Collected, ENCODER, QUANTITIES, ShownPush, TRUE_ANGLE};
use super::events::Listed;
use super::pack::{Series, Times};
use super::rows::Rows;

/// Names of the quantities of a pose, as in `collect`.
const POSE_NAMES: [&str; 2] = ["angle", "reference"];

/// Largest time in s between two poses that shows as steady motion.
const FRAME_S: f64 = 1.0 / 60.0;

/// All data of the page.
#[derive(Debug, Serialize)]
pub(super) struct PageData<'a> {
    /// First and last time, in s.
    from: f64,
    to: f64,
    arm: Arm,
    /// Distance from the setpoint, in rad, within which a joint counts as settled.
    settled: f64,
    /// Torque limits of each joint, in N m.
    torque_limits: &'a [[f64; 2]],
    runs: Vec<Run<'a>>,
    events: &'a [Listed],
    /// Start and name of each mode.
    modes: &'a [(f64, &'static str)],
    gaps: &'a [[f64; 2]],
    pushes: Vec<Push>,
}

/// Shape of the arm.
#[derive(Debug, Serialize)]
struct Arm {
    /// Lengths in m.
    l1: f64,
    l2: f64,
    is_hanging: bool,
}

/// Curves of a run.
#[derive(Debug, Serialize)]
struct Run<'a> {
    name: &'a str,
    /// Ticks of one row.
    every: usize,
    curves: Table,
    /// Where rows are too long to show the motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    poses: Option<Table>,
}

/// Quantities over time.
#[derive(Debug, Serialize)]
struct Table {
    times: Times,
    /// By name and number of the joint, as `angle1`.
    series: BTreeMap<String, Series>,
}

/// A push: start and duration in s, joint from 1, torque in N m.
#[derive(Debug, Serialize)]
struct Push(f64, f64, usize, f64);

impl<'a> PageData<'a> {
    pub(super) fn new(
        input: &'a PageInput<'a>,
        run: &'a Collected,
        beside: Option<&'a Collected>,
    ) -> Self {
        let facts = &run.facts;
        let names = [
            Some("this run"),
            input.beside.as_ref().map(|beside| beside.name),
        ];
        let runs = [Some(run), beside];
        let runs = runs.into_iter().zip(names).zip([true, false]);
        let runs = runs.filter_map(|((run, name), is_main)| Some(self::run(run?, name?, is_main)));
        Self {
            from: -run.zero_s,
            to: run.end_s,
            arm: arm(&facts.setup.arm),
            settled: SETTLED_RAD,
            torque_limits: &facts.torque_limits_nm[..facts.joints()],
            runs: runs.collect(),
            events: &run.events,
            modes: &run.modes,
            gaps: &run.gaps,
            pushes: run.pushes.iter().map(push).collect(),
        }
    }

    /// JSON for a `script` element.
    pub(super) fn json(&self) -> String {
        // Plain data: this cannot fail.
        let json = serde_json::to_string(self).unwrap_or_default();
        // Nothing in a text may end the element.
        json.replace('<', "\\u003c")
    }
}

fn arm(arm: &Parameters<f32>) -> Arm {
    Arm {
        l1: arm.l1.into(),
        l2: arm.l2.into(),
        is_hanging: arm.mounting == Mounting::Hanging,
    }
}

fn push(shown: &ShownPush) -> Push {
    let push = shown.push;
    Push(
        shown.start_s,
        push.duration_ns as f64 * 1e-9,
        push.joint + 1,
        push.torque_nm,
    )
}

fn run<'a>(run: &Collected, name: &'a str, is_main: bool) -> Run<'a> {
    let mut series = BTreeMap::new();
    for (index, quantity) in QUANTITIES.iter().enumerate() {
        if !is_main && !quantity.is_compared {
            continue;
        }
        for joint in 0..JOINTS {
            let values = run.rows.values(index * JOINTS + joint);
            let packed = if quantity.name == ENCODER {
                Series::of(&values.map(|ends| angles(run, joint, ends)))
            } else {
                Series::of(&values)
            };
            add(&mut series, quantity.name, joint, packed);
        }
    }
    for joint in (0..JOINTS).filter(|_| is_main) {
        let packed = Series::of(&run.rows.values(QUANTITIES.len() * JOINTS + joint));
        add(&mut series, TRUE_ANGLE, joint, packed);
    }
    let rows = run.rows.times_s().len().max(1);
    let row_s = (run.end_s + run.zero_s) / rows as f64;
    Run {
        name,
        every: run.rows.every(),
        curves: table(&run.rows, run.zero_s, series),
        poses: (run.rows.every() > 1 && row_s > FRAME_S).then(|| poses(run)),
    }
}

/// Angles in rad of the lowest and the highest encoder count.
fn angles(run: &Collected, joint: usize, counts: [f32; 2]) -> [f32; 2] {
    let facts = &run.facts;
    let angle = |count: f32| {
        let from_zero = f64::from(count) - facts.zero_count[joint];
        (from_zero * facts.rad_per_count[joint]) as f32
    };
    let [a, b] = counts.map(angle);
    [a.min(b), a.max(b)]
}

fn poses(run: &Collected) -> Table {
    let mut series = BTreeMap::new();
    for (index, name) in POSE_NAMES.into_iter().enumerate() {
        for joint in 0..JOINTS {
            let values = run.poses.values(index * JOINTS + joint);
            add(&mut series, name, joint, Series::of(&values));
        }
    }
    table(&run.poses, run.zero_s, series)
}

fn add(series: &mut BTreeMap<String, Series>, name: &str, joint: usize, packed: Option<Series>) {
    // A quantity that the estimator or the setpoint does not have is zero throughout.
    let packed = packed
        .filter(|packed| name != "disturbance" && name != "reference_speed" || !packed.is_zero());
    series.extend(packed.map(|packed| (format!("{name}{}", joint + 1), packed)));
}

fn table(rows: &Rows, zero_s: f64, series: BTreeMap<String, Series>) -> Table {
    let times_s: Vec<f64> = rows.times_s().iter().map(|time| time - zero_s).collect();
    Table {
        times: Times::of(&times_s),
        series,
    }
}
