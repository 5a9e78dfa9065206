//! `armbridge demo`: the code of the board, in this process, in virtual time.

use armbridge::links::{LinkUri, drive};

use super::Outcome;
use super::job::{self, Nobody};
use crate::cli::DemoArgs;

pub(crate) fn run(args: &DemoArgs) -> Outcome {
    let mut options = job::options(args)?;
    if args.port.disarmed {
        return job::left_alone(drive(&LinkUri::Sim, options, Nobody).1);
    }
    let player = job::player(args, "demo", "simulated: bench", true)?;
    options.taps.push(player.tap());
    let (player, result) = drive(&LinkUri::Sim, options, player);
    job::finish(player, result, &args.output)
}
