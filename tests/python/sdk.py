"""The vendor's SDK (package dynamixel-sdk), as it is, at a port with stock AX-12As.

    python sdk.py PORT [--ids 1 2] [--fresh] [--rate-counts] [--latency-ms MS]

Pings, reads every register, writes, writes to several servos at once, and
compares what it reads with what it wrote. Exit code 0 if all is as it should
be; otherwise 1, and the first thing that is not on stderr.

What the SDK (4.1.0) does with a port, by its source:

- It opens with pyserial: 8N1 raw, no flow control, not exclusive. pyserial
  raises DTR and RTS; that a pseudo-terminal has none (ENOTTY) it ignores.
- `setBaudRate` closes the port and opens it again, and so does `openPort`.
  Anything but its list of rates is refused without a word to the port.
- Before each packet it discards what it has received; it writes a packet whole
  and never waits for it to be sent.
- It reads without blocking, in a busy loop, and gives up the time of the
  answer's bytes + 2 x LATENCY_TIMER + 2 ms after it wrote: about 34 ms.
  LATENCY_TIMER (16 ms) is that of the usual USB adapter; its users are told to
  change the constant if theirs differs, which is what --latency-ms does.
- An answer that comes later is discarded with the next packet, or taken for
  the next answer if it comes later still. So after a failure this waits, and
  asks again: a busy computer is late sometimes.
- PING is followed by a READ of the model number.
"""

import argparse
import errno
import sys
import time

import dynamixel_sdk
from dynamixel_sdk import (
    COMM_RX_TIMEOUT,
    COMM_SUCCESS,
    DXL_HIBYTE,
    DXL_LOBYTE,
    GroupSyncWrite,
    PacketHandler,
    PortHandler,
)

BROADCAST = 0xFE
MODEL = 12
ATTEMPTS = 5
# After a failure, and longer than any answer takes to come.
PAUSE_S = 0.5
# A servo that writes to its EEPROM receives nothing.
EEPROM_S = 0.05
ERROR_RANGE = 1 << 3

# ROBOTIS e-Manual, "AX-12A": address, bytes, name, what it holds ex works, if
# that is the same in every servo.
REGISTERS = [
    (0, 2, "model_number", MODEL),
    (2, 1, "firmware_version", None),
    (3, 1, "id", None),
    (4, 1, "baud_rate", 1),
    (5, 1, "return_delay_time", 250),
    (6, 2, "cw_angle_limit", 0),
    (8, 2, "ccw_angle_limit", 1023),
    (11, 1, "temperature_limit", 70),
    (12, 1, "min_voltage_limit", 60),
    (13, 1, "max_voltage_limit", 140),
    (14, 2, "max_torque", 1023),
    (16, 1, "status_return_level", 2),
    (17, 1, "alarm_led", 36),
    (18, 1, "shutdown", 36),
    (24, 1, "torque_enable", 0),
    (25, 1, "led", 0),
    (26, 1, "cw_compliance_margin", 1),
    (27, 1, "ccw_compliance_margin", 1),
    (28, 1, "cw_compliance_slope", 32),
    (29, 1, "ccw_compliance_slope", 32),
    (30, 2, "goal_position", None),
    (32, 2, "moving_speed", None),
    (34, 2, "torque_limit", 1023),
    (36, 2, "present_position", None),
    (38, 2, "present_speed", None),
    (40, 2, "present_load", None),
    (42, 1, "present_voltage", None),
    (43, 1, "present_temperature", None),
    (44, 1, "registered", 0),
    (46, 1, "moving", 0),
    (47, 1, "lock", 0),
    (48, 2, "punch", 32),
]
PLACE = {name: (address, size) for address, size, name, _ in REGISTERS}


class Wrong(Exception):
    """Something is not as it should be."""


