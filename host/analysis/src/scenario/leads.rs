//! Hands that lead the simulated arm.

use armbridge_sim::plant::{Grip, Lead, LeadPoint};

use super::Overrides;
use super::file::{HandKeys, HandPointKeys};
use super::mistake::{KeyPath, Mistake};
use super::steps::{microseconds, times};

/// Link that a hand holds, counting from 1.
const LINK: usize = 2;
/// Stiffness of a hand in N/m.
const STIFFNESS_N_M: f64 = 300.0;
/// Damping of a hand in N s/m.
const DAMPING_N_S_M: f64 = 10.0;
/// Smallest time from one point of a path to the next, in µs.
const LEG_MIN_US: u64 = 1_000;

/// Hands in order of time.
pub(super) fn leads(
    keys: &[HandKeys],
    end_us: u64,
    overrides: &Overrides,
) -> Result<Vec<Lead>, Mistake> {
    let mut leads: Vec<(Lead, KeyPath)> = Vec::new();
    for (number, key) in keys.iter().enumerate() {
        // A shortened run omits its last hands.
        if overrides.duration_s.is_some_and(|end_s| key.at_s >= end_s) {
            continue;
        }
        let place = KeyPath::top("bench").at("hand").nth(number);
        let at_us = microseconds(&place.at("at_s"), key.at_s)?;
        let path = path(&place.at("path"), &key.path)?;
        let release_ns = release_ns(&place.at("release_s"), key.release_s, &path)?;
        let grip = Grip {
            link: key.link.unwrap_or(LINK).saturating_sub(1),
            stiffness_n_m: key.stiffness_n_m.unwrap_or(STIFFNESS_N_M),
            damping_n_s_m: key.damping_n_s_m.unwrap_or(DAMPING_N_S_M),
        };
        let times = times(&place, at_us, key.every_s, end_us)?;
        leads.extend(times.into_iter().map(|at_us| {
            let lead = Lead {
                grip,
                start_ns: at_us * 1_000,
                path: path.clone(),
                release_ns,
            };
            (lead, place.clone())
        }));
    }
    leads.sort_by_key(|(lead, _)| lead.start_ns);
    for ((before, before_place), (lead, place)) in leads.iter().zip(leads.iter().skip(1)) {
        let free_ns = before.start_ns + before.release_ns;
        if lead.start_ns < free_ns {
            let is_repeated = before_place == place;
            let message = format!(
                "one hand leads the arm at a time, and the one before it lets go at {} s",
                free_ns as f64 * 1e-9
            );
            let key = if is_repeated { "every_s" } else { "at_s" };
            return Err(Mistake::new(place.at(key), message));
        }
    }
    Ok(leads.into_iter().map(|(lead, _)| lead).collect())
}

/// Points of a path, in order of time.
fn path(place: &KeyPath, keys: &[HandPointKeys]) -> Result<Vec<LeadPoint>, Mistake> {
    if keys.is_empty() {
        let message = "a hand has at least one point: `{ after_s = .., angle_rad = [..] }`";
        return Err(Mistake::new(place.clone(), message));
    }
    let mut before_us = 0;
    let points = keys.iter().enumerate().map(|(number, key)| {
        let at = place.nth(number).at("after_s");
        let after_us = microseconds(&at, key.after_s)?;
        if after_us < before_us + LEG_MIN_US {
            let message = "a point is at least 0.001 s after the one before it, or the start";
            return Err(Mistake::new(at, message));
        }
        before_us = after_us;
        Ok(LeadPoint {
            after_ns: after_us * 1_000,
            angle_rad: key.angle_rad,
        })
    });
    points.collect()
}

