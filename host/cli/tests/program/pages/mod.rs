//! Pages in a browser: no errors of scripts, nothing wider than the window, from 400 px up,
//! light and dark.

mod browser;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use browser::{Browser, Tab, Window};

/// Windows in which every page is right.
const WINDOWS: [Window; 4] = [
    Window {
        width: 1280,
        is_dark: false,
    },
    Window {
        width: 1280,
        is_dark: true,
    },
    Window {
        width: 400,
        is_dark: false,
    },
    Window {
        width: 400,
        is_dark: true,
    },
];

/// Largest size of the page of a run, in bytes.
const SIZE_MAX: u64 = 2_000_000;

/// Runs the program in a folder.
fn program(folder: &Path, args: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_armbridge"))
        .args(args)
        .current_dir(folder)
        .env_remove("ARMBRIDGE_LINK")
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    // A run that does not meet its expectations is shown as well.
    let has_run = output.status.code().is_some_and(|code| code < 2);
    assert!(has_run, "{args:?}: {stderr}");
}

/// Runs a scenario; returns its folder.
fn run(folder: &Path, args: &[&str]) -> PathBuf {
    let before = run_folders(folder);
    program(folder, &[&["run"], args].concat());
    let after = run_folders(folder);
    let new = after.into_iter().find(|run| !before.contains(run));
    new.expect("a new run folder")
}

fn run_folders(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder.join("runs")).into_iter().flatten();
    entries.map(|entry| entry.unwrap().path()).collect()
}

/// Complaints about a page in all windows.
fn complaints(browser: &mut Browser, page: &Path) -> Vec<String> {
    let mut complaints = Vec::new();
    for window in WINDOWS {
        let mut tab = browser.open(page, window);
        let (beyond_px, element) = tab.overflow();
        if beyond_px > 0.0 {
            complaints.push(format!(
                "{window:?}: {beyond_px} px beyond the window: {element}"
            ));
        }
        let errors = tab.errors();
        complaints.extend(errors.iter().map(|error| format!("{window:?}: {error}")));
    }
    complaints
}

fn assert_right(browser: &mut Browser, page: &Path) {
    let complaints = complaints(browser, page);
    assert!(complaints.is_empty(), "{}: {complaints:#?}", page.display());
}

/// Number of the page's state.
fn number(tab: &mut Tab<'_>, expression: &str) -> f64 {
    let value = tab.value(expression);
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{expression}: {value}"))
}

#[test]
fn the_page_of_a_run_is_self_contained() {
    let folder = crate::folder("pages-contents");
    let run = run(
        &folder,
        &["upright", "--duration", "3", "--set", "limits.hold_ms=120"],
    );
    let text = fs::read_to_string(run.join("run.html")).unwrap();
    for address in ["http:", "https:", "src=", "@import", "url("] {
        assert!(!text.contains(address), "{address}");
    }
    let name = run.file_name().unwrap().to_str().unwrap();
    let replay = format!("armbridge replay runs/{name}/run.mcap");
    for expected in [
        "default-src 'none'",
        "Different from the defaults",
        &replay,
        "angles.png",
    ] {
        assert!(text.contains(expected), "no {expected:?}");
    }
    let (_, data) = text.split_once("id=\"data\">").unwrap();
    let (data, _) = data.split_once("</script>").unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    let series = data["runs"][0]["curves"]["series"].as_object().unwrap();
    for name in [
        "encoder1",
        "angle2",
        "reference1",
        "error2",
        "speed1",
        "torque2",
    ] {
        assert!(series.contains_key(name), "{name}");
    }
    let times = &data["runs"][0]["curves"]["times"];
    let [from, count] = ["from", "count"].map(|key| times[key].as_f64().unwrap());
    assert!(from < 0.0 && count > 3_000.0, "{times}");
    assert!(
        (data["to"].as_f64().unwrap() - 3.0).abs() < 0.01,
        "{}",
        data["to"]
    );
    let events = data["events"].as_array().unwrap();
    let commands = events.iter().filter(|event| event["kind"] == "command");
    assert!(
        commands
            .clone()
            .any(|event| event["text"] == "hold at +0.00 and +0.00 rad")
    );
    let first = commands.filter(|event| event["text"].as_str().unwrap().starts_with("hold"));
    let first_s = first.map(|event| event["time"].as_f64().unwrap()).next();
    assert!(first_s.unwrap().abs() < 0.01, "{first_s:?}");
}

