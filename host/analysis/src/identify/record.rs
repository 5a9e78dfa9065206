//! Traces of a log: runs of ticks without a gap in which the motors are driven.
//!
//! While the motors are off, the torques on the arm are unknown: it may be held by hand.

use armbridge_control::encoder::Encoder;
use armbridge_link::message::{Record, Sample, Setup};

use super::dataset::Trace;

/// Counts from either end of an AX-12A's track in which its reading is invalid.
const END_COUNTS: u16 = 3;
/// Shortest trace in ticks.
const TRACE_MIN: usize = 200;

/// Traces of a log of a board with this set-up. A joint that its arm does not have is at its zero.
pub fn traces(records: &[Record], setup: &Setup) -> Vec<Trace> {
    let absent = |joint: usize| joint >= setup.arm.joints();
    let zero = setup.joints.map(|joint| joint.zero_count.round() as u16);
    let mut traces = Vec::new();
    let mut trace = Trace::default();
    let mut before: Option<u32> = None;
    for record in records {
        let is_contiguous = before.is_some_and(|tick| tick.wrapping_add(1) == record.tick);
        before = Some(record.tick);
        let is_driven = record.mode.drive().is_some();
        if !(is_contiguous && is_driven) {
            end_trace(&mut trace, &mut traces);
        }
        if is_driven {
            if trace.pwm.is_empty() {
                let since_us = record
                    .input
                    .start_us
                    .saturating_sub(records[0].input.start_us);
                trace.start_s = since_us as f64 * 1e-6;
            }
            trace.pwm.push(record.input.pwm_in_force);
            let samples = record.input.samples;
            trace.counts.push(core::array::from_fn(|joint| {
                if absent(joint) {
                    Some(zero[joint])
                } else {
                    counts(samples[joint])
                }
            }));
        }
    }
    end_trace(&mut trace, &mut traces);
    traces
}

fn counts(sample: Sample) -> Option<u16> {
    sample.counts().filter(|counts| !is_at_end(*counts))
}

/// Whether an encoder at this count is at an end of its track, where it measures no angle. More
/// counts than an AX-12A has are an X servo's, whose track has no ends; a board keeps a joint away
/// from the counts that both have.
pub(super) fn is_at_end(counts: u16) -> bool {
    let last = Encoder::Ax12a.counts_max();
    counts < END_COUNTS || (last - END_COUNTS + 1..=last).contains(&counts)
}

fn end_trace(trace: &mut Trace, traces: &mut Vec<Trace>) {
    let ended = std::mem::take(trace);
    if ended.pwm.len() >= TRACE_MIN {
        traces.push(ended);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ax12a_is_at_its_ends_near_them_and_an_x_servo_nowhere_it_is_driven() {
        let ends: Vec<u16> = (0..4096).filter(|counts| is_at_end(*counts)).collect();
        assert_eq!(ends, [0, 1, 2, 1021, 1022, 1023]);
        let x = Encoder::XSeries;
        let (middle, reach) = (x.middle_count(), x.counts_from_middle());
        assert!((middle - reach..=middle + reach).all(|counts| !is_at_end(counts)));
    }
}
