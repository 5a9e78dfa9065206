use armbridge_client::LinkStats;
use armbridge_link::experiment::Conclusion;
use armbridge_link::message::{Command, Record};
use armbridge_log::summary::Tally;
use armbridge_sim::link::{BoardUri, Options, drive};

use super::*;
use crate::plan_runner::{PlanRunner, RecordSink};

fn parse(text: &str) -> Result<Scenario, ScenarioError> {
    Scenario::parse(Path::new("mine.toml"), text, &Overrides::default())
}

/// Where and what is wrong.
fn mistake(text: &str) -> String {
    parse(text).expect_err(text).to_string()
}

const HEAD: &str = "title = \"t\"\n[stop]\nafter_s = 5.0\n";

#[test]
fn mistakes_have_a_place_and_say_what_is_right() {
    for (tail, at, words) in [
        ("[stop", "4:6", "]"),
        (
            "[[step]]\nat_s = 0\nregulate_red = [0, 0]",
            "6:1",
            "is it `regulate_rad`",
        ),
        (
            "[[step]]\nat_s = 0\nregulate_rad = [0, 2]",
            "6:20",
            "from -1.2 to 1.2",
        ),
        ("[[step]]\nat_s = 0\nregulate_rad = [0]", "6:16", "2"),
        (
            "[[step]]\nat_s = 7\nregulate_rad = [0, 0]",
            "5:8",
            "ends after 5 s",
        ),
        ("[[step]]\nat_s = 1", "4:1", "does nothing"),
        (
            "[[step]]\nat_s = 1\narm = true\nidle = true",
            "4:1",
            "one action",
        ),
        (
            "[[step]]\nat_s = 1\narm = true\n[[step]]\nat_s = 0.5\narm = true",
            "8:8",
            "order of time",
        ),
        (
            "[[step]]\nat_s = 1\nidle = true\n[[step]]\nat_s = 2\ntorque_nm = [0, 0]",
            "7:1",
            "idle since the step at 1 s",
        ),
        (
            "[[step]]\nat_s = 1\nminimum_jerk = { to_rad = [0.9, 0], duration_s = 0.2 }",
            "6:1",
            "joint 1 would reach",
        ),
        (
            "[[step]]\nat_s = 1\nwaypoints = [{ after_s = 1, angle_rad = [0, 0] }, { after_s = 1, \
             angle_rad = [0, 0] }]",
            "6:63",
            "after the one before it",
        ),
        (
            "[[step]]\nat_s = 1\nstream = [{ after_s = 0.02, angle_rad = [0.0, 0.0] }]",
            "6:11",
            "give this point an `after_s` of",
        ),
        (
            "[set]\nsetup.period_us = 10000\n[[step]]\nat_s = 1\nfloat = true",
            "8:9",
            "`setup.period_us` of at most 5000",
        ),
        (
            "[set]\narm = { l2_m = 0, m2_kg = 0 }\n[[step]]\nat_s = 1\nregulate_rad = [0, 0.1]",
            "8:16",
            "the board's arm has no joint 2",
        ),
        ("[set]\ncontroller.kwind = 3", "5:20", "`controller.kind`"),
        ("[set]\nlimits.silence_ms = -3", "5:21", "limits.silence_ms"),
        (
            "[set]\nlimits.hold_ms = 600",
            "4:2",
            "longer than `limits.silence_ms`",
        ),
        (
            "[[step]]\nat_s = 1\nset = { limits.hold_ms = 50 }",
            "6:26",
            "put it into `[set]`",
        ),
        (
            "[bench]\ninitial_rad = [3.0, 0.0]",
            "5:16",
            "from -1.4 to 1.4",
        ),
        ("[bench]\nplant.torque_gain = 99.0", "5:21", "0.1 to 10"),
        (
            "[[bench.push]]\nat_s = 1\njoint = 3\ntorque_nm = 1\nduration_s = 1",
            "6:9",
            "from 1 to 2",
        ),
        ("[expect]\nsettles_within_s = -1", "5:20", "above 0"),
        ("success = [\"angel\"]", "4:12", "is it `angle`"),
    ] {
        assert_mistake(tail, at, words);
    }
}

