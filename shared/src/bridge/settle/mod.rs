//! Stock servos made ready for torque, and given back as they were.
//!
//! Bring-up only looks at stock servos. Everything else is asked for, by
//! [`Command::Prepare`](crate::link::message::Command::Prepare) and
//! [`Command::Release`](crate::link::message::Command::Release): whoever plugs the
//! bridge in to use its transparent port finds the servos as they were.
//!
//! A stock AX-12A has no torque command. In wheel mode (both angle limits 0) its
//! moving speed is the motor's duty, which is as good. Its return delay, 500 µs
//! ex works, would take the half of a tick for each servo. Both are EEPROM, so
//! they are written only where they differ, and what was found is remembered for
//! the release, until reset.
//!
//! | module    | what                                                       |
//! |-----------|------------------------------------------------------------|
//! | [`chore`] | which steps there are, and what each asks of a servo       |

mod chore;

pub(super) use chore::{Chore, Stock};

use embedded_hal::digital::OutputPin;
use embedded_hal_nb::serial::{Read, Write};

use super::mailbox::Notice;
use super::schedule::Stage;
use super::{Bridge, SERVO_IDS};
use crate::JOINTS;
use crate::link::message::Missing;
use crate::servo::Firmware;
use crate::servo::master::Asked;
use crate::servo::master::timing::latency_us;
use crate::servo::port::SetBaud;
use chore::{Purpose, Settings, Step};

/// How long a servo is left alone after a write to its EEPROM, in µs. The e-Manual
/// does not say how long it is busy; an `ATmega8`, which AX-12A have had, takes
/// 8.5 ms a byte, and four are the most that is written here.
const EEPROM_US: u64 = 40_000;

impl<S, D> Bridge<'_, S, D>
where
    S: Read<u8> + Write<u8> + SetBaud,
    D: OutputPin,
{
    /// Does this chore's request, or the next that has one.
    pub(in crate::bridge) fn do_chore(&mut self, mut chore: Chore) {
        loop {
            let stock = self.stock.get(chore.joint).copied().unwrap_or_default();
            let id = SERVO_IDS.get(chore.joint).map_or(0, |id| id.get());
            let errand = chore.errand(&stock);
            if let Some((packet, reply_bytes)) = errand.and_then(|errand| errand.packet(id)) {
                let asked = Asked {
                    id,
                    reply_bytes,
                    latency_us: latency_us(Firmware::Stock),
                };
                self.stage = Stage::Settle(chore);
                self.is_chore_asked = true;
                // Idle was just seen, and our own packets are short.
                let _ = self.master.ask(&packet, asked, self.core.now_us());
                return;
            }
            let Some(next) = chore.after() else {
                self.chores_done(chore);
                return;
            };
            chore = next;
        }
    }

    /// A chore's request has been answered, or not.
    pub(in crate::bridge) fn finish_chore(&mut self, chore: Chore) {
        let settings = self
            .master
            .reply()
            .and_then(|reply| Settings::of(&reply.data));
        let next = match (chore.step, settings) {
            (Step::Look | Step::LookAgain | Step::Check, Some(settings)) => {
                if let Some(stock) = self.stock.get_mut(chore.joint) {
                    stock.now = Some(settings);
                    if chore.step != Step::Check && !settings.are_ready() {
                        stock.before = Some(settings);
                    }
                }
                if chore.step == Step::Check && !settings.are_ready() {
                    let _ = self
                        .end
                        .notices
                        .enqueue(Notice::Unprepared(chore.joint as u8));
                    self.search_again();
                    return;
                }
                chore.after()
            }
            // Status return level 0: READ is not answered.
            (Step::Look, None) => Some(Chore {
                step: Step::MakeItAnswer,
                ..chore
            }),
            (Step::LookAgain | Step::Check, None) => {
                self.report_absent(chore.joint, Missing::Silence);
                return;
            }
            (
                Step::MakeItAnswer
                | Step::Mode
                | Step::Delay
                | Step::Standstill
                | Step::TorqueOn
                | Step::TorqueOff
                | Step::Level,
                _,
            ) => chore.after(),
        };
        if chore.step.is_kept() {
            self.core.set_next_start(self.core.now_us() + EEPROM_US);
        }
        match next {
            Some(next) => self.stage = Stage::Settle(next),
            None => self.chores_done(chore),
        }
    }

    fn chores_done(&mut self, chore: Chore) {
        match chore.purpose {
            Purpose::Look => self.begin_ticking(),
            Purpose::Prepare => {
                self.master.set_prepared(true);
                self.begin_ticking();
            }
            Purpose::Restore => {
                self.stock = [Stock::default(); JOINTS];
                self.stage = Stage::Released;
            }
        }
    }
}
