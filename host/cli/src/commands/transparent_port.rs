//! The transparent port of a simulated board, served to another program.

use armbridge_client::endpoint::Exposure;
use armbridge_client::stdio;
use armbridge_client::transport::LinkUri;
use armbridge_sim::cosim::PortClient;
use armbridge_sim::usb2dynamixel_server::PortServer;

use super::Error;

/// The program at the port that is asked for.
pub(super) fn open(
    at: Option<&LinkUri>,
    exposure: Exposure,
) -> Result<Option<Box<dyn PortClient>>, Error> {
    match at {
        None => Ok(None),
        Some(LinkUri::Tcp(endpoint)) => {
            let (listener, at) = endpoint.listen(exposure)?;
            stdio::note(format_args!("transparent port on {at}, raw bus bytes"));
            Ok(Some(Box::new(PortServer::on_socket(listener)?)))
        }
        Some(LinkUri::Pty(None)) => on_terminal().map(Some),
        Some(other @ (LinkUri::Usb(_) | LinkUri::Serial(_) | LinkUri::Pty(Some(_)))) => {
            Err(format!(
                "the transparent port cannot be served on {other}: expected tcp://HOST:PORT or pty:"
            )
            .into())
        }
    }
}

#[cfg(unix)]
fn on_terminal() -> Result<Box<dyn PortClient>, Error> {
    let pty = armbridge_client::pty::Pty::open()?;
    stdio::note("transparent port, raw bus bytes:");
    stdio::print_line(pty.name())?;
    Ok(Box::new(PortServer::on_terminal(pty)?))
}

#[cfg(not(unix))]
fn on_terminal() -> Result<Box<dyn PortClient>, Error> {
    Err("there are no pseudo-terminals on this system: use tcp://127.0.0.1:PORT".into())
}
