//! Every figure is drawn, whatever the run was like. What they look like is
//! for eyes: the files stay in the build folder under `tmp/plot-*`.

use std::path::{Path, PathBuf};

use armbridge_analysis::plot;
use armbridge_link::message::{Fault, Missing, Mode, Record, Sample, Timing};
use armbridge_log::output_file::Existing;
use armbridge_tests::synthetic;

use crate::folder;

/// Largest SVG that still opens at once everywhere.
const LARGEST_SVG_BYTES: u64 = 300_000;

fn draw(name: &str, records: &[Record]) -> Vec<PathBuf> {
    let folder = folder(name);
    let files = plot::draw_all(
        &folder,
        Existing::Number,
        &synthetic::facts(Some(0.06)),
        records,
    )
    .unwrap();
    let names: Vec<_> = files
        .iter()
        .map(|f| f.file_name().unwrap().to_str().unwrap())
        .collect();
    let expected = [
        "angles.svg",
        "angles.png",
        "torque.svg",
        "torque.png",
        "timing.svg",
        "timing.png",
    ];
    assert_eq!(names, expected);
    for file in files.iter().filter(|f| f.extension().unwrap() == "svg") {
        let bytes = file.metadata().unwrap().len();
        assert!(
            bytes < LARGEST_SVG_BYTES,
            "{} has {bytes} bytes",
            file.display()
        );
    }
    files
}

/// Share of the pixels of a PNG that are not white.
fn ink(file: &Path) -> f64 {
    let pixels = tiny_skia::Pixmap::load_png(file).unwrap();
    let white = pixels
        .pixels()
        .iter()
        .filter(|p| p.red() == 255 && p.green() == 255)
        .count();
    1.0 - white as f64 / pixels.pixels().len() as f64
}

#[test]
fn a_run_is_drawn_with_its_texts() {
    let files = draw("plot-run", &synthetic::run(0.0));
    for (file, words) in [(0, "angle (rad)"), (2, "torque (N m)"), (4, "late by (µs)")] {
        let svg = std::fs::read_to_string(&files[file]).unwrap();
        for words in [
            words,
            "time (s)",
            "simulated: bench · seed 1 · period 1000 µs",
        ] {
            assert!(
                svg.contains(words),
                "{words} is missing in {}",
                files[file].display()
            );
        }
    }
    for file in files.iter().filter(|f| f.extension().unwrap() == "png") {
        assert!(
            (0.01..0.5).contains(&ink(file)),
            "{} has {} ink",
            file.display(),
            ink(file)
        );
    }
}

#[test]
fn texts_of_the_png_need_no_installed_font() {
    // The title line: without a font this corner would be empty.
    let files = draw("plot-text", &synthetic::run(0.0)[..2000]);
    let pixels = tiny_skia::Pixmap::load_png(&files[1]).unwrap();
    let dark = (0..500u32)
        .flat_map(|x| (30..75u32).map(move |y| (x, y)))
        .filter(|&(x, y)| pixels.pixel(x, y).is_some_and(|p| p.red() < 100))
        .count();
    assert!(dark > 500, "{dark} dark pixels");
}

#[test]
fn stiction_faults_and_idle_clocks_are_drawn() {
    let mut records = synthetic::run(0.06);
    for record in &mut records {
        record.timing = Timing {
            start_error_us: 0,
            bus_us: 480,
            compute_ns: 0,
            missed: 0,
        };
    }
    for record in &mut records[8000..] {
        record.mode = Mode::Fault(Fault::SamplesLost);
        record.input.samples = [Sample::Missing(Missing::Silence); 2];
    }
    let files = draw("plot-fault", &records);
    let angles = std::fs::read_to_string(&files[0]).unwrap();
    for words in ["fault: samples_lost", "missing sample", "does not settle"] {
        assert!(angles.contains(words), "{words}");
    }
    let timing = std::fs::read_to_string(&files[4]).unwrap();
    assert!(timing.contains("0 µs in every tick") && timing.contains("not measured"));
}

#[test]
fn nothing_and_nonsense_are_drawn_too() {
    draw("plot-empty", &[]);
    let mut records = synthetic::run(0.0)[..30].to_vec();
    for record in &mut records {
        record.output.angle_rad = [f32::NAN, f32::INFINITY];
        record.output.torque_nm = [f32::NAN; 2];
    }
    draw("plot-nan", &records);
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let gone = folder("plot-gone").join("gone");
    let text = plot::draw_all(&gone, Existing::Number, &synthetic::facts(None), &[])
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("cannot write") && text.contains("gone"),
        "{text}"
    );
}
