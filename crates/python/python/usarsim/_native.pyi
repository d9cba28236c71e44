"""Types and docs of the compiled part of the package. Import its names from `usarsim`.

The world frame is that of USARSim: x forward, y to the right, z down. Units are metres, kilograms, seconds and radians.
A quaternion is x, y, z, w. Roll, pitch and yaw are positive clockwise, seen along x, y and z: a positive yaw turns right.
Case does not matter in names of classes, starts, sensors, joints and objects.
"""

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from ._picture import Picture
from ._view import View

__all__ = [
    "__version__",
    "Scene",
    "World",
    "Robot",
    "Reading",
    "Object",
    "Batch",
    "Environments",
    "main",
    "_png",
    "maps",
    "robots",
    "scenarios",
    "tasks",
    "_replay",
    "_validate",
    "_run_experiment",
    "_fit",
    "Error",
    "SceneError",
    "CommandError",
    "SaveError",
    "LogError",
    "TaskError",
    "UsarsimWarning",
    "_finish_sweep",
    "_sweep_batch",
    "_sweep_batches",
]

_Path: TypeAlias = str | os.PathLike[str]
_Numbers: TypeAlias = Sequence[float] | NDArray[np.floating[Any]] | NDArray[np.integer[Any]]
_Size: TypeAlias = Sequence[int] | NDArray[np.integer[Any]]
_DriveModel: TypeAlias = Literal["articulated", "bodies", "analytic", "kinematic", "kinematic-textbook"]
_Orders: TypeAlias = Literal["wheels", "twist", "joints", "wheels+joints", "twist+joints"]
_Autoreset: TypeAlias = Literal["next_step", "same_step", "disabled"]

__version__: str
"""Version of the package, as `usarsim --version` prints it."""

@final
class Scene:
    """A map with classes of robots. It does not change, and worlds share it.

    >>> from usarsim import Scene, describe
    >>> scene = Scene("rough")
    >>> scene.map, scene.starts
    ('rough', ['PlayerStart_0', 'RobotStart1', 'RobotStart2'])
    >>> "KUKA_YouBot" in scene.classes
    True
    >>> describe(Scene("rough", set=["map.gravity=1.62"]))["gravity"]
    1.62
    """

    def __new__(
        cls,
        map: str | None = None,
        *,
        scenario: str | None = None,
        robots: Sequence[_Path] = ...,
        set: Sequence[str] = ...,
        equipment: str | None = None,
        drive_model: _DriveModel | None = None,
    ) -> Scene:
        """Loads a map, or a scenario with its own, and all shipped robot classes.

        `map` is the name of a shipped map, see `maps()`, or the path of a map.toml or its folder, by default `hall`. `scenario` is
        the name of a shipped scenario, see `scenarios()`, or the path of a scenario.toml or its folder: `world.spawn` puts its
        robots at their starts, and `world.reached` and `world.finished` judge them. `robots` adds classes:
        paths of a robot.toml, its folder, or a URDF file. Their names are those of the folder or the URDF file. `set` replaces
        numbers: a list of `PATH=VALUE`, as `robot.wheels.gain=2.5` (every robot that has it), `P3AT.wheel.FLWheel.gain=1`,
        `map.gravity=1.62` or `material.carpet.friction=0.5`. `equipment` replaces what robots carry: the name of a set, as
        `robocup2014`, or the path of its file. `drive_model` replaces the drive model of every class that can have it.

        Raises `SceneError` for an unknown name, a mistake in a file, an override that changes nothing, or both a map and a scenario.
        """

    @property
    def map(self) -> str:
        """Name of the map."""

    @property
    def classes(self) -> list[str]:
        """Names of the robot classes, sorted."""

    @property
    def starts(self) -> list[str]:
        """Names of the start poses of the map."""

    def _robot_json(self, class_name: str) -> str:
        """Returns every number of a robot class as JSON. `usarsim.describe` reads it."""

    def _map_json(self) -> str:
        """Returns every number of the map as JSON. `usarsim.describe` reads it."""

    @staticmethod
    def _from_bytes(bytes: bytes) -> Scene:
        """Returns a pickled scene."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Returns what pickle makes the scene of: every number of it, so that it needs no files."""

