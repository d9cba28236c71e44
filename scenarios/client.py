"""A robot of a scenario, driven over the wire: what a controller in Python needs, and no more."""

import math
import re
import socket

TRUTH = re.compile(r"^SEN \{Time ([-\d.]+)\}.*\{Type GroundTruth\}.*\{Location ([-\d.,]+)\} \{Orientation ([-\d.,]+)\}")


class Robot:
    """A robot in the world. Lengths in m, angles in rad, with x forward, y right, z down; a heading turns to the right."""

    def __init__(self, port, robot_class, name=None):
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.lines = self.socket.makefile(encoding="utf-8", errors="replace")
        # The server then says what is wrong with a line.
        self.send("REPORT {Errors true}")
        self.send(f"INIT {{ClassName USARBot.{robot_class}}} {{Name {name or robot_class}}}")
        self.wait()

    def send(self, line):
        self.socket.sendall(f"{line}\r\n".encode())

    def drive(self, **values):
        """Sends DRIVE: `drive(Left=1, Right=1)`."""
        self.send("DRIVE " + " ".join(f"{{{key} {value:.4f}}}" for key, value in values.items()))

    def wait(self, seconds=0.0):
        """Reads until the pose has come that the robot has after some simulated seconds: the next one at least."""
        end = None
        for line in self.lines:
            if line.startswith("NFO {Error"):
                raise ValueError(line.strip())
            found = TRUTH.search(line)
            if not found:
                continue
            self.time = float(found[1])
            self.x, self.y, self.z = (float(number) for number in found[2].split(","))
            self.heading = wrapped(float(found[3].split(",")[2]))
            end = self.time + seconds if end is None else end
            if self.time >= end:
                return
        raise ConnectionError("the server has closed the connection")

    def distance(self, x, y):
        return math.hypot(x - self.x, y - self.y)

    def bearing(self, x, y):
        """The direction of a point in the robot's frame: 0 ahead, positive to the right."""
        return wrapped(math.atan2(y - self.y, x - self.x) - self.heading)

    def own(self, x, y):
        """A point in the robot's frame: ahead and to the right."""
        far, bearing = self.distance(x, y), self.bearing(x, y)
        return far * math.cos(bearing), far * math.sin(bearing)


def wrapped(angle):
    """The same direction from -pi to pi."""
    return math.atan2(math.sin(angle), math.cos(angle))


def limited(value, most):
    return max(-most, min(most, value))


def go_skid(robot, x, y, speed=4.0, near=0.15, then_stop=True):
    """Drives a robot with wheels at its sides to a point. `speed` is that of its wheels, rad/s."""
    while robot.distance(x, y) > near:
        bearing = robot.bearing(x, y)
        ahead = speed * max(0.0, math.cos(bearing)) ** 3
        turn = limited(3 * speed * bearing, speed)
        robot.drive(Left=limited(ahead + turn, speed), Right=limited(ahead - turn, speed))
        robot.wait()
    if then_stop:
        robot.drive(Left=0, Right=0)


def go_omni(robot, x, y, heading=0.0, speed=0.5, near=0.03):
    """Drives a robot with Mecanum wheels to a point, with a heading of its own."""
    while robot.distance(x, y) > near:
        ahead, right = robot.own(x, y)
        far = math.hypot(ahead, right)
        now = min(speed, 0.8 * far + 0.05)
        turn = limited(1.5 * wrapped(heading - robot.heading), 0.5)
        robot.drive(LinearVelocity=now * ahead / far, LateralVelocity=now * right / far, RotationalVelocity=turn)
        robot.wait()
    robot.drive(LinearVelocity=0, LateralVelocity=0, RotationalVelocity=0)
