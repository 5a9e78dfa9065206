//! Exceptions: which are enabled, pending and active, their priorities, and which comes next.
//!
//! Numbers are exception numbers: 16 is interrupt 0. After each change, [`Nvic::ready`] is the
//! exception to enter, 0 for none. Source: DDI 0403, B1.5 and B3.4.

use super::exception_set::Exceptions;

/// Exception numbers.
pub(crate) mod number {
    pub(crate) const NMI: u16 = 2;
    pub(crate) const HARD_FAULT: u16 = 3;
    pub(crate) const MEMORY_FAULT: u16 = 4;
    pub(crate) const BUS_FAULT: u16 = 5;
    pub(crate) const USAGE_FAULT: u16 = 6;
    pub(crate) const SUPERVISOR_CALL: u16 = 11;
    pub(crate) const DEBUG_MONITOR: u16 = 12;
    pub(crate) const PEND_SUPERVISOR: u16 = 14;
    pub(crate) const SYSTICK: u16 = 15;
    pub(crate) const INTERRUPT_0: u16 = 16;
}

/// Execution priority while nothing is active and nothing masked.
const LOWEST: i16 = 256;
/// Exceptions enabled for good: NMI, `HardFault`, `SVCall`, `PendSV` and `SysTick`.
const ALWAYS_ENABLED: u64 = 1 << 2 | 1 << 3 | 1 << 11 | 1 << 14 | 1 << 15;

/// State of all exceptions, and the masks.
#[derive(Clone, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "masks and events")]
pub(crate) struct Nvic {
    interrupts: u16,
    priority_mask: u8,
    group_mask: u8,
    priorities: [u8; 256],
    enabled: Exceptions,
    pending: Exceptions,
    active: Exceptions,
    lines: Exceptions,
    primask: bool,
    faultmask: bool,
    basepri: u8,
    /// Whether an exception that becomes pending is an event.
    pub(crate) event_on_pend: bool,
    /// The event register.
    pub(crate) event: bool,
    /// Group priority of the active exceptions.
    active_priority: i16,
    /// The pending and enabled exception of highest priority, 0 for none.
    first: u16,
    first_priority: i16,
    ready: u16,
}

impl Nvic {
    pub(crate) fn new(interrupts: u16, priority_bits: u8) -> Self {
        let mut nvic = Self {
            interrupts: interrupts.min(240),
            priority_mask: !(0xFF_u16 >> priority_bits.min(8)) as u8,
            group_mask: 0,
            priorities: [0; 256],
            enabled: Exceptions::default(),
            pending: Exceptions::default(),
            active: Exceptions::default(),
            lines: Exceptions::default(),
            primask: false,
            faultmask: false,
            basepri: 0,
            event_on_pend: false,
            event: false,
            active_priority: LOWEST,
            first: 0,
            first_priority: LOWEST,
            ready: 0,
        };
        nvic.reset();
        nvic
    }

    /// As after a reset; lines of devices stay as they are.
    pub(crate) fn reset(&mut self) {
        self.priorities = [0; 256];
        self.enabled = Exceptions([ALWAYS_ENABLED, 0, 0, 0]);
        self.pending = self.lines;
        self.active = Exceptions::default();
        self.primask = false;
        self.faultmask = false;
        self.basepri = 0;
        self.event_on_pend = false;
        self.event = false;
        self.set_grouping(0);
    }

    /// The exception to be entered now, 0 for none.
    #[inline]
    pub(crate) fn ready(&self) -> u16 {
        self.ready
    }

    /// Whether an exception ends WFI: PRIMASK does not count.
    pub(crate) fn wakes(&self) -> bool {
        let priority = self.boosted(false).min(self.active_priority);
        self.first != 0 && self.group(self.first_priority) < priority
    }

    /// Number of the last exception that exists.
    pub(crate) fn last(&self) -> u16 {
        number::INTERRUPT_0 + self.interrupts - 1
    }

    fn exists(&self, number: u16) -> bool {
        number < number::INTERRUPT_0 + self.interrupts
    }

    /// Priority of an exception, with its subpriority.
    fn priority(&self, number: u16) -> i16 {
        match number {
            0 => LOWEST,
            1..=3 => number as i16 - 4,
            _ => i16::from(self.priorities[usize::from(number & 255)]),
        }
    }

    fn group(&self, priority: i16) -> i16 {
        if (0..LOWEST).contains(&priority) {
            priority & i16::from(self.group_mask)
        } else {
            priority
        }
    }

    fn boosted(&self, primask: bool) -> i16 {
        if self.faultmask {
            -1
        } else if primask {
            0
        } else if self.basepri != 0 {
            i16::from(self.basepri & self.group_mask)
        } else {
            LOWEST
        }
    }

