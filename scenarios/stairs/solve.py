from client import Robot


def solve(port):
    robot = Robot(port, "Kenaf")
    for joint, angle in [("FLFlipper", -0.6), ("FRFlipper", -0.6)]:
        robot.send(f"SET {{Type Joint}} {{Name {joint}}} {{Opcode Angle}} {{Params {angle}}}")
    robot.wait(1.5)
    while robot.x < 6.4:
        turn = -1.5 * (robot.heading - 0.4 * (-5.3 - robot.y))
        robot.drive(Left=3 + turn, Right=3 - turn)
        robot.wait()
    robot.drive(Left=0, Right=0)
    robot.wait(1.5)
    return robot
