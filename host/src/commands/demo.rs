//! `armbridge demo`: the code of the board, in this process, in virtual time.

use std::process::ExitCode;
use std::time::Instant;

use armbridge::bench::board::VirtualBoard;
use armbridge::bench::cosim::{Cosim, CosimError};
use armbridge_shared::bridge::Mailboxes;

use super::Outcome;
use super::job::{self, Job, Nobody};
use crate::cli::RunArgs;

pub(crate) fn run(args: &RunArgs) -> Outcome {
    let mut mailboxes = Mailboxes::new();
    let board = VirtualBoard::new(mailboxes.split())
        .map_err(|refusal| format!("the default set-up has no controller: {refusal:?}"))?;
    let bench = job::bench(args)?;
    if args.port.disarmed {
        let mut cosim = job::with_port(Cosim::new(board, bench, Nobody), &args.port)?;
        return match cosim.run() {
            Ok(()) => Ok(ExitCode::SUCCESS),
            Err(CosimError::Host(never) | CosimError::Board(never)) => match never {},
        };
    }
    let job = Job::new(args, "demo", "simulated: bench")?;
    let mut cosim = job::with_port(Cosim::new(board, bench, job), &args.port)?;
    let begun = Instant::now();
    match cosim.run() {
        Ok(()) => cosim.host.finish(begun.elapsed()),
        Err(CosimError::Host(error)) => Err(error.into()),
        Err(CosimError::Board(never)) => match never {},
    }
}
