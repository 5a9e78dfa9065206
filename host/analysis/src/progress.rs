//! How far a run has come, on a terminal only.
//!
//! Drawn on standard error, so that standard output stays clean for the
//! summary. Silent when standard error is not a terminal, or when so requested.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Redraws per second; the eye asks for no more, and a run at 1 kHz would
/// otherwise spend its time drawing.
const REDRAWS_PER_S: u8 = 15;

/// A progress bar over the time of a run.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar for a run of this length, hidden if `quiet`.
    pub fn new(total_s: f64, quiet: bool) -> Self {
        let visible = !quiet && std::io::stderr().is_terminal();
        let target = if visible {
            ProgressDrawTarget::stderr_with_hz(REDRAWS_PER_S)
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(Some(milliseconds(total_s)), target);
        // A template that does not parse leaves the default style: still a bar.
        if let Ok(style) = ProgressStyle::with_template("{bar:20} {percent:>3} %  {wide_msg}") {
            bar.set_style(style.progress_chars("━━╌"));
        }
        Self { bar }
    }

    /// The run has come to this time.
    pub fn at(&self, now_s: f64) {
        let now_ms = milliseconds(now_s);
        if now_ms != self.bar.position() {
            self.bar.set_position(now_ms);
        }
    }

    /// Shows what the run is doing.
    pub fn say(&self, what: impl Into<std::borrow::Cow<'static, str>>) {
        self.bar.set_message(what);
    }

    /// Takes the bar off the terminal, to make room for what follows.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

fn milliseconds(time_s: f64) -> u64 {
    (time_s * 1e3) as u64
}
