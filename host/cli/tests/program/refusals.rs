//! Arguments that cannot be meant are refused, in one line that fits.

use std::fs;

use super::links::program::{TCP, text};
use super::program::Program;

#[test]
fn what_would_be_ignored_is_refused() {
    let program = Program::new("refusals-ignored");
    program.write("empty.toml", "");
    let seeds = [
        "sweep",
        "demo",
        "--over",
        "seed=1..2",
        "--over",
        "seed=3..4",
    ];
    program.refuses(&seeds, &["--over seed is given twice"]);
    let three = ["run", "--firmware", "stock,morpheus,stock"];
    program.refuses(&three, &["3 values after --firmware", "two servos"]);
    let twice = ["serve", "servos", "--listen", TCP, "--ids", "1,1"];
    program.refuses(&twice, &["id 1 is given to two"]);
    for option in ["--list", "--explain"] {
        program.refuses(&["run", option, "x"], &[option, "cannot be used with"]);
    }
    let plant = ["run", "--plant", "empty.toml"];
    program.refuses(
        &plant,
        &["empty.toml:1:1", "sets no key", "plants --explain"],
    );
    fs::create_dir(program.path("armbridge.toml")).unwrap();
    program.refuses(&["config"], &["armbridge.toml", "directory"]);
}

#[test]
fn errors_of_toml_are_one_line_that_ends_where_it_ends() {
    let program = Program::new("refusals-toml");
    program.write("empty.toml", "");
    let output = program.run(&["run", "empty.toml"]);
    let line = text(&output.stderr).trim_end();
    assert!(line.ends_with("missing field `title`"), "{line}");
    program.prints(&["run", "upright", "--quiet"]);
    program.write("bad.toml", "[controller\nkind = 1\n");
    program.refuses(&["replay", "--with", "bad.toml"], &["bad.toml:1:"]);
}

#[test]
fn places_that_nothing_can_listen_on_are_not_offered() {
    let program = Program::new("refusals-listen");
    for args in [
        ["serve", "board", "--listen", "foo"].as_slice(),
        &["serve", "board", "--transparent", "usb:"],
        &["serve", "servos", "--listen", "serial:"],
        &["run", "--transparent", "foo"],
    ] {
        program.refuses(args, &["expected tcp://HOST:PORT or pty:"]);
        let line = program.run(args).stderr;
        assert!(!text(&line).contains("usb:SERIAL"), "{args:?}");
    }
    let at = "tcp://127.0.0.1:7999";
    let same = ["serve", "board", "--listen", at, "--transparent", at];
    program.refuses(&same, &["--listen and --transparent are both", "two ports"]);
}

#[test]
fn a_list_of_images_is_read_before_the_board_is_asked() {
    let program = Program::new("refusals-images");
    program.refuses(&["status", "--images", "gone.json"], &["gone.json"]);
    program.write("images.json", "{ \"version\": 1 }");
    let args = ["status", "--images", "images.json"];
    program.refuses(&args, &["images.json", "line 1", "cargo release"]);
    program.write(
        "images.json",
        r#"{ "version": "7.8.9", "commit": "", "images": [] }"#,
    );
    let status = program.json(&[&args[..], &["--json"]].concat());
    assert_eq!(status["image_release"], "7.8.9");
    // The simulation is not run from flash.
    assert!(status["image_crc32"].is_null() && status["image_board"].is_null());
}

#[cfg(unix)]
#[test]
fn a_pseudo_terminal_that_is_gone_is_no_matter_of_plugs() {
    let program = Program::new("refusals-pty");
    let args = ["status", "--link", "pty:///dev/pts/99999"];
    program.refuses(&args, &["/dev/pts/99999", "still run?"]);
    let line = program.run(&args).stderr;
    assert!(!text(&line).contains("by-id"));
}
