//! Fit of an arm to the records of one or several runs, with its report and checks.

use std::path::{Path, PathBuf};

use armbridge_client::params;
use armbridge_client::params::{InvalidSettings, Parameter, ParameterError};
use armbridge_link::message::{Record, Settings};
use armbridge_log::inspect::Log;
use armbridge_log::recording::ReadError;
use toml::Value;

use super::{
    Checks, Diagnosis, FitResult, KnownParameters, Prior, Report, Tally, Trace, UnphysicalArm,
    identified_settings, identify, traces,
};
use crate::design::{PlaceError, Redesign, retune};

/// Reason why there is no fit.
#[derive(Debug, thiserror::Error)]
pub enum ArmFitError {
    /// The records do not identify the arm.
    #[error(transparent)]
    Diagnosis(#[from] Diagnosis),
    /// A log cannot be read.
    #[error(transparent)]
    Log(#[from] ReadError),
    /// A log begins after the board has reported its settings.
    #[error("{0} has no settings of the board; record from the hello on")]
    NoSettings(PathBuf),
    /// Logs are of boards with different settings.
    #[error("{logs}: the boards of these logs have different {what}; fit them one by one")]
    OtherModel {
        /// Their paths.
        logs: String,
        /// The settings, in words.
        what: String,
    },
}

/// Reason why the settings of a board cannot have the identified arm.
#[derive(Debug, thiserror::Error)]
pub enum AdoptError {
    /// No arm has these parameters.
    #[error(transparent)]
    Unphysical(#[from] UnphysicalArm),
    /// A parameter rejects its value.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The settings contradict each other.
    #[error(transparent)]
    Settings(#[from] InvalidSettings),
    /// No gain has the poles that the present gain has.
    #[error(transparent)]
    Gain(#[from] PlaceError),
}

/// Records of one or several runs of the same board.
#[derive(Debug)]
pub struct FitData {
    settings: Settings,
    traces: Vec<Trace>,
    tally: Tally,
    /// Each log's path, name and link.
    logs: Vec<String>,
    /// Damage of the logs, a line each.
    pub damage: Vec<String>,
}

impl FitData {
    /// Data of one run, by a board with these settings.
    pub fn from_records(settings: &Settings, records: &[Record]) -> Self {
        let mut data = Self {
            settings: *settings,
            traces: Vec::new(),
            tally: Tally::default(),
            logs: Vec::new(),
            damage: Vec::new(),
        };
        data.add(records);
        data
    }

    fn add(&mut self, records: &[Record]) {
        let log = self.logs.len();
        self.tally.add(records, &self.settings);
        let traces = traces(records, &self.settings.setup).into_iter();
        self.traces
            .extend(traces.map(|trace| Trace { log, ..trace }));
    }

    /// Data of these logs, of which there is at least one.
    ///
    /// # Errors
    /// If a log cannot be read, has no records or settings, or is of another board than the first.
    pub fn load(paths: &[PathBuf]) -> Result<Self, ArmFitError> {
        let mut data: Option<(&Path, Self)> = None;
        for path in paths {
            let Log { head, records, .. } = Log::load(path)?;
            if records.is_empty() {
                return Err(Diagnosis::Empty.into());
            }
            let no_settings = || ArmFitError::NoSettings(path.clone());
            let settings = head.settings.ok_or_else(no_settings)?;
            let (first, data) =
                data.get_or_insert_with(|| (path, Self::from_records(&settings, &[])));
            if let Some(what) = difference(&data.settings, &settings) {
                let logs = format!("{} and {}", first.display(), path.display());
                return Err(ArmFitError::OtherModel { logs, what });
            }
            data.add(&records);
            let (name, facts) = (path.display(), &head.facts);
            let facts = format!("{name} · {} · {}", facts.name, facts.describe());
            data.logs.push(facts);
            let damage = head.damage.iter();
            data.damage
                .extend(damage.map(|damage| format!("{name}: {damage}")));
        }
        Ok(data.ok_or(Diagnosis::Empty)?.1)
    }
}

/// What differs between the models of two boards, or their periods.
fn difference(one: &Settings, other: &Settings) -> Option<String> {
    let (one, other) = (&one.setup, &other.setup);
    if one.period_us != other.period_us {
        let periods = format!("periods, {} and {} µs", one.period_us, other.period_us);
        Some(periods)
    } else if one.joints != other.joints {
        Some("calibrations or actuators of the joints".into())
    } else if one.arm != other.arm {
        Some("models of the arm".into())
    } else {
        None
    }
}

/// An arm fitted to records.
pub struct ArmFit {
    /// Settings of the board that recorded them.
    pub before: Settings,
    /// Parameters that were not fitted.
    pub known: KnownParameters,
    /// Prior of those that were.
    pub prior: Prior,
    /// The fit.
    pub result: FitResult,
    /// Its estimates.
    pub report: Report,
    /// Its checks.
    pub checks: Checks,
    /// Each log's path, name and link.
    pub logs: Vec<String>,
}

impl ArmFit {
    /// Fits the arm; the known weight has this relative standard error.
    ///
    /// # Errors
    /// If the records do not identify it.
    pub fn new(data: FitData, weighed: f64) -> Result<Self, Diagnosis> {
        let before = data.settings;
        let known = KnownParameters::from_setup(&before.setup);
        let prior = Prior::from_setup(&before.setup, weighed);
        let result = identify(&data.traces, &data.tally, &known, &prior)?;
        Ok(Self {
            report: Report::new(&result, &prior, &known),
            checks: Checks::new(&result, &data.traces, &known, &prior),
            before,
            known,
            prior,
            result,
            logs: data.logs,
        })
    }

    /// Traces of other logs, excluded from the fit.
    ///
    /// # Errors
    /// If they cannot be read, or are of a board with another model.
    pub fn held_out(&self, paths: &[PathBuf]) -> Result<Vec<Trace>, ArmFitError> {
        let data = FitData::load(paths)?;
        match difference(&self.before, &data.settings) {
            Some(what) => Err(ArmFitError::OtherModel {
                logs: "fitted and held out".into(),
                what,
            }),
            None => Ok(data.traces),
        }
    }

    /// All parameters of the arm: the identified ones, and the known ones, such as its lengths
    /// and mounting.
    ///
    /// # Errors
    /// If the arm is not physical.
    pub fn parameters(&self) -> Result<Vec<(&'static Parameter, Value)>, UnphysicalArm> {
        let after = identified_settings(&self.before, &self.result)?;
        let is_of_arm = |parameter: &Parameter| {
            ["arm", "joint1", "joint2"].contains(&parameter.group())
                || ["setup.friction_nm", "setup.friction_load_percent"].contains(&parameter.key)
        };
        let all = params::pairs(&after).into_iter();
        Ok(all.filter(|(parameter, _)| is_of_arm(parameter)).collect())
    }

    /// A board's settings with the identified arm, and gains for it.
    ///
    /// # Errors
    /// If the board cannot have it.
    pub fn adopted_by(&self, before: &Settings) -> Result<(Settings, Redesign), AdoptError> {
        let mut after = *before;
        let arm = self.parameters()?;
        let pairs = arm.iter().map(|(parameter, value)| (parameter.key, value));
        params::apply(&mut after, pairs)?;
        let (setup, redesign) = retune(&before.setup, &after.setup)?;
        after.setup = setup;
        params::check(&after)?;
        Ok((after, redesign))
    }
}
