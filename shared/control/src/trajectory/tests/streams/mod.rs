//! Streams: interpolation, starvation, joining; what is accepted and refused.

mod acceptance;

use super::*;
use crate::trajectory::stream::{self, POINTS_MAX, Phase, Point, SPACING_MIN_US, Stream};

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
