//! Instruction counts of the core's mathematics and of the link's frames, under QEMU.
//!
//! With `-icount shift=0` every instruction takes one virtual nanosecond, so a
//! clock counts instructions. Each function is called many times on inputs that
//! the compiler does not know, and the count of an empty loop is subtracted: the
//! remainder is the function, call and moves included.
//!
//! `cargo count-instructions` builds and runs it. The computing time of a whole tick
//! is in the records of `armbridge run --link emulate:?icount`.
#![no_std]
#![no_main]

use core::hint::black_box;

use armbridge_control::arm::{Parameters, Posture, State};
use armbridge_control::controller::{ComputedTorque, Lqr, Tuning, Weights};
use armbridge_control::design::placement::{self, Poles};
use armbridge_control::estimate::{Config, Estimator, Form, Luenberger, Model};
use armbridge_control::real::Real;
use armbridge_control::trajectory::{Bounds, Reference, Shape, Trajectory};
use armbridge_firmware::board::mps2_an386::{clock, semihosting};
use armbridge_link::frame::{Decoder, Encoder};
use armbridge_link::message::{
    Command, Drive, Guards, Mode, Record, Sample, TickInput, TickOutput, Timing, ToBoard, ToHost,
};
use armbridge_servo::JOINTS;
use cortex_m_semihosting::hprintln;
use nalgebra::Vector2;

const CALLS: u32 = 10_000;
const PERIOD_S: f32 = 0.001;

#[cortex_m_rt::entry]
fn main() -> ! {
    clock::start(false, 1);
    if measure().is_none() {
        // A panic would reset the machine, and restart.
        hprintln!("a controller or an estimator could not be built");
        semihosting::exit(semihosting::EXIT_PANIC)
    }
    semihosting::exit(0)
}

/// Instructions per call, rounded to a tenth. The counter runs at 25 MHz: 40
/// instructions a step, a thousandth of one over all calls.
fn count<T>(mut call: impl FnMut() -> T) -> u64 {
    let cycles = |work: &mut dyn FnMut()| {
        let before = clock::cycles();
        work();
        u64::from(clock::cycles().wrapping_sub(before))
    };
    let empty = cycles(&mut || {
        for _ in 0..CALLS {
            black_box(());
        }
    });
    let full = cycles(&mut || {
        for _ in 0..CALLS {
            black_box(call());
        }
    });
    let calls = u64::from(CALLS);
    (full.saturating_sub(empty) * 40 * 10 + calls / 2) / calls
}

fn show(name: &str, tenths: u64) {
    hprintln!("{:<52} {:>6}.{}", name, tenths / 10, tenths % 10);
}

