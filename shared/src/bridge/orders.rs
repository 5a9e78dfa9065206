//! What the host wants.

use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::Bridge;
use super::mailbox::{Notice, Order, Task};
use super::supervisor::{Event, Request};
use crate::link::message::Refusal;

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8>,
    D: OutputPin,
{
    pub(super) fn take_orders(&mut self) {
        while let Some(order) = self.end.orders.dequeue() {
            self.heard_us = self.now_us;
            if let Order::Do(sequence, task) = order {
                let result = self.perform(task);
                // Lost if the host does not fetch them: it will ask again.
                let _ = self.end.notices.enqueue(Notice::Ack(sequence, result));
            }
        }
    }

    pub(super) fn perform(&mut self, task: Task) -> Result<(), Refusal> {
        match task {
            Task::Idle => self.apply(Event::Asked(Request::Idle)),
            Task::ClearFault => self.apply(Event::Asked(Request::ClearFault)),
            Task::Torque(torque_nm) => {
                self.apply(Event::Asked(Request::Torque))?;
                self.torque_nm = torque_nm;
                Ok(())
            }
            Task::Regulate(reference_rad) => {
                self.apply(Event::Asked(Request::Regulate))?;
                self.law.set_reference(reference_rad);
                Ok(())
            }
            Task::Install(law) => {
                self.apply(Event::Asked(Request::Configure))?;
                self.law = law;
                self.is_fresh = true;
                Ok(())
            }
        }
    }
}
