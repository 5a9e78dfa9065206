import builtins
from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Self, TypeAlias, final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

__all__ = [
    "Arm",
    "ArmbridgeError",
    "Armed",
    "Block",
    "Board",
    "Campaign",
    "ClosedError",
    "Design",
    "DroppedError",
    "Environment",
    "Environments",
    "FaultError",
    "Fit",
    "IdentifyError",
    "LinkError",
    "Log",
    "LogError",
    "Motion",
    "ObserverError",
    "Plant",
    "RefusedError",
    "Replay",
    "Status",
    "Stream",
    "Telemetry",
    "Ticks",
    "Torque",
    "bench",
    "campaign_part",
    "computed_torque",
    "connect",
    "identify",
    "lqr",
    "place",
]

_Pair: TypeAlias = Sequence[float] | NDArray[np.floating[Any]]
"""Two numbers, one for each joint: of shape (2,)."""
_Value: TypeAlias = bool | int | float | str | np.generic | Sequence[bool | int | float | str] | NDArray[Any]
"""Value of a parameter."""

class ArmbridgeError(Exception):
    """Base of the package's exceptions."""

class LinkError(ArmbridgeError):
    """The link to the board could not be opened, or has ended."""

class ClosedError(ArmbridgeError):
    """The board was closed, or belongs to the parent of this process."""

class RefusedError(ArmbridgeError):
    """The board refuses a command."""

class FaultError(ArmbridgeError):
    """The board has switched torque off; `clear` ends that."""

class DroppedError(ArmbridgeError):
    """A stop or a disarm overtook the command, or the board was reset."""

class ObserverError(ArmbridgeError):
    """Another program commands the board."""

class LogError(ArmbridgeError):
    """A log cannot be read or written."""

class IdentifyError(ArmbridgeError):
    """The records do not identify the arm."""

def bench(
    scenario: str = "demo",
    *,
    settings: Mapping[str, _Value] | None = None,
    plant: str | Plant | None = None,
    friction: bool | None = None,
    initial: _Pair | None = None,
    seed: int | None = None,
    duration: float | None = None,
    log: str | PathLike[str] | None = None,
) -> dict[str, Any]:
    """Runs a scenario, a file or one that ships, on a simulated board and arm, and returns its
    figures. The same arguments give the same run, to the bit. `settings` are parameters of the
    board by name, `initial` angles in rad; `log` is the path of a log to be written.

    Figures, of the worse joint: `settling_time_s` (None if it never settled), `settled`,
    `rest_error_mrad`, `tracking_rms_mrad`, `peak_torque_nm`, `fault`, `missed_expectations`,
    `ended`.
    """

def identify(*logs: str | PathLike[str], weighed: float = 0.01) -> Fit:
    """Identifies an arm from logs, of one board each the same; a folder means the log in it.
    `weighed` is the relative standard error of the arm's known weight.

    Raises IdentifyError, with a diagnosis, if the logs do not identify it.
    """

def campaign_part(seeds: Sequence[int], *, activity: str | None = None, park: bool = False) -> str:
    """Runs the cases of these seeds, and returns them as JSON; a pure function of its arguments."""

def lqr(
    q: Sequence[float] | NDArray[Any], r: _Pair, *, settings: Mapping[str, _Value] | None = None
) -> Design:
    """The regulator of least cost: `q` weighs both angles and both speeds, `r` both torques.
    `settings` are parameters by name, such as `Board.settings`; the board's defaults without.

    Raises ValueError if a board would refuse it.
    """

def computed_torque(
    natural: _Pair, damping: _Pair, *, settings: Mapping[str, _Value] | None = None
) -> Design:
    """Computed torque: natural frequencies in rad/s and damping ratios of the errors of both
    joints."""

def place(
    poles: Sequence[Sequence[complex]] | NDArray[Any],
    *,
    settings: Mapping[str, _Value] | None = None,
) -> Design:
    """State feedback whose loop has these poles in z, of shape (2, 2): two for each joint, real or
    conjugate."""

