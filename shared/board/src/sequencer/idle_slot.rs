//! Idle slots: the time between a tick's exchange and the next tick, for one request.
//!
//! A request is registered with its owner and the reply that it expects; the reply
//! goes to that owner and to no other. It must fit the time that is left, unless a tick
//! may begin late for it.

use super::force_off::CheckKind;
use super::health_poll::HealthRequest;
use super::idle_request::{IdleRequest, Owner};
use super::time_budget::TimeBudget;
use super::{BusSequencer, Dropouts, State};
use armbridge_link::record::Permission;
use armbridge_servo::Query;
use armbridge_servo::bus::Bus;
use armbridge_servo::master::timing::{GUARD_US, reply_latency_us, same_servo_guard_us};

/// Margin in µs that client traffic leaves before a tick: it must never delay one.
const RESERVE_US: u64 = 10;
/// Time in µs from the end of the last exchange in which a reading begins that makes the next tick
/// late: more than a board computes for a tick.
const SLOT_BEGIN_US: u64 = 100;

impl<B: Bus> BusSequencer<B> {
    /// Sends the board's own next request in the present idle slot; whether one was sent.
    pub fn use_idle_slot(&mut self, tick_due_us: u64, dropouts: &Dropouts) -> bool {
        if !(self.is_ticking() && self.master.is_idle()) {
            return false;
        }
        if self.check_off(tick_due_us) {
            return true;
        }
        let firmware = self.firmware();
        let may_drive = self.permission.is_armed();
        let due = self.health.next(firmware, self.now_us, dropouts, may_drive);
        let Some((health, may_be_late)) = due else {
            return false;
        };
        let joint = match health {
            HealthRequest::Temperature { joint }
            | HealthRequest::Torque { joint }
            | HealthRequest::Ping { joint } => joint,
        };
        let servo = self.ids.get(joint).copied();
        // Later in the slot it would make the tick later.
        let is_at_begin = self.now_us < self.master.active_us() + SLOT_BEGIN_US;
        let is_ping = matches!(health, HealthRequest::Ping { .. });
        let may_be_late = may_be_late && (is_at_begin || is_ping);
        let Some(query) = servo.and_then(|servo| health.query(firmware, servo)) else {
            return false;
        };
        let request = IdleRequest {
            query,
            owner: Owner::Health(health),
            may_be_late,
        };
        let is_sent = self.request(&request, tick_due_us);
        if is_sent {
            self.health.note_sent(health, self.now_us, self.ids.len());
        }
        is_sent
    }

    /// Sends a query that shows whether a motor is off. With an arm that is to be driven
    /// soon it delays no tick.
    fn check_off(&mut self, tick_due_us: u64) -> bool {
        if self.state != State::ForceOff {
            return false;
        }
        let Some(check) = self.off.next_check(self.now_us) else {
            return false;
        };
        let Some(servo) = self.ids.get(check.joint).copied() else {
            return false;
        };
        let query = match check.kind {
            CheckKind::Ping => self.firmware().ping_query(servo),
            CheckKind::ReadBack => self.firmware().off_query(servo, self.master.mode()),
        };
        let request = IdleRequest {
            query,
            owner: Owner::Off(check),
            may_be_late: self.permission == Permission::Off,
        };
        let is_sent = self.request(&request, tick_due_us);
        if is_sent {
            let left_us = tick_due_us.saturating_sub(self.now_us);
            self.off.note_sent(check, self.now_us, left_us);
        }
        is_sent
    }

    /// Time until the next tick for a request to this servo and its reply; `None` without
    /// an idle slot.
    pub fn time_budget(&self, id: u8, tick_due_us: u64) -> Option<TimeBudget> {
        if !(self.is_ticking() && self.master.is_idle()) {
            return None;
        }
        let begins_us = self.now_us.max(self.master.ready_at_us(id));
        let budget_us = tick_due_us.saturating_sub(begins_us + GUARD_US + RESERVE_US);
        Some(self.budget_of(id, budget_us as u32))
    }

    /// Time budget of a period after an exchange of this duration, for this servo.
    pub fn spare_budget(&self, id: u8, period_us: u32, exchange_us: u32) -> TimeBudget {
        let rests_us = (same_servo_guard_us(self.firmware()) + GUARD_US + RESERVE_US) as u32;
        self.budget_of(id, period_us.saturating_sub(exchange_us + rests_us))
    }

    fn budget_of(&self, id: u8, budget_us: u32) -> TimeBudget {
        let (firmware, baud) = (self.firmware(), self.baud());
        let is_ours = self.ids.iter().any(|ours| ours.get() == id);
        let answers_soon = is_ours && self.master.answers_soon();
        let latency_us = reply_latency_us(firmware, baud, answers_soon);
        TimeBudget::new(budget_us, baud, latency_us)
    }

    /// Sends a client's query in the present idle slot. The caller has made it fit.
    pub fn request_for_client<const N: usize>(&mut self, query: Query<N>, tick_due_us: u64) {
        let request = IdleRequest {
            query,
            owner: Owner::Client,
            may_be_late: false,
        };
        let _ = self.request(&request, tick_due_us);
    }

    /// Sends this request in the present idle slot, if it fits; whether it was sent.
    pub(super) fn request<const N: usize>(
        &mut self,
        request: &IdleRequest<N>,
        tick_due_us: u64,
    ) -> bool {
        let IdleRequest {
            query,
            owner,
            may_be_late,
        } = request;
        let Some(budget) = self.time_budget(query.id, tick_due_us) else {
            return false;
        };
        if !(*may_be_late || budget.fits(query)) {
            return false;
        }
        let expected = query.expected_reply(budget.latency_us);
        if self
            .master
            .request(&query.packet, expected, self.now_us)
            .is_err()
        {
            return false;
        }
        self.owner = Some(*owner);
        let _ = self.master.poll(self.now_us);
        true
    }
}
