//! Result of a run in one sentence.

use armbridge_log::summary::{SETTLED_RAD, SegmentSummary, Summary};

use super::collect::Collected;
use super::events::Kind;

/// The result of a run in one sentence; a fault goes first.
pub(super) fn headline(run: &Collected) -> String {
    let summary = &run.summary;
    if let Some(fault) = summary.faults.first() {
        let mut events = run.events.iter();
        let cause = events
            .find(|event| event.kind == Kind::Fault)
            .and_then(|event| event.text.split(';').next())
            .unwrap_or(fault.fault);
        return format!(
            "A fault stops the arm after {:.2} s: {cause}.",
            fault.time_s - run.zero_s
        );
    }
    sentence(run).map_or_else(
        || "The arm is not driven to a setpoint in this run.".to_owned(),
        |sentence| format!("The arm {sentence}."),
    )
}

/// The second run, as far as it differs from the first.
pub(super) fn beside(name: &str, run: &Collected) -> Option<String> {
    let sentence = match run.summary.faults.first() {
        Some(fault) => format!("ends in the fault {}", fault.fault.replace('_', " ")),
        None => sentence(run)?,
    };
    Some(format!("In grey, {name}: it {sentence}."))
}

fn sentence(run: &Collected) -> Option<String> {
    let result = at_setpoints(&run.summary).or_else(|| tracking(&run.summary))?;
    Some(result + &pushes(&run.summary))
}

fn at_setpoints(summary: &Summary) -> Option<String> {
    let segments = summary.segments.as_slice();
    if segments.is_empty() {
        return None;
    }
    let all = segments.len() as u64 + summary.segments_left_out;
    let settled: Vec<f64> = segments.iter().filter_map(settling_s).collect();
    let slowest_s = settled.iter().copied().fold(0.0, f64::max);
    let off_mrad = segments.iter().map(off_mrad).fold(0.0, f64::max);
    let within_mrad = SETTLED_RAD * 1e3;
    let setpoints = match all {
        1 => "its setpoint".to_owned(),
        2 => "both setpoints".to_owned(),
        all => format!("all {all} setpoints"),
    };
    let reached = match (settled.len(), all) {
        (some, _) if some == segments.len() => {
            format!("is within {within_mrad:.0} mrad of {setpoints} in at most {slowest_s:.2} s")
        }
        (0, 1) => format!("does not stay within {within_mrad:.0} mrad of its setpoint"),
        (0, _) => format!("does not stay within {within_mrad:.0} mrad of any of {all} setpoints"),
        (some, _) => format!("settles at {some} of {all} setpoints"),
    };
    Some(format!(
        "{reached} and rests at most {off_mrad:.1} mrad off"
    ))
}

/// Recovery from pushes, to be appended.
fn pushes(summary: &Summary) -> String {
    let pushes = summary.pushes.as_slice();
    let recovered: Vec<f64> = pushes.iter().filter_map(|push| push.recovered_s).collect();
    let slowest_s = recovered.iter().copied().fold(0.0, f64::max);
    match (recovered.len(), pushes.len()) {
        (_, 0) => String::new(),
        (1, 1) => format!("; it recovers from a push in {slowest_s:.2} s"),
        (some, all) if some == all => {
            format!("; it recovers from {all} pushes in at most {slowest_s:.2} s each")
        }
        (_, 1) => "; it does not recover from a push".to_owned(),
        (some, all) => format!("; it recovers from {some} of {all} pushes"),
    }
}

fn tracking(summary: &Summary) -> Option<String> {
    let rms_mrad = summary.tracking_rms_mrad?.into_iter().fold(0.0, f64::max);
    Some(format!("follows the motion within {rms_mrad:.1} mrad rms"))
}

/// Settling time of the slower joint, in s; none if one does not settle.
pub(super) fn settling_s(segment: &SegmentSummary) -> Option<f64> {
    let [first, second] = [0, 1].map(|joint| segment.joints[joint].settling_time_s);
    Some(first?.max(second?))
}

/// Larger steady-state error of the joints, in mrad.
fn off_mrad(segment: &SegmentSummary) -> f64 {
    let off = segment
        .joints
        .iter()
        .map(|joint| joint.steady_state_error_mrad.abs());
    off.fold(0.0, f64::max)
}
