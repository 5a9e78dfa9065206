//! A design in tables: settings, gain, poles and margins.

use armbridge_analysis::design::{Design, JointMargins};
use armbridge_client::params;
use armbridge_client::params::to_text;
use armbridge_link::message::Settings;
use armbridge_log::text_table;

pub(super) fn as_text(settings: &Settings, design: &Design) -> String {
    let kind = |key| params::get(settings, key).map_or_else(String::new, |kind| to_text(&kind));
    let strings = |row: &[&str]| {
        row.iter()
            .map(|cell| (*cell).to_owned())
            .collect::<Vec<_>>()
    };
    let heading = [
        "armbridge design".to_owned(),
        format!("controller {}", kind("controller.kind")),
        format!("estimator {}", kind("estimator.kind")),
        format!("period {} µs", settings.setup.period_us),
    ];
    let heading = text_table::wrap(heading, " · ", text_table::WIDTH, "  ").join("\n") + "\n";
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
    let mut margins = vec![strings(&[
        "margin of",
        "gain",
        "in dB",
        "phase",
        "at rad/s",
        "delay",
    ])];
    for (joint, of_joint) in design.margins.joints.iter().enumerate() {
        margins.push(margin_row(&format!("torque {}", joint + 1), of_joint));
    }
    let none = || "-".to_owned();
    let [both, both_db] = range(design.margins.both_gain);
    margins.push(vec![
        "both alike".into(),
        both,
        both_db,
        none(),
        none(),
        none(),
    ]);
    let disc = design.margins.disc;
    let [own, own_db] = range(disc.gain.map(Some));
    let phase = format!("{:.1}°", disc.phase_deg);
    margins.push(vec![
        "each its own".into(),
        own,
        own_db,
        phase,
        none(),
        none(),
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
    let phase = margins.phase.map(|at| format!("{:.1}°", at.margin_deg));
    let at = margins.phase.map(|at| format!("{:.1}", at.at_rad_s));
    let [gain, gain_db] = range(margins.gain);
    let delay = margins.delay_s.map(|s| format!("{:.2} ms", 1e3 * s));
    vec![
        name.to_owned(),
        gain,
        gain_db,
        phase.unwrap_or_else(none),
        at.unwrap_or_else(none),
        delay.unwrap_or_else(none),
    ]
}

/// Factors, as `0.21 to 18.3`, and the same in dB, as `-13.6 to +25.2`.
fn range([low, high]: [Option<f64>; 2]) -> [String; 2] {
    let factor = |gain: Option<f64>, none: &str| {
        gain.map_or_else(|| none.to_owned(), |gain| format!("{gain:.3}"))
    };
    let decibel = |gain: Option<f64>, none: &str| {
        gain.map_or_else(
            || none.to_owned(),
            |gain| format!("{:+.1}", 20.0 * gain.log10()),
        )
    };
    [
        format!("{} to {}", factor(low, "0"), factor(high, "any")),
        format!("{} to {}", decibel(low, "-inf"), decibel(high, "+inf")),
    ]
}
