//! The command line of `servos`.

use armbridge_client::transport::LinkUri;
use armbridge_shared::servo::Firmware;
use armbridge_sim::kind;
use armbridge_sim::kind::{KindError, ServoKind};
use clap::Args;

use super::ArmArgs;

/// Rates that a bus can have: what a stock servo has at the least, and what
/// Morpheus has at the most.
const BAUDS: std::ops::RangeInclusive<i64> = 7_843..=2_000_000;

/// Virtual servos for other programs.
#[derive(Args, Debug)]
pub(crate) struct ServosArgs {
    #[command(flatten)]
    pub(crate) at: ServosAt,
    /// What runs on the servos, morpheus or stock: one for all, or one each.
    #[arg(
        long,
        value_name = "NAME[,NAME]",
        value_delimiter = ',',
        value_parser = kind::firmware,
        default_value = "morpheus"
    )]
    firmware: Vec<Firmware>,
    /// Their ids. The first two turn the arm's joints, any others nothing.
    #[arg(
        long,
        value_name = "ID[,ID]",
        value_delimiter = ',',
        default_value = "1,2",
        value_parser = clap::value_parser!(u8).range(0..=253)
    )]
    ids: Vec<u8>,
    /// Baud rate that is stored in the servos: one for all, or one each.
    #[arg(
        long,
        value_name = "BAUD[,BAUD]",
        value_delimiter = ',',
        default_value = "1000000"
    )]
    servo_baud: Vec<u32>,
    /// Baud rate of whoever connects over TCP. On the pseudo-terminal it is
    /// what the other side sets.
    #[arg(long, value_name = "BAUD", default_value_t = 1_000_000, conflicts_with = "pty",
          value_parser = clap::value_parser!(u32).range(BAUDS))]
    pub(crate) baud: u32,
    /// Send back what comes in, as a single-wire bus that hears itself.
    #[arg(long)]
    pub(crate) echo: bool,
    /// How many times slower than the wall clock the servos' time runs.
    #[arg(long, value_name = "TIMES", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) slow: u32,
    #[command(flatten)]
    pub(crate) arm: ArmArgs,
}

/// Where the bus is offered.
#[derive(Args, Debug)]
#[group(required = true, multiple = false)]
pub(crate) struct ServosAt {
    /// On a TCP port, to one program at a time, or as `pty:` on a new
    /// pseudo-terminal, whose name is printed.
    #[arg(long, value_name = "tcp://HOST:PORT|pty:")]
    pub(crate) listen: Option<LinkUri>,
    /// The same as `--listen pty:`.
    #[arg(long)]
    pub(crate) pty: bool,
}

/// Why there are no such servos.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ServosError {
    /// Lists of different lengths.
    #[error("{ids} ids, but {count} values after {option}: expected one, or one for each id")]
    Count {
        /// Which list does not fit.
        option: &'static str,
        count: usize,
        ids: usize,
    },
    /// No such servo.
    #[error(transparent)]
    Kind(#[from] KindError),
}

impl ServosArgs {
    /// The servos that are asked for.
    pub(crate) fn kinds(&self) -> Result<Vec<ServoKind>, ServosError> {
        let ids = self.ids.len();
        let firmware = one_each(&self.firmware, "--firmware", ids)?;
        let baud = one_each(&self.servo_baud, "--servo-baud", ids)?;
        let servos = self.ids.iter().zip(firmware).zip(baud);
        servos
            .map(|((id, firmware), baud)| Ok(ServoKind::new(firmware, *id, baud)?))
            .collect()
    }
}

/// One value for each of `ids` servos.
fn one_each<T: Copy>(
    values: &[T],
    option: &'static str,
    ids: usize,
) -> Result<Vec<T>, ServosError> {
    match values {
        [one] => Ok(vec![*one; ids]),
        each if each.len() == ids => Ok(each.to_vec()),
        _ => Err(ServosError::Count {
            option,
            count: values.len(),
            ids,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::{Cli, Command};
    use clap::Parser;

    fn kinds(args: &[&str]) -> Result<Vec<ServoKind>, String> {
        let args = [
            &["armbridge", "servos", "--listen", "tcp://127.0.0.1:0"],
            args,
        ]
        .concat();
        let cli = Cli::try_parse_from(args).map_err(|error| error.to_string())?;
        match cli.command {
            Some(Command::Servos(args)) => args.kinds().map_err(|error| error.to_string()),
            _ => unreachable!("servos was asked for"),
        }
    }

    #[test]
    fn one_value_is_for_all_and_several_for_one_each() {
        let kind = |firmware, id, baud| ServoKind::new(firmware, id, baud).unwrap();
        let (morpheus, stock) = (Firmware::Morpheus, Firmware::Stock);
        assert_eq!(
            kinds(&[]).unwrap(),
            [kind(morpheus, 1, 1_000_000), kind(morpheus, 2, 1_000_000)]
        );
        let mixed = ["--firmware", "stock,morpheus,stock", "--ids", "1,2,7"];
        assert_eq!(
            kinds(&[&mixed[..], &["--servo-baud", "57600"]].concat()).unwrap(),
            [
                kind(stock, 1, 57_600),
                kind(morpheus, 2, 57_600),
                kind(stock, 7, 57_600)
            ]
        );
    }

    #[test]
    fn mistakes_are_named() {
        for (args, word) in [
            (["--firmware", "xl430"].as_slice(), "morpheus or stock"),
            (&["--ids", "1,254"], "0..=253"),
            (&["--ids", "0"], "1 to 253"),
            (&["--servo-baud", "1,2,3"], "one for each id"),
            (&["--servo-baud", "750000"], "no rate of 750000"),
            (&["--baud", "300"], "7843"),
            (&["--pty", "--baud", "57600"], "cannot be used with"),
        ] {
            let error = kinds(args).unwrap_err();
            assert!(error.contains(word), "{args:?}: {error}");
        }
    }
}