/// Time in ns after the start at which a hand lets go: by default that of its last point.
fn release_ns(place: &KeyPath, release_s: Option<f64>, path: &[LeadPoint]) -> Result<u64, Mistake> {
    let Some(release_s) = release_s else {
        return Ok(path.last().map_or(0, |last| last.after_ns));
    };
    match microseconds(place, release_s)? {
        0 => Err(Mistake::new(place.clone(), "expected more than 0 s")),
        release_us => Ok(release_us * 1_000),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scenario::Scenario;
    use crate::scenario::tests::assert_mistake;

    /// Hands of a run of 10 s.
    fn leads_of(hands: &str, overrides: &Overrides) -> Vec<Lead> {
        let text = format!(
            "title = \"t\"\n[[step]]\nat_s = 0\nfloat = true\n{hands}[stop]\nafter_s = 10\n"
        );
        let scenario = Scenario::parse(Path::new("mine.toml"), &text, overrides).unwrap();
        scenario.plan.leads
    }

    #[test]
    fn a_hand_holds_link_2_and_lets_go_at_its_last_point() {
        let hands = "[[bench.hand]]\nat_s = 6\nlink = 1\nrelease_s = 0.5\nstiffness_n_m = 100\n\
                     damping_n_s_m = 0\npath = [{ after_s = 1, angle_rad = [0, 0] }]\n\
                     [[bench.hand]]\nat_s = 1\nevery_s = 2\n\
                     path = [{ after_s = 1, angle_rad = [0.1, 0.2] }, { after_s = 2, angle_rad = [0, 0] }]\n";
        let shortened = Overrides {
            duration_s: Some(4.0),
            ..Overrides::default()
        };
        let leads = leads_of(hands, &shortened);
        let starts: Vec<u64> = leads.iter().map(|lead| lead.start_ns / 1_000_000).collect();
        assert_eq!(starts, [1_000, 3_000]);
        let by_default = Lead {
            grip: Grip {
                link: 1,
                stiffness_n_m: 300.0,
                damping_n_s_m: 10.0,
            },
            start_ns: 1_000_000_000,
            path: vec![
                LeadPoint {
                    after_ns: 1_000_000_000,
                    angle_rad: [0.1, 0.2],
                },
                LeadPoint {
                    after_ns: 2_000_000_000,
                    angle_rad: [0.0, 0.0],
                },
            ],
            release_ns: 2_000_000_000,
        };
        assert_eq!(leads[0], by_default);
        let once = hands.replace("every_s = 2\n", "");
        let leads = leads_of(&once, &Overrides::default());
        let grip = Grip {
            link: 0,
            stiffness_n_m: 100.0,
            damping_n_s_m: 0.0,
        };
        assert_eq!((leads[1].grip, leads[1].release_ns), (grip, 500_000_000));
    }

    #[test]
    fn mistakes_have_a_place_and_say_what_is_right() {
        const POINT: &str = "path = [{ after_s = 1, angle_rad = [0, 0] }]";
        for (keys, at, words) in [
            ("path = []".into(), "6:8", "at least one point"),
            (
                "path = [{ after_s = 0, angle_rad = [0, 0] }]".into(),
                "6:21",
                "0.001 s after the one before it, or the start",
            ),
            (
                "path = [{ after_s = 1, angle_rad = [0, 2] }]".into(),
                "6:40",
                "from -1.4 to 1.4",
            ),
            (
                "path = [{ after = 1, angle_rad = [0, 0] }]".into(),
                "6:11",
                "is it `after_s`",
            ),
            (format!("{POINT}\nlink = 3"), "7:8", "from 1 to 2"),
            (format!("{POINT}\nrelease_s = 0"), "7:13", "more than 0 s"),
            (
                format!("{POINT}\nstiffness = 1"),
                "7:1",
                "is it `stiffness_n_m`",
            ),
            (format!("{POINT}\nevery_s = 0.5"), "7:11", "lets go at 2 s"),
            (
                format!("{POINT}\n[[bench.hand]]\nat_s = 1.5\n{POINT}"),
                "8:8",
                "one hand leads the arm at a time",
            ),
        ] {
            assert_mistake(
                &format!("[[bench.hand]]\nat_s = 1\n{keys}\n{STEP}"),
                at,
                words,
            );
        }
    }

    const STEP: &str = "[[step]]\nat_s = 0\nfloat = true";
}
