//! The schematic, the chapters and the firmware's own table name the same pins.

use std::fs;
use std::path::Path;

/// A pin of the Feather that goes somewhere: its name on the board, and that of the chip.
type Pin = (String, String);

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn cells(line: &str) -> Vec<&str> {
    line.split('|').map(str::trim).collect()
}

/// Pins in the table of the firmware's module that are wired by hand.
fn pins() -> Vec<Pin> {
    let module = read("firmware/src/board/feather_f405.rs");
    let rows = module.lines().filter_map(|line| {
        let row = cells(line.strip_prefix("//! ")?);
        match row.as_slice() {
            ["", chip, board, _, wired, ""]
                if chip.starts_with('P') && *wired != "on the board" =>
            {
                Some(((*board).to_owned(), (*chip).to_owned()))
            }
            _ => None,
        }
    });
    rows.collect()
}

#[test]
fn the_schematic_and_the_chapters_name_the_pins_of_the_firmware() {
    let pins = pins();
    let names: Vec<&str> = pins.iter().map(|(board, _)| board.as_str()).collect();
    assert_eq!(names, ["TX", "RX", "D12", "D9", "D11"]);
    let schematic = read("host/doc/src/schematic.svg");
    // Both names of a pin are on one line of the drawing.
    let at = |name: &str| {
        let label = format!(">{name}</text>");
        let line = schematic.lines().find(|line| line.ends_with(&label));
        let line = line.unwrap_or_else(|| panic!("no {name} in the schematic"));
        line.split("y=\"")
            .nth(1)
            .unwrap()
            .split('"')
            .next()
            .unwrap()
    };
    for (board, chip) in &pins {
        assert_eq!(at(board), at(chip), "{board} and {chip}");
    }
    let is_chip = |text: &str| {
        let port = text.strip_prefix('P').unwrap_or_default();
        port.len() >= 2 && port[1..].bytes().all(|byte| byte.is_ascii_digit())
    };
    let drawn = schematic.lines().filter_map(|line| {
        let text = line.strip_suffix("</text>")?.rsplit('>').next()?;
        is_chip(text).then_some(text)
    });
    assert_eq!(drawn.count(), pins.len(), "no other pin of the chip");
    for chapter in ["first-motion.md", "board.md"] {
        let text = read(&format!("host/doc/src/{chapter}"));
        let rows: Vec<Vec<&str>> = text.lines().map(cells).collect();
        for (board, chip) in &pins {
            let is_there = |row: &Vec<&str>| row.len() == 5 && row[1] == board && row[2] == chip;
            assert!(
                rows.iter().any(is_there),
                "{chapter}: no row of {board} and {chip}"
            );
        }
    }
}

/// The sense of the buffer's enables is written beside them: PC2 is high to send.
#[test]
fn the_buffer_is_wired_as_its_table_says() {
    let chapter = read("host/doc/src/first-motion.md");
    for (feather, buffer) in [
        ("| TX |", "pin 11"),
        ("| RX |", "pin 18"),
        ("| D12 |", "pins 1 and 19"),
    ] {
        let row = chapter.lines().find(|line| line.starts_with(feather));
        assert!(
            row.is_some_and(|row| row.contains(buffer)),
            "{feather} {buffer}"
        );
    }
    let schematic = read("host/doc/src/schematic.svg");
    for pin in ["1", "2", "9", "10", "11", "18", "19", "20"] {
        let label = format!("class=\"small\">{pin}</text>");
        assert!(schematic.contains(&label), "no pin {pin} of the buffer");
    }
}
