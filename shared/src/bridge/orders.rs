//! What the host wants.

use crate::servo::port::SetBaud;
use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::Bridge;
use super::app_core::BusFacts;
use super::command::ValidatedCommand;
use super::mailbox::{Notice, Order};
use super::schedule::Stage;
use super::settle::Chore;
use crate::link::message::Refusal;
use crate::servo::Firmware;
use crate::supervisor::Event;

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    pub(super) fn take_orders(&mut self) {
        if let Some(source) = self.end.take_emergency() {
            self.emergency_stop(source);
        }
        while let Some(order) = self.end.orders.dequeue() {
            match order {
                Order::Heartbeat => self.core.note_host(),
                Order::Greeted => self.greet(),
                Order::Goodbye => {
                    // Never refused.
                    let _ = self.apply(Event::Disarm);
                }
                Order::Do(sequence, command) => {
                    self.core.note_host();
                    self.take_command(sequence, command);
                }
            }
        }
    }

    /// A host says hello.
    fn greet(&mut self) {
        self.core.greet();
        self.heed_core();
        let _ = self.end.notices.enqueue(Notice::Began(self.core.moment()));
        self.announce();
        if let Some(trip) = self.core.cause() {
            let _ = self.end.notices.enqueue(Notice::Tripped(trip));
        }
    }

    fn take_command(&mut self, sequence: u16, command: ValidatedCommand) {
        self.gateway.claim(self.core.now_us());
        let moment = self.core.moment();
        let notice = if matches!(command, ValidatedCommand::StartPoint) {
            self.core.start_point().map_or_else(
                |refusal| Notice::Ack(sequence, Err(refusal), moment),
                |start| Notice::StartPoint(sequence, start, moment),
            )
        } else {
            Notice::Ack(sequence, self.perform(command), moment)
        };
        // Lost if the host does not fetch them: it will ask again.
        let _ = self.end.notices.enqueue(notice);
    }

    fn perform(&mut self, command: ValidatedCommand) -> Result<(), Refusal> {
        let bus = BusFacts {
            is_prepared: self.master.is_prepared(),
            least_period_us: self.least_period_us(),
        };
        let is_stock = self.master.firmware() == Firmware::Stock;
        let chore = match command {
            ValidatedCommand::Prepare if !bus.is_prepared => Some(Chore::PREPARE),
            ValidatedCommand::Release if is_stock => Some(Chore::RESTORE),
            _ => None,
        };
        let result = self.core.command(command, bus);
        self.heed_core();
        if let (Ok(()), Some(chore)) = (result, chore) {
            self.stage = Stage::Settle(chore);
        }
        result
    }
}
