import math

from client import Robot, limited


def fly(robot, x, y, z, near=0.15):
    while math.hypot(robot.distance(x, y), z - robot.z) > near:
        ahead, right = robot.own(x, y)
        robot.drive(
            AltitudeVelocity=limited(robot.z - z, 0.8),
            LinearVelocity=limited(0.8 * ahead, 1.0),
            LateralVelocity=limited(0.8 * right, 1.0),
            RotationalVelocity=limited(-robot.heading, 0.5),
        )
        robot.wait()


def solve(port):
    robot = Robot(port, "AirRobot")
    for x, y, height in [(1.0, 0.0, 0.9), (3.0, 1.0, 1.8), (5.0, -0.5, 1.3)]:
        fly(robot, x - 0.7, y, -height)
        fly(robot, x + 0.7, y, -height)
    fly(robot, 7.0, 0.0, -0.6)
    fly(robot, 7.0, 0.0, -0.25)
    robot.drive(AltitudeVelocity=-0.2, LinearVelocity=0, LateralVelocity=0, RotationalVelocity=0)
    robot.wait(3.0)
    return robot
