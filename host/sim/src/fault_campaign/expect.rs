//! What each fault may rightly be called: one table, with the reasons.
//!
//! A name is right if somebody who looks at the arm would agree with it. Where a
//! fault has no effect, or one that the loop is made to ride through, no fault is
//! right too; [`verdict`] says when there has to be one.

use Fault::{
    AngleLimit, Clock, Corrupted, DeadZone, Diverged, EmergencyStop, HostSilent, Overrun, PwmLimit,
    SamplesLost, SamplesRare, ServoAlarm, ServoReset, ServoSilent, SpeedLimit, Stuck, Temperature,
    TorqueLimit, TorqueRate,
};
use armbridge_shared::link::message::{Fault, StopSource};
use armbridge_shared::servo::Firmware;

use super::case::{Case, Injection, Scenario};
use super::kind::{Harm, Kind};
use crate::half_duplex_bus::Way;

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Right {
    /// Which kinds it is about.
    is_about: fn(Kind) -> bool,
    /// What they may be called, if they are a fault.
    pub names: &'static [Fault],
    /// Why.
    pub because: &'static str,
}

/// Names for each kind of fault, in one row each. A row holds for both firmwares unless
/// [`STOCK`] has another.
pub const TABLE: [Right; 19] = [
    Right {
        is_about: |kind| matches!(kind, Kind::Bytes(Way::ToServos, _)),
        names: &[SamplesLost, SamplesRare, ServoSilent, Diverged],
        because: "what servos do not understand they do not answer; where they miss a PWM but not \
                  the question, the arm goes another way than the model",
    },
    Right {
        is_about: |kind| matches!(kind, Kind::Bytes(Way::ToMaster, _)),
        names: &[SamplesLost, SamplesRare, ServoSilent],
        because: "answers come damaged, or nothing is left of them",
    },
    Right {
        is_about: |kind| matches!(kind, Kind::EchoOn | Kind::EchoOff),
        names: &[SamplesLost, SamplesRare, ServoSilent],
        because: "the master either tells its own bytes from answers or loses samples",
    },
    Right {
        is_about: |kind| matches!(kind, Kind::LineLow | Kind::LineHigh),
        names: &[SamplesLost, ServoSilent],
        because: "nobody is heard; a wire that is held and servos without power look alike",
    },
    Right {
        is_about: |kind| kind == Kind::ServoReset,
        names: &[ServoReset],
        because: "it answers a ping, and has forgotten its place in the line-up",
    },
    Right {
        is_about: |kind| matches!(kind, Kind::ServoMute | Kind::ServoDeaf),
        names: &[ServoSilent],
        because: "it says nothing; whether it hears nobody can tell from its silence",
    },
    Right {
        is_about: |kind| kind == Kind::ServosSwapped,
        names: &[Diverged, SpeedLimit, AngleLimit],
        because: "both angles leap, and the loop drives the wrong joints; while angles and torques \
                  are alike nothing is to be seen",
    },
    Right {
        is_about: |kind| kind == Kind::Frozen,
        names: &[Stuck, Diverged],
        because: "told by its missing noise where the limits say that noise shows, or by an arm \
                  that does not do what it is driven to; at rest a frozen angle is a true one",
    },
    Right {
        is_about: |kind| kind == Kind::DeadZone,
        names: &[DeadZone],
        because: "counts near the ends of the track",
    },
    Right {
        is_about: |kind| kind == Kind::Hot,
        names: &[Temperature],
        because: "it drifts beyond its limit",
    },
    Right {
        is_about: |kind| matches!(kind, Kind::HostVanish | Kind::HostSchema | Kind::HostReplay),
        names: &[HostSilent],
        because: "nothing new that can be understood is silence; a pause is ridden through, and \
                  so is what comes beside the host's own words. A replay with the hello in it \
                  is a host to the board: nothing in the frames tells the two apart",
    },
    Right {
        is_about: |kind| kind == Kind::HostFlood,
        names: &[EmergencyStop(StopSource::Flood)],
        because: "garbage outweighs the frames",
    },
    Right {
        is_about: |kind| matches!(kind, Kind::HostGarbage | Kind::HostRange | Kind::Goodbye),
        names: &[],
        because: "enough frames come through; numbers out of range are refused; a goodbye disarms",
    },
    Right {
        is_about: |kind| kind == Kind::ClockAhead,
        names: &[Overrun],
        because: "ticks are missing; a short gap is ridden through",
    },
    Right {
        is_about: |kind| kind == Kind::ClockBack,
        names: &[Clock],
        because: "no time between two events is what it seems",
    },
    Right {
        is_about: |kind| kind == Kind::Push,
        names: &[
            SpeedLimit,
            AngleLimit,
            Diverged,
            TorqueLimit,
            TorqueRate,
            PwmLimit,
        ],
        because: "a push is answered with torque as far as limits allow; beyond that it moves the \
                  arm, or overcomes the friction that held it",
    },
    Right {
        is_about: |kind| kind == Kind::Corrupt,
        names: &[Corrupted],
        because: "the parameters in force are not those that were set",
    },
    Right {
        is_about: |kind| kind == Kind::StopHost,
        names: &[EmergencyStop(StopSource::Host)],
        because: "somebody asked for it",
    },
    Right {
        is_about: |kind| kind == Kind::StopPin,
        names: &[EmergencyStop(StopSource::Pin)],
        because: "somebody pressed it",
    },
];

