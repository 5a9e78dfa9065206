//! The planned motion, as a table and as a figure.

use std::path::{Path, PathBuf};

use armbridge_analysis::plot::{PlotError, draw_preview};
use armbridge_analysis::scenario::{JointPreview, Preview, Stage};
use armbridge_log::text_table;

/// Most steps of the table; a plan that repeats itself has more.
const STEPS_MAX: usize = 40;

/// Begin of a line on a joint.
const INDENT: &str = "      ";

/// The table, ending in a line feed.
pub(super) fn as_text(preview: &Preview) -> String {
    let more = preview.stages.len().saturating_sub(STEPS_MAX);
    let more = if more > 0 {
        format!("... and {more} steps more\n")
    } else {
        String::new()
    };
    let limits = &preview.limit_rad[..preview.joints];
    let limits_rad: Vec<String> = limits.iter().map(|limit| format!("{limit:.2}")).collect();
    let limits_rad = limits_rad.join(" and ");
    let degrees = limits
        .iter()
        .map(|limit| format!("{:.0}", limit.to_degrees()));
    let degrees = degrees.collect::<Vec<String>>().join(" and ");
    format!(
        "{}: {}, {} steps in {:.1} s\n\n{}{more}\nThe board switches off beyond {limits_rad} rad \
         ({degrees}°), and ends an\nexperiment when a joint leaves its envelope, in brackets above.\n",
        preview.name,
        preview.title,
        preview.stages.len(),
        preview.end_s,
        table(preview),
    )
}

/// A line for each step, and below it one for each joint.
fn table(preview: &Preview) -> String {
    let heads = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
    let mut steps: Vec<Vec<String>> = vec![heads(&["step", "from", "lasts", "what"])];
    let mut joints: Vec<Vec<String>> = vec![heads(&["joint", "angle", "speed at most"])];
    // The heads are one line each.
    let mut joint_lines = vec![1];
    for stage in preview.stages.iter().take(STEPS_MAX) {
        steps.push(step_row(stage));
        joints.extend((0..preview.joints).map(|joint| joint_row(preview, stage, joint)));
        joint_lines.push(preview.joints);
    }
    let (steps, joints) = (text_table::columns(&steps), text_table::columns(&joints));
    let mut joints = joints.lines();
    let mut text = String::new();
    for (step, count) in steps.lines().zip(joint_lines) {
        text = text + step + "\n";
        for joint in joints.by_ref().take(count) {
            text = text + INDENT + joint + "\n";
        }
    }
    text
}

fn step_row(stage: &Stage) -> Vec<String> {
    let lasts_s = stage.time_s.end - stage.time_s.start;
    vec![
        stage.step.to_string(),
        format!("{:.1} s", stage.time_s.start),
        format!("{lasts_s:.1} s"),
        stage.doing.clone(),
    ]
}

fn joint_row(preview: &Preview, stage: &Stage, joint: usize) -> Vec<String> {
    let joint_preview = &stage.joints[joint];
    let speed = joint_preview.speed_rad_s.map_or_else(
        || format!("limit {:.2} rad/s", preview.limit_rad_s[joint]),
        |speed| format!("{speed:.2} rad/s"),
    );
    vec![(joint + 1).to_string(), range(joint_preview), speed]
}

/// Range of a joint; an envelope in brackets.
fn range(joint_preview: &JointPreview) -> String {
    let Some([low, high]) = joint_preview.range_rad else {
        return "anywhere in its limits".into();
    };
    let text = if low < high {
        format!(
            "{low:+.2} to {high:+.2} rad ({:+.0} to {:+.0}°)",
            low.to_degrees(),
            high.to_degrees()
        )
    } else {
        format!("to {low:+.2} rad ({:+.0}°)", low.to_degrees())
    };
    if joint_preview.is_guarded {
        format!("[{text}]")
    } else {
        text
    }
}

/// The picture, in a folder.
pub(super) fn draw(
    folder: &Path,
    preview: &Preview,
    board: Option<&str>,
) -> Result<Vec<PathBuf>, PlotError> {
    let about = board.map_or_else(
        || "checked for a board with its default settings".to_owned(),
        |board| format!("checked for {board}"),
    );
    draw_preview(folder, preview, &about)
}