class Bus:
    """The SDK, with failures repeated and named."""

    def __init__(self, name, baud):
        self.port = PortHandler(name)
        self.handler = PacketHandler(1.0)
        self.exchanges = 0
        self.repeated = 0
        if not self.port.openPort():
            raise Wrong(f"cannot open {name}")
        self.set_baud(baud)

    def set_baud(self, baud):
        if not self.port.setBaudRate(baud):
            raise Wrong(f"the SDK does not set {baud} baud")
        if self.port.getBaudRate() != baud:
            raise Wrong(f"set {baud} baud, have {self.port.getBaudRate()}")

    def ask(self, what, call, *arguments):
        """Data, if it is a reading, and error byte of the answer."""
        for _ in range(ATTEMPTS):
            *data, result, error = call(self.port, *arguments)
            self.exchanges += 1
            if result == COMM_SUCCESS:
                return (*data, error)
            self.repeated += 1
            time.sleep(PAUSE_S)
        raise Wrong(f"{what}: {self.handler.getTxRxResult(result)}")

    def is_silent(self, servo):
        """Whether nothing answers a ping."""
        _, result, _ = self.handler.ping(self.port, servo)
        self.exchanges += 1
        time.sleep(PAUSE_S)
        return result == COMM_RX_TIMEOUT

    def ping(self, servo):
        model, error = self.ask(f"ping {servo}", self.handler.ping, servo)
        expect(f"model of servo {servo}", (model, error), (MODEL, 0))

    def read(self, servo, name):
        address, size = PLACE[name]
        handler = self.handler
        call = handler.read1ByteTxRx if size == 1 else handler.read2ByteTxRx
        value, error = self.ask(f"read {name} of {servo}", call, servo, address)
        expect(f"error byte with {name} of servo {servo}", error, 0)
        return value

    def write(self, servo, name, value):
        """Error byte of the answer."""
        address, size = PLACE[name]
        handler = self.handler
        call = handler.write1ByteTxRx if size == 1 else handler.write2ByteTxRx
        (error,) = self.ask(f"write {name} of {servo}", call, servo, address, value)
        if address < PLACE["torque_enable"][0]:
            time.sleep(EEPROM_S)
        return error

    def write_and_compare(self, servo, name, value):
        expect(f"error byte on {name} = {value}", self.write(servo, name, value), 0)
        expect(f"{name} of servo {servo}", self.read(servo, name), value)


def expect(what, found, wanted):
    if found != wanted:
        raise Wrong(f"{what}: {found}, should be {wanted}")


def modem_lines(bus):
    """Toggles what a USB2Dynamixel ignores."""
    for level in (False, True):
        for line in ("dtr", "rts"):
            try:
                setattr(bus.port.ser, line, level)
            except OSError as error:
                # A pseudo-terminal has no such lines.
                if error.errno not in (errno.ENOTTY, errno.EINVAL):
                    raise


def every_register(bus, servo, fresh):
    for _, size, name, ex_works in REGISTERS:
        value = bus.read(servo, name)
        if not 0 <= value < 256**size:
            raise Wrong(f"{name} of servo {servo} is {value}")
        if fresh and ex_works is not None:
            expect(f"{name} of servo {servo}", value, ex_works)
    expect("model number", bus.read(servo, "model_number"), MODEL)
    expect("id", bus.read(servo, "id"), servo)


def writes(bus, servo):
    # Joint mode: in wheel mode the speed is a duty.
    bus.write_and_compare(servo, "cw_angle_limit", 0)
    bus.write_and_compare(servo, "ccw_angle_limit", 1023)
    bus.write_and_compare(servo, "led", 1)
    bus.write_and_compare(servo, "cw_compliance_slope", 64)
    bus.write_and_compare(servo, "torque_limit", 600 + servo)
    bus.write_and_compare(servo, "punch", 40)
    bus.write_and_compare(servo, "punch", 32)
    # Refused by the servo, by its error byte.
    error = bus.write(servo, "moving_speed", 2048)
    expect("error byte on moving_speed = 2048", error, ERROR_RANGE)


