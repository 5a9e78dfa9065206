"""The model of the arm."""

import armbridge as ab
import numpy as np
import pytest


def test_the_equations_of_motion_agree_with_each_other() -> None:
    arm = ab.Arm()
    q, dq, torque = np.array([0.3, -0.4]), np.array([0.5, 1.5]), np.array([0.2, -0.1])
    mass, coriolis, gravity = arm.mass(q), arm.coriolis(q, dq), arm.gravity(q)
    assert mass.shape == coriolis.shape == (2, 2) and gravity.shape == (2,)
    at_rest = arm.acceleration(q, [0.0, 0.0], torque)
    assert np.allclose(mass @ at_rest, torque - gravity)
    # Near rest the linearisation is the derivative of the acceleration.
    a, b = arm.linearise(q)
    assert a.shape == (4, 4) and b.shape == (4, 2)
    step = 1e-6
    for joint in range(2):
        moved = q + step * np.eye(2)[joint]
        slope = (
            arm.acceleration(moved, [0, 0], gravity) - arm.acceleration(q, [0, 0], gravity)
        ) / step
        assert np.allclose(a[2:, joint], slope, atol=1e-4)
    assert np.allclose(b[2:], np.linalg.inv(mass))


def test_a_falling_arm_loses_energy() -> None:
    arm = ab.Arm()
    with pytest.raises(ValueError, match="expected two angles in rad, got 3"):
        arm.mass([0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="nothing"):
        ab.Arm("nothing")
    # A fall from 0.3 rad loses energy by viscous friction alone.
    q, dq, dt = np.array([0.3, 0.0]), np.zeros(2), 1e-4
    energies = []
    for _ in range(5_000):
        energies.append(arm.energy(q, dq))
        dq = dq + dt * arm.acceleration(q, dq, [0.0, 0.0])
        q = q + dt * dq
    assert np.all(np.diff(energies) < 1e-6)
