//! Headless Chromium, controlled by its `DevTools` protocol.
//!
//! A page is opened in a tab of its own with a given width and colour scheme. Errors of its
//! scripts, and of what it loads, are collected.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

/// Longest wait for an answer.
const PATIENCE: Duration = Duration::from_secs(60);

/// A running browser.
pub(super) struct Browser {
    child: Child,
    profile: PathBuf,
    socket: WebSocket<TcpStream>,
    calls: u64,
    errors: Vec<String>,
    is_loaded: bool,
}

/// Size and colour scheme of a window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) width: u32,
    pub(super) is_dark: bool,
}

impl Browser {
    /// Starts the browser with an empty profile in a folder.
    pub(super) fn start(folder: &Path) -> Self {
        let profile = folder.join("profile");
        let mut child = Command::new("chromium")
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--no-first-run",
            ])
            .args(["--disable-quic", "--disable-background-networking"])
            .args(["--disable-component-update", "--disable-sync"])
            .args(["--disable-dev-shm-usage", "--remote-debugging-port=0"])
            .arg(format!("--user-data-dir={}", profile.display()))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("Chromium; `cargo verify --only browser` installs it");
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let url = lines
            .find_map(|line| {
                Some(
                    line.ok()?
                        .strip_prefix("DevTools listening on ")?
                        .to_owned(),
                )
            })
            .expect("the address of the DevTools");
        // The pipe is read to its end, or the browser would stall.
        std::thread::spawn(move || lines.for_each(drop));
        let address = url.strip_prefix("ws://").unwrap();
        let stream = TcpStream::connect(address.split('/').next().unwrap()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let (socket, _) = tungstenite::client(&url, stream).unwrap();
        Self {
            child,
            profile,
            socket,
            calls: 0,
            errors: Vec::new(),
            is_loaded: false,
        }
    }

    /// Opens a page in a new tab and waits until it is loaded.
    pub(super) fn open(&mut self, page: &Path, window: Window) -> Tab<'_> {
        (self.errors, self.is_loaded) = (Vec::new(), false);
        let target = self.call(None, "Target.createTarget", &json!({"url": "about:blank"}));
        let target = target["targetId"].as_str().unwrap().to_owned();
        let attach = json!({"targetId": target, "flatten": true});
        let attached = self.call(None, "Target.attachToTarget", &attach);
        let session = attached["sessionId"].as_str().unwrap().to_owned();
        let mut tab = Tab {
            browser: self,
            target,
            session,
        };
        for domain in ["Page", "Runtime", "Log"] {
            tab.call(&format!("{domain}.enable"), &json!({}));
        }
        let size = json!({
            "width": window.width, "height": 800, "deviceScaleFactor": 1, "mobile": false
        });
        tab.call("Emulation.setDeviceMetricsOverride", &size);
        let scheme = if window.is_dark { "dark" } else { "light" };
        let features = json!([
            {"name": "prefers-color-scheme", "value": scheme},
            {"name": "prefers-reduced-motion", "value": "reduce"},
        ]);
        tab.call("Emulation.setEmulatedMedia", &json!({"features": features}));
        let url = format!("file://{}", page.display());
        tab.call("Page.navigate", &json!({"url": url}));
        while !tab.browser.is_loaded {
            tab.browser.read();
        }
        tab
    }

    /// Result of a command.
    fn call(&mut self, session: Option<&str>, method: &str, params: &Value) -> Value {
        self.calls += 1;
        let id = self.calls;
        let mut call = json!({"id": id, "method": method, "params": params});
        if let Some(session) = session {
            call["sessionId"] = session.into();
        }
        self.socket.send(Message::text(call.to_string())).unwrap();
        loop {
            let message = self.read();
            if message["id"] == id {
                assert_eq!(message.get("error"), None, "{method} {params}");
                return message["result"].clone();
            }
        }
    }

    /// The next message; records errors and the end of loading.
    fn read(&mut self) -> Value {
        let message = self.socket.read().unwrap();
        let message: Value = serde_json::from_str(message.to_text().unwrap()).unwrap();
        let params = &message["params"];
        match message["method"].as_str() {
            Some("Page.loadEventFired") => self.is_loaded = true,
            Some("Runtime.exceptionThrown") => {
                self.errors.push(params["exceptionDetails"].to_string());
            }
            Some("Runtime.consoleAPICalled") if params["type"] == "error" => {
                self.errors.push(params["args"].to_string());
            }
            Some("Log.entryAdded") if params["entry"]["level"] == "error" => {
                self.errors.push(params["entry"].to_string());
            }
            _ => {}
        }
        message
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_dir_all(&self.profile);
    }
}

/// A page in a tab.
pub(super) struct Tab<'a> {
    browser: &'a mut Browser,
    target: String,
    session: String,
}

impl Tab<'_> {
    fn call(&mut self, method: &str, params: &Value) -> Value {
        self.browser.call(Some(&self.session), method, params)
    }

    /// Value of an expression, which may be a promise.
    pub(super) fn value(&mut self, expression: &str) -> Value {
        let params = json!({
            "expression": expression, "returnByValue": true, "awaitPromise": true
        });
        let result = self.call("Runtime.evaluate", &params);
        assert_eq!(result.get("exceptionDetails"), None, "{expression}");
        result["result"]["value"].clone()
    }

    /// Presses a key.
    pub(super) fn press(&mut self, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            let event =
                json!({"type": kind, "key": key, "text": if key.len() == 1 { key } else { "" }});
            self.call("Input.dispatchKeyEvent", &event);
        }
    }

    /// Moves the mouse with these buttons, or presses or releases the left one.
    pub(super) fn mouse(&mut self, kind: &str, (x, y): (f64, f64)) {
        let event = json!({
            "type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1
        });
        self.call("Input.dispatchMouseEvent", &event);
    }

    /// Errors so far.
    pub(super) fn errors(&mut self) -> Vec<String> {
        // Two frames are drawn, and reported, before this returns.
        let frames = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(0))))";
        self.value(frames);
        std::mem::take(&mut self.browser.errors)
    }

    /// Width of the contents beyond the window, in px, and the element that reaches farthest.
    pub(super) fn overflow(&mut self) -> (f64, String) {
        let by = "document.documentElement.scrollWidth - document.documentElement.clientWidth";
        let farthest = "[...document.querySelectorAll('body *')].reduce((a, b) => \
            b.getBoundingClientRect().right > a.getBoundingClientRect().right ? b : a).outerHTML.slice(0, 80)";
        let by = self.value(by).as_f64().unwrap();
        (by, self.value(farthest).as_str().unwrap().to_owned())
    }
}

impl Drop for Tab<'_> {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            let target = json!({"targetId": self.target});
            self.browser.call(None, "Target.closeTarget", &target);
        }
    }
}
