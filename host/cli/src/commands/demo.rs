//! `armbridge demo`: the code of the board, in this process, in virtual time.

use armbridge_sim::link::{BoardUri, drive};

use super::Outcome;
use super::job::{self, Nobody};
use crate::cli::DemoArgs;

pub(crate) fn run(args: &DemoArgs) -> Outcome {
    let mut options = job::options(args)?;
    if args.port.disarmed {
        return job::left_alone(drive(&BoardUri::Sim, options, Nobody).1);
    }
    let player = job::player(args, "demo", "simulated: bench", true)?;
    options.link.taps.push(player.tap());
    let (player, result) = drive(&BoardUri::Sim, options, player);
    job::finish(player, result, &args.output)
}
