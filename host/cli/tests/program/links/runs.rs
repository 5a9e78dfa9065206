//! `armbridge run` on links and disks that fail: its messages, its files, and no arm
//! energised.

use std::process::{Command, Output};

use armbridge_link::message::{Drive, Mode};
use armbridge_log::recording::Recording;

#[cfg(unix)]
use super::program::interrupt;
use super::program::{TCP, assert_ends, command, spawn, text};
use armbridge_tests::cable::Cable;
use armbridge_tests::served_board::Served;

/// A scenario of ten seconds that moves.
const UPRIGHT: [&str; 3] = ["run", "upright", "--verbose"];

/// The board is well under way.
fn until_it_regulates(board: &Served) {
    board.until("it regulates", |seen| {
        seen.mode.drive() == Some(Drive::Regulate)
    });
}

/// The log that a run has left.
fn left(output: &Output) -> Recording {
    let folder = armbridge_tests::paths::run_folder(text(&output.stdout));
    Recording::load(&super::program::folder().join(folder).join("run.mcap")).unwrap()
}

/// It has ticks, and ends in order.
fn assert_whole(log: &Recording) {
    assert!(!log.records().is_empty());
    assert_eq!(log.damage, [""; 0]);
}

#[test]
fn a_run_whose_board_is_reset_ends_and_keeps_its_log() {
    let board = Served::on(TCP);
    let child = spawn(&board.link, &UPRIGHT);
    until_it_regulates(&board);
    board.reset();
    let output = child.wait_with_output().unwrap();
    assert_ends(
        &output,
        1,
        "ended early: the board has been reset: its watchdog",
    );
    assert_ends(&output, 1, "0 lost, 0 damaged, 0 dropped");
    assert_whole(&left(&output));
    board.until_off();
    board.until("idle", |seen| seen.mode == Mode::Idle);
}

#[test]
fn a_run_whose_link_is_unplugged_ends_and_keeps_its_log() {
    let board = Served::on(TCP);
    let cable = Cable::to(&board.link);
    let child = spawn(&cable.link, &UPRIGHT);
    until_it_regulates(&board);
    cable.unplug();
    let output = child.wait_with_output().unwrap();
    assert_ends(&output, 1, "it is tried again for at most 0.5 s");
    assert_ends(&output, 1, "did not come back in 0.5 s");
    assert_whole(&left(&output));
    board.until_off();
}

#[cfg(unix)]
#[test]
fn a_run_that_is_interrupted_disarms_and_ends() {
    let board = Served::on("pty:");
    let child = spawn(&board.link, &UPRIGHT);
    until_it_regulates(&board);
    interrupt(&child);
    let output = child.wait_with_output().unwrap();
    assert_ends(&output, 130, "ended early: ctrl-c; motors are off");
    assert_whole(&left(&output));
    board.until_off();
    assert_eq!(board.seen().mode, Mode::Idle, "no fault");
}

/// No file may grow past 256 kB: like a disk that is full, and as easily tried.
#[cfg(unix)]
#[test]
fn a_run_on_a_full_disk_goes_on_and_says_what_is_missing() {
    let board = Served::on(TCP);
    let run = command(&board.link, &UPRIGHT);
    let mut limited = Command::new("sh");
    let script = "trap '' XFSZ; ulimit -f 512; exec \"$0\" \"$@\"";
    limited.args(["-c", script]).arg(run.get_program());
    limited.args(run.get_args());
    limited.current_dir(run.get_current_dir().unwrap());
    let output = limited.output().unwrap();
    assert_ends(&output, 1, "the file may not grow further");
    let stdout = text(&output.stdout);
    let number = |before: &str, after: &str| -> u64 {
        let (_, rest) = stdout.split_once(before).unwrap();
        rest.split_once(after).unwrap().0.trim().parse().unwrap()
    };
    let written = number("the log ends after ", " ticks");
    assert_eq!(
        number("\n log file ", " records written"),
        written,
        "{stdout}"
    );
    // The arm has gone through all of it; its board may be 0.1 s behind the wall clock.
    assert!(number("1 kHz,", " ticks") >= 9_900, "{stdout}");
    assert!(left(&output).records().len() as u64 >= written);
    board.until_off();
}