@final
class World:
    """A simulated world: a scene, robots in it, and a clock that only `step` and `run` advance.

    The same scene, seed, orders and steps give the same bits, with any number of threads.

    >>> from usarsim import Scene, World
    >>> world = World(Scene("rough"), seed=1)
    >>> robot = world.spawn("KUKA_YouBot", position=(0, 0, 0))
    >>> robot.drive_twist(forward=0.3)
    >>> world.run(seconds=0.5)
    >>> world
    World("rough", time=0.500, 1 robots)
    >>> other = world.copy()
    >>> world.step(100)
    >>> other.run(0.2)
    >>> other.digest == world.digest
    True
    """

    def __new__(
        cls, scene: Scene, *, seed: int = 0, time_step: float = 0.002, threads: int = 1, log: _Path | None = None
    ) -> World:
        """Creates a world at time zero without robots.

        `seed` (0 to 2**64 - 1) decides the noise of sensors. `time_step` is 0.0001 to 0.02 s, by default 0.002. `threads` move
        robots that do not touch; 0 takes as many as the machine runs at a time, at most 256. `log` is the path of an MCAP file
        that records every order, state and reading. The file must be a new one. End the log by `close`, or use the world in
        a `with` block.

        Raises `SceneError` for the time step, `CommandError` for the threads, `LogError` if the log cannot be written, and
        `OverflowError` for a seed out of range.
        """

    def spawn(
        self,
        class_name: str,
        *,
        start: str | None = None,
        position: _Numbers | None = None,
        rotation: _Numbers | None = None,
        name: str = "",
    ) -> Robot:
        """Spawns a robot and returns it.

        `start` is the name of a start pose of the map. `position` is x, y, z in the world, m; a position in the floor is
        raised onto it. `rotation` is roll, pitch, yaw, rad, by default 0. With neither `start` nor `position` the robot
        takes the place of the map's first start. `name` is free text for logs and people.

        Raises `CommandError` for an unknown class or start, for `start` beside `position` or `rotation`, for numbers that are not finite or
        outside the map, and if no robot fits there. Warns with `usarsim.UsarsimWarning` if the robot is put beside an occupied place, or
        if its name is taken.
        """

    def step(self, steps: int = 1, *, real_time_factor: float | None = None) -> None:
        """Advances the world by time steps. Ctrl-C ends it within 0.1 s.

        `real_time_factor` is the simulated seconds per second that it keeps to, 0.001 to 1000, to watch the world; None is as
        fast as possible.

        Raises `CommandError` for more than 31 simulated days or another factor, `LogError` if the log cannot be written, and `OverflowError` for
        a negative number.
        """

    def run(self, seconds: float, *, real_time_factor: float | None = None) -> None:
        """Advances the world by a time, s, rounded to whole time steps. `real_time_factor` is as for `step`.

        Raises `CommandError` if the time is negative, not finite, or more than 31 days, and `LogError` if the log cannot be
        written.
        """

    @property
    def time(self) -> float:
        """Simulated time, s."""

    @property
    def time_step(self) -> float:
        """Length of a time step, s."""

    @property
    def scene(self) -> Scene:
        """The scene. Each call returns another object for the same scene."""

    @property
    def robots(self) -> list[Robot]:
        """Robots in the order of their spawns."""

    @property
    def objects(self) -> list[Object]:
        """Movable objects at this moment, by their ids. One that a robot holds is not among them."""

    def put_object(self, name: str, position: _Numbers, rotation: _Numbers = ...) -> None:
        """Puts a movable object at a pose in the world, at rest.

        `position` is that of its middle: x, y, z, m. `rotation` is roll, pitch, yaw, rad, by default 0.

        Raises `CommandError` for an unknown name, a position outside the map, and in a world with a log, which could not
        repeat it.
        """

    def create_object(
        self,
        class_name: str,
        name: str,
        position: _Numbers,
        rotation: _Numbers = ...,
        *,
        scale: _Numbers = ...,
        material: str = "",
        rigid: bool = True,
    ) -> Object:
        """Creates a movable object, and returns it. A world may have 1024.

        `class_name` is one of the classes of a world controller, as `WCCrate`, and `position` that of its middle: x, y, z, m.
        `rotation` is roll, pitch, yaw, rad. `scale` are factors of its size along x, y, z; its mass follows the volume.
        `material` is one of the world, or that of the class. An object that is not `rigid` stays where it is put, and robots
        drive against it or on it. A rigid one in the floor is raised onto it.

        Raises `CommandError` for an unknown class, a name that is empty or taken, and a place that is taken or outside the
        map. Warns with `UsarsimWarning` of an unknown material; the object has that of its class then.

        >>> from usarsim import Scene, World
        >>> world = World(Scene("rough"))
        >>> world.create_object("WCCrate", "box", position=(1, 0, -0.5))
        Object("box", position=[1.000, 0.000, -0.500])
        >>> world.run(1.0)
        >>> world.objects
        [Object("box", position=[1.000, 0.000, -0.250])]
        >>> world.remove_object("box")
        >>> world.objects
        []
        """

    def remove_object(self, name: str) -> None:
        """Removes a movable object, also one of the map.

        Raises `CommandError` for an unknown name.
        """

    def control(self, line: str) -> list[str]:
        """Sends one line of the Gamebots protocol as a world controller, and returns the lines that answer it.

        `CONTROL` turns objects, lets them follow paths, moves robots and drives conveyors. Objects of `create_object` are the
        same controller's.

        Raises `CommandError` for everything that a server would complain about, and for a text with line ends or of more
        than 65536 bytes.

        >>> from usarsim import Scene, World
        >>> world = World(Scene("rough"))
        >>> crate = world.create_object("WCCrate", "box", position=(1, 0, -0.25))
        >>> world.control("CONTROL {Type AbsMove} {Name box} {Location 3,0,-0.25}")
        []
        >>> world.control("CONTROL {Type GetSTA} {Name box}")[0][:62]
        'STA {Name box} {Size 0.5000,0.5000,-0.5000} {Location 3.0000,0'
        """

    @property
    def reached(self) -> list[str]:
        """Names of the goals of the scenario that have been reached, in that order. Without a scenario there are none."""

    @property
    def finished(self) -> float | None:
        """Simulated time from the first robot's arrival in which all goals of the scenario were reached, s; None before that."""

    @property
    def digest(self) -> str:
        """Hash of the bits of every body, 16 hexadecimal digits. Equal worlds have equal digests."""

    @property
    def unsettled_steps(self) -> int:
        """Number of systems of touching bodies, over all steps, whose contact solver did not converge. 0 is usual."""

    def copy(self) -> World:
        """Returns an independent copy that continues with the same bits, without a log."""

    def __copy__(self) -> World:
        """Returns `copy()`."""

    def __deepcopy__(self, _memo: object) -> World:
        """Returns `copy()`."""

    def save(self) -> bytes:
        """Returns the state as bytes, without the scene and without the last readings.

        Raises `SaveError` if a robot has the drive model `bodies`.
        """

    @staticmethod
    def load(scene: Scene, state: bytes, *, threads: int = 1) -> World:
        """Creates a world that goes on from a saved state with the same bits.

        `scene` is a scene like the one of the saved world: the same map, overrides and equipment. Seed, time step, time and
        robots come from the state.

        Raises `SaveError` if the state cannot be read, or its robots or objects do not fit the scene.
        """

    @staticmethod
    def _restore(scene: Scene, state: bytes, threads: int) -> World:
        """Returns a pickled world."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Returns what pickle makes the world of: its scene and what `save` returns, without a log and the last readings."""

    def _robot(self, id: int) -> Robot:
        """Returns the robot with a number. Pickle uses it."""

    def close(self) -> None:
        """Ends the log, if there is one. The world itself goes on without it.

        Raises `LogError` if the log cannot be written.
        """

    def show(self, port: int = 0, height: int = 480) -> View:
        """Serves a page that shows the world, with the beams of lasers and sonars, while it is stepped. A notebook shows it as
        a frame of `height` pixels.

        `port` 0 takes a free one. The page is served on this machine alone, and nobody can drive or change the world from it.
        A second call shows the present and returns a view of the same page.

        Raises `CommandError` if it cannot listen on the port.
        """

    def _hide(self) -> None:
        """Ends the page of the world. `View.close` calls it."""

    def __enter__(self) -> World:
        """Returns the world."""

    def __exit__(self, *_error: object) -> None:
        """Ends the log, as `close` does."""

    def picture(
        self, size: _Size = ..., *, eye: _Numbers | None = None, target: _Numbers | None = None
    ) -> Picture:
        """Draws the world: an array of rows, columns and colours (uint8).

        `size` is width and height, 16 to 8192 pixels each, by default 640 x 360. `eye` is the camera's position and `target` the
        point in the middle of the picture: x, y, z in the world, m. By default the camera looks at all robots from behind and
        above, or at the map if there are none.

        Raises `CommandError` for a size out of range or numbers that are not finite.
        """

