//! A hand on the simulated arm of `serve board`, for `push` and `hand`.

use armbridge::config::Config;
use armbridge_client::transport::touch;
use armbridge_link::server::Touch;
use armbridge_sim::link::BoardUri;

use super::Error;
use crate::args::LinkArgs;

/// Touches the arm.
pub(super) fn touch(args: &LinkArgs, with: Touch) -> Result<(), Error> {
    match Config::discover()?.link(args.link.as_ref())? {
        BoardUri::Link(link) => Ok(touch::touch(&link, with)?),
        simulated @ (BoardUri::Sim | BoardUri::Emulate(_)) => Err(format!(
            "{simulated} is simulated inside each program that uses it: serve it to several by \
             `armbridge serve board --listen tcp://127.0.0.1:7001`, then add \
             --link tcp://127.0.0.1:7001"
        )
        .into()),
    }
}
