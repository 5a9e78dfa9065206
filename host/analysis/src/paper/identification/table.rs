//! What came of the paper's procedure, in words.

use armbridge_log::text_table;

use super::comparison::{PaperComparison, Within};
use super::experiment_fits::Model;
use super::sampled::Kind;

/// Friction in N m s/rad by which two values are two: more than any of the fits is off.
const APART: f64 = 0.01;

impl PaperComparison {
    /// The fits, a row each, below what the paper has for it; the first row is the heads.
    pub fn rows(&self) -> Vec<Vec<String>> {
        let heads = [
            "experiment",
            "model",
            "b1 (N m s/rad)",
            "dry friction (N m)",
            "torque (N m)",
            "rms (mrad)",
        ];
        let mut rows = vec![heads.map(str::to_owned).to_vec()];
        for line in &self.lines {
            let experiment = line.experiment.map_or("both", Kind::name).to_owned();
            rows.extend(line.paper.map(|paper| printed(&experiment, paper)));
            let number = |number: Option<Within>| number.map_or("–".to_owned(), in_words);
            rows.push(vec![
                experiment,
                line.model.name().to_owned(),
                in_words(line.b1),
                number(line.coulomb_nm),
                number(line.torque_nm),
                format!("{:.2}", line.rms_mrad),
            ]);
        }
        rows
    }

    /// What the rows say, a sentence each.
    pub fn sentences(&self) -> Vec<String> {
        let mut sentences = Vec::new();
        sentences.extend(self.warning());
        let value = |kind, model| self.line(kind, model).map(|line| line.b1.value);
        let fall = value(Some(Kind::FreeFall), Model::ViscousOnly);
        let push = value(Some(Kind::ConstantInput), Model::ViscousOnly);
        let both = self.line(None, Model::WithDryFriction);
        if let (Some(fall), Some(push), Some(both)) = (fall, push, both) {
            let b1 = both.b1.value;
            let two = format!("Two values of b1, {fall:.3} and {push:.3}");
            sentences.push(match (self.dry_friction(), (fall - push).abs() > APART) {
                (Some(coulomb_nm), true) => format!(
                    "{two}, are one arm: b1 = {b1:.3} N m s/rad and {coulomb_nm:.3} N m of dry \
                     friction."
                ),
                (None, true) => format!(
                    "{two}, and dry friction does not explain them: was the arm at rest when it \
                     was let go?"
                ),
                (Some(_) | None, false) => format!(
                    "Both experiments agree without dry friction: b1 = {fall:.3} and {push:.3}."
                ),
            });
        }
        sentences.extend(self.torque());
        if let Some(blind) = &self.blind_spot {
            sentences.push(format!("Of the constant input alone, {blind}."));
        }
        sentences
    }

    /// All of it, ending in a line feed.
    pub fn text(&self) -> String {
        let mut text = text_table::columns(&self.rows());
        for sentence in self.sentences() {
            text.push('\n');
            text.push_str(&wrapped(&sentence));
        }
        text
    }

    /// That viscous friction alone is of the wrong form, if it is.
    pub fn warning(&self) -> Option<String> {
        let form = self.form.filter(|form| form.is_wrong)?;
        Some(format!(
            "Warning: viscous friction alone is of the wrong form for the free fall. Its residuals \
             wander {} standard deviations more than noise, and dry friction takes {} times as \
             much off them as a number that is not there would: its b1 and what is said to be \
             within mean nothing.",
            rounded(form.wander_sigma),
            rounded(form.f_ratio),
        ))
    }

    /// Dry friction in N m, if there is any beyond what may be none.
    fn dry_friction(&self) -> Option<f64> {
        let fits = [None, Some(Kind::FreeFall)].into_iter();
        let mut lines = fits.filter_map(|kind| self.line(kind, Model::WithDryFriction));
        let Within { value, within } = lines.next()?.coulomb_nm?;
        (value > within).then_some(value)
    }

