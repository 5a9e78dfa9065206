//! Settings outlive the board: saved over the link, in force after a reset.

use armbridge_board::bridge::Channels;
use armbridge_client::Host;
use armbridge_link::message::{
    Command, Guards, Limits, Record, Refusal, SettingsFrom, Setup, ToHost,
};
use armbridge_servo::Firmware;
use armbridge_sim::board::{Flash, VirtualBoard, blank_flash};
use armbridge_sim::cosim::Cosim;
use armbridge_sim::plant::PlantConfig;
use armbridge_tests::command_host::{
    CommandHost, Received, Request, SAVE, bench, configure, period_us,
};
use armbridge_tests::torque_off::rig::{self as torque_off, World, with_rig};

/// Switches a board on with this flash, sends these commands, and switches it off.
fn live(flash: &mut Flash, requests: impl IntoIterator<Item = Request>) -> Received {
    let mut channels = Channels::new();
    let board = VirtualBoard::with_flash(channels.split(), flash.clone()).unwrap();
    let mut cosim = Cosim::new(board, bench(), CommandHost::new(requests));
    while !cosim.host.is_done() {
        cosim.step().unwrap();
    }
    flash.clone_from(cosim.board.flash());
    cosim.host.received
}

fn limit(torque_nm: f32) -> Request {
    Request::Command(Command::Limit(Limits {
        torque_nm: [torque_nm; 2],
        ..Limits::default()
    }))
}

const TORQUE_NM: f32 = 0.2;
/// Arm, and ask for [`TORQUE_NM`].
const PUSH: [Request; 2] = [
    Request::Arm,
    Request::Command(Command::Torque([TORQUE_NM, 0.0])),
];

/// The greatest torque of joint 0, and whether it was limited.
fn pushed(received: &Received) -> (f32, bool) {
    let driven = received.records.iter().filter(|r| r.mode.drive().is_some());
    let torque = |record: &Record| record.output.torque_nm[0].abs();
    let greatest_nm = driven.clone().map(torque).fold(0.0, f32::max);
    let is_limited = driven
        .clone()
        .any(|r| r.output.guards.contains(Guards::TORQUE));
    (greatest_nm, is_limited)
}

#[test]
fn what_is_saved_is_in_force_after_a_reset() {
    let mut flash = blank_flash();
    let received = live(&mut flash, [configure(2_000), limit(0.1), SAVE]);
    assert_eq!(received.settings, Some(SettingsFrom::Saved));
    assert_eq!(received.answers, [Ok(()); 3]);

    let received = live(&mut flash, PUSH);
    assert_eq!(received.settings, Some(SettingsFrom::Saved));
    assert_eq!(received.answers, [Ok(()); 2]);
    assert_eq!(period_us(&received), 2_000);
    let (greatest_nm, is_limited) = pushed(&received);
    assert!(
        is_limited && (0.05..0.11).contains(&greatest_nm),
        "{greatest_nm}"
    );

    // Changed, but not saved: the next life knows nothing of it.
    let received = live(&mut flash, [configure(1_000), limit(1.0)]);
    assert_eq!(
        (received.settings, period_us(&received)),
        (Some(SettingsFrom::Saved), 1_000)
    );
    assert_eq!(period_us(&live(&mut flash, [])), 2_000);
}

#[test]
fn nothing_is_written_while_armed() {
    let mut flash = blank_flash();
    let received = live(&mut flash, [limit(0.1), Request::Arm, SAVE]);
    assert_eq!(received.answers, [Ok(()), Ok(()), Err(Refusal::NotIdle)]);
    assert_eq!(flash.0, blank_flash().0);
}

/// Each byte of a flash with one saved record, with a bit turned: the board has the saved
/// settings, or refuses to arm until those in force are confirmed.
#[test]
fn damaged_settings_are_reported_and_not_armed_with() {
    let mut flash = blank_flash();
    live(&mut flash, [configure(2_000), limit(0.1), SAVE]);
    let sound = flash.clone();
    let written = flash.0.iter().rposition(|byte| *byte != 0xFF).unwrap();
    let mut damaged = 0;
    for at in 0..=written {
        flash.clone_from(&sound);
        flash.0[at] ^= 1 << (at % 8);
        let received = live(&mut flash, PUSH);
        // Some bits belong to nothing that counts: of the marks of page and receipt.
        if received.settings == Some(SettingsFrom::Saved) {
            let (greatest_nm, is_limited) = pushed(&received);
            assert!(is_limited && greatest_nm < 0.11, "byte {at}: {greatest_nm}");
            assert_eq!(period_us(&received), 2_000, "byte {at}");
            continue;
        }
        assert_eq!(received.settings, Some(SettingsFrom::Damaged), "byte {at}");
        let refused = [Err(Refusal::SettingsLost), Err(Refusal::Disarmed)];
        assert_eq!(received.answers, refused, "byte {at}");
        let is_driven = |record: &Record| record.mode.is_armed();
        assert!(!received.records.iter().any(is_driven), "byte {at}");
        damaged += 1;
    }
    assert!(damaged > 200, "{damaged} of {}", written + 1);

    // A save confirms the settings in force, now and after a reset.
    flash.0[written / 2] ^= 0x11;
    let confirmed = [limit(0.1), SAVE].into_iter().chain(PUSH);
    let received = live(&mut flash, confirmed);
    assert_eq!(received.answers, [Ok(()); 4]);
    let received = live(&mut flash, PUSH);
    assert_eq!(
        (received.settings, received.answers.as_slice()),
        (Some(SettingsFrom::Saved), [Ok(()); 2].as_slice())
    );
}

#[test]
fn a_full_flash_says_so_until_a_reset() {
    let mut flash = blank_flash();
    let many = (0..100).flat_map(|number| [limit(0.1 + number as f32 * 0.01), SAVE]);
    let received = live(&mut flash, many);
    let refused = received.answers.iter().filter(|answer| answer.is_err());
    assert!(
        refused
            .clone()
            .all(|answer| *answer == Err(Refusal::NotSaved))
    );
    let refused = refused.count();
    assert!((1..=100 - 16).contains(&refused), "{refused}");
    let received = live(&mut flash, [limit(0.15), SAVE]);
    assert_eq!(received.settings, Some(SettingsFrom::Saved));
    assert_eq!(received.answers, [Ok(()); 2]);
}

/// In one write, the second with a number that the tick refuses: the first is in force, and
/// is what the board reports.
#[test]
fn of_two_set_ups_in_one_write_the_one_in_force_is_reported() {
    let bench = torque_off::bench(&PlantConfig::default(), Firmware::Morpheus);
    with_rig(World::Bench, bench, |rig| {
        let since = rig.host().messages.len();
        let setup = |period_us| Setup {
            period_us,
            ..Setup::default()
        };
        let [first, second] = [2_000, 5_000]
            .map(|period_us| rig.host().command(Command::Configure(setup(period_us))));
        rig.pass_ms(100);
        assert_eq!(rig.cosim.host.answer(since, first), Some(Ok(())));
        let answer = rig.cosim.host.answer(since, second);
        assert_eq!(answer, Some(Err(Refusal::Busy)));
        let settings = |(_, message): &(u64, ToHost)| match message {
            ToHost::Settings(settings) => Some(settings.setup.period_us),
            _ => None,
        };
        let mut reported = rig.cosim.host.messages[since..].iter().filter_map(settings);
        assert_eq!(reported.next_back(), Some(2_000));
        // And the next one is taken.
        assert_eq!(rig.command_once(Command::Configure(setup(4_000))), Ok(()));
    });
}
