//! Point to point.

use super::*;

const ARM: Bounds<f64> = Bounds {
    angle_rad: 1.5,
    speed_rad_s: 3.0,
    acceleration_rad_s2: 20.0,
    jerk_rad_s3: 1e9,
};

fn shape(to: Vector2<f64>, duration_s: Option<f64>) -> Shape<f64> {
    Shape::MinimumJerk { to, duration_s }
}

#[test]
fn from_rest_it_is_the_known_polynomial() {
    let (from, to, duration) = (Vector2::new(0.3, -0.2), Vector2::new(0.9, -0.7), 0.8);
    let start = Reference::at_rest(from);
    let trajectory = Trajectory::plan(start, &shape(to, Some(duration)), &ARM).unwrap();
    assert_eq!(trajectory.duration_s(), duration);
    let d = to - from;
    for i in 0..1000 {
        let u = f64::from(i) / 1000.0;
        let known = Reference {
            q: from + d * (10.0 * u.powi(3) - 15.0 * u.powi(4) + 6.0 * u.powi(5)),
            dq: d * (30.0 * u.powi(2) - 60.0 * u.powi(3) + 30.0 * u.powi(4)) / duration,
            ddq: d * (60.0 * u - 180.0 * u.powi(2) + 120.0 * u.powi(3)) / duration.powi(2),
        };
        assert!(gap(&trajectory.at(u * duration), &known) < 1e-12);
    }
    // Clamped at both ends.
    assert_eq!(trajectory.at(-1.0), start);
    assert_eq!(trajectory.at(duration), Reference::at_rest(to));
    assert_eq!(trajectory.at(1e9), Reference::at_rest(to));
    assert_eq!(trajectory.at(f64::NAN), Reference::at_rest(to));
    assert_eq!(trajectory.end(), to);
}

#[test]
fn peaks_are_where_and_what_they_are_known_to_be() {
    let (d, duration) = (0.8, 0.5);
    let start = Reference::at_rest(Vector2::zeros());
    let wanted = shape(Vector2::new(0.1, d), Some(duration));
    let refused = |speed_rad_s, acceleration_rad_s2| {
        let bounds = Bounds {
            angle_rad: 1.0,
            speed_rad_s,
            acceleration_rad_s2,
            jerk_rad_s3: 1e9,
        };
        match Trajectory::plan(start, &wanted, &bounds) {
            Err(Error::Exceeds(peak)) => peak,
            other => panic!("{other:?}"),
        }
    };
    let peak = refused(2.9, 100.0);
    assert_eq!((peak.joint, peak.quantity), (1, Quantity::Speed));
    assert_eq!(peak.limit, 2.9);
    assert!((peak.value - 1.875 * d / duration).abs() < 1e-12);
    assert!((peak.at_s - duration / 2.0).abs() < 1e-7);

    let peak = refused(100.0, 18.0);
    assert_eq!((peak.joint, peak.quantity), (1, Quantity::Acceleration));
    let known = 10.0 / 3.0_f64.sqrt() * d / duration.powi(2);
    assert!((peak.value.abs() - known).abs() < 1e-12);
    let early = duration * (0.5 - 1.0 / 12.0_f64.sqrt());
    let late = duration - early;
    assert!((peak.at_s - early).abs().min((peak.at_s - late).abs()) < 1e-7);
}

#[test]
fn the_shortest_duration_touches_a_bound() {
    for seed in 0..200 {
        let mut random = Random::seeded(seed);
        let (from, to) = (random.vector(1.4), random.vector(1.4));
        let trajectory = Trajectory::plan(Reference::at_rest(from), &shape(to, None), &ARM);
        let duration = trajectory.as_ref().unwrap().duration_s();
        let d = (to - from).amax();
        let known = (1.875 * d / ARM.speed_rad_s)
            .max((10.0 / 3.0_f64.sqrt() * d / ARM.acceleration_rad_s2).sqrt());
        assert!((duration / known - 1.0).abs() < 2e-4, "{duration} {known}");
    }
}