@final
class Robot:
    """A robot in a world. `World.spawn` and `World.robots` return it.

    Orders hold until the next ones. Properties give the state after the last time step, in new arrays.
    After the robot has left, only `id` and `is_alive` work; all else raises `CommandError`.

    >>> from usarsim import Scene, World
    >>> world = World(Scene("rough"))
    >>> robot = world.spawn("P3AT", position=(1, 2, 0), name="Ann")
    >>> robot.wheel_names
    ['FRWheel', 'FLWheel', 'BRWheel', 'BLWheel']
    >>> robot.drive_sides(left=2.0, right=2.0)
    >>> world.run(0.5)
    >>> robot.wheel_speeds.round(1).tolist()
    [2.0, 2.0, 2.0, 2.0]
    >>> bool(robot.position[0] > 1.05)
    True
    >>> points, forces = robot.contacts
    >>> round(-forces[:, 2].sum() / 9.81), "kg"
    (12, 'kg')
    >>> robot.remove()
    >>> robot.is_alive
    False
    """

    @property
    def id(self) -> int:
        """Number of the robot in its world, from 0. No other robot of the world ever has it."""

    @property
    def name(self) -> str:
        """Name from its spawn, or the empty string."""

    @property
    def class_name(self) -> str:
        """Name of its class."""

    @property
    def is_alive(self) -> bool:
        """True while it is in the world."""

    @property
    def position(self) -> NDArray[np.float64]:
        """Position of the robot frame in the world: x, y, z, m, shape (3,)."""

    @property
    def orientation(self) -> NDArray[np.float64]:
        """Orientation of the robot frame in the world, a quaternion x, y, z, w, shape (4,)."""

    @property
    def rotation(self) -> NDArray[np.float64]:
        """Orientation of the robot frame in the world: roll, pitch, yaw, rad, shape (3,)."""

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Velocity of the robot frame's origin along the world's axes, m/s, shape (3,)."""

    @property
    def angular_velocity(self) -> NDArray[np.float64]:
        """Angular velocity about the world's axes, rad/s, shape (3,). A positive z turns clockwise, seen from above."""

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints that have a value, wheels included."""

    @property
    def joint_positions(self) -> NDArray[np.float64]:
        """Positions of the joints of `joint_names`, rad or m."""

    @property
    def joint_speeds(self) -> NDArray[np.float64]:
        """Speeds of the joints of `joint_names`, rad/s or m/s."""

    @property
    def wheel_names(self) -> list[str]:
        """Names of the driven wheels, and of tracks after them."""

    @property
    def wheel_angles(self) -> NDArray[np.float64]:
        """Angles of the wheels of `wheel_names`, rad, not wrapped."""

    @property
    def wheel_speeds(self) -> NDArray[np.float64]:
        """Speeds of the wheels of `wheel_names`, rad/s."""

    @property
    def contacts(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Contacts of the last time step: points in the world, m, and forces on the robot along the world's axes, N.

        Both have shape (n, 3). Forces of the floor have a negative z.
        """

    @property
    def grip(self) -> dict[str, NDArray[Any]]:
        """Grip of each of the `contacts`, in their order.

        | key | shape | meaning |
        |---|---|---|
        | `wheels` | (n,) | number of the wheel in `wheel_names`, -1 for another part |
        | `slips` | (n, 3) | velocity of the robot's surface over what it touches, along that, m/s; free rollers slip along their axis only |
        | `friction_used` | (n,) | friction over the most that the contact can give; 1 where it slides |
        | `patches` | (n, 2) | half length and half width of the tyre's patch, m; 0 for a rigid disc |
        """

    @property
    def effective_track(self) -> float | None:
        """Difference of the speeds of its sides' wheels over its yaw rate, m: the track that it would have if its wheels did not slip.

        Over the true track it is the turning factor of a skid-steered robot, chi. `None` for a robot that turns by less than
        0.02 rad/s or has no wheels on both sides of its body.
        """

    @property
    def sensor_names(self) -> list[str]:
        """Names of its sensors. A name that comes again has a number behind it, as `Camera#2`."""

    @property
    def readings(self) -> dict[str, Reading]:
        """Last readings by the names of their sensors, of all sensors that have measured.

        Another name raises a `KeyError` that lists the sensors.
        """

    def reading(self, name: str) -> Reading | None:
        """Returns the last reading of a sensor, or None before its first one.

        Raises `CommandError` for an unknown sensor.
        """

    def camera(self, name: str = "Camera", size: _Size = ...) -> Picture:
        """Draws what a camera sees now: an array of rows, columns and colours (uint8).

        `size` is width and height, 16 to 8192 pixels each, by default 320 x 240.

        Raises `CommandError` for an unknown sensor, one that is not a camera, and a size out of range.
        """

    def drive_wheels(self, speeds: _Numbers) -> None:
        """Sets the target speeds of the wheels of a Mecanum base, rad/s, in the order of `wheel_names`.

        A positive speed drives forward. A wheel turns at most at its `max_speed`. Use `drive_sides` for skid-steered robots,
        and `drive` for cars.

        Raises `CommandError` for another number of speeds, speeds that are not finite, and other robots.
        """

    def drive_sides(self, left: float, right: float) -> None:
        """Sets the target speeds of all driven wheels on the left and on the right, rad/s.

        It is for skid-steered robots and Mecanum bases.

        Raises `CommandError` for speeds that are not finite, and other robots.
        """

    def drive_twist(self, forward: float = 0.0, right: float = 0.0, clockwise: float = 0.0) -> None:
        """Sets the target velocity of a Mecanum base or a flying robot in its own frame: m/s, m/s and rad/s.

        `clockwise` is meant as seen from above. Use `drive_sides` for skid-steered robots, and `drive` for cars.

        Raises `CommandError` for velocities that are not finite, and other robots.
        """

    def drive(self, keys: Mapping[str, float]) -> None:
        """Sends a DRIVE line with these keys and numbers. The robot's class decides which keys it takes, and ignores
        others, as on the wire.

        A car takes `{"Speed": 2.0, "FrontSteer": 0.3, "RearSteer": 0.0}`: rad/s of its wheels, and rad.

        Raises `CommandError` for problems of the line, and for numbers that are not finite.
        """

    def move_joints(self, targets: Mapping[str, float]) -> None:
        """Sets the targets of joints that are no wheels, rad or m, by name. Other joints keep their targets.

        A target beyond the joint's limits counts as the limit.

        Raises `CommandError` for an unknown joint, and then moves none.
        """

    def send(self, line: str) -> list[str]:
        """Sends one line of the Gamebots protocol as the robot's controller, as `SET {Type Gripper} ..`, and returns the
        lines that answer it.

        Raises `CommandError` for everything that a server would complain about, and for a text with line ends or of more
        than 65536 bytes.
        """

    def remove(self) -> None:
        """Removes the robot from the world."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Returns what pickle makes the robot of: its world and its number."""

