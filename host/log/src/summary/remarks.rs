//! Remarks on the numbers of a summary.

use armbridge_client::number_text::beside_limit;
use armbridge_link::message::Fault;
use armbridge_servo::JOINTS;

use super::{Cause, Summary};

/// Remarks for these numbers.
pub(super) fn remarks(summary: &Summary) -> Vec<String> {
    let mut remarks: Vec<String> = (0..JOINTS)
        .filter_map(|joint| steady_state_remark(summary, joint))
        .collect();
    let rest_torque = summary.rest_torque.as_ref();
    remarks.extend(rest_torque.and_then(|torque| torque.remark(&summary.run)));
    for fault in &summary.faults {
        let is_angle = fault.fault == Fault::AngleLimit.name();
        let text = |cause| cause_text(cause, is_angle);
        let cause = fault.cause.as_ref().map_or_else(String::new, text);
        remarks.push(format!(
            "FAULT {} at {:.3} s: torque off{cause}",
            fault.fault, fault.time_s
        ));
    }
    if let Some(ended) = &summary.ended {
        remarks.push(format!("ended: {ended}"));
    }
    let missing: u64 = summary.missing_samples.values().sum();
    if missing > 0 {
        let kinds: Vec<_> = summary
            .missing_samples
            .iter()
            .map(|(kind, n)| format!("{kind} {n}"))
            .collect();
        remarks.push(format!("{missing} samples missing: {}", kinds.join(", ")));
    }
    if summary.missed_ticks > 0 {
        remarks.push(format!("{} ticks missed", summary.missed_ticks));
    }
    let link = summary.records;
    let missing_records = link.lost + link.damaged + link.dropped;
    if missing_records > 0 {
        remarks.push(format!(
            "the record is not complete: {} lost, {} damaged, {} dropped by the board",
            link.lost, link.damaged, link.dropped
        ));
    }
    if let Some(log) = &summary.log {
        if !log.is_complete() {
            remarks.push(format!(
                "the log is not complete: {} records never came, {} bytes of the link are not in \
                 the file",
                log.lost, log.unwritten
            ));
        }
        remarks.extend(log.trouble.clone());
    }
    let missed = summary.missed_expectations.iter();
    remarks.extend(missed.map(|missed| format!("MISSED {missed}")));
    remarks
}

/// An angle may trip inside its limit, where the arm is braked for too long.
fn cause_text(cause: &Cause, is_angle: bool) -> String {
    let Cause {
        tick,
        joint,
        value,
        limit,
    } = *cause;
    let joint = joint.map_or_else(String::new, |joint| format!(" of joint {joint}"));
    let values = if value == 0.0 && limit == 0.0 {
        String::new()
    } else {
        let is_inside = is_angle && value.abs() < limit.abs();
        let [value, limit] = beside_limit(value, limit, 3);
        if is_inside {
            format!(", {value} before the limit of {limit}")
        } else {
            format!(", {value} where {limit} is allowed")
        }
    };
    format!("; tick {tick}{joint}{values}")
}

/// Steady-state error of a joint where it is at rest, and its explanation.
fn steady_state_remark(summary: &Summary, joint: usize) -> Option<String> {
    let joints = summary.segments.iter().map(|s| &s.joints[joint]);
    let errors = joints
        .filter(|joint| joint.is_at_rest)
        .map(|joint| joint.steady_state_error_mrad.abs());
    let worst_mrad = errors.reduce(f64::max)?;
    let count_mrad = summary.run.count_mrad(joint);
    let joint_text = format!("joint {} rests", joint + 1);
    if worst_mrad <= count_mrad {
        return Some(format!(
            "{joint_text} within one encoder count ({count_mrad:.1} mrad)"
        ));
    }
    let at = format!("{joint_text} up to {worst_mrad:.1} mrad from its setpoint");
    let (Some(friction_nm), Some(offset_mrad)) = (
        summary.run.static_friction_nm,
        summary.run.stiction_offset_mrad,
    ) else {
        return Some(format!(
            "{at}, more than one encoder count ({count_mrad:.1} mrad)"
        ));
    };
    let (friction_nm, offset_mrad) = (friction_nm[joint], offset_mrad[joint]);
    let explained = format!(
        "static friction explains: {friction_nm} N m / {:.3} N m/rad = {offset_mrad:.1} mrad",
        friction_nm / offset_mrad * 1e3
    );
    Some(if worst_mrad <= offset_mrad {
        format!("{at}, within what {explained}")
    } else if worst_mrad <= offset_mrad + count_mrad {
        format!("{at}, within one encoder count of what {explained}")
    } else {
        format!("{at}, MORE than {explained}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_inside_its_limit_is_not_called_beyond_it() {
        let text = |value, is_angle| {
            let cause = Cause {
                tick: 7,
                joint: Some(1),
                value,
                limit: 1.4,
            };
            cause_text(&cause, is_angle)
        };
        let inside = text(-1.393, true);
        assert!(
            inside.ends_with("-1.393 before the limit of 1.400"),
            "{inside}"
        );
        for (value, is_angle) in [(1.41, true), (1.393, false)] {
            let text = text(value, is_angle);
            assert!(text.ends_with("where 1.400 is allowed"), "{text}");
        }
    }
}
