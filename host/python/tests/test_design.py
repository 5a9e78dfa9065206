"""Designs, benches and identification."""

import threading
import time
from pathlib import Path
from typing import Any

import armbridge as ab
import numpy as np
import pytest

HOLD = {
    "roles": ["hold", "hold"],
    "duration_s": 0.5,
    "angle_rad": [[-0.5, 0.5], [-0.5, 0.5]],
    "speed_rad_s": [2.0, 2.0],
}
PLAN = """
title = "A short multisine"
control = "compensated"
set.controller = { kind = "computed-torque", natural_rad_s = [20.0, 20.0] }
bench.initial_rad = [0.0, 0.0]
stop.after_s = 12.0

[[step]]
at_s = 0.0
regulate_rad = [0.0, 0.0]

[[step]]
at_s = 1.0
[step.experiment]
duration_s = 10.0
angle_rad = [[-0.6, 0.6], [-0.6, 0.6]]
speed_rad_s = [3.0, 3.0]
roles = [
    { angle = { multisine = { amplitude = 0.15, lowest_hz = 0.2, lines = 8, ramp_s = 2.0 } } },
    { angle = { multisine = { amplitude = 0.2, lowest_hz = 0.2, lines = 7, ramp_s = 2.0 } } },
]
"""


def test_a_regulator_has_the_poles_of_its_gain() -> None:
    design = ab.design.lqr(q=[30, 30, 0.3, 0.3], r=np.array([10, 10]))
    assert design.is_stable and design.gain.shape == (2, 4)
    assert np.all(np.abs(design.poles) < 1)
    a, b = ab.Arm().linearise([0.0, 0.0])
    loop = np.linalg.eigvals(a - b @ design.gain)
    # Those of the controller are the continuous ones, sampled at 1 kHz; the torque acts a
    # period later, which moves them by less than 1 %.
    expected = np.exp(1e-3 * loop)
    for pole in expected:
        assert np.min(np.abs(np.log(design.poles) - np.log(pole))) < 0.02 * abs(np.log(pole))


def test_placed_poles_are_those_of_the_loop() -> None:
    poles: list[list[complex]] = [[0.98, 0.97], [0.98 + 0.01j, 0.98 - 0.01j]]
    design = ab.design.place(poles)
    for pole in sum(poles, []):
        assert np.min(np.abs(design.poles - pole)) < 1e-4


def test_the_board_has_what_was_designed() -> None:
    design = ab.design.computed_torque([12.0, 12.0], [1.0, 1.0])
    with ab.connect("sim:") as arm:
        arm.set(design.parameters)
        assert arm.get("controller.natural_rad_s") == [12.0, 12.0]
        assert ab.design.lqr([30] * 4, [10] * 2, settings=arm.settings).is_stable


@pytest.mark.parametrize(
    ("poles", "error"),
    [([[0.98, 1.2], [0.9, 0.9]], ValueError), ([[0.9, 0.8]], ValueError), (3, TypeError)],
)
def test_poles_that_there_are_not(poles: Any, error: type[Exception]) -> None:
    with pytest.raises(error):
        ab.design.place(poles)


@pytest.mark.parametrize("q", [[1, 1, 1], [1, 1, 1, float("nan")], "abcd", 5])
def test_weights_that_there_are_not(q: Any) -> None:
    with pytest.raises(ValueError, match="controller.q"):
        ab.design.lqr(q, [1, 1])


def test_the_same_bench_is_the_same_to_the_bit(tmp_path: Path) -> None:
    log = tmp_path / "demo.mcap"
    first = ab.bench("demo", seed=3, log=log)
    assert first["settled"] and first == ab.bench("demo", seed=3)
    assert first != ab.bench("demo", seed=4)
    assert ab.Log(log).replay().equal


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"scenario": "nope"}, "no scenario `nope`"),
        ({"settings": {"limits.torqe_nm": [1, 1]}}, "is it `limits.torque_nm`"),
        ({"plant": "nope"}, "no virtual arm `nope`"),
        ({"initial": [1]}, "two angles in rad, got 1"),
    ],
)
def test_benches_that_there_are_not(keywords: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ab.bench(**keywords)


def test_ctrl_c_ends_a_bench() -> None:
    import _thread

    begun = time.monotonic()
    threading.Timer(0.5, _thread.interrupt_main).start()
    with pytest.raises(KeyboardInterrupt):
        ab.bench("demo", duration=3600.0)
    assert time.monotonic() - begun < 3.0


def test_an_experiment_says_how_it_ended() -> None:
    with ab.connect("sim:") as arm, arm.armed():
        arm.regulate([0.0, 0.0])
        whole, why = arm.experiment(HOLD)
        assert whole and "its time is up" in why
        with pytest.raises(ab.RefusedError, match="joint 2's envelope"):
            arm.experiment({**HOLD, "speed_rad_s": [2.0, 200.0]})
        with pytest.raises(ValueError, match="missing field `roles`"):
            arm.experiment({})


def test_an_arm_is_identified_on_its_board(tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN)
    log = tmp_path / "run.mcap"
    with ab.connect("sim:", plant="heavy", log=log) as arm:
        before = arm.settings
        fit = arm.identify(str(plan))
        assert arm.status().mode == "idle" and arm.settings == before
        # An arm 1.2 times as heavy as the board believes moves as one whose motors are weaker.
        name = "joint1.gain_counts_per_nm"
        assert fit.parameters[name] == pytest.approx(before[name] * 1.2, rel=0.1)
        arm.set(fit.adopted_by(arm.settings))
        assert arm.get(name) == pytest.approx(fit.parameters[name])
    # The log of the connection has the same motion.
    again = ab.identify(log)
    assert again.estimates == fit.estimates
    assert "inertia" in str(again)


def test_a_log_that_identifies_nothing_is_diagnosed(tmp_path: Path) -> None:
    log = tmp_path / "demo.mcap"
    ab.bench("demo", log=log)
    with pytest.raises(ab.IdentifyError, match="too short a log"):
        ab.identify(log)
    with pytest.raises(ab.IdentifyError, match="empty"):
        ab.identify()
    with pytest.raises(ab.LogError):
        ab.identify(tmp_path / "none.mcap")
    with pytest.raises(ValueError, match="weighed"):
        ab.identify(log, weighed=0.0)
