//! The virtual servos against recordings of the real servo firmware.
use armbridge::bench::servo::{Deafness, Receiving};
use armbridge_tests::replay::{Outcome, Replay};
use armbridge_tests::trace::{Exchange, load};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const LATENCY_TOLERANCE_US: f64 = 60.0;
const PWM_TOLERANCE_US: f64 = 560.0;
const PWM_GLITCH_US: f64 = 8.0;

const FIRST_POSITION: [(&str, u16); 2] = [
    ("read/position_follows_sensor", 777),
    ("read/speed_after_step", 643),
];

fn differences(e: &Exchange, o: &Outcome) -> Vec<String> {
    let mut d = Vec::new();
    macro_rules! same {
        ($name:expr, $want:expr, $got:expr) => {
            let (w, g) = ($want, $got);
            if w != g {
                d.push(format!("{}: recorded {:?}, got {:?}", $name, w, g));
            }
        };
    }
    if !e.varies("replies") {
        same!("replies_total", e.replies_total, o.packets.len());
        for (w, g) in e.replies.iter().zip(&o.packets) {
            same!("reply servo", w.servo, g.servo);
            same!("reply", &w.hex.0, &g.bytes);
            same!("complete", w.complete, g.complete);
            if (w.latency_us - g.latency_us).abs() > LATENCY_TOLERANCE_US {
                d.push(format!(
                    "latency: recorded {} got {}",
                    w.latency_us, g.latency_us
                ));
            }
            if std::env::var("LAT").is_ok() {
                println!(
                    "LAT {} {} {} {} {} gap {} {} rel {:?} {:?}",
                    e.scenario,
                    e.step,
                    w.latency_us,
                    g.latency_us,
                    g.latency_us - w.latency_us,
                    w.max_gap_us,
                    g.max_gap_us,
                    w.release_us,
                    g.release_us
                );
            }
        }
    }
    if !e.varies("collision") {
        same!("collision", e.collision, o.collision);
        if let (Some(w), false) = (&e.wire, e.varies("replies")) {
            same!(
                "wire",
                format!("{w:?}"),
                format!("{:?}", armbridge_tests::trace::Hex(o.wire.clone()))
            );
        }
    }
    for (i, (w, servo)) in e.after.iter().zip(&o.servos).enumerate() {
        let g = servo.state();
        let n = |what: &str| format!("{what}[{i}]");
        if !e.varies_for("pwm", i) {
            same!(n("pwm"), w.pwm, g.pwm);
            let rec: Vec<_> = e.pwm_changes.iter().filter(|c| c.servo == i).collect();
            let mut rec2 = Vec::new();
            for (k, c) in rec.iter().enumerate() {
                if c.pwm == 1000
                    && rec
                        .get(k + 1)
                        .is_some_and(|x| x.t_us - c.t_us <= PWM_GLITCH_US)
                {
                    continue;
                }
                rec2.push((c.pwm, c.t_us));
            }
            let got: Vec<_> = o
                .pwm_changes
                .iter()
                .filter(|c| c.0 == i)
                .map(|c| (c.2, c.1))
                .collect();
            if e.pwm_changes_total <= 12 {
                if rec2.len() != got.len() {
                    d.push(format!("times {rec2:?} {got:?}"));
                }
                same!(
                    n("pwm_changes"),
                    rec2.iter().map(|c| c.0).collect::<Vec<_>>(),
                    got.iter().map(|c| c.0).collect::<Vec<_>>()
                );
            }
            for (a, b) in rec2.iter().zip(&got) {
                if std::env::var("SHOW").is_ok() {
                    println!("{a:?} {b:?}");
                }
                if (a.1 - b.1).abs() > PWM_TOLERANCE_US || a.0 != b.0 {
                    d.push(format!("pwm change[{i}]: recorded {a:?} got {b:?}"));
                }
                if std::env::var("LAT").is_ok() {
                    println!(
                        "PWM {} {} {} {} {}",
                        e.scenario,
                        e.step,
                        a.1,
                        b.1,
                        b.1 - a.1
                    );
                }
            }
        }
        same!(
            n("mode"),
            &*w.mode,
            if g.position_mode { "position" } else { "pwm" }
        );
        if let (Some(deaf), false) = (w.deaf, e.varies_for("deaf", i)) {
            let cause = servo.deafness().map(|c| match c {
                Deafness::MidPacket => "mid_packet",
                Deafness::MessageStuck => "message_stuck",
                Deafness::Busy => "busy",
            });
            same!(n("deaf"), deaf, cause.is_some());
            same!(n("deaf_cause"), w.deaf_cause.as_deref(), cause);
        }
        if !e.varies_for("rx_state", i) && !e.varies_for("deaf", i) {
            let st = match g.receiving {
                Receiving::Idle => "idle",
                Receiving::Length => "length",
                Receiving::Header => "header",
                Receiving::Body => "body",
                Receiving::SyncAddress => "sync_addr",
                Receiving::SyncSize => "sync_size",
                Receiving::SyncScan => "sync_scan",
                Receiving::SyncTake => "sync_take",
                Receiving::SyncTail => "sync_tail",
            };
            same!(n("rx_state"), &*w.rx_state, st);
            same!(n("rx_failsafe"), w.rx_failsafe, g.failsafe);
            same!(n("rx_overruns"), e.rx_overruns[i], o.overruns[i]);
        }
        if !e.varies_for("eeprom", i) {
            same!(n("eeprom"), &w.eeprom.0[..], &g.rom[..]);
        }
        if !e.varies_for("id", i) {
            same!(n("id"), w.id, servo.id());
        }
        same!(n("baud_reg"), w.baud_reg, g.baud);
        same!(n("position"), w.position, g.position);
        same!(n("speed"), w.speed, g.speed);
        same!(n("temperature"), w.temperature, g.temperature);
        if !e.varies_for("pwm_reg", i) {
            same!(n("pwm_reg"), w.pwm_reg, g.pwm_requested);
            same!(n("pwm_sync"), w.pwm_sync, g.pwm_sync);
            same!(n("pwm_last"), w.pwm_last, g.pwm_before);
        }
        same!(n("goal_reg"), w.goal_reg, g.goal_requested);
        same!(n("goal_last"), w.goal_last, g.goal_before);
        same!(n("goal_active"), w.goal_active, g.goal);
        same!(n("speed_reg"), w.speed_reg, g.speed_requested);
        same!(n("speed_active"), w.speed_active, g.goal_speed);
    }
    d
}

