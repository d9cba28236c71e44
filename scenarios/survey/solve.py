from client import Robot, go_skid


def solve(port):
    robot = Robot(port, "P3AT")
    way = [(-3.4, 0.3), (0.2, 0.3), (-0.2, 2.8), (1.8, 2.9), (2.0, 1.6), (0.3, 0.2), (0.4, -1.7), (2.9, -1.9), (3.4, -0.2), (4.2, 0.9)]
    for x, y in way:
        go_skid(robot, x, y, speed=6, near=0.25, then_stop=False)
    robot.drive(Left=0, Right=0)
    robot.wait(1.0)
    return robot
