from client import Robot, go_omni


def solve(port):
    robot = Robot(port, "YouBot")
    side = 1.05
    for x in [0.6, 1.5, 2.4, 3.3]:
        go_omni(robot, x - 0.45, side, near=0.06)
        go_omni(robot, x + 0.45, side, near=0.06)
        side = -side
    return robot
