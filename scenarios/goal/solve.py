from client import Robot, limited, wrapped

# A gain so low, 1/s, that poses which come late do no harm.
GAIN = 1.5
# Radius of the wheels and half their distance, m.
RADIUS, HALF_TRACK = 0.03, 0.078


def turn(robot, heading):
    while abs(error := wrapped(heading - robot.heading)) > 0.01:
        wheels = limited(GAIN * error, 2.0) * HALF_TRACK / RADIUS
        robot.drive(Left=wheels, Right=-wheels)
        robot.wait()


def go(robot, x, y):
    """Drives straight to a point ahead."""
    while (ahead := robot.own(x, y)[0]) > 0.01:
        wheels = limited(GAIN * ahead + 0.01, 0.4) / RADIUS
        robot.drive(Left=wheels, Right=wheels)
        robot.wait()


def solve(port):
    robot = Robot(port, "SoccerRobot")
    # To a place behind the ball, on its line to the middle of the goal.
    behind = (-0.3, 0.0)
    turn(robot, robot.heading + robot.bearing(*behind))
    go(robot, *behind)
    turn(robot, 0.0)
    # Its flat front pushes the ball straight ahead, as long as it does not turn.
    robot.drive(Left=17, Right=17)
    while robot.x < 4.2:
        robot.wait()
    robot.drive(Left=0, Right=0)
    robot.wait(1.0)
    return robot
