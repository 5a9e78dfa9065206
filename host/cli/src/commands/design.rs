//! `armbridge design`: gains, poles, margins and a step response; to the board or a file.

mod text;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use armbridge::config::Config;
use armbridge_analysis::design;
use armbridge_analysis::design::Design;
use armbridge_analysis::plot::Formats;
use armbridge_client::toml_file::Document;
use armbridge_client::{params, refusal_text, stdio};
use armbridge_link::message::{Controller, Gains, Settings, Setup};
use armbridge_log::output_file;
use armbridge_log::output_file::Existing;
use armbridge_servo::JOINTS;
use clap::Args;
use serde_json::json;
use toml::Value;

use super::params_exchange::{ExchangeOptions, apply};
use super::{Error, Outcome};
use crate::args::values::period;
use crate::args::{ForceArgs, LinkArgs};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge design --q 30,30,0.3,0.3 --r 10,10 --period 1000
  armbridge design --poles 0.98+0.01i,0.98-0.01i,0.97,0.96 --write gains.toml
  armbridge design --natural 20,20 --damping 1,1 --plot step.svg
  armbridge design --q 30,30,0.3,0.3 --estimator kalman --apply --link serial:

Unspecified options are taken from armbridge.toml, or the board's defaults.
Poles and margins are those of the linear loop about upright that the board
closes: torque held for a period and acting a period after the sample, the
estimator included, rounding and dry friction left out. Margins are of the
torque: the gain, phase and delay errors that it may have; the disc margin holds
for both joints at once, with different errors. The figure shows the linear loop
and the simulation, friction and noise included.";

/// A design.
#[derive(Args, Debug)]
pub(crate) struct DesignArgs {
    #[command(flatten)]
    pub(crate) control: DesignControlArgs,
    /// State estimator: luenberger, kalman or difference.
    #[arg(long, value_name = "KIND")]
    pub(crate) estimator: Option<String>,
    /// Tick period in µs.
    #[arg(long, value_name = "US", value_parser = period)]
    pub(crate) period: Option<u32>,
    /// Any other parameter, as `params --all` lists them; may be repeated.
    #[arg(long, value_name = "KEY=VALUE", value_parser = params::pair)]
    pub(crate) set: Vec<(String, Value)>,
    /// File with the arm and all unspecified options, in the format of armbridge.toml
    /// [default: armbridge.toml itself, if there is one].
    #[arg(long, value_name = "FILE")]
    pub(crate) arm: Option<PathBuf>,
    /// Draw the step response to this .svg or .png; without an ending, to both.
    #[arg(long, value_name = "FILE", value_parser = figure)]
    pub(crate) plot: Option<PathBuf>,
    /// Write the controller, the estimator and the period to a file, for `params --from`,
    /// `replay --with` or armbridge.toml.
    #[arg(long, value_name = "FILE")]
    pub(crate) write: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Send the design to the board, as one group.
    #[arg(long)]
    pub(crate) apply: bool,
    /// With --apply, save it on the board, so that it survives power-off.
    #[arg(long, requires = "apply")]
    pub(crate) save: bool,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Print one JSON object instead of the tables.
    #[arg(long)]
    pub(crate) json: bool,
}

/// From state to torque: one of three methods.
#[derive(Args, Debug)]
pub(crate) struct DesignControlArgs {
    /// Diagonal of the LQR's Q: both angles, both speeds.
    #[arg(long, value_name = "A,B,C,D", value_parser = value)]
    pub(crate) q: Option<Value>,
    /// Diagonal of the LQR's R: both torques.
    #[arg(long, value_name = "A,B", value_parser = value)]
    pub(crate) r: Option<Value>,
    /// Poles of the closed loop in z, two for each joint: real ones, or a pair as
    /// 0.98+0.01i,0.98-0.01i. The resulting gain goes to the board.
    #[arg(long, value_name = "P,P,P,P", value_parser = poles,
          conflicts_with_all = ["q", "r", "natural", "damping"], allow_hyphen_values = true)]
    pub(crate) poles: Option<[(f64, f64); 2]>,
    /// Computed torque: natural frequencies of the errors, in rad/s.
    #[arg(long, value_name = "W1,W2", conflicts_with_all = ["q", "r"],
          value_parser = value)]
    pub(crate) natural: Option<Value>,
    /// Computed torque: damping ratios of the errors.
    #[arg(long, value_name = "Z1,Z2", conflicts_with_all = ["q", "r"],
          value_parser = value)]
    pub(crate) damping: Option<Value>,
}

/// Checked with the parameter that it is for.
#[expect(clippy::unnecessary_wraps, reason = "the shape that clap asks for")]
fn value(text: &str) -> Result<Value, std::convert::Infallible> {
    Ok(params::of_text(text))
}

/// A file that a figure can be drawn to.
fn figure(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let formats = Formats::of_file(&path).map_err(|error| error.to_string());
    formats.map(|_| path)
}

/// Sum and product of each joint's two poles.
fn poles(text: &str) -> Result<[(f64, f64); 2], String> {
    let parsed = || {
        let [a, b, c, d]: [(f64, f64); 4] = params::complex_numbers(text)?.try_into().ok()?;
        Some([design::pole_pair([a, b])?, design::pole_pair([c, d])?])
    };
    parsed().ok_or_else(|| {
        "expected four poles inside the unit circle, two for each joint, real or a conjugate \
         pair, as 0.98,0.97,0.98+0.01i,0.98-0.01i"
            .into()
    })
}

