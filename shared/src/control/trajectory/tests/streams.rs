//! Interpolation, starvation, joining, refusals.

use super::*;
use crate::control::trajectory::stream::{self, POINTS_MAX, Phase, Point, SPACING_MIN_US, Stream};

const ARM: Bounds<f64> = Bounds {
    angle_rad: 1.5,
    speed_rad_s: 5.0,
    acceleration_rad_s2: 30.0,
    jerk_rad_s3: 4_000.0,
};
const TICK_US: u64 = 1000;
const START_US: u64 = 5_000_000;

fn at_rest(q: Vector2<f64>) -> Stream<f64> {
    Stream::new(&Reference::at_rest(q), START_US, &ARM).unwrap()
}

/// A sinusoid that starts from rest at its turning point, since `START_US`.
fn wanted(at_us: u64) -> Reference<f64> {
    let t = (at_us - START_US) as f64 * 1e-6;
    let (a, w) = (Vector2::new(0.4, -0.5), Vector2::new(2.0, 3.0));
    let each = |f: fn(f64, f64, f64) -> f64| Vector2::new(f(a.x, w.x, t), f(a.y, w.y, t));
    Reference {
        q: each(|a, w, t| a * (1.0 - (w * t).cos())),
        dq: each(|a, w, t| a * w * (w * t).sin()),
        ddq: each(|a, w, t| a * w * w * (w * t).cos()),
    }
}

fn point(at_us: u64, with_speed: bool) -> Point<f64> {
    let Reference { q, dq, .. } = wanted(at_us);
    let dq = with_speed.then_some(dq);
    Point { at_us, q, dq }
}

/// Runs ticks; asserts that acceleration never jumps by more than `jump`, and that
/// the angle moves according to speed and acceleration.
fn run(
    stream: &mut Stream<f64>,
    ticks: core::ops::Range<u64>,
    jump: f64,
    mut each: impl FnMut(&mut Stream<f64>, u64, Reference<f64>),
) {
    let h = TICK_US as f64 * 1e-6;
    let mut last: Option<Reference<f64>> = None;
    for tick in ticks {
        let now_us = START_US + tick * TICK_US;
        let r = stream.advance(now_us);
        if let Some(last) = last {
            let step = (r.ddq - last.ddq).amax();
            assert!(step < jump, "tick {tick}: {step}");
            let speed = (r.dq - last.dq - (r.ddq + last.ddq) * (h / 2.0)).amax();
            let angle = (r.q - last.q - (r.dq + last.dq) * (h / 2.0)).amax();
            // Half the change of slope at most, over a tick.
            assert!(speed <= jump * h && angle <= jump * h * h, "tick {tick}");
        }
        last = Some(r);
        each(stream, now_us, r);
    }
}

#[test]
fn follows_what_the_host_samples() {
    // Every 20 ms, three points ahead.
    const EVERY_US: u64 = 20_000;
    for (with_speed, tolerance) in [(true, [1e-5, 1e-3]), (false, [1e-4, 1e-2])] {
        let mut stream = at_rest(Vector2::zeros());
        let mut next_us = START_US + EVERY_US;
        let (mut angle, mut speed): (f64, f64) = (0.0, 0.0);
        for ahead in 0..3 {
            let at_us = next_us + ahead * EVERY_US;
            stream.push(START_US, point(at_us, with_speed)).unwrap();
        }
        run(&mut stream, 0..3000, 2.0, |stream, now_us, r| {
            let truth = wanted(now_us);
            // It starts without the acceleration that the truth starts with.
            if now_us > START_US + 2 * EVERY_US {
                angle = angle.max((r.q - truth.q).amax());
                speed = speed.max((r.dq - truth.dq).amax());
            }
            if now_us >= next_us {
                next_us += EVERY_US;
                let at_us = next_us + 2 * EVERY_US;
                stream.push(now_us, point(at_us, with_speed)).unwrap();
            }
            assert_eq!(stream.phase(), Phase::Following);
        });
        std::println!("speed sent: {with_speed}, errors {angle:e} rad, {speed:e} rad/s");
        assert!(
            angle < tolerance[0] && speed < tolerance[1],
            "{angle:e} {speed:e}"
        );
    }
}

#[test]
fn starved_it_brakes_within_the_bounds_and_rests() {
    let mut stream = at_rest(Vector2::zeros());
    for i in 1..=6 {
        stream
            .push(START_US, point(START_US + i * 50_000, true))
            .unwrap();
    }
    let last = wanted(START_US + 300_000);
    let mut phases = List::new();
    let mut end = last;
    run(&mut stream, 0..2000, 3.0, |stream, _, r| {
        if phases.last() != Some(&stream.phase()) {
            phases.push(stream.phase());
        }
        assert!(r.ddq.amax() <= ARM.acceleration_rad_s2);
        end = r;
    });
    assert_eq!(phases, [Phase::Following, Phase::Braking, Phase::Resting]);
    assert_eq!(end, Reference::at_rest(end.q));
    // On in the direction of motion, no further than a braking distance.
    for joint in 0..2 {
        let run = (end.q - last.q)[joint] * last.dq[joint].signum();
        assert!((0.0..0.2).contains(&run), "{run}");
    }
    assert_eq!(stream.points(), 0);
}

