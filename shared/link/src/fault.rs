//! Faults: causes for which the supervisor switches torque off.
//!
//! Each fault is declared once, in the table at the end of this module. Its order is the encoding
//! on the link. A row has, after the variant:
//!
//! | column            | use                                                               |
//! |-------------------|-------------------------------------------------------------------|
//! | name              | in logs, tables, scenarios and the log's schema (`FAULT_` before)  |
//! | of the parameters | true if corrupted parameters may be the cause, which is then named |
//! | cause             | for the user, after "joint 1: " where a joint is concerned         |
//! | remedy            | for the user                                                      |
//!
//! Texts that a program does not use are not in it.

use postcard::experimental::max_size::MaxSize;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

macro_rules! faults {
    (
        stops { $($(#[$stop_doc:meta])* $stop:ident
            $stop_name:literal $stop_corrupt:literal $stop_cause:literal $stop_remedy:literal;)* }
        faults { $($(#[$doc:meta])* $fault:ident
            $name:literal $corrupt:literal $cause:literal $remedy:literal;)* }
    ) => {
        /// Source of an emergency stop.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, Schema, MaxSize)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub enum StopSource {
            $($(#[$stop_doc])* $stop,)*
        }

        impl StopSource {
            /// All sources.
            pub const ALL: [Self; [$($stop_name),*].len()] = [$(Self::$stop),*];
        }

        /// Fault for which the supervisor switched torque off.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, Schema, MaxSize)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub enum Fault {
            /// An emergency stop was requested.
            EmergencyStop(StopSource),
            $($(#[$doc])* $fault,)*
        }

        impl Fault {
            /// All faults.
            pub const ALL: [Self; [$($stop_name,)* $($name),*].len()] =
                [$(Self::EmergencyStop(StopSource::$stop),)* $(Self::$fault),*];

            /// Name in logs and tables.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::EmergencyStop(StopSource::$stop) => $stop_name,)*
                    $(Self::$fault => $name,)*
                }
            }

            /// Whether corrupted parameters may be the cause.
            pub const fn may_be_corruption(self) -> bool {
                match self {
                    $(Self::EmergencyStop(StopSource::$stop) => $stop_corrupt,)*
                    $(Self::$fault => $corrupt,)*
                }
            }

            /// Cause, for the user: a line without a full stop.
            pub const fn cause(self) -> &'static str {
                match self {
                    $(Self::EmergencyStop(StopSource::$stop) => $stop_cause,)*
                    $(Self::$fault => $cause,)*
                }
            }

            /// Remedy, for the user: a line without a full stop.
            pub const fn remedy(self) -> &'static str {
                match self {
                    $(Self::EmergencyStop(StopSource::$stop) => $stop_remedy,)*
                    $(Self::$fault => $remedy,)*
                }
            }
        }
    };
}

