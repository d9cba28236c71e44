from client import Robot, go_skid


def solve(port):
    robot = Robot(port, "SoccerRobot")
    go_skid(robot, -0.4, 0.0, speed=10, near=0.03)
    go_skid(robot, 3.9, 0.0, speed=16, near=0.2)
    robot.wait(4.0)
    return robot