#[test]
fn continuous_at_every_switch_and_within_the_bounds_from_any_motion() {
    let mut planned = 0;
    for seed in 0..300 {
        let mut random = Random::seeded(seed);
        let mut in_force = Trajectory::hold(random.vector(1.0));
        for _ in 0..4 {
            let switch = random.within(0.0, 1.2) * in_force.duration_s();
            let from = in_force.at(switch);
            let Ok(next) = Trajectory::plan(from, &shape(random.vector(1.2), None), &ARM) else {
                // A fast start close to a limit may leave no way out.
                continue;
            };
            planned += 1;
            assert!(gap(&next.at(0.0), &from) < 1e-12);
            assert!(sampled_ratio(&next, &ARM) < 1.0 + 1e-4);
            let end = next.duration_s();
            assert_smooth(&next, &[end], 1.0 + 60.0 / end.powi(3));
            in_force = next;
        }
    }
    assert!(planned > 1100, "{planned}");
}

#[test]
fn peaks_are_those_of_fine_samples() {
    for seed in 0..300 {
        let mut random = Random::seeded(seed);
        let (from, to) = (random.reference(), random.vector(1.0));
        let duration = random.within(0.1, 3.0);
        let any = Trajectory::plan(from, &shape(to, Some(duration)), &WIDE).unwrap();
        // Bounds of one on everything make ratios of values.
        let one = Bounds {
            angle_rad: 1.0,
            speed_rad_s: 1.0,
            acceleration_rad_s2: 1.0,
            jerk_rad_s3: 1e9,
        };
        let mut tightest = PeakTracker::new(&one);
        any.show(&mut tightest);
        let sampled = sampled_ratio(&any, &one);
        assert!(tightest.ratio() >= sampled - 1e-9);
        assert!(tightest.ratio() <= sampled * 1.001);
    }
}

#[test]
fn no_distance_takes_no_time_and_no_way_is_said_so() {
    let still = Reference::at_rest(Vector2::new(0.5, 0.5));
    let stay = Trajectory::plan(still, &shape(still.q, None), &ARM).unwrap();
    assert!((stay.duration_s() - DURATION_MIN_S).abs() < 1e-9);
    let falling = Reference {
        dq: Vector2::new(4.0, 0.0),
        ..still
    };
    let refused = Trajectory::plan(falling, &shape(still.q, None), &ARM);
    let Err(Error::NoDuration(peak)) = refused else {
        panic!("{refused:?}");
    };
    assert_eq!((peak.joint, peak.quantity), (0, Quantity::Speed));
}

#[test]
fn f32_agrees_with_f64() {
    let bounds = Bounds {
        angle_rad: 1.5_f32,
        speed_rad_s: 50.0,
        acceleration_rad_s2: 1e4,
        jerk_rad_s3: 1e9,
    };
    for seed in 0..200 {
        let mut random = Random::seeded(seed);
        let from = Reference {
            q: random.vector(0.5),
            ..random.reference()
        };
        let (to, duration) = (random.vector(0.5), random.within(0.2, 1.0));
        let exact = Trajectory::plan(from, &shape(to, Some(duration)), &WIDE).unwrap();
        let to = Shape::MinimumJerk {
            to: to.cast::<f32>(),
            duration_s: Some(duration as f32),
        };
        let close = Trajectory::plan(single(&from), &to, &bounds).unwrap();
        for i in 0..100 {
            let t = duration * f64::from(i) / 100.0;
            let (a, b) = (exact.at(t), close.at(t as f32));
            assert!((a.q - b.q.cast::<f64>()).amax() < 1e-5);
            assert!((a.dq - b.dq.cast::<f64>()).amax() < 1e-4);
            assert!((a.ddq - b.ddq.cast::<f64>()).amax() < 2e-3);
        }
    }
}
