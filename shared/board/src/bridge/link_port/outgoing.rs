//! Frames for the host: answers first, then notifications of the tick, then records.

use super::LinkPort;
use crate::bridge::channels::Notification;
use armbridge_link::message::{Refusal, ToHost};
use armbridge_link::schema;

impl LinkPort<'_> {
    pub(super) fn drop_records(&mut self) {
        while self.end.records.dequeue().is_some() {}
    }

    /// Takes the next frame for the host.
    pub fn transmit(&mut self) -> Option<&[u8]> {
        if let Some(message) = self.next_message() {
            return Some(self.encoder.encode(&message).1);
        }
        if !self.is_greeted {
            return None;
        }
        let Self { end, encoder, .. } = self;
        end.records.take(|record| encoder.encode_record(record))
    }

    /// The frame that was taken last, whose bytes stay until the next is.
    pub fn last_frame(&self) -> &[u8] {
        self.encoder.last()
    }

    /// Takes the next message other than a record; records are encoded in place.
    fn next_message(&mut self) -> Option<ToHost> {
        if core::mem::take(&mut self.pending.hello) {
            return Some(ToHost::Hello(schema::HELLO));
        }
        if let Some((sequence, result)) = self.answer.take() {
            return Some(ToHost::Ack {
                sequence,
                result,
                moment: None,
            });
        }
        if !self.is_greeted {
            // Without a host records do not count as dropped.
            self.drop_records();
            return None;
        }
        if core::mem::take(&mut self.pending.report) {
            return Some(ToHost::Board(self.report));
        }
        if core::mem::take(&mut self.pending.settings) {
            return Some(ToHost::Settings(self.settings));
        }
        while let Some(notification) = self.end.notifications.dequeue() {
            let message = match notification {
                Notification::Dropped(sequence) => {
                    self.conclude_offer(sequence, Err(Refusal::Stale));
                    self.saving.take_if(|(saving, _)| *saving == sequence);
                    Some(ToHost::Ack {
                        sequence,
                        result: Err(Refusal::Stale),
                        moment: None,
                    })
                }
                Notification::Ack(sequence, result, moment) => self.ack(sequence, result, moment),
                Notification::Began(moment) => Some(ToHost::Began(moment)),
                Notification::Absent(joint, missing) => Some(ToHost::Absent { joint, missing }),
                Notification::Found(firmware, baud, is_ready) => Some(ToHost::Found {
                    firmware,
                    baud,
                    is_ready,
                }),
                Notification::Mixed(firmwares) => Some(ToHost::Mixed(firmwares)),
                Notification::Passthrough => Some(ToHost::Passthrough),
                Notification::Unprepared(joint) => Some(ToHost::Unprepared { joint }),
                Notification::Port(counters) => Some(ToHost::Port(counters)),
                Notification::Tripped(trip) => Some(ToHost::Tripped(trip)),
                Notification::Off(report) => Some(ToHost::Off(report)),
                Notification::Concluded(conclusion) => Some(ToHost::Concluded(conclusion)),
                Notification::Temperature(joint, value) => {
                    Some(ToHost::Temperature { joint, value })
                }
                Notification::StartPoint(sequence, start, moment) => {
                    self.plan(sequence, start);
                    Some(ToHost::Departs { sequence, moment })
                }
            };
            if message.is_some() {
                return message;
            }
        }
        None
    }
}
