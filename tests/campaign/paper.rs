//! The paper's two friction values by the board's logs, over twenty seeds of three arms.

use armbridge_tests::paper_runs::{DRY, Place, SMOOTH};
use armbridge_tests::paths;
use serde_json::Value;

/// Of the encoders' noise.
const SEEDS: usize = 20;

/// One arm over many seeds: what comes out, how often the truth is in its interval, and
/// how often the form is called wrong.
fn many(name: &str, arm: &str, torque: &str, [b1, coulomb_nm]: [f64; 2]) -> [usize; 3] {
    let place = Place::new(paths::armbridge(), crate::folder(name));
    let mut ranges = [[f64::INFINITY, f64::NEG_INFINITY]; 4];
    let mut counts = [0; 3];
    for seed in 1..=SEEDS {
        let seed = seed.to_string();
        let logs = [
            place.record("paper-free-fall", &seed, arm, ""),
            place.record("paper-constant-input", &seed, arm, torque),
        ];
        let found = place.json(&["identify", "paper", &logs[0], &logs[1], "--json"]);
        let lines = found["lines"].as_array().unwrap();
        let [fall, push, _, both] = lines.as_slice() else {
            panic!("{} lines", lines.len());
        };
        let number = |line: &Value, name: &str, of: &str| line[name][of].as_f64().unwrap();
        let values = [
            number(fall, "b1", "value"),
            number(push, "b1", "value"),
            number(both, "b1", "value"),
            number(both, "coulomb_nm", "value"),
        ];
        for (range, value) in ranges.iter_mut().zip(values) {
            *range = [range[0].min(value), range[1].max(value)];
        }
        let is_within = |value: f64, truth: f64, name| {
            usize::from((value - truth).abs() < number(both, name, "within"))
        };
        counts[0] += is_within(values[2], b1, "b1");
        counts[1] += is_within(values[3], coulomb_nm, "coulomb_nm");
        counts[2] += usize::from(found["form"]["is_wrong"] == true);
    }
    let names = [
        "b1 of the fall",
        "b1 of the push",
        "b1 of both",
        "dry friction",
    ];
    for (name, [low, high]) in names.iter().zip(ranges) {
        println!("{name}, {low:.4} to {high:.4}");
    }
    println!("{name}: b1 and dry friction within, warned: {counts:?} of {SEEDS}\n");
    counts
}

#[test]
fn twenty_seeds_of_three_arms() {
    let arms = [
        ("dry", DRY, "-0.4997 }", [0.239, 0.107285], SEEDS),
        ("the bench's", "", "-0.3924 }", [0.24, 0.04], SEEDS),
        ("smooth", SMOOTH, "-0.3924 }", [0.24, 0.0], 0),
    ];
    for (name, arm, torque, truth, warned) in arms {
        let [b1, coulomb, wrong] = many(&format!("twenty-{name}"), arm, torque, truth);
        // Of intervals of 95 %, chance leaves fewer than 16 of 20 once in 400 times.
        assert!(b1 >= 16 && coulomb >= 16, "{name}: {b1}, {coulomb}");
        assert_eq!(wrong, warned, "{name}");
    }
}
