//! The board's side of lockstep: time stands still until the bench grants it.
//!
//! ```text
//! board                                    bench
//!   everything is done, the tick waits
//!   other ports: take what has come, send all
//!   Idle { until, bytes sent so far } ---->  fetches the announced bytes,
//!                                            moves the arm, feeds the ports,
//!   waits for the announced bytes    <-----  Grant { now, bytes sent so far }
//!   other ports: take what has come, send all
//!   time becomes `now`, the tick runs at once, until it waits again
//! ```
//!
//! The bench sends bus and link bytes only right before the grant that
//! announces them. So the order of events is always the same, whatever either
//! process does meanwhile; only measured computing times differ between runs.
//!
//! `Idle` goes to QEMU's standard output, `Grant` is read from its standard
//! input. Waiting for a grant stops all of QEMU, so everything is on its way
//! before; a bench that closes the pipe ends QEMU. A serial port would do the
//! same at half the speed: QEMU takes about 25 µs for every byte it feeds to
//! one.

use super::semihosting::{self, EXIT_NO_BENCH, Stdio};
use super::{BUS, CLIENT, LINK, time};
use crate::end::memory;
use crate::settings;
use armbridge_shared::bridge::LinkPort;
use armbridge_shared::bridge::gateway::PortEnd;
use armbridge_shared::lockstep::{Grant, Idle, MESSAGE_LEN};
use armbridge_shared::store::Store;
use embedded_storage::nor_flash::NorFlash;

/// Runs the bridge by grants, for ever, in thread mode and in place of
/// [`crate::run::link`]. The real-time loop must be waiting.
pub async fn run(
    mut port: LinkPort<'_>,
    mut client: PortEnd<'_>,
    mut store: Store<impl NorFlash>,
) -> ! {
    let Some(mut bench) = Stdio::open() else {
        semihosting::exit(EXIT_NO_BENCH);
    };
    loop {
        serve_link(&mut port, &mut store).await;
        serve_client(&mut client).await;
        let (until_us, bus_wanted) = time::waits_for();
        let idle = Idle {
            until_us,
            bus_wanted,
            bus_tx: BUS.buffers().written_total() as u16,
            link_tx: LINK.buffers().written_total(),
            client_tx: CLIENT.buffers().written_total(),
            bus_baud: memory::baud(),
        };
        for port in [&BUS, &LINK, &CLIENT] {
            port.until_sent().await;
        }
        let mut answer = [0; MESSAGE_LEN];
        if !(bench.write(&idle.to_bytes()) && bench.read(&mut answer)) {
            semihosting::exit(EXIT_NO_BENCH);
        }

        let grant = Grant::from_bytes(answer);
        BUS.until(|bus| has_come(bus.received_total(), grant.bus_rx))
            .await;
        loop {
            serve_link(&mut port, &mut store).await;
            if has_come(LINK.buffers().received_total(), grant.link_rx) {
                break;
            }
            LINK.until(|link| {
                link.has_received() || has_come(link.received_total(), grant.link_rx)
            })
            .await;
        }
        serve_link(&mut port, &mut store).await;
        loop {
            serve_client(&mut client).await;
            if has_come(CLIENT.buffers().received_total(), grant.client_rx) {
                break;
            }
            CLIENT
                .until(|port| {
                    port.has_received() || has_come(port.received_total(), grant.client_rx)
                })
                .await;
        }
        serve_client(&mut client).await;
        client.set_line(grant.client_line);
        time::grant(grant.now_us, grant.is_stop_pressed);
    }
}

/// Whether a count modulo 2³² has reached `target`.
fn has_come(count: u32, target: u32) -> bool {
    target.wrapping_sub(count) as i32 <= 0
}

/// Takes all that the host has sent and sends it all there is.
async fn serve_link(port: &mut LinkPort<'_>, store: &mut Store<impl NorFlash>) {
    while let Some(byte) = LINK.buffers().read() {
        port.receive(&[byte]);
    }
    loop {
        while let Some(frame) = port.transmit() {
            for byte in frame {
                LINK.until(|link| link.write(*byte)).await;
            }
            LINK.send();
        }
        if !settings::keep(port, store) {
            break;
        }
    }
}

/// Takes what the client has sent, as far as there is room, and sends it all
/// there is.
async fn serve_client(client: &mut PortEnd<'_>) {
    while client.room() > 0
        && let Some(byte) = CLIENT.buffers().read()
    {
        client.receive(&[byte]);
    }
    while let Some(byte) = client.transmit() {
        CLIENT.until(|port| port.write(byte)).await;
    }
    CLIENT.send();
}
