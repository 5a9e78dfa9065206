//! The planned motion, as a table and as a figure.

use std::path::{Path, PathBuf};

use armbridge_analysis::plot::{PlotError, draw_preview};
use armbridge_analysis::scenario::{JointPreview, Preview, Stage};
use armbridge_log::text_table;

/// Most rows of the table; a plan that repeats itself has more steps.
const ROWS_MAX: usize = 40;

/// The table, ending in a line feed.
pub(super) fn as_text(preview: &Preview) -> String {
    let heads = ["step", "from", "lasts", "joint", "angle", "at most", "what"];
    let mut rows = vec![heads.map(str::to_owned).to_vec()];
    for stage in preview.stages.iter().take(ROWS_MAX) {
        for joint in 0..stage.joints.len() {
            rows.push(row(preview, stage, joint));
        }
    }
    let more = preview.stages.len().saturating_sub(ROWS_MAX);
    let more = if more > 0 {
        format!("... and {more} steps more\n")
    } else {
        String::new()
    };
    let [first, second] = preview.limit_rad;
    format!(
        "{}: {}, {} steps in {:.1} s\n\n{}{more}\nThe board switches off beyond {first:.2} and \
         {second:.2} rad ({:.0} and {:.0}°), and ends an\nexperiment whose envelope [] a joint \
         leaves.\n",
        preview.name,
        preview.title,
        preview.stages.len(),
        preview.end_s,
        text_table::columns(&rows),
        first.to_degrees(),
        second.to_degrees()
    )
}

fn row(preview: &Preview, stage: &Stage, joint: usize) -> Vec<String> {
    let joint_preview = &stage.joints[joint];
    let only_first = |text: String| if joint == 0 { text } else { String::new() };
    let speed = joint_preview.speed_rad_s.map_or_else(
        || format!("limit {:.2} rad/s", preview.limit_rad_s[joint]),
        |speed| format!("{speed:.2} rad/s"),
    );
    let lasts_s = stage.time_s.end - stage.time_s.start;
    vec![
        only_first(stage.step.to_string()),
        only_first(format!("{:.1} s", stage.time_s.start)),
        only_first(format!("{lasts_s:.1} s")),
        (joint + 1).to_string(),
        range(joint_preview),
        speed,
        only_first(stage.doing.clone()),
    ]
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
