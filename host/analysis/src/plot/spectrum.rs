//! `spectrum`: power spectral density of error, torque and innovation.
//!
//! The innovation is the sample minus the estimate of the previous tick, extrapolated at
//! its speed; a missing sample has none. Only ticks in which the arm is driven count, and for
//! the error those with a reference.

use armbridge_link::message::{Record, Sample};
use armbridge_log::record_values::error_rad;
use armbridge_log::run_info::RunFacts;
use armbridge_servo::JOINTS;

use super::axis::{Axis, Scale};
use super::drawing::{Anchor, Drawing, Font, Rect, Stroke};
use super::figure;
use super::marks::NOTE;
use super::panel::{JOINT, Key, MUTED, Panel};
use super::run::Run;
use super::welch::{Spectrum, Welch};

/// Number of decades shown below the largest power.
const DECADES: f64 = 8.0;

/// A signal of each joint, computed from a tick and the previous one.
pub(super) struct Signal {
    title: &'static str,
    axis_title: &'static str,
    of: fn(&RunFacts, &Record, &Record, usize) -> f64,
}

pub(super) const SIGNALS: [Signal; 3] = [
    Signal {
        title: "Angle error: estimate minus reference",
        axis_title: "mrad²/Hz",
        of: |_, _, r, j| 1e3 * error_rad(r, j),
    },
    Signal {
        title: "Torque decided",
        axis_title: "(mN m)²/Hz",
        of: |_, _, r, j| 1e3 * f64::from(r.output.torque_nm[j]),
    },
    Signal {
        title: "Innovation: sample minus the estimate before, carried on",
        axis_title: "mrad²/Hz",
        of: |facts, before, r, j| {
            let period_s = f64::from(facts.period_us) * 1e-6;
            let carried = f64::from(before.output.angle_rad[j])
                + period_s * f64::from(before.output.speed_rad_s[j]);
            match r.input.samples[j] {
                Sample::Counts(count) => 1e3 * (facts.angle_rad(j, count) - carried),
                // The estimator continues with its prediction.
                Sample::Missing(_) => 0.0,
            }
        },
    },
];

/// Spectra of the [`SIGNALS`] of each joint, tick by tick.
#[derive(Debug)]
pub(super) struct Welches(Vec<[Welch; JOINTS]>);

impl Default for Welches {
    fn default() -> Self {
        Self(SIGNALS.iter().map(|_| Default::default()).collect())
    }
}

impl Welches {
    /// Adds a tick; `before` is the previous one, unless ticks are missing between them.
    pub(super) fn add(&mut self, before: Option<&Record>, record: &Record, facts: &RunFacts) {
        let is_driven = |record: &&Record| record.mode.drive().is_some();
        let before = before.filter(is_driven).filter(|_| is_driven(&record));
        for (signal, welches) in SIGNALS.iter().zip(&mut self.0) {
            for (joint, welch) in welches.iter_mut().enumerate() {
                let value = before.map(|before| (signal.of)(facts, before, record, joint));
                match value.filter(|value| value.is_finite()) {
                    Some(value) => welch.add(value),
                    None => welch.gap(),
                }
            }
        }
    }

    /// Spectra of ticks at `rate_hz`.
    pub(super) fn finish(&self, rate_hz: f64) -> Vec<[Option<Spectrum>; JOINTS]> {
        let of_joint = |welch: &Welch| welch.spectrum(rate_hz);
        self.0
            .iter()
            .map(|joints| joints.each_ref().map(of_joint))
            .collect()
    }
}

pub(super) fn draw(run: &Run) -> Drawing {
    let mut drawing = figure(860.0, "Power spectral density", &run.facts);
    let rate_hz = 1.0 / run.period_s();
    for (row, (signal, spectra)) in SIGNALS.iter().zip(&run.spectra).enumerate() {
        let frame = Rect::row(78.0 + 252.0 * row as f64, 206.0);
        let last = row + 1 == SIGNALS.len();
        let curves: Vec<_> = JOINT
            .into_iter()
            .zip(spectra)
            .map(|(colour, spectrum)| (Stroke::solid(colour, 1.3), spectrum.as_ref()))
            .collect();
        let panel = draw_panel(
            &mut drawing,
            frame,
            signal.title,
            signal,
            &curves,
            last,
            rate_hz,
        );
        let names = ["joint 1", "joint 2"];
        let keys = curves.iter().map(|(stroke, _)| Key::Line(*stroke));
        panel.legend(&mut drawing, &keys.zip(names).collect::<Vec<_>>());
        note(&mut drawing, &panel, spectra);
    }
    drawing
}

/// Draws spectra of a signal in a panel.
pub(super) fn draw_panel(
    drawing: &mut Drawing,
    frame: Rect,
    title: &str,
    signal: &Signal,
    curves: &[(Stroke, Option<&Spectrum>)],
    last: bool,
    rate_hz: f64,
) -> Panel {
    let spectra = || curves.iter().filter_map(|(_, spectrum)| *spectrum);
    let powers = || {
        let densities = spectra().flat_map(|spectrum| spectrum.density.iter().map(|(_, d)| *d));
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
    let first_hz = spectra().map(|s| s.density[0].0);
    let panel = Panel {
        frame,
        x: Axis {
            scale: Scale::Log,
            low: first_hz.reduce(f64::min).unwrap_or(rate_hz / 100.0),
            high: rate_hz / 2.0,
        },
        y: Axis {
            scale: Scale::Log,
            low: low.min(high / 10.0),
            high,
        },
    };
    let x_title = last.then_some("frequency (Hz)");
    panel.draw(drawing, title, x_title, Some(signal.axis_title));
    for (stroke, spectrum) in curves {
        let points = spectrum.iter().flat_map(|spectrum| &spectrum.density);
        panel.curve(drawing, points.copied(), *stroke);
    }
    panel
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
            "too few ticks for a spectrum",
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