#[test]
#[ignore = "needs Chromium: run `cargo verify`"]
fn the_page_of_a_run_is_right_and_obeys_mouse_and_keys() {
    let folder = crate::folder("pages-run");
    let page = run(&folder, &["push"]).join("run.html");
    assert!(fs::metadata(&page).unwrap().len() < SIZE_MAX);
    let mut browser = Browser::start(&folder);
    assert_right(&mut browser, &page);

    let mut tab = browser.open(&page, WINDOWS[0]);
    has_contents(&mut tab);
    obeys_keys(&mut tab);
    obeys_mouse(&mut tab);
    assert_eq!(tab.errors(), [""; 0]);
    drop(tab);

    // The checks themselves: a page with a broken script, one that needs the network, and one
    // that is too wide must fail.
    let text = fs::read_to_string(&page).unwrap();
    let breaks = [
        ("new Timeline()", "new Timelime()"),
        (
            "seek(Math.max",
            "fetch('https://example.org'); seek(Math.max",
        ),
        ("<footer>", "<footer style=\"width: 1300px\">"),
    ];
    for (sound, broken) in breaks {
        assert!(text.contains(sound), "{sound}");
        let page = folder.join("broken.html");
        fs::write(&page, text.replace(sound, broken)).unwrap();
        let found = complaints(&mut browser, &page);
        assert!(found.len() >= 4, "{broken}: {found:?}");
    }
}

#[test]
#[ignore = "needs Chromium: run `cargo verify`"]
fn the_demo_shows_its_baseline_in_grey() {
    let folder = crate::folder("pages-demo");
    let page = run(&folder, &["demo"]).join("run.html");
    assert!(fs::metadata(&page).unwrap().len() < SIZE_MAX);
    let mut browser = Browser::start(&folder);
    assert_right(&mut browser, &page);
    let mut tab = browser.open(&page, WINDOWS[0]);
    let both = "[RUN, BESIDE].map(run => run.pose(3) !== null)";
    assert_eq!(tab.value(both), serde_json::json!([true, true]));
    assert_eq!(tab.value("Math.round(DATA.pushes[0][0] * 100)"), 200);
    let headline = tab.value("document.querySelector('h1').textContent");
    let headline = headline.as_str().unwrap().replace('\u{a0}', " ");
    for expected in [
        "all 3 setpoints in at most 0.",
        "recovers from a push in 0.",
    ] {
        assert!(headline.contains(expected), "{headline}");
    }
}

#[test]
#[ignore = "needs Chromium: run `cargo verify`"]
fn an_hour_makes_no_larger_page() {
    let folder = crate::folder("pages-hour");
    let page = run(&folder, &["hour", "--duration", "120"]).join("run.html");
    assert!(fs::metadata(&page).unwrap().len() < SIZE_MAX);
    let mut browser = Browser::start(&folder);
    assert_right(&mut browser, &page);
}

#[test]
#[ignore = "needs Chromium: run `cargo verify`"]
fn reports_are_right() {
    let folder = crate::folder("pages-reports");
    let multisine = run(&folder, &["multisine"]);
    let log = multisine.join("run.mcap");
    let log = log.to_str().unwrap();
    program(&folder, &["identify", "fit", log, "--report", "fit"]);
    program(&folder, &["paper", "--quiet"]);
    let paper = run_folders(&folder)
        .into_iter()
        .map(|run| run.join("report.html"))
        .find(|page| page.is_file())
        .expect("the report on the paper");
    let mut browser = Browser::start(&folder);
    for page in [folder.join("fit/report.html"), paper] {
        assert_right(&mut browser, &page);
    }
}

