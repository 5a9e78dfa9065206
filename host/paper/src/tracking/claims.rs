//! The paper's claims on tracking, with the numbers and figures that test them.

use super::{DURATION_S, LOST_RAD, OMEGA, SWEEP, TRACKS_RAD, Tracking};
use crate::JOINT_NAMES;
use crate::chart::{CORRECTED, Chart, Curve, DIFFERENCE, Figure, MODEL, PLACED, PRINTED, Subplot};
use crate::claim::{Claim, Number, Rule};
use crate::computed_torque::{SINE, reference};
use crate::printed::PERIOD_S;
use crate::sampled_loop::Run;
use crate::text::number;

impl Tracking {
    /// The claims about tracking.
    pub fn claims(&self) -> Vec<Claim> {
        vec![self.observer_claim(), self.fast_observer_claim()]
    }

    fn observer_claim(&self) -> Claim {
        let [difference, printed, ..] = self.delayed_rad;
        let error = |condition: &str, found, rule| {
            let quantity = format!("Tracking error (RMS), {condition}");
            Number::new(quantity, "rad", found, rule)
        };
        Claim {
            id: "tracking",
            title: "Figs. 9 and 10: tracking with the observer",
            paper: "With a nonlinear tracking controller the observer behaves much better; with \
                    speeds computed by differences the system is unstable."
                .into(),
            finding: format!(
                "Computed torque with both error poles at −{OMEGA} rad/s and one period of {} ms \
                 from sample to torque: the tracking error (RMS, worse joint) is {} with speeds by \
                 differences and {} with the printed observer.",
                PERIOD_S * 1e3,
                error_text(difference),
                error_text(printed),
            ),
            explanation: format!(
                "The claim holds only with stiff gains and the delay of the USB adapter, which the \
                 paper does not mention; without delay the error with differences is {}. The slow \
                 observer acts as a low-pass filter, which makes the law insensitive to the delay. \
                 Its estimate is no better: without delay the error with the printed observer is \
                 {}. The paper prints neither the law, nor its gains, nor the trajectory; those \
                 used here are the simplest.",
                error_text(self.undelayed_rad[0]),
                error_text(self.undelayed_rad[1]),
            ),
            remedy: format!(
                "Model the delay: the board predicts the state for the instant at which its torque \
                 will act. With its observer and one period of delay the error is {} at 45 ms, and \
                 {} at the board's 1 ms.",
                error_text(self.corrected_rad[0]),
                error_text(self.corrected_rad[1]),
            ),
            // The paper mentions no delay, so the printed reading has none.
            printed: vec![
                error(
                    "differences, no delay",
                    self.undelayed_rad[0],
                    Rule::AtLeast(LOST_RAD),
                ),
                error(
                    "printed observer, no delay",
                    self.undelayed_rad[1],
                    Rule::AtMost(TRACKS_RAD),
                ),
            ],
            reading: vec![
                error(
                    "differences, 45 ms delay",
                    difference,
                    Rule::AtLeast(LOST_RAD),
                ),
                error(
                    "printed observer, 45 ms delay",
                    printed,
                    Rule::AtMost(TRACKS_RAD),
                ),
                error(
                    "the board's observer, delay predicted",
                    self.corrected_rad[0],
                    Rule::AtMost(printed),
                ),
                error(
                    "the same at 1 ms",
                    self.corrected_rad[1],
                    Rule::AtMost(self.corrected_rad[0]),
                ),
            ],
            figures: vec![self.figure(0), self.figure(1)],
        }
    }

