//! Persistent settings: loaded at boot, saved on a command of the host.

use armbridge_board::bridge::{LinkPort, can_run};
use armbridge_board::store::Store;
use armbridge_link::message::{Settings, SettingsFrom};
use embedded_storage::nor_flash::NorFlash;

/// Number of saves for which a boot makes room: more than a tuning session needs.
const SAVES: u32 = 16;

/// Prepares the store, and loads the settings to begin with. Call it after the
/// stop sequence and before the watchdog runs: it may erase both pages.
#[inline(never)]
pub fn open(store: &mut Store<impl NorFlash>) -> (Settings, SettingsFrom) {
    // Saved settings can still be loaded; saving fails and is reported.
    let prepared = store.prepare(SAVES);
    let (settings, from) = store.load(can_run);
    #[cfg(feature = "board")]
    {
        if let Err(error) = prepared {
            defmt::warn!("settings cannot be kept: {}", defmt::Debug2Format(&error));
        }
        defmt::info!("settings: {}", from);
    }
    #[cfg(not(feature = "board"))]
    let _ = prepared;
    (settings, from)
}

/// Saves the settings, if the host has commanded that and the tick has confirmed that
/// torque is off; returns whether it did. The tick continues meanwhile, but may miss bytes from
/// the bus while a word is programmed.
#[inline(never)]
pub fn keep(port: &mut LinkPort<'_>, store: &mut Store<impl NorFlash>) -> bool {
    let Some((sequence, settings)) = port.take_save() else {
        return false;
    };
    let result = store.save(settings);
    #[cfg(feature = "board")]
    if let Err(error) = result {
        defmt::warn!("settings not saved: {}", defmt::Debug2Format(&error));
    }
    port.saved(sequence, result.is_ok());
    true
}
