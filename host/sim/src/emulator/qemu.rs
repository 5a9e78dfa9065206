//! The QEMU process: its command line, its sockets, its end.

use std::fmt;
use std::io::{self, Read};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::image::{Image, ImageError};

/// Name of the emulator, which is on the search path if it is installed.
const PROGRAM: &str = "qemu-system-arm";

/// Timeout for QEMU to connect its sockets: it takes a second on a loaded machine.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(20);

/// Time base of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Time {
    /// Granted by the bench.
    Lockstep,
    /// QEMU's clock, this many times slower.
    Slow(u32),
}

/// A failure of the firmware, on demand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Provocation {
    /// The failure.
    pub failure: Failure,
    /// Time of the failure, in ms of the board's time since boot.
    pub at_ms: u32,
}

/// Kinds of failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// A panic.
    Panic,
    /// A fault of the processor.
    Fault,
    /// The stack grows beyond its end.
    Overflow,
    /// The tick never ends.
    Hang,
    /// Bits of the saved settings turn, and a panic.
    Rot,
}

impl fmt::Display for Provocation {
    /// As the firmware has it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let failure = match self.failure {
            Failure::Panic => "panic",
            Failure::Fault => "fault",
            Failure::Overflow => "overflow",
            Failure::Hang => "hang",
            Failure::Rot => "rot",
        };
        write!(f, "provoke={failure}@{}", self.at_ms)
    }
}

/// Options of the emulator.
#[derive(Clone, Debug)]
pub struct QemuOptions {
    /// The firmware image.
    pub image: Image,
    /// Time base of the board.
    pub time: Time,
    /// Instructions take a fixed virtual time, so that measured compute times
    /// repeat from run to run.
    pub icount: bool,
    /// Failure to inject, once.
    pub provoke: Option<Provocation>,
}

/// Reason for which the emulator does not run.
#[derive(Debug, thiserror::Error)]
pub enum QemuError {
    /// There is no image to run.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The program is not installed.
    #[error(
        "{PROGRAM} is not installed: `cargo verify` installs it where it may, \
         or use your package manager (Debian: `apt-get install qemu-system-arm`)"
    )]
    NotInstalled,
    /// The program could not be started.
    #[error("cannot start {PROGRAM}: {0}")]
    Start(io::Error),
    /// It ended early, or did not connect its ports.
    #[error("{PROGRAM} ended: {0}")]
    Died(ProcessEnd),
    /// A socket failed.
    #[error("the connection to {PROGRAM} broke: {0}")]
    Socket(#[from] io::Error),
}

/// End of the emulator's process, or failure of its start.
#[derive(Debug, thiserror::Error)]
pub enum ProcessEnd {
    /// Its standard input is missing.
    #[error("it has no input")]
    NoInput,
    /// Its sockets did not connect.
    #[error("it did not connect its ports in time")]
    Timeout,
    /// The board sent bytes before lockstep began.
    #[error("the board sent {0} bytes before its first grant")]
    EarlyBytes(usize),
    /// The firmware panicked.
    #[error("the firmware panicked")]
    Panic,
    /// The firmware ran into a hard fault.
    #[error("the firmware ran into a hard fault")]
    HardFault,
    /// First line of its standard error.
    #[error("{0}")]
    Message(String),
    /// It wrote nothing.
    #[error("{0}")]
    Status(ExitStatus),
}

/// A running emulator; killed when dropped.
#[derive(Debug)]
pub struct Qemu {
    process: Child,
    /// The control link.
    pub link: TcpStream,
    /// The servo bus.
    pub bus: TcpStream,
    /// The transparent port.
    pub client: TcpStream,
    /// In lockstep, all bytes to the board: QEMU's standard input. Not one socket for both
    /// directions: a reader of one is also woken when its written bytes
    /// are read, twice a message in vain.
    pub to_board: ChildStdin,
    /// In lockstep, all bytes from the board: QEMU's standard output.
    pub from_board: UnixStream,
    /// Log of the firmware.
    pub log: TcpStream,
}

