//! Permission of the servos' supply: a stop that needs no packet on the bus.
//!
//! A board has an output for a relay or a switch in the servos' supply. While it is low, or
//! floats, servos have no power, whatever they were told last, and a servo that hears nothing
//! is stopped as well.
//!
//! | fault                                    | supply                              |
//! |------------------------------------------|-------------------------------------|
//! | none                                     | on: servos need power to be found, calibrated, and read with motors off |
//! | an emergency stop                        | off at once, from any source        |
//! | memory is corrupted                      | off at once: nor is the evidence below to be trusted |
//! | any other                                | on while motors are confirmed off, or have been for less than [`CONFIRM_US`]; then off |
//! | any, then an emergency stop              | off at once                         |
//!
//! Off is latched until the fault is cleared. Bring-up follows then, as after the servos'
//! power-up.
//!
//! The supply falls before the bus is done with its stop sequence. That is sent all the same: a
//! contact needs some ms to open, and may be welded or not be there.

use armbridge_link::message::Fault;
use embedded_hal::digital::PinState;

/// Time in µs for which motors may be unconfirmed during a fault. At 1 Mbaud stop sequence
/// and read-backs take 15 ms. At 57 600 baud the sequence alone takes 52 ms, so there the supply
/// may fall although the stop would have succeeded.
pub const CONFIRM_US: u64 = 100_000;

/// Permission of the servos' supply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SupplyPermission {
    /// Servos may have power.
    On,
    /// Servos must not have power.
    Off,
}

impl SupplyPermission {
    /// The permission that follows this one under `fault`, if there is one. `unconfirmed_us` is
    /// the time since the beginning of the fault, or since every motor was last confirmed off.
    #[must_use]
    pub fn next(self, fault: Option<Fault>, unconfirmed_us: u64) -> Self {
        match fault {
            None => Self::On,
            Some(Fault::EmergencyStop(_) | Fault::Corrupted) => Self::Off,
            Some(_) if unconfirmed_us >= CONFIRM_US => Self::Off,
            Some(_) => self,
        }
    }
}

/// High is on, so that a pin that floats, with a resistor to ground, is off.
impl From<SupplyPermission> for PinState {
    fn from(permission: SupplyPermission) -> Self {
        match permission {
            SupplyPermission::On => Self::High,
            SupplyPermission::Off => Self::Low,
        }
    }
}

/// The permission, and the time that it depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Supply {
    permission: SupplyPermission,
    /// Last time, in µs, without a fault or with every motor confirmed off.
    confirmed_us: u64,
}

impl Supply {
    /// Off, until the first update.
    pub(super) fn new(now_us: u64) -> Self {
        Self {
            permission: SupplyPermission::Off,
            confirmed_us: now_us,
        }
    }

    /// Takes an emergency stop, which may follow another fault.
    pub(super) fn stop(&mut self) {
        self.permission = SupplyPermission::Off;
    }

    /// The permission now. `is_off`: every motor is confirmed off.
    pub(super) fn update(
        &mut self,
        now_us: u64,
        fault: Option<Fault>,
        is_off: bool,
    ) -> SupplyPermission {
        if is_off || fault.is_none() {
            self.confirmed_us = now_us;
        }
        let unconfirmed_us = now_us.saturating_sub(self.confirmed_us);
        self.permission = self.permission.next(fault, unconfirmed_us);
        self.permission
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use SupplyPermission::{Off, On};
    use armbridge_link::message::StopSource;

    const LIMIT: Option<Fault> = Some(Fault::AngleLimit);
    const STOP: Option<Fault> = Some(Fault::EmergencyStop(StopSource::Pin));

    #[test]
    fn only_faults_cut_the_supply() {
        for before in [On, Off] {
            assert_eq!(before.next(None, u64::MAX), On);
        }
        let sources = StopSource::ALL;
        for fault in sources.map(Fault::EmergencyStop) {
            assert_eq!(On.next(Some(fault), 0), Off, "{fault:?}");
        }
        assert_eq!(On.next(Some(Fault::Corrupted), 0), Off);
        for fault in [Fault::AngleLimit, Fault::ServoSilent, Fault::HostSilent] {
            let latched = Some(fault);
            assert_eq!(On.next(latched, CONFIRM_US - 1), On, "{fault:?}");
            assert_eq!(On.next(latched, CONFIRM_US), Off, "{fault:?}");
            assert_eq!(Off.next(latched, 0), Off, "latched: {fault:?}");
        }
        assert_eq!(PinState::from(Off), PinState::Low);
    }

    /// Since when motors are not confirmed off counts, not since when there is a fault.
    #[test]
    fn motors_that_are_not_confirmed_off_cut_it_after_100_ms() {
        let mut supply = Supply::new(0);
        assert_eq!(supply.update(1_000, None, false), On);
        assert_eq!(supply.update(100_999, LIMIT, false), On);
        assert_eq!(supply.update(101_000, LIMIT, false), Off);
        assert_eq!(supply.update(102_000, LIMIT, true), Off, "latched");
        assert_eq!(supply.update(103_000, None, false), On);

        assert_eq!(supply.update(110_000, LIMIT, false), On);
        assert_eq!(supply.update(125_000, LIMIT, true), On);
        assert_eq!(supply.update(9_000_000, LIMIT, true), On);
        assert_eq!(supply.update(9_099_999, LIMIT, false), On);
        assert_eq!(supply.update(9_100_000, LIMIT, false), Off);
    }

    #[test]
    fn an_emergency_stop_after_another_fault_cuts_it_at_once() {
        let mut supply = Supply::new(0);
        assert_eq!(supply.update(0, STOP, true), Off);
        assert_eq!(supply.update(1_000, None, false), On);
        assert_eq!(supply.update(2_000, LIMIT, true), On);
        supply.stop();
        assert_eq!(supply.update(2_000, LIMIT, true), Off);
        assert_eq!(supply.update(3_000, None, false), On);
    }
}
