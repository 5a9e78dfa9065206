//! Result of a run in one sentence.

use armbridge_client::enum_names;
use armbridge_link::message::{Drive, Mode};
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
    let result = at_setpoints(&run.summary).or_else(|| tracking(&run.summary));
    let result = result.map(|result| result + &pushes(&run.summary));
    let parts = [result, floats(run), parks(run)];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join("; it "))
}

/// Times of the first park and of its end, if it ended with motors off.
fn parks(run: &Collected) -> Option<String> {
    let [park, idle] = [Mode::Running(Drive::Park), Mode::Idle].map(enum_names::mode);
    let mut modes = run.modes.iter().skip_while(|(_, mode)| *mode != park);
    let (start_s, _) = modes.next()?;
    let (end_s, _) = modes.find(|(_, mode)| *mode == idle)?;
    Some(format!(
        "is parked from {start_s:.2} s on and let go at {end_s:.2} s"
    ))
}

/// Time from which the arm floats, if it does.
fn floats(run: &Collected) -> Option<String> {
    let name = enum_names::mode(Mode::Running(Drive::Float));
    let (start_s, _) = run.modes.iter().find(|(_, mode)| *mode == name)?;
    Some(format!("floats from {start_s:.2} s on"))
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

#[cfg(test)]
mod tests {
    use armbridge_link::message::{Record, TickInput};

    use super::*;
    use crate::test_log::write_log;

    /// An arm that is held for a time and then floats is not at its setpoint for good.
    #[test]
    fn an_arm_that_floats_is_said_to() {
        let folder = tempfile::tempdir().unwrap();
        let headline_of = |float_from: u32| {
            let path = folder.path().join(format!("{float_from}.mcap"));
            let records = (0..4_000).map(|tick| Record {
                tick,
                mode: Mode::Running(if tick < float_from {
                    Drive::Regulate
                } else {
                    Drive::Float
                }),
                input: TickInput {
                    start_us: u64::from(tick) * 1_000,
                    ..TickInput::AT_REST
                },
                ..Record::NONE
            });
            write_log(&path, &[], &records.collect::<Vec<_>>());
            headline(&Collected::read(&path).unwrap())
        };
        let held = headline_of(2_000);
        assert!(
            held.contains("its setpoint") && held.ends_with("; it floats from 2.00 s on."),
            "{held}"
        );
        assert_eq!(headline_of(0), "The arm floats from 0.00 s on.");
        assert!(!headline_of(4_000).contains("floats"));
    }
}