def connect(
    link: str = "sim:",
    *,
    log: str | PathLike[str] | None = None,
    plant: str | Plant | None = None,
    friction: bool = True,
    initial: _Pair | None = None,
    seed: int = 1,
    observe: bool = False,
) -> Board:
    """Connects to a board and waits until it has reported itself.

    `link` is `sim:`, `emulate:`, `usb:`, `serial:`, `tcp://HOST:PORT` or `pty:` as in the host
    tool. A simulated board has its arm at `initial` angles in rad, and runs in step with the wall
    clock. `log` is the path of a log to be written.

    Raises LinkError if the link does not open, TimeoutError if the board does not answer.
    """

@final
class Board:
    """A board. A thread of its own serves the link; the board is disarmed, or its arm parked, when
    it is closed, by the end of its `with` block at the latest."""

    def __enter__(self) -> Self: ...
    def __exit__(self, *_error: object) -> None: ...
    def close(self) -> None:
        """Parks the arm or disarms, and closes the link and the log."""

    def status(self) -> Status:
        """Status of the board."""

    @property
    def telemetry(self) -> Telemetry:
        """Ticks as they arrive."""

    @property
    def settings(self) -> dict[str, Any]:
        """Parameters in force, by name."""

    def get(self, name: str) -> Any:
        """The value of a parameter; None if it belongs to another kind of controller or estimator."""

    def set(self, parameters: Mapping[str, _Value], *, save: bool = False) -> None:
        """Replaces parameters, all or none, and keeps them across power-off if `save`.

        Raises ValueError for a name or value that there is not, RefusedError if the board refuses.
        """

    def armed(self) -> Armed:
        """Arms the board for a `with` block, by whose end the arm is parked or the board disarmed."""

    def arm(self) -> None:
        """Arms the board: returns when its motors have been checked."""

    def disarm(self) -> None:
        """Disarms: torque is off at once."""

    def park(self) -> None:
        """Moves the arm to the pose of `park.angle_rad`, lowers it there and disarms; disarms
        without a pose."""

    def stop(self) -> None:
        """Emergency stop: torque off, until `clear`."""

    def clear(self) -> None:
        """Clears a fault."""

    def regulate(self, q: _Pair) -> None:
        """Holds the arm at these angles in rad, of shape (2,): a step, if it is elsewhere."""

    def move_to(self, q: _Pair, duration: builtins.float | None = None) -> Motion:
        """Moves the arm to these angles in rad, of shape (2,), with least jerk: in `duration` s, or
        as fast as the board's bounds permit."""

    def float(self) -> None:
        """Makes the arm weightless, for a hand to lead."""

    def experiment(self, experiment: Mapping[str, Any]) -> tuple[bool, str]:
        """Performs an experiment from where the arm is: a dictionary as a step of a scenario has
        it, of `roles`, `duration_s`, `angle_rad` and `speed_rad_s`. Returns whether it lasted its
        whole time, and a sentence that says why it ended; the arm is held then.

        Raises RefusedError if the board refuses it, FaultError after a fault.
        """

    def identify(self, plan: str = "identify", *, weighed: builtins.float = 0.01) -> Fit:
        """Moves the arm by a plan, a scenario that ships or a file, and identifies it; its records
        are in the log of the connection, too. An arm that was not armed is armed for it, and
        parked or let go of at the end. `weighed` is the relative standard error of its known
        weight.

        Raises IdentifyError, with a diagnosis, if the motion does not identify it.
        """

    def stream(self, rate: builtins.float, *, lead: builtins.float = 0.03) -> Stream:
        """A stream of setpoints at this rate in Hz, for a `with` block; each is sent `lead` s before
        the arm follows it."""

    def torque(self, rate: builtins.float) -> Torque:
        """Torques of a controller in Python at this rate in Hz, for a `with` block."""

    def push(self, joint: int, torque: builtins.float, duration: builtins.float) -> None:
        """Pushes a joint, 1 or 2, of a simulated arm: torque in N m for a duration in s."""

    def lift(self) -> None:
        """Brings a simulated arm back to where it began, and holds it there until a motor drives it."""

