//! Settings outlive the board: saved over the link, in force after a reset.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::io::Read;
use std::time::{Duration, Instant};

use armbridge_client::Host;
use armbridge_client::session::{BoardMessage, CommandLink};
use armbridge_client::tcp_pump;
use armbridge_shared::bridge::Channels;
use armbridge_shared::link::message::{
    Command, Guards, Limits, Mode, Record, Refusal, SettingsFrom, Setup, ToHost,
};
use armbridge_sim::Bench;
use armbridge_sim::board::{Flash, VirtualBoard, blank_flash};
use armbridge_sim::cosim::Cosim;
use armbridge_sim::emulator::{Failure, Provocation, Qemu, QemuOptions, Time, qemu};
use armbridge_sim::plant::Plant;
use armbridge_sim::raw_bus_server::LiveBench;
use armbridge_tests::plant;

/// What is said to the board, one after the other.
#[derive(Clone, Copy, Debug)]
enum Say {
    Command(Command),
    /// With the session that the board has told.
    Arm,
}

/// Somebody who says what they have to say once the board is idle, and listens to
/// some ticks after the last answer.
struct Caller {
    client: CommandLink,
    to_say: VecDeque<Say>,
    heard: Heard,
    is_idle: bool,
    ticks_left: usize,
}

/// What the board said.
#[derive(Default)]
struct Heard {
    session: u32,
    settings: Option<SettingsFrom>,
    answers: Vec<Result<(), Refusal>>,
    records: Vec<Record>,
}

impl Caller {
    fn take(&mut self, said: BoardMessage) {
        match said {
            BoardMessage::Told(ToHost::Board(report)) => {
                self.heard.session = report.session;
                self.heard.settings = Some(report.settings);
            }
            BoardMessage::Done => self.heard.answers.push(Ok(())),
            BoardMessage::Refused(refusal) => self.heard.answers.push(Err(refusal)),
            BoardMessage::Told(ToHost::Record(record)) => {
                self.is_idle |= record.mode == Mode::Idle;
                if self.has_said_all() {
                    self.ticks_left = self.ticks_left.saturating_sub(1);
                }
                self.heard.records.push(record);
            }
            _ => {}
        }
    }

    fn has_said_all(&self) -> bool {
        self.to_say.is_empty() && self.client.is_settled() && self.is_idle
    }
}

impl Host for Caller {
    type Error = Infallible;

    fn transmit(&mut self, now_us: u64) -> Result<&[u8], Infallible> {
        assert!(now_us < 10_000_000, "no end");
        if self.is_idle
            && self.client.is_settled()
            && let Some(next) = self.to_say.pop_front()
        {
            self.client.command(match next {
                Say::Command(command) => command,
                Say::Arm => Command::Arm {
                    session: self.heard.session,
                },
            });
        }
        Ok(self.client.transmit(now_us))
    }

    fn receive(&mut self, _now_us: u64, mut bytes: &[u8]) -> Result<(), Infallible> {
        while let Some(message) = self.client.receive(&mut bytes) {
            self.take(message);
        }
        Ok(())
    }

    fn wake_at_us(&self) -> u64 {
        self.client.wake_at_us()
    }

    fn is_done(&self) -> bool {
        self.ticks_left == 0
    }
}

/// Somebody with this to say.
fn caller(to_say: impl IntoIterator<Item = Say>) -> Caller {
    Caller {
        client: CommandLink::default(),
        to_say: to_say.into_iter().collect(),
        heard: Heard::default(),
        is_idle: false,
        ticks_left: 20,
    }
}

fn bench() -> Bench {
    Bench::new(Plant::new(plant([0.1, -0.1], true), 1))
}

