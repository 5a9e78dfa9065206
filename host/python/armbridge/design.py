"""Controllers designed for the linear loop, without a board.

>>> import armbridge as ab
>>> ab.design.lqr(q=[30, 30, 0.3, 0.3], r=[10, 10]).is_stable
True
"""

from ._native import Design, computed_torque, lqr, place

__all__ = ["Design", "computed_torque", "lqr", "place"]
