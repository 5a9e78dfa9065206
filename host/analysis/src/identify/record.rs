//! Traces of a log: runs of ticks without a gap in which the motors are driven.
//!
//! While the motors are off, the torques on the arm are unknown: it may be held by hand.

use armbridge_link::message::{Record, Sample};

use super::dataset::Trace;

/// Counts from either end of an encoder's track in which its reading is invalid.
pub(super) const END_COUNTS: u16 = 3;
/// Shortest trace in ticks.
const TRACE_MIN: usize = 200;

/// Traces of a log.
pub fn traces(records: &[Record]) -> Vec<Trace> {
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
            trace.counts.push(record.input.samples.map(counts));
        }
    }
    end_trace(&mut trace, &mut traces);
    traces
}

fn counts(sample: Sample) -> Option<u16> {
    let range = END_COUNTS..=1023 - END_COUNTS;
    sample.counts().filter(|counts| range.contains(counts))
}

fn end_trace(trace: &mut Trace, traces: &mut Vec<Trace>) {
    let ended = std::mem::take(trace);
    if ended.pwm.len() >= TRACE_MIN {
        traces.push(ended);
    }
}
