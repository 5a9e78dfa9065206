//! `armbridge serve servos`: the virtual servos in wall-clock time.

use std::collections::HashSet;

use armbridge_client::endpoint::Endpoint;
use armbridge_client::transport::LinkUri;
use armbridge_client::{ctrl_c, stdio};
use armbridge_servo::Firmware;
use armbridge_sim::plant::Plant;
use armbridge_sim::raw_bus_server::WallClockBench;
use armbridge_sim::servo_kind::{KindError, ServoKind};
use armbridge_sim::{Bench, servo_kind};
use clap::Args;

use super::super::{Error, virtual_arm};
use crate::args::listen::{FORMS, listen_at};
use crate::args::{ArmArgs, ExposeArgs};

/// Rates that a bus can have: what a stock servo has at the least, and what
/// Morpheus has at the most.
const BAUDS: std::ops::RangeInclusive<i64> = 7_843..=2_000_000;

/// Virtual servos for other programs.
#[derive(Args, Debug)]
pub(crate) struct ServosArgs {
    /// Serve on a TCP port, to one program at a time, or by `pty:` on a new
    /// pseudo-terminal, whose name is printed.
    #[arg(long, value_name = FORMS, value_parser = listen_at)]
    pub(crate) listen: LinkUri,
    #[command(flatten)]
    pub(crate) expose: ExposeArgs,
    /// Firmware of the servos, morpheus, stock or x: one for all, or one for each. Stock
    /// servos speak Dynamixel Protocol 1.0 and those of the X series Protocol 2.0, as the
    /// vendor's SDK does; Morpheus ones do not [default: morpheus, or x if the arm has its
    /// encoders].
    #[arg(
        long,
        value_name = "NAME[,NAME]",
        value_delimiter = ',',
        value_parser = servo_kind::firmware,
    )]
    firmware: Vec<Firmware>,
    /// Ids of the servos. The first two drive the arm's joints, any others nothing.
    #[arg(
        long,
        value_name = "ID[,ID]",
        value_delimiter = ',',
        default_value = "1,2",
        value_parser = clap::value_parser!(u8).range(0..=253)
    )]
    ids: Vec<u8>,
    /// Baud rate stored in the servos: one for all, or one for each.
    #[arg(
        long,
        value_name = "BAUD[,BAUD]",
        value_delimiter = ',',
        default_value = "1000000"
    )]
    servo_baud: Vec<u32>,
    /// Baud rate of the program that connects over TCP. On the pseudo-terminal the
    /// program sets it.
    #[arg(long, value_name = "BAUD", default_value_t = 1_000_000,
          value_parser = clap::value_parser!(u32).range(BAUDS))]
    pub(crate) baud: u32,
    /// Echo received bytes, as a single-wire bus does.
    #[arg(long)]
    pub(crate) echo: bool,
    /// Run the servos' time this many times slower than the wall clock.
    #[arg(long, value_name = "TIMES", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) slow: u32,
    #[command(flatten)]
    pub(crate) arm: ArmArgs,
}

/// Why servos cannot be made.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ServosError {
    /// Lists of different lengths.
    #[error("{ids} ids, but {count} values after {option}: expected one, or one for each id")]
    Count {
        /// Option of the list that does not fit.
        option: &'static str,
        count: usize,
        ids: usize,
    },
    /// Two servos of one bus would answer at once.
    #[error("id {0} is given to two {1} servos: expected another id for each")]
    Repeated(u8, Firmware),
    /// No such servo.
    #[error(transparent)]
    Kind(#[from] KindError),
}

