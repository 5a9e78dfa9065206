//! A cable between a host and a board on a socket, which can be unplugged.

use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use armbridge_client::tcp_pump;
use armbridge_client::transport::LinkUri;

/// Plugged in at first.
pub struct Cable {
    /// The host's end.
    pub link: LinkUri,
    is_plugged: Arc<AtomicBool>,
    wires: Arc<Mutex<Vec<TcpStream>>>,
}

impl Cable {
    /// To a board on a socket.
    pub fn to(board: &LinkUri) -> Self {
        let LinkUri::Tcp(board) = board.clone() else {
            panic!("{board} is no socket");
        };
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let at = listener.local_addr().unwrap();
        let is_plugged = Arc::new(AtomicBool::new(true));
        let wires = Arc::new(Mutex::new(Vec::new()));
        {
            let (is_plugged, wires) = (Arc::clone(&is_plugged), Arc::clone(&wires));
            // Ends with the test's process.
            std::thread::spawn(move || {
                for near in listener.incoming().map_while(Result::ok) {
                    if is_plugged.load(Ordering::Relaxed) {
                        let far = board.connect().unwrap();
                        near.set_nodelay(true).unwrap();
                        tcp_pump::join(&near, &far).unwrap();
                        wires.lock().unwrap().extend([near, far]);
                    }
                }
            });
        }
        Self {
            link: format!("tcp://{at}").parse().unwrap(),
            is_plugged,
            wires,
        }
    }

    /// Breaks every connection and takes no more.
    pub fn unplug(&self) {
        self.is_plugged.store(false, Ordering::Relaxed);
        for wire in self.wires.lock().unwrap().drain(..) {
            let _ = wire.shutdown(Shutdown::Both);
        }
    }

    /// Takes connections again.
    pub fn plug_in(&self) {
        self.is_plugged.store(true, Ordering::Relaxed);
    }
}
