//! HTML of the page.

use std::path::Path;

use armbridge_client::{params, shell_text};
use armbridge_link::message::Settings;
use armbridge_log::summary::SegmentSummary;
use maud::{Markup, PreEscaped, html};

use super::collect::Collected;
use super::{FILE, PageInput, headline};
use crate::html::{self, unbroken};

const STYLE: &str = include_str!("page.css");

/// The scripts, each of which needs those before it.
const SCRIPTS: [&str; 7] = [
    include_str!("data.js"),
    include_str!("arm.js"),
    include_str!("plots.js"),
    include_str!("zoom.js"),
    include_str!("timeline.js"),
    include_str!("tables.js"),
    include_str!("main.js"),
];

/// Speeds of playback.
const RATES: [&str; 7] = ["0.1", "0.25", "0.5", "1", "2", "5", "20"];

/// HTML text of the page, with its data as JSON.
pub(super) fn document(
    folder: &Path,
    input: &PageInput<'_>,
    run: &Collected,
    beside: Option<&Collected>,
    data: &str,
) -> String {
    let name = &run.facts.name;
    let title = format!("{name} · armbridge run");
    let body = html! {
        main {
            (header(input, run, beside))
            (stage(run.rows.every(), run.facts.joints()))
            (timeline())
            (setpoints(run, beside.zip(input.beside.map(|beside| beside.name))))
            (events(run))
            (run.settings.as_ref().map_or_else(|| html! {}, settings))
            (commands(input))
            (files(folder))
            footer {
                p { "Armbridge " (run.facts.version) ". This page needs no network." }
            }
        }
        script type="application/json" id="data" { (PreEscaped(data)) }
        @for script in SCRIPTS { script { (PreEscaped(script)) } }
    };
    html::document(&title, STYLE, &body)
}

fn header(input: &PageInput<'_>, run: &Collected, beside: Option<&Collected>) -> Markup {
    let headline = input.headline.clone();
    let headline = headline.unwrap_or_else(|| headline::headline(run));
    let second = input
        .beside
        .zip(beside)
        .and_then(|(beside, run)| headline::beside(beside.name, run));
    html! {
        header {
            p.kicker { "armbridge " strong { (run.facts.name) } " · " (unbroken(&run.facts.describe())) }
            h1 { (unbroken(&headline)) }
            @if let Some(second) = second { p.lead { (unbroken(&second)) } }
            p.totals { (unbroken(&totals(run))) }
            @for damage in &run.damage { p.note { (damage) } }
            noscript { p.note { "The moving arm and the curves need JavaScript." } }
        }
    }
}

/// Length, losses and torque in one line.
fn totals(run: &Collected) -> String {
    let summary = &run.summary;
    let missing: u64 = summary.missing_samples.values().sum();
    format!(
        "{} ticks · {} missed · {missing} samples missing · {} faults · {} · bus {:.0} of \
         {} µs",
        summary.ticks,
        summary.missed_ticks,
        summary.faults.len(),
        summary.torque_text(),
        summary.bus_us.mean,
        run.facts.period_us
    )
}

/// The arm with this number of joints beside the curves, whose points stand for some ticks each.
fn stage(every: usize, joints: usize) -> Markup {
    let views = [("three", "3D"), ("front", "joint 1"), ("side", "joint 2")];
    let views = views.into_iter().take(1 + joints);
    let rows = [
        ("angle", "angle", "angle", "3", "1", "rad"),
        ("setpoint", "reference", "reference", "3", "1", "rad"),
        ("error", "error", "error", "1", "1000", "mrad"),
        ("speed", "speed", "speed", "2", "1", "rad/s"),
        ("torque", "torque", "torque", "3", "1", "N m"),
    ];
    html! {
        div.stage {
            section.arm aria-label="The arm" {
                div.view {
                    canvas #arm role="img"
                        aria-label="The arm at the time of the cursor; drag to turn the view" {}
                    div.views role="group" aria-label="View" {
                        @for (view, label) in views {
                            button type="button" data-view=(view)
                                aria-pressed=(view == "three") { (label) }
                        }
                    }
                    p #mode {}
                }
                table #readout {
                    thead { tr {
                        td {}
                        @for joint in 1..=joints {
                            th class={ "n j" (joint) } { "joint " (joint) }
                        }
                        td {}
                    } }
                    tbody {
                        @for (label, series, _, digits, factor, unit) in rows {
                            tr {
                                th scope="row" { (label) }
                                @for joint in 1..=joints {
                                    td.n data-series={ (series) (joint) } data-digits=(digits)
                                        data-factor=(factor) {}
                                }
                                td.unit { (unit) }
                            }
                        }
                    }
                }
            }
            section #panels aria-label="Curves" {
                p.help {
                    "Drag to zoom, double-click for all. Click, then turn the wheel; or hold Ctrl. \
                     Keys: " kbd { "space" } " plays, " kbd { "←" } " " kbd { "→" } " move, "
                    kbd { "[" } " " kbd { "]" } " jump between events, "
                    kbd { "+" } " " kbd { "−" } " " kbd { "0" } " zoom."
                    @if every > 1 { " Each point is the range of " (every) " ticks." }
                }
            }
        }
    }
}