@final
class Reading:
    """A reading of a sensor: its quantities by name, as arrays.

    >>> from usarsim import Scene, World
    >>> world = World(Scene("rough"))
    >>> robot = world.spawn("P3AT", position=(0, 0, 0))
    >>> robot.reading("lms200") is None
    True
    >>> world.run(0.5)
    >>> scan = robot.readings["lms200"]
    >>> scan
    Reading("lms200", RangeScanner, time=0.400, ranges)
    >>> scan["ranges"].shape, scan.units
    ((181,), {'ranges': 'm'})
    >>> robot.readings["GndTruth"].keys()
    ['position', 'angles']
    """

    @property
    def name(self) -> str:
        """Name of the sensor."""

    @property
    def type(self) -> str:
        """Type of the reading on the wire, as `RangeScanner` or `GroundTruth`."""

    @property
    def time(self) -> float:
        """Simulated time of the measurement, s."""

    @property
    def units(self) -> dict[str, str]:
        """Units of the quantities by name, as `m`; empty for numbers without a unit."""

    def keys(self) -> list[str]:
        """Returns the names of the quantities."""

    def __len__(self) -> int:
        """Returns the number of quantities."""

    def __contains__(self, key: str, /) -> bool:
        """Returns true if there is a quantity with this name."""

    def __iter__(self) -> Iterator[str]:
        """Iterates over the names of the quantities."""

    def __getitem__(self, key: str, /) -> NDArray[np.float64]:
        """Returns the values of a quantity in a new array with one dimension. A single number has shape (1,).

        Raises `KeyError` for an unknown name.
        """

