//! The terminal: keys in, pictures out, as long as the link is served.
//!
//! Drawn fifteen times a second, which is enough for the eye and little for the
//! processor; keys are acted upon at once. Keys are read on a thread of their own: where the
//! terminal has hung up, that reading never returns, and the board must still be disarmed.

use std::collections::VecDeque;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use armbridge_client::ctrl_c;
use armbridge_client::ctrl_c::Signal;
use armbridge_client::event_queue::EventQueue;
use armbridge_client::session::Request;
use armbridge_sim::link::LinkThread;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event as TerminalEvent, KeyEventKind};

use super::keys::{Action, Keys};
use super::model::Model;
use super::playback::{Playback, Progress};
use super::view;

/// Between two pictures.
const FRAME: Duration = Duration::from_millis(66);

/// Between two looks of the thread that reads keys whether it is still of use.
const LOOK: Duration = Duration::from_millis(100);

/// Failure of the terminal.
#[derive(Debug, thiserror::Error)]
pub enum ScreenError {
    /// It cannot be drawn on from the beginning.
    #[error("cannot draw on this terminal: {0}; is TERM right?")]
    Draw(io::Error),
    /// It hung up: its window or its connection was closed.
    #[error("the terminal is gone")]
    Gone,
}

/// Shows `event_queue` and obeys keys until the person quits or the link ends. The terminal
/// is restored when this returns or panics.
///
/// # Errors
/// If the terminal cannot be drawn on, or hangs up.
pub fn show(
    session: &LinkThread,
    event_queue: &EventQueue,
    is_simulated: bool,
    link_name: &str,
) -> Result<Model, ScreenError> {
    // Restores the terminal in a panic, too, whichever thread it is in.
    let mut terminal = ratatui::try_init().map_err(ScreenError::Draw)?;
    let shown = run(&mut terminal, session, event_queue, is_simulated, link_name);
    let has_cursor = terminal.show_cursor();
    // Its destructor shows the cursor, too, and panics where the terminal is gone.
    std::mem::forget(terminal);
    let restored = has_cursor.and(ratatui::try_restore());
    if ctrl_c::raised() == Some(Signal::HangUp) {
        return Err(ScreenError::Gone);
    }
    // It could be drawn on before.
    let model = shown.map_err(|_| ScreenError::Gone)?;
    restored.map_err(|_| ScreenError::Gone)?;
    Ok(model)
}

/// Keys that were pressed, and changes of the terminal's size.
struct Keyboard {
    events: Receiver<TerminalEvent>,
    is_over: Arc<AtomicBool>,
}

impl Keyboard {
    fn new() -> Self {
        let (sender, events) = channel();
        let is_over = Arc::new(AtomicBool::new(false));
        let end = Arc::clone(&is_over);
        // Not joined: on a terminal that has hung up, it does not end before the program.
        std::thread::spawn(move || {
            while !end.load(Ordering::Relaxed) {
                match event::poll(LOOK) {
                    Ok(false) => {}
                    Ok(true) => {
                        let Ok(event) = event::read() else { return };
                        if sender.send(event).is_err() {
                            return;
                        }
                    }
                    Err(_) => return,
                }
            }
        });
        Self { events, is_over }
    }
}

impl Drop for Keyboard {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
    }
}

fn run(
    terminal: &mut DefaultTerminal,
    session: &LinkThread,
    event_queue: &EventQueue,
    is_simulated: bool,
    link_name: &str,
) -> io::Result<Model> {
    let mut model = Model::default();
    let mut keys = Keys::new(is_simulated);
    let mut playback: Option<Playback> = None;
    let mut events = VecDeque::new();
    let keyboard = Keyboard::new();
    while !session.is_over() && !ctrl_c::is_raised() {
        let begun = Instant::now();
        model.unseen += event_queue.take(&mut events);
        for event in &events {
            model.take(event);
        }
        if let Some(now_ns) = event_queue.now_ns() {
            model.advance(now_ns);
        }
        if let (Some(player), Some(record)) = (&mut playback, model.board.record) {
            match player.advance(&record, model.board_us()) {
                Progress::Due(commands) => {
                    let requests = commands.into_iter().map(Request::Command);
                    requests.for_each(|request| session.request(request));
                }
                Progress::Done => {
                    playback = None;
                    keys.result = Some("the motion has been replayed".into());
                }
                Progress::Ended => {
                    playback = None;
                    keys.result = Some("the replay has ended before its time".into());
                }
            }
        }
        keys.role = session.role();
        keys.is_touchable = is_simulated || keys.role.is_some_and(|role| role.is_touchable);
        terminal.draw(|frame| view::draw(frame, &model, &keys, link_name))?;
        loop {
            let left = FRAME.saturating_sub(begun.elapsed());
            let key = match keyboard.events.recv_timeout(left) {
                Ok(TerminalEvent::Key(key)) => key,
                // Of another size now, or time for the next picture: drawn at once.
                Ok(_) | Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(io::ErrorKind::UnexpectedEof.into());
                }
            };
            if key.kind == KeyEventKind::Release {
                continue;
            }
            for act in keys.press(key, &model) {
                match act {
                    Action::Request(request) => {
                        playback = None;
                        session.request(request);
                    }
                    Action::Play => match model.lesson.motion() {
                        Ok(taught) => {
                            let (begun, command) = Playback::begin(&taught, model.board_us());
                            playback = Some(begun);
                            session.request(Request::Command(command));
                        }
                        Err(error) => keys.result = Some(error.to_string()),
                    },
                    Action::Hand(hand) => session.touch(hand.into()),
                    Action::Teach => keys.result = Some(teach(&model)),
                    Action::Quit => return Ok(model),
                }
            }
        }
    }
    Ok(model)
}

/// Writes the motion of the last float into the working folder; returns the result in words.
fn teach(model: &Model) -> String {
    match model.lesson.write(Path::new("")) {
        Ok((file, duration_s)) => {
            let file = file.display();
            format!("{file}: {duration_s:.1} s of motion; replay it by `armbridge run {file}`")
        }
        Err(error) => format!("no motion is written: {error}"),
    }
}
