//! The bench: servos on a wire that move an arm.

use armbridge_shared::arm::State;
use armbridge_shared::bridge::SERVO_IDS;

use crate::drivetrain::Joints;
use crate::faults::sensor::SensorFault;
use crate::half_duplex_bus::{ByteFault, Device, Disturbance, Heard, Wire, bit_ns};
use crate::morpheus_servo::Servo;
use crate::plant::{Plant, Push};
use crate::servo_kind::ServoKind;

/// The servos' default.
const DEFAULT_BAUD: u32 = 1_000_000;
/// Bits of a byte on the wire.
const BITS: u64 = 10;

/// Servos on a wire, moving an arm.
#[derive(Debug)]
pub struct Bench {
    wire: Wire,
    joints: Joints,
    baud: u32,
    line_free_ns: u64,
    framing_errors: u64,
}

impl Bench {
    /// Morpheus servos with the bridge's ids, powered up at time 0, that move
    /// `plant`.
    pub fn new(plant: Plant) -> Self {
        let servos = SERVO_IDS
            .iter()
            .map(|id| Servo::with_id(id.get()).into())
            .collect();
        Self::of(plant, servos)
    }

    /// These servos, powered up at time 0. The first two move the joints of
    /// `plant`, in this order; any others turn nothing but their shafts.
    pub fn with_servos(plant: Plant, servos: &[ServoKind]) -> Self {
        Self::of(plant, servos.iter().map(|kind| kind.build()).collect())
    }

    fn of(plant: Plant, servos: Vec<Device>) -> Self {
        Self {
            joints: Joints::new(plant, servos.len()),
            wire: Wire::new(servos),
            baud: DEFAULT_BAUD,
            line_free_ns: 0,
            framing_errors: 0,
        }
    }

    /// The master's rate, at which it sends from the next byte on, and listens
    /// at once. It begins with 1 Mbaud.
    pub fn set_baud(&mut self, baud: u32) {
        self.baud = baud.max(1);
        self.wire.listen_at(self.baud);
    }

    /// The master's rate.
    pub fn baud(&self) -> u32 {
        self.baud
    }

    /// Puts bytes on the wire, back to back, from `now_us` or from when the
    /// bytes before have left.
    pub fn send(&mut self, now_us: u64, bytes: &[u8]) {
        let byte_ns = BITS * bit_ns(self.baud);
        for byte in bytes {
            let start_ns = self.line_free_ns.max(now_us * 1_000);
            self.wire.send(start_ns, *byte, self.baud);
            self.line_free_ns = start_ns + byte_ns;
        }
    }

    /// When the bytes put on the wire will have left it, in µs, rounded up.
    pub fn line_free_us(&self) -> u64 {
        self.line_free_ns.div_ceil(1_000)
    }

    /// Goes on to `until_us`, or until `wanted` bytes have come from the servos,
    /// whichever is first. Returns the time in µs, rounded up, and adds what has
    /// come to `heard`.
    pub fn advance(&mut self, until_us: u64, wanted: Option<usize>, heard: &mut Vec<u8>) -> u64 {
        self.advance_into(until_us, wanted, |byte| heard.push(byte.byte))
    }

    /// The same, with when each byte came and whether its stop bit was wrong.
    pub fn advance_timed(
        &mut self,
        until_us: u64,
        wanted: Option<usize>,
        heard: &mut Vec<Heard>,
    ) -> u64 {
        self.advance_into(until_us, wanted, |byte| heard.push(byte))
    }

    fn advance_into(
        &mut self,
        until_us: u64,
        wanted: Option<usize>,
        mut take: impl FnMut(Heard),
    ) -> u64 {
        let enough = wanted.unwrap_or(usize::MAX);
        self.wire
            .advance_until(until_us.saturating_mul(1_000), enough, &mut self.joints);
        let mut count = 0;
        while let Some(byte) = self.wire.take_heard() {
            self.framing_errors += u64::from(byte.framing_error);
            take(byte);
            count += 1;
            if count >= enough {
                return byte.end_ns.div_ceil(1_000);
            }
        }
        until_us
    }

    /// Bytes that the master has taken so far whose stop bit was wrong: another
    /// rate, or a collision.
    pub fn framing_errors(&self) -> u64 {
        self.framing_errors
    }