@final
class Object:
    """A movable object at one moment. `World.objects` returns it.

    >>> from usarsim import Scene, World
    >>> world = World(Scene("hall"))
    >>> football = next(it for it in world.objects if it.name == "football")
    >>> football
    Object("football", position=[0.800, 1.000, -0.110])
    >>> world.put_object("football", position=(0, 0, -0.5))
    >>> world.step()
    >>> football.position.tolist()
    [0.8, 1.0, -0.11]
    """

    @property
    def id(self) -> int:
        """Number of the object in its world."""

    @property
    def name(self) -> str:
        """Name of the object on its map."""

    @property
    def mass(self) -> float:
        """Mass, kg."""

    @property
    def position(self) -> NDArray[np.float64]:
        """Position of its middle in the world: x, y, z, m, shape (3,)."""

    @property
    def orientation(self) -> NDArray[np.float64]:
        """Orientation in the world, a quaternion x, y, z, w, shape (4,)."""

@final
class Batch:
    """Copies of a world that one call steps on many threads, with orders and observations in two arrays.

    Each world is a row. Within a row the robots follow one another in the order of their spawns. A world gives the same
    bits alone and in a batch, with any number of threads.

    >>> import numpy as np
    >>> from usarsim import Batch, Scene, World
    >>> world = World(Scene("rough"))
    >>> robot = world.spawn("KUKA_YouBot", position=(0, 0, 0))
    >>> batch = Batch(world, 3, orders="twist", observations=["position", "wheel_speeds"])
    >>> batch
    Batch(3 worlds, 3 orders, 7 observations each)
    >>> batch.columns
    [(0, 'position', 0, 3), (0, 'wheel_speeds', 3, 7)]
    >>> orders = np.zeros((len(batch), batch.order_width))
    >>> orders[:, 0] = [0.1, 0.2, 0.3]
    >>> observations = batch.step(orders, steps=250)
    >>> observations.shape, bool((np.diff(observations[:, 0]) > 0).all())
    ((3, 7), True)
    >>> batch.reset(np.array([True, False, False])) is observations
    True
    """

    def __new__(
        cls, world: World, count: int, *, orders: _Orders = "wheels", observations: Sequence[str] = ..., threads: int = 0
    ) -> Batch:
        """Creates `count` copies of a world that has all its robots.

        `orders` is the meaning of a row of orders, for each robot:

        - `wheels`: target speed of each driven wheel, rad/s, in the order of `Robot.wheel_names`.
        - `twist`: target velocity of a Mecanum base: forward and right, m/s, clockwise, rad/s.
        - `joints`: target of each joint that is not a wheel, rad or m, in the order of `Robot.joint_names`.
        - `wheels+joints` and `twist+joints`: the one, then the other.

        `observations` are groups of columns, for each robot, by default position, orientation, velocity and
        angular_velocity:

        - `position`: x, y, z of the robot frame in the world, m.
        - `orientation`: its quaternion x, y, z, w.
        - `rotation`: its roll, pitch, yaw, rad.
        - `velocity`: velocity of its origin along the world's axes, m/s, 3 columns.
        - `angular_velocity`: about the world's axes, rad/s, 3 columns.
        - `joint_positions`, `joint_speeds`: those of `Robot.joint_names`, rad or m, rad/s or m/s.
        - `wheel_angles`, `wheel_speeds`: those of `Robot.wheel_names`, rad, rad/s.
        - `objects`: position and quaternion of every movable object, 7 columns each, by their ids.
        - `sensor:NAME`: all quantities of the sensor's last reading; 0 before the first.

        `threads` is 0 for as many as the machine runs at a time, or a number up to 256.

        Raises `TaskError` for an unknown name, a world without robots, a robot that cannot follow such orders, a sensor
        whose readings vary in length, and too many numbers.
        """

    def step(self, orders: NDArray[np.float64], steps: int = 1) -> NDArray[np.float64]:
        """Gives every world its row of orders, advances each by `steps` time steps, and returns the observations.

        `orders` is a float64 array in C order of shape (worlds, `order_width`). The result is `observations`, the same
        array each time: copy what has to outlive the next step. With `steps=0` the world does not advance.

        Raises `TypeError` for another dtype, and `TaskError` for another shape; then nothing happens. Raises `TaskError` if
        worlds do not follow their orders, because a number is not finite, a robot is gone or its battery is flat; then all
        worlds are stepped.
        """

    def reset(self, mask: NDArray[np.bool_] | None = None) -> NDArray[np.float64]:
        """Puts worlds back to the state that they were copied from, and returns the observations, as `step` does.

        `mask` of shape (worlds,) marks the worlds to put back; None marks all.

        Raises `TypeError` for another dtype, and `TaskError` for another length.
        """

    @property
    def observations(self) -> NDArray[np.float64]:
        """Observations after the last step or reset, a row a world. It is one array for the whole life of the batch.

        Numbers of a robot that is gone are NaN.
        """

    @property
    def columns(self) -> list[tuple[int, str, int, int]]:
        """Groups of columns of the observations: number of the robot, name of the group, first column, column after the last."""

    def column(self, name: str, robot: int = 0) -> slice:
        """Returns the columns of a group of observations: `batch.observations[:, batch.column("position")]`.

        Raises `TaskError` for a group or a robot that the batch does not have.
        """

    def world(self, number: int) -> World:
        """Returns a copy of a world, to look at, draw or save it.

        Raises `TaskError` for a number that no world has.
        """

    @property
    def order_width(self) -> int:
        """Number of orders in a row."""

    @property
    def digests(self) -> list[str]:
        """Hashes of the bits of every body, a world each, as `World.digest`."""

    def __len__(self) -> int:
        """Returns the number of worlds."""

