//! The numbers once more, without the last fifth of the windows, and how well these tell
//! what was left out: where there is no other log, the only forecast there is.

use armbridge_shared::JOINTS;

use super::arm::Known;
use super::checks::Checks;
use super::cost::{Stretch, cost};
use super::dataset::Window;
use super::fit_result::Found;
use super::forecast::{Forecast, of_windows};
use super::search::{Prior, Search};

/// Share of the windows that is held out.
const HELD_OUT: f64 = 0.2;
/// Ticks in all windows up to which the second fit is made: six minutes at 1 kHz. A search
/// that begins near its end evaluates them some twelve times.
const TICKS_MAX: usize = 360_000;

/// Forecasts of the last fifth of both joints' windows by numbers from the others; none for
/// windows of more than [`TICKS_MAX`] ticks, which would take a while.
pub fn without_the_last(
    found: &Found,
    checks: &Checks,
    known: &Known,
    prior: &Prior,
) -> Option<Vec<Forecast>> {
    let ticks: usize = found
        .stretches
        .iter()
        .map(|stretch| stretch.window.len)
        .sum();
    if ticks > TICKS_MAX {
        return None;
    }
    let known = &known.with(&found.stribeck);
    let mut kept = found.stretches.clone();
    cost(&mut kept, &checks.traces, known, &found.at, found.most);
    let held: [Vec<Window>; JOINTS] = core::array::from_fn(|joint| last(&found.stretches, joint));
    let is_kept = |stretch: &Stretch| {
        let Window {
            trace,
            joint,
            first,
            ..
        } = stretch.window;
        let is_it = |window: &Window| (window.trace, window.first) == (trace, first);
        !held[joint].iter().any(is_it)
    };
    let kept = kept.into_iter().filter(is_kept).collect();
    let judged = [found.noise_counts.powi(2), found.most];
    let search = Search::begin(kept, &checks.traces, known, prior, found.at, judged).run();
    let of = |joint| of_windows(joint, &held[joint], &checks.traces, known, &search.at());
    let forecasts = (0..JOINTS).map(of);
    Some(
        forecasts
            .map(|forecast| forecast.less_noise(found.noise_counts))
            .collect(),
    )
}

/// The last windows of a joint, in the order of traces.
fn last(stretches: &[Stretch], joint: usize) -> Vec<Window> {
    let of_joint = stretches
        .iter()
        .filter(|stretch| stretch.window.joint == joint);
    let mut windows: Vec<Window> = of_joint.map(|stretch| stretch.window.clone()).collect();
    windows.sort_by_key(|window| (window.trace, window.first));
    let kept = windows.len() - (windows.len() as f64 * HELD_OUT) as usize;
    windows.split_off(kept)
}
