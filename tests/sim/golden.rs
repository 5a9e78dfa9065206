//! The virtual servos against recordings of the real servo firmware.
//!
//! `data/morpheus/README.md` describes the recordings. Every exchange is
//! replayed and compared: reply bytes, their senders and order, collisions,
//! lost bytes, PWM, mode, deafness and its cause, the receiver's state and all
//! registers exactly, times within the tolerances below. Results that the
//! record names as dependent on the phase of the servo's main loop are not
//! compared.
//!
//! `ARMBRIDGE_TRACES=<file>` replays another file of the same form instead.
//! `cargo test -p armbridge-tests --test sim golden -- --nocapture` shows the table by family.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::path::{Path, PathBuf};

use armbridge_sim::morpheus_servo::{Deafness, ReceiverState, Servo};
use armbridge_tests::replay::{Outcome, Replay};
use armbridge_tests::trace::{After, Exchange, Hex, load};

/// Tolerance of a time, in µs. Which turn
/// of the main loop (6 us) meets a byte, and whether a tick or a control step
/// comes before or after it, depends on single processor cycles that only the
/// same machine code would reproduce.
mod tolerance_us {
    /// Start of a reply: a tick (44) and the control step in it (up to 35).
    pub(super) const LATENCY: f64 = 80.0;
    /// Pause between two bytes of a reply: a control step.
    pub(super) const GAP: f64 = 40.0;
    /// Release of the wire after a reply: a control step in position mode and
    /// the turns beside it.
    pub(super) const RELEASE: f64 = 60.0;
    /// A new PWM on the motor: a control period (494) and reception, which
    /// stretches it while bytes arrive.
    pub(super) const PWM: f64 = 600.0;
    /// The firmware switches the motor off for a moment when it changes the
    /// PWM; the recording, which looks every 4 us, shows some of these.
    pub(super) const PWM_BLINK: f64 = 8.0;
}

/// The record shows at most this many replies, and PWM changes, of each exchange.
const SHOWN: usize = 12;

/// Where the sensor stood before a scenario's first event, which the record
/// does not have; it follows from the speed that the reply shows.
const FIRST_POSITION: [(&str, u16); 2] = [
    ("read/position_follows_sensor", 777),
    ("read/speed_after_step", 643),
];

/// Two servos answer at the same time. What their bytes add up to depends on
/// single microseconds between them: one starts up to 20 us early or late, or
/// both start as recorded and a pause inside one of them differs.
const SHIFT: &str = "the bytes of two overlapping replies meet differently";
/// Whether two replies overlap at all is as close.
const OVERLAP: &str = "the replies of two servos just meet, or just do not";
/// Of several packets in a row, the one that is obeyed is the newest when the
/// main loop looks.
const MISSED: &str = "a turn of the main loop decides which packet is seen";
/// A servo receives nothing until its bus driver is off.
const RELEASE: &str = "a turn of the main loop decides how much of a request is received";

/// Exchanges that differ, and why: none of the 746 of named scenarios, and 12
/// of the 967 random ones.
const DIFFER: &[(&str, u32, &str)] = &[
    ("fuzz/burst_039", 2, SHIFT),
    ("fuzz/burst_054", 2, SHIFT),
    ("fuzz/burst_089", 1, OVERLAP),
    ("fuzz/burst_189", 2, MISSED),
    ("fuzz/burst_204", 2, SHIFT),
    ("fuzz/burst_279", 2, SHIFT),
    ("fuzz/burst_299", 1, MISSED),
    ("fuzz/burst_309", 2, RELEASE),
    ("fuzz/valid_321", 2, SHIFT),
    ("fuzz/burst_374", 1, SHIFT),
    ("fuzz/burst_399", 2, SHIFT),
    ("fuzz/burst_474", 2, SHIFT),
];

struct Comparison<'a> {
    recorded: &'a Exchange,
    differences: Vec<String>,
}

