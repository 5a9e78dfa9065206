//! Through angles at times.

use super::*;
use crate::trajectory::waypoints::{Knot, Knots, smooth};

fn points(random: &mut Random, count: usize) -> heapless::Vec<Waypoint<f64>, WAYPOINTS_MAX> {
    let mut at_s = 0.0;
    (0..count)
        .map(|_| {
            at_s += random.within(0.2, 1.5);
            Waypoint {
                at_s,
                q: random.vector(1.0),
            }
        })
        .collect()
}

#[test]
fn passes_every_waypoint_and_is_smooth_there() {
    for seed in 0..200 {
        let mut random = Random::seeded(seed);
        let from = random.reference();
        let points = points(&mut random, 1 + seed as usize % WAYPOINTS_MAX);
        let shape = Shape::Waypoints {
            points: points.clone(),
        };
        let trajectory = Trajectory::plan(from, &shape, &WIDE).unwrap();
        assert!(gap(&trajectory.at(0.0), &from) < 1e-12);
        for point in &points {
            assert!((trajectory.at(point.at_s).q - point.q).amax() < 1e-9);
        }
        let last = points.last().unwrap();
        assert_eq!(trajectory.duration_s(), last.at_s);
        assert_eq!(trajectory.at(last.at_s), Reference::at_rest(last.q));
        let knots: List<f64> = points.iter().map(|point| point.at_s).collect();
        assert_smooth(&trajectory, &knots, 1e4);
    }
}

/// Third and fourth derivative by differences of the exact second.
fn jerk_and_snap(trajectory: &Trajectory<f64>, t: f64, side: f64) -> (Vector2<f64>, Vector2<f64>) {
    let h = 1e-4 * side;
    // Off the knot by a hair; one-sided, second order.
    let [a, b, c, d] = [0.0, 1.0, 2.0, 3.0].map(|i| trajectory.at(t + side * 1e-12 + h * i).ddq);
    let jerk = (b * 4.0 - a * 3.0 - c) / (2.0 * h);
    let snap = (a * 2.0 - b * 5.0 + c * 4.0 - d) / (h * h);
    (jerk, snap)
}

#[test]
fn jerk_and_snap_are_continuous_too() {
    for seed in 0..50 {
        let mut random = Random::seeded(seed);
        let from = random.reference();
        let points = points(&mut random, 6);
        let shape = Shape::Waypoints {
            points: points.clone(),
        };
        let trajectory = Trajectory::plan(from, &shape, &WIDE).unwrap();
        for point in points.iter().take(5) {
            let (jerk, snap) = jerk_and_snap(&trajectory, point.at_s, -1.0);
            let (jerk_after, snap_after) = jerk_and_snap(&trajectory, point.at_s, 1.0);
            let scale = 1.0 + snap.amax();
            assert!((jerk - jerk_after).amax() < 1e-3 * scale);
            assert!((snap - snap_after).amax() < 1e-2 * scale);
        }
    }
}

/// The integral of squared jerk cannot be lowered by other speeds or
/// accelerations at the waypoints.
#[test]
fn least_jerk() {
    let cost = |knots: &Knots<f64>| -> f64 {
        let ways = knots.windows(2).map(|two| {
            let h = two[1].at_s - two[0].at_s;
            let way = quintic::Quintic::joining(&two[0].reference, &two[1].reference, h);
            let jerk = |t: f64| (way.at(t + 1e-6).ddq - way.at(t - 1e-6).ddq) / 2e-6;
            // Squared jerk is of degree four: Gauss-Legendre on three points is
            // exact.
            let root = 0.6_f64.sqrt() / 2.0;
            [(0.5 - root, 5.0), (0.5, 8.0), (0.5 + root, 5.0)]
                .map(|(u, weight)| jerk(u * h).norm_squared() * weight * h / 18.0)
                .iter()
                .sum::<f64>()
        });
        ways.sum()
    };
    for seed in 0..20 {
        let mut random = Random::seeded(seed);
        let mut knots = Knots::new();
        let mut at_s = 0.0;
        for _ in 0..5 {
            let reference = Reference::at_rest(random.vector(1.0));
            assert!(knots.push(Knot { at_s, reference }).is_ok());
            at_s += random.within(0.5, 1.0);
        }
        smooth(&mut knots).unwrap();
        let least = cost(&knots);
        for _ in 0..20 {
            let mut other: Knots<f64> = knots
                .iter()
                .map(|knot| Knot {
                    at_s: knot.at_s,
                    reference: knot.reference,
                })
                .collect();
            for knot in other.iter_mut().take(4).skip(1) {
                knot.reference.dq += random.vector(0.01);
                knot.reference.ddq += random.vector(0.1);
            }
            assert!(cost(&other) > least, "{} {least}", cost(&other));
        }
    }
}

#[test]
fn bounds_hold_or_the_peak_is_named() {
    let bounds = Bounds {
        angle_rad: 1.2,
        speed_rad_s: 3.0,
        acceleration_rad_s2: 15.0,
        jerk_rad_s3: 1e9,
    };
    let (mut passed, mut refused) = (0, 0);
    for seed in 0..300 {
        let mut random = Random::seeded(seed);
        let points = points(&mut random, 4);
        let (from, shape) = (
            Reference::at_rest(random.vector(0.5)),
            Shape::Waypoints { points },
        );
        match Trajectory::plan(from, &shape, &bounds) {
            Ok(trajectory) => {
                passed += 1;
                assert!(sampled_ratio(&trajectory, &bounds) < 1.0 + 1e-4);
            }
            Err(Error::Exceeds(peak)) => {
                refused += 1;
                let any = Trajectory::plan(from, &shape, &WIDE).unwrap();
                let there = any.at(peak.at_s);
                let value = match peak.quantity {
                    Quantity::Angle => there.q,
                    Quantity::Speed => there.dq,
                    Quantity::Acceleration => there.ddq,
                    Quantity::Jerk => panic!("{peak:?}"),
                }[peak.joint];
                assert!((value - peak.value).abs() < 1e-6 * peak.limit);
                assert!(value.abs() > peak.limit && peak.limit == bounds.of(peak.quantity));
            }
            Err(other) => panic!("{other:?}"),
        }
    }
    assert!(passed > 30 && refused > 30, "{passed} {refused}");
}

#[test]
fn f32_agrees_with_f64() {
    for seed in 0..100 {
        let mut random = Random::seeded(seed);
        let points = points(&mut random, WAYPOINTS_MAX);
        let close: heapless::Vec<Waypoint<f32>, WAYPOINTS_MAX> = points
            .iter()
            .map(|point| Waypoint {
                at_s: point.at_s as f32,
                q: point.q.cast(),
            })
            .collect();
        let from = Reference::at_rest(random.vector(1.0));
        let exact = Trajectory::plan(from, &Shape::Waypoints { points }, &WIDE).unwrap();
        let bounds = Bounds {
            angle_rad: 1e3_f32,
            speed_rad_s: 1e4,
            acceleration_rad_s2: 1e6,
            jerk_rad_s3: 1e9,
        };
        let close = Shape::Waypoints { points: close };
        let close = Trajectory::plan(single(&from), &close, &bounds).unwrap();
        for i in 0..500 {
            let t = exact.duration_s() * f64::from(i) / 500.0;
            let error = exact.at(t).q - close.at(t as f32).q.cast::<f64>();
            assert!(error.amax() < 1e-4, "{seed} {t} {error}");
        }
    }
}
