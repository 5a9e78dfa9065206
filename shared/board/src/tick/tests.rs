//! Tests of a tick.

use super::*;
use armbridge_link::message::{Missing, Sample, Settings};
use armbridge_servo::JOINTS;

/// An estimate that begins at the first sample would take the way there for a speed.
#[test]
fn there_is_no_torque_before_a_sample_of_each_joint() {
    let config = LoopConfig::build(&Settings::default()).unwrap();
    let (mut control, mut input) = (ControlLoop::new(&config), TickInput::AT_REST);
    let request = DriveRequest::Regulate([0.3, 0.3]);
    control
        .request(&config, &request, Instant::default())
        .unwrap();
    input.permission = Permission::Drive;
    let mut command = |samples| {
        input.samples = samples;
        let output = step(&config, &mut control, &input, &mut Checkpoints::default());
        assert_eq!(output.events, None);
        output.pwm
    };
    let off = [Pwm::OFF.counts(); JOINTS];
    let (there, missing) = (Sample::Counts(560), Sample::Missing(Missing::Silence));
    for samples in [[missing; 2], [missing, there], [there, missing]] {
        assert_eq!(command(samples), off, "{samples:?}");
    }
    assert_ne!(command([there; 2]), off);
}
