//! The paper computed again: the numbers that the report rests on, and the
//! report itself.
#![allow(clippy::float_cmp, reason = "cut numbers and grid points are exact")]

use std::collections::HashSet;

use armbridge_paper as paper;
use armbridge_paper::{
    Claim, ConstantInput, DiscreteModel, Dynamics, Findings, FreeFall, Gains, LqrObserver, PwmLaw,
    Regulation, Tracking, Verdict,
};

use crate::folder;

fn cut(value: f64) -> f64 {
    (value * 100.0).trunc() / 100.0
}

fn assert_near(what: &str, found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    assert!(error <= tolerance, "{what}: {found}, not {expected}");
}

/// Compares the claims, in their order, by name and verdict.
fn assert_verdicts<const N: usize>(claims: &[Claim], expected: [(&str, Verdict); N]) {
    let found: Vec<_> = claims.iter().map(|c| (c.id, c.verdict())).collect();
    assert_eq!(found, expected);
}

#[test]
fn energy_tells_the_printed_coriolis_matrix_from_the_right_one() {
    let model = Dynamics::compute();
    let [printed, sign, dimension, both] = model.drift_j;
    assert_near("as printed", printed, 0.5136, 1e-4);
    assert_near("sign mended", sign, 0.3175, 1e-4);
    assert_near("dimension mended", dimension, 0.2107, 1e-4);
    assert!(both < 1e-11, "{both:e} J");
    let expected = [
        ("coriolis", Verdict::Explained),
        ("equilibria", Verdict::Reproduced),
    ];
    assert_verdicts(&model.claims(), expected);
}

#[test]
fn the_digits_of_7_leave_one_inertia() {
    let discrete_model = DiscreteModel::compute();
    let intervals = [
        (discrete_model.i1x_reading, [0.02265346443, 0.02265556314]),
        (discrete_model.i1x_printed, [0.02286780818, 0.02286990689]),
        (discrete_model.i2y, [0.02265310904, 0.02265434449]),
    ];
    for (found, expected) in intervals {
        assert_near("lower end", found[0], expected[0], 1e-10);
        assert_near("upper end", found[1], expected[1], 1e-10);
    }
    assert_near("Euler's A", discrete_model.euler_error[0], 0.127, 5e-4);
    assert_near("Euler's B", discrete_model.euler_error[1], 0.260, 5e-4);
    assert_verdicts(&discrete_model.claims(), [("model", Verdict::Explained)]);
}

#[test]
fn gains_are_those_printed_cut_to_two_decimals() {
    let gains = Gains::compute().expect("designs");
    let k = [(0, 0), (0, 2), (1, 1), (1, 3)].map(|at| cut(gains.k[at]));
    assert_eq!(k, [1.65, 0.22, 1.10, 0.20]);
    assert_eq!(gains.slow_poles[0], [[0.60, 0.75]]);
    assert_eq!(gains.slow_poles[1], [[0.65, 0.70]]);
    let slow = gains.slow.map(|gain| [cut(gain.x), cut(gain.y)]);
    assert_eq!(slow, [[0.29, 0.72], [0.34, 0.34]]);
    let poles = [[0.757658, 0.600942], [0.701534, 0.653066]];
    for (found, expected) in gains.poles_of_12.iter().zip(poles) {
        assert_near("larger pole of (12)", found[0], expected[0], 1e-6);
        assert_near("smaller pole of (12)", found[1], expected[1], 1e-6);
    }
    let expected = [
        ("lqr", Verdict::Reproduced),
        ("observer-gain", Verdict::Explained),
    ];
    assert_verdicts(&gains.claims(), expected);
}

