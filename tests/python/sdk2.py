"""The vendor's SDK (package dynamixel-sdk), as it is, at a port with two servos of the X series.

    python sdk2.py PORT

Finds them by a broadcast ping, reads registers of one, two and four bytes, reads and writes several
servos at once in each of the ways that Protocol 2.0 has, drives a motor by PWM, has its watchdog
stop it, and restarts a servo. Exit code 0 if all is as it should be; otherwise 1, and the first
thing that is not on stderr.

A busy computer is late sometimes, and the SDK takes an answer that comes late for the next one: a
call that fails is repeated after a pause.
"""

import argparse
import sys
import time

from dynamixel_sdk import (
    COMM_SUCCESS,
    GroupBulkRead,
    GroupBulkWrite,
    GroupSyncRead,
    GroupSyncWrite,
    PacketHandler,
    PortHandler,
)

IDS = [1, 2]
MODEL = 1060  # XL430-W250
ATTEMPTS = 5
PAUSE_S = 0.5
# Longer than a servo takes to start.
BOOT_S = 0.3

# ROBOTIS e-Manual, "XL430-W250": address and bytes.
MODEL_NUMBER = (0, 2)
RETURN_DELAY = (9, 1)
OPERATING_MODE = (11, 1)
HOMING_OFFSET = (20, 4)
TORQUE_ENABLE = (64, 1)
LED = (65, 1)
BUS_WATCHDOG = (98, 1)
GOAL_PWM = (100, 2)
PRESENT_PWM = (124, 2)
PRESENT_POSITION = (132, 4)
PRESENT_VOLTAGE = (144, 2)
PWM_MODE = 16
POSITION_MODE = 3
DATA_RANGE_ERROR = 4
ACCESS_ERROR = 7


class Unlike(Exception):
    """Something is not as it should be."""


def expect(what, seen, expected):
    if seen != expected:
        raise Unlike(f"{what}: {seen}, expected {expected}")


class Bus:
    """The servos at a port."""

    def __init__(self, name):
        self.port = PortHandler(name)
        if not self.port.openPort() or not self.port.setBaudRate(1_000_000):
            raise Unlike(f"{name} does not open at 1 Mbaud")
        self.packets = PacketHandler(2.0)

    def again(self, what, call):
        """The result of the call's first success."""
        for _ in range(ATTEMPTS):
            result, value = call()
            if result == COMM_SUCCESS:
                return value
            time.sleep(PAUSE_S)
            self.port.clearPort()
        raise Unlike(f"{what}: {self.packets.getTxRxResult(result)}")

    def read(self, servo, register, error=0):
        address, count = register
        functions = {
            1: self.packets.read1ByteTxRx,
            2: self.packets.read2ByteTxRx,
            4: self.packets.read4ByteTxRx,
        }

        def call():
            value, result, seen = functions[count](self.port, servo, address)
            return result, (value, seen)

        value, seen = self.again(f"read {address} of {servo}", call)
        expect(f"error of reading {address} of {servo}", seen, error)
        return value

    def write(self, servo, register, value, error=0):
        address, count = register
        functions = {
            1: self.packets.write1ByteTxRx,
            2: self.packets.write2ByteTxRx,
            4: self.packets.write4ByteTxRx,
        }

        def call():
            result, seen = functions[count](self.port, servo, address, value)
            return result, seen

        seen = self.again(f"write {address} of {servo}", call)
        expect(f"error of writing {value} to {address} of {servo}", seen, error)


def pings(bus):
    found = bus.again("broadcast ping", lambda: tuple(reversed(bus.packets.broadcastPing(bus.port))))
    expect("servos found", sorted(found), IDS)
    for servo in IDS:
        expect(f"model of {servo} in the broadcast ping", found[servo][0], MODEL)

        def ping(servo=servo):
            model, result, error = bus.packets.ping(bus.port, servo)
            return result, (model, error)

        expect(f"ping of {servo}", bus.again("ping", ping), (MODEL, 0))
        expect("model number", bus.read(servo, MODEL_NUMBER), MODEL)
        expect("supply is plausible", 60 < bus.read(servo, PRESENT_VOLTAGE) < 140, True)


