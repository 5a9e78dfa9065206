"""pypot's DxlIO, as it is, at a port with stock AX-12As.

    python pypot_io.py PORT [--ids 1 2] [--timeout-s S]

Scans, reads, writes, and moves the servos in joint mode. Exit code 0 if all is
as it should be; otherwise 1, and the first thing that is not on stderr.

What pypot (5.0.2) does with a port, by its source:

- It opens with pyserial, as the SDK does: 8N1 raw, DTR and RTS raised (a
  pseudo-terminal's ENOTTY is ignored), not exclusive; that nobody else of the
  same process uses the port is all it looks at.
- It reads with a time limit, 50 ms by default, first four bytes, then as many
  as the length says. It compares the checksum, but not the id: an answer that
  is late, as a busy computer's are sometimes, is taken for the next one. So
  this asks for more time, and after a failure waits and asks again.
- An answer's error byte is looked at only if an error handler was given.
- Before each packet it discards what it has received *and what has not been
  sent yet* (TCOFLUSH). Every setter is a SYNC_WRITE, after which nothing is
  waited for: a packet sent right after it can wipe it out of the terminal's
  buffer. So after each this waits.
- Getters that convert units ask the model number first, once.
"""

import argparse
import sys
import time

from pypot.dynamixel import DxlIO
from pypot.dynamixel.io.abstract_io import DxlCommunicationError

# For a SYNC_WRITE to be taken out of the buffer, and for the EEPROM.
SENT_S = 0.25
ATTEMPTS = 5
# After a failure, and longer than any answer takes to come.
PAUSE_S = 0.5
# Of 300 degrees in 1023 counts: what a goal is rounded to.
COUNT_DEG = 300 / 1023
MOVE_DEG = 20
# Gravity pulls a servo off its goal, whose rule has no integral.
NEAR_DEG = 6
SPEED_DEG_S = 60
# What the move takes, and time for a busy computer.
PATIENCE_S = 20


class Wrong(Exception):
    """Something is not as it should be."""


class Patient:
    """DxlIO, with a pause after each setting, and failures repeated."""

    def __init__(self, io):
        self.io = io
        self.repeated = 0

    def __getattr__(self, name):
        method = getattr(self.io, name)

        def call(*arguments):
            for attempt in range(ATTEMPTS):
                try:
                    result = method(*arguments)
                    if result is None:
                        time.sleep(SENT_S)
                    return result
                except DxlCommunicationError:
                    if attempt + 1 == ATTEMPTS:
                        raise
                    self.repeated += 1
                    time.sleep(PAUSE_S)

        return call


def expect(what, found, wanted):
    if found != wanted:
        raise Wrong(f"{what}: {found}, should be {wanted}")


def near(what, found, wanted, within):
    if len(found) != len(wanted):
        raise Wrong(f"{what}: {found}, should be about {wanted}")
    for one, other in zip(found, wanted):
        if abs(one - other) > within:
            raise Wrong(f"{what}: {found}, should be {wanted} within {within}")


def look(io, ids):
    """Finds the servos, and nothing else."""
    # A ping whose answer is late is not repeated.
    for _ in range(ATTEMPTS):
        found = io.scan(range(max(ids) + 3))
        if found == ids:
            break
        time.sleep(PAUSE_S)
    expect("ids", found, ids)
    expect("models", io.get_model(ids), ("AX-12",) * len(ids))
    expect("return levels", io.get_status_return_level(ids), ("always",) * len(ids))
    for servo, table in zip(ids, io.get_control_table(ids)):
        expect("id in the table", table["id"], servo)
        expect("model in the table", table["model"], "AX-12")
    for voltage in io.get_present_voltage(ids):
        if not 6 <= voltage <= 14:
            raise Wrong(f"present voltage: {voltage} V")


def write(io, ids):
    """What was set is read again."""
    io.set_joint_mode(ids)
    expect("modes", io.get_control_mode(ids), ("joint",) * len(ids))
    limits = io.get_angle_limit(ids)
    expect("angle limits", limits, ((-150.0, 150.0),) * len(ids))
    io.switch_led_on(ids)
    expect("LEDs", io.is_led_on(ids), (True,) * len(ids))
    io.switch_led_off(ids)
    expect("LEDs", io.is_led_on(ids), (False,) * len(ids))
    io.set_torque_limit(dict.fromkeys(ids, 100.0))
    near("torque limits", io.get_torque_limit(ids), [100.0] * len(ids), 0.1)
    io.set_moving_speed(dict.fromkeys(ids, SPEED_DEG_S))
    near("speeds", io.get_moving_speed(ids), [SPEED_DEG_S] * len(ids), 1)


def move(io, ids):
    """Moves all servos there and back, every other one the other way."""
    begin = io.get_present_position(ids)
    # Held where they are, not dropped.
    io.set_goal_position(dict(zip(ids, begin)))
    io.enable_torque(ids)
    expect("torque", io.is_torque_enabled(ids), (True,) * len(ids))
    away = [at + MOVE_DEG * (-1) ** number for number, at in enumerate(begin)]
    for goals in (away, begin):
        io.set_goal_position(dict(zip(ids, goals)))
        near("goals", io.get_goal_position(ids), goals, COUNT_DEG)
        reach(io, ids, goals)
    io.disable_torque(ids)
    expect("torque", io.is_torque_enabled(ids), (False,) * len(ids))


def reach(io, ids, goals):
    """Waits until all are there and at rest."""
    until = time.monotonic() + PATIENCE_S
    while True:
        at = io.get_present_position(ids)
        is_there = all(abs(a - b) <= NEAR_DEG for a, b in zip(at, goals))
        if is_there and not any(io.is_moving(ids)):
            return
        if time.monotonic() > until:
            raise Wrong(f"at {at}, should be about {goals} by now")


def run(arguments):
    baud, timeout = arguments.baud, arguments.timeout_s
    with DxlIO(arguments.port, baudrate=baud, timeout=timeout) as io:
        io = Patient(io)
        look(io, arguments.ids)
        write(io, arguments.ids)
        move(io, arguments.ids)
        return f"as it should be, {io.repeated} times asked again"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("port", help="serial device")
    parser.add_argument("--ids", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--baud", type=int, default=1_000_000)
    parser.add_argument("--timeout-s", type=float, default=0.5, help="for an answer")
    try:
        print(f"pypot: {run(parser.parse_args())}")
    # OSError: the port could not be opened, or is gone.
    except (Wrong, DxlCommunicationError, OSError) as wrong:
        sys.exit(f"pypot: {wrong}")


if __name__ == "__main__":
    main()