#[test]
fn so_do_mistakes_in_experiments() {
    for (tail, at, words) in [
        (
            "[[step]]\nat_s = 1\nexperiment = { roles = [\"hold\", \"of\"], duration_s = 1, \
             angle_rad = [[-1, 1], [-1, 1]], speed_rad_s = [1, 1] }",
            "6:33",
            "`off`",
        ),
        (
            "[[step]]\nat_s = 1\n[step.experiment]\nduration_s = 700\nroles = [\"hold\", \"off\"]\n\
             angle_rad = [[-1, 1], [-1, 1]]\nspeed_rad_s = [1, 1]",
            "7:14",
            "to 600 s",
        ),
        (
            "[[step]]\nat_s = 1\n[step.experiment]\nduration_s = 1\nangle_rad = [[-1, 1], [-1, 1]]\n\
             speed_rad_s = [1, 1]\n\
             roles = [\"hold\", { torque = { prbs = { amplitude = 2, hold_s = 0.1, seed = 1 } } }]",
            "10:18",
            "more than the 1.25 N m",
        ),
        (
            "[[step]]\nat_s = 0\nregulate_rad = [0.5, 0]\n[[step]]\nat_s = 1\n\
             [step.experiment]\nduration_s = 1\nangle_rad = [[-0.4, 0.4], [-1, 1]]\n\
             speed_rad_s = [1, 1]\nroles = [\"hold\", \"off\"]",
            "11:14",
            "is at 0.50 rad",
        ),
        (
            "[[step]]\nat_s = 0\nregulate_rad = [0, 0]\n[[step]]\nat_s = 1\n\
             [step.experiment]\nduration_s = 1\nangle_rad = [[-1, 1], [-1, 1]]\n\
             speed_rad_s = [1, 3]\nroles = [\"hold\", \"off\"]",
            "11:23",
            "narrower or slower",
        ),
    ] {
        assert_mistake(tail, at, words);
    }
}

/// The mistake in this end of a file: its place and message, on one line.
#[track_caller]
pub(super) fn assert_mistake(tail: &str, at: &str, words: &str) {
    let text = mistake(&format!("{HEAD}{tail}"));
    let place = format!("mine.toml:{at}: ");
    assert!(text.starts_with(&place), "{tail}\n{text}");
    let is_said = text.to_lowercase().contains(&words.to_lowercase());
    assert!(is_said, "{tail}\nno {words:?} in {text}");
    assert!(!text.contains('\n'), "{text}");
}

#[test]
fn gains_that_let_the_arm_fall_are_found_before_it_does() {
    let weak =
        "[set]\ncontroller.kind = \"gain\"\ncontroller.gain = [0.3, 0, 0.1, 0, 0, 0.3, 0, 0.1]";
    let text = mistake(&format!("{HEAD}{weak}"));
    assert!(text.contains("eigenvalue"), "{text}");
}

#[test]
fn what_repeats_does_so_until_the_end() {
    let steps = "[[step]]\nat_s = 0\nevery_s = 2\nregulate_rad = [0, 0]\n\
                 [[step]]\nat_s = 1\nevery_s = 2\nregulate_rad = [0.1, 0]";
    let scenario = parse(&format!("{HEAD}{steps}")).unwrap();
    let times: Vec<u64> = scenario
        .plan
        .steps
        .iter()
        .map(|step| step.at_us / 1_000)
        .collect();
    assert_eq!(times, [0, 1_000, 2_000, 3_000, 4_000]);
}

#[test]
fn an_unknown_name_gets_the_nearest_one() {
    let error = Scenario::load("uprihgt", &Overrides::default()).unwrap_err();
    assert!(error.to_string().contains("is it `upright`?"), "{error}");
}

#[derive(Debug)]
struct ExpectationSink {
    tally: Tally,
    monitor: ExpectationMonitor,
}

