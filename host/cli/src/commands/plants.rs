//! `armbridge plants`: the virtual arms that ship, and the keys of a plant file.

use std::io::Write;
use std::process::ExitCode;

use armbridge_client::stdio::Stdout;
use armbridge_client::toml_file::keys;
use armbridge_log::text_table;
use armbridge_sim::plant::{BuiltinPlant, KEYS, PLANTS, PlantFile};
use clap::Args;
use serde_json::{Value, json};

use super::Outcome;
use crate::args::suggestions::plants;

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge plants                          the virtual arms that ship
  armbridge plants heavy > mine.toml        one of them, to start from
  armbridge plants --explain | less         every key of a plant file
  armbridge run push --plant heavy          a run on one of them";

/// The virtual arms that ship.
#[derive(Args, Debug)]
pub(crate) struct PlantsArgs {
    /// Print the file of this one.
    #[arg(value_parser = plants(), hide_possible_values = true)]
    pub(crate) name: Option<String>,
    /// Print every key of a plant file with its range and meaning.
    #[arg(long, conflicts_with = "name")]
    pub(crate) explain: bool,
    /// Print one JSON array instead of the table.
    #[arg(long, conflicts_with_all = ["name", "explain"])]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &PlantsArgs) -> Outcome {
    let text = match &args.name {
        Some(name) => match BuiltinPlant::find(name) {
            Some(plant) => plant.text.to_owned(),
            // A file is checked, and an unknown name gets the nearest one.
            None => PlantFile::load(name).map(|_| format!("{name} is in order\n"))?,
        },
        None if args.explain => keys::explain(&[KEYS]),
        None if args.json => {
            let plants = PLANTS.iter();
            let rows = plants.map(|plant| json!({ "name": plant.name, "about": plant.about() }));
            format!("{}\n", rows.collect::<Value>())
        }
        None => {
            let plants = PLANTS.iter();
            let rows = plants.map(|plant| vec![plant.name.to_owned(), plant.about()]);
            text_table::columns(&rows.collect::<Vec<_>>())
        }
    };
    Stdout.write_all(text.as_bytes())?;
    Ok(ExitCode::SUCCESS)
}
