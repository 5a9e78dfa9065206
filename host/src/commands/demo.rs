//! `armbridge demo`: the code of the board, in this process, in virtual time.

use std::time::Instant;

use armbridge::bench::Bench;
use armbridge::bench::board::VirtualBoard;
use armbridge::bench::cosim::{Cosim, CosimError};
use armbridge_shared::bridge::Mailboxes;

use super::Outcome;
use super::job::{self, Job};
use crate::cli::RunArgs;

pub(crate) fn run(args: &RunArgs) -> Outcome {
    let job = Job::new(args, "demo", "simulated: bench")?;
    let mut mailboxes = Mailboxes::new();
    let board = VirtualBoard::new(mailboxes.split())
        .map_err(|refusal| format!("the default set-up has no controller: {refusal:?}"))?;
    let bench = Bench::new(job::plant(&args.arm));
    let mut cosim = Cosim::new(board, bench, job);
    let begun = Instant::now();
    match cosim.run() {
        Ok(()) => cosim.host.finish(begun.elapsed()),
        Err(CosimError::Host(error)) => Err(error.into()),
        Err(CosimError::Board(never)) => match never {},
    }
}