#[test]
fn braking_stays_within_its_bounds_from_any_motion() {
    for seed in 0..500 {
        let mut random = Random::seeded(seed);
        let from = Reference {
            q: random.vector(0.5),
            dq: random.vector(ARM.speed_rad_s / 2.0),
            ddq: random.vector(ARM.acceleration_rad_s2),
        };
        let mut stream = Stream::new(&from, START_US, &ARM).unwrap();
        assert_eq!(stream.phase(), Phase::Braking);
        run(&mut stream, 0..800, 10.0, |_, _, r| {
            assert!(r.ddq.amax() <= ARM.acceleration_rad_s2 * 1.0001, "{seed}");
            assert!(r.q.amax() <= ARM.angle_rad);
        });
        assert_eq!(stream.phase(), Phase::Resting);
    }
}

#[test]
fn braking_ends_at_the_bound_on_angles() {
    let from = Reference {
        q: Vector2::new(1.4, 0.0),
        dq: Vector2::new(2.0, 0.0),
        ddq: Vector2::zeros(),
    };
    let mut stream = Stream::new(&from, START_US, &ARM).unwrap();
    let mut end = from;
    run(&mut stream, 0..1000, 5.0, |_, _, r| end = r);
    assert!((end.q.x - ARM.angle_rad).abs() < 1e-12, "{}", end.q);
}

#[test]
fn a_last_point_without_a_speed_is_approached_to_rest() {
    let mut stream = at_rest(Vector2::zeros());
    let q = Vector2::new(0.3, -0.2);
    let at_us = START_US + 500_000;
    stream.push(START_US, Point { at_us, q, dq: None }).unwrap();
    let mut end = Reference::at_rest(Vector2::zeros());
    run(&mut stream, 0..600, 1.0, |_, _, r| end = r);
    assert_eq!(end.dq, Vector2::zeros());
    assert!((end.q - q).amax() < 1e-12);
    assert_eq!(stream.phase(), Phase::Resting);
}

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

#[test]
fn no_time_is_too_strange() {
    let mut stream = at_rest(Vector2::zeros());
    for i in 1..=POINTS_MAX as u64 {
        stream
            .push(START_US, point(START_US + i * 10_000, true))
            .unwrap();
    }
    // Back in time, far ahead, to the end of the clock: always an answer.
    for now_us in [0, START_US + 35_000, START_US, u64::MAX, u64::MAX, 0] {
        assert!(stream.advance(now_us).is_finite());
    }
    assert_eq!(stream.phase(), Phase::Resting);
}

#[test]
fn f32_agrees_with_f64() {
    const EVERY_US: u64 = 20_000;
    let mut exact = at_rest(Vector2::zeros());
    let bounds = Bounds {
        angle_rad: 1.5_f32,
        speed_rad_s: 5.0,
        acceleration_rad_s2: 30.0,
        jerk_rad_s3: 4_000.0,
    };
    let still = Reference::at_rest(Vector2::zeros());
    let mut close = Stream::new(&still, START_US, &bounds).unwrap();
    let (mut next_us, mut worst): (u64, [f64; 3]) = (START_US + EVERY_US, [0.0; 3]);
    for tick in 0..3000 {
        let now_us = START_US + tick * TICK_US;
        // Three points ahead, and none after two seconds: it brakes.
        while next_us <= now_us + 3 * EVERY_US && tick < 2000 {
            let point = point(next_us, true);
            exact.push(now_us, point).unwrap();
            let (at_us, q, dq) = (point.at_us, point.q.cast(), point.dq.map(Vector2::cast));
            close.push(now_us, Point { at_us, q, dq }).unwrap();
            next_us += EVERY_US;
        }
        let (a, b) = (exact.advance(now_us), close.advance(now_us));
        assert_eq!(exact.phase(), close.phase());
        let errors = [
            (a.q - b.q.cast::<f64>()).amax(),
            (a.dq - b.dq.cast::<f64>()).amax(),
            (a.ddq - b.ddq.cast::<f64>()).amax(),
        ];
        for (worst, error) in worst.iter_mut().zip(errors) {
            *worst = worst.max(error);
        }
    }
    assert_eq!(close.phase(), Phase::Resting);
    // Acceleration is the second difference of angles 20 ms apart: what their last
    // digit is worth, by 1/(20 ms)^2 and the 60 of the quintic.
    let [q, dq, ddq] = worst;
    assert!(q < 2e-6 && dq < 1e-4 && ddq < 3e-2, "{worst:?}");
}