fn replay(exchanges: &[Exchange]) -> usize {
    let mut table: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    let mut bad = 0;
    for scenario in exchanges.chunk_by(|a, b| a.scenario == b.scenario) {
        let position = FIRST_POSITION
            .iter()
            .find(|(name, _)| *name == scenario[0].scenario)
            .map(|p| p.1);
        let mut replay = Replay::new(&scenario[0], position);
        for e in scenario {
            let o = replay.exchange(e);
            let d = differences(e, &o);
            let row = table.entry(e.family()).or_default();
            row.1 += 1;
            if d.is_empty() {
                row.0 += 1;
            } else {
                bad += 1;
                if bad < 400 {
                    println!(
                        "{} {} {:?}\n    {}",
                        e.scenario,
                        e.step,
                        e.tx,
                        d.join("\n    ")
                    );
                }
            }
        }
    }
    for (f, (ok, all)) in &table {
        println!("{f:16} {ok:4} of {all}");
    }
    bad
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data/morpheus")
        .join(name)
}

#[test]
fn scenarios() {
    assert_eq!(
        replay(&load(
            &std::env::var("ARMBRIDGE_TRACES").map_or(data("scenarios.jsonl.gz"), PathBuf::from)
        )),
        0
    );
}
#[test]
fn random() {
    assert_eq!(replay(&load(&data("random.jsonl.gz"))), 0);
}
