import math

from client import Robot


def solve(port):
    robot = Robot(port, "KUKA_YouBot")
    while abs(2.0 - robot.y) > 0.01:
        far = 2.0 - robot.y
        wheel = math.copysign(min(6.0, 8 * abs(far) + 0.3), far)
        turn = 4 * robot.heading
        ahead = -8 * robot.x
        front_left, front_right = ahead + wheel - turn, ahead - wheel + turn
        back_left, back_right = ahead - wheel - turn, ahead + wheel + turn
        robot.send(f"DRIVE {{Front-Left {front_left:.3f}}} {{Front-Right {front_right:.3f}}} {{Back-Left {back_left:.3f}}} {{Back-Right {back_right:.3f}}}")
        robot.wait()
    robot.send("DRIVE {Front-Left 0} {Front-Right 0} {Back-Left 0} {Back-Right 0}")
    robot.wait(2.0)
    return robot
