from client import Robot, go_skid


def solve(port):
    robot = Robot(port, "P3AT")
    go_skid(robot, -6.3, 4.4, speed=6)
    robot.wait(1.5)
    for x, y in [(-6.0, 0.6), (-4.6, 0.0), (-1.8, 0.0), (-1.8, 1.4), (-2.9, 1.6), (-3.0, 2.8)]:
        go_skid(robot, x, y, speed=6, then_stop=False)
    robot.drive(Left=0, Right=0)
    robot.wait(1.5)
    for x, y in [(-2.9, 1.6), (-1.8, 1.3), (-1.8, 0.1), (0.1, 0.2), (0.45, -0.1), (0.45, -0.7)]:
        go_skid(robot, x, y, speed=5, near=0.1, then_stop=False)
    robot.drive(Left=0, Right=0)
    robot.wait(1.5)
    return robot