pub(crate) fn run(args: &DesignArgs) -> Outcome {
    let settings = settings(args)?;
    let setup = settings.setup;
    let design = Design::from_setup(&setup).map_err(|why| {
        format!(
            "the board would refuse this set-up: {}",
            refusal_text::in_words(why)
        )
    })?;
    if args.json {
        let parameters = params::to_table(designed(&settings));
        let report = json!({ "parameters": parameters, "design": design });
        stdio::print_line(report)?;
    } else {
        stdio::print(text::as_text(&settings, &design))?;
    }
    if let Some(path) = &args.write {
        write_file(path, &settings, args.force.chosen())?;
    }
    if let Some(path) = &args.plot {
        // The steps take a while: a file that is in the way is reported first.
        let formats = Formats::of_file(path)?;
        let endings = [("svg", formats.svg), ("png", formats.png)];
        for (ending, _) in endings.into_iter().filter(|(_, is_drawn)| *is_drawn) {
            args.force.check(&path.with_extension(ending))?;
        }
        for file in design::draw_step(&setup, path, args.force.chosen())? {
            say(args, &format!("drawn: {}", file.display()))?;
        }
    }
    if !design.is_stable {
        stdio::note("armbridge: the loop with this estimator is unstable: nothing was sent");
        return Ok(ExitCode::from(1));
    }
    if args.apply {
        let options = ExchangeOptions {
            link: &args.link,
            save: args.save,
            dry_run: false,
            json: false,
        };
        let names = designed(&settings);
        return apply(&options, |before| {
            let pairs = names
                .iter()
                .map(|(parameter, value)| (parameter.key, value));
            Ok(params::replaced(before, pairs)?)
        });
    }
    Ok(ExitCode::SUCCESS)
}

/// Prints text; on standard error beside a JSON object.
fn say(args: &DesignArgs, line: &str) -> Result<(), Error> {
    if !args.json {
        stdio::print_line(line)?;
    }
    Ok(())
}

/// The board's defaults, overridden by the file, then by the command line.
fn settings(args: &DesignArgs) -> Result<Settings, Error> {
    let mut settings = match &args.arm {
        Some(path) => Config::of(Some(path), |_| None)?.settings(Settings::default())?,
        None => Config::discover()?.settings(Settings::default())?,
    };
    let overrides = overrides(args);
    params::apply(
        &mut settings,
        overrides.iter().map(|(key, value)| (key.as_str(), value)),
    )?;
    if let Some(poles) = args.control.poles {
        settings.setup.controller = placed(&settings.setup, poles)?;
    }
    params::check(&settings)?;
    Ok(settings)
}

/// The command line's options, as parameters.
fn overrides(args: &DesignArgs) -> Vec<(String, Value)> {
    let DesignControlArgs {
        q,
        r,
        natural,
        damping,
        poles: _,
    } = &args.control;
    let mut overrides = Vec::new();
    let mut set = |key: &str, value: Option<Value>| {
        if let Some(value) = value {
            overrides.push((key.to_owned(), value));
        }
    };
    let kind = if q.is_some() || r.is_some() {
        Some("lqr".into())
    } else if natural.is_some() || damping.is_some() {
        Some("computed-torque".into())
    } else {
        None
    };
    set("controller.kind", kind);
    set("controller.q", q.clone());
    set("controller.r", r.clone());
    set("controller.natural_rad_s", natural.clone());
    set("controller.damping", damping.clone());
    set("estimator.kind", args.estimator.clone().map(Value::from));
    set(
        "setup.period_us",
        args.period.map(|us| i64::from(us).into()),
    );
    overrides.extend(args.set.iter().cloned());
    overrides
}

fn placed(setup: &Setup, poles: [(f64, f64); JOINTS]) -> Result<Controller, Error> {
    let gain = design::place(setup, poles)?;
    Ok(Controller::StateFeedback(Gains::Given(gain)))
}

/// The parameters that a design is about: of set-up, controller and estimator.
fn designed(settings: &Settings) -> Vec<(&'static params::Parameter, Value)> {
    let mut pairs = params::pairs(settings);
    pairs
        .retain(|(parameter, _)| ["setup", "controller", "estimator"].contains(&parameter.group()));
    pairs
}

fn write_file(path: &Path, settings: &Settings, existing: Existing) -> Result<(), Error> {
    let table = params::to_table(designed(settings));
    let text = format!("# Made by `armbridge design`.\n{table}");
    // Checked before it is written: the file can be read again.
    Document::parse(path, text.clone())?;
    output_file::write(path, text.as_bytes(), existing)
        .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poles_are_read_in_pairs() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        let [(s1, p1), (s2, p2)] = poles("0.5,-0.25, 0.9+0.1i,0.9-0.1i").unwrap();
        assert!(near(s1, 0.25) && near(p1, -0.125) && near(s2, 1.8) && near(p2, 0.82));
        let [(s1, p1), _] = poles("9e-1+1e-1i,9e-1-1e-1i,0.5±0.1i").unwrap();
        assert!(near(s1, 1.8) && near(p1, 0.82));
        for wrong in [
            "",
            "0.5",
            "nan,0.5,0.5,0.5",
            "0.5,0.5,0.5,1",
            "0.5,0.9+0.1i,0.9-0.1i,0.5",
            "a,b,c,d",
            "1i,2i,3i,4i",
        ] {
            assert!(poles(wrong).is_err(), "{wrong}");
        }
    }
}