/// Rows that differ with stock servos.
pub const STOCK: [Right; 2] = [
    Right {
        is_about: |kind| kind == Kind::ServoReset,
        names: &[ServoReset],
        because: "it answers as before, but its torque is not enabled any more",
    },
    Right {
        is_about: |kind| kind == Kind::Hot,
        names: &[Temperature, ServoAlarm],
        because: "at the servo's own limit, which is the board's too, it lets go and says so in \
                  every answer",
    },
];

/// The row of a kind with these servos.
pub fn right(kind: Kind, servos: Firmware) -> &'static Right {
    let stock: &[Right] = match servos {
        Firmware::Morpheus => &[],
        Firmware::Stock => &STOCK,
    };
    let [first, ..] = &TABLE;
    let mut rows = stock.iter().chain(&TABLE);
    let row = rows.find(|row| (row.is_about)(kind));
    // Every kind has a row, as a test shows.
    row.unwrap_or(first)
}

/// Whether there has to be a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// There must be one.
    Must,
    /// There may be one.
    May,
    /// There must be none.
    No,
}

/// An outage so short is ridden through: half of what the limits' default allows
/// samples to be missing.
const RIDDEN_US: u64 = 10_000;
/// One so long cannot be: three times that.
const TOLD_US: u64 = 60_000;
/// Silence of the host that is a fault, and how much of it may have passed before
/// the host vanished.
const SILENCE_US: u64 = 500_000;
const HEARTBEAT_US: u64 = 25_000;
/// Share of bytes that leaves no packet whole.
const ALL: f64 = 0.94;
/// Of a replay: nothing else is heard.
const REPLAY_ALONE: f64 = 0.5;

/// Whether there has to be a fault in this case. A board that is not armed needs
/// to notice nothing, but may.
pub fn verdict(injection: &Injection, case: &Case) -> Verdict {
    use Verdict::{May, Must, No};
    let Injection {
        kind,
        lasts_us,
        amount,
        ..
    } = *injection;
    let is_armed = case.scenario != Scenario::Idle;
    let if_armed = if is_armed { Must } else { May };
    let lasting = |ridden_us, told_us| match lasts_us {
        _ if lasts_us < ridden_us => No,
        _ if lasts_us > told_us => if_armed,
        _ => May,
    };
    match kind {
        Kind::Bytes(_, harm) if harm == Harm::Late || amount < ALL => May,
        Kind::Bytes(..) | Kind::LineLow | Kind::LineHigh | Kind::ServoMute | Kind::ServoDeaf => {
            lasting(RIDDEN_US, TOLD_US)
        }
        Kind::HostVanish | Kind::HostSchema | Kind::HostReplay | Kind::Push if !is_armed => No,
        Kind::HostReplay if amount < REPLAY_ALONE => No,
        Kind::HostVanish | Kind::HostSchema => {
            lasting(SILENCE_US - HEARTBEAT_US, SILENCE_US + HEARTBEAT_US)
        }
        Kind::Frozen if is_armed && case.is_tight => Must,
        Kind::Frozen if !case.scenario.is_driven() => No,
        Kind::HostReplay
        | Kind::EchoOn
        | Kind::EchoOff
        | Kind::ServosSwapped
        | Kind::Frozen
        | Kind::ClockAhead
        | Kind::Push => May,
        Kind::HostGarbage | Kind::HostRange | Kind::Goodbye => No,
        Kind::ServoReset
        | Kind::DeadZone
        | Kind::Hot
        | Kind::HostFlood
        | Kind::ClockBack
        | Kind::Corrupt => if_armed,
        Kind::StopHost | Kind::StopPin => Must,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_one_row() {
        for kind in Kind::ALL {
            let rows = TABLE.iter().filter(|row| (row.is_about)(kind));
            assert_eq!(rows.count(), 1, "{kind}");
        }
    }
}