    /// Priority at which the processor executes; an exception has to be below.
    pub(crate) fn execution_priority(&self) -> i16 {
        self.active_priority.min(self.boosted(self.primask))
    }

    /// Whether this exception may be entered at present.
    pub(crate) fn can_preempt(&self, number: u16) -> bool {
        self.enabled.has(number) && self.group(self.priority(number)) < self.execution_priority()
    }

    fn update(&mut self) {
        let candidates = self.pending.and(self.enabled).iter();
        let first = candidates
            .map(|number| (self.priority(number), number))
            .min();
        (self.first_priority, self.first) = first.unwrap_or((LOWEST, 0));
        self.update_ready();
    }

    fn update_ready(&mut self) {
        let preempts =
            self.first != 0 && self.group(self.first_priority) < self.execution_priority();
        self.ready = if preempts { self.first } else { 0 };
    }

    fn update_active(&mut self) {
        let active = self.active.iter();
        let priority = active.map(|number| self.group(self.priority(number))).min();
        self.active_priority = priority.unwrap_or(LOWEST);
        self.update();
    }

    pub(crate) fn masks(&self) -> (bool, bool, u8) {
        (self.primask, self.faultmask, self.basepri)
    }

    pub(crate) fn set_primask(&mut self, value: bool) {
        self.primask = value;
        self.update_ready();
    }

    pub(crate) fn set_faultmask(&mut self, value: bool) {
        self.faultmask = value;
        self.update_ready();
    }

    pub(crate) fn set_basepri(&mut self, value: u8) {
        self.basepri = value & self.priority_mask;
        self.update_ready();
    }

    /// Which bits of a priority are its group, as `AIRCR.PRIGROUP` says.
    pub(crate) fn set_grouping(&mut self, prigroup: u32) {
        self.group_mask = !((2_u32 << (prigroup & 7)) - 1) as u8;
        self.update_active();
    }

    pub(crate) fn priority_bits(&self, number: u16) -> u8 {
        self.priorities[usize::from(number & 255)]
    }

    pub(crate) fn set_priority_bits(&mut self, number: u16, value: u8) {
        let is_settable = (4..=6).contains(&number)
            || (11..=12).contains(&number)
            || number >= number::PEND_SUPERVISOR && self.exists(number);
        if is_settable {
            self.priorities[usize::from(number & 255)] = value & self.priority_mask;
            self.update_active();
        }
    }

    pub(crate) fn is_enabled(&self, number: u16) -> bool {
        self.enabled.has(number)
    }

    pub(crate) fn set_enabled(&mut self, number: u16, value: bool) {
        if self.exists(number) {
            self.enabled.set(number, value);
            self.update();
        }
    }

    pub(crate) fn is_pending(&self, number: u16) -> bool {
        self.pending.has(number)
    }

    pub(crate) fn pend(&mut self, number: u16) {
        if self.exists(number) {
            self.event |= self.event_on_pend && !self.pending.has(number);
            self.pending.set(number, true);
            self.update();
        }
    }

    /// Clears a pending exception; one whose line is high is pending again.
    pub(crate) fn unpend(&mut self, number: u16) {
        let line = self.lines.has(number) && !self.active.has(number);
        self.pending.set(number, line);
        self.update();
    }

    pub(crate) fn set_line(&mut self, number: u16, level: bool) {
        if self.lines.has(number) != level && self.exists(number) {
            self.lines.set(number, level);
            if level {
                self.pend(number);
            }
        }
    }

    pub(crate) fn is_active(&self, number: u16) -> bool {
        self.active.has(number)
    }

    /// Sets the active state alone, as a write of SHCSR does.
    pub(crate) fn set_active(&mut self, number: u16, value: bool) {
        self.active.set(number, value);
        self.update_active();
    }

    pub(crate) fn active_count(&self) -> usize {
        self.active.iter().count()
    }

    /// The pending exception of highest priority, whatever is masked.
    pub(crate) fn first_pending(&self) -> u16 {
        self.first
    }

    /// An exception is entered.
    pub(crate) fn activate(&mut self, number: u16) {
        self.pending.set(number, false);
        self.active.set(number, true);
        self.event = true;
        self.update_active();
    }

    /// A handler returned; its exception is pending again if its line is still high.
    pub(crate) fn deactivate(&mut self, number: u16) {
        self.active.set(number, false);
        if number != number::NMI {
            self.faultmask = false;
        }
        if self.lines.has(number) {
            self.event |= self.event_on_pend && !self.pending.has(number);
            self.pending.set(number, true);
        }
        self.update_active();
    }
}
