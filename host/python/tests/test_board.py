"""Boards on `sim:`, in step with the wall clock."""

import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import armbridge as ab
import numpy as np
import pytest


@pytest.fixture
def arm() -> Iterator[ab.Board]:
    with ab.connect("sim:") as arm:
        yield arm


def mode(arm: ab.Board) -> str | None:
    return arm.status().mode


def wait_for_idle(arm: ab.Board) -> None:
    until = time.monotonic() + 2.0
    while mode(arm) != "idle":
        assert time.monotonic() < until, arm.status()
        time.sleep(0.01)


def test_the_script_of_the_manual(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with ab.connect("sim:", log=path) as arm:
        arm.set({"limits.torque_nm": [1.0, 1.0]})
        with arm.armed():
            arm.regulate([0.1, -0.1])
            arm.move_to([0.0, 0.0], duration=1.0).wait(timeout=5)
            with arm.stream(rate=200) as s:
                for t in s.ticks(2.0):
                    s.send(q=[0.1 * np.sin(2 * t), 0.0])
            block = arm.telemetry.take(1000)
            assert block["angle_rad"].shape == (1000, 2)
        assert arm.telemetry.lost == 0
        assert mode(arm) == "idle"
        # Some of 400 may be late on a busy machine, and do no harm.
        assert s.late < 40
    log = ab.Log(path)
    assert log.replay().equal
    streamed = np.flatnonzero(log["board_mode"] == "track")[-1500:]
    error = (log["angle_rad"] - log["reference_rad"])[streamed]
    assert np.sqrt(np.mean(error**2)) < 0.05
    reference = log["reference_rad"][streamed, 0]
    assert 0.095 < reference.max() < 0.105
    # The log of a simulated arm has its true states, all but of the first ticks.
    truth = log["true_angle_rad"]
    assert np.abs(truth - log["angle_rad"])[streamed].max() < 0.02


def test_torques_from_python_hold_the_arm(arm: ab.Board) -> None:
    model = ab.Arm()
    gains = np.array([6.0, 2.0]), np.array([0.6, 0.15])
    q = np.zeros(2)
    with arm.armed():
        arm.regulate(q)
        time.sleep(1.0)
        with arm.torque(rate=200) as torque:
            for _ in torque.ticks(1.0):
                status = arm.status()
                assert status.angle_rad is not None and status.speed_rad_s is not None
                q, dq = np.array(status.angle_rad), np.array(status.speed_rad_s)
                torque.send(model.gravity(q) - gains[0] * q - gains[1] * dq)
            assert mode(arm) == "torque"
            assert np.abs(q).max() < 0.1
        # Held where it was.
        assert mode(arm) == "regulate"


def test_an_arm_is_parked_by_the_end_of_its_block(arm: ab.Board) -> None:
    arm.set({"park.kind": "pose", "park.angle_rad": [1.2, -0.2]})
    with arm.armed():
        arm.regulate([0.3, -0.3])
        time.sleep(0.5)
    angle = arm.status().angle_rad
    assert angle is not None and angle[0] > 1.5, "it lies on the table"


def test_a_disarm_does_not_park(arm: ab.Board) -> None:
    arm.set({"park.kind": "pose"})
    with arm.armed():
        arm.regulate([0.0, 0.0])
        begun = time.monotonic()
        arm.disarm()
        assert mode(arm) == "idle" and time.monotonic() - begun < 1.0


def test_a_stream_goes_on_after_a_pause(arm: ab.Board) -> None:
    with arm.armed():
        arm.regulate([0.0, 0.0])
        with arm.stream(rate=100) as stream:
            for _ in range(2):
                for _ in stream.ticks(0.5):
                    stream.send([0.05, 0.0])
                time.sleep(0.3)
            assert stream.late < 10
        assert arm.telemetry.drain()["reference_rad"][-1] == pytest.approx([0.05, 0.0])


def test_a_stream_follows_on_another(arm: ab.Board) -> None:
    with arm.armed():
        arm.move_to([0.0, 0.0], duration=1.0).wait()
        for _ in range(2):
            with arm.stream(rate=100) as stream:
                for t in stream.ticks(2 * np.pi / 3):
                    stream.send([0.1 * np.sin(3 * t), 0.0], [0.3 * np.cos(3 * t), 0.0])
            assert stream.late < 7


def test_a_failed_connection_leaves_no_log(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with pytest.raises(ab.LinkError, match="refused"):
        ab.connect("tcp://127.0.0.1:1", log=path)
    assert not path.exists()


def test_an_exception_disarms() -> None:
    with pytest.raises(ZeroDivisionError), ab.connect() as arm, arm.armed():
        arm.regulate([0.0, 0.0])
        _ = 1 / 0
    with pytest.raises(ab.ClosedError, match="sim: is closed"):
        arm.status()
    with pytest.raises(ab.ClosedError):
        arm.telemetry.take(1)


def test_a_stop_ends_a_motion_and_can_be_cleared(arm: ab.Board) -> None:
    with arm.armed():
        motion = arm.move_to([0.2, 0.0], duration=5.0)
        arm.stop()
        with pytest.raises(ab.FaultError, match="torque is off"):
            motion.wait()
        with pytest.raises(ab.RefusedError, match="fault is latched"):
            arm.regulate([0.0, 0.0])
    status = arm.status()
    assert status.mode == "fault" and status.fault == "emergency_stop_host"
    arm.clear()
    assert mode(arm) == "idle"


def test_another_command_ends_a_motion(arm: ab.Board) -> None:
    with arm.armed():
        arm.regulate([0.0, 0.0])
        motion = arm.move_to([0.2, 0.0], duration=5.0)
        arm.regulate([0.1, 0.0])
        with pytest.raises(ab.DroppedError):
            motion.wait()
        assert not motion.done
        with pytest.raises(TimeoutError, match=r"the motion did not end in 0.2 s"):
            arm.move_to([0.2, 0.0], duration=5.0).wait(timeout=0.2)


@pytest.mark.parametrize(
    ("q", "error", "text"),
    [
        ([0.1], ValueError, "expected two angles in rad, got 1"),
        ([0.1, 0.2, 0.3], ValueError, "got 3"),
        (np.zeros((2, 2)), TypeError, "expected two angles in rad"),
        ([0.1, float("nan")], ValueError, "finite"),
        ([np.inf, 0.0], ValueError, "finite"),
        ([1e300, 0.0], ValueError, "finite"),
        ([1j, 0.0], TypeError, "expected two angles in rad"),
        ("ab", TypeError, "expected two angles in rad"),
        (0.1, TypeError, "got float"),
        (None, TypeError, "got NoneType"),
        ([5.0, 0.0], ab.RefusedError, "refuses to regulate"),
    ],
)
def test_angles_are_checked(
    armed: ab.Board, q: Any, error: type[Exception], text: str
) -> None:
    with pytest.raises(error, match=text):
        armed.regulate(q)


@pytest.fixture(scope="module")
def armed() -> Iterator[ab.Board]:
    with ab.connect() as arm, arm.armed():
        arm.regulate(np.array([0.0, 0.0], dtype=np.float32))
        yield arm


@pytest.mark.parametrize(
    ("parameters", "error", "text"),
    [
        ({"limits.torque": [1, 1]}, ValueError, "is it `limits.torque_nm`"),
        ({"limits.torque_nm": 1.0}, ValueError, "limits.torque_nm"),
        ({"limits.torque_nm": [99.0, 1.0]}, ValueError, "limits.torque_nm"),
        ({"limits.torque_nm": [float("nan"), 1.0]}, ValueError, "limits.torque_nm"),
        ({"limits.torque_nm": object()}, TypeError, "cannot be of type object"),
        ({3: 1.0}, TypeError, "names of parameters are strings"),
    ],
)
def test_parameters_are_checked(
    arm: ab.Board, parameters: Any, error: type[Exception], text: str
) -> None:
    before = arm.settings
    with pytest.raises(error, match=text):
        arm.set(parameters)
    assert arm.settings == before


def test_parameters_are_read_back(arm: ab.Board) -> None:
    arm.set({"limits.torque_nm": np.array([1.0, 0.5]), "limits.silence_ms": np.int64(400)})
    assert arm.get("limits.torque_nm") == [1.0, 0.5]
    assert arm.settings["limits.silence_ms"] == 400
    with pytest.raises(ValueError, match="no parameter `nothing`"):
        arm.get("nothing")


def test_rates_and_times_are_checked(arm: ab.Board) -> None:
    for rate in (0, -1, float("nan"), 1000):
        with pytest.raises(ValueError, match="expected a rate"):
            arm.stream(rate=rate)
    with pytest.raises(ValueError, match="expected a time in s"):
        arm.torque(rate=100).ticks(-1.0)
    with pytest.raises(ValueError, match="at most 60000"):
        arm.telemetry.take(60_001)
    with pytest.raises(TimeoutError, match="too few ticks came in 0.1 s"):
        arm.telemetry.take(1000, timeout=0.1)
    assert len(arm.telemetry.take(1000, timeout=5.0)) == 1000


def test_links_that_do_not_open_say_why() -> None:
    with pytest.raises(ValueError, match="nonsense"):
        ab.connect("nonsense:")
    with pytest.raises(ab.LinkError, match="refused"):
        ab.connect("tcp://127.0.0.1:1")
    with pytest.raises(ab.LogError):
        ab.connect("sim:", log="/nowhere/run.mcap")


def test_a_forked_child_cannot_use_the_link(arm: ab.Board) -> None:
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            arm.status()
            answer = b"no error"
        except ab.ClosedError as error:
            answer = str(error).encode()
        os.write(writer, answer)
        os._exit(0)
    os.waitpid(child, 0)
    assert b"belongs to the parent" in os.read(reader, 1000)
    assert len(arm.telemetry.take(100, timeout=5.0)) == 100


def test_ctrl_c_ends_a_call_that_waits(arm: ab.Board) -> None:
    begun = time.monotonic()
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt), arm.armed():
        arm.telemetry.take(50_000)
    assert time.monotonic() - begun < 5.0
    wait_for_idle(arm)
    with arm.armed():
        timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            arm.move_to([0.0, 0.0], duration=8.0).wait()
    wait_for_idle(arm)


def test_threads_share_a_board(arm: ab.Board) -> None:
    taken: list[int] = []
    errors: list[Exception] = []

    def take() -> None:
        try:
            for _ in range(8):
                taken.extend(arm.telemetry.take(100, timeout=5.0)["tick"])
        except Exception as error:
            errors.append(error)

    threads = [threading.Thread(target=take) for _ in range(2)]
    with arm.armed():
        for thread in threads:
            thread.start()
        for k in range(20):
            arm.regulate([0.01 * k, 0.0])
        for thread in threads:
            thread.join()
    assert not errors
    assert sorted(taken) == list(range(min(taken), min(taken) + 1600))


def test_a_close_ends_what_another_thread_waits_for() -> None:
    arm = ab.connect()
    errors: list[Exception] = []

    def take() -> None:
        try:
            arm.telemetry.take(50_000)
        except ab.LinkError as error:
            errors.append(error)

    thread = threading.Thread(target=take)
    thread.start()
    time.sleep(0.2)
    arm.close()
    thread.join(timeout=5.0)
    assert not thread.is_alive() and len(errors) == 1
    arm.close()


def test_a_busy_interpreter_loses_nothing(arm: ab.Board) -> None:
    """A thread that spins holds the interpreter's lock in turns of 5 ms."""
    is_over = threading.Event()

    def spin() -> None:
        while not is_over.is_set():
            pass

    thread = threading.Thread(target=spin)
    thread.start()
    try:
        for _ in range(3):
            assert len(arm.telemetry.take(1000, timeout=10.0)) == 1000
        assert arm.telemetry.lost == 0
    finally:
        is_over.set()
        thread.join()