/// A board is switched on with this flash, hears all this, and is switched off.
fn live(flash: &mut Flash, to_say: impl IntoIterator<Item = Say>) -> Heard {
    let mut channels = Channels::new();
    let board = VirtualBoard::with_flash(channels.split(), flash.clone()).unwrap();
    let mut cosim = Cosim::new(board, bench(), caller(to_say));
    while !cosim.host.is_done() {
        cosim.step().unwrap();
    }
    flash.clone_from(cosim.board.flash());
    cosim.host.heard
}

/// Period of the last ticks in µs.
fn period_us(heard: &Heard) -> u64 {
    let [.., a, b] = &heard.records[..] else {
        panic!("no ticks");
    };
    b.start_us - a.start_us
}

fn configure(period_us: u32) -> Say {
    Say::Command(Command::Configure(Setup {
        period_us,
        ..Setup::default()
    }))
}

fn limit(torque_nm: f32) -> Say {
    Say::Command(Command::Limit(Limits {
        torque_nm: [torque_nm; 2],
        ..Limits::default()
    }))
}

const SAVE: Say = Say::Command(Command::Save);
const TORQUE_NM: f32 = 0.2;
/// Arm, and ask for [`TORQUE_NM`].
const PUSH: [Say; 2] = [Say::Arm, Say::Command(Command::Torque([TORQUE_NM, 0.0]))];

/// The greatest torque of joint 0, and whether it was limited.
fn pushed(heard: &Heard) -> (f32, bool) {
    let driven = heard.records.iter().filter(|r| r.mode.drive().is_some());
    let torque = |record: &Record| record.torque_nm[0].abs();
    let greatest_nm = driven.clone().map(torque).fold(0.0, f32::max);
    let is_limited = driven.clone().any(|r| r.guards.contains(Guards::TORQUE));
    (greatest_nm, is_limited)
}

#[test]
fn what_is_saved_is_in_force_after_a_reset() {
    let mut flash = blank_flash();
    let heard = live(&mut flash, [configure(2_000), limit(0.1), SAVE]);
    assert_eq!(heard.settings, Some(SettingsFrom::Default));
    assert_eq!(heard.answers, [Ok(()); 3]);

    let heard = live(&mut flash, PUSH);
    assert_eq!(heard.settings, Some(SettingsFrom::Saved));
    assert_eq!(heard.answers, [Ok(()); 2]);
    assert_eq!(period_us(&heard), 2_000);
    let (greatest_nm, is_limited) = pushed(&heard);
    assert!(
        is_limited && (0.05..0.11).contains(&greatest_nm),
        "{greatest_nm}"
    );

    // Changed, but not saved: the next life knows nothing of it.
    let heard = live(&mut flash, [configure(1_000), limit(1.0)]);
    assert_eq!(
        (heard.settings, period_us(&heard)),
        (Some(SettingsFrom::Saved), 1_000)
    );
    assert_eq!(period_us(&live(&mut flash, [])), 2_000);
}

#[test]
fn nothing_is_written_while_armed() {
    let mut flash = blank_flash();
    let heard = live(&mut flash, [limit(0.1), Say::Arm, SAVE]);
    assert_eq!(heard.answers, [Ok(()), Ok(()), Err(Refusal::NotIdle)]);
    assert_eq!(flash.0, blank_flash().0);
}

#[test]
fn damaged_settings_are_reported_and_not_used() {
    let mut flash = blank_flash();
    live(&mut flash, [configure(2_000), limit(0.1), SAVE]);
    let sound = flash.clone();
    let written = flash.0.iter().rposition(|byte| *byte != 0xFF).unwrap();
    let mut damaged = 0;
    for at in (0..=written).step_by(29) {
        flash.clone_from(&sound);
        flash.0[at] ^= 0x11;
        let heard = live(&mut flash, PUSH);
        // A few bits belong to nothing that counts: of the marks of page and
        // receipt.
        if heard.settings == Some(SettingsFrom::Saved) {
            assert_eq!(period_us(&heard), 2_000, "byte {at}");
            continue;
        }
        assert_eq!(heard.settings, Some(SettingsFrom::Damaged), "byte {at}");
        assert_eq!(period_us(&heard), 1_000, "byte {at}");
        let (greatest_nm, is_limited) = pushed(&heard);
        assert!(
            !is_limited && (greatest_nm - TORQUE_NM).abs() < 0.01,
            "{greatest_nm}"
        );
        damaged += 1;
        // It can be saved to again.
        live(&mut flash, [limit(0.3), SAVE]);
        assert_eq!(live(&mut flash, []).settings, Some(SettingsFrom::Saved));
    }
    assert!(damaged >= 7, "{damaged}");
}

