//! Values of options, read from their text.

/// Longest run: a day.
const DURATION_MAX_S: f64 = 86_400.0;

pub(crate) fn duration(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.1..=DURATION_MAX_S).contains(&seconds) => Ok(seconds),
        _ => Err(format!("expected seconds from 0.1 to {DURATION_MAX_S}")),
    }
}

pub(crate) fn period(text: &str) -> Result<u32, String> {
    use armbridge_board::bridge::limits::{PERIOD_MAX_US, PERIOD_MIN_US};
    match text.parse() {
        Ok(us) if (PERIOD_MIN_US..=PERIOD_MAX_US).contains(&us) => Ok(us),
        _ => Err(format!(
            "expected microseconds from {PERIOD_MIN_US} to {PERIOD_MAX_US}"
        )),
    }
}

/// Largest initial angle: inside the board's angle limit.
const INITIAL_MAX_RAD: f64 = 1.4;

pub(crate) fn angles(text: &str) -> Result<[f64; 2], String> {
    numbers(text)
        .filter(|angles: &[f64; 2]| angles.iter().all(|q| q.abs() <= INITIAL_MAX_RAD))
        .ok_or_else(|| {
            format!(
                "expected two angles from -{INITIAL_MAX_RAD} to {INITIAL_MAX_RAD} rad, as 0.3,-0.25"
            )
        })
}

/// `N` numbers with commas between.
pub(crate) fn numbers<T: std::str::FromStr + Copy, const N: usize>(text: &str) -> Option<[T; N]> {
    let numbers: Result<Vec<T>, _> = text.split(',').map(|x| x.trim().parse()).collect();
    numbers.ok()?.try_into().ok()
}

pub(crate) fn seed(text: &str) -> Result<u64, String> {
    let wrong = |_| format!("expected a whole number from 0 to {}", u64::MAX);
    text.parse().map_err(wrong)
}

/// Most seeds at once; ten minutes of work.
const SEEDS_MAX: usize = 10_000;

/// Seeds, in a type of their own: clap takes a `Vec` for repeated options.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Seeds(pub(crate) Vec<u64>);

pub(crate) fn weights<const N: usize>(text: &str) -> Result<[f32; N], String> {
    numbers(text)
        .filter(|numbers: &[f32; N]| numbers.iter().all(|x| *x >= 0.0 && x.is_finite()))
        .ok_or_else(|| format!("expected {N} numbers from 0 up, with commas between"))
}

/// Speed of a motion, relative to its own.
pub(crate) fn speed(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(factor) if (0.05..=20.0).contains(&factor) => Ok(factor),
        _ => Err("expected a factor from 0.05 to 20, as 0.5 for half as fast".into()),
    }
}

pub(crate) fn positive(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && f32::is_finite(x) => Ok(x),
        _ => Err("expected a number above 0".into()),
    }
}

pub(crate) fn not_negative(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(x) if x >= 0.0 && f32::is_finite(x) => Ok(x),
        _ => Err("expected a number from 0 up".into()),
    }
}

pub(crate) fn seeds(text: &str) -> Result<Seeds, String> {
    let seeds: Option<Vec<u64>> = match text.split_once("..") {
        Some((first, last)) => first
            .parse()
            .ok()
            .zip(last.trim_start_matches('=').parse().ok())
            .filter(|(first, last): &(u64, u64)| last.saturating_sub(*first) < SEEDS_MAX as u64)
            .map(|(first, last)| (first..=last).collect()),
        None => text
            .split(',')
            .map(|seed| seed.trim().parse().ok())
            .collect(),
    };
    seeds
        .filter(|seeds| (1..=SEEDS_MAX).contains(&seeds.len()))
        .map(Seeds)
        .ok_or_else(|| format!("expected seeds as 1..20 or 1,2,3, at most {SEEDS_MAX}"))
}