#[test]
fn dry_friction_makes_one_arm_of_both_identifications() {
    let (fall, push, pwm) = (
        FreeFall::compute(),
        ConstantInput::compute(),
        PwmLaw::compute(),
    );
    assert_near("fit without friction", fall.b1_without, 0.24, 1e-4);
    assert_near("fit with friction", fall.b1_with, 0.421, 1e-4);
    // What it takes depends on where the fall starts and how long it is seen.
    assert_near("Coulomb friction", fall.coulomb_nm, 0.107285, 1e-3);
    assert_near("short of 180 degrees", fall.short_deg, 10.8, 0.1);
    for (found, expected) in [
        (fall.inertia_effect, [-7.2, 6.6]),
        (fall.friction_effect, [-28.5, 33.2]),
    ] {
        assert_near("half", found[0], expected[0], 0.5);
        assert_near("one and a half times", found[1], expected[1], 0.5);
    }
    assert_near("b1", push.without[0], 0.24, 1e-3);
    assert_near("torque", push.without[1], -0.3924, 5e-4);
    assert_near("torque with friction", push.with[1], -0.3524, 5e-4);
    assert_near("upright", push.upright_s, 0.73, 0.01);
    assert_near("zero torque", pwm.zero_counts, 1015.0, 1e-9);
    let expected = [
        ("fall", Verdict::Explained),
        ("inertia", Verdict::Reproduced),
        ("push", Verdict::Reproduced),
        ("pwm", Verdict::NotReproduced),
    ];
    assert_verdicts(
        &[fall.claims(), push.claims(), pwm.claims()].concat(),
        expected,
    );
}

#[test]
fn the_printed_observer_is_stable_and_soft_and_hangs_where_differences_stand() {
    let lqr_observer = LqrObserver::compute().expect("designs");
    assert_near("radius", lqr_observer.spectral_radius[0], 0.8648, 1e-3);
    assert_near(
        "radius, delayed",
        lqr_observer.spectral_radius[1],
        0.9105,
        1e-3,
    );
    assert_near(
        "radius, differences",
        lqr_observer.other_spectral_radii[1],
        0.8742,
        1e-3,
    );
    let [full, printed, _] = lqr_observer.stiffness;
    assert_near("stiffness, full state", full[0], 1.0794, 1e-4);
    assert_near("stiffness, printed L", printed[0], 0.3493, 1e-4);
    assert_near("stiffness, printed L", printed[1], 0.2902, 1e-4);
    assert_near("softening", lqr_observer.softening(), 3.09, 0.0309);
    assert_near(
        "least gain",
        lqr_observer.minimum_torque_gain[1],
        0.6203,
        1e-4,
    );
    // With weak motors.
    assert!((paper::WEAK - 0.7).abs() < 1e-12);
    let [difference, printed, ..] = lqr_observer.weak_rest_rad;
    assert_near("printed L", printed, 0.44, 0.03);
    assert!(difference < 0.1, "{difference} rad");
    // At nominal torque, and what mends it.
    let [
        difference,
        printed,
        placed,
        current,
        board,
        compensated,
        filter,
    ] = lqr_observer.rest_rad;
    assert_near("differences", difference, 0.0423, 0.003);
    assert_near("printed L", printed, 0.1134, 0.003);
    assert_near("printed poles", placed, 0.0628, 0.003);
    assert_near("current form", current, 0.0527, 0.003);
    assert!(board < current, "{board} rad");
    assert!(compensated < 0.02, "{compensated} rad");
    assert!(filter < 0.01, "{filter} rad");
    let filter_when_weak = lqr_observer.weak_rest_rad[6];
    assert!(filter_when_weak < 0.02, "{filter_when_weak} rad");
    assert_verdicts(
        &lqr_observer.claims(),
        [("instability", Verdict::Explained)],
    );
}

#[test]
fn with_a_delay_differences_oscillate_and_the_slow_observer_tracks() {
    let tracking = Tracking::compute().expect("designs");
    let [difference, printed, ..] = tracking.delayed_rad;
    assert!((0.11..0.21).contains(&difference), "{difference} rad");
    assert!((0.018..0.029).contains(&printed), "{printed} rad");
    assert!(
        tracking.undelayed_rad[0] < 0.005,
        "{:?}",
        tracking.undelayed_rad
    );
    // The more aggressive observer falls; on the exact model it does not.
    assert!(tracking.undelayed_rad[2].is_infinite());
    assert!(tracking.undelayed_rad[3] < 0.002);
    assert_eq!(tracking.last_omega, [14.0, 24.0]);
    assert!(
        tracking.with_sent_torque.1 < 0.01,
        "{:?}",
        tracking.with_sent_torque
    );
    let [slow, fast] = tracking.corrected_rad;
    assert!(slow < 0.002 && fast < 2e-4, "{slow} and {fast} rad");
    let expected = [
        ("tracking", Verdict::Explained),
        ("aggressive", Verdict::Reproduced),
    ];
    assert_verdicts(&tracking.claims(), expected);
}

