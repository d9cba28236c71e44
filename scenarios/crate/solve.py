from client import Robot


def solve(port):
    robots = [Robot(port, "P3AT", "Left"), Robot(port, "P3AT", "Right")]
    while max(robot.x for robot in robots) < 1.4:
        behind = robots[0].x - robots[1].x
        for robot, ahead in zip(robots, [behind, -behind]):
            speed = 3 - max(-1.0, min(1.0, 6 * ahead))
            robot.drive(Left=speed - 2 * robot.heading, Right=speed + 2 * robot.heading)
            robot.wait()
    for robot in robots:
        robot.drive(Left=0, Right=0)
        robot.wait(0.5)
    return robots
