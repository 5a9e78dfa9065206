//! The terminal: keys in, pictures out, as long as the link is served.
//!
//! Drawn fifteen times a second, which is enough for the eye and little for the
//! processor; keys are acted upon at once.

use std::collections::VecDeque;
use std::io;
use std::time::{Duration, Instant};

use armbridge_client::ctrl_c;
use armbridge_client::event_queue::EventQueue;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event as TerminalEvent, KeyEventKind};

use super::keys::{Action, Keys};
use super::model::Model;
use super::view;
use crate::link_thread::LinkThread;

/// Between two pictures.
const FRAME: Duration = Duration::from_millis(66);

/// Shows `event_queue` and obeys keys until the person quits or the link ends. The terminal
/// is restored when this returns or panics.
///
/// # Errors
/// If the terminal cannot be drawn on.
pub fn show(
    session: &LinkThread,
    event_queue: &EventQueue,
    is_simulated: bool,
    link_name: &str,
) -> io::Result<Model> {
    // Restores the terminal in a panic, too, whichever thread it is in.
    let terminal = ratatui::try_init()?;
    let shown = run(terminal, session, event_queue, is_simulated, link_name);
    ratatui::try_restore()?;
    shown
}

fn run(
    mut terminal: DefaultTerminal,
    session: &LinkThread,
    event_queue: &EventQueue,
    is_simulated: bool,
    link_name: &str,
) -> io::Result<Model> {
    let mut model = Model::default();
    let mut keys = Keys::new(is_simulated);
    let mut events = VecDeque::new();
    while !session.is_over() && !ctrl_c::is_raised() {
        let begun = Instant::now();
        model.unseen += event_queue.take(&mut events);
        for event in &events {
            model.take(event);
        }
        if let Some(now_ns) = event_queue.now_ns() {
            model.advance(now_ns);
        }
        keys.role = session.role();
        keys.is_touchable = is_simulated || keys.role.is_some_and(|role| role.is_touchable);
        terminal.draw(|frame| view::draw(frame, &model, &keys, link_name))?;
        while event::poll(FRAME.saturating_sub(begun.elapsed()))? {
            let TerminalEvent::Key(key) = event::read()? else {
                // Of another size now: drawn at once.
                break;
            };
            if key.kind == KeyEventKind::Release {
                continue;
            }
            for act in keys.press(key, &model) {
                match act {
                    Action::Request(request) => session.request(request),
                    Action::Hand(hand) => session.apply_hand(hand),
                    Action::Quit => return Ok(model),
                }
            }
        }
    }
    Ok(model)
}