faults! {
    stops {
        /// [`ToBoard::Stop`](crate::message::ToBoard::Stop).
        Host "emergency_stop_host" false
            "emergency stop, asked for by the host"
            "clear it when the arm is free to move";
        /// The switch at the board's stop input, or a wire of it that broke.
        Pin "emergency_stop_pin" false
            "emergency stop by the switch at the board, or its wire broke"
            "release the switch or mend the wire, then clear";
        /// More garbage than frames came over the link.
        Flood "emergency_stop_flood" false
            "emergency stop: more garbage than frames on the link"
            "end whatever else writes to the link, then clear";
        /// The board's crystal does not oscillate: it runs on an oscillator that is too
        /// inaccurate for the servo bus, USB and the period.
        Crystal "emergency_stop_crystal" false
            "the board's crystal does not oscillate"
            "use another board";
    }
    faults {
        /// No valid frame from the host for too long.
        HostSilent "host_silent" false
            "the host was silent for too long"
            "check cable and computer, then clear and arm again";
        /// A joint left its angle limit.
        AngleLimit "angle_limit" true
            "beyond its angle limit, or braked before it for too long"
            "bring the arm back by hand, then clear";
        /// A joint is faster than its limit.
        SpeedLimit "speed_limit" true
            "faster than its limit"
            "look for what pushes it, or lower the gains, then clear";
        /// More torque than the limit was wanted for too long.
        TorqueLimit "torque_limit" true
            "more torque than the limit was wanted for too long"
            "look for what blocks it, or lower the gains, then clear";
        /// The wanted torque changed faster than its limit for too long.
        TorqueRate "torque_rate" true
            "the wanted torque changed too fast for too long"
            "the loop rattles: lower the gains or slow the estimator";
        /// More PWM than the limit was wanted for too long.
        PwmLimit "pwm_limit" true
            "more PWM than the limit was wanted for too long"
            "look for what blocks the arm, or lower the gains, then clear";
        /// A servo is too hot, or its temperature has changed too much.
        Temperature "temperature" false
            "its servo is too hot, or has changed its temperature too much"
            "let it cool down, then clear";
        /// A joint is in the gap of its potentiometer.
        DeadZone "dead_zone" true
            "it is where its potentiometer has no track"
            "turn it back by hand, then clear; is the servo mounted right?";
        /// A servo no longer answers.
        ServoSilent "servo_silent" false
            "its servo no longer answers"
            "check its plug and its supply, then clear";
        /// A servo answers, but has been reset.
        ServoReset "servo_reset" false
            "its servo has been off and on again"
            "check the supply under load, then clear";
        /// Too many samples in a row came damaged.
        SamplesLost "samples_lost" false
            "too many samples in a row came damaged"
            "check the bus wiring and its ground, then clear";
        /// Too many samples were missing within a second.
        SamplesRare "samples_rare" false
            "too many samples were missing within a second"
            "check the bus wiring and its ground, then clear";
        /// A tick took longer than its period.
        Overrun "overrun" false
            "ticks began later than a whole period"
            "use a longer period or a faster bus, then clear";
        /// The board's clock went back.
        Clock "clock" false
            "the board's clock went back"
            "reset the board; if it happens again, the board is broken";
        /// Samples differ repeatedly from the prediction of the estimator.
        Diverged "diverged" true
            "it is not where the estimate is, again and again"
            "check calibration and encoder, then clear";
        /// A joint does not move though it is driven.
        Stuck "stuck" true
            "it does not move though driven"
            "look for what blocks it, and at its gears, then clear";
        /// An encoder repeats one count for longer than its noise allows: it has stopped.
        EncoderFrozen "encoder_frozen" true
            "its encoder repeats one count: it has stopped"
            "check the servo's position reading, then clear";
        /// A torque that the model does not explain acts on a joint for long: its encoder drifts or
        /// has an offset, its motor is weaker or stronger than calibrated, or something pushes it.
        ExternalTorque "external_torque" true
            "a torque that the model does not explain acts for long"
            "check its encoder, calibration and load, then clear";
        /// A motor turns its joint the wrong way.
        MotorDirection "motor_direction" true
            "its motor turns it the wrong way"
            "check the direction and the mounting of its servo, then clear";
        /// Each servo moves the joint of the other.
        JointsSwapped "joints_swapped" true
            "each servo seems to move the joint of the other"
            "check the servos' ids and the masses of the links, then clear";
        /// The control law produced NaN or an infinite value.
        NotFinite "not_finite" true
            "the control law made something that is not a number"
            "go back to gains and estimator that worked, then clear";
        /// A stock servo reported that it is too hot or overloaded: it switches
        /// its torque off by itself.
        ServoAlarm "servo_alarm" false
            "its servo reports heat or overload, and lets go"
            "let it cool down, take load off the arm, then clear";
        /// The servos run another firmware than before.
        FirmwareChanged "firmware_changed" false
            "the servos run another firmware than before"
            "if that is meant, clear; otherwise check what is on the bus";
        /// A parameter in memory has changed.
        Corrupted "corrupted" false
            "a parameter in memory is not what it was set to"
            "send the settings again, then clear; check the supply";
    }
}
