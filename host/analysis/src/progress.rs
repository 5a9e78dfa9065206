//! Progress bar of a run, on a terminal only.
//!
//! The bar is drawn on standard error, so that standard output contains only the
//! summary. It is hidden if standard error is not a terminal, or on request.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Redraws per second, limited because a run at 1 kHz would otherwise spend its time
/// drawing.
const REDRAWS_PER_S: u8 = 15;

/// A progress bar over the time of a run.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// Bar for a run of `total_s` seconds, hidden if `quiet`.
    pub fn new(total_s: f64, quiet: bool) -> Self {
        let visible = !quiet && std::io::stderr().is_terminal();
        let target = if visible {
            ProgressDrawTarget::stderr_with_hz(REDRAWS_PER_S)
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(Some(milliseconds(total_s)), target);
        // If the template does not parse, the bar has the default style.
        if let Ok(style) = ProgressStyle::with_template("{bar:20} {percent:>3} %  {wide_msg}") {
            bar.set_style(style.progress_chars("━━╌"));
        }
        Self { bar }
    }

    /// Sets the position, in the unit of the total.
    pub fn set_position(&self, now_s: f64) {
        let now_ms = milliseconds(now_s);
        if now_ms != self.bar.position() {
            self.bar.set_position(now_ms);
        }
    }

    /// Shows a message beside the bar.
    pub fn set_message(&self, text: impl Into<std::borrow::Cow<'static, str>>) {
        self.bar.set_message(text);
    }

    /// Removes the bar from the terminal.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

fn milliseconds(time_s: f64) -> u64 {
    (time_s * 1e3) as u64
}
