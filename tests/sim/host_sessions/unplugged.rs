//! A cable that is unplugged while the arm is held.

use std::time::Duration;

use armbridge_client::LinkError;
use armbridge_client::session::Request;
use armbridge_link::message::{Fault, Mode};
use armbridge_tests::cable::Cable;
use armbridge_tests::channel_host::Manned;
use armbridge_tests::served_board::{Served, until};

#[test]
fn plugged_in_again_the_host_is_back_and_nothing_is_armed() {
    let board = Served::on("tcp://127.0.0.1:0");
    let cable = Cable::to(&board.link);
    let station = Manned::on(&cable.link, Duration::from_secs(20));
    station.hold(&board);
    cable.unplug();
    let silent = Mode::Fault(Fault::HostSilent);
    board.until("the host is found silent", |seen| seen.mode == silent);
    board.until_off();
    until("parted", || station.received().partings > 0);
    let before = station.received().records;
    cable.plug_in();
    until("records come again", || {
        station.received().records > before + 100
    });
    let received = station.received();
    assert_eq!(received.mode, Some(silent), "the fault is reported");
    assert!(!received.was_armed_after);
    station.ask(Request::Leave);
    station.end().unwrap();
    board.until_off();
}

#[test]
fn not_plugged_in_again_the_host_gives_up() {
    let board = Served::on("tcp://127.0.0.1:0");
    let cable = Cable::to(&board.link);
    let station = Manned::on(&cable.link, Duration::from_millis(600));
    station.hold(&board);
    cable.unplug();
    let Err(LinkError::Link(why)) = station.end() else {
        panic!("the link is gone");
    };
    let why = why.to_string();
    assert!(why.contains("did not come back in 0.6 s"), "{why}");
    board.until_off();
}

#[cfg(unix)]
#[test]
fn a_terminal_that_is_closed_is_a_broken_link() {
    let board = Served::on("pty:");
    let station = Manned::on(&board.link, Duration::from_millis(600));
    station.hold(&board);
    drop(board);
    let Err(LinkError::Link(why)) = station.end() else {
        panic!("the link is gone");
    };
    let why = why.to_string();
    assert!(
        why.contains("/dev/pts/") && why.contains("did not come back"),
        "{why}"
    );
}
