"""Robot descriptions against the dynamics of MuJoCo."""

from __future__ import annotations

import importlib
from typing import Any

import armbridge as ab
import numpy as np
import pytest
from numpy.typing import NDArray

# It has no types.
mujoco: Any = importlib.import_module("mujoco")

ARMS = {
    "default": ab.Plant(),
    "heavy": ab.Plant("heavy"),
    "varied": ab.Plant().varied(0.4, 1),
    "hanging": ab.Plant.of_board({"arm.mounting": "hanging", "setup.friction_nm": [0.03, 0.05]}),
}


def mass(model: Any, data: Any) -> NDArray[np.float64]:
    """Mass matrix: its product with each unit vector."""
    columns = []
    for unit in np.eye(2):
        column = np.zeros(2)
        mujoco.mj_mulM(model, data, column, unit)
        columns.append(column)
    return np.array(columns).T


@pytest.mark.parametrize("form", ["mjcf", "urdf"])
@pytest.mark.parametrize("name", ARMS)
def test_equations_of_motion_are_those_of_the_board(name: str, form: str) -> None:
    plant = ARMS[name]
    arm = ab.Arm(plant)
    text = plant.mjcf() if form == "mjcf" else plant.urdf()
    model = mujoco.MjModel.from_xml_string(text)
    friction = [model.dof_frictionloss[joint] for joint in (0, 1)]
    assert all(0.0 < torque < 0.1 for torque in friction)
    model.dof_frictionloss[:] = 0.0
    if form == "urdf":
        # It has no gravity of its own: MuJoCo's default is 9.81 downwards.
        assert np.array_equal(model.opt.gravity, [0, 0, -9.81])
    data = mujoco.MjData(model)
    random = np.random.default_rng(1)
    for _ in range(100):
        q, dq, torque = random.uniform(-1.4, 1.4, 2), random.uniform(-4, 4, 2), random.uniform(-1, 1, 2)
        data.qpos[:], data.qvel[:], data.qfrc_applied[:] = q, dq, torque
        mujoco.mj_forward(model, data)
        assert np.abs(mass(model, data) - arm.mass(q)).max() < 1e-12
        bias = arm.coriolis(q, dq) @ dq + arm.gravity(q)
        assert np.abs(data.qfrc_bias - bias).max() < 1e-12
        assert np.abs(data.qacc - arm.acceleration(q, dq, torque)).max() < 1e-9


def test_a_fall_is_that_of_the_virtual_arm() -> None:
    plant = ab.Plant()
    model = mujoco.MjModel.from_xml_string(plant.mjcf())
    model.opt.timestep = 1e-4
    model.dof_frictionloss[:] = 0.0
    data = mujoco.MjData(model)
    data.qpos[:] = [0.3, -0.25]
    arm, q, dq, step = ab.Arm(plant), np.array([0.3, -0.25]), np.zeros(2), 1e-4
    while abs(q).max() < 1.2:
        dq = dq + arm.acceleration(q, dq, [0.0, 0.0]) * step
        q = q + dq * step
        mujoco.mj_step(model, data)
    # Both integrate by Euler's method, the damping of one implicitly.
    assert np.abs(data.qpos - q).max() < 2e-3


def test_stops_and_torques_are_those_of_the_virtual_arm() -> None:
    model = mujoco.MjModel.from_xml_string(ab.Plant().mjcf())
    assert np.allclose(model.jnt_range, [[-np.pi / 2, np.pi / 2], [-np.radians(150), np.radians(150)]])
    assert np.allclose(model.actuator_ctrlrange, 1.217 * np.array([[-1, 1], [-1, 1]]), atol=1e-3)


def test_urdf_says_which_arm_it_cannot_have() -> None:
    with pytest.raises(ValueError, match="write it as mjcf"):
        ab.Plant.of_board({"arm.i1x_kg_m2": 0.001}).urdf()