def registered(bus, servo):
    """REG_WRITE, then ACTION."""
    address, size = PLACE["moving_speed"]
    before = bus.read(servo, "moving_speed")
    speed = 100 if before != 100 else 101
    data = [DXL_LOBYTE(speed), DXL_HIBYTE(speed)]
    call = bus.handler.regWriteTxRx
    (error,) = bus.ask("REG_WRITE", call, servo, address, size, data)
    expect("error byte on REG_WRITE", error, 0)
    expect("registered", bus.read(servo, "registered"), 1)
    expect("moving_speed before ACTION", bus.read(servo, "moving_speed"), before)
    expect("ACTION", bus.handler.action(bus.port, BROADCAST), COMM_SUCCESS)
    expect("moving_speed after ACTION", bus.read(servo, "moving_speed"), speed)
    expect("registered", bus.read(servo, "registered"), 0)


def sync_write(bus, servos):
    """Goal and speed of all servos in one packet, different for each."""
    address, _ = PLACE["goal_position"]
    group = GroupSyncWrite(bus.port, bus.handler, address, 4)
    wanted = {servo: (500 + 10 * servo, 200 + servo) for servo in servos}
    for servo, values in wanted.items():
        data = [part(value) for value in values for part in (DXL_LOBYTE, DXL_HIBYTE)]
        if not group.addParam(servo, data):
            raise Wrong(f"the SDK does not take {values} for servo {servo}")
    expect("SYNC_WRITE", group.txPacket(), COMM_SUCCESS)
    for servo, (goal, speed) in wanted.items():
        expect(f"goal of servo {servo}", bus.read(servo, "goal_position"), goal)
        expect(f"speed of servo {servo}", bus.read(servo, "moving_speed"), speed)


def to_all(bus, servos):
    """A WRITE that no servo answers."""
    for name in ("led", "torque_enable"):
        address, _ = PLACE[name]
        result = bus.handler.write1ByteTxOnly(bus.port, BROADCAST, address, 0)
        expect(f"{name} = 0 to all", result, COMM_SUCCESS)
        for servo in servos:
            expect(f"{name} of servo {servo}", bus.read(servo, name), 0)


def other_rate(bus, servos, baud, rate_counts):
    """Sets a rate that no servo has, and the right one again."""
    bus.set_baud(57600)
    if rate_counts and not bus.is_silent(servos[0]):
        raise Wrong("a servo answers at a rate that is not its own")
    bus.set_baud(baud)
    for servo in servos:
        bus.ping(servo)


def run(arguments):
    if arguments.latency_ms is not None:
        dynamixel_sdk.port_handler.LATENCY_TIMER = arguments.latency_ms
    servos = arguments.ids
    bus = Bus(arguments.port, arguments.baud)
    modem_lines(bus)
    for servo in servos:
        bus.ping(servo)
    absent = max(servos) + 1
    if not bus.is_silent(absent):
        raise Wrong(f"there is no servo {absent}, and it answers")
    for servo in servos:
        every_register(bus, servo, arguments.fresh)
    for servo in servos:
        writes(bus, servo)
        registered(bus, servo)
    sync_write(bus, servos)
    other_rate(bus, servos, arguments.baud, arguments.rate_counts)
    to_all(bus, servos)
    bus.port.closePort()
    return f"as it should be, {bus.exchanges} exchanges, {bus.repeated} of them again"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("port", help="serial device")
    parser.add_argument("--ids", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--baud", type=int, default=1_000_000)
    parser.add_argument("--fresh", action="store_true", help="registers are as ex works")
    parser.add_argument(
        "--rate-counts",
        action="store_true",
        help="the port's rate is the bus's, so that at another no servo answers",
    )
    parser.add_argument("--latency-ms", type=int, help="LATENCY_TIMER of the SDK")
    try:
        print(f"sdk: {run(parser.parse_args())}")
    # The port could not be opened, or is gone.
    except (Wrong, OSError) as wrong:
        sys.exit(f"sdk: {wrong}")


if __name__ == "__main__":
    main()
