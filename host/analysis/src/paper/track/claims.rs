//! What the runs say about the paper's claims on tracking, and their figures.

use super::{DURATION_S, LOST_RAD, OMEGA, SWEEP, TRACKS_RAD, Track};
use crate::paper::JOINT_NAMES;
use crate::paper::chart::{Chart, Curve, DIFFERENCE, Figure, MENDED, MODEL, PLACED, PRINTED, Part};
use crate::paper::claim::{Claim, Number, Rule};
use crate::paper::printed::PERIOD_S;
use crate::paper::sim::Run;
use crate::paper::text::number;
use crate::paper::tracking::{SINE, goal};

impl Track {
    /// The claims about tracking.
    pub fn claims(&self) -> Vec<Claim> {
        vec![self.observer(), self.aggressive()]
    }

    fn observer(&self) -> Claim {
        let [difference, printed, ..] = self.delayed_rad;
        let error = |what: &str, found, rule| {
            Number::new(format!("Tracking error (RMS), {what}"), "rad", found, rule)
        };
        Claim {
            id: "tracking",
            title: "Figs. 9 and 10: tracking with the observer",
            paper: "With a nonlinear tracking control the observer behaves much better; with \
                    speeds computed by differences the system is unstable."
                .into(),
            find: format!(
                "Computed torque with both error poles at −{OMEGA} rad/s, one period of {} ms \
                 from sample to torque: by differences the arm is {} off (RMS, worse joint), with \
                 the printed observer {}.",
                PERIOD_S * 1e3,
                off(difference),
                off(printed),
            ),
            why: format!(
                "It takes stiff gains and the delay of the USB adapter, which the paper does not \
                 mention; without delay differences are {} off. The slow observer is a low pass \
                 that hides the delay from the law. It is not a better estimate: without delay \
                 the printed observer is {} off. The paper prints neither law, gains nor \
                 trajectory; those used here are the simplest.",
                off(self.prompt_rad[0]),
                off(self.prompt_rad[1]),
            ),
            mend: format!(
                "To model the delay: the board predicts the state for the instant at which its \
                 torque will act. With its observer and the same delay the arm is {} off at \
                 45 ms, and {} off at the board's 1 ms.",
                off(self.mended_rad[0]),
                off(self.mended_rad[1]),
            ),
            // The paper mentions no delay, so as printed there is none.
            printed: vec![
                error(
                    "differences, no delay",
                    self.prompt_rad[0],
                    Rule::AtLeast(LOST_RAD),
                ),
                error(
                    "printed observer, no delay",
                    self.prompt_rad[1],
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
                    self.mended_rad[0],
                    Rule::AtMost(printed),
                ),
                error(
                    "the same at 1 ms",
                    self.mended_rad[1],
                    Rule::AtMost(self.mended_rad[0]),
                ),
            ],
            figures: vec![self.figure(0), self.figure(1)],
        }
    }

    fn aggressive(&self) -> Claim {
        let [euler, exact] = self.last_omega;
        let last = |what: &str, found, rule| {
            Number::new(
                format!("Stiffest gain that tracks, printed poles on {what}"),
                "rad/s",
                found,
                rule,
            )
        };
        Claim {
            id: "aggressive",
            title: "A more aggressive observer",
            paper: "One option could be to make the observer more aggressive, but this is not \
                    applicable on the nonlinear system."
                .into(),
            find: format!(
                "With the printed poles really placed on (7), the arm tracks up to \
                 {euler} rad/s and falls beyond, even without delay."
            ),
            why: format!(
                "Not for the arm's nonlinearity. Fast poles trust each sample and turn (7)'s \
                 error over a period into speed; the law answers with more torque than the servo \
                 has, and (11) is told what was asked for, not what was given. Told what was \
                 sent, the same observer is {} off at {} rad/s.",
                off(self.with_sent_torque.1),
                self.with_sent_torque.0,
            ),
            mend: format!(
                "The exact zero-order hold: the same poles placed on it track up to {exact} \
                 rad/s. And an observer that is told the torque that the sent PWM stands for, \
                 clamped and rounded, as the board does."
            ),
            printed: vec![last("(7)", euler, Rule::AtMost(OMEGA))],
            reading: vec![
                last("the exact model", exact, Rule::AtLeast(1.3 * euler)),
                Number::new(
                    format!(
                        "Tracking error (RMS), printed poles on (7), told what was sent, {} rad/s",
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
        let wanted = (0..=steps).map(|i| {
            let time_s = f64::from(i) * 0.02;
            (time_s, goal(time_s).q[joint])
        });
        let (name, of_paper, title) = [
            ("fig9", "Fig. 9", "Trajectory tracking, first joint"),
            ("fig10", "Fig. 10", "Trajectory tracking, second joint"),
        ][joint];
        let goal_curve = || Curve::new("desired", MODEL, wanted.clone().collect());
        let panel = |name, curve, run: &Run| {
            let mut part = Part::new("", "angle (rad)", vec![]);
            part.curves = vec![Curve::new(name, curve, run.angle(joint)), goal_curve()];
            part.height = 170.0;
            part.y = Some([-0.85, 0.85]);
            part
        };
        let (amplitude, hertz) = SINE[joint];
        Figure {
            name,
            of_paper: Some(of_paper),
            caption: format!(
                "{}, {amplitude} rad at {hertz} Hz, computed torque at {OMEGA} rad/s, {} ms, one \
                 period of delay; speeds by differences, by the printed observer, and by the \
                 board's observer with the delay predicted. The paper's curve, law and \
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
                    panel("delay predicted", MENDED, &self.runs[2]),
                ],
            },
        }
    }

    fn over_gain(&self) -> Figure {
        let names = [
            "differences",
            "printed L",
            "printed poles on (7)",
            "on exact model",
        ];
        let looks = [DIFFERENCE, PRINTED, PLACED, MODEL];
        let panel = |title: &str, sweep: &[Vec<(f64, f64)>; 4]| {
            let curves = (0..4).map(|i| Curve::in_mrad(names[i], looks[i], &sweep[i]));
            let mut part = Part::new(title, "RMS error (mrad)", curves.collect());
            part.log = true;
            part.y = Some([1.0, 1000.0]);
            part.height = 220.0;
            part
        };
        let mut delayed = panel("45 ms delay", &self.sweep);
        let mended = Curve::in_mrad("delay predicted", MENDED, &self.sweep_mended);
        delayed.curves.push(mended);
        Figure {
            name: "stiffness",
            of_paper: None,
            caption: "Tracking error of the worse joint over the law's gain, by estimator. A \
                      curve ends where the arm falls."
                .into(),
            chart: Chart {
                title: "Tracking error over gain",
                x_title: "error poles of the law (rad/s)",
                x: [SWEEP[0], SWEEP[SWEEP.len() - 1]],
                panels: vec![panel("no delay", &self.sweep_prompt), delayed],
            },
        }
    }
}

/// An error in words.
fn off(rad: f64) -> String {
    if rad.is_finite() {
        format!("{} mrad", number(rad * 1e3, 1))
    } else {
        "so far that it falls".to_owned()
    }
}