@final
class Environments:
    """Environments of one task that one call steps on many threads. `usarsim.gym` and `usarsim.pettingzoo` wrap it.

    Actions are between -1 and 1. Results go into arrays of the caller, a row an environment. Within a row the robots
    follow one another. Environment `i` with the seed `s` has the same bits alone and among others.

    >>> import numpy as np
    >>> from usarsim import Environments
    >>> environments = Environments("YouBotReach", 2)
    >>> environments.count, environments.robots, environments.actions, environments.observations
    (2, 1, 3, 5)
    >>> arrays = observations, rewards, terminated, truncated, successes, last = environments.arrays()
    >>> environments.reset(observations, seeds=[1, 2])
    >>> actions = np.zeros((2, 3), np.float32)
    >>> environments.step(actions, "next_step", *arrays)
    >>> rewards.round(3).tolist(), truncated.tolist()
    ([[-0.008], [-0.008]], [False, False])
    """

    def __new__(cls, task: str, count: int = 1, *, threads: int = 0) -> Environments:
        """Creates environments whose first episodes begin with `reset`, with the seeds 0, 1, 2 and so on.

        `task` is the name of a shipped task, see `tasks()`, or the path of a task.toml. `threads` is 0 for as many as the
        machine runs at a time, or a number up to 256.

        Raises `TaskError` for an unknown task, a mistake in its file, and no or too many environments.
        """

    def reset(
        self,
        observations: NDArray[np.float32],
        seeds: Sequence[int] | None = None,
        mask: NDArray[np.bool_] | None = None,
    ) -> None:
        """Begins episodes and writes their first observations into `observations`, see `arrays`.

        `mask` of shape (count,) marks the environments; None marks all. Rows of others stay as they are. `seeds` has one seed
        an environment and begins the random numbers anew; without it they go on.

        Raises `TypeError` for another dtype, and `TaskError` for another shape; then nothing happens.
        """

    def step(
        self,
        actions: NDArray[np.float32],
        autoreset: _Autoreset,
        observations: NDArray[np.float32],
        rewards: NDArray[np.float64],
        terminated: NDArray[np.bool_],
        truncated: NDArray[np.bool_],
        successes: NDArray[np.bool_],
        last_observations: NDArray[np.float32],
    ) -> None:
        """Plays one control interval in every environment, and writes the results into the arrays, see `arrays`.

        `actions` is a float32 array in C order of shape (count, `robots` x `actions`). Actions beyond -1 to 1 count as these.
        `autoreset` says when an environment whose episode has ended begins the next one:

        - `next_step`: in the next step, whose action has no effect and whose reward is 0.
        - `same_step`: at once. `observations` gets the first ones of the new episode, and `last_observations` the last ones
          of the old episode.
        - `disabled`: when it is reset. Until then its steps change nothing, and its rewards are 0.

        Raises `TypeError` for another dtype, or an array that is given twice. Raises `TaskError` for another shape, an
        unknown mode, and an action that is not finite; then nothing happens.
        """

    def picture(self, environment: int = 0, size: _Size = ...) -> Picture:
        """Draws the world of an environment: an array of rows, columns and colours (uint8).

        `size` is width and height, 16 to 8192 pixels each, by default 480 x 320.

        Raises `TaskError` for an environment that does not exist, and `CommandError` for a size out of range.
        """

    @property
    def count(self) -> int:
        """Number of environments."""

    @property
    def name(self) -> str:
        """Name of the task."""

    @property
    def description(self) -> str:
        """Description of the task in one sentence."""

    @property
    def robots(self) -> int:
        """Number of robots in an environment."""

    @property
    def actions(self) -> int:
        """Number of actions of a robot."""

    @property
    def observations(self) -> int:
        """Number of observations of a robot."""

    @property
    def control_interval(self) -> float:
        """Time between two actions, s."""

    @property
    def horizon(self) -> int:
        """Number of actions until an episode is cut off."""

    @property
    def digests(self) -> list[str]:
        """Hashes of the bits of every body, an environment each, as `World.digest`."""

    def arrays(
        self,
    ) -> tuple[
        NDArray[np.float32],
        NDArray[np.float64],
        NDArray[np.bool_],
        NDArray[np.bool_],
        NDArray[np.bool_],
        NDArray[np.float32],
    ]:
        """Returns new arrays of zeros for `step`, in the order of its arguments:

        - observations, shape (count, `robots` x `observations`).
        - rewards, shape (count, `robots`).
        - terminated, shape (count,): True if the goal was reached, or can no longer be reached.
        - truncated, shape (count,): True if the time of the episode was up.
        - successes, shape (count,): True if the goal was reached.
        - last observations, as observations. Only the mode `same_step` writes them, in rows whose episode ended.
        """

