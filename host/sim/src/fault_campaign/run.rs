//! Runs of a case.

use std::panic::{AssertUnwindSafe, catch_unwind};

use armbridge_board::bridge::Channels;
use armbridge_client::event::Event;

use super::case::Case;
use super::fixture::Fixture;
use super::oracle::CaseRunner;
use super::outcome::Outcome;
use super::trace::Trace;

/// Runs a case.
pub fn run(case: &Case) -> Outcome {
    run_case(case, &mut Trace::off(), None)
}

/// The same; `on_event` takes the messages on the link as they pass the board.
pub fn run_with_events(case: &Case, mut on_event: impl FnMut(Event)) -> Outcome {
    run_case(case, &mut Trace::off(), Some(&mut on_event))
}

/// The same, with the case as text.
pub fn run_with_trace(case: &Case) -> (Outcome, String) {
    let mut trace = Trace::default();
    trace.begin(case);
    let outcome = run_case(case, &mut trace, None);
    trace.end(&outcome);
    (outcome, trace.text())
}

/// A case that panics has failed.
pub(super) fn run_case(
    case: &Case,
    trace: &mut Trace,
    on_event: Option<&mut dyn FnMut(Event)>,
) -> Outcome {
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        let (mut channels, mut spare) = (Channels::new(), Channels::new());
        match Fixture::new(case, [channels.split(), spare.split()]) {
            Ok(mut fixture) => {
                if let Some(on_event) = on_event {
                    fixture.cosim.board.decode_link(on_event);
                }
                CaseRunner::new(case, fixture, trace).run()
            }
            Err(why) => Outcome::new(case).failed(why),
        }
    }));
    outcome.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Outcome::new(case).failed(format!("panicked: {}", text.unwrap_or("")))
    })
}
