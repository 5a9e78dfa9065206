//! From a seed to what became of it.

use std::panic::{AssertUnwindSafe, catch_unwind};

use armbridge_client::event::Event;
use armbridge_shared::bridge::Channels;
use armbridge_shared::servo::Firmware;

use super::case::Case;
use super::fixture::World;
use super::oracle::Judge;
use super::outcome::Outcome;
use super::trace::Story;

/// Runs the case of this seed, with servos of this firmware.
pub fn run(seed: u64, servos: Firmware) -> Outcome {
    judge(&Case::new(seed, servos), &mut Story::untold(), None)
}

/// The same, with whatever is said on the link told to `hear`, as the board hears it.
pub fn overhear(seed: u64, servos: Firmware, mut hear: impl FnMut(Event)) -> Outcome {
    let case = Case::new(seed, servos);
    judge(&case, &mut Story::untold(), Some(&mut hear))
}

/// The same, told.
pub fn run_with_story(seed: u64, servos: Firmware) -> (Outcome, String) {
    let mut story = Story::default();
    let case = Case::new(seed, servos);
    story.begin(&case);
    let outcome = judge(&case, &mut story, None);
    story.end(&outcome);
    (outcome, story.text())
}

/// A case that panics is one that failed.
fn judge(case: &Case, story: &mut Story, hear: Option<&mut dyn FnMut(Event)>) -> Outcome {
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        let mut channels = Channels::new();
        match World::new(case, channels.split()) {
            Ok(mut world) => {
                if let Some(hear) = hear {
                    world.cosim.board.overhear(hear);
                }
                Judge::new(case, world, story).run()
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
