from client import Robot, limited


def drive(robot, steer, speed=3.0):
    robot.drive(Speed=speed, FrontSteer=limited(steer, 0.5), RearSteer=0)
    robot.wait()


def solve(port):
    robot = Robot(port, "Hummer")
    # The smallest circle has a radius of some 6.3 m.
    while robot.x < 5.0:
        drive(robot, -0.2 * robot.y - robot.heading)
    while robot.heading < 1.3:
        drive(robot, 0.5)
    while robot.y < 7.3:
        drive(robot, 2 * robot.bearing(10.0, 11.0))
    robot.drive(Speed=0, FrontSteer=0, RearSteer=0)
    robot.wait(2.0)
    return robot
