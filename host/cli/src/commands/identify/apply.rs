//! The identified arm, sent to the board with gains designed for it.

use std::io::Write;
use std::process::ExitCode;

use armbridge_analysis::design::{Design, Redesign, retune};
use armbridge_client::params;
use armbridge_client::params::settings_exchange;
use armbridge_client::refusal_text;
use armbridge_log::text_table;
use armbridge_shared::link::message::Settings;

use super::super::params_exchange::{Sent, differences};
use super::super::{Error, ask};
use super::Fit;
use crate::args::LinkArgs;

/// The board, and whether the user confirms.
pub(super) struct Apply<'a> {
    pub(super) link: &'a LinkArgs,
    /// The board is changed without a question.
    pub(super) is_sure: bool,
    /// Tables go to standard error.
    pub(super) is_silent: bool,
}

/// Result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Applied {
    /// The board has it, and keeps it.
    Saved,
    /// It is unchanged, for a reason that was printed.
    Not,
}

impl Applied {
    pub(super) fn exit_code(self) -> ExitCode {
        match self {
            Self::Saved => ExitCode::SUCCESS,
            Self::Not => ExitCode::from(1),
        }
    }
}

impl Apply<'_> {
    /// Shows the changes, asks, and sends them, unless the parameters are too uncertain.
    pub(super) fn to_board(&self, fit: &Fit) -> Result<Applied, Error> {
        let vague = fit.report.too_vague();
        if !vague.is_empty() {
            for number in vague {
                eprintln!("armbridge: {number}");
            }
            return Ok(not(
                "the identified parameters are too uncertain to control an arm by",
            ));
        }
        let mut redesign = Redesign::OnBoard;
        let decide = |before: &Settings| {
            let (after, what) = wanted(before, fit)?;
            redesign = what;
            Ok(after)
        };
        let Sent { before, after, .. } = Sent::to(self.link, decide, |_, _| Vec::new())?;
        let is_known = params::changed(&before, &after).is_empty();
        if !is_known {
            let new = match judged(&after) {
                Ok(new) => new,
                Err(why) => return Ok(not(&why)),
            };
            let old = Design::of(&before.setup).ok();
            self.say(&differences(&before, &after))?;
            self.say(&gains(old.as_ref(), &new, redesign))?;
            for note in fit.report.may_lean() {
                eprintln!("note: {note}");
            }
            let question = "The board takes over all of this, and keeps it across power-off.";
            if !self.is_sure && !ask::is_agreed(question) {
                return Ok(not("the answer was not yes"));
            }
        }
        let still = |now: &Settings| {
            if *now == before {
                Ok(after)
            } else {
                Err(
                    "the board's settings were changed by another program meanwhile; run it again"
                        .into(),
                )
            }
        };
        let orders = |before: &_, after: &_| settings_exchange::commands(before, after, true);
        let sent = Sent::to(self.link, still, orders)?;
        if let Some(line) = sent.refusal() {
            return Ok(not(&line));
        }
        let done = if is_known {
            "the board computes with this arm already"
        } else {
            "the board has taken it"
        };
        self.say(&format!("{done}, and keeps its settings across power-off"))?;
        Ok(Applied::Saved)
    }

    fn say(&self, text: &str) -> Result<(), Error> {
        let text = text.trim_end();
        if self.is_silent {
            eprintln!("{text}");
        } else {
            writeln!(std::io::stdout(), "{text}")?;
        }
        Ok(())
    }
}

/// The control loop with these settings, if it is stable and a board would accept it.
fn judged(after: &Settings) -> Result<Design, String> {
    match Design::of(&after.setup) {
        Ok(design) if design.is_stable => Ok(design),
        Ok(_) => Err("with this arm the loop would be unstable: `armbridge design`".into()),
        Err(why) => Err(format!(
            "the board would refuse it: {}; `armbridge design`",
            refusal_text::in_words(why)
        )),
    }
}

/// Prints why nothing is changed.
pub(super) fn not(why: &str) -> Applied {
    eprintln!("armbridge: not applied: {why}");
    Applied::Not
}

/// The board's own settings, with the arm that was found and gains for it.
fn wanted(before: &Settings, fit: &Fit) -> Result<(Settings, Redesign), Error> {
    let mut after = *before;
    let arm = fit.arm()?;
    let pairs = arm.iter().map(|(parameter, value)| (parameter.key, value));
    params::apply(&mut after, pairs)?;
    let (setup, redesign) = retune(&before.setup, &after.setup)?;
    after.setup = setup;
    params::check(&after)?;
    Ok((after, redesign))
}

/// Gains before and after, and the margins that there are then.
fn gains(old: Option<&Design>, new: &Design, redesign: Redesign) -> String {
    let mut rows = vec![
        ["gain", "", "q1", "q2", "dq1", "dq2"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for (joint, row) in new.gain.iter().enumerate() {
        let before = old.map(|old| old.gain[joint]);
        for (when, row) in [("before", before), ("then", Some(*row))] {
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