class Error(Exception):
    """An error of usarsim. Its text says what is wrong, where, and what is expected."""

class SceneError(Error):
    """A map, a robot, an override or equipment does not load."""

class CommandError(Error):
    """A robot cannot do what it was told."""

class SaveError(Error):
    """A world cannot be saved, or go on from a saved state."""

class LogError(Error):
    """A log cannot be written, read or replayed."""

class TaskError(Error):
    """A task, a batch, an experiment or a fit cannot run."""

class UsarsimWarning(UserWarning):
    """Something was done in another way than asked for."""

def maps() -> list[str]:
    """Returns the names of the shipped maps.

    >>> import usarsim
    >>> "rough" in usarsim.maps()
    True
    """

def scenarios() -> list[str]:
    """Returns the names of the shipped scenarios.

    >>> import usarsim
    >>> "stairs" in usarsim.scenarios()
    True
    """

def robots() -> list[str]:
    """Returns the names of the shipped robot classes.

    >>> import usarsim
    >>> "P3AT" in usarsim.robots()
    True
    """

def tasks() -> list[str]:
    """Returns the names of the shipped tasks.

    A robot observes points in its own frame (forward and right, m) and its velocities (forward and right, m/s, clockwise,
    rad/s). Rewards of the tasks, by their goals:

    - Reach: the distance that the robot came nearer to a point, m, minus 0.2 a second, and 1 on arrival.
    - Follow: the distance that it came along a path, m, minus its distance beside the path, m, times the time, s, and 1 at
      the end.
    - Push: the distance that an object came nearer to a point, m, a tenth of the distance that the robots came nearer to
      the object, and 1 when the object is there.
    - Fetch: the distance that the gripper came nearer to the object, the height that the object rose, the distance that it
      came nearer to a point, m, and 1 when it is there.
    - Explore: the area that the robot is the first to see with its laser, m².

    >>> import usarsim
    >>> usarsim.tasks()
    ['P3ATExplore', 'P3ATTeamExplore', 'YouBotFetch', 'YouBotFollow', 'YouBotPush', 'YouBotReach']
    """