impl Qemu {
    /// Starts the image and waits for its ports.
    ///
    /// # Errors
    /// If there is no QEMU, or it does not start.
    pub fn start(options: &QemuOptions) -> Result<Self, QemuError> {
        // QEMU connects to us: no free port has to be guessed.
        let listen = || TcpListener::bind((Ipv4Addr::LOCALHOST, 0));
        let listeners = [listen()?, listen()?, listen()?, listen()?];
        let mut command = Command::new(PROGRAM);
        command.args(arguments(options));
        for (name, listener) in ["link", "bus", "client", "log"].iter().zip(&listeners) {
            let port = listener.local_addr()?.port();
            command.arg("-chardev");
            command.arg(format!(
                "socket,id={name},host=127.0.0.1,port={port},nodelay=on"
            ));
        }
        for name in ["link", "bus", "client"] {
            command.args(["-serial", &format!("chardev:{name}")]);
        }
        let (from_board, theirs) = UnixStream::pair()?;
        command.stdin(Stdio::piped());
        command.stdout(OwnedFd::from(theirs));
        command.stderr(Stdio::piped());
        if options.time == Time::Lockstep {
            // Ctrl-C at the terminal must not reach QEMU: the board is disarmed
            // first. QEMU ends with its input.
            command.process_group(0);
        }
        let mut process = command.spawn().map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => QemuError::NotInstalled,
            _ => QemuError::Start(error),
        })?;
        // Closes our copy of QEMU's end of `from_board`.
        drop(command);
        let to_board = process.stdin.take();
        let to_board = to_board.ok_or(QemuError::Died(ProcessEnd::NoInput))?;
        let [link, bus, client, log] = &listeners;
        let mut accept = |listener| accept(listener, &mut process);
        let (link, bus) = (accept(link)?, accept(bus)?);
        let (client, log) = (accept(client)?, accept(log)?);
        Ok(Self {
            process,
            link,
            bus,
            client,
            to_board,
            from_board,
            log,
        })
    }

    /// Turns an error on a socket into its cause, if QEMU has ended.
    pub fn explain(&mut self, error: io::Error) -> QemuError {
        // Its last output may arrive shortly after the socket closes.
        std::thread::sleep(Duration::from_millis(100));
        process_end(&mut self.process).map_or(QemuError::Socket(error), QemuError::Died)
    }
}

impl Drop for Qemu {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn arguments(options: &QemuOptions) -> Vec<String> {
    let time = match options.time {
        Time::Lockstep => "lockstep".into(),
        Time::Slow(times) => format!("slow={times}"),
    };
    let provoke = options
        .provoke
        .map_or_else(String::new, |provocation| format!(",arg={provocation}"));
    let mut arguments = vec![
        "-machine".into(),
        "mps2-an386".into(),
        "-display".into(),
        "none".into(),
        "-monitor".into(),
        "none".into(),
        "-semihosting-config".into(),
        format!("enable=on,target=native,chardev=log,arg=armbridge,arg={time}{provoke}"),
        "-kernel".into(),
        options.image.path.display().to_string(),
    ];
    if options.icount {
        // 8 ns an instruction: 125 MIPS, about the speed of the board's 168 MHz
        // core. Without `sleep` an idle core jumps to its next alarm.
        let sleep = match options.time {
            Time::Lockstep => "off",
            Time::Slow(_) => "on",
        };
        arguments.extend(["-icount".into(), format!("shift=3,align=off,sleep={sleep}")]);
    }
    arguments
}

fn accept(listener: &TcpListener, process: &mut Child) -> Result<TcpStream, QemuError> {
    listener.set_nonblocking(true)?;
    let begun = Instant::now();
    loop {
        match listener.accept() {
            Ok((stream, _)) => {
                stream.set_nonblocking(false)?;
                stream.set_nodelay(true)?;
                return Ok(stream);
            }
            Err(error) if error.kind() != io::ErrorKind::WouldBlock => return Err(error.into()),
            Err(_) => {}
        }
        if let Some(end) = process_end(process) {
            return Err(QemuError::Died(end));
        }
        if begun.elapsed() > CONNECT_TIMEOUT {
            return Err(QemuError::Died(ProcessEnd::Timeout));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// End of the process, if it has ended. Its exit code is the firmware's if that ended
/// by itself.
fn process_end(process: &mut Child) -> Option<ProcessEnd> {
    let status = process.try_wait().ok()??;
    let mut text = String::new();
    if let Some(stderr) = &mut process.stderr {
        // Best effort: the status alone will do.
        let _ = stderr.read_to_string(&mut text);
    }
    Some(match (status.code(), text.lines().next()) {
        (Some(101), _) => ProcessEnd::Panic,
        (Some(102), _) => ProcessEnd::HardFault,
        (_, Some(line)) => ProcessEnd::Message(line.into()),
        (_, None) => ProcessEnd::Status(status),
    })
}