#[test]
fn model_and_arm_stay_together_under_lqr() {
    let regulation = Regulation::compute().expect("designs");
    assert!(regulation.rest_rad < regulation.explained_rad);
    assert!(regulation.settled_s < 1.3, "{} s", regulation.settled_s);
    assert_near("peak torque", regulation.torque_nm[0], 0.8085, 0.005);
    // Faster sampling leaves what is static where it is.
    assert!(regulation.fast_rest_rad > 0.8 * regulation.rest_rad);
    assert!(regulation.fast_rest_rad < regulation.explained_rad);
    assert_verdicts(&regulation.claims(), [("standing", Verdict::Reproduced)]);
}

fn figures(claims: &[Claim]) -> impl Iterator<Item = &paper::Figure> {
    claims.iter().flat_map(|claim| &claim.figures)
}

#[test]
fn the_page_stands_alone_shows_everything_and_is_the_same_every_time() {
    let [(folder, claims, page), (_, _, again)] = ["paper-once", "paper-twice"].map(|name| {
        let (folder, claims) = (folder(name), Findings::compute().expect("designs").claims());
        let path = paper::write(&folder, &claims).expect("a report");
        let page = std::fs::read_to_string(path).expect("text");
        (folder, claims, page)
    });
    assert!(page == again);

    for outside in [
        "http:", "https:", "src=", "<script", "<link", "@import", "file:",
    ] {
        assert!(!page.contains(outside), "{outside} in the page");
    }
    let mut in_paper: Vec<_> = figures(&claims).filter_map(|f| f.paper_figure).collect();
    in_paper.sort_by_key(|name| name.len());
    let expected = ["Fig. 5", "Fig. 6", "Fig. 7", "Fig. 8", "Fig. 9", "Fig. 10"];
    assert_eq!(in_paper, expected);
    for figure in figures(&claims) {
        assert!(page.contains(&format!("<figure id=\"{}\">", figure.name)));
        let name = figure.paper_figure.unwrap_or("Not in the paper");
        assert!(page.contains(&format!("<figcaption>{name}. ")));
        for ending in ["svg", "png"] {
            let file = folder.join(format!("{}.{ending}", figure.name));
            assert!(file.metadata().expect("a file").len() > 1000, "{file:?}");
        }
    }
    for claim in &claims {
        assert!(page.contains(&format!("href=\"#{}\"", claim.id)));
        assert!(page.contains(claim.verdict().words()));
    }
    assert!(page.contains("Everything here is simulated"));
    assert_well_formed(&page);
}

/// Every element is closed in order, and no two have one name.
fn assert_well_formed(page: &str) {
    let (mut open, mut names) = (Vec::new(), HashSet::new());
    let body = page.split_once("<main>").expect("a body").1;
    let body = body.split_once("</main>").expect("an end").0;
    for piece in body.split('<').skip(1) {
        let (tag, _text) = piece.split_once('>').expect("a tag's end");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "{tag}");
        } else if !tag.ends_with('/') {
            open.push(tag.split(' ').next().expect("a name"));
        }
        if let Some((_, name)) = tag.split_once("id=\"") {
            let name = name.split('"').next().expect("a quote");
            assert!(names.insert(name), "{name} twice");
        }
    }
    assert!(open.is_empty(), "{open:?}");
    // What is pointed at is there.
    for mark in ["href=\"#", "url(#"] {
        for target in body.split(mark).skip(1) {
            let name = target.split(['"', ')']).next().expect("an end");
            assert!(names.contains(name), "nothing is called {name}");
        }
    }
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let folder = folder("paper-nowhere").join("no-such-folder");
    let error = paper::write(&folder, &Dynamics::compute().claims()).unwrap_err();
    assert!(error.to_string().contains("no-such-folder"), "{error}");
}
