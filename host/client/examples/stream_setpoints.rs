//! Moves both joints along a slow sinusoid, 50 setpoints a second for 10 s.
//!
//! `cargo run --release -p armbridge-client --example stream_setpoints -- serial:`, or
//! with the simulated board of `armbridge serve board --listen tcp://127.0.0.1:7001`:
//! `.. stream_setpoints -- tcp://127.0.0.1:7001`.

use std::error::Error;
use std::thread::{sleep, spawn};
use std::time::Duration;

use armbridge_client::session::{ChannelHost, Request};
use armbridge_client::transport::{LinkOptions, LinkUri, drive};
use armbridge_link::message::{Command, Mode};

fn main() -> Result<(), Box<dyn Error>> {
    let link: LinkUri = std::env::args().nth(1).ok_or("name a link")?.parse()?;
    let (host, board) = ChannelHost::new();
    let link = spawn(move || drive(&link, LinkOptions::default(), host).1);
    let is_idle = board.wait_for(Duration::from_secs(5), |board| {
        board.mode() == Some(Mode::Idle)
    });
    if is_idle {
        board.request(Request::Arm)?;
        for step in 0..500 {
            let angle_rad = 0.2 * (f64::from(step) * 0.02).sin() as f32;
            let setpoint = Command::Regulate([angle_rad, -angle_rad]);
            board.request(Request::Command(setpoint))?;
            sleep(Duration::from_millis(20));
        }
    }
    println!("{:?}", board.status().mode());
    // Without a handle the host disarms the board and leaves.
    drop(board);
    link.join().map_err(|_| "the link's thread panicked")??;
    Ok(())
}