@final
class Armed:
    """The `with` block in which a board is armed."""

    def __enter__(self) -> Board: ...
    def __exit__(self, *_error: object) -> None: ...

@final
class Motion:
    """A motion that the board has accepted."""

    def wait(self, timeout: float = 30.0) -> None:
        """Waits until the reference rests at the motion's end.

        Raises FaultError if torque went off, DroppedError if another command ended the motion,
        TimeoutError after `timeout` s.
        """

    @property
    def done(self) -> bool:
        """Whether the reference rests at the motion's end."""

@final
class Ticks:
    """Times of a fixed rate, against deadlines that do not drift."""

    def __iter__(self) -> Self: ...
    def __next__(self) -> float: ...
    def __len__(self) -> int: ...

@final
class Stream:
    """A stream of setpoints, which the board interpolates."""

    def __enter__(self) -> Self: ...
    def __exit__(self, *_error: object) -> None: ...
    def ticks(self, duration: float) -> Ticks:
        """Deadlines for this many seconds."""

    def send(self, q: _Pair, dq: _Pair | None = None) -> None:
        """Sends the setpoint of the latest deadline of `ticks`, or of this moment without: angles in
        rad, and speeds in rad/s unless the board is to compute them. The arm is there one lead
        later; it joins the stream within 0.2 s."""

    @property
    def late(self) -> int:
        """Number of setpoints that came too late for the board, which leaves them out."""

@final
class Torque:
    """Torques of a controller in Python."""

    def __enter__(self) -> Self: ...
    def __exit__(self, *_error: object) -> None: ...
    def ticks(self, duration: float) -> Ticks:
        """Deadlines for this many seconds."""

    def send(self, torque: _Pair) -> None:
        """Sends torques in N m, which stay until the next ones, or until they are older than
        `limits.torque_age_ms`: then torque is off."""

@final
class Status:
    """Status of a board: its mode, and what it reports of itself."""

    @property
    def mode(self) -> str | None:
        """`idle`, `armed`, `regulate`, `track`, `fault` and so on; None before the first tick."""

    @property
    def fault(self) -> str | None:
        """Name of the fault, in mode `fault`."""

    @property
    def cause(self) -> str | None:
        """Cause of the fault and what to do, in a sentence."""

    @property
    def obstacle(self) -> str | None:
        """What the board lacks to be armed, in a sentence."""

    @property
    def is_armed(self) -> bool:
        """Whether the motors may be driven."""

    @property
    def servos(self) -> str | None:
        """Firmware of the servos, `Morpheus` or `AX-12A`; None until they are found."""

    @property
    def angle_rad(self) -> tuple[float, float] | None:
        """Estimated angles in rad."""

    @property
    def speed_rad_s(self) -> tuple[float, float] | None:
        """Estimated speeds in rad/s."""

    @property
    def tick(self) -> int | None:
        """Number of the latest tick."""

    @property
    def temperature(self) -> tuple[int | None, int | None]:
        """Temperatures of the servos: degrees Celsius of stock ones, converter counts of Morpheus."""

@final
class Telemetry:
    """Ticks of the board as they arrive. Up to 60 000 wait to be taken."""

    def take(self, count: int, timeout: float | None = None) -> Block:
        """Waits for this many ticks and takes them, oldest first.

        Raises TimeoutError after `timeout` s, LinkError if the link ends: the ticks wait.
        """

    def drain(self) -> Block:
        """Takes all ticks that wait."""

    @property
    def waiting(self) -> int:
        """Number of ticks that wait."""

    @property
    def lost(self) -> int:
        """Number of ticks lost since the board was connected, on the link or because they were not
        taken."""

