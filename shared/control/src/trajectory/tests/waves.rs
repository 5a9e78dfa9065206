//! Sinusoids and chirps.

use super::*;

fn sinusoid(random: &mut Random) -> Shape<f64> {
    Shape::Sinusoid {
        centre: random.vector(0.5),
        amplitude_rad: random.vector(0.5),
        frequency_hz: Vector2::new(random.within(0.0, 3.0), random.within(0.0, 3.0)),
        phase_rad: random.vector(20.0),
        ramp_s: 1.0,
        duration_s: random.within(4.0, 8.0),
    }
}

fn chirp(random: &mut Random) -> Shape<f64> {
    Shape::Chirp {
        centre: random.vector(0.5),
        amplitude_rad: random.vector(0.3),
        from_hz: Vector2::new(random.within(0.0, 1.0), random.within(0.0, 4.0)),
        to_hz: Vector2::new(random.within(0.0, 5.0), random.within(0.0, 1.0)),
        ramp_s: 1.5,
        duration_s: random.within(4.0, 8.0),
    }
}

#[test]
fn continuous_from_any_motion_to_rest_and_derivatives_are_derivatives() {
    for seed in 0..100 {
        let mut random = Random::seeded(seed);
        let from = random.reference();
        for (shape, ramp) in [(sinusoid(&mut random), 1.0), (chirp(&mut random), 1.5)] {
            let trajectory = Trajectory::plan(from, &shape, &WIDE).unwrap();
            let end = trajectory.duration_s();
            assert!(gap(&trajectory.at(0.0), &from) < 1e-12);
            let (Shape::Sinusoid { centre, .. } | Shape::Chirp { centre, .. }) = shape else {
                unreachable!()
            };
            assert_eq!(trajectory.at(end), Reference::at_rest(centre));
            // A third derivative of 0.5 (2 pi 5 Hz)^3, by the square of the step.
            assert_smooth(&trajectory, &[ramp, end - ramp, end], 100.0);
        }
    }
}

#[test]
fn between_the_ramps_it_is_the_sinusoid_that_was_asked_for() {
    let (centre, amplitude) = (Vector2::new(0.1, -0.2), Vector2::new(0.4, 0.5));
    let (frequency, phase) = (Vector2::new(0.25, 0.3), Vector2::new(0.7, -9.0));
    let shape = Shape::Sinusoid {
        centre,
        amplitude_rad: amplitude,
        frequency_hz: frequency,
        phase_rad: phase,
        ramp_s: 2.0,
        duration_s: 300.0,
    };
    let trajectory = Trajectory::plan(Reference::at_rest(centre), &shape, &WIDE).unwrap();
    for i in 0..2960 {
        let t = 2.0 + f64::from(i) * 0.1;
        let r = trajectory.at(t);
        for joint in 0..2 {
            let omega = TAU * frequency[joint];
            let (sin, cos) = (omega * t + phase[joint]).sin_cos();
            let a = amplitude[joint];
            assert!((r.q[joint] - centre[joint] - a * sin).abs() < 1e-12);
            assert!((r.dq[joint] - a * omega * cos).abs() < 1e-12);
            assert!((r.ddq[joint] + a * omega * omega * sin).abs() < 1e-12);
        }
    }
}

#[test]
fn a_chirp_sweeps_linearly() {
    let shape = Shape::Chirp {
        centre: Vector2::zeros(),
        amplitude_rad: Vector2::new(0.1, 0.0),
        from_hz: Vector2::new(0.5, 0.0),
        to_hz: Vector2::new(4.5, 0.0),
        ramp_s: 1.0,
        duration_s: 20.0,
    };
    let start = Reference::at_rest(Vector2::zeros());
    let trajectory = Trajectory::plan(start, &shape, &WIDE).unwrap();
    for i in 0..180 {
        let t = 1.0 + f64::from(i) * 0.1;
        let phase = TAU * (0.5 * t + 0.1 * t * t);
        let r = trajectory.at(t);
        assert!((r.q.x - 0.1 * phase.sin()).abs() < 1e-12);
        assert_eq!(r.q.y, 0.0);
    }
}

