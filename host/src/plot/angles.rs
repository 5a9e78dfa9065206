//! `angles`: did each joint go where it was told to?

use super::axis::Axis;
use super::panel::{ALARM, GOOD, JOINT, JOINT_TINT, Key, LABEL, MUTED, Panel, SETPOINT};
use super::svg::{Anchor, Font, Rect, Stroke, Svg};
use super::{draw_faults, figure, over_time, time_axis, time_s};
use crate::facts::RunFacts;
use crate::log::names;
use crate::summary::{JointSummary, SETTLED_RAD, SegmentSummary, segments};
use armbridge_shared::JOINTS;
use armbridge_shared::link::message::{Drive, Record, Sample};

/// Estimates.
const ESTIMATE_WIDTH: f64 = 1.7;

pub(super) fn draw(facts: &RunFacts, records: &[Record]) -> String {
    let mut svg = figure(640.0, "Joint angles", facts);
    let summaries: Vec<_> = segments(records)
        .iter()
        .map(|segment| SegmentSummary::of(records, segment, facts))
        .collect();
    for joint in 0..JOINTS {
        let frame = Rect {
            x: 84.0,
            y: 78.0 + 270.0 * joint as f64,
            w: 932.0,
            h: 224.0,
        };
        let x = time_axis(facts, records);
        let panel = Panel {
            frame,
            x,
            y: angle_axis(facts, records, joint),
        };
        draw_joint(&mut svg, &panel, facts, records, joint);
        draw_setpoints(&mut svg, &panel, &summaries, joint);
        draw_motion(&mut svg, &panel, records, joint);
        draw_faults(&mut svg, &panel, records);
    }
    svg.finish()
}

/// Everything that is drawn, and room above it for what is written there.
fn angle_axis(facts: &RunFacts, records: &[Record], joint: usize) -> Axis {
    let shown = records
        .iter()
        .filter(|r| names::is_up(r.mode))
        .flat_map(|record| {
            let reference = f64::from(record.reference_rad[joint]);
            let angles = [
                reference - 1.5 * SETTLED_RAD,
                reference + 1.5 * SETTLED_RAD,
                f64::from(record.angle_rad[joint]),
                measured_rad(facts, record, joint),
            ];
            angles.into_iter()
        });
    let axis = Axis::around(shown, 0.05);
    Axis {
        high: axis.high + 0.14 * (axis.high - axis.low),
        ..axis
    }
}

/// What the encoder says; not a number where it said nothing.
fn measured_rad(facts: &RunFacts, record: &Record, joint: usize) -> f64 {
    match record.samples[joint] {
        Sample::Counts(count) => facts.angle_rad(joint, count),
        Sample::Missing(_) => f64::NAN,
    }
}

fn draw_joint(svg: &mut Svg, panel: &Panel, facts: &RunFacts, records: &[Record], joint: usize) {
    let last = joint + 1 == JOINTS;
    let title = format!("Joint {}", joint + 1);
    panel.draw(svg, &title, last.then_some("time (s)"), Some("angle (rad)"));
    let samples = over_time(records, |r| measured_rad(facts, r, joint));
    panel.dots(
        svg,
        samples.filter(|(_, angle)| angle.is_finite()),
        JOINT_TINT[joint],
    );
    let estimate = Stroke::solid(JOINT[joint], ESTIMATE_WIDTH);
    let angle = |r: &Record| {
        if names::is_up(r.mode) {
            f64::from(r.angle_rad[joint])
        } else {
            f64::NAN
        }
    };
    panel.curve(svg, over_time(records, angle), estimate);

    let mut legend = vec![
        (Key::Dots(JOINT_TINT[joint]), "encoder"),
        (Key::Line(estimate), "estimate"),
        (Key::Line(SETPOINT), "setpoint"),
        (Key::Band(GOOD), "±20 mrad"),
    ];
    let missing: Vec<_> = records
        .iter()
        .filter(|r| names::is_up(r.mode) && matches!(r.samples[joint], Sample::Missing(_)))
        .map(|r| panel.at(time_s(records, r), panel.y.low))
        .map(|(x, y)| vec![(x, y), (x, y - 8.0)])
        .collect();
    if !missing.is_empty() {
        let stroke = Stroke::solid(ALARM, 1.2);
        svg.polyline(&missing, stroke);
        legend.push((Key::Line(stroke), "missing sample"));
    }
    panel.legend(svg, &legend);
}

/// The reference while it moves.
fn draw_motion(svg: &mut Svg, panel: &Panel, records: &[Record], joint: usize) {
    let reference = |r: &Record| match r.mode.drive() {
        Some(Drive::Track | Drive::Hold) => f64::from(r.reference_rad[joint]),
        _ => f64::NAN,
    };
    panel.curve(svg, over_time(records, reference), SETPOINT);
}

/// The setpoint, the band in which a joint counts as settled, and how it went.
fn draw_setpoints(svg: &mut Svg, panel: &Panel, segments: &[SegmentSummary], joint: usize) {
    let mut path = Vec::new();
    for segment in segments {
        let JointSummary {
            reference_rad,
            settling_time_s,
            steady_state_error_mrad,
            ..
        } = segment.joints[joint];
        let reference = f64::from(reference_rad);
        let (from, to) = (segment.start_s, segment.end_s);
        let (low, high) = (reference - SETTLED_RAD, reference + SETTLED_RAD);
        panel.area(svg, (from, low), (to, high), GOOD, 0.14);
        path.extend([(from, reference), (to, reference)]);

        let settled = settling_time_s.map_or("does not settle".to_owned(), |s| {
            format!("settled in {s:.2} s")
        });
        let rest = format!("{steady_state_error_mrad:+.1} mrad").replace('-', "−");
        let long = format!("{settled}, rests {rest} off");
        let short = format!("{settled}, {rest}");
        let font = Font {
            size: 11.0,
            colour: MUTED,
            anchor: Anchor::Start,
            ..LABEL
        };
        let (left, right) = (panel.at(from, low).0 + 7.0, panel.at(to, low).0);
        // Only what fits between this setpoint and the next.
        let fits = |text: &&String| left + font.width(text) < right;
        if let Some(text) = [&long, &short, &settled].into_iter().find(fits) {
            svg.text((left, panel.frame.y + 16.0), text, font, false);
        }
    }
    for segment in segments.iter().skip(1) {
        let (x, _) = panel.at(segment.start_s, panel.y.low);
        let stroke = Stroke {
            colour: MUTED,
            width: 0.8,
            dash: "1 3",
        };
        svg.line((x, panel.frame.y), (x, panel.frame.bottom()), stroke);
    }
    panel.curve(svg, path.into_iter(), SETPOINT);
}
