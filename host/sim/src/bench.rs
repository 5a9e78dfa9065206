//! Bench: servos on a wire that move an arm.

use armbridge_board::bridge::SERVO_IDS;
use armbridge_client::simulation::TrueState;
use armbridge_control::arm::State;
use armbridge_servo::JOINTS;

use crate::drivetrain::Joints;
use crate::faults::sensor::SensorFault;
use crate::half_duplex_bus::{ByteFault, Device, Disturbance, ReceivedByte, Wire, bit_ns};
use crate::plant::{Impact, Lead, MotorFault, Plant, Push};
use crate::servo_kind::ServoKind;

/// Default baud rate of the servos.
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
    /// Servos with the encoders of `plant`, the bridge's ids and 1 Mbaud, powered up at time 0,
    /// that move it.
    pub fn new(plant: Plant) -> Self {
        let firmware = plant.firmware();
        let servos = SERVO_IDS.map(|id| ServoKind::at_one_megabaud(firmware, id));
        Self::with_servos(plant, &servos)
    }

    /// These servos, powered up at time 0. The first two move the joints of
    /// `plant`, in this order; any others turn a free shaft. An arm of one joint has no second.
    pub fn with_servos(plant: Plant, servos: &[ServoKind]) -> Self {
        let absent = plant.joints()..JOINTS;
        let servos = servos.iter().enumerate();
        let servos = servos.filter(|(servo, _)| !absent.contains(servo));
        let servos = servos
            .map(|(_, kind)| kind.build(plant.x_servo()))
            .collect();
        Self::with_devices(plant, servos)
    }

    /// The same with servos as they are on a wire: also those of the X series.
    pub fn with_devices(plant: Plant, servos: Vec<Device>) -> Self {
        Self {
            joints: Joints::new(plant, servos.len()),
            wire: Wire::new(servos),
            baud: DEFAULT_BAUD,
            line_free_ns: 0,
            framing_errors: 0,
        }
    }

    /// Sets the master's rate, for sending from the next byte on, and for receiving
    /// at once. It begins with 1 Mbaud.
    pub fn set_baud(&mut self, baud: u32) {
        self.baud = baud.max(1);
        self.wire.listen_at(self.baud);
    }

    /// The master's rate.
    pub fn baud(&self) -> u32 {
        self.baud
    }

    /// Puts bytes on the wire, back to back, from `now_us` or from the end of
    /// the bytes before.
    pub fn send(&mut self, now_us: u64, bytes: &[u8]) {
        let byte_ns = BITS * bit_ns(self.baud);
        for byte in bytes {
            let start_ns = self.line_free_ns.max(now_us * 1_000);
            self.wire.send(start_ns, *byte, self.baud);
            self.line_free_ns = start_ns + byte_ns;
        }
    }

    /// Puts a byte on the wire at `start_ns`, or at the end of the byte before, at this rate:
    /// for a board whose port is simulated with its own timing.
    pub fn send_byte(&mut self, start_ns: u64, byte: u8, baud: u32) {
        self.baud = baud.max(1);
        let start_ns = self.line_free_ns.max(start_ns);
        self.wire.send(start_ns, byte, self.baud);
        self.line_free_ns = start_ns + BITS * bit_ns(self.baud);
    }

    /// Advances to `until_ns`, and appends the bytes from the servos to `received`.
    pub fn advance_ns(&mut self, until_ns: u64, received: &mut Vec<ReceivedByte>) {
        self.wire.advance(until_ns, &mut self.joints);
        while let Some(byte) = self.wire.take_received() {
            self.framing_errors += u64::from(byte.framing_error);
            received.push(byte);
        }
    }

    /// Time in ns of the next event of wire or servos; `u64::MAX` if there is none.
    pub fn next_event_ns(&self) -> u64 {
        self.wire.next_event_ns()
    }

    /// End of the bytes that were put on the wire, in µs, rounded up.
    pub(crate) fn line_free_us(&self) -> u64 {
        self.line_free_ns.div_ceil(1_000)
    }

    /// Advances to `until_us`, or until `wanted` bytes have come from the servos,
    /// whichever is first. Returns the time in µs, rounded up, and appends the bytes
    /// to `received`.
    pub fn advance(&mut self, until_us: u64, wanted: Option<usize>, received: &mut Vec<u8>) -> u64 {
        self.advance_into(until_us, wanted, |byte| received.push(byte.byte))
    }

    /// The same, with the time of each byte, and whether its stop bit was wrong.
    pub fn advance_timed(
        &mut self,
        until_us: u64,
        wanted: Option<usize>,
        received: &mut Vec<ReceivedByte>,
    ) -> u64 {
        self.advance_into(until_us, wanted, |byte| received.push(byte))
    }

    fn advance_into(
        &mut self,
        until_us: u64,
        wanted: Option<usize>,
        mut take: impl FnMut(ReceivedByte),
    ) -> u64 {
        let count_max = wanted.unwrap_or(usize::MAX);
        self.wire
            .advance_until(until_us.saturating_mul(1_000), count_max, &mut self.joints);
        let mut count = 0;
        while let Some(byte) = self.wire.take_received() {
            self.framing_errors += u64::from(byte.framing_error);
            take(byte);
            count += 1;
            if count >= count_max {
                return byte.end_ns.div_ceil(1_000);
            }
        }
        until_us
    }

    /// Bytes that the master has received so far with a wrong stop bit: another
    /// rate, or a collision.
    pub fn framing_errors(&self) -> u64 {
        self.framing_errors
    }

    /// The servos, in the order given.
    pub fn servos(&self) -> &[Device] {
        self.wire.servos()
    }

    /// Mutable access to a servo, for properties that a master cannot change: supply, heat.
    pub fn servo_mut(&mut self, servo: usize) -> &mut Device {
        self.wire.servo_mut(servo)
    }

    /// Power-cycles servo `servo`.
    pub fn power_cycle(&mut self, servo: usize) {
        self.wire.power_cycle(servo, &mut self.joints);
    }

    /// PWM of servo `servo`'s motor, 0..=2000, 1000 = off.
    pub fn applied_pwm(&self, servo: usize) -> u16 {
        self.wire.servos()[servo].pwm()
    }

    /// Disconnects servo `servo` from the wire; it stays powered and keeps its command.
    pub fn disconnect(&mut self, servo: usize) {
        self.wire.connect(servo, false);
    }

    /// Connects servo `servo` to the wire again.
    pub fn reconnect(&mut self, servo: usize) {
        self.wire.connect(servo, true);
    }

    /// Replaces servo `servo` by another one, powered up now.
    pub(crate) fn replace(&mut self, servo: usize, kind: ServoKind) {
        *self.wire.servo_mut(servo) = kind.build(self.joints.arm.x_servo());
        self.power_cycle(servo);
    }

    /// Puts bytes of a second master on the wire, back to back, from `now_us`.
    pub fn send_foreign(&mut self, now_us: u64, bytes: &[u8], baud: u32) {
        let byte_ns = BITS * bit_ns(baud);
        for (start_ns, byte) in (now_us * 1_000..).step_by(byte_ns as usize).zip(bytes) {
            self.wire.send_foreign(start_ns, *byte, baud);
        }
    }

    /// Corrupts the servos' replies from now on.
    pub fn disturb(&mut self, disturbance: Disturbance) {
        self.wire.disturb(disturbance);
    }

    /// Damages bytes between the master and the bus.
    pub fn inject(&mut self, fault: ByteFault) {
        self.wire.inject(fault);
    }

    /// Removes all damage of bytes.
    pub(crate) fn clear_byte_faults(&mut self) {
        self.wire.clear_byte_faults();
    }

    /// Holds the line low from now on, for this time.
    pub(crate) fn hold_low(&mut self, duration_us: u64) {
        self.wire.hold_low(duration_us * 1_000);
    }

    /// Holds the line high from now on, for this time.
    pub fn hold_high(&mut self, duration_us: u64) {
        self.wire.hold_high(duration_us * 1_000);
    }

    /// Sets whether the master receives its own bytes; initially it does not.
    pub fn echo(&mut self, on: bool) {
        self.wire.echo(on);
    }

    /// Sets whether servo `servo` is mute: it receives and executes, but does not reply.
    pub(crate) fn mute(&mut self, servo: usize, is_mute: bool) {
        self.wire.mute(servo, is_mute);
    }

    /// Sets whether servo `servo` is deaf: it receives nothing, and keeps its last command.
    pub fn deafen(&mut self, servo: usize, is_deaf: bool) {
        self.wire.deafen(servo, is_deaf);
    }

    /// Injects a fault of the sensors of the arm's servo `servo`.
    pub fn fail_sensor(&mut self, servo: usize, fault: SensorFault) {
        self.joints.sensors[servo].fail(fault);
    }

    /// Removes the faults of the sensors of the arm's servo `servo`.
    pub(crate) fn repair_sensors(&mut self, servo: usize) {
        self.joints.sensors[servo].mend();
    }

    /// Swaps the arm's servos, with ids and state; the second call swaps them back.
    pub(crate) fn swap_servos(&mut self) {
        self.joints.swap(self.wire.now_ns());
    }

    /// Start and end of the last time for which the motor of the arm's servo `servo` was on,
    /// in ns; the end is `None` while it is.
    pub fn last_on_ns(&self, servo: usize) -> (u64, Option<u64>) {
        self.joints.last_on_ns(servo)
    }

    /// Time in ns that the motor of the arm's servo `servo` was on so far.
    pub fn total_on_ns(&self, servo: usize) -> u64 {
        self.joints.total_on_ns(servo, self.wire.now_ns())
    }

    /// Largest distance from off of the PWM of the arm's servo `servo` since the last
    /// call.
    pub(crate) fn take_most_counts(&mut self, servo: usize) -> u16 {
        self.joints.take_most_counts(servo)
    }

    /// Sets the fault of the motor of the arm's servo `servo`.
    pub(crate) fn fail_motor(&mut self, servo: usize, fault: MotorFault) {
        self.joints.arm.fail_motor(servo, fault);
    }

    /// The arm's fastest impact on a stop since the last call.
    pub(crate) fn take_impact(&mut self) -> Option<Impact> {
        self.joints.arm.take_impact()
    }

    /// Adds a hand that leads the arm, see [`Plant::lead`].
    pub fn lead(&mut self, lead: &Lead) {
        self.joints.arm.lead(lead);
    }

    /// Pushes the arm. A push whose start has passed begins now.
    pub fn push(&mut self, push: Push) {
        self.joints.arm.push(push);
    }

    /// Moves the arm by hand, see [`Plant::move_by_hand`].
    pub fn move_by_hand(&mut self, to_rad: [f64; JOINTS], duration_us: u64) {
        self.joints
            .arm
            .move_by_hand(to_rad, duration_us.saturating_mul(1_000));
    }

    /// Moves the arm by hand to its initial angles, see [`Plant::lift`].
    pub fn lift(&mut self) {
        self.joints.arm.lift();
    }

    /// Lets go of the arm.
    pub fn release(&mut self) {
        self.joints.arm.release();
    }

    /// True angles and speeds at `at_us`, which is not before the time of the last
    /// [`Bench::advance`].
    pub fn state_at(&mut self, at_us: u64) -> State<f64> {
        self.joints.arm.advance(at_us.saturating_mul(1_000));
        self.joints.arm.state()
    }

    /// State and torques of the arm at `at_us`, under the same condition.
    pub(crate) fn true_state(&mut self, at_us: u64) -> TrueState {
        self.joints.arm.advance(at_us.saturating_mul(1_000));
        self.joints.arm.true_state()
    }

    /// The next push that has begun, once.
    pub(crate) fn take_begun_push(&mut self) -> Option<Push> {
        self.joints.arm.take_begun_push()
    }

    /// The true arm.
    pub fn plant(&self) -> &Plant {
        &self.joints.arm
    }
}
