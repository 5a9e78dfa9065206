//! Acceptance and refusal of a stream's points, and its bounds.

use super::*;

#[test]
fn resumes_from_braking_and_refuses_what_cannot_be_reached() {
    let mut stream = at_rest(Vector2::zeros());
    for i in 1..=4 {
        stream
            .push(START_US, point(START_US + i * 50_000, true))
            .unwrap();
    }
    run(&mut stream, 0..220, 3.0, |_, _, _| {});
    assert_eq!(stream.phase(), Phase::Braking);
    // Far away within 5 ms: not with this arm; a second later: yes.
    let now_us = START_US + 220 * TICK_US;
    let mut push = |ahead_us, q| {
        stream.push(
            now_us,
            Point {
                at_us: now_us + ahead_us,
                q: Vector2::new(q, 0.0),
                dq: None,
            },
        )
    };
    let refused = push(5_000, 0.9);
    assert!(
        matches!(
            refused,
            Err(stream::Error::Exceeds(Peak { joint: 0, quantity: Quantity::Acceleration, value, limit: 30.0, .. }))
                if value.abs() > 1e4
        ),
        "{refused:?}"
    );
    push(1_000_000, 0.91).unwrap();
    run(&mut stream, 220..2000, 3.0, |_, _, r| {
        assert!(r.ddq.amax() <= ARM.acceleration_rad_s2);
    });
    let end = stream.advance(START_US + 3_000_000);
    assert!((end.q - Vector2::new(0.91, 0.0)).amax() < 1e-12);
}

/// Two points 10 ms apart, and a constant speed that ends: neither may lead beyond the bounds.
#[test]
fn what_was_accepted_beyond_the_bounds_is_refused_or_braked() {
    let mut stream = at_rest(Vector2::zeros());
    let at = |ms: u64, q: f64, dq| Point {
        at_us: START_US + ms * 1_000,
        q: Vector2::new(q, 0.0),
        dq,
    };
    stream.push(START_US, at(500, 0.2, None)).unwrap();
    let refused = stream.push(START_US, at(510, 0.3, None));
    let Err(stream::Error::Exceeds(peak)) = refused else {
        panic!("{refused:?}");
    };
    assert_eq!(
        (peak.joint, peak.quantity, peak.limit),
        (0, Quantity::Acceleration, 30.0)
    );
    assert!(peak.value.abs() > 100.0, "{peak:?}");

    // 0.5 rad/s, with and without the speed, until no point follows.
    for speed in [Some(Vector2::new(0.5, 0.0)), None] {
        let mut stream = at_rest(Vector2::new(0.085, 0.0));
        let mut next = 0;
        let mut push = |stream: &mut Stream<f64>, now_us: u64| {
            while next < 50 && START_US + 500_000 + next * 10_000 < now_us + 60_000 {
                let point = at(500 + next * 10, 0.1 + 0.005 * next as f64, speed);
                stream.push(now_us, point).unwrap();
                next += 1;
            }
        };
        push(&mut stream, START_US + 440_000);
        let (mut last, mut most) = (List::new(), 0.0_f64);
        run(&mut stream, 440..2_000, 4.01, |stream, now_us, r| {
            push(stream, now_us);
            if now_us > START_US + 600_000 {
                last.push(r.ddq.x);
                let four_before = last.len().checked_sub(5).map_or(r.ddq.x, |at| last[at]);
                most = most.max((r.ddq.x - four_before).abs());
            }
        });
        assert_eq!(stream.phase(), Phase::Resting);
        // Of the bound of 30: a reversal would be 60.
        assert!(most < 8.0, "{speed:?}: {most} rad/s2 within four ticks");
    }
}

/// Whatever a host sends, at whatever times: refused points are left out, and the rest
/// moves within the bounds, by its own account and by differences.
#[test]
fn whatever_is_accepted_stays_within_the_bounds() {
    const TIGHT: f64 = 1.000_11;
    let (mut accepted, mut refused, mut brakes) = (0_u32, 0_u32, 0_u32);
    for seed in 0..300 {
        let mut random = Random::seeded(seed);
        let mut stream = at_rest(random.vector(0.5));
        let mut q = stream.at(START_US).q;
        let mut next_us = START_US;
        let spacing_us = [1_000.0, 5_000.0, 20_000.0, 100_000.0][(seed % 4) as usize];
        // From smooth to wild.
        let spread = 10.0_f64.powf(random.within(-3.0, 0.0));
        let mut v = Vector2::zeros();
        let mut recent: List<Reference<f64>> = List::new();
        let mut was_following = false;
        for tick in 0..1_500_u64 {
            let now_us = START_US + tick * TICK_US;
            let is_silent = (tick / 300) % 2 == 1;
            while !is_silent && next_us < now_us + 60_000 {
                let gap_us = random.within(1_000.0, 2.0 * spacing_us) as u64;
                next_us = next_us.max(now_us) + gap_us;
                v = v * 0.9 + random.vector(spread * 5.0) * 0.3;
                q += v * (gap_us as f64 * 1e-6);
                let dq = (random.unit() < 0.5).then_some(v);
                match stream.push(
                    now_us,
                    Point {
                        at_us: next_us,
                        q,
                        dq,
                    },
                ) {
                    Ok(()) => accepted += 1,
                    Err(stream::Error::Full) => break,
                    Err(_) => {
                        refused += 1;
                        q = stream.at(now_us).q;
                        v = Vector2::zeros();
                    }
                }
            }
            let r = stream.advance(now_us);
            assert!(r.q.amax() <= ARM.angle_rad * TIGHT, "{seed} {tick}: {r:?}");
            assert!(
                r.dq.amax() <= ARM.speed_rad_s * TIGHT,
                "{seed} {tick}: {r:?}"
            );
            assert!(
                r.ddq.amax() <= ARM.acceleration_rad_s2 * TIGHT,
                "{seed} {tick}: {r:?}"
            );
            brakes += u32::from(was_following && stream.phase() == Phase::Braking);
            let is_ending = !was_following && stream.phase() != Phase::Following;
            was_following = stream.phase() == Phase::Following;
            if let [.., two_before, before] = recent[..] {
                let h = TICK_US as f64 * 1e-6;
                let speed = (r.q - before.q).amax() / h;
                let second = (r.q - before.q * 2.0 + two_before.q).amax() / (h * h);
                assert!(speed <= ARM.speed_rad_s * TIGHT, "{seed} {tick}: {speed}");
                assert!(
                    second <= ARM.acceleration_rad_s2 * TIGHT + 1e-6,
                    "{seed} {tick}: {second}"
                );
                if is_ending {
                    let jerk = (r.ddq - before.ddq).amax() / h;
                    assert!(jerk <= ARM.jerk_rad_s3 * TIGHT, "{seed} {tick}: {jerk}");
                }
            }
            recent.push(r);
        }
    }
    std::println!("{accepted} points accepted, {refused} refused, {brakes} times braked");
    assert!(accepted > 3_000 && refused > 3_000 && brakes > 100);
}