def main(arguments: Sequence[str]) -> int:
    """Runs the program `usarsim` and returns its exit code. `arguments` begin with the name of the program.

    Help and wrong arguments end the process. `python -m usarsim` calls it.
    """

def _png(picture: NDArray[np.uint8]) -> bytes:
    """Returns an array of rows, columns and colours as a PNG file. `usarsim.Picture.to_png` calls it.

    Raises `CommandError` for another shape.
    """

def _replay(path: _Path) -> str:
    """Replays a log and compares. Returns JSON, which `usarsim.replay` reads. Raises `LogError` if it cannot be read."""

def _validate(
    robot: str,
    *,
    drive_model: str | None = None,
    set: Sequence[str] = ...,
    checks: Sequence[int] | None = None,
    seconds: float = 20.0,
    time_step: float = 0.002,
) -> str:
    """Runs the physical checks of a robot on wheels. Returns JSON, which `usarsim.validate` reads.

    Raises `SceneError` if the robot does not load, and `TaskError` for numbers out of range or a check that it does not have.
    """

def _run_experiment(file: _Path, out: _Path, *, jobs: int) -> str:
    """Runs an experiment file into a folder. Returns the outcomes as JSON, which `usarsim.run_experiment` reads.

    Raises `TaskError` if the file, the folder or a run has a mistake.
    """

def _fit(file: _Path, *, drive_model: str | None = None, jobs: int) -> str:
    """Fits parameters of a robot to measured steps. Returns JSON, which `usarsim.fit` reads.

    Raises `TaskError` if a file has a mistake, and `SceneError` for an unknown drive model.
    """

def _sweep_batches(file: _Path, text: str, batch_size: int, out: _Path) -> tuple[int, int, list[int]]:
    """Opens the folder of a sweep. Returns the numbers of runs and of batches, and the batches that are not done.

    Raises `TaskError` if the experiment has a mistake, or the folder has other contents.
    """

def _sweep_batch(file: _Path, text: str, batch_size: int, out: _Path, batch: int) -> int:
    """Does a batch of a sweep and writes its part. Returns the number of its runs.

    Raises `TaskError` if there is no such batch, a run fails, or the part cannot be written.
    """

def _finish_sweep(file: _Path, text: str, batch_size: int, out: _Path) -> int:
    """Joins the parts of a sweep: table, plots and report. Returns the number of plots.

    Raises `TaskError` if a part is missing or damaged, or a file cannot be written.
    """