@final
class Block:
    """Ticks in order, whose quantities are arrays: `block["angle_rad"]` has shape (n, 2), what the
    board has once has shape (n,). An array is made of the records when it is asked for."""

    def __len__(self) -> int: ...
    def __getitem__(self, name: str, /) -> NDArray[Any]: ...
    def __contains__(self, name: str, /) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def keys(self) -> list[str]:
        """Names of the quantities."""

    def unit(self, name: str) -> str:
        """Unit of a quantity, as `rad`; empty for words and plain numbers."""

    def to_pandas(self) -> pd.DataFrame:
        """A table with one column for each quantity and joint, as in the Parquet export."""

@final
class Log:
    """A log in memory, as far as its first damage."""

    def __new__(cls, path: str | PathLike[str]) -> Self: ...
    def __len__(self) -> int: ...
    def __getitem__(self, name: str, /) -> NDArray[Any]: ...
    def __contains__(self, name: str, /) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def keys(self) -> list[str]:
        """Names of the quantities."""

    def unit(self, name: str) -> str:
        """Unit of a quantity, as `rad`; empty for words and plain numbers."""

    def to_pandas(self) -> pd.DataFrame:
        """A table with one column for each quantity and joint, as in the Parquet export."""

    @property
    def path(self) -> PathLike[str]:
        """Path of the log."""

    @property
    def damage(self) -> list[str]:
        """Damage of the file, each in one sentence; empty for an intact one."""

    @property
    def settings(self) -> dict[str, Any] | None:
        """Parameters of the board by name: in force when the motors were first driven, else the
        last; None if the log has none."""

    def replay(self) -> Replay:
        """Runs the board's code on the recorded inputs, and compares its outputs to the bit."""

@final
class Replay:
    """Result of a replay."""

    @property
    def equal(self) -> bool:
        """Whether every compared tick and answer is equal to the bit."""

    @property
    def compared(self) -> int:
        """Number of ticks that were compared."""

    @property
    def differing(self) -> int:
        """Number of those that differ."""

    @property
    def first_difference(self) -> str | None:
        """The first difference, in a sentence."""

@final
class Arm:
    """Model of the arm: two links, gravity, and viscous friction. Angles are in rad from upright,
    torques in N m, all of shape (2,)."""

    def __new__(cls, plant: str | Plant | None = None) -> Self: ...
    def mass(self, q: _Pair) -> NDArray[np.float64]:
        """Mass matrix in kg m^2, of shape (2, 2)."""

    def coriolis(self, q: _Pair, dq: _Pair) -> NDArray[np.float64]:
        """Coriolis matrix, of shape (2, 2): its product with the speeds is a torque."""

    def gravity(self, q: _Pair) -> NDArray[np.float64]:
        """Torque of gravity in N m."""

    def acceleration(self, q: _Pair, dq: _Pair, torque: _Pair) -> NDArray[np.float64]:
        """Acceleration in rad/s^2 under a torque of the motors."""

    def energy(self, q: _Pair, dq: _Pair) -> float:
        """Kinetic and potential energy in J; the latter is 0 with both links level."""

    def linearise(self, q: _Pair) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Matrices A of shape (4, 4) and B of shape (4, 2) of the arm at rest at these angles, with
        the state of angles and speeds."""

@final
class Design:
    """A design: gain, poles and margins of the loop about upright that the board closes."""

    @property
    def gain(self) -> NDArray[np.float64]:
        """Gain from state to torque, of shape (2, 4), in N m/rad and N m s/rad."""

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Poles in z of the controller, the estimator and the actuators, of shape (n,)."""

    @property
    def margins(self) -> dict[str, Any]:
        """Margins of the loop, by name."""

    @property
    def is_stable(self) -> bool:
        """Whether the loop is stable."""

    @property
    def parameters(self) -> dict[str, Any]:
        """Parameters for `Board.set`."""