/// The check that a stream makes agrees with the exact extremes.
#[test]
fn the_cheap_check_is_the_exact_one() {
    use super::super::bounds::PeakTracker;
    use super::super::quintic::Quintic;
    let (mut within, mut beyond) = (0, 0);
    for seed in 0..5_000 {
        let mut random = Random::seeded(seed);
        let (from, to) = (random.reference(), random.reference());
        let duration_s = 10.0_f64.powf(random.within(-2.0, 0.5));
        let quintic = Quintic::joining(&from, &to, duration_s);
        let bounds = Bounds {
            speed_rad_s: random.within(1.0, 20.0),
            acceleration_rad_s2: random.within(4.0, 200.0),
            ..ARM
        };
        let mut tightest = PeakTracker::new(&bounds);
        quintic.show(0.0, duration_s, &mut tightest);
        let checked = quintic.check(duration_s, &bounds, false);
        assert_eq!(
            checked.is_ok(),
            tightest.verdict().is_ok(),
            "{seed}: {checked:?} {tightest:?}"
        );
        within += u32::from(checked.is_ok());
        beyond += u32::from(checked.is_err());
    }
    assert!(within > 200 && beyond > 200, "{within} {beyond}");
}

#[test]
fn refusals_leave_the_points_that_are_there() {
    let mut stream = at_rest(Vector2::zeros());
    let q = Vector2::new(0.1, 0.1);
    let at = |at_us, q, dq| Point { at_us, q, dq };
    let later = START_US + 1_000_000;
    let mut push = |point| stream.push(START_US, point);
    for bad in [f64::NAN, f64::INFINITY] {
        let vector = Vector2::new(0.0, bad);
        assert_eq!(push(at(later, vector, None)), Err(stream::Error::NotFinite));
        assert_eq!(
            push(at(later, q, Some(vector))),
            Err(stream::Error::NotFinite)
        );
    }
    for at_us in [0, START_US, START_US + SPACING_MIN_US - 1] {
        let by_us = START_US + SPACING_MIN_US - at_us;
        assert_eq!(push(at(at_us, q, None)), Err(stream::Error::Late { by_us }));
    }
    let exceeds = |refused: Result<(), stream::Error<f64>>, joint, quantity, value: f64| {
        let Err(stream::Error::Exceeds(peak)) = refused else {
            panic!("{refused:?}");
        };
        assert_eq!((peak.joint, peak.quantity), (joint, quantity), "{peak:?}");
        assert!(
            value.abs() <= peak.value.abs() + 1e-9 && peak.limit < value.abs(),
            "{peak:?}"
        );
    };
    let far = Vector2::new(0.0, -1.6);
    exceeds(push(at(later, far, None)), 1, Quantity::Angle, -1.6);
    let fast = Some(Vector2::new(5.1, 0.0));
    exceeds(push(at(later, q, fast)), 0, Quantity::Speed, 5.1);
    assert_eq!(push(at(later, q, None)), Ok(()));
    for at_us in [later - 1000, later, later + SPACING_MIN_US - 1] {
        let by_us = later + SPACING_MIN_US - at_us;
        assert_eq!(push(at(at_us, q, None)), Err(stream::Error::Late { by_us }));
    }
    let apart = q + Vector2::new(0.1, 0.0);
    exceeds(
        push(at(later + 10_000, apart, None)),
        0,
        Quantity::Acceleration,
        200.0,
    );
    for i in 1..POINTS_MAX as u64 {
        assert_eq!(push(at(later + i * 1000, q, None)), Ok(()));
    }
    assert_eq!(push(at(later + 50_000, q, None)), Err(stream::Error::Full));
    assert_eq!(stream.points(), POINTS_MAX);

    let still = Reference::at_rest(q);
    let bounds = Bounds {
        speed_rad_s: -1.0,
        ..ARM
    };
    let refused = Stream::new(&still, 0, &bounds).map(|_| ());
    assert_eq!(refused, Err(Error::NoRoom(Quantity::Speed)));
}
