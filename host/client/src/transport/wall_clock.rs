//! Host on a byte stream, in wall-clock time.
//!
//! One thread: it waits for bytes, at the longest until the host's next message or
//! [`WAIT_MAX`], and passes them on. The system's own buffers hold bytes that arrive while
//! the host is busy. A broken stream is reopened, repeatedly until
//! patience ends; after [`Host::disconnected`] a host begins with a hello. The link is back
//! when the first bytes of the board arrive.
//!
//! Meanwhile a stop that another process asks for is sent at once, see
//! [`stop_socket`](super::stop_socket).

use std::io;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use armbridge_link::server::{FromServer, LinkRole, ToServer};

use super::clock::Clock;
use super::disconnect_guard::Connection;
use super::open::Opener;
use super::role::RoleKeeper;
use super::stop_socket::{BoardKey, StopRelay};
use super::{LinkError, LinkOptions, LinkUri, TransportError};
use crate::servo_bus::Line;
use crate::{Host, stdio};

/// Longest wait for bytes: with the coarse timeouts of a socket (4 ms) and a busy
/// machine, the host still sends every 20 ms.
const WAIT_MAX: Duration = Duration::from_millis(12);
/// Shortest wait, so that a late host does not load the processor.
const WAIT_MIN: Duration = Duration::from_micros(100);
/// Interval of the attempts to reopen a broken link.
const RETRY_INTERVAL: Duration = Duration::from_millis(250);

/// Reason for the end of a connection.
enum Ended<E> {
    /// The stream broke.
    Broken(io::Error),
    /// The link cannot be used.
    Unusable(TransportError),
    /// Error of our host.
    Host(E),
}

/// A broken link that is not back yet.
struct Outage {
    cause: String,
    until: Instant,
}

/// See [`super::drive`].
pub(super) fn run<H: Host>(
    uri: &LinkUri,
    options: LinkOptions,
    host: H,
) -> (H, Result<(), LinkError<H::Error>>) {
    let mut driver = LinkDriver {
        uri,
        role: RoleKeeper::new(options.intent),
        options,
        clock: Clock::start(),
        outage: None,
    };
    let mut host = StopRelay::new(host);
    let result = driver.run(&mut host);
    (host.host, result)
}

/// The commanding program, for one that watches.
fn in_words(role: LinkRole, link: &LinkUri) -> String {
    match role.commander {
        Some(program) => format!(
            "{program} commands the board at {link}; this program observes, and may stop it"
        ),
        None => format!("no program commands the board at {link}; this one observes"),
    }
}

struct LinkDriver<'a> {
    uri: &'a LinkUri,
    role: RoleKeeper,
    options: LinkOptions,
    clock: Clock,
    outage: Option<Outage>,
}