@final
class Fit:
    """An arm identified from its motion."""

    @property
    def parameters(self) -> dict[str, Any]:
        """Parameters of the arm for `Board.set`, and for the keys of a scenario."""

    def adopted_by(self, settings: Mapping[str, _Value]) -> dict[str, Any]:
        """Parameters of a board with the identified arm: its own, and a gain for it where it has
        one that was given instead of designed."""

    @property
    def estimates(self) -> list[dict[str, Any]]:
        """Estimates as a list of dictionaries: joint, name, unit, value, half width of the 95 %
        interval."""

    def plants(self, count: int, seed: int = 0) -> list[Plant]:
        """So many virtual arms, drawn from the distribution of the estimates; a pure function of the
        fit and its arguments."""

    @property
    def uncertain(self) -> list[str]:
        """Reasons, a sentence each, for which the estimates are too uncertain to control an arm by;
        empty if they are certain enough."""

@final
class Campaign:
    """A fault campaign."""

    def __new__(cls, parts: Sequence[str]) -> Self:
        """Joins parts, each as JSON of some seeds."""

    def __len__(self) -> int: ...
    @property
    def holds(self) -> bool:
        """Whether all requirements are met."""

    @property
    def report(self) -> dict[str, Any]:
        """Results by kind of fault, activity and set-up, and the failures."""

    @property
    def cases(self) -> list[dict[str, Any]]:
        """Cases in the order of their seeds, a dictionary each."""

    def to_json(self) -> str:
        """What `armbridge fault-campaign --json` prints of the same seeds, to the byte."""

@final
class Plant:
    """A virtual arm: links, friction, motors and encoders, wherever it is."""

    def __new__(cls, name: str | None = None) -> Self:
        """The default arm, that of a plant file, or one that ships."""

    @staticmethod
    def of_board(parameters: Mapping[str, _Value]) -> Plant:
        """The arm that a board with these parameters takes its own for."""

    def varied(self, spread: float, seed: int) -> Plant:
        """This arm with masses, inertias, friction and motor gains that are each off by a factor from
        `1 - spread` to `1 + spread`; a pure function of its arguments."""

    def mjcf(self) -> str:
        """The arm as a model of MuJoCo."""

    def urdf(self) -> str:
        """The arm as URDF."""

    def to_toml(self) -> str:
        """The arm as a plant file."""

@final
class Environment:
    """One environment, see `armbridge.gym`. `board` is a board to run it on instead of a simulated
    one."""

    def __new__(
        cls,
        task: str,
        *,
        mode: str = "fast",
        action: str = "torque",
        settings: Mapping[str, _Value] | None = None,
        plant: str | Plant | Sequence[str | Plant] | None = None,
        ticks: int = 20,
        steps: int = 250,
        board: Board | None = None,
    ) -> Self: ...
    @property
    def bounds(self) -> list[NDArray[np.float64]]:
        """Smallest and largest actions, each of shape (2,)."""

    @property
    def observations(self) -> int:
        """Length of an observation."""

    def reset(self, seed: int | None = None) -> NDArray[np.float32]:
        """Begins an episode, after seeding the generator of episodes if `seed` is given."""

    def step(self, action: _Pair) -> tuple[NDArray[np.float32], float, bool, bool]:
        """Runs a step: observation, reward, whether the episode has ended, whether it was truncated."""

    @property
    def info(self) -> dict[str, Any]:
        """The last tick, and the true angles and speeds of a simulated arm."""

@final
class Environments:
    """So many environments like another one, which are stepped on all processors."""

    def __new__(cls, environment: Environment, count: int) -> Self: ...
    def reset(self, seeds: Sequence[int | None]) -> NDArray[np.float32]:
        """Begins an episode in each; `seeds` has one for each, or None."""

    def step(
        self, actions: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_]]:
        """Runs a step of each, with actions of shape (n, 2): observations, rewards, whether the
        episodes have ended, whether they were truncated. The step after the end of an episode begins
        the next."""
