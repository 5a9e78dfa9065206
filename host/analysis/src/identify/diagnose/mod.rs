//! Whether an arm is identifiable from the data at all: a [`Diagnosis`] by name in place of
//! numbers that are wrong.
//!
//! | when       | what is looked at                                             |
//! |------------|---------------------------------------------------------------|
//! | before     | [`Tally`]: empty, samples lost, encoder or motor at a limit   |
//! | before     | sliding: too short; which motor a joint obeys, and which way  |
//! | after      | torque that nothing explains, with its seconds; the model     |

mod bump;
mod diagnosis;
mod driver;
mod external_torque;
mod tally;

pub use diagnosis::Diagnosis;
pub use external_torque::Push;
pub use tally::{OfJoint, Tally};

pub(super) use bump::Bump;

use armbridge_shared::JOINTS;

use super::arm::Known;
use super::cost::Stretch;
use super::dataset::Trace;
use super::fit::find;
use super::fit_result::Found;
use super::initial_guess::NoStart;
use super::quantity::Quantity;
use super::search::Prior;

/// Seconds for which a joint must slide: what the sharpest experiments take.
const SLIDES_S: f64 = 2.0;
/// Share of the windows that may be without explanation.
const ODD: f64 = 0.4;
/// Errors that are so many times the encoders' own noise are not theirs.
const NOISY: f64 = 2.0;
/// Longest window in ticks, of those that are counted.
const WINDOW: usize = 1_000;

/// Seeks the numbers of an arm in data that can tell them.
///
/// # Errors
/// If they cannot.
pub fn identify(
    traces: &[Trace],
    tally: &Tally,
    known: &Known,
    prior: &Prior,
) -> Result<Found, Diagnosis> {
    examine(traces, tally, known, prior)?;
    let found = find(traces, known, prior).map_err(|error| of_start(&error, known))?;
    judge(traces, known, &found)?;
    Ok(found)
}

/// Looks at data before anything is sought in them.
///
/// # Errors
/// If they cannot tell an arm.
pub fn examine(
    traces: &[Trace],
    tally: &Tally,
    known: &Known,
    prior: &Prior,
) -> Result<(), Diagnosis> {
    tally.check()?;
    let zero = [0, 1].map(|joint| Quantity::Zero.value(prior.mean[Quantity::Zero.at(joint)]));
    let smooth = smoothed(traces, known, zero);
    for joint in 0..JOINTS {
        let windows = smooth
            .iter()
            .flat_map(|trace| trace.windows(0, joint, WINDOW));
        let slid: usize = windows.map(|window| window.len).sum();
        let slid_s = slid as f64 * known.period_s;
        if slid_s < SLIDES_S {
            return Err(too_short(joint, slid_s));
        }
    }
    driver::check(&smooth, known)
}

/// Looks at what was found.
///
/// # Errors
/// If the data are not those of an arm that is left to its motors.
pub fn judge(traces: &[Trace], known: &Known, found: &Found) -> Result<(), Diagnosis> {
    let known = &known.with(&found.stribeck);
    let zero = [0, 1].map(|joint| found.number(joint, Quantity::Zero).0);
    let smooth = smoothed(traces, known, zero);
    let pushes = external_torque::pushes(&smooth, known, found);
    let strongest = |a: &&Push, b: &&Push| a.torque_nm.abs().total_cmp(&b.torque_nm.abs());
    if let Some(push) = pushes.iter().max_by(strongest) {
        let trace = &traces[push.trace];
        let from_s = trace.since_s + push.first as f64 * known.period_s;
        let all: usize = pushes.iter().map(|push| push.len).sum();
        return Err(Diagnosis::HeldByHand {
            log: trace.log + 1,
            joint: push.joint + 1,
            from_s,
            to_s: from_s + push.len as f64 * known.period_s,
            torque_nm: push.torque_nm.abs(),
            pushes: pushes.len(),
            all_s: all as f64 * known.period_s,
        });
    }
    let (odd, windows) = (found.odd(), found.stretches.len());
    let is_noisy = found.noise_counts > NOISY * noise_counts(traces);
    if is_noisy || odd as f64 > ODD * windows as f64 {
        let rms = |stretch: &Stretch| (stretch.squares / stretch.count as f64).sqrt();
        let mut all: Vec<f64> = found.stretches.iter().map(rms).collect();
        all.sort_by(f64::total_cmp);
        return Err(Diagnosis::NotThisArm {
            odd,
            windows,
            rms_counts: all.get(windows / 2).copied().unwrap_or(f64::NAN),
            noise_counts: noise_counts(traces),
        });
    }
    Ok(())
}

/// Standard deviation of the encoders' noise in counts, by how positions jump from tick to
/// tick: no arm accelerates so fast that it shows there.
fn noise_counts(traces: &[Trace]) -> f64 {
    let (mut squares, mut count) = (0.0, 0.0);
    for three in traces.iter().flat_map(|trace| trace.counts.windows(3)) {
        let [before, here, after] = [0, 1, 2].map(|tick| three[tick].map(|c| c.map(f64::from)));
        for ((a, b), c) in before.into_iter().zip(here).zip(after) {
            if let (Some(a), Some(b), Some(c)) = (a, b, c) {
                // Noise comes in with 1, -2 and 1.
                squares += (a - 2.0 * b + c).powi(2) / 6.0;
                count += 1.0;
            }
        }
    }
    // Rounding alone is a third of a count.
    f64::sqrt(squares / f64::max(count, 1.0)).max(0.5)
}

fn smoothed(traces: &[Trace], known: &Known, zero: [f64; JOINTS]) -> Vec<Trace> {
    let smooth = |trace: &Trace| trace.smoothed(known, zero);
    traces.iter().map(smooth).collect()
}

fn too_short(joint: usize, slid_s: f64) -> Diagnosis {
    Diagnosis::TooShort {
        joint: joint + 1,
        slid_s,
        needed_s: SLIDES_S,
    }
}

/// What it means that there is nowhere to begin.
fn of_start(error: &NoStart, known: &Known) -> Diagnosis {
    let NoStart {
        joint,
        stretches,
        gain,
    } = *error;
    if gain == 0.0 {
        // Stretches of 160 ticks, each 20 ticks after the one before.
        too_short(joint, 20.0 * stretches as f64 * known.period_s)
    } else {
        Diagnosis::NotDriven { joint: joint + 1 }
    }
}
