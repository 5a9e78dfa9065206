//! Timed actions of the blocks: bytes on the bus, DMA, USB transactions, and the
//! lines of interrupts that result.

use super::{System, Unmodelled, map};
use crate::core::Core;
use crate::line::Line;
use crate::peripherals::dma::Direction;
use crate::peripherals::timer::Timer;
use crate::peripherals::usart::{Received, Usart};
use crate::time::Time;

impl<L: Line> System<L> {
    /// Serves all blocks at the present time, and sets the interrupt lines of the core.
    pub(crate) fn serve(&mut self, core: &mut Core) {
        let now = self.now;
        if self.rcc.next(now) <= now {
            self.update_clocks();
        }
        self.rcc.update(now);
        if self.cycle != Time::periods(1, self.rcc.clocks().core_hz) {
            self.update_clocks();
        }
        for timer in &mut self.timers {
            timer.advance(now);
        }
        self.serve_bus();
        self.otg.is_wired = self.gpio.alternate(map::USB_PLUS.0) == Some(map::USB_PLUS.1);
        self.usb.advance(now, &mut self.otg);
        self.exti
            .set_line(map::PVD_LINE, self.pwr.is_low(self.supply_mv));
        self.set_interrupts(core);
        if self.flash.take_changed() {
            core.invalidate();
        }
        self.is_touched = false;
        self.next = self.next_event();
    }

    /// Time of the next event of any block.
    fn next_event(&self) -> Time {
        let timers = self.timers.iter().map(Timer::next);
        let usarts = self.usarts.iter().map(Usart::next);
        let others = [
            self.line.next(),
            self.usb.next(),
            self.iwdg.next(),
            self.rcc.next(self.now),
        ];
        let all = timers.chain(usarts).chain(others);
        all.min().unwrap_or(Time::NEVER)
    }

    /// The bus: what the board sends, what it receives, and its DMA.
    fn serve_bus(&mut self) {
        let now = self.now;
        let port = self.board.bus.0 - 1;
        loop {
            for usart in &mut self.usarts {
                usart.advance(now);
            }
            self.transmit(port);
            let baud = self.usarts[port].baud();
            self.line.set_baud(baud);
            let mut received = std::mem::take(&mut self.received);
            self.line.advance(now, &mut received);
            for byte in received.drain(..) {
                self.receive(port, byte);
            }
            self.received = received;
            let mut is_moved = false;
            for usart in 0..self.usarts.len() {
                is_moved |= self.dma_from(usart) | self.dma_to(usart);
            }
            if !is_moved && !self.usarts[port].has_sent() {
                break;
            }
        }
        self.note_cuts(port);
    }

    /// Bytes that begin to be sent go to the line if the buffer drives it.
    fn transmit(&mut self, port: usize) {
        let is_driving = self.gpio.level(self.board.direction);
        for byte in self.usarts[port].take_sent() {
            if is_driving {
                self.line.send(byte);
            } else {
                self.bus_faults.undriven += 1;
            }
        }
    }

    /// A byte from the line reaches the receiver unless the board drives the line.
    fn receive(&mut self, port: usize, byte: Received) {
        if self.gpio.level(self.board.direction) {
            self.bus_faults.collisions += 1;
            return;
        }
        self.usarts[port].receive(byte);
        self.dma_from(port);
    }

    /// The direction pin that falls within a byte cuts it off.
    fn note_cuts(&mut self, port: usize) {
        let edges = self.gpio.edges();
        for edge in &edges[self.edges_seen..] {
            let is_release = edge.pin == self.board.direction && !edge.is_high;
            if is_release && self.usarts[port].is_sending(edge.at) {
                self.bus_faults.cut += 1;
            }
        }
        self.edges_seen = edges.len();
    }

    /// Moves received bytes of a USART to memory.
    fn dma_from(&mut self, usart: usize) -> bool {
        let mut is_moved = false;
        while self.usarts[usart].wants_read() {
            let Some((dma, stream)) =
                self.stream(map::RECEIVE[usart], usart, Direction::FromPeripheral)
            else {
                break;
            };
            let byte = self.usarts[usart].take_data();
            let (address, _) = self.dma[dma].memory(stream);
            if self.dma_write(address, byte).is_none() {
                self.unmodelled.insert(Unmodelled::Address(address));
            }
            self.dma[dma].moved(stream);
            is_moved = true;
        }
        is_moved
    }

    /// Moves bytes from memory to a USART.
    fn dma_to(&mut self, usart: usize) -> bool {
        let mut is_moved = false;
        while self.usarts[usart].wants_write() {
            let Some((dma, stream)) =
                self.stream(map::TRANSMIT[usart], usart, Direction::ToPeripheral)
            else {
                break;
            };
            let (address, _) = self.dma[dma].memory(stream);
            let byte = self.dma_read(address);
            if byte.is_none() {
                self.unmodelled.insert(Unmodelled::Address(address));
            }
            self.usarts[usart].put_data(self.now, byte.unwrap_or(0));
            self.dma[dma].moved(stream);
            is_moved = true;
        }
        is_moved
    }

    /// The stream that serves a request of a USART.
    fn stream(
        &self,
        requests: &[(usize, usize, u32)],
        usart: usize,
        direction: Direction,
    ) -> Option<(usize, usize)> {
        let register = map::data_register(usart);
        let found = requests.iter().find(|(dma, stream, channel)| {
            self.dma[*dma].serves(*stream, *channel, register, direction)
        });
        found.map(|(dma, stream, _)| (*dma, *stream))
    }

    fn set_interrupts(&self, core: &mut Core) {
        for (timer, interrupt) in self.timers.iter().zip(map::TIMERS) {
            core.set_line(interrupt, timer.is_interrupt());
        }
        for (usart, interrupt) in self.usarts.iter().zip(map::USARTS) {
            core.set_line(interrupt, usart.is_interrupt());
        }
        for (dma, interrupts) in self.dma.iter().zip(map::DMA) {
            for (stream, interrupt) in interrupts.into_iter().enumerate() {
                core.set_line(interrupt, dma.is_interrupt(stream));
            }
        }
        core.set_line(map::OTG, self.otg.is_interrupt());
        core.set_line(map::PVD, self.exti.is_pending(map::PVD_LINE));
        if self.rcc.is_nmi() {
            core.pend_nmi();
        }
    }
}
