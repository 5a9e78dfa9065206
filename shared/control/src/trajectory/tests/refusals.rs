//! Every error, by what it names.

use super::*;

const ARM: Bounds<f64> = Bounds {
    angle_rad: 1.5,
    speed_rad_s: 5.0,
    acceleration_rad_s2: 50.0,
    jerk_rad_s3: 1e9,
};

fn plan(shape: &Shape<f64>) -> Result<Trajectory<f64>, Error<f64>> {
    Trajectory::plan(Reference::at_rest(Vector2::zeros()), shape, &ARM)
}

fn through(points: &[(f64, f64)]) -> Shape<f64> {
    let points = points.iter().map(|&(at_s, q)| Waypoint {
        at_s,
        q: Vector2::new(q, q),
    });
    Shape::Waypoints {
        points: points.collect(),
    }
}

fn wave(frequency: Vector2<f64>, ramp_s: f64, duration_s: f64) -> Shape<f64> {
    Shape::Sinusoid {
        centre: Vector2::zeros(),
        amplitude_rad: Vector2::new(0.01, 0.01),
        frequency_hz: frequency,
        phase_rad: Vector2::zeros(),
        ramp_s,
        duration_s,
    }
}

fn sweep(from: f64, to: f64, duration_s: f64) -> Shape<f64> {
    Shape::Chirp {
        centre: Vector2::zeros(),
        amplitude_rad: Vector2::new(0.01, 0.01),
        from_hz: Vector2::new(1.0, from),
        to_hz: Vector2::new(1.0, to),
        ramp_s: 1.0,
        duration_s,
    }
}

#[test]
fn nothing_that_is_not_finite() {
    let fine = Vector2::new(0.1, 0.1);
    let refused = Err(Error::NotFinite(Argument::Shape));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let vector = Vector2::new(0.0, bad);
        assert_eq!(plan(&Shape::Hold { q: vector }), refused);
        for (to, duration_s) in [(vector, None), (fine, Some(bad))] {
            assert_eq!(plan(&Shape::MinimumJerk { to, duration_s }), refused);
        }
        assert_eq!(plan(&through(&[(1.0, 0.1), (bad, 0.1)])), refused);
        assert_eq!(plan(&through(&[(1.0, bad)])), refused);
        for shape in [
            wave(vector, 1.0, 4.0),
            wave(fine, bad, 4.0),
            wave(fine, 1.0, bad),
            sweep(bad, 1.0, 4.0),
            sweep(1.0, bad, 4.0),
            sweep(1.0, 1.0, bad),
        ] {
            assert_eq!(plan(&shape), refused);
        }
        let still = Reference::at_rest(fine);
        for from in [
            Reference { q: vector, ..still },
            Reference {
                dq: vector,
                ..still
            },
            Reference {
                ddq: vector,
                ..still
            },
        ] {
            let refused = Trajectory::plan(from, &Shape::Hold { q: fine }, &ARM);
            assert_eq!(refused, Err(Error::NotFinite(Argument::From)));
        }
        let bounds = Bounds {
            speed_rad_s: bad,
            ..ARM
        };
        let refused = Trajectory::plan(still, &Shape::Hold { q: fine }, &bounds);
        assert_eq!(refused, Err(Error::NotFinite(Argument::Bounds)));
    }
}

#[test]
fn bounds_leave_room() {
    let hold = Shape::Hold {
        q: Vector2::zeros(),
    };
    let bounds = Bounds {
        acceleration_rad_s2: 0.0,
        ..ARM
    };
    let refused = Trajectory::plan(Reference::at_rest(Vector2::zeros()), &hold, &bounds);
    assert_eq!(refused, Err(Error::NoRoom(Quantity::Acceleration)));
}

#[test]
fn durations_ramps_and_frequencies() {
    let to = Vector2::new(0.1, 0.1);
    for value_s in [-1.0, 0.0, 1e-4, 601.0] {
        let refused = Err(Error::Duration { value_s });
        let duration_s = Some(value_s);
        assert_eq!(plan(&Shape::MinimumJerk { to, duration_s }), refused);
        assert_eq!(plan(&wave(to, 1.0, value_s)), refused);
        assert_eq!(plan(&sweep(1.0, 2.0, value_s)), refused);
    }
    for value_s in [-1.0, 0.0, 2.1] {
        let refused = Err(Error::Ramp { value_s });
        assert_eq!(plan(&wave(to, value_s, 4.0)), refused);
    }
    for value_hz in [-0.1, 50.1] {
        let refused = Err(Error::Frequency { joint: 1, value_hz });
        assert_eq!(plan(&wave(Vector2::new(1.0, value_hz), 1.0, 4.0)), refused);
        assert_eq!(plan(&sweep(value_hz, 1.0, 4.0)), refused);
        assert_eq!(plan(&sweep(1.0, value_hz, 4.0)), refused);
    }
}

#[test]
fn waypoints_in_order() {
    assert_eq!(plan(&through(&[])), Err(Error::NoWaypoints));
    for (points, waypoint) in [
        (&[(0.0, 0.1)][..], 0),
        (&[(-1.0, 0.1)], 0),
        (&[(1.0, 0.1), (1.0, 0.2)], 1),
        (&[(1.0, 0.1), (2.0, 0.2), (1.5, 0.3)], 2),
        (&[(1.0, 0.1), (601.0, 0.2)], 1),
    ] {
        let refused = Err(Error::WaypointTime { waypoint });
        assert_eq!(plan(&through(points)), refused);
    }
}

#[test]
fn a_hold_out_of_bounds_and_numbers_that_overflow() {
    let refused = plan(&Shape::Hold {
        q: Vector2::new(0.0, -1.6),
    });
    let Err(Error::Exceeds(peak)) = refused else {
        panic!("{refused:?}");
    };
    assert_eq!(peak.value, -1.6);
    assert_eq!(
        (peak.joint, peak.quantity, peak.limit),
        (1, Quantity::Angle, 1.5)
    );
    let to = Vector2::new(f32::MAX, 0.0);
    let bounds = Bounds {
        angle_rad: 1.5_f32,
        speed_rad_s: 5.0,
        acceleration_rad_s2: 50.0,
        jerk_rad_s3: 1e9,
    };
    for duration_s in [Some(1e-3), Some(1.0), None] {
        let from = Reference::at_rest(Vector2::zeros());
        let shape = Shape::MinimumJerk { to, duration_s };
        let refused = Trajectory::plan(from, &shape, &bounds);
        assert!(
            matches!(refused, Err(Error::Exceeds(_) | Error::NoDuration(_))),
            "{refused:?}"
        );
    }
}

#[test]
fn a_hold_does_not_care_where_the_arm_is() {
    let q = Vector2::new(0.3, -0.4);
    let moving = Random::seeded(1).reference();
    let hold = Trajectory::plan(moving, &Shape::Hold { q }, &ARM).unwrap();
    assert_eq!(hold, Trajectory::hold(q));
    assert_eq!(hold.at(0.0), Reference::at_rest(q));
    assert_eq!(hold.duration_s(), 0.0);
}
