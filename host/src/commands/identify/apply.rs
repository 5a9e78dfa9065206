//! The arm that was found, sent to the board, with gains that go with it.

use std::io::Write;
use std::process::ExitCode;

use armbridge::design::{Design, Redesign, again};
use armbridge::params::{self, exchange};
use armbridge::{refusal, table};
use armbridge_shared::link::message::{Settings, Setup};

use super::super::set::{Sent, differences};
use super::super::{Error, ask};
use super::Fit;
use crate::cli::LinkArgs;

/// Where to, and whether anybody is asked.
pub(super) struct Apply<'a> {
    pub(super) link: &'a LinkArgs,
    /// The board is changed without a question.
    pub(super) is_sure: bool,
    /// What is shown goes to standard error.
    pub(super) is_silent: bool,
}

/// What became of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Applied {
    /// The board has it, and keeps it.
    Saved,
    /// It is as it was, for a reason that was told.
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
    /// Shows what changes, asks, and changes it, unless what was found is too vague.
    pub(super) fn to_board(&self, fit: &Fit) -> Result<Applied, Error> {
        let vague = fit.report.too_vague();
        if !vague.is_empty() {
            for number in vague {
                eprintln!("armbridge: {number}");
            }
            return Ok(not("what was found is too vague to control an arm by"));
        }
        let read = Sent::to(self.link, |before| wanted(before, fit), |_, _| Vec::new())?;
        let Sent { before, after, .. } = read;
        if params::changed(&before, &after).is_empty() {
            self.say("the board computes with this arm already")?;
            return Ok(Applied::Saved);
        }
        let redesign = again(&before.setup, &after.setup)?.1;
        let [old, new] = [before, after].map(|settings| Design::of(&settings.setup));
        let new = match new {
            Ok(new) if new.is_stable => new,
            Ok(_) => {
                return Ok(not(
                    "with this arm the loop would be unstable: `armbridge design`",
                ));
            }
            Err(why) => {
                let why = refusal::in_words(why);
                return Ok(not(&format!(
                    "the board would refuse it: {why}; `armbridge design`"
                )));
            }
        };
        self.say(&differences(&before, &after))?;
        self.say(&gains(old.ok().as_ref(), &new, redesign))?;
        for note in fit.report.may_lean() {
            eprintln!("note: {note}");
        }
        let question = "The board takes over all of this, and keeps it across power-off.";
        if !self.is_sure && !ask::is_agreed(question) {
            return Ok(not("the answer was not yes"));
        }
        let still = |now: &Settings| {
            if *now == before {
                Ok(after)
            } else {
                Err("somebody else has changed the board's settings meanwhile; do it again".into())
            }
        };
        let orders = |before: &_, after: &_| exchange::commands(before, after, true);
        let sent = Sent::to(self.link, still, orders)?;
        if let Some(line) = sent.refusal() {
            return Ok(not(&line));
        }
        self.say("the board has taken it, and keeps its settings across power-off")?;
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

/// Says why nothing is changed.
fn not(why: &str) -> Applied {
    eprintln!("armbridge: not applied: {why}");
    Applied::Not
}

/// The board's own settings, with the arm that was found and gains for it.
fn wanted(before: &Settings, fit: &Fit) -> Result<Settings, Error> {
    let mut after = *before;
    let changes = fit.changes()?;
    params::apply(
        &mut after,
        changes
            .iter()
            .map(|(parameter, value)| (parameter.key, value)),
    )?;
    let (setup, _): (Setup, Redesign) = again(&before.setup, &after.setup)?;
    after.setup = setup;
    params::check(&after)?;
    Ok(after)
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
        table::columns(&rows),
        redesign.in_words(),
        disc.alpha
    )
}
