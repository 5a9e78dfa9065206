//! The arm as a description for a simulator.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge_client::toml_file::Document;
use armbridge_client::{params, stdio};
use armbridge_link::message::Settings;
use armbridge_log::inspect::Head;
use armbridge_log::output_file;
use armbridge_sim::plant::robot_description::RobotFormat;
use armbridge_sim::plant::{BuiltinPlant, PlantConfig, PlantFile};

use super::ExportArgs;
use crate::commands::{Error, Outcome, log};

pub(super) fn run(args: &ExportArgs, format: RobotFormat) -> Outcome {
    let (arm, from) = source(args.log.as_deref())?;
    let text = format.describe(&arm)?;
    let beside = || from.with_extension(format.extension());
    let out = args.out.clone().unwrap_or_else(beside);
    let existing = args.force.existing(args.out.as_ref());
    let written = output_file::write(&out, text.as_bytes(), existing).map_err(|error| {
        let out = out.display();
        format!("cannot write {out}: {error}; or choose another place with --out")
    })?;
    if !output_file::is_stdout(&out) {
        stdio::print_line(written.display())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The arm that is meant, and a path after which the output is named.
fn source(given: Option<&Path>) -> Result<(PlantConfig, PathBuf), Error> {
    if let Some(path) = given
        && let Some(name) = path.to_str()
        && BuiltinPlant::find(name).is_some()
    {
        return Ok((PlantFile::arm(Some(name), None)?, path.into()));
    }
    if let Some(path) = given
        && path
            .extension()
            .is_some_and(|extension| extension == "toml")
    {
        return Ok((in_file(path)?, path.into()));
    }
    let log = log::find(given)?;
    let head = Head::read(&log, |_| ())?;
    let settings = head.settings.ok_or_else(|| {
        let log = log.display();
        format!("{log} has no settings of the board, and so no arm: record from the hello on")
    })?;
    Ok((PlantConfig::of_board(&settings), log))
}

/// The arm of a file with parameters of a board, or of a plant file.
fn in_file(path: &Path) -> Result<PlantConfig, Error> {
    let file = Document::read(path)?;
    if !file.entries().any(|(key, _)| params::find(key).is_some()) {
        return Ok(PlantFile::read(path)?.config([0.0; 2]));
    }
    let mut settings = Settings::default();
    let entries = file.entries().map(|(key, entry)| (key, &entry.value));
    params::apply(&mut settings, entries)
        .map_err(|error| file.wrong_key(error.key(), error.to_string()))?;
    Ok(PlantConfig::of_board(&settings))
}
