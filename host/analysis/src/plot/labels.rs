//! Names of several runs in a legend: the facts and settings in which they differ.

use armbridge_client::params;
use armbridge_link::message::{Settings, Setup};

use super::run::Run;

/// Differing settings in a name; more are counted.
const SETTINGS_MAX: usize = 3;

/// Period: a fact of the run, see [`FACTS`].
const PERIOD_KEY: &str = "setup.period_us";

/// Groups of the settings that a control consists of.
const CONTROL_GROUPS: [&str; 3] = ["controller", "estimator", "setup"];

/// Facts of a run, each as words with a rank of its own.
const FACTS: [fn(&Run) -> Option<String>; 5] = [
    |run| Some(run.facts.name.clone()),
    |run| Some(run.facts.world.clone()),
    |run| control(&run.settings).map(|name| format!("control {name}")),
    |run| run.facts.seed.map(|seed| format!("seed {seed}")),
    |run| Some(format!("period {} µs", run.facts.period_us)),
];

/// Facts that all runs share, as words, and the name of each run.
pub(super) fn labels(runs: &[Run]) -> (String, Vec<String>) {
    let mut common = Vec::new();
    let mut labels = vec![Vec::new(); runs.len()];
    for fact in FACTS {
        let words: Vec<_> = runs.iter().map(fact).collect();
        if words.windows(2).all(|two| two[0] == two[1]) {
            common.extend(words.into_iter().next().flatten());
        } else {
            for (label, words) in labels.iter_mut().zip(words) {
                label.extend(words);
            }
        }
    }
    for (label, settings) in labels.iter_mut().zip(differing_settings(runs)) {
        let more = settings.len().saturating_sub(SETTINGS_MAX);
        label.extend(settings.into_iter().take(SETTINGS_MAX));
        label.extend((more > 0).then(|| format!("and {more} more")));
    }
    let mut labels: Vec<String> = labels.iter().map(|words| words.join(" · ")).collect();
    // Runs without a difference have the names of their folders.
    let plain = labels.clone();
    for (run, label) in runs.iter().zip(&mut labels) {
        let is_alone = plain.iter().filter(|other| *other == label).count() == 1;
        if !is_alone || label.is_empty() {
            let separator = if label.is_empty() { "" } else { " · " };
            *label = format!("{label}{separator}{}", place(run));
        }
    }
    (common.join(" · "), labels)
}

/// Name of a whole set-up, where it is one; arm, joints and period apart.
pub(super) fn control(settings: &Settings) -> Option<&'static str> {
    let own = settings.setup;
    let is = |control: Setup| {
        own == Setup {
            period_us: own.period_us,
            ..control.with_arm_of(&own)
        }
    };
    match () {
        () if is(Setup::best()) => Some("compensated"),
        () if is(Setup::default()) => Some("paper"),
        () => None,
    }
}

/// Settings of each run that differ between any two, those of the controller first; without the
/// period, and without the settings of a control that has a name.
fn differing_settings(runs: &[Run]) -> Vec<Vec<String>> {
    let mut differing: Vec<_> = params::all()
        .iter()
        .filter(|parameter| parameter.key != PERIOD_KEY)
        .map(|parameter| {
            let value = |run: &Run| params::get(&run.settings, parameter.key);
            (parameter, runs.iter().map(value).collect::<Vec<_>>())
        })
        .filter(|(_, values)| values.windows(2).any(|two| two[0] != two[1]))
        .collect();
    differing.sort_by_key(|(parameter, _)| {
        let group = parameter.group();
        CONTROL_GROUPS
            .iter()
            .position(|one| *one == group)
            .unwrap_or(CONTROL_GROUPS.len())
    });
    let words_of = |(place, run): (usize, &Run)| {
        let is_named = control(&run.settings).is_some();
        let own = differing
            .iter()
            .filter(|(parameter, _)| !(is_named && CONTROL_GROUPS.contains(&parameter.group())));
        own.filter_map(|(parameter, values)| {
            let text = params::to_text(values[place].as_ref()?);
            let text = text.trim_matches(['[', ']', '"']);
            Some(format!("{} {text}", parameter.key))
        })
        .collect::<Vec<_>>()
    };
    runs.iter().enumerate().map(words_of).collect()
}

/// Folder of a run's log, or the name of a log that is not called `run.mcap`.
fn place(run: &Run) -> String {
    let name =
        |path: &std::path::Path| path.file_name().map(|it| it.to_string_lossy().into_owned());
    let log = name(&run.path).unwrap_or_default();
    let folder = run.path.parent().and_then(name);
    folder.filter(|_| log == "run.mcap").unwrap_or(log)
}