fn measure() -> Option<()> {
    let arm = Parameters::<f32>::paper();
    let model = arm.linearise(Vector2::zeros()).zero_order_hold(PERIOD_S);
    let lqr = Lqr::design(&model, &Weights::paper()).ok()?;
    let state = State {
        q: Vector2::new(0.2_f32, -0.1),
        dq: Vector2::new(0.3, 0.4),
    };
    let upright = State::at_rest(Vector2::zeros());
    let measured = [Some(0.2_f32), Some(-0.1)];
    let torque = Vector2::new(0.1_f32, -0.2);

    hprintln!("instructions a call, Cortex-M4F, f32\n");
    show(
        "sine and cosine of one angle",
        count(|| black_box(0.7_f32).sine_cosine()),
    );

    let poles = Poles::Real(0.9_f32, 0.95);
    let [a1, a2] = model.joints();
    let gains = [
        placement::current_gain(&a1, poles).ok()?,
        placement::current_gain(&a2, poles).ok()?,
    ];
    let observer = Luenberger::new(Model::linear(&model), gains, Form::Current);
    let upright_q = Vector2::zeros();
    // A linear model does not use it.
    let posture = Posture::of(upright_q);
    let mut estimate = Estimator::Luenberger(observer).at_rest(upright_q);
    show(
        "LQR and linear Luenberger observer",
        count(|| {
            // In memory, as in a tick: a loop would keep them in registers.
            let (observer, lqr, estimate) = black_box((&observer, &lqr, &mut estimate));
            observer.correct(estimate, *black_box(&measured));
            let ahead = observer.advance(&arm, &posture, estimate, *black_box(&torque));
            lqr.feedback(&ahead, black_box(&upright))
        }),
    );

    let observer = Config::standing().build(&arm, PERIOD_S).ok()?;
    let mut estimate = observer.at_rest(upright_q);
    show(
        "Luenberger observer with the exact gravity",
        count(|| {
            observer.correct(&mut estimate, *black_box(&measured));
            observer.advance(&arm, &mut estimate, *black_box(&torque))
        }),
    );

    let filter = Config::kalman().build(&arm, PERIOD_S).ok()?;
    let mut estimate = filter.at_rest(upright_q);
    show(
        "Kalman filter, 6 states: model, predict, update",
        count(|| {
            filter.correct(&mut estimate, *black_box(&measured));
            filter.advance(&arm, &mut estimate, *black_box(&torque))
        }),
    );

    let tuning = Tuning {
        natural_rad_s: [20.0; JOINTS],
        damping: [1.0; JOINTS],
    };
    let law = ComputedTorque::new(&tuning, PERIOD_S).ok()?;
    let reference = Reference::at_rest(Vector2::new(0.3, 0.2));
    show(
        "computed torque",
        count(|| law.torque(&arm, black_box(&state), black_box(&reference))),
    );

    let bounds = Bounds::<f32> {
        angle_rad: 1.2,
        speed_rad_s: 4.0,
        acceleration_rad_s2: 20.0,
        jerk_rad_s3: 1e9,
    };
    let shape = Shape::MinimumJerk {
        to: Vector2::new(0.3, -0.3),
        duration_s: Some(1.0),
    };
    let start = Reference::at_rest(Vector2::zeros());
    let trajectory = Trajectory::plan(start, &shape, &bounds).ok()?;
    show(
        "minimum-jerk trajectory",
        count(|| trajectory.at(black_box(0.4))),
    );
    frames();
    Some(())
}

/// A record on its way to the host, and a command from it.
fn frames() {
    let message = ToHost::Record(record());
    let mut encoder = Encoder::default();
    show(
        "frame of a record",
        count(|| encoder.encode(black_box(&message)).1.len()),
    );
    let command = ToBoard::Command(Command::Regulate([0.15, -0.1]));
    let (mut encoder, mut decoder) = (Encoder::default(), Decoder::default());
    let frame = encoder.encode(&command).1;
    show(
        "command out of a frame",
        count(|| {
            let messages = frame.iter().filter_map(|byte| {
                let received = decoder.push::<ToBoard>(*black_box(byte))?;
                received.ok()
            });
            messages.count()
        }),
    );
}

/// A record of an arm that is held, as long as they get.
fn record() -> Record {
    Record {
        tick: 1_000_000,
        mode: Mode::Running(Drive::Regulate),
        timing: Timing {
            start_error_us: 0,
            bus_us: 547,
            compute_ns: 12_280,
            missed: 0,
        },
        dropped: 0,
        input: TickInput {
            start_us: 1_000_000_000,
            samples: [Sample::Counts(511), Sample::Counts(540)],
            alarms: [0; JOINTS],
            pwm_in_force: [1_021, 987],
            ..TickInput::AT_REST
        },
        output: TickOutput {
            guards: Guards::NONE,
            pwm: [1_022, 986],
            reference_rad: [0.15, -0.1],
            reference_speed_rad_s: [0.0; JOINTS],
            angle_rad: [0.1487, -0.0991],
            speed_rad_s: [0.0123, -0.0312],
            torque_nm: [0.0521, -0.0178],
            disturbance_nm: [0.0; JOINTS],
            ..TickOutput::NONE
        },
    }
}