impl RecordSink for ExpectationSink {
    fn record(&mut self, record: &Record) {
        self.tally.add(record);
        self.monitor.on_record(record);
    }

    fn concluded(&mut self, conclusion: &Conclusion) {
        self.monitor.on_experiment_end(conclusion);
    }
}

/// Runs a scenario on the bench; returns its end and missed expectations.
fn simulate(scenario: &Scenario) -> (Option<Ending>, Vec<String>, u64) {
    let sink = ExpectationSink {
        tally: Tally::default(),
        monitor: ExpectationMonitor::new(
            scenario.expect,
            &scenario.plan.pushes,
            &scenario.plan.leads,
        ),
    };
    let runner = PlanRunner::with_sink(scenario.plan.clone(), sink);
    let options = Options::new(scenario.bench.build());
    let (runner, result) = drive(&BoardUri::Sim, options, runner);
    let name = &scenario.name;
    result.unwrap_or_else(|error| panic!("{name}: {error}"));
    let ending = runner.ending();
    let ExpectationSink { tally, monitor } = runner.into_sink();
    let facts = armbridge_log::run_info::RunFacts::from_settings(
        name,
        "simulated: bench",
        &scenario.settings,
    );
    let summary = tally.summary(&facts, LinkStats::default(), 1.0, 1.0);
    let ticks = summary.ticks;
    (ending, monitor.misses(&tally, &summary), ticks)
}

#[test]
fn every_built_in_scenario_succeeds() {
    for builtin in BUILTINS {
        // An hour is too long for a test.
        let overrides = Overrides {
            duration_s: (builtin.name == "hour").then_some(60.0),
            ..Overrides::default()
        };
        let scenario = Scenario::load(builtin.name, &overrides)
            .unwrap_or_else(|error| panic!("{}: {error}", builtin.name));
        let (ending, missed, ticks) = simulate(&scenario);
        println!(
            "{}: {ending:?}, {ticks} ticks, missed {missed:?}",
            builtin.name
        );
        let is_success = ending.is_some_and(|end| scenario.success.iter().any(|s| s.matches(end)));
        assert!(is_success, "{}: {ending:?}", builtin.name);
        assert_eq!(missed, Vec::<String>::new(), "{}", builtin.name);
    }
}

#[test]
fn a_missed_expectation_is_reported() {
    let text = "title = \"t\"\ncontrol = \"paper\"\n[[step]]\nat_s = 0\nregulate_rad = [0, 0]\n\
                [[bench.push]]\nat_s = 2.9\njoint = 1\ntorque_nm = 0.5\nduration_s = 0.05\n\
                [stop]\nafter_s = 3.0\n[expect]\nrests_within_rad = 0.001\nsettles_within_s = 0.1\n\
                tracks_within_rad = 0.1\nrecovers_within_s = 0.5\ntorque_within_nm = 0.1";
    let (ending, missed, _) = simulate(&parse(text).unwrap());
    assert_eq!(
        (ending, missed.len()),
        (Some(Ending::Time), 5),
        "{missed:?}"
    );
}

#[test]
fn settings_are_put_back_and_a_stop_condition_stops() {
    let text = "title = \"t\"\n[set]\nlimits.speed_rad_s = [6, 6]\ncontroller.q = [20, 20, 1, 1]\n\
                [[step]]\nat_s = 0\nregulate_rad = [0, 0]\n[[step]]\nat_s = 1\n\
                regulate_rad = [0.6, 0]\n[stop]\nafter_s = 5\nangle_beyond_rad = [0.4, 0.4]\n\
                success = [\"angle\"]";
    let scenario = parse(text).unwrap();
    let bits = scenario.settings.limits.speed_rad_s.map(f32::to_bits);
    assert_eq!(bits, [6.0_f32.to_bits(); 2]);
    let runner = PlanRunner::new(scenario.plan.clone());
    let options = Options::new(scenario.bench.build());
    let (runner, result) = drive(&BoardUri::Sim, options, runner);
    result.unwrap();
    assert!(matches!(
        runner.ending(),
        Some(Ending::Angle { joint: 0, .. })
    ));
    assert_eq!(runner.begun_with(), Some(&scenario.settings));
    assert_eq!(runner.settings(), Some(&Settings::default()));
    let (_, commands, _) = runner.into_parts();
    let last: Vec<_> = commands
        .iter()
        .rev()
        .take(3)
        .map(|(_, last)| *last)
        .collect();
    let default = Settings::default();
    let back = [
        Command::Configure(default.setup),
        Command::Limit(default.limits),
        Command::Idle,
    ];
    assert_eq!(last, back);
}

