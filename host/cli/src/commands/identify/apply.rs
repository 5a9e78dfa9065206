//! The identified arm, sent to the board with gains designed for it.

use std::process::ExitCode;

use armbridge::config::Config;
use armbridge_analysis::design::{Design, Redesign};
use armbridge_analysis::identify::ArmFit;
use armbridge_client::params::settings_exchange;
use armbridge_client::{params, refusal_text, stdio};
use armbridge_link::message::Settings;
use armbridge_log::text_table;

use super::super::params_exchange::{Sent, differences, kept};
use super::super::{Error, ask};
use crate::args::LinkArgs;

/// The board, and whether the user confirms.
pub(super) struct Apply<'a> {
    pub(super) link: &'a LinkArgs,
    /// The board is changed without a question.
    pub(super) is_confirmed: bool,
    /// Tables go to standard error.
    pub(super) is_silent: bool,
}

/// Result of [`Apply::to_board`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Applied {
    /// The board has the arm in use and saved.
    Saved,
    /// The board is unchanged; the reason is printed.
    Unchanged,
}

impl Applied {
    pub(super) fn exit_code(self) -> ExitCode {
        match self {
            Self::Saved => ExitCode::SUCCESS,
            Self::Unchanged => ExitCode::from(1),
        }
    }
}

impl Apply<'_> {
    /// Shows the changes, asks, and sends them, unless the parameters are too uncertain.
    pub(super) fn to_board(&self, fit: &ArmFit) -> Result<Applied, Error> {
        let uncertain = fit.report.too_uncertain();
        if !uncertain.is_empty() {
            for parameter in uncertain {
                stdio::note(format_args!("armbridge: {parameter}"));
            }
            return Ok(not_applied(
                "the identified parameters are too uncertain to control an arm by",
            ));
        }
        let mut redesign = Redesign::OnBoard;
        let decide = |before: &Settings| {
            let (after, how) = fit.adopted_by(before)?;
            redesign = how;
            Ok(after)
        };
        let Sent { before, after, .. } = Sent::to(self.link, decide, |_, _| Vec::new())?;
        let is_unchanged = params::changed(&before, &after).is_empty();
        if !is_unchanged {
            let new = match stable_design(&after) {
                Ok(new) => new,
                Err(why) => return Ok(not_applied(&why)),
            };
            let old = Design::from_setup(&before.setup).ok();
            self.print_text(&differences(&before, &after))?;
            self.print_text(&gains(old.as_ref(), &new, redesign))?;
            for note in fit.report.zero_notes() {
                stdio::note(format_args!("note: {note}"));
            }
            let question = "The board takes over all of this, and keeps it across power-off.";
            if !self.is_confirmed && !ask::is_agreed(question) {
                return Ok(not_applied("the answer was not yes"));
            }
        }
        let unless_changed = |now: &Settings| {
            if *now == before {
                Ok(after)
            } else {
                Err(
                    "the board's settings were changed by another program meanwhile; run it again"
                        .into(),
                )
            }
        };
        let commands = |before: &_, after: &_| settings_exchange::commands(before, after, true);
        let sent = Sent::to(self.link, unless_changed, commands)?;
        if let Some(line) = sent.refusal() {
            return Ok(not_applied(&line));
        }
        let done = if is_unchanged {
            "the board has this arm already"
        } else {
            "the board has taken it"
        };
        let link = Config::discover()?.link(self.link.link.as_ref())?;
        self.print_text(&format!("{done}{}", kept(&link, true)))?;
        Ok(Applied::Saved)
    }

    fn print_text(&self, text: &str) -> Result<(), Error> {
        let text = text.trim_end();
        if self.is_silent {
            stdio::note(text);
        } else {
            stdio::print_line(text)?;
        }
        Ok(())
    }
}

/// The control loop with these settings, if it is stable and a board would accept it.
fn stable_design(after: &Settings) -> Result<Design, String> {
    match Design::from_setup(&after.setup) {
        Ok(design) if design.is_stable => Ok(design),
        Ok(_) => Err("with this arm the loop would be unstable: `armbridge design`".into()),
        Err(why) => Err(format!(
            "the board would refuse it: {}; `armbridge design`",
            refusal_text::in_words(why)
        )),
    }
}

/// Prints why nothing is changed.
pub(super) fn not_applied(why: &str) -> Applied {
    stdio::note(format_args!("armbridge: not applied: {why}"));
    Applied::Unchanged
}

/// Gains before and after, and the disc margin after.
fn gains(old: Option<&Design>, new: &Design, redesign: Redesign) -> String {
    let mut rows = vec![
        ["gain", "", "q1", "q2", "dq1", "dq2"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for (joint, row) in new.gain.iter().enumerate() {
        let before = old.map(|old| old.gain[joint]);
        for (when, row) in [("before", before), ("after", Some(*row))] {
            let Some(row) = row else { continue };
            let cells = row.iter().map(|k| format!("{k:.4}"));
            let head = [format!("torque {}", joint + 1), when.to_owned()];
            rows.push(head.into_iter().chain(cells).collect());
        }
    }
    let disc = new.margins.disc;
    format!(
        "\n{}\n{}; disc margin {:.3}\n",
        text_table::columns(&rows),
        redesign.in_words(),
        disc.alpha
    )
}