def writes(bus):
    for servo in IDS:
        bus.write(servo, TORQUE_ENABLE, 0)
        bus.write(servo, LED, 1)
        expect("LED", bus.read(servo, LED), 1)
        bus.write(servo, HOMING_OFFSET, 1000)
        expect("homing offset", bus.read(servo, HOMING_OFFSET), 1000)
        bus.write(servo, HOMING_OFFSET, 0)
        bus.write(servo, OPERATING_MODE, 7, DATA_RANGE_ERROR)
        bus.write(servo, PRESENT_POSITION, 0, ACCESS_ERROR)


def groups(bus):
    """Several servos by one instruction."""
    address, count = LED
    writes = GroupSyncWrite(bus.port, bus.packets, address, count)
    for servo in IDS:
        writes.addParam(servo, [0])
    bus.again("sync write", lambda: (writes.txPacket(), None))
    for servo in IDS:
        expect("LED by sync write", bus.read(servo, LED), 0)

    bulk = GroupBulkWrite(bus.port, bus.packets)
    bulk.addParam(1, *LED, [1])
    bulk.addParam(2, *RETURN_DELAY, [100])
    bus.again("bulk write", lambda: (bulk.txPacket(), None))
    time.sleep(0.05)
    expect("LED by bulk write", bus.read(1, LED), 1)
    expect("return delay by bulk write", bus.read(2, RETURN_DELAY), 100)

    positions = {servo: bus.read(servo, PRESENT_POSITION) for servo in IDS}
    reads = GroupSyncRead(bus.port, bus.packets, *PRESENT_POSITION)
    both = GroupBulkRead(bus.port, bus.packets)
    for servo in IDS:
        reads.addParam(servo)
        both.addParam(servo, *PRESENT_POSITION)
    ways = {"sync read": (reads, reads.txRxPacket), "bulk read": (both, both.txRxPacket)}
    if hasattr(reads, "fastSyncRead"):
        ways["fast sync read"] = (reads, reads.fastSyncRead)
    for name, (group, call) in ways.items():
        bus.again(name, lambda call=call: (call(), None))
        for servo in IDS:
            seen = group.getData(servo, *PRESENT_POSITION)
            # The arm hangs still, but for the noise of its encoders.
            if abs(seen - positions[servo]) > 8:
                raise Unlike(f"{name} of {servo}: {seen}, not {positions[servo]}")


def drives(bus):
    """A motor by PWM, and its end by the servo's own watchdog."""
    servo = 2
    bus.write(servo, OPERATING_MODE, PWM_MODE)
    bus.write(servo, GOAL_PWM, 0)
    bus.write(servo, TORQUE_ENABLE, 1)
    bus.write(servo, OPERATING_MODE, POSITION_MODE, ACCESS_ERROR)
    bus.write(servo, GOAL_PWM, 100)
    time.sleep(0.02)
    expect("present PWM", bus.read(servo, PRESENT_PWM), 100)
    # 100 ms.
    bus.write(servo, BUS_WATCHDOG, 5)
    bus.write(servo, GOAL_PWM, 100)
    time.sleep(0.5)
    expect("present PWM after a pause", bus.read(servo, PRESENT_PWM), 0)
    expect("watchdog that has run out", bus.read(servo, BUS_WATCHDOG), 255)
    bus.write(servo, GOAL_PWM, 100, DATA_RANGE_ERROR)
    bus.write(servo, BUS_WATCHDOG, 0)
    bus.write(servo, TORQUE_ENABLE, 0)


def restarts(bus):
    servo = 1

    def reboot():
        result, error = bus.packets.reboot(bus.port, servo)
        return result, error

    expect("error of the reboot", bus.again("reboot", reboot), 0)
    time.sleep(BOOT_S)
    expect("LED after the reboot", bus.read(servo, LED), 0)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("port")
    bus = Bus(parser.parse_args().port)
    try:
        for part in [pings, writes, groups, drives, restarts]:
            part(bus)
            print(f"{part.__name__}: as they should be")
    finally:
        bus.port.closePort()


if __name__ == "__main__":
    try:
        main()
    except Unlike as unlike:
        sys.exit(str(unlike))
