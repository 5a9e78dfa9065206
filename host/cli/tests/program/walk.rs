//! The console blocks of the README and of the book are what the program prints.
//!
//! Each `console` block of the README and of the chapters, in the order of
//! `host/doc/src/SUMMARY.md`, is a list of commands, `$ armbridge …` or
//! `$ cargo run --release`, with what they print. All are run, in order, in one
//! empty folder, and the output is compared line by line. A line `...` stands for
//! any lines, and `…` within a line for any text: wall-clock times, names of run
//! folders. The screen of `watch` is the one that its own test captures.

use std::fs;
use std::path::Path;
use std::process::Command;

/// A command and what it should print.
struct Step {
    command: String,
    expected: Vec<String>,
}

/// The README and the chapters of the book, in order.
fn pages(root: &Path) -> Vec<String> {
    let book = root.join("host/doc/src");
    let summary = fs::read_to_string(book.join("SUMMARY.md")).unwrap();
    let links = summary.split("](").skip(1);
    let chapters = links.map(|link| book.join(link.split(')').next().unwrap_or_default()));
    let pages = std::iter::once(root.join("README.md")).chain(chapters);
    pages
        .map(|page| fs::read_to_string(page).unwrap())
        .collect()
}

fn steps(pages: &str) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    let mut is_console = false;
    for line in pages.lines() {
        match (line, line.strip_prefix("$ ")) {
            ("```console", _) => is_console = true,
            ("```", _) => is_console = false,
            (_, Some(command)) if is_console => steps.push(Step {
                command: command.to_owned(),
                expected: Vec::new(),
            }),
            _ if is_console => {
                let step = steps.last_mut().expect("a block begins with a command");
                step.expected.push(line.trim_end().to_owned());
            }
            _ => {}
        }
    }
    for step in &mut steps {
        while step.expected.last().is_some_and(String::is_empty) {
            step.expected.pop();
        }
    }
    steps
}

/// The arguments of the program that a command stands for.
fn arguments(command: &str) -> Vec<&str> {
    let mut words = command.split_whitespace().skip(1);
    if command.starts_with("cargo") {
        let is_run = words.next() == Some("run") && words.next() == Some("--release");
        assert!(is_run, "{command}");
        return words.skip_while(|word| *word == "--").collect();
    }
    assert!(command.starts_with("armbridge"), "{command}");
    words.collect()
}

/// Whether a line is as expected, `…` standing for any text.
fn fits(expected: &str, line: &str) -> bool {
    let mut pieces = expected.split('…');
    let Some(rest) = pieces.next().and_then(|first| line.strip_prefix(first)) else {
        return false;
    };
    let mut rest = rest;
    let mut pieces = pieces.peekable();
    if pieces.peek().is_none() {
        return rest.is_empty();
    }
    while let Some(piece) = pieces.next() {
        if pieces.peek().is_none() {
            return rest.ends_with(piece);
        }
        let Some(at) = rest.find(piece) else {
            return false;
        };
        rest = &rest[at + piece.len()..];
    }
    true
}

/// Where the output leaves what is expected: the expected line.
fn first_misfit<'a>(expected: &'a [String], lines: &[&str]) -> Option<&'a str> {
    let Some((first, then)) = expected.split_first() else {
        return (!lines.is_empty()).then_some("the end");
    };
    if first == "..." {
        let next = then.first()?;
        let at = lines.iter().position(|line| fits(next, line));
        return at.map_or(Some(next), |at| first_misfit(then, &lines[at..]));
    }
    match lines.split_first() {
        Some((line, rest)) if fits(first, line) => first_misfit(then, rest),
        _ => Some(first),
    }
}

#[test]
fn console_blocks_print_what_they_show() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let pages = pages(&here.join("../..")).join("\n");
    let folder = std::env::temp_dir().join(format!("armbridge-walk-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let steps = steps(&pages);
    assert!(steps.len() >= 6, "{} commands", steps.len());
    for Step { command, expected } in steps {
        let printed = if command.starts_with("armbridge watch") {
            fs::read_to_string(here.join("tests/data/watch/running-80x24.txt")).unwrap()
        } else {
            let output = Command::new(env!("CARGO_BIN_EXE_armbridge"))
                .args(arguments(&command))
                .current_dir(&folder)
                .env_remove("ARMBRIDGE_LINK")
                .output()
                .unwrap();
            let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success(), "{command}: {stderr}");
            String::from_utf8(output.stdout).unwrap()
        };
        let lines: Vec<&str> = printed.lines().map(str::trim_end).collect();
        let end = lines.iter().rposition(|line| !line.is_empty());
        let lines = &lines[..end.map_or(0, |end| end + 1)];
        if let Some(misfit) = first_misfit(&expected, lines) {
            panic!("{command} does not print\n{misfit}\nbut\n{printed}");
        }
    }
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn what_stands_for_anything_stands_for_nothing_else() {
    let fit = |expected: &[&str], lines: &[&str]| {
        let expected: Vec<String> = expected.iter().map(|&line| line.to_owned()).collect();
        first_misfit(&expected, lines).is_none()
    };
    assert!(fit(&["a", "...", "c … e"], &["a", "b", "b", "c d e"]));
    assert!(fit(&["...", "z"], &["z"]));
    assert!(!fit(&["a", "c"], &["a", "b", "c"]));
    assert!(!fit(&["a"], &["a", "b"]));
    assert!(!fit(&["a … c"], &["a b d"]));
    assert!(!fit(&["a", "..."], &["b"]));
}