    /// The servos, in the order given.
    pub fn servos(&self) -> &[Device] {
        self.wire.servos()
    }

    /// One of them, to change what no master can: its supply, its heat.
    pub fn servo_mut(&mut self, servo: usize) -> &mut Device {
        self.wire.servo_mut(servo)
    }

    /// Switches servo `servo` off and on again.
    pub fn power_cycle(&mut self, servo: usize) {
        self.wire.power_cycle(servo, &mut self.joints);
    }

    /// The PWM that servo `servo`'s motor gets, 0..=2000, 1000 = off.
    pub fn applied_pwm(&self, servo: usize) -> u16 {
        self.wire.servos()[servo].pwm()
    }

    /// Takes servo `servo` off the wire; it stays powered and obeys on.
    pub fn disconnect(&mut self, servo: usize) {
        self.wire.connect(servo, false);
    }

    /// Lets something spoil the servos' replies from now on.
    pub fn disturb(&mut self, disturbance: Disturbance) {
        self.wire.disturb(disturbance);
    }

    /// Does harm to bytes between the master and the bus.
    pub fn harm(&mut self, fault: ByteFault) {
        self.wire.harm(fault);
    }

    /// No byte comes to harm any more.
    pub fn unharm(&mut self) {
        self.wire.unharm();
    }

    /// Something pulls the line down from now on, for so long.
    pub fn hold_low(&mut self, duration_us: u64) {
        self.wire.hold_low(duration_us * 1_000);
    }

    /// Something keeps the line from going down, for so long from now on.
    pub fn hold_high(&mut self, duration_us: u64) {
        self.wire.hold_high(duration_us * 1_000);
    }

    /// Whether the master hears what it sends; at first it does not.
    pub fn echo(&mut self, on: bool) {
        self.wire.echo(on);
    }

    /// Whether servo `servo` says nothing, though it hears and obeys.
    pub fn mute(&mut self, servo: usize, is_mute: bool) {
        self.wire.mute(servo, is_mute);
    }

    /// Whether servo `servo` hears nothing, and so goes on as it was told last.
    pub fn deafen(&mut self, servo: usize, is_deaf: bool) {
        self.wire.deafen(servo, is_deaf);
    }

    /// Something goes wrong with the sensors of the arm's servo `servo`.
    pub fn fail_sensor(&mut self, servo: usize, fault: SensorFault) {
        self.joints.sensors[servo].fail(fault);
    }

    /// The sensors of the arm's servo `servo` are well again.
    pub fn mend_sensors(&mut self, servo: usize) {
        self.joints.sensors[servo].mend();
    }

    /// The arm's servos change places, ids and all they do; or back.
    pub fn swap_servos(&mut self) {
        self.joints.swap(self.wire.now_ns());
    }

    /// From when to when the motor of the arm's servo `servo` was on last, in ns; the
    /// end is `None` while it is.
    pub fn last_on_ns(&self, servo: usize) -> (u64, Option<u64>) {
        self.joints.last_on_ns(servo)
    }

    /// Time in ns that the motor of the arm's servo `servo` was on so far.
    pub fn total_on_ns(&self, servo: usize) -> u64 {
        self.joints.total_on_ns(servo, self.wire.now_ns())
    }

    /// The farthest from off that the PWM of the arm's servo `servo` was since this
    /// was asked last.
    pub fn take_most_counts(&mut self, servo: usize) -> u16 {
        self.joints.take_most_counts(servo)
    }

    /// Somebody pushes the arm. A push that should have begun begins now.
    pub fn push(&mut self, push: Push) {
        self.joints.arm.push(push);
    }

    /// Somebody brings the arm back to where it began, and holds it until a motor drives
    /// it.
    pub fn lift(&mut self) {
        self.joints.arm.lift();
    }

    /// True angles and speeds at `at_us`, which is not before the time that
    /// [`Bench::advance`] has come to.
    pub fn state_at(&mut self, at_us: u64) -> State<f64> {
        self.joints.arm.advance(at_us.saturating_mul(1_000));
        self.joints.arm.state()
    }

    /// The true arm.
    pub fn plant(&self) -> &Plant {
        &self.joints.arm
    }
}