impl LinkDriver<'_> {
    fn run<H: Host>(&mut self, host: &mut StopRelay<H>) -> Result<(), LinkError<H::Error>> {
        let mut opener = Opener::new(self.uri);
        let mut line = opener.open();
        // Opening may have waited for another program.
        self.clock = Clock::start();
        loop {
            match line {
                Err(error) => self.check_retry(error)?,
                Ok(line) => match self.serve(line, opener.name(), host) {
                    Ok(()) => return Ok(()),
                    Err(Ended::Host(error)) => return Err(LinkError::Host(error)),
                    Err(Ended::Unusable(error)) => return Err(LinkError::Link(error.into())),
                    // Also where a peer accepts and closes at once, repeatedly.
                    Err(Ended::Broken(error)) => {
                        let error = TransportError::Broken(error);
                        self.disconnected(&error, host);
                        self.check_retry(error)?;
                    }
                },
            }
            if self.run_offline(host).map_err(LinkError::Host)? {
                return Ok(());
            }
            line = opener.open();
        }
    }

    /// Whether opening may be retried after this error.
    fn check_retry<E>(&self, error: TransportError) -> Result<(), LinkError<E>> {
        let error = match &self.outage {
            None => error,
            Some(outage) if Instant::now() < outage.until => return Ok(()),
            Some(outage) => TransportError::Lost {
                uri: self.uri.clone(),
                cause: outage.cause.clone(),
                patience: self.options.patience,
                last: Box::new(error),
            },
        };
        Err(LinkError::Link(error.into()))
    }

    /// Notifies host and taps of the break, and the user of the first one.
    fn disconnected<H: Host>(&mut self, error: &TransportError, host: &mut H) {
        let now_ns = self.clock.now_ns();
        for tap in &mut self.options.taps {
            tap.disconnected(now_ns);
        }
        host.disconnected(self.clock.now_us());
        if self.outage.is_some() {
            return;
        }
        let patience = self.options.patience;
        if !self.options.is_quiet {
            stdio::note(format_args!(
                "armbridge: {} broke: {error}; it is tried again for at most {} s",
                self.uri,
                patience.as_secs_f64()
            ));
        }
        self.outage = Some(Outage {
            cause: error.to_string(),
            until: Instant::now() + patience,
        });
    }

    /// Runs the host without a link until the next attempt; true if it is done.
    fn run_offline<H: Host>(&mut self, host: &mut H) -> Result<bool, H::Error> {
        let until = Instant::now() + RETRY_INTERVAL;
        while Instant::now() < until && !host.is_done() {
            host.transmit(self.clock.now_us())?;
            std::thread::sleep(WAIT_MAX);
        }
        Ok(host.is_done())
    }

    /// Listens for orders of other processes, once the link is open under this name.
    fn listen<H: Host>(&self, name: &LinkUri, host: &mut StopRelay<H>) {
        let Some(board) = BoardKey::of(name) else {
            return;
        };
        if let Err(error) = host.listen(&board)
            && !self.options.is_quiet
        {
            stdio::note(format_args!(
                "armbridge: `armbridge stop` from another terminal cannot reach {name} while this \
                 program has it: {error}"
            ));
        }
    }

    fn serve<H: Host>(
        &mut self,
        line: Box<dyn Line>,
        name: &LinkUri,
        host: &mut StopRelay<H>,
    ) -> Result<(), Ended<H::Error>> {
        self.listen(name, host);
        host.connected();
        let Self {
            options,
            clock,
            outage,
            uri,
            role,
        } = self;
        let join = role.join(uri).map_err(Ended::Unusable)?;
        let mut connection = Connection::new(line, &mut options.taps, clock);
        if role.is_observer() {
            connection.observe();
        }
        if let Some(join) = join {
            connection.send_to_server(&join).map_err(Ended::Broken)?;
        }
        while !host.is_done() {
            let touches = options.touches.iter().flat_map(Receiver::try_iter);
            for touch in touches.filter(|_| role.role().is_some_and(|role| role.is_touchable)) {
                let touch = ToServer::Touch(touch);
                connection.send_to_server(&touch).map_err(Ended::Broken)?;
            }
            let words = host.transmit(clock.now_us()).map_err(Ended::Host)?;
            let may_send = role.may_send(uri).map_err(|error| match error {
                TransportError::Broken(error) => Ended::Broken(error),
                error => Ended::Unusable(error),
            })?;
            if may_send {
                connection.send(words).map_err(Ended::Broken)?;
            }
            if host.is_done() {
                break;
            }
            let wait = clock.until(host.wake_at_us()).clamp(WAIT_MIN, WAIT_MAX);
            let until = Instant::now() + wait;
            let mut roles = Vec::new();
            let on_server = |message| match message {
                FromServer::Role(role) => roles.push(role),
                // The arm shows it.
                FromServer::Touched(_) => {}
            };
            let received = connection.receive(until, on_server);
            let bytes = received.map_err(Ended::Broken)?;
            for latest in roles {
                if !latest.is_commander {
                    connection.observe();
                }
                if role.take(latest).map_err(Ended::Unusable)? {
                    host.link_role(latest);
                    if !latest.is_commander && !options.is_quiet {
                        stdio::note(format_args!("armbridge: {}", in_words(latest, uri)));
                    }
                }
            }
            if bytes.is_empty() {
                continue;
            }
            if outage.take().is_some() && !options.is_quiet {
                stdio::note(format_args!("armbridge: {uri} is back; nothing is armed"));
            }
            host.receive(clock.now_us(), &bytes).map_err(Ended::Host)?;
        }
        connection.close();
        Ok(())
    }
}
