//! Text of the comparison: a table of the fits, and sentences about them.

use armbridge_log::text_table;

use super::comparison::{Estimate, PaperComparison};
use super::experiment_fits::FrictionModel;
use super::sampled_experiment::ExperimentKind;

/// Smallest difference in N m s/rad of two distinct values of b1: larger than the error of
/// any of the fits.
const DISTINCT: f64 = 0.01;

/// A value that a fit does not have.
const NONE: &str = "–";

impl PaperComparison {
    /// One row for each fit, below the paper's values; the first row is the header.
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
        for fit in &self.fits {
            let experiment = fit
                .experiment
                .map_or("both", ExperimentKind::name)
                .to_owned();
            rows.extend(fit.paper.map(|paper| printed_row(&experiment, paper)));
            let cell = |estimate: Option<Estimate>| estimate.map_or(NONE.to_owned(), estimate_text);
            rows.push(vec![
                experiment,
                fit.model.name().to_owned(),
                estimate_text(fit.b1),
                cell(fit.coulomb_nm),
                cell(fit.torque_nm),
                format!("{:.2}", fit.rms_mrad),
            ]);
        }
        rows
    }

    /// Conclusions from the rows, one sentence each.
    pub fn sentences(&self) -> Vec<String> {
        let mut sentences = Vec::new();
        sentences.extend(self.warning());
        let value = |kind, model| self.fit(kind, model).map(|fit| fit.b1.value);
        let fall = value(Some(ExperimentKind::FreeFall), FrictionModel::ViscousOnly);
        let push = value(
            Some(ExperimentKind::ConstantInput),
            FrictionModel::ViscousOnly,
        );
        let both = self.fit(None, FrictionModel::WithDryFriction);
        if let (Some(fall), Some(push), Some(both)) = (fall, push, both) {
            let b1 = both.b1.value;
            let is_distinct = (fall - push).abs() > DISTINCT;
            sentences.push(match (self.dry_friction(), is_distinct) {
                (Some(coulomb_nm), true) => format!(
                    "The two values of b1, {fall:.3} and {push:.3}, belong to one arm with \
                     b1 = {b1:.3} N m s/rad and {coulomb_nm:.3} N m of dry friction."
                ),
                (None, true) => format!(
                    "Dry friction does not explain the two values of b1, {fall:.3} and {push:.3}: \
                     was the arm at rest when it was released?"
                ),
                (Some(_) | None, false) => format!(
                    "Both experiments agree without dry friction: b1 = {fall:.3} and {push:.3}."
                ),
            });
        }
        sentences.extend(self.torque());
        if let Some(message) = &self.unidentifiable {
            sentences.push(format!("From the constant input alone, {message}."));
        }
        sentences
    }

    /// Tables and sentences, ending in a line feed.
    pub fn text(&self) -> String {
        let mut text = self.tables();
        for sentence in self.sentences() {
            text.push('\n');
            text.push_str(&text_table::fold(&sentence, ""));
        }
        text
    }

    /// The rows as two tables: all columns beside each other are wider than a terminal.
    fn tables(&self) -> String {
        let rows = self.rows();
        let take =
            |row: &Vec<String>, columns: [usize; 4]| columns.map(|c| row[c].clone()).to_vec();
        let friction = rows.iter().map(|row| take(row, [0, 1, 2, 5]));
        let is_empty = |row: &&Vec<String>| row[3] == NONE && row[4] == NONE;
        let torque = rows.iter().filter(|row| !is_empty(row));
        let torque = torque.map(|row| take(row, [0, 1, 3, 4]));
        [friction.collect::<Vec<_>>(), torque.collect()]
            .map(|rows| text_table::columns(&rows))
            .join("\n")
    }

    /// Warning that viscous friction alone is of the wrong form, if it is.
    pub fn warning(&self) -> Option<String> {
        let form = self.form.filter(|form| form.is_wrong)?;
        Some(format!(
            "Warning: viscous friction alone is of the wrong form for the free fall. Its residuals \
             wander {} standard deviations more than noise, and dry friction reduces their sum of \
             squares {} times as much as a superfluous parameter would: the b1 of this fit and its \
             confidence interval are not valid.",
            rounded(form.wander_sigma),
            rounded(form.f_ratio),
        ))
    }

    /// Dry friction in N m, if it exceeds its confidence interval.
    fn dry_friction(&self) -> Option<f64> {
        let fits = [None, Some(ExperimentKind::FreeFall)].into_iter();
        let mut fits = fits.filter_map(|kind| self.fit(kind, FrictionModel::WithDryFriction));
        let Estimate { value, half_width } = fits.next()?.coulomb_nm?;
        (value > half_width).then_some(value)
    }

    /// Sentence on the torque by the constant input, if there is dry friction and the
    /// commanded torque is known.
    fn torque(&self) -> Option<String> {
        self.dry_friction()?;
        let push = self.fit(
            Some(ExperimentKind::ConstantInput),
            FrictionModel::ViscousOnly,
        )?;
        let (commanded_nm, fitted_nm) = (self.commanded_nm?, push.torque_nm?.value);
        Some(format!(
            "The commanded torque is {commanded_nm:+.4} N m, and the fit of the constant input \
             gives {fitted_nm:+.4} N m: the difference of {:.4} N m is dry friction in one \
             direction.",
            (commanded_nm - fitted_nm).abs(),
        ))
    }
}

