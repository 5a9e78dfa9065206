//! Holdouts: recordings that are excluded from a fit, and its error on them.
//!
//! By gain, every other gain is held out, then the rest of them: a gain between those of the fit
//! or beyond them. By trajectory, each in turn. Every recording is held out once of each kind.

use serde::Serialize;

use super::fit::Fit;
use super::parameters::FrictionForm;
use super::recording::Recording;

/// Recordings excluded from a fit.
pub(super) struct Partition {
    /// What is held out.
    pub(super) held_out: String,
    /// What they have in common.
    pub(super) kind: &'static str,
    /// Which recordings are held out.
    pub(super) is_held_out: Vec<bool>,
}

/// Errors with some recordings held out.
#[derive(Clone, Debug, Serialize)]
pub struct Holdout {
    /// What the recordings held out have in common: `gain` or `trajectory`.
    pub kind: &'static str,
    /// Their gains or trajectory.
    pub held_out: String,
    /// Number of their samples.
    pub samples: usize,
    /// Errors of the forms of friction.
    pub errors: Vec<HoldoutError>,
}

/// Errors of a form of friction with some recordings held out.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct HoldoutError {
    /// The form.
    pub form: FrictionForm,
    /// Error on the recordings of the fit in degrees.
    pub fitted_deg: f64,
    /// Error on those held out in degrees.
    pub held_out_deg: f64,
}

impl Partition {
    /// Partitions by gain and by trajectory, as far as there are several of these.
    pub(super) fn of(recordings: &[Recording]) -> Vec<Self> {
        let mut gains: Vec<f64> = recordings.iter().map(|it| it.gain).collect();
        gains.sort_by(f64::total_cmp);
        gains.dedup();
        let mut trajectories: Vec<&str> = recordings.iter().map(Recording::trajectory).collect();
        trajectories.sort_unstable();
        trajectories.dedup();
        let by_gain = [0, 1].map(|first| {
            let gains: Vec<f64> = gains.iter().copied().skip(first).step_by(2).collect();
            let words: Vec<String> = gains.iter().map(f64::to_string).collect();
            Self {
                held_out: format!("kp {}", words.join(", ")),
                kind: "gain",
                is_held_out: recordings
                    .iter()
                    .map(|it| gains.contains(&it.gain))
                    .collect(),
            }
        });
        let by_trajectory = trajectories.iter().map(|&trajectory| Self {
            held_out: trajectory.to_owned(),
            kind: "trajectory",
            is_held_out: recordings
                .iter()
                .map(|it| it.trajectory() == trajectory)
                .collect(),
        });
        let is_split =
            |it: &Self| it.is_held_out.contains(&true) && it.is_held_out.contains(&false);
        let partitions = by_gain.into_iter().chain(by_trajectory);
        partitions.filter(is_split).collect()
    }

    /// Recordings of the fit, or those held out.
    pub(super) fn part<'a>(
        &self,
        recordings: &'a [Recording],
        is_held_out: bool,
    ) -> Vec<&'a Recording> {
        let pairs = recordings.iter().zip(&self.is_held_out);
        pairs
            .filter(|(_, is)| **is == is_held_out)
            .map(|(recording, _)| recording)
            .collect()
    }

    /// Errors of fits to the other recordings.
    pub(super) fn errors(&self, recordings: &[Recording], fits: &[Fit]) -> Holdout {
        let held_out = self.part(recordings, true);
        let errors = fits.iter().map(|fit| HoldoutError {
            form: fit.form,
            fitted_deg: fit.error_deg,
            held_out_deg: super::error_deg(&held_out, &fit.parameters),
        });
        Holdout {
            kind: self.kind,
            held_out: self.held_out.clone(),
            samples: held_out.iter().map(|it| it.samples.len()).sum(),
            errors: errors.collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(gain: f64, trajectory: &str) -> Recording {
        Recording {
            name: String::new(),
            trajectory: trajectory.to_owned(),
            gain,
            gravity_nm: 0.5,
            inertia_kg_m2: 0.005,
            initial_speed_rad_s: 0.0,
            samples: Vec::new(),
        }
    }

    #[test]
    fn every_recording_is_held_out_once_of_each_kind() {
        let recordings: Vec<Recording> = [100.0, 200.0, 400.0, 800.0]
            .into_iter()
            .flat_map(|gain| ["a", "b", "c"].map(|trajectory| recording(gain, trajectory)))
            .collect();
        let partitions = Partition::of(&recordings);
        let names: Vec<&str> = partitions.iter().map(|it| it.held_out.as_str()).collect();
        assert_eq!(names, ["kp 100, 400", "kp 200, 800", "a", "b", "c"]);
        for kind in ["gain", "trajectory"] {
            for i in 0..recordings.len() {
                let of_kind = partitions.iter().filter(|it| it.kind == kind);
                assert_eq!(of_kind.filter(|it| it.is_held_out[i]).count(), 1);
            }
        }
    }

    #[test]
    fn recordings_that_are_alike_cannot_be_parted() {
        let recordings = [recording(100.0, "a"), recording(100.0, "a")];
        assert!(Partition::of(&recordings).is_empty());
    }
}
