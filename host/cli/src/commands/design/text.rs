//! A design in tables: settings, gain, poles and margins.

use armbridge_analysis::design::{Design, JointMargins};
use armbridge_client::params;
use armbridge_client::params::to_text;
use armbridge_log::text_table;
use armbridge_shared::link::message::Settings;

pub(super) fn as_text(settings: &Settings, design: &Design) -> String {
    let kind = |key| params::get(settings, key).map_or_else(String::new, |kind| to_text(&kind));
    let strings = |row: &[&str]| {
        row.iter()
            .map(|cell| (*cell).to_owned())
            .collect::<Vec<_>>()
    };
    let heading = format!(
        "armbridge design · controller {} · estimator {} · period {} µs\n",
        kind("controller.kind"),
        kind("estimator.kind"),
        settings.setup.period_us
    );
    let mut gain = vec![strings(&["gain", "q1", "q2", "dq1", "dq2"])];
    for (joint, row) in design.gain.iter().enumerate() {
        let cells = row.iter().map(|k| format!("{k:.4}"));
        gain.push(
            std::iter::once(format!("torque {}", joint + 1))
                .chain(cells)
                .collect(),
        );
    }
    let mut poles = vec![strings(&[
        "pole of",
        "z",
        "rad/s",
        "damping",
        "time constant",
    ])];
    poles.extend(design.poles.all().map(|(name, pole)| {
        let z = if pole.im == 0.0 {
            format!("{:.5}", pole.re)
        } else {
            format!("{:.5} ± {:.5}i", pole.re, pole.im)
        };
        let decay_s = 1.0 / (pole.natural_rad_s * pole.damping);
        vec![
            name.to_owned(),
            z,
            format!("{:.2}", pole.natural_rad_s),
            format!("{:.3}", pole.damping),
            format!("{:.1} ms", 1e3 * decay_s),
        ]
    }));
    let mut margins = vec![strings(&["margin of", "gain", "phase", "delay"])];
    for (joint, of_joint) in design.margins.joints.iter().enumerate() {
        margins.push(margin_row(&format!("torque {}", joint + 1), of_joint));
    }
    let both = range(design.margins.both_gain);
    margins.push(vec!["both alike".into(), both, "-".into(), "-".into()]);
    let disc = design.margins.disc;
    margins.push(vec![
        "both, each its own".into(),
        range(disc.gain.map(Some)),
        format!("{:.1}°", disc.phase_deg),
        "-".into(),
    ]);
    let peak = format!(
        "disc margin {:.3} at {:.1} rad/s; largest sensitivity {:.3} at {:.1} rad/s\n",
        disc.alpha, disc.at_rad_s, design.margins.sensitivity, design.margins.sensitivity_rad_s
    );
    let stability = if design.is_stable {
        ""
    } else {
        "THE LOOP IS UNSTABLE: the estimator does not go with this gain\n"
    };
    [
        heading,
        text_table::columns(&gain),
        text_table::columns(&poles),
        text_table::columns(&margins),
        peak,
        stability.to_owned(),
    ]
    .join("\n")
    .trim_end()
    .to_owned()
        + "\n"
}

fn margin_row(name: &str, margins: &JointMargins) -> Vec<String> {
    let none = || "-".to_owned();
    let phase = margins.phase.map(|crossing| {
        format!(
            "{:.1}° at {:.1} rad/s",
            crossing.margin_deg, crossing.at_rad_s
        )
    });
    let delay = margins.delay_s.map(|s| format!("{:.2} ms", 1e3 * s));
    vec![
        name.to_owned(),
        range(margins.gain),
        phase.unwrap_or_else(none),
        delay.unwrap_or_else(none),
    ]
}

/// Factors, as `0.21 to 18.3 (-13.6 to +25.2 dB)`.
fn range([low, high]: [Option<f64>; 2]) -> String {
    let factor = |gain: Option<f64>, none: &str| {
        gain.map_or_else(|| none.to_owned(), |gain| format!("{gain:.3}"))
    };
    let decibel = |gain: Option<f64>, none: &str| {
        gain.map_or_else(
            || none.to_owned(),
            |gain| format!("{:+.1}", 20.0 * gain.log10()),
        )
    };
    format!(
        "{} to {} ({} to {} dB)",
        factor(low, "0"),
        factor(high, "any"),
        decibel(low, "-inf"),
        decibel(high, "+inf")
    )
}