fn timeline() -> Markup {
    html! {
        section.transport aria-label="Playback" {
            div.track {
                canvas #overview aria-hidden="true" {}
                input #slider type="range" aria-label="Time in the run";
                p #hint hidden {}
            }
            div.controls {
                button #before type="button" aria-label="Event before" title="Event before, [" { "⇤" }
                button #play type="button" aria-label="Play" title="Play and pause, space" {}
                button #after type="button" aria-label="Next event" title="Next event, ]" { "⇥" }
                output #clock {}
                label {
                    span.wide-only { "speed " }
                    select #rate aria-label="Speed of playback" {
                        @for rate in RATES {
                            option value=(rate) selected[rate == "1"] { (rate) "×" }
                        }
                    }
                }
                button #loop type="button" aria-pressed="false" { "loop" }
                button #reset type="button" disabled { "show all" }
            }
        }
    }
}

/// Table of the setpoints; a second run is shown if it has as many.
fn setpoints(run: &Collected, beside: Option<(&Collected, &str)>) -> Markup {
    let segments = &run.summary.segments;
    let beside = beside.filter(|(other, _)| other.summary.segments.len() == segments.len());
    let mut heads = vec![
        "#From",
        "#Setpoint",
        "#Within 20 mrad after",
        "#At rest off by",
    ];
    let others = beside.map(|(_, name)| [format!("#{name}: after"), format!("#{name}: off by")]);
    heads.extend(others.iter().flatten().map(String::as_str));
    let rows = html! {
        @for (index, segment) in segments.iter().enumerate() {
            tr {
                td.n { (format!("{:.1} s", segment.start_s - run.zero_s)) }
                td.n { (each(segment, run.facts.joints(), " rad", |joint| format!("{:+.2}", joint.reference_rad))) }
                (performance(segment, run.facts.joints()))
                @if let Some(other) = beside.and_then(|(other, _)| other.summary.segments.get(index)) {
                    (performance(other, run.facts.joints()))
                }
            }
        }
    };
    html! {
        @if !segments.is_empty() {
            section #setpoints {
                h2 { "Setpoints" }
                div.scroll { (html::table(&heads, &rows)) }
                @if run.summary.segments_left_out > 0 {
                    p.note { (run.summary.segments_left_out) " setpoints more." }
                }
            }
        }
    }
}

/// Cells with settling times and steady-state errors.
fn performance(segment: &SegmentSummary, joints: usize) -> Markup {
    html! {
        td.n { (each(segment, joints, "", |joint| {
            joint.settling_time_s.map_or_else(|| "never".to_owned(), |s| format!("{s:.2} s"))
        })) }
        td.n { (each(segment, joints, " mrad", |joint| format!("{:.1}", joint.steady_state_error_mrad.abs()))) }
    }
}

/// The texts of this many joints.
fn each(
    segment: &SegmentSummary,
    joints: usize,
    unit: &str,
    text: impl Fn(&armbridge_log::summary::JointSummary) -> String,
) -> String {
    let texts: Vec<_> = segment.joints.iter().take(joints).map(text).collect();
    (texts.join("  ") + unit).replace('-', "−")
}