/// Curves, events, files and settings are there, and each canvas has a drawing on it.
fn has_contents(tab: &mut Tab<'_>) {
    // Each canvas has a drawing on it.
    let blank =
        "[...document.querySelectorAll('#arm, #overview, .stack canvas:first-child')].filter(
        canvas => new Set(new Uint32Array(canvas.getContext('2d').getImageData(
            0, 0, canvas.width, canvas.height).data.buffer)).size < 4).length";
    tab.errors();
    assert_eq!(tab.value(blank), 0);
    // Curves, events, files and settings are there.
    assert_eq!(tab.value("panels.length"), 5);
    assert!(number(tab, "document.querySelectorAll('#events tbody tr').length") > 8.0);
    // The scenario's pushes, with their times.
    let pushes = tab.value("DATA.pushes.map(push => Math.round(push[0] * 100) / 100)");
    assert_eq!(pushes, serde_json::json!([3, 6, 9, 12]));
    assert!(number(tab, "document.querySelectorAll('#files li').length") > 1.0);
    assert!(
        number(
            tab,
            "document.querySelectorAll('#settings tbody tr').length"
        ) > 40.0
    );
}

fn obeys_keys(tab: &mut Tab<'_>) {
    // Keys: events, zoom, playback.
    tab.value("seek(2.5)");
    tab.press("]");
    let time = number(tab, "app.time");
    assert!((time - 3.0).abs() < 0.01, "{time}");
    tab.press("+");
    let span = "app.range[1] - app.range[0]";
    let zoomed = number(tab, span);
    assert!(zoomed < 10.0, "{zoomed}");
    tab.press("0");
    assert!(number(tab, span) > 15.0);
    tab.press(" ");
    let moved = "new Promise(done => setTimeout(() => done(app.time), 400))";
    assert!(number(tab, moved) > 3.05);
    tab.press(" ");
    assert_eq!(tab.value("app.isPlaying"), false);
}

fn obeys_mouse(tab: &mut Tab<'_>) {
    // A drag zooms, a click seeks, an event is jumped to.
    let place = "(() => { panels[0].overlay.scrollIntoView({ block: 'center' });
        const box = panels[0].overlay.getBoundingClientRect();
        return [box.left + panels[0].x(4), box.left + panels[0].x(6), box.top + 50]; })()";
    let place = tab.value(place);
    let [from, to, y] = [0, 1, 2].map(|index| place[index].as_f64().unwrap());
    tab.mouse("mousePressed", (from, y));
    tab.mouse("mouseMoved", (f64::midpoint(from, to), y));
    tab.mouse("mouseMoved", (to, y));
    tab.mouse("mouseReleased", (to, y));
    let shown = tab.value("app.range");
    for (index, expected) in [4.0, 6.0].into_iter().enumerate() {
        assert!(
            (shown[index].as_f64().unwrap() - expected).abs() < 0.05,
            "{shown}"
        );
    }
    tab.mouse("mousePressed", (from + 0.5 * (to - from), y));
    tab.mouse("mouseReleased", (from + 0.5 * (to - from), y));
    let time = number(tab, "app.time");
    assert!((4.0..6.0).contains(&time), "{time}");
    tab.value("[...document.querySelectorAll('#events .jump')].at(-1).click()");
    assert_eq!(tab.value("app.time === DATA.events.at(-1).time"), true);
    tab.value("document.querySelector('#settings details').open = true");
    tab.value(
        "{ const search = document.querySelector('#settings input');
        search.value = 'controller.q'; search.dispatchEvent(new Event('input')); }",
    );
    let found = "[...document.querySelectorAll('#settings tbody tr:not(.group)')].filter(row => !row.hidden).length";
    assert!((1.0..5.0).contains(&number(tab, found)));
}
