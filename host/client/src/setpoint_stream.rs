//! Stream of setpoints: the commands that make a board follow setpoints as a program computes them.
//!
//! The setpoint of time `t` is due on the board one lead later. Its time follows from `t` alone,
//! not from when it is sent, so that jitter of the program does not become acceleration; the
//! board's clock is followed by at most one part in [`FOLLOW`].
//!
//! The reference could not get the angle and speed of the first setpoint at once. So the stream is
//! faded in over [`FADE_S`] by the polynomial of least jerk, from a reference that keeps its speed.

use armbridge_link::message::{Command, Record};

/// Time in s over which a stream is faded in: a setpoint that moves at 0.8 rad/s from where the
/// reference was takes 18.5 of the 20 rad/s^2 that the board permits.
const FADE_S: f64 = 0.2;
/// Change of the offset between the clocks, as a part of the time that passes.
const FOLLOW: f64 = 1_000.0;

/// See the [module](self).
#[derive(Clone, Copy, Debug)]
pub struct SetpointStream {
    /// Reference in rad at time 0, and its speed in rad/s.
    from_rad: [f32; 2],
    from_rad_s: [f32; 2],
    /// Time on the board's clock in µs at which the setpoint of time 0 is due.
    start_us: f64,
    latest_s: f64,
}

impl SetpointStream {
    /// A stream from the reference of this tick, whose setpoint of time 0 is due at `start_us` on
    /// the board's clock.
    pub fn new(record: &Record, start_us: u64) -> Self {
        let output = &record.output;
        let ahead_s = start_us.saturating_sub(record.input.acts_us()) as f32 * 1e-6;
        let (angle, speed) = (output.reference_rad, output.reference_speed_rad_s);
        Self {
            from_rad: [0, 1].map(|joint| angle[joint] + ahead_s * speed[joint]),
            from_rad_s: speed,
            start_us: start_us as f64,
            latest_s: 0.0,
        }
    }

    /// The command for the setpoint of time `t_s`: angles in rad, and speeds in rad/s unless the
    /// board is to compute them. By the present estimate of the board's clock it is due at `due_us`.
    pub fn command(
        &mut self,
        t_s: f64,
        due_us: u64,
        angle_rad: [f32; 2],
        speed_rad_s: Option<[f32; 2]>,
    ) -> Command {
        let change_us = (t_s - self.latest_s).max(0.0) * 1e6 / FOLLOW;
        self.latest_s = t_s;
        let error_us = due_us as f64 - (self.start_us + t_s * 1e6);
        self.start_us += error_us.clamp(-change_us, change_us);
        let at = (t_s / FADE_S).clamp(0.0, 1.0) as f32;
        let share = at * at * at * (10.0 + at * (6.0 * at - 15.0));
        let slope_1_s = 30.0 * at * at * (1.0 - at) * (1.0 - at) / FADE_S as f32;
        let from = |joint: usize| self.from_rad[joint] + t_s as f32 * self.from_rad_s[joint];
        let away = |joint: usize| angle_rad[joint] - from(joint);
        let angle = |joint: usize| from(joint) + share * away(joint);
        Command::Stream {
            at_us: (self.start_us + t_s * 1e6).max(0.0).round() as u64,
            angle_rad: [angle(0), angle(1)],
            speed_rad_s: speed_rad_s.map(|speed| {
                let speed = |joint: usize| {
                    let from_rad_s = (1.0 - share) * self.from_rad_s[joint];
                    from_rad_s + share * speed[joint] + slope_1_s * away(joint)
                };
                [speed(0), speed(1)]
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(speed_rad_s: f32) -> Record {
        let mut record = Record::NONE;
        record.output.reference_rad = [0.1, 0.0];
        record.output.reference_speed_rad_s = [speed_rad_s, 0.0];
        record
    }

    fn point(stream: &mut SetpointStream, t_s: f64, due_us: u64, q: f32) -> (u64, f32, f32) {
        let command = stream.command(t_s, due_us, [q, 0.0], Some([0.2, 0.0]));
        let Command::Stream {
            at_us,
            angle_rad,
            speed_rad_s: Some(speed_rad_s),
        } = command
        else {
            panic!("{command:?}");
        };
        (at_us, angle_rad[0], speed_rad_s[0])
    }

    /// A program that is late by up to 4 ms has no effect on the times, and drift is followed.
    #[test]
    fn times_are_those_of_the_setpoints() {
        let mut stream = SetpointStream::new(&record(0.0), 1_000_000);
        let mut before = None;
        for k in 0..2_000_u32 {
            let (t_s, jitter_us) = (f64::from(k) * 0.005, u64::from(k * 7 % 5) * 1_000);
            let drift_us = u64::from(k) / 10;
            let due_us = 1_000_000 + u64::from(k) * 5_000 + drift_us + jitter_us;
            let (at_us, ..) = point(&mut stream, t_s, due_us, 0.1);
            if let Some(before) = before.replace(at_us) {
                assert!((at_us - before).abs_diff(5_000) <= 6, "{k}");
            }
        }
        let exact_us = 1_000_000 + 1_999 * 5_000 + 199;
        assert!(before.unwrap().abs_diff(exact_us) < 4_000);
    }

    /// It begins where the reference was, with its speed, and is the setpoint after 0.2 s.
    #[test]
    fn a_stream_is_faded_in() {
        let mut moving = SetpointStream::new(&record(-0.5), 40_000);
        assert_eq!(point(&mut moving, 0.0, 40_000, 0.3), (40_000, 0.08, -0.5));
        assert!((point(&mut moving, 0.2, 40_000, 0.3).1 - 0.3).abs() < 1e-6);
        let mut stream = SetpointStream::new(&record(0.0), 0);
        assert_eq!(point(&mut stream, 0.0, 0, 0.3), (0, 0.1, 0.0));
        let (mut speed, mut most) = (0.0_f32, 0.0_f32);
        for k in 1..=40_u32 {
            let t_s = f64::from(k) * 0.005;
            let (.., next) = point(&mut stream, t_s, 0, 0.1 + 0.2 * t_s as f32);
            most = most.max((next - speed).abs() / 0.005);
            speed = next;
        }
        assert!((point(&mut stream, 0.2, 0, 0.14).1 - 0.14).abs() < 1e-6);
        assert!(
            (speed - 0.2).abs() < 1e-6 && (4.0..4.7).contains(&most),
            "{speed} {most}"
        );
    }
}
