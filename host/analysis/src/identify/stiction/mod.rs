//! Static friction: what a joint at rest withstood, and what it gave way to.
//!
//! With all else found, what pushes a joint at rest is known: its motor and gravity. Where
//! the PWM goes up or down slowly, the joint rests until the push has passed static
//! friction, and then slides.
//!
//! ```text
//! trace -> rests that end in sliding -> each: how likely is which torque -> all together
//!          rest.rs                      event.rs                           belief.rs
//! ```

mod event;
mod posterior;
mod rest;

use armbridge_shared::JOINTS;
use nalgebra::{SMatrix, SVector};

use super::arm::Known;
use super::dataset::Trace;
use super::quantity::COUNT;
use event::Event;
use posterior::Belief;

/// Fewest times a joint must give way to tell its static friction.
const FEWEST: usize = 2;

/// Static friction of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Static {
    /// In N m.
    pub torque_nm: f64,
    /// Its standard error.
    pub error_nm: f64,
    /// How often the joint gave way.
    pub events: usize,
}

/// What is known when static friction is sought.
pub(super) struct Stiction<'a> {
    /// Smoothed.
    pub(super) traces: &'a [Trace],
    pub(super) known: &'a Known,
    /// Coordinates of all other numbers, and their covariance.
    pub(super) at: &'a [f64; COUNT],
    pub(super) covariance: &'a SMatrix<f64, COUNT, COUNT>,
    /// Standard deviation of the encoders' noise.
    pub(super) noise_counts: f64,
}

impl Stiction<'_> {
    /// Static friction of each joint; `None` of one that did not give way often enough.
    pub(super) fn found(&self) -> [Option<Static>; JOINTS] {
        core::array::from_fn(|joint| {
            let traces = self.traces.iter();
            let events = traces.flat_map(|trace| {
                let rests = rest::rests(trace, self.known, joint).into_iter();
                rests.filter_map(move |rest| self.event(trace, joint, rest))
            });
            let events: Vec<Event> = events.collect();
            (events.len() >= FEWEST).then(|| self.together(&events))
        })
    }

    /// What all events say together. They share the numbers that the pushes are worked
    /// out with, whose errors do not average out.
    fn together(&self, events: &[Event]) -> Static {
        let beliefs: Vec<Belief> = events.iter().map(|event| event.belief.clone()).collect();
        let [torque_nm, variance] = Belief::all(&beliefs);
        let (mut slope, mut total) = (SVector::<f64, COUNT>::zeros(), 0.0);
        for event in events {
            let [_, variance] = event.belief.moments();
            slope += event.slope / variance;
            total += 1.0 / variance;
        }
        slope /= total;
        let by_numbers = (slope.transpose() * self.covariance * slope)[0];
        Static {
            torque_nm,
            error_nm: (variance + by_numbers.max(0.0)).sqrt(),
            events: events.len(),
        }
    }
}