impl Comparison<'_> {
    #[allow(clippy::needless_pass_by_value)] // The calls read better so.
    fn same<T: PartialEq + Debug>(&mut self, field: &str, recorded: T, got: T) {
        if recorded != got {
            self.differences
                .push(format!("{field}: recorded {recorded:?}, got {got:?}"));
        }
    }

    fn near(&mut self, field: &str, recorded: f64, got: f64, tolerance: f64) {
        if (recorded - got).abs() > tolerance {
            self.differences.push(format!(
                "{field}: recorded {recorded:.1} us, got {got:.1} us"
            ));
        }
    }

    fn replies(&mut self, got: &Outcome) {
        let recorded = self.recorded;
        if recorded.varies("replies") {
            return;
        }
        self.same("replies", recorded.replies_total, got.packets.len());
        for (want, packet) in recorded.replies.iter().zip(&got.packets) {
            self.same("sender", want.servo, packet.servo);
            self.same("reply", &want.hex, &Hex(packet.bytes.clone()));
            self.same("complete", want.complete, packet.complete);
            let latency = packet.latency_us;
            self.near("latency", want.latency_us, latency, tolerance_us::LATENCY);
            let gap = packet.max_gap_us;
            self.near("longest gap", want.max_gap_us, gap, tolerance_us::GAP);
            if let (Some(want), Some(got)) = (want.release_us, packet.release_us) {
                self.near("release", want, got, tolerance_us::RELEASE);
            }
        }
    }

    fn collision(&mut self, got: &Outcome) {
        let recorded = self.recorded;
        if recorded.varies("collision") {
            return;
        }
        self.same("collision", recorded.collision, got.collision);
        if let Some(wire) = &recorded.wire
            && !recorded.varies("replies")
        {
            self.same("wire", wire, &Hex(got.wire.clone()));
        }
    }

    fn pwm(&mut self, i: usize, after: &After, got: &Outcome) {
        let recorded = self.recorded;
        if recorded.varies_for("pwm", i) {
            return;
        }
        let field = format!("pwm[{i}]");
        self.same(&field, after.pwm, got.servos[i].state().pwm);
        let all: Vec<_> = recorded
            .pwm_changes
            .iter()
            .filter(|c| c.servo == i)
            .collect();
        let blink = |n: usize| {
            all[n].pwm == 1000
                && all
                    .get(n + 1)
                    .is_some_and(|next| next.t_us - all[n].t_us <= tolerance_us::PWM_BLINK)
        };
        let want: Vec<_> = (0..all.len())
            .filter(|&n| !blink(n))
            .map(|n| all[n])
            .collect();
        let mine: Vec<_> = got.pwm_changes.iter().filter(|c| c.0 == i).collect();
        let values = |n: usize| mine.iter().take(n).map(|c| c.2).collect::<Vec<_>>();
        let shown = if recorded.pwm_changes_total > SHOWN {
            want.len()
        } else {
            mine.len()
        };
        let changes: Vec<_> = want.iter().map(|c| c.pwm).collect();
        self.same(&format!("{field} changes"), changes, values(shown));
        for (want, got) in want.iter().zip(mine) {
            self.near(
                &format!("{field} change"),
                want.t_us,
                got.1,
                tolerance_us::PWM,
            );
        }
    }

    fn deafness(&mut self, i: usize, after: &After, servo: &Servo) {
        let Some(deaf) = after.deaf else {
            return; // The window was too short to tell.
        };
        if self.recorded.varies_for("deaf", i) {
            return;
        }
        let cause = servo.deafness().map(|cause| match cause {
            Deafness::MidPacket => "mid_packet",
            Deafness::MessageStuck => "message_stuck",
            Deafness::Busy => "busy",
        });
        self.same(&format!("deaf[{i}]"), deaf, cause.is_some());
        let recorded = after.deaf_cause.as_deref();
        self.same(&format!("deaf_cause[{i}]"), recorded, cause);
    }

    fn receiver(&mut self, i: usize, after: &After, got: &Outcome, is_comparable: &mut [bool]) {
        let recorded = self.recorded;
        let state = got.servos[i].state();
        // The fail-safe counts every byte received. Where replies vary, so does
        // the count, until the next header sets it back.
        let varies = ["replies", "collision"].iter().any(|w| recorded.varies(w))
            || ["deaf", "rx_state"]
                .iter()
                .any(|w| recorded.varies_for(w, i));
        is_comparable[i] = !varies && (is_comparable[i] || after.rx_failsafe == state.failsafe);
        if is_comparable[i] {
            let field = format!("rx_failsafe[{i}]");
            self.same(&field, after.rx_failsafe, state.failsafe);
        }
        if !varies {
            let field = format!("rx_overruns[{i}]");
            self.same(&field, recorded.rx_overruns[i], got.overruns[i]);
        }
        if !recorded.varies_for("rx_state", i) {
            let waits_for = match state.receiving {
                ReceiverState::Idle => "idle",
                ReceiverState::Length => "length",
                ReceiverState::Header => "header",
                ReceiverState::Body => "body",
                ReceiverState::SyncAddress => "sync_addr",
                ReceiverState::SyncSize => "sync_size",
                ReceiverState::SyncScan => "sync_scan",
                ReceiverState::SyncData => "sync_take",
                ReceiverState::SyncTail => "sync_tail",
            };
            self.same(&format!("rx_state[{i}]"), &*after.rx_state, waits_for);
        }
    }

    fn registers(&mut self, i: usize, after: &After, servo: &Servo) {
        let recorded = self.recorded;
        let state = servo.state();
        let mode = if state.position_mode {
            "position"
        } else {
            "pwm"
        };
        self.same(&format!("mode[{i}]"), &*after.mode, mode);
        if !recorded.varies_for("id", i) {
            self.same(&format!("id[{i}]"), after.id, servo.id());
        }
        if !recorded.varies_for("eeprom", i) {
            let rom = Hex(state.rom.to_vec());
            self.same(&format!("eeprom[{i}]"), &after.eeprom, &rom);
        }
        if !recorded.varies_for("pwm_reg", i) {
            self.same(
                &format!("pwm_reg, pwm_sync, pwm_last[{i}]"),
                [after.pwm_reg, after.pwm_sync, after.pwm_last],
                [state.pwm_requested, state.pwm_sync, state.pwm_before],
            );
        }
        self.same(
            &format!("baud_reg, speed[{i}]"),
            [after.baud_reg, after.speed],
            [state.baud, state.speed],
        );
        self.same(
            &format!("position, temperature[{i}]"),
            [after.position, after.temperature],
            [state.position, state.temperature],
        );
        self.same(
            &format!("goal_reg, goal_last, goal_active[{i}]"),
            [after.goal_reg, after.goal_last, after.goal_active],
            [state.goal_requested, state.goal_before, state.goal],
        );
        self.same(
            &format!("speed_reg, speed_active[{i}]"),
            [after.speed_reg, after.speed_active],
            [state.speed_requested, state.goal_speed],
        );
    }
}

