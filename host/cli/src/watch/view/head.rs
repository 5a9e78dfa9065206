//! The lines at the top: which link, what the board does, what is wrong and what to
//! do about it.

use armbridge_client::status::Obstacle;
use armbridge_client::{enum_names, experiment_text, fault_text};
use armbridge_link::message::{Drive, Fault, Mode};
use armbridge_link::server::LinkRole;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::theme;
use crate::watch::model::{Line as LinkLine, Model};

/// The link's name, this program's role on it, and its state.
pub(super) fn title(
    model: &Model,
    role: Option<LinkRole>,
    link_name: &str,
    width: u16,
) -> Line<'static> {
    let left = format!(" armbridge watch · {link_name}");
    let right = match model.line() {
        LinkLine::Opening => "waiting for the board ".to_owned(),
        LinkLine::Up => format!("link up, {:.0}/s ", model.link.frames_per_s(model.now_ns())),
        LinkLine::Quiet(ns) => format!("quiet for {:.1} s ", ns as f64 * 1e-9),
        LinkLine::Parted(ns) => format!("lost for {:.1} s ", ns as f64 * 1e-9),
    };
    let role = match role {
        None => "",
        Some(role) if role.is_commander => "COMMANDING · ",
        Some(_) => "OBSERVING · ",
    };
    let right = format!("{role}{right}");
    let taken = left.chars().count() + right.chars().count();
    let between = " ".repeat(usize::from(width).saturating_sub(taken));
    Line::from(format!("{left}{between}{right}")).style(theme::badge(Style::new()))
}

/// Commander in place of this program.
pub(super) fn observer(role: LinkRole) -> Option<Line<'static>> {
    let commander = match role.commander {
        _ if role.is_commander => return None,
        Some(program) => format!("{program} commands the board"),
        None => "no program commands the board".to_owned(),
    };
    Some(badge(
        "OBSERVING",
        theme::warn(),
        &format!("{commander}; space stops it"),
    ))
}

/// Mode of the board, and its fault or obstacle: one to three lines. An observer clears no
/// fault.
pub(super) fn state(model: &Model, is_observer: bool) -> Vec<Line<'static>> {
    match model.line() {
        LinkLine::Opening => {
            return vec![badge(
                "WAITING",
                theme::warn(),
                "nothing heard from a board yet",
            )];
        }
        LinkLine::Parted(ns) => return lost(model, "LINK LOST", "the connection broke", ns),
        // A program on the transparent port has the bus: there are no ticks to tell of.
        LinkLine::Quiet(_) if model.board.mode() == Some(Mode::Passthrough) => {}
        LinkLine::Quiet(ns) => return lost(model, "SILENT", "no messages from the board", ns),
        LinkLine::Up => {}
    }
    let Some(mode) = model.board.mode() else {
        return vec![badge("CONNECTED", theme::warn(), &waiting_for(model))];
    };
    if let Mode::Fault(fault) = mode {
        return tripped(model, fault, is_observer);
    }
    let (word, meaning) = fault_text::mode(mode);
    let style = match mode {
        Mode::Running(_) => theme::good(),
        Mode::MotorCheck | Mode::Armed | Mode::Degraded(_) | Mode::Boot | Mode::Passthrough => {
            theme::warn()
        }
        Mode::Idle | Mode::Fault(_) => Style::new(),
    };
    let guards = model
        .board
        .record
        .map(|record| enum_names::guards(record.output.guards));
    let guards = guards.filter(|guards| !guards.is_empty());
    let meaning = guards.map_or_else(
        || meaning.to_owned(),
        |guards| format!("{meaning}; torque held back: {guards}"),
    );
    let mut lines = vec![badge(word, style, &meaning)];
    if let (Some(Drive::Hold), Some(conclusion)) = (mode.drive(), &model.board.concluded) {
        let ended = experiment_text::conclusion(conclusion);
        lines.push(Line::from(format!("   {ended}")));
    }
    if let Some(obstacle) = model.board.obstacle {
        let help = match obstacle {
            Obstacle::NotReady => ": press a to set them",
            _ => "",
        };
        lines.push(Line::from(format!(" ! {obstacle}{help}")).style(theme::warn()));
    }
    lines
}

/// A word on its own ground, and what it means.
fn badge(word: &str, style: Style, meaning: &str) -> Line<'static> {
    Line::from(vec![
        Span::from(format!(" {word} ")).style(theme::badge(style)),
        Span::from(format!("  {meaning}")),
    ])
}

fn waiting_for(model: &Model) -> String {
    let searching = || "the servos are being looked for".into();
    let obstacle = model.board.obstacle;
    obstacle.map_or_else(searching, |obstacle| obstacle.to_string())
}

fn lost(model: &Model, word: &str, cause: &str, ns: u64) -> Vec<Line<'static>> {
    let ago = format!("{cause} {:.1} s ago; trying again", ns as f64 * 1e-9);
    let mut lines = vec![badge(word, theme::bad(), &ago)];
    let was = model
        .board
        .mode()
        .map_or("not known", |mode| fault_text::mode(mode).0);
    let off = model.board.settings.map_or_else(
        || "by itself the board switches torque off".to_owned(),
        |settings| {
            let limits = settings.limits;
            format!(
                "it brakes after {} ms of silence, torque is off after {}",
                limits.hold_ms, limits.silence_ms
            )
        },
    );
    lines.push(Line::from(format!("   last seen {was}; {off}")));
    lines
}

fn tripped(model: &Model, fault: Fault, is_observer: bool) -> Vec<Line<'static>> {
    let (cause, details, remedy) = if let Some(trip) = &model.board.trip {
        let description = fault_text::in_words(trip);
        let measured = description
            .measured
            .map(|measured| format!("{measured} · "));
        let details = format!("{}tick {} · ", measured.unwrap_or_default(), trip.tick);
        (description.cause, details, description.remedy)
    } else {
        let (cause, remedy) = (fault.cause(), fault.remedy());
        (cause.to_owned(), String::new(), remedy)
    };
    let off = model.board.off.as_ref().map(fault_text::off);
    let after = off.unwrap_or_else(|| "motors commanded off, not yet seen to be".to_owned());
    let how = if is_observer {
        "its commander clears"
    } else {
        "c clears"
    };
    vec![
        badge("FAULT", theme::bad(), &cause),
        Line::from(format!("   {details}{after}")),
        Line::from(format!(" → {remedy} ({how})")).style(theme::warn()),
    ]
}
