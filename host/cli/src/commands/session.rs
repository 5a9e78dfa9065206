//! A command's link on a thread of its own, with a queue of its events, and a log if one is
//! requested.

use std::time::Duration;

use armbridge::config::Config;
use armbridge_client::event_queue::EventQueue;
use armbridge_client::transport::{Intent, LinkOptions};
use armbridge_client::{ctrl_c, stdio};
use armbridge_sim::Bench;
use armbridge_sim::link::{BoardUri, LinkThread, Options, Pace};
use armbridge_sim::plant::Plant;

use super::recording::Recording;
use super::{Error, virtual_arm};
use crate::args::SessionArgs;

/// A link that breaks is tried again for as long as the command runs.
const PATIENCE: Duration = Duration::from_secs(24 * 3_600);

/// The link, its events and its log.
pub(crate) struct OpenedLink {
    session: LinkThread,
    /// Events of the link.
    pub(crate) event_queue: EventQueue,
    recording: Option<Recording>,
    /// The link's name, and what is behind it.
    pub(crate) title: String,
    /// There is no real arm.
    pub(crate) is_simulated: bool,
}

impl OpenedLink {
    /// Opens it. `name` is the command's; a quiet link prints nothing on standard error.
    pub(crate) fn begin(
        args: &SessionArgs,
        name: &str,
        is_quiet: bool,
        intent: Intent,
    ) -> Result<Self, Error> {
        ctrl_c::listen()?;
        let link = Config::discover()?.link(args.link.link.as_ref())?;
        if link.is_simulated() && intent == Intent::Observe {
            return Err(format!(
                "{link} is simulated in this program alone: to observe, give the --link of \
                 `armbridge serve board`"
            )
            .into());
        }
        let (is_simulated, title) = match &link {
            BoardUri::Sim => (true, "sim: (simulated board and arm)".to_owned()),
            BoardUri::Emulate(_) => (true, format!("{link} (emulated board)")),
            BoardUri::Link(link) => (false, link.to_string()),
        };
        let recording = args.record.as_deref();
        let recording = recording.map(|path| Recording::begin(path, name, &title));
        let recording = recording.transpose()?;
        let event_queue = EventQueue::default();
        let mut taps = vec![event_queue.tap()];
        taps.extend(recording.iter().flat_map(Recording::taps));
        let plant = virtual_arm::config(&args.arm)?;
        let kinds = args.servos.kinds(plant.firmware())?;
        let seed = args.arm.seed;
        // A bench cannot be sent to another thread: it is made there.
        let session = LinkThread::begin(link, move || {
            let mut options = Options::new(Bench::with_servos(Plant::new(plant, seed), &kinds));
            options.pace = Pace::WallClock;
            options.is_stoppable = true;
            options.link = LinkOptions {
                patience: PATIENCE,
                is_quiet,
                intent,
                taps,
                ..LinkOptions::default()
            };
            options
        })?;
        Ok(Self {
            session,
            event_queue,
            recording,
            title,
            is_simulated,
        })
    }

    /// The board.
    pub(crate) fn session(&self) -> &LinkThread {
        &self.session
    }

    /// Disarms the board, closes the log, and prints the log's statistics on standard
    /// error.
    pub(crate) fn end(self) -> Result<(), Error> {
        let ended = self.session.end();
        if let Some(recording) = self.recording {
            let report = recording.finish()?;
            if let Some(trouble) = &report.trouble {
                stdio::note(format_args!("armbridge: {trouble}"));
            }
            let (records, lost, unwritten) = (report.records, report.lost, report.unwritten);
            stdio::note(format_args!(
                "{records} records written, {lost} lost, {unwritten} bytes unwritten"
            ));
        }
        Ok(ended?)
    }
}