fn differences(recorded: &Exchange, got: &Outcome, is_comparable: &mut [bool]) -> Vec<String> {
    let mut comparison = Comparison {
        recorded,
        differences: Vec::new(),
    };
    comparison.replies(got);
    comparison.collision(got);
    for (i, after) in recorded.after.iter().enumerate() {
        comparison.pwm(i, after, got);
        comparison.deafness(i, after, &got.servos[i]);
        comparison.receiver(i, after, got, is_comparable);
        comparison.registers(i, after, &got.servos[i]);
    }
    comparison.differences
}

/// Replays all exchanges, prints the table by family and the differences, and
/// returns which exchanges differ.
fn replay(exchanges: &[Exchange]) -> Vec<(&str, u32)> {
    let mut table: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    let mut differing = Vec::new();
    for scenario in exchanges.chunk_by(|a, b| a.scenario == b.scenario) {
        let first = &scenario[0];
        let position = FIRST_POSITION
            .iter()
            .find(|(name, _)| *name == first.scenario);
        let mut replay = Replay::new(first, position.map(|&(_, counts)| counts));
        let mut is_comparable = vec![true; first.bus.len()];
        for recorded in scenario {
            let got = replay.exchange(recorded);
            let differences = differences(recorded, &got, &mut is_comparable);
            let (agree, all) = table.entry(recorded.family()).or_default();
            *all += 1;
            if differences.is_empty() {
                *agree += 1;
                continue;
            }
            differing.push((recorded.scenario.as_str(), recorded.step));
            println!(
                "{} step {}: {:?}",
                recorded.scenario, recorded.step, recorded.tx
            );
            for difference in differences {
                println!("    {difference}");
            }
        }
    }
    for (family, (agree, all)) in &table {
        println!("{family:16} {agree:4} of {all:4} agree");
    }
    let (agree, all) = (exchanges.len() - differing.len(), exchanges.len());
    println!("{:16} {agree:4} of {all:4} agree", "all");
    differing
}

#[test]
fn recorded_exchanges() {
    if let Some(file) = std::env::var_os("ARMBRIDGE_TRACES") {
        let exchanges = load(&PathBuf::from(file));
        assert!(!exchanges.is_empty(), "no exchange in the file");
        let differing = replay(&exchanges).len();
        assert_eq!(differing, 0, "exchanges differ, see above");
        return;
    }
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/morpheus");
    let mut exchanges = load(&data.join("scenarios.jsonl.gz"));
    assert_eq!(exchanges.len(), 746);
    exchanges.extend(load(&data.join("random.jsonl.gz")));
    assert_eq!(exchanges.len(), 746 + 967);
    let known: Vec<_> = DIFFER.iter().map(|&(name, step, _)| (name, step)).collect();
    assert_eq!(replay(&exchanges), known, "the exchanges that differ");
}
