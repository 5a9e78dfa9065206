//! The command line of `design`.

use std::path::PathBuf;

use armbridge_client::params;
use clap::Args;
use toml::Value;

use super::{LinkArgs, numbers, period};

pub(crate) const EXAMPLES: &str = "\
Examples:
  armbridge design --q 30,30,0.3,0.3 --r 10,10 --period 1000
  armbridge design --poles 0.98+0.01i,0.98-0.01i,0.97,0.96 --write gains.toml
  armbridge design --natural 20,20 --damping 1,1 --plot step.svg
  armbridge design --q 30,30,0.3,0.3 --estimator kalman --apply --link serial:

What is not said is as armbridge.toml has it, or the board's default. Poles and margins are
those of the linear loop about upright that the board closes: torque held for a period and
acting a period after the sample, the estimator included; rounding and dry friction left
out. Margins are of the torque: by which factor it may be wrong, by which turn, by which
delay; the disc margin holds for both joints at once, each wrong in its own way. The figure
shows the linear loop and the simulated bench, friction and noise included.";

/// What is designed.
#[derive(Args, Debug)]
pub(crate) struct DesignArgs {
    #[command(flatten)]
    pub(crate) control: DesignControlArgs,
    /// Where the state comes from: luenberger, kalman or difference.
    #[arg(long, value_name = "KIND")]
    pub(crate) estimator: Option<String>,
    /// Tick period in µs.
    #[arg(long, value_name = "US", value_parser = period)]
    pub(crate) period: Option<u32>,
    /// Any other parameter, as `get --all` lists them; may be repeated.
    #[arg(long, value_name = "KEY=VALUE", value_parser = params::pair)]
    pub(crate) set: Vec<(String, Value)>,
    /// The arm and all else that is not said, in a file as armbridge.toml
    /// [default: armbridge.toml itself, if there is one].
    #[arg(long, value_name = "FILE")]
    pub(crate) arm: Option<PathBuf>,
    /// Draw the answer to a step, as this file and its like that ends in .svg or .png.
    #[arg(long, value_name = "FILE")]
    pub(crate) plot: Option<PathBuf>,
    /// Write the controller, the estimator and the period to a file, for `set --from`,
    /// `replay --with` or armbridge.toml.
    #[arg(long, value_name = "FILE")]
    pub(crate) write: Option<PathBuf>,
    /// Send it to the board, as one group.
    #[arg(long)]
    pub(crate) apply: bool,
    /// With --apply, have the board keep it across power-off.
    #[arg(long, requires = "apply")]
    pub(crate) save: bool,
    #[command(flatten)]
    pub(crate) link: LinkArgs,
    /// Print one JSON object instead of the tables.
    #[arg(long)]
    pub(crate) json: bool,
}

/// From state to torque: one of three ways.
#[derive(Args, Debug)]
pub(crate) struct DesignControlArgs {
    /// Diagonal of the LQR's Q: both angles, both speeds.
    #[arg(long, value_name = "A,B,C,D", value_parser = value)]
    pub(crate) q: Option<Value>,
    /// Diagonal of the LQR's R: both torques.
    #[arg(long, value_name = "A,B", value_parser = value)]
    pub(crate) r: Option<Value>,
    /// Poles of the closed loop in z, two for each joint: real ones, or a pair as
    /// 0.98+0.01i,0.98-0.01i. The gain that has them goes to the board.
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

/// Sum and product of each joint's two poles.
#[expect(clippy::float_cmp, reason = "conjugates are typed alike")]
fn poles(text: &str) -> Result<[(f64, f64); 2], String> {
    let pair = |first: (f64, f64), second: (f64, f64)| {
        let (sum, product) = (first.0 + second.0, first.0 * second.0 - first.1 * second.1);
        let is_pair = first.1 == -second.1 && (first.1 == 0.0 || first.0 == second.0);
        let is_inside = [first, second].iter().all(|(re, im)| re.hypot(*im) < 1.0);
        (is_pair && is_inside).then_some((sum, product))
    };
    let parsed = || {
        let poles: Option<Vec<(f64, f64)>> = text.split(',').map(complex).collect();
        let [a, b, c, d]: [(f64, f64); 4] = poles?.try_into().ok()?;
        Some([pair(a, b)?, pair(c, d)?])
    };
    parsed().ok_or_else(|| {
        "expected four poles inside the unit circle, two for each joint, real or a conjugate \
         pair, as 0.98,0.97,0.98+0.01i,0.98-0.01i"
            .into()
    })
}

/// `0.98`, or `0.98+0.01i`.
fn complex(text: &str) -> Option<(f64, f64)> {
    let text = text.trim();
    let Some(pair) = text.strip_suffix('i') else {
        let [re] = numbers(text)?;
        return Some((re, 0.0));
    };
    // The sign between, not the one before or that of an exponent.
    let at = pair.rfind(['+', '-']).filter(|at| *at > 0)?;
    let (re, im) = pair.split_at(at);
    Some((re.trim().parse().ok()?, im.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poles_are_read_in_pairs() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        let [(s1, p1), (s2, p2)] = poles("0.5,-0.25, 0.9+0.1i,0.9-0.1i").unwrap();
        assert!(near(s1, 0.25) && near(p1, -0.125) && near(s2, 1.8) && near(p2, 0.82));
        for wrong in [
            "",
            "0.5",
            "0.5,0.5,0.5,1",
            "0.5,0.9+0.1i,0.9-0.1i,0.5",
            "a,b,c,d",
            "1i,2i,3i,4i",
        ] {
            assert!(poles(wrong).is_err(), "{wrong}");
        }
    }
}