    fn fast_observer_claim(&self) -> Claim {
        let [euler, exact] = self.last_omega;
        let last = |model: &str, found, rule| {
            Number::new(
                format!("Largest gain that tracks, printed poles on {model}"),
                "rad/s",
                found,
                rule,
            )
        };
        Claim {
            id: "aggressive",
            title: "A more aggressive observer",
            paper: "One option could be to make the observer more aggressive, but this is not \
                    applicable to the nonlinear system."
                .into(),
            finding: format!(
                "With the printed poles actually placed on (7), the arm tracks up to {euler} rad/s \
                 and falls at larger gains, even without delay."
            ),
            explanation: format!(
                "The cause is not the arm's nonlinearity. Fast poles follow each sample and turn \
                 the error of (7) over a period into speed; the law responds with more torque than \
                 the servo can give, but the input of (11) is the torque requested, not the torque \
                 given. With the torque sent as its input, the same observer has an error of {} at \
                 {} rad/s.",
                error_text(self.with_sent_torque.1),
                self.with_sent_torque.0,
            ),
            remedy: format!(
                "Use the exact zero-order hold: the same poles placed on it track up to {exact} \
                 rad/s. Use the torque of the PWM sent, clamped and rounded, as the observer's \
                 input, as the board does."
            ),
            printed: vec![last("(7)", euler, Rule::AtMost(OMEGA))],
            reading: vec![
                last("the exact model", exact, Rule::AtLeast(1.3 * euler)),
                Number::new(
                    format!(
                        "Tracking error (RMS), printed poles on (7), input is torque sent, {} rad/s",
                        self.with_sent_torque.0
                    ),
                    "rad",
                    self.with_sent_torque.1,
                    Rule::AtMost(TRACKS_RAD),
                ),
            ],
            figures: vec![self.over_gain()],
        }
    }

    fn figure(&self, joint: usize) -> Figure {
        let steps = (DURATION_S / 0.02) as u32;
        let desired = (0..=steps).map(|i| {
            let time_s = f64::from(i) * 0.02;
            (time_s, reference(time_s).q[joint])
        });
        let (name, paper_figure, title) = [
            ("fig9", "Fig. 9", "Trajectory tracking, first joint"),
            ("fig10", "Fig. 10", "Trajectory tracking, second joint"),
        ][joint];
        let reference_curve = || Curve::new("desired", MODEL, desired.clone().collect());
        let panel = |name, curve, run: &Run| {
            let mut subplot = Subplot::new("", "angle (rad)", vec![]);
            subplot.curves = vec![Curve::new(name, curve, run.angle(joint)), reference_curve()];
            subplot.height = 170.0;
            subplot.y = Some([-0.85, 0.85]);
            subplot
        };
        let (amplitude, hertz) = SINE[joint];
        Figure {
            name,
            paper_figure: Some(paper_figure),
            caption: format!(
                "{}, {amplitude} rad at {hertz} Hz, computed torque at {OMEGA} rad/s, {} ms, one \
                 period of delay; with speeds by differences, with the printed observer, and with \
                 the board's observer and the delay predicted. The paper's curve, law and \
                 trajectory are not available.",
                JOINT_NAMES[joint],
                PERIOD_S * 1e3,
            ),
            chart: Chart {
                title,
                x_title: "time (s)",
                x: [0.0, DURATION_S],
                panels: vec![
                    panel("differences", DIFFERENCE, &self.runs[0]),
                    panel("printed observer", PRINTED, &self.runs[1]),
                    panel("delay predicted", CORRECTED, &self.runs[2]),
                ],
            },
        }
    }

    fn over_gain(&self) -> Figure {
        let names = [
            "differences",
            "printed L",
            "printed poles on (7)",
            "poles on exact model",
        ];
        let strokes = [DIFFERENCE, PRINTED, PLACED, MODEL];
        let panel = |title: &str, sweep: &[Vec<(f64, f64)>; 4]| {
            let curves = (0..4).map(|i| Curve::in_mrad(names[i], strokes[i], &sweep[i]));
            let mut subplot = Subplot::new(title, "RMS error (mrad)", curves.collect());
            subplot.log = true;
            subplot.y = Some([1.0, 1000.0]);
            subplot.height = 220.0;
            subplot
        };
        let mut delayed = panel("45 ms of delay", &self.sweep);
        let corrected = Curve::in_mrad("delay predicted", CORRECTED, &self.sweep_corrected);
        delayed.curves.push(corrected);
        Figure {
            name: "stiffness",
            paper_figure: None,
            caption:
                "Tracking error of the worse joint over the law's gain, for each estimator. A \
                      curve ends where the arm falls."
                    .into(),
            chart: Chart {
                title: "Tracking error over gain",
                x_title: "error poles of the law (rad/s)",
                x: [SWEEP[0], SWEEP[SWEEP.len() - 1]],
                panels: vec![panel("no delay", &self.sweep_undelayed), delayed],
            },
        }
    }
}

/// An error with its unit, or that the arm falls.
fn error_text(rad: f64) -> String {
    if rad.is_finite() {
        format!("{} mrad", number(rad * 1e3, 1))
    } else {
        "unbounded (the arm falls)".to_owned()
    }
}
