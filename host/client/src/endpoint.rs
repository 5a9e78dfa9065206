//! Byte streams by name: `tcp://HOST:PORT`.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::str::FromStr;
use std::time::Duration;
use std::{fmt, io};

/// Longest time that a connection may take: the peer is on the same network.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// The address of a byte stream.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Endpoint(SocketAddr);

/// Reason for which a name is not an endpoint.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EndpointError {
    /// Not `tcp://`.
    #[error("expected tcp://HOST:PORT, for example tcp://127.0.0.1:7000")]
    Scheme,
    /// No host and port after it.
    #[error("expected HOST:PORT after tcp://: {0}")]
    Address(String),
}

impl From<SocketAddr> for Endpoint {
    fn from(address: SocketAddr) -> Self {
        Self(address)
    }
}

impl FromStr for Endpoint {
    type Err = EndpointError;

    fn from_str(name: &str) -> Result<Self, EndpointError> {
        let address = name.strip_prefix("tcp://").ok_or(EndpointError::Scheme)?;
        let mut found = address
            .to_socket_addrs()
            .map_err(|error| EndpointError::Address(error.to_string()))?;
        found
            .next()
            .map(Self)
            .ok_or_else(|| EndpointError::Address("no such host".into()))
    }
}

impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tcp://{}", self.0)
    }
}

/// Programs that may reach a listener.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exposure {
    /// Programs of this machine.
    Loopback,
    /// Any host of the network.
    Network,
}

impl Exposure {
    /// Refuses an address that others can reach.
    ///
    /// # Errors
    /// If it is not a loopback address, and this is [`Exposure::Loopback`].
    pub fn check(self, address: SocketAddr) -> Result<(), OpenError> {
        match self {
            Self::Loopback if !address.ip().to_canonical().is_loopback() => {
                Err(OpenError::Exposed(address))
            }
            Self::Loopback | Self::Network => Ok(()),
        }
    }
}

/// Reason for which an endpoint cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// It is not to be reached from the network.
    #[error(
        "any host of the network could command the arm at {0}: listen on 127.0.0.1, or add --expose \
         if that is meant"
    )]
    Exposed(SocketAddr),
    /// The address cannot be reached.
    #[error("cannot connect to {0}: {1}; is the other side listening?")]
    Connect(Endpoint, io::Error),
    /// Another program listens on it.
    #[error("{0} is taken by another program; choose another port, or 0 for any free one")]
    Taken(Endpoint),
    /// It cannot be listened on.
    #[error("cannot listen on {0}: {1}")]
    Listen(Endpoint, io::Error),
}

impl Endpoint {
    /// Any free port of this machine, which others do not reach.
    pub const ANY_LOCAL: Self = Self(SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 0));

    /// Whether its port is 0, for any free one.
    pub fn is_any_port(&self) -> bool {
        self.0.port() == 0
    }

    /// Connects to it.
    ///
    /// # Errors
    /// If the peer does not accept.
    pub fn connect(&self) -> Result<TcpStream, OpenError> {
        TcpStream::connect_timeout(&self.0, CONNECT_TIMEOUT)
            .and_then(|stream| stream.set_nodelay(true).map(|()| stream))
            .map_err(|error| OpenError::Connect(self.clone(), error))
    }

    /// Listens on it; also returns the actual address, in case the port was 0.
    ///
    /// # Errors
    /// If more can reach it than `exposure` allows, or the port is in use or reserved.
    pub fn listen(&self, exposure: Exposure) -> Result<(TcpListener, Self), OpenError> {
        exposure.check(self.0)?;
        TcpListener::bind(self.0)
            .and_then(|listener| Ok((listener.local_addr()?, listener)))
            .map(|(at, listener)| (listener, Self(at)))
            .map_err(|error| match error.kind() {
                io::ErrorKind::AddrInUse => OpenError::Taken(self.clone()),
                _ => OpenError::Listen(self.clone(), error),
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_mistakes() {
        let endpoint: Endpoint = "tcp://127.0.0.1:7000".parse().unwrap();
        assert_eq!(endpoint.to_string(), "tcp://127.0.0.1:7000");
        assert_eq!(
            "udp://127.0.0.1:1".parse::<Endpoint>(),
            Err(EndpointError::Scheme)
        );
        assert!(matches!(
            "tcp://127.0.0.1".parse::<Endpoint>(),
            Err(EndpointError::Address(_))
        ));
    }

    #[test]
    fn a_taken_port_is_named() {
        let (listener, at) = "tcp://127.0.0.1:0"
            .parse::<Endpoint>()
            .unwrap()
            .listen(Exposure::Loopback)
            .unwrap();
        let error = at.listen(Exposure::Loopback).unwrap_err().to_string();
        assert!(
            error.contains(&at.to_string()) && error.contains("taken"),
            "{error}"
        );
        drop(listener);
    }

    #[test]
    fn the_network_is_listened_to_only_on_request() {
        for (name, is_refused) in [
            ("tcp://0.0.0.0:0", true),
            ("tcp://[::]:0", true),
            ("tcp://192.0.2.1:0", true),
            ("tcp://127.0.0.1:0", false),
            ("tcp://127.9.9.9:0", false),
            ("tcp://[::1]:0", false),
            ("tcp://[::ffff:127.0.0.1]:0", false),
        ] {
            let Endpoint(address) = name.parse().unwrap();
            let refused = Exposure::Loopback.check(address);
            assert_eq!(refused.is_err(), is_refused, "{name}");
            assert!(Exposure::Network.check(address).is_ok());
            if let Err(error) = refused {
                let error = error.to_string();
                assert!(
                    error.contains("--expose") && !error.contains('\n'),
                    "{error}"
                );
            }
        }
    }
}
