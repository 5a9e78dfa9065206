"""Boards, benches and logs of Armbridge.

>>> import armbridge as ab
>>> with ab.connect("sim:") as arm:
...     with arm.armed():
...         arm.regulate([0.0, 0.0])
...         block = arm.telemetry.take(1000)
>>> block["angle_rad"].shape
(1000, 2)

Angles are in rad from upright, speeds in rad/s, torques in N m, times in s. A board is served by a
thread of its own, which keeps the link alive while Python is busy; the arm is parked, or the board
disarmed, at the end of every `with` block, by an exception too.
"""

from . import cluster as cluster, design as design
from ._native import *
from .cluster import campaign as campaign, sweep as sweep

# They are those of `design`, `cluster` and `gym`.
del computed_torque, lqr, place, campaign_part, Environment, Environments
