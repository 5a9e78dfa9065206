//! Distribution of the cases over seeds.

use super::*;
use std::collections::HashMap;

#[test]
fn kinds_pairs_and_activities_take_turns() {
    let kinds = Kind::ALL.len();
    let pairs_count = kinds * (kinds - 1) / 2;
    let mut singles = HashMap::new();
    let mut pairs = HashMap::new();
    for seed in 0..24 * pairs_count as u64 {
        let case = Case::new(seed);
        match case.injections.as_slice() {
            [only] => *singles.entry((only.kind, case.activity)).or_insert(0) += 1,
            [a, b] => {
                let mut names = [a.kind.name(), b.kind.name()];
                names.sort_unstable();
                *pairs.entry((names, case.activity)).or_insert(0) += 1;
            }
            _ => panic!("{case:?}"),
        }
    }
    assert_eq!((singles.len(), pairs.len()), (kinds * 12, pairs_count * 12));
    let of_each = pairs_count / kinds;
    assert!(
        singles
            .values()
            .all(|n| (of_each..=of_each + 1).contains(n))
    );
    assert!(pairs.values().all(|cases| *cases == 1));
}

#[test]
fn a_case_depends_on_its_seed_alone_and_comes_to_every_set_up() {
    let mut set_ups = HashMap::new();
    let mut early = 0;
    for seed in 0..4_000 {
        let case = Case::new(seed);
        assert_eq!(case, Case::new(seed));
        *set_ups
            .entry(format!("{:?} {:?}", case.bus, case.set_up))
            .or_insert(0) += 1;
        let begins = |origin| case.injections.iter().any(|i| i.origin == origin);
        early += usize::from(begins(Origin::PowerUp));
        let latest_us = case.injections.iter().map(|i| i.after_us).max();
        assert!(latest_us < Some(4_200_000));
    }
    let all: usize = Bus::all()
        .map(|bus| (bus.set_ups(Activity::Regulate).len(), bus))
        .fold((0, None), |(sum, last), (len, bus)| match last {
            Some(before) if before == bus => (sum, last),
            _ => (sum + len, Some(bus)),
        })
        .0;
    assert_eq!(set_ups.len(), all);
    assert!(early > 4_000 / 8, "{early}");
}

#[test]
fn a_given_activity_leaves_drawn_cases_as_they_are() {
    let (mut led, mut buses) = (0, std::collections::HashSet::new());
    for seed in 0..1_000 {
        let drawn = Case::new(seed);
        assert!(
            drawn.activity != Activity::Float && !drawn.is_led,
            "{drawn:?}"
        );
        assert_eq!(Case::with_activity(seed, Some(drawn.activity)), drawn);
        let float = Case::with_activity(seed, Some(Activity::Float));
        assert!(float.activity.permits(float.set_up.period_us), "{float:?}");
        let kinds = |case: &Case| case.injections.iter().map(|it| it.kind).collect::<Vec<_>>();
        assert_eq!(kinds(&float), kinds(&drawn));
        led += u32::from(float.is_led);
        buses.insert(float.bus.to_string());
    }
    assert!((450..550).contains(&led), "{led}");
    // A tick over stock servos at 57 600 baud takes more than 5 ms, and one over others at it.
    assert_eq!(buses.len(), 6, "{buses:?}");
}