impl ServosArgs {
    /// The servos that are asked for; `own` is the firmware of those whose encoders the arm has.
    pub(crate) fn kinds(&self, own: Firmware) -> Result<Vec<ServoKind>, ServosError> {
        let ids = self.ids.len();
        let firmware = match self.firmware.as_slice() {
            [] => vec![own; ids],
            each => one_each(each, "--firmware", ids)?,
        };
        let baud = one_each(&self.servo_baud, "--servo-baud", ids)?;
        let mut known = HashSet::new();
        let mut servos = self.ids.iter().zip(&firmware);
        // Those of the other firmware leave its packets unanswered.
        if let Some((id, firmware)) = servos.find(|servo| !known.insert(*servo)) {
            return Err(ServosError::Repeated(*id, *firmware));
        }
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

pub(super) fn run(args: &ServosArgs) -> Result<(), Error> {
    let config = virtual_arm::config(&args.arm)?;
    let firmware = args.firmware.first();
    let config = firmware.map_or(config, |first| config.with_servos(*first));
    let kinds = args.kinds(config.firmware())?;
    let mut bench = Bench::with_servos(Plant::new(config, args.arm.seed), &kinds);
    bench.set_baud(args.baud);
    let mut bench = WallClockBench::new(bench, args.slow).interrupted_by(ctrl_c::is_raised);
    let who = in_words(&kinds);
    match &args.listen {
        LinkUri::Tcp(endpoint) => on_tcp(args, &who, endpoint, &mut bench),
        LinkUri::Pty(None) => on_pty(args, &who, &mut bench),
        // Not parsed as an argument.
        other @ (LinkUri::Usb(_) | LinkUri::Serial(_) | LinkUri::Pty(Some(_))) => Err(format!(
            "servos cannot be offered on {other}: expected tcp://HOST:PORT or pty:"
        )
        .into()),
    }
}

/// As "1 (morpheus, 1000000 baud) and 2 (stock, 1000000 baud)".
fn in_words(kinds: &[ServoKind]) -> String {
    let each: Vec<String> = kinds.iter().map(ToString::to_string).collect();
    each.join(" and ")
}

/// Protocol of servos with these firmwares, and how to get the other.
fn protocol(firmware: &[Firmware]) -> &'static str {
    if firmware.contains(&Firmware::XSeries) {
        return "those of the X series speak Dynamixel Protocol 2.0, as the vendor's SDK does";
    }
    match (
        firmware.contains(&Firmware::Morpheus),
        firmware.contains(&Firmware::Stock),
    ) {
        (_, false) => {
            "they speak Morpheus packets; Protocol 1.0, as the vendor's SDK does, with\n  \
             --firmware stock"
        }
        (false, true) => {
            "they speak Dynamixel Protocol 1.0, as the vendor's SDK does; Morpheus packets\n  \
             with --firmware morpheus"
        }
        (true, true) => {
            "the stock ones speak Dynamixel Protocol 1.0, as the vendor's SDK does, the others\n  \
             Morpheus packets"
        }
    }
}

fn on_tcp(
    args: &ServosArgs,
    who: &str,
    endpoint: &Endpoint,
    bench: &mut WallClockBench,
) -> Result<(), Error> {
    let (listener, at) = endpoint.listen(args.expose.into())?;
    stdio::note(format_args!(
        "virtual servos {who} on {at}, raw bus bytes at {} baud; end with ctrl-c",
        args.baud
    ));
    stdio::note(protocol(&args.firmware));
    let mut next = None;
    loop {
        let connection = match next.take() {
            Some(next) => Some(next),
            None => bench.accept(&listener)?,
        };
        let Some((stream, peer)) = connection.filter(|_| !ctrl_c::is_raised()) else {
            return Ok(());
        };
        stdio::note(format_args!("{peer} is on the bus"));
        match bench.serve_socket(&stream, &listener, args.echo) {
            Ok(_) if ctrl_c::is_raised() => return Ok(()),
            Ok(waiting) => {
                next = waiting;
                stdio::note(format_args!(
                    "{peer} has left; the servos keep their last commands"
                ));
            }
            Err(error) => stdio::note(format_args!("{peer} is gone: {error}")),
        }
    }
}

#[cfg(unix)]
fn on_pty(args: &ServosArgs, who: &str, bench: &mut WallClockBench) -> Result<(), Error> {
    use armbridge_client::pty::Pty;

    let pty = Pty::open()?;
    let ours = pty.controller()?;
    stdio::note(format_args!(
        "virtual servos {who}, raw bus bytes; end with ctrl-c"
    ));
    stdio::note(protocol(&args.firmware));
    stdio::print_line(pty.name())?;
    let baud = move || Pty::baud(&ours);
    bench.serve(pty.controller()?, pty.controller()?, baud, args.echo)?;
    Ok(())
}

#[cfg(not(unix))]
fn on_pty(_: &ServosArgs, _: &str, _: &mut WallClockBench) -> Result<(), Error> {
    Err("there are no pseudo-terminals on this system: use --listen tcp://127.0.0.1:PORT".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: ServosArgs,
    }

    fn kinds(args: &[&str]) -> Result<Vec<ServoKind>, String> {
        let args = [&["servos", "--listen", "tcp://127.0.0.1:0"], args].concat();
        let line = Line::try_parse_from(args).map_err(|error| error.to_string())?;
        line.args
            .kinds(Firmware::Morpheus)
            .map_err(|error| error.to_string())
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
            (["--firmware", "xl430"].as_slice(), "morpheus, stock or x"),
            (&["--ids", "1,254"], "0..=253"),
            (&["--ids", "0"], "1 to 253"),
            (&["--ids", "1,2,1"], "id 1 is given to two"),
            (&["--servo-baud", "1,2,3"], "one for each id"),
            (&["--servo-baud", "750000"], "no rate of 750000"),
            (&["--baud", "300"], "7843"),
        ] {
            let error = kinds(args).unwrap_err();
            assert!(error.contains(word), "{args:?}: {error}");
        }
    }
}