fn events(run: &Collected) -> Markup {
    html! {
        section #events {
            h2 { "Events" }
            p.filters {
                input type="search" placeholder="Search events" aria-label="Search events";
            }
            div.scroll { (html::table(&["#Time", "Kind", "Event"], &html! {})) }
            @if run.events_left_out > 0 {
                p.note { (run.events_left_out) " events more are in the log." }
            }
        }
    }
}

/// Settings in force, those that are not the defaults first.
fn settings(settings: &Settings) -> Markup {
    let default = Settings::default();
    let rows = params::pairs(settings)
        .into_iter()
        .map(|(parameter, value)| {
            let usual = params::get(&default, parameter.key);
            let is_usual = usual.as_ref() == Some(&value);
            let usual =
                usual.map_or_else(|| "not in use".to_owned(), |usual| params::to_text(&usual));
            (parameter, params::to_text(&value), usual, is_usual)
        });
    let (usual, changed): (Vec<_>, Vec<_>) = rows.partition(|row| row.3);
    let groups = [
        ("Different from the defaults", &changed),
        ("As by default", &usual),
    ];
    let rows = html! {
        @for (label, group) in groups {
            @if !group.is_empty() {
                tr.group { th colspan="4" { (label) ", " (group.len()) } }
            }
            @for (parameter, value, usual, is_usual) in group {
                tr {
                    td { code { (parameter.key) } }
                    td { (value) " " span.unit { (parameter.unit) } }
                    td { @if !is_usual { (usual) } }
                    td.about { (parameter.about) }
                }
            }
        }
    };
    html! {
        section #settings {
            details {
                summary {
                    h2 { "Settings in force" }
                    span.count { (changed.len()) " of " (changed.len() + usual.len()) " differ from the defaults" }
                }
                p.filters {
                    input type="search" placeholder="Search settings" aria-label="Search settings";
                }
                (html::table(&["Setting", "Value", "Default", "Meaning"], &rows))
            }
        }
    }
}

/// Commands that repeat and examine the run.
fn commands(input: &PageInput<'_>) -> Markup {
    let log = shell_word(input.log);
    let mut commands = Vec::new();
    commands.extend(input.made_by.map(|line| (line.to_owned(), "the run again")));
    commands.push((
        format!("armbridge replay {log}"),
        "every tick through the board's code again, compared bit for bit",
    ));
    commands.push((
        format!("armbridge info {log}"),
        "counts, faults, commands and settings",
    ));
    commands.push((format!("armbridge plot {log}"), "figures as SVG and PNG"));
    if let Some(beside) = input.beside {
        commands.push((
            format!("armbridge diff {log} {}", shell_word(beside.log)),
            "where both runs differ",
        ));
    }
    commands.push((
        format!("armbridge export csv {log}"),
        "every tick as a table",
    ));
    html! {
        section #commands {
            h2 { "Commands" }
            ul {
                @for (line, about) in &commands {
                    li {
                        span.about { (about) }
                        code { (line) }
                        button.copy type="button" aria-label={ "Copy " (line) } { "copy" }
                    }
                }
            }
        }
    }
}

/// A path as a word of a shell.
fn shell_word(path: &Path) -> String {
    shell_text::word(&path.display().to_string())
}

/// Files of the folder, with links.
fn files(folder: &Path) -> Markup {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let file = |entry: std::fs::DirEntry| {
        let metadata = entry.metadata().ok()?;
        let name = entry.file_name().into_string().ok()?;
        (metadata.is_file() && name != FILE).then_some((name, metadata.len()))
    };
    let mut files: Vec<(String, u64)> = entries.filter_map(file).collect();
    files.sort();
    html! {
        @if !files.is_empty() {
            section #files {
                h2 { "Files beside this page" }
                ul {
                    @for (name, bytes) in &files {
                        li { a href={ "./" (percent_encoded(name)) } { (name) } " " span.unit { (size(*bytes)) } }
                    }
                }
            }
        }
    }
}

/// A name as part of an address.
fn percent_encoded(name: &str) -> String {
    let letter = |byte: u8| {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            char::from(byte).to_string()
        } else {
            format!("%{byte:02X}")
        }
    };
    name.bytes().map(letter).collect()
}

fn size(bytes: u64) -> String {
    if bytes < 1_000_000 {
        format!("{:.0} kB", (bytes as f64 / 1e3).ceil())
    } else {
        format!("{:.1} MB", bytes as f64 / 1e6)
    }
}