/// An estimate with two significant digits of its half-width.
fn estimate_text(Estimate { value, half_width }: Estimate) -> String {
    if !(half_width.is_finite() && half_width > 0.0) {
        return format!("{value:.4}");
    }
    let places = (1.0 - half_width.log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.places$} ± {half_width:.places$}")
}

/// Row of the printed b1 and torque of an experiment.
fn printed_row(experiment: &str, paper: [Option<f64>; 2]) -> Vec<String> {
    let [b1, torque_nm] = paper.map(|value| value.map_or(NONE.to_owned(), |x| x.to_string()));
    let none = NONE.to_owned();
    vec![
        experiment.to_owned(),
        "the paper".to_owned(),
        b1,
        none.clone(),
        torque_nm,
        none,
    ]
}

/// A value rounded to two significant digits, or to an integer if less than 10.
fn rounded(value: f64) -> String {
    let scale = 10_f64.powi((value.log10().floor() as i32 - 1).max(0));
    format!("{:.0}", (value / scale).round() * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_are_known() {
        let text = |value, half_width| estimate_text(Estimate { value, half_width });
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
            let [fall, push, dry, both] = comparison.fits.as_slice() else {
                panic!("{} fits", comparison.fits.len());
            };
            assert!((fall.b1.value - 0.421).abs() < 1e-3, "{fall:?}");
            assert!((push.b1.value - 0.239).abs() < 2e-3, "{push:?}");
            let torque_nm = push.torque_nm.unwrap().value;
            assert!((torque_nm + 0.3924).abs() < 1.5e-3, "{push:?}");
            for fit in [dry, both] {
                assert!((fit.b1.value - 0.239).abs() < 1e-3, "{fit:?}");
                let coulomb_nm = fit.coulomb_nm.unwrap();
                assert!((coulomb_nm.value - 0.107_285).abs() < 5e-4, "{fit:?}");
                assert!(fit.rms_mrad < 3.0, "{fit:?}");
            }
            let torque_nm = both.torque_nm.unwrap().value;
            assert!((torque_nm + 0.3924 + 0.107_285).abs() < 1e-3, "{both:?}");
            let text = comparison.text();
            for words in [
                "Warning: viscous friction alone is of the wrong form",
                "The two values of b1, 0.42",
                "belong to one arm with b1 = 0.239 N m s/rad and 0.107 N m of dry friction.",
                "torque and dry friction are not separately identifiable",
            ] {
                assert!(
                    text.replace('\n', " ").contains(words),
                    "no {words:?} in\n{text}"
                );
            }
        }
    }
}
