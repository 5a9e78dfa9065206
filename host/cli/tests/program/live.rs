//! A viewer at `armbridge foxglove`: one that was written from the protocol's
//! specification, in Python.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use armbridge_tests::paths;

/// `armbridge foxglove` on any free port, ended with the test.
pub(crate) struct Live {
    child: Child,
    /// Address with the token.
    pub(crate) url: String,
}

impl Live {
    fn start(options: &[&str]) -> Self {
        Self::on("sim:", options)
    }

    /// On this link.
    pub(crate) fn on(link: &str, options: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_armbridge"))
            .args(["foxglove", "--link", link, "--port", "0"])
            .args(options)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut url = String::new();
        let stdout = child.stdout.take().unwrap();
        let read = BufReader::new(stdout).read_line(&mut url);
        // Owned from here on, so that it ends with the test.
        let live = Self {
            child,
            url: url.trim().to_owned(),
        };
        assert!(read.is_ok() && live.url.starts_with("ws://127.0.0.1:"));
        live
    }

    /// The server's process.
    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    fn passes(&self, options: &[&str]) {
        let output = paths::script("live.py")
            .arg(&self.url)
            .args(options)
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "live.py {options:?}: {stderr}");
        print!("{}", String::from_utf8_lossy(&output.stdout));
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn a_viewer_sees_every_tick_changes_parameters_and_stops_the_board() {
    Live::start(&[]).passes(&[]);
}

#[test]
#[ignore = "needs the Python packages: run `cargo verify`"]
fn a_viewer_may_arm_if_it_is_allowed_and_leaves_the_arm_disarmed() {
    Live::start(&["--allow-arm"]).passes(&["--arm"]);
}

#[test]
fn a_port_that_is_taken_is_named() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let output = Command::new(env!("CARGO_BIN_EXE_armbridge"))
        .args(["foxglove", "--link", "sim:", "--port", &port])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(
        stderr.contains(&port) && stderr.contains("--port"),
        "{stderr}"
    );
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
}