#[test]
fn a_full_flash_says_so_until_a_reset() {
    let mut flash = blank_flash();
    let many = (0..100).flat_map(|number| [limit(0.1 + number as f32 * 0.01), SAVE]);
    let heard = live(&mut flash, many);
    let refused = heard.answers.iter().filter(|answer| answer.is_err());
    assert!(
        refused
            .clone()
            .all(|answer| *answer == Err(Refusal::NotSaved))
    );
    let refused = refused.count();
    assert!((1..=100 - 16).contains(&refused), "{refused}");
    let heard = live(&mut flash, [limit(0.15), SAVE]);
    assert_eq!(heard.settings, Some(SettingsFrom::Saved));
    assert_eq!(heard.answers, [Ok(()); 2]);
}

/// The same on the emulated board, whose flash is memory that a reset leaves alone.
#[test]
#[ignore = "needs QEMU and the firmware image: run `cargo verify`"]
fn firmware_keeps_settings_across_a_reset() {
    /// Times slower than the wall clock, for a machine with other things to do.
    const SLOW: u32 = 10;
    const FAILS_MS: u32 = 1_200;
    let begun = Instant::now();
    let mut qemu = Qemu::start(&QemuOptions {
        image: qemu::default_image(),
        time: Time::Slow(SLOW),
        icount: false,
        provoke: Some(Provocation {
            failure: Failure::Panic,
            at_ms: FAILS_MS,
        }),
    })
    .unwrap();
    let (from, to) = (qemu.bus.try_clone().unwrap(), qemu.bus.try_clone().unwrap());
    // Ends with QEMU.
    std::thread::spawn(move || LiveBench::new(bench(), SLOW).serve(from, to, || None, false));

    let mut first = caller([configure(2_000), SAVE]);
    tcp_pump::run(&mut qemu.link, &mut first, SLOW).unwrap();
    assert_eq!(first.heard.settings, Some(SettingsFrom::Default));
    assert_eq!(first.heard.answers, [Ok(()); 2]);
    let fails_at = Duration::from_millis(u64::from(FAILS_MS * SLOW));
    assert!(
        begun.elapsed() < fails_at,
        "too slow a machine for this test"
    );

    let over = fails_at + Duration::from_secs(2);
    std::thread::sleep(over.saturating_sub(begun.elapsed()));
    // What the first life said last is nobody's any more.
    let link = &mut qemu.link;
    link.set_read_timeout(Some(Duration::from_millis(100)))
        .unwrap();
    while matches!(link.read(&mut [0; 4096]), Ok(count) if count > 0) {}
    let mut second = caller([]);
    tcp_pump::run(&mut qemu.link, &mut second, SLOW).unwrap();
    assert_ne!(second.heard.session, first.heard.session);
    assert_eq!(second.heard.settings, Some(SettingsFrom::Saved));
    let spans = second.heard.records.windows(2);
    let spans = spans.map(|pair| {
        (
            pair[1].tick - pair[0].tick,
            pair[1].start_us - pair[0].start_us,
        )
    });
    assert!(spans.clone().any(|(ticks, _)| ticks == 1));
    for (ticks, span_us) in spans.filter(|(ticks, _)| *ticks == 1) {
        assert!((1_500..2_500).contains(&span_us), "{ticks} in {span_us} us");
    }
}