/// The parser and the table that explains it have the same keys.
#[test]
fn the_table_has_the_keys_that_the_parser_takes() {
    for (text, prefix) in [
        ("zzz = 1", ""),
        ("title = 't'\n[stop]\nzzz = 1", "stop."),
        ("[[step]]\nzzz = 1", "step."),
        (
            "[[step]]\n[step.minimum_jerk]\nzzz = 1",
            "step.minimum_jerk.",
        ),
        ("[[step]]\n[[step.waypoints]]\nzzz = 1", "step.waypoints."),
        ("[[step]]\n[[step.stream]]\nzzz = 1", "step.stream."),
        ("[[step]]\n[step.sinusoid]\nzzz = 1", "step.sinusoid."),
        ("[[step]]\n[step.chirp]\nzzz = 1", "step.chirp."),
        ("[[step]]\n[step.experiment]\nzzz = 1", "step.experiment."),
        ("[expect]\nzzz = 1", "expect."),
        ("[bench]\nzzz = 1", "bench."),
        ("[[bench.push]]\nzzz = 1", "bench.push."),
        ("[[bench.hand]]\nzzz = 1", "bench.hand."),
        (
            "[[bench.hand]]\n[[bench.hand.path]]\nzzz = 1",
            "bench.hand.path.",
        ),
    ] {
        let error = toml::from_str::<file::File>(text).unwrap_err();
        let mut parsed: Vec<&str> = error.message().split('`').skip(3).step_by(2).collect();
        let below = KEYS
            .iter()
            .flat_map(|table| table.keys)
            .filter_map(|key| key.path.strip_prefix(prefix));
        let mut known: Vec<&str> = below.filter(|name| !name.contains('.')).collect();
        parsed.sort_unstable();
        known.sort_unstable();
        assert_eq!(known, parsed, "{prefix}");
    }
}

#[test]
fn ranges_are_those_of_the_board() {
    use armbridge_board::bridge::limits::REFERENCE_MAX_RAD;
    use armbridge_link::limits::hard;
    let [reference_rad, torque_nm] =
        [keys::REFERENCE_RAD, keys::TORQUE_NM].map(|range| range.high as f32);
    assert!((reference_rad - REFERENCE_MAX_RAD).abs() < f32::EPSILON);
    assert!((torque_nm - hard::TORQUE_NM).abs() < f32::EPSILON);
}

#[test]
fn an_arm_beside_the_scenario_is_never_taken_from_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.toml");
    let load = |plant: &str| {
        let text =
            format!("{HEAD}[bench]\nplant_file = \"{plant}\"\n[[step]]\nat_s = 0\nidle = true\n");
        Scenario::parse(&file, &text, &Overrides::default())
    };
    // The tests run in the crate's folder, which has a file of this name.
    let error = load("Cargo.toml").unwrap_err().to_string();
    let missing = folder.path().join("Cargo.toml").display().to_string();
    assert!(error.contains(&format!("cannot read {missing}")), "{error}");
    // A folder hides no arm that ships, and a file does.
    std::fs::create_dir(folder.path().join("heavy")).unwrap();
    let heavy = load("heavy").unwrap().bench.plant;
    let default = load("default").unwrap().bench.plant;
    assert_ne!(heavy, default);
    std::fs::write(
        folder.path().join("default"),
        "inertia_scale = 1.2\ngravity_scale = 1.2\n",
    )
    .unwrap();
    assert_eq!(load("default").unwrap().bench.plant, heavy);
}
