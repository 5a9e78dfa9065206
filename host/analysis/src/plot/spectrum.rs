//! `spectrum`: power spectral density of error, torque and innovation.
//!
//! The innovation is the sample minus the estimate of the previous tick, extrapolated at
//! its speed; a missing sample has none. Only ticks in which the arm is driven count.

use armbridge_shared::JOINTS;
use armbridge_shared::link::message::Record;

use super::axis::{Axis, Scale};
use super::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use super::figure;
use super::panel::{JOINT, Key, MUTED, Panel};
use super::run::{NOTE, Run};
use super::welch::{self, Spectrum};

/// Number of decades shown below the largest power.
const DECADES: f64 = 8.0;

/// A signal of each joint, computed from a tick and the previous one.
struct Signal {
    title: &'static str,
    axis_title: &'static str,
    of: fn(&Run, &Record, &Record, usize) -> f64,
}

const SIGNALS: [Signal; 3] = [
    Signal {
        title: "Angle error: estimate minus reference",
        axis_title: "mrad²/Hz",
        of: |_, _, r, j| 1e3 * (f64::from(r.angle_rad[j]) - f64::from(r.reference_rad[j])),
    },
    Signal {
        title: "Torque decided",
        axis_title: "(mN m)²/Hz",
        of: |_, _, r, j| 1e3 * f64::from(r.torque_nm[j]),
    },
    Signal {
        title: "Innovation: sample minus the estimate before, carried on",
        axis_title: "mrad²/Hz",
        of: |run, before, r, j| {
            let period_s = f64::from(run.facts.period_us) * 1e-6;
            let carried =
                f64::from(before.angle_rad[j]) + period_s * f64::from(before.speed_rad_s[j]);
            let innovation = 1e3 * (run.measured_rad(r, j) - carried);
            // The estimator continues with its prediction.
            if innovation.is_nan() { 0.0 } else { innovation }
        },
    },
];

pub(super) fn draw(run: &Run) -> Drawing {
    let mut drawing = figure(860.0, "Power spectral density", run.facts);
    let rate_hz = 1e6 / f64::from(run.facts.period_us);
    for (row, signal) in SIGNALS.iter().enumerate() {
        let frame = Rect::row(78.0 + 252.0 * row as f64, 206.0);
        let spectra: Vec<_> = (0..JOINTS)
            .map(|joint| welch::spectrum(&pieces(run, signal, joint), rate_hz))
            .collect();
        let last = row + 1 == SIGNALS.len();
        draw_signal(&mut drawing, frame, signal, &spectra, last, rate_hz);
    }
    drawing
}

/// Pieces of a signal from consecutive ticks in which the arm is driven.
fn pieces(run: &Run, signal: &Signal, joint: usize) -> Vec<Vec<f64>> {
    let mut pieces = vec![Vec::new()];
    for two in run.shown().windows(2) {
        let [before, record] = [&two[0], &two[1]];
        let is_driven = before.mode.drive().is_some() && record.mode.drive().is_some();
        let value = (signal.of)(run, before, record, joint);
        let follows = record.tick == before.tick.wrapping_add(1);
        match pieces.last_mut() {
            Some(piece) if is_driven && follows && value.is_finite() => piece.push(value),
            Some(piece) if piece.is_empty() => {}
            _ => pieces.push(Vec::new()),
        }
    }
    pieces
}

fn draw_signal(
    drawing: &mut Drawing,
    frame: Rect,
    signal: &Signal,
    spectra: &[Option<Spectrum>],
    last: bool,
    rate_hz: f64,
) {
    let powers = || {
        let spectra = spectra.iter().flatten();
        let densities = spectra.flat_map(|spectrum| spectrum.density.iter().map(|(_, d)| *d));
        densities.filter(|density| *density > 0.0)
    };
    let highest = powers().fold(f64::MIN_POSITIVE, f64::max);
    let lowest = powers().fold(highest, f64::min);
    let decade = |value: f64| 10_f64.powf(value);
    let high = if highest > f64::MIN_POSITIVE {
        decade(highest.log10().ceil())
    } else {
        1.0
    };
    let low = decade(lowest.max(high * decade(-DECADES)).log10().floor());
    let first_hz = spectra.iter().flatten().map(|s| s.density[0].0);
    let panel = Panel {
        frame,
        x: Axis {
            scale: Scale::Log,
            low: first_hz.fold(rate_hz / 100.0, f64::min),
            high: rate_hz / 2.0,
        },
        y: Axis {
            scale: Scale::Log,
            low: low.min(high / 10.0),
            high,
        },
    };
    let x_title = last.then_some("frequency (Hz)");
    panel.draw(drawing, signal.title, x_title, Some(signal.axis_title));
    let strokes = JOINT.map(|colour| Stroke::solid(colour, 1.3));
    for (spectrum, stroke) in spectra.iter().zip(strokes) {
        let points = spectrum.iter().flat_map(|spectrum| &spectrum.density);
        panel.curve(drawing, points.copied(), stroke);
    }
    let names = ["joint 1", "joint 2"];
    let legend: Vec<_> = strokes.map(Key::Line).into_iter().zip(names).collect();
    panel.legend(drawing, &legend);
    note(drawing, &panel, spectra);
}

/// Draws a note on the windows that the curves average.
fn note(drawing: &mut Drawing, panel: &Panel, spectra: &[Option<Spectrum>]) {
    let Some(spectrum) = spectra.iter().flatten().next() else {
        let font = Font {
            size: 13.0,
            bold: false,
            colour: MUTED,
            anchor: Anchor::Middle,
        };
        let Rect { x, y, w, h } = panel.frame;
        drawing.text(
            (x + w / 2.0, y + h / 2.0),
            "the arm was not driven for long enough",
            font,
            false,
        );
        return;
    };
    let Spectrum {
        segments,
        segment_s,
        ..
    } = spectrum;
    let words = format!("mean of {segments} Hann windows of {segment_s:.2} s");
    let (left, bottom) = (panel.frame.x + 9.0, panel.frame.bottom() - 9.0);
    drawing.text((left, bottom), &words, NOTE, false);
}
