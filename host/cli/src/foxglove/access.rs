//! Access to the server, and permissions of viewers.
//!
//! A browser opens a WebSocket for any page, and says in `Origin` whose page that is. So
//! pages of Foxglove's app, of this machine and of `--allow-origin` may connect, and any
//! other may not. A native program sends no `Origin`.
//!
//! A viewer with the token in its address (`?token=...`) may change settings and call every
//! service; one without may watch, stop and disarm.

use std::net::IpAddr;

use tungstenite::handshake::server::{ErrorResponse, Request};
use tungstenite::http::{HeaderMap, StatusCode, Uri};

/// Subprotocol of the connection.
pub const PROTOCOL: &str = "foxglove.sdk.v1";

/// Origin of Foxglove's app.
const APP: &str = "https://app.foxglove.dev";

/// Random bytes of a token.
const TOKEN_BYTES: usize = 16;

/// Permission of a viewer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Right {
    /// Watch, stop and disarm.
    #[default]
    Watch,
    /// Also change settings and call every service.
    Command,
}

/// Reason for which a connection is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Denial {
    /// A page of another site.
    #[error("pages of {0} may not connect; `armbridge foxglove --allow-origin {0}` lets them")]
    Origin(String),
    /// Not the token of this server.
    #[error("the token is wrong: open the address that `armbridge foxglove` has printed")]
    Token,
    /// No viewer.
    #[error("expected the WebSocket subprotocol {PROTOCOL}")]
    Protocol,
}

impl Denial {
    fn status(&self) -> StatusCode {
        match self {
            Self::Origin(_) => StatusCode::FORBIDDEN,
            Self::Token => StatusCode::UNAUTHORIZED,
            Self::Protocol => StatusCode::BAD_REQUEST,
        }
    }

    /// The answer to the request.
    pub fn response(&self) -> ErrorResponse {
        let mut response = ErrorResponse::new(Some(format!("{self}\n")));
        *response.status_mut() = self.status();
        response
    }
}

/// Rule for connections.
#[derive(Clone, Debug)]
pub struct Access {
    origins: Vec<String>,
    token: String,
}

impl Access {
    /// Pages of these origins may connect too; the token is a new one if none is given.
    ///
    /// # Errors
    /// If the system has no random numbers.
    pub fn new(origins: Vec<String>, token: Option<String>) -> Result<Self, getrandom::Error> {
        let token = if let Some(token) = token {
            token
        } else {
            let mut bytes = [0; TOKEN_BYTES];
            getrandom::fill(&mut bytes)?;
            format!("{:032x}", u128::from_ne_bytes(bytes))
        };
        Ok(Self { origins, token })
    }

    /// The token.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// Permission of the sender of this request.
    ///
    /// # Errors
    /// If it may not connect.
    pub fn check(&self, request: &Request) -> Result<Right, Denial> {
        self.check_origin(request.headers())?;
        let offered = request.headers().get_all("sec-websocket-protocol");
        let mut offered = offered
            .iter()
            .flat_map(|header| header.to_str().unwrap_or_default().split(','));
        if !offered.any(|name| name.trim() == PROTOCOL) {
            return Err(Denial::Protocol);
        }
        match token(request.uri()) {
            None => Ok(Right::Watch),
            Some(token) if is_equal(token, &self.token) => Ok(Right::Command),
            Some(_) => Err(Denial::Token),
        }
    }

    fn check_origin(&self, headers: &HeaderMap) -> Result<(), Denial> {
        for origin in headers.get_all("origin") {
            let origin = String::from_utf8_lossy(origin.as_bytes());
            let is_listed = origin == APP || self.origins.iter().any(|listed| *listed == *origin);
            if !is_listed && !is_of_this_machine(&origin) {
                return Err(Denial::Origin(origin.into_owned()));
            }
        }
        Ok(())
    }
}

/// Whether a page with this origin was served by this machine.
fn is_of_this_machine(origin: &str) -> bool {
    let Ok(uri) = origin.parse::<Uri>() else {
        return false;
    };
    let host = uri.host().unwrap_or_default();
    let address = host.trim_start_matches('[').trim_end_matches(']');
    matches!(uri.scheme_str(), Some("http" | "https"))
        && (host == "localhost"
            || address
                .parse()
                .is_ok_and(|address: IpAddr| address.is_loopback()))
}

fn token(uri: &Uri) -> Option<&str> {
    let mut pairs = uri.query()?.split('&');
    pairs.find_map(|pair| pair.strip_prefix("token="))
}

/// Compares in a time that depends on the lengths alone.
fn is_equal(a: &str, b: &str) -> bool {
    let differences = a.bytes().zip(b.bytes());
    let sum = differences.fold(0, |sum, (a, b)| std::hint::black_box(sum | (a ^ b)));
    a.len() == b.len() && sum == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn access() -> Access {
        Access::new(vec!["https://lab.example".into()], Some("secret".into())).unwrap()
    }

    fn check(uri: &str, origins: &[&str]) -> Result<Right, Denial> {
        let mut request = Request::builder()
            .uri(uri)
            .header("Sec-WebSocket-Protocol", "other, foxglove.sdk.v1");
        for origin in origins {
            request = request.header("Origin", *origin);
        }
        access().check(&request.body(()).unwrap())
    }

    #[test]
    fn pages_of_other_sites_are_refused() {
        for origin in [
            "https://app.foxglove.dev",
            "https://lab.example",
            "http://localhost",
            "http://localhost:8080",
            "https://127.0.0.1:3000",
            "http://[::1]:3000",
        ] {
            assert_eq!(check("/", &[origin]), Ok(Right::Watch), "{origin}");
        }
        for origin in [
            "https://evil.example",
            "null",
            "",
            "file://",
            "http://app.foxglove.dev",
            "https://app.foxglove.dev.evil.example",
            "https://app.foxglove.dev:8443",
            "http://localhost.evil.example",
            "http://evil.example/localhost",
            "http://localhost@evil.example",
            "http://127.0.0.1.evil.example",
            "http://192.168.1.2",
            "ftp://localhost",
            "localhost",
        ] {
            let denied = check("/?token=secret", &[origin]);
            assert_eq!(denied, Err(Denial::Origin(origin.into())), "{origin}");
        }
        let both = check("/", &["https://app.foxglove.dev", "https://evil.example"]);
        assert_eq!(both, Err(Denial::Origin("https://evil.example".into())));
    }

    #[test]
    fn the_token_lets_a_viewer_command() {
        assert_eq!(check("/", &[]), Ok(Right::Watch));
        assert_eq!(check("/?a=b&token=secret", &[]), Ok(Right::Command));
        for wrong in ["", "secre", "secret1", "Secret", "secret%20"] {
            let uri = format!("/?token={wrong}");
            assert_eq!(check(&uri, &[]), Err(Denial::Token), "{wrong}");
        }
        let [a, b] = [(); 2].map(|()| Access::new(Vec::new(), None).unwrap());
        assert_eq!(a.token().len(), 2 * TOKEN_BYTES);
        assert_ne!(a.token(), b.token());
    }

    #[test]
    fn another_protocol_is_refused() {
        let request = Request::builder().header("Sec-WebSocket-Protocol", "foxglove.sdk.v1.1");
        let denied = access().check(&request.body(()).unwrap());
        assert_eq!(denied, Err(Denial::Protocol));
    }
}