#[test]
fn bounds_hold_at_all_times() {
    let bounds = Bounds {
        angle_rad: 1.0,
        speed_rad_s: 4.0,
        acceleration_rad_s2: 30.0,
        jerk_rad_s3: 1e9,
    };
    let (mut passed, mut refused) = (0, 0);
    for seed in 0..300 {
        let mut random = Random::seeded(seed);
        let from = Reference::at_rest(random.vector(0.5));
        for shape in [sinusoid(&mut random), chirp(&mut random)] {
            match Trajectory::plan(from, &shape, &bounds) {
                Ok(trajectory) => {
                    passed += 1;
                    assert!(sampled_ratio(&trajectory, &bounds) < 1.0 + 2e-4);
                }
                Err(Error::Exceeds(peak)) => {
                    refused += 1;
                    // Real, or nearly: the worst phase comes up in seconds.
                    let any = Trajectory::plan(from, &shape, &WIDE).unwrap();
                    let real = sampled_ratio(&any, &bounds);
                    let said = peak.value.abs() / peak.limit;
                    assert!(real <= said * 1.001, "{real} {peak:?}");
                }
                Err(other) => panic!("{other:?}"),
            }
        }
    }
    assert!(passed > 50 && refused > 50, "{passed} {refused}");
}

#[test]
fn the_peak_of_a_steady_wave_is_its_amplitude() {
    let wave = |amplitude_rad| Shape::Sinusoid {
        centre: Vector2::zeros(),
        amplitude_rad,
        frequency_hz: Vector2::new(1.0, 1.0),
        phase_rad: Vector2::zeros(),
        ramp_s: 5.0,
        duration_s: 20.0,
    };
    let bounds = Bounds {
        angle_rad: 0.5,
        ..WIDE
    };
    let start = Reference::at_rest(Vector2::zeros());
    assert!(Trajectory::plan(start, &wave(Vector2::new(0.5, -0.5)), &bounds).is_ok());
    let refused = Trajectory::plan(start, &wave(Vector2::new(0.1, -0.6)), &bounds);
    let Err(Error::Exceeds(peak)) = refused else {
        panic!("{refused:?}");
    };
    assert_eq!((peak.joint, peak.quantity), (1, Quantity::Angle));
    assert!((peak.value.abs() - 0.6).abs() < 1e-12);
}

#[test]
fn f32_keeps_the_phase_for_minutes() {
    let shape = |amplitude: f64| Shape::Sinusoid {
        centre: Vector2::zeros(),
        amplitude_rad: Vector2::repeat(amplitude),
        frequency_hz: Vector2::new(2.0, 0.3),
        phase_rad: Vector2::zeros(),
        ramp_s: 1.0,
        duration_s: 300.0,
    };
    let start = Reference::at_rest(Vector2::zeros());
    let exact = Trajectory::plan(start, &shape(0.4), &WIDE).unwrap();
    let close = Trajectory::plan(
        single(&start),
        &Shape::Sinusoid {
            centre: Vector2::zeros(),
            amplitude_rad: Vector2::repeat(0.4_f32),
            frequency_hz: Vector2::new(2.0, 0.3),
            phase_rad: Vector2::zeros(),
            ramp_s: 1.0,
            duration_s: 300.0,
        },
        &Bounds {
            angle_rad: 1.0,
            speed_rad_s: 10.0,
            acceleration_rad_s2: 100.0,
            jerk_rad_s3: 1e9,
        },
    )
    .unwrap();
    for i in 0..30_000 {
        // The same instant for both: what is compared is the wave, not the clock.
        let t = i as f32 * 0.01;
        let (a, b) = (exact.at(f64::from(t)), close.at(t));
        // 600 turns in 24 bits: 3e-5 turns, 2e-4 rad of phase.
        assert!((a.q - b.q.cast::<f64>()).amax() < 1e-4, "{t}");
        assert!((a.dq - b.dq.cast::<f64>()).amax() < 1e-3, "{t}");
    }
}
