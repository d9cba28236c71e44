import math

from client import Robot, go_omni

# Distance of the cube from the robot's middle, ahead, when it is gripped, m.
AHEAD = 0.4
# Height of the shoulder above the floor, m; then the lengths of upper arm, forearm and hand.
SHOULDER, UPPER, LOWER, HAND = 0.241, 0.155, 0.135, 0.209


def to_height(robot, height, seconds):
    """Moves the hand, which points down, to a height above the floor at the distance of the cube."""
    ahead, up = AHEAD - 0.2, height + HAND - SHOULDER
    distance, slope = math.hypot(ahead, up), math.atan2(up, ahead)
    lift = math.acos((distance**2 + UPPER**2 - LOWER**2) / (2 * distance * UPPER))
    shoulder = math.pi / 2 - slope - lift
    forearm = math.atan2(ahead - UPPER * math.sin(shoulder), up - UPPER * math.cos(shoulder))
    angles = [shoulder, forearm - shoulder, math.pi - forearm]
    robot.send("ACT {Name arm} " + " ".join(f"{{Link {link}}} {{Value {angle:.4f}}}" for link, angle in enumerate(angles, 1)))
    robot.wait(seconds)


def solve(port):
    robot = Robot(port, "YouBotArm")
    robot.send("SET {Type Gripper} {Name Gripper} {Opcode Open}")
    go_omni(robot, -0.5 - AHEAD, -1.5, near=0.01)
    for height in [0.2, 0.12, 0.06, 0.03]:
        to_height(robot, height, 1.5)
    robot.send("ACT {Name Gripper} {Gripper 1}")
    robot.wait(1.0)
    to_height(robot, 0.15, 2.0)
    go_omni(robot, -0.5 - AHEAD, -0.5, speed=0.2, near=0.02)
    robot.wait(0.5)
    to_height(robot, 0.115, 1.5)
    robot.send("ACT {Name Gripper} {Gripper 0}")
    robot.wait(1.0)
    to_height(robot, 0.2, 2.0)
    return robot