    /// Dry friction by the constant input, if there is some and the motor's torque is known.
    fn torque(&self) -> Option<String> {
        self.dry_friction()?;
        let push = self.line(Some(Kind::ConstantInput), Model::ViscousOnly)?;
        let (told, found) = (self.told_nm?, push.torque_nm?.value);
        Some(format!(
            "The motor is told {told:+.4} N m and the constant input finds {found:+.4}: dry friction \
             of one direction is taken for {:.4} N m of torque.",
            (told - found).abs(),
        ))
    }
}

/// With the digits that are known, and one more.
fn in_words(Within { value, within }: Within) -> String {
    if !(within.is_finite() && within > 0.0) {
        return format!("{value:.4}");
    }
    let places = (1.0 - within.log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.places$} ± {within:.places$}")
}

/// What the paper has for an experiment: b1 and torque.
fn printed(experiment: &str, paper: [Option<f64>; 2]) -> Vec<String> {
    let [b1, torque_nm] = paper.map(|number| number.map_or("–".to_owned(), |x| x.to_string()));
    let none = "–".to_owned();
    let model = "the paper".to_owned();
    vec![
        experiment.to_owned(),
        model,
        b1,
        none.clone(),
        torque_nm,
        none,
    ]
}

/// Two digits of a large number.
fn rounded(value: f64) -> String {
    let scale = 10_f64.powi((value.log10().floor() as i32 - 1).max(0));
    format!("{:.0}", (value / scale).round() * scale)
}

/// In lines of 88 columns.
fn wrapped(text: &str) -> String {
    const WIDTH: usize = 88;
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last_mut().filter(|line| {
            line.is_empty() || line.chars().count() + 1 + word.chars().count() <= WIDTH
        });
        match last {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) => {
                line.push(' ');
                line.push_str(word);
            }
            None => lines.push(word.to_owned()),
        }
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_are_known() {
        let text = |value, within| in_words(Within { value, within });
        assert_eq!(text(0.239_04, 0.000_42), "0.23904 ± 0.00042");
        assert_eq!(text(0.421, 0.013), "0.421 ± 0.013");
        assert_eq!(text(0.3, f64::INFINITY), "0.3000");
        assert_eq!(rounded(12_345.0), "12000");
        assert_eq!(rounded(7.0), "7");
    }

    #[test]
    fn the_papers_two_values_are_one_arm() {
        for seed in 1..=5 {
            let comparison = PaperComparison::simulated(seed).unwrap();
            let [fall, push, dry, both] = comparison.lines.as_slice() else {
                panic!("{} lines", comparison.lines.len());
            };
            assert!((fall.b1.value - 0.421).abs() < 1e-3, "{fall:?}");
            assert!((push.b1.value - 0.239).abs() < 2e-3, "{push:?}");
            let torque_nm = push.torque_nm.unwrap().value;
            assert!((torque_nm + 0.3924).abs() < 1.5e-3, "{push:?}");
            for line in [dry, both] {
                assert!((line.b1.value - 0.239).abs() < 1e-3, "{line:?}");
                let coulomb_nm = line.coulomb_nm.unwrap();
                assert!((coulomb_nm.value - 0.107_285).abs() < 5e-4, "{line:?}");
                assert!(line.rms_mrad < 3.0, "{line:?}");
            }
            let torque_nm = both.torque_nm.unwrap().value;
            assert!((torque_nm + 0.3924 + 0.107_285).abs() < 1e-3, "{both:?}");
            let text = comparison.text();
            for words in [
                "Warning: viscous friction alone is of the wrong form",
                "Two values of b1, 0.42",
                "are one arm: b1 = 0.239 N m s/rad and 0.107 N m of dry friction.",
                "torque and dry friction cannot be told apart",
            ] {
                assert!(
                    text.replace('\n', " ").contains(words),
                    "no {words:?} in\n{text}"
                );
            }
        }
    }
}
