//! A host on a byte stream, in wall-clock time.
//!
//! One thread: it waits for bytes, at the longest until the host wants to speak or
//! [`LONGEST`], and hands them on. The system's own buffers hold what comes while the
//! host is busy. A stream that breaks is opened again, as often as it takes and
//! patience allows; whoever was told [`Host::disconnected`] begins with a hello. It is back
//! when the board is heard again.

use std::io;
use std::time::{Duration, Instant};

use super::clock::Clock;
use super::disconnect_guard::Connection;
use super::open::Opener;
use super::{IN_USE, LinkError, LinkOptions, LinkUri};
use crate::Host;
use crate::servo_bus::Line;

/// Longest wait for bytes: with the coarse time-outs of a socket (4 ms) and a busy
/// machine, the host still speaks every 20 ms.
const LONGEST: Duration = Duration::from_millis(12);
/// Shortest: a host that is late to speak must not keep the processor busy.
const SHORTEST: Duration = Duration::from_micros(100);
/// Between two attempts to open a broken link again.
const AGAIN: Duration = Duration::from_millis(250);

/// Why a connection ended.
enum Ended<E> {
    /// The stream did.
    Broken(io::Error),
    /// It was another host's.
    InUse,
    /// Ours gave up.
    Host(E),
}

/// A link that broke and is not back yet.
struct Outage {
    why: String,
    until: Instant,
}

/// See [`super::drive`].
pub(super) fn run<H: Host>(
    uri: &LinkUri,
    options: LinkOptions,
    mut host: H,
) -> (H, Result<(), LinkError<H::Error>>) {
    let mut session = Session {
        uri,
        options,
        clock: Clock::start(),
        outage: None,
    };
    let result = session.hold(&mut host);
    (host, result)
}

struct Session<'a> {
    uri: &'a LinkUri,
    options: LinkOptions,
    clock: Clock,
    outage: Option<Outage>,
}

impl Session<'_> {
    fn hold<H: Host>(&mut self, host: &mut H) -> Result<(), LinkError<H::Error>> {
        let mut opener = Opener::new(self.uri);
        let mut line = opener.open();
        // Somebody may have been waited for.
        self.clock = Clock::start();
        loop {
            match line {
                Err(why) => self.excuse(why).map_err(LinkError::Link)?,
                Ok(line) => match self.serve(line, host) {
                    Ok(()) => return Ok(()),
                    Err(Ended::Host(error)) => return Err(LinkError::Host(error)),
                    Err(Ended::InUse) => {
                        let why = format!(
                            "{} is in use: another host has the link; end that one first",
                            self.uri
                        );
                        self.excuse(why).map_err(LinkError::Link)?;
                    }
                    // Also where somebody lets us in and closes at once, again and again.
                    Err(Ended::Broken(why)) => {
                        let why = self.part(&why, host);
                        self.excuse(why).map_err(LinkError::Link)?;
                    }
                },
            }
            if self.idle(host).map_err(LinkError::Host)? {
                return Ok(());
            }
            line = opener.open();
        }
    }

    /// Whether it may be tried again though it does not open.
    fn excuse(&self, why: String) -> Result<(), String> {
        match &self.outage {
            None => Err(why),
            Some(outage) if Instant::now() < outage.until => Ok(()),
            Some(outage) => Err(format!(
                "{} broke ({}) and did not come back in {} s: {why}",
                self.uri,
                outage.why,
                self.options.patience.as_secs_f64()
            )),
        }
    }

    /// Tells everybody; gives back why, in words.
    fn part<H: Host>(&mut self, why: &io::Error, host: &mut H) -> String {
        let now_ns = self.clock.now_ns();
        for tap in &mut self.options.taps {
            tap.disconnected(now_ns);
        }
        host.disconnected(self.clock.now_us());
        let why = match why.kind() {
            io::ErrorKind::UnexpectedEof => "the other side closed it".to_owned(),
            _ => why.to_string(),
        };
        if self.outage.is_some() {
            return why;
        }
        let patience = self.options.patience;
        self.say(&format!(
            "{} broke: {why}; it is tried again for {} s",
            self.uri,
            patience.as_secs_f64()
        ));
        let until = Instant::now() + patience;
        self.outage = Some(Outage {
            why: why.clone(),
            until,
        });
        why
    }

    fn say(&self, what: &str) {
        if !self.options.is_quiet {
            eprintln!("armbridge: {what}");
        }
    }

    /// Lets the host speak to nobody until it is time to try again; true if it is done.
    fn idle<H: Host>(&self, host: &mut H) -> Result<bool, H::Error> {
        let until = Instant::now() + AGAIN;
        while Instant::now() < until && !host.is_done() {
            host.transmit(self.clock.now_us())?;
            std::thread::sleep(LONGEST);
        }
        Ok(host.is_done())
    }

    fn serve<H: Host>(&mut self, line: Box<dyn Line>, host: &mut H) -> Result<(), Ended<H::Error>> {
        let Self {
            options,
            clock,
            outage,
            uri,
        } = self;
        let mut connection = Connection::new(line, &mut options.taps, clock);
        let mut is_new = true;
        while !host.is_done() {
            let words = host.transmit(clock.now_us()).map_err(Ended::Host)?;
            connection.send(words).map_err(Ended::Broken)?;
            if host.is_done() {
                break;
            }
            let wait = clock.until(host.wake_at_us()).clamp(SHORTEST, LONGEST);
            let until = Instant::now() + wait;
            let bytes = connection.receive(until).map_err(Ended::Broken)?;
            if bytes.is_empty() {
                continue;
            }
            if std::mem::take(&mut is_new) {
                if bytes.starts_with(IN_USE) {
                    connection.abandon();
                    return Err(Ended::InUse);
                }
                if outage.take().is_some() && !options.is_quiet {
                    eprintln!("armbridge: {uri} is back; nothing is armed");
                }
            }
            host.receive(clock.now_us(), &bytes).map_err(Ended::Host)?;
        }
        connection.close();
        Ok(())
    }
}
