//! Places at which a server of this program can be reached.

use armbridge_client::transport::LinkUri;

/// The forms of such a place.
pub(crate) const FORMS: &str = "tcp://HOST:PORT|pty:";

/// `tcp://HOST:PORT`, or `pty:` for a new pseudo-terminal.
pub(crate) fn listen_at(text: &str) -> Result<LinkUri, String> {
    if text.starts_with("tcp:") {
        return text.parse::<LinkUri>().map_err(|error| error.to_string());
    }
    match text.parse() {
        Ok(at @ LinkUri::Pty(None)) => Ok(at),
        Ok(_) | Err(_) => Err("expected tcp://HOST:PORT or pty:".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_can_be_listened_on_is_taken_and_named() {
        for text in ["tcp://127.0.0.1:0", "pty:"] {
            assert_eq!(listen_at(text).unwrap().to_string(), text);
        }
        for text in ["foo", "usb:", "serial:", "pty:///dev/pts/3", "/dev/ttyACM0"] {
            let error = listen_at(text).unwrap_err();
            assert_eq!(error, "expected tcp://HOST:PORT or pty:", "{text}");
        }
        assert!(
            listen_at("tcp://nowhere")
                .unwrap_err()
                .contains("HOST:PORT")
        );
    }
}
