"""Robots that fly or dive."""

import math

from parts import propeller
from solids import *

# AirRobot AR100: four rotors in a ring of carbon fibre around a round pod, from memory. Its propellers turn and are meshes of their own.

ROTORS = [(0.17, 0.175), (-0.2167, 0.175), (-0.2167, -0.211), (0.17, -0.211)]
POD = (-0.023, -0.018)


def airrobot():
    mesh = Mesh()
    path = []
    for quarter, (x, y) in enumerate(ROTORS):
        for step in range(7):
            path.append((x, y, math.pi / 2 * (quarter + step / 6)))
    section = [(r * math.cos(a), r * math.sin(a)) for a, r in zip(angles(6), [0.010] * 6)]
    rings = [
        [(x + (0.146 + out) * math.cos(a), y + (0.146 + out) * math.sin(a), -0.01 + up) for out, up in section] for x, y, a in path
    ]
    mesh.add(loft(rings, closed=True), DARK)
    for x, y in ROTORS:
        dx, dy = x - POD[0], y - POD[1]
        angle, length = math.atan2(dy, dx), math.hypot(dx, dy)
        reach = length + 0.137  # the arm goes on to the ring
        middle = (POD[0] + reach / 2 * math.cos(angle), POD[1] + reach / 2 * math.sin(angle), 0.004)
        mesh.add(box(reach, 0.018, 0.012), BLACK, middle, (0, 0, angle))
        mesh.add(rod(0.02, 0.012, -0.018, 12), GREY, (x, y, 0))
        mesh.add(rod(0.012, -0.018, -0.034, 10, second=0.005), RED if x > 0 else DARK, (x, y, 0))  # red is ahead
        foot = (POD[0] + 0.42 * dx, POD[1] + 0.42 * dy, 0)  # legs down to what touches the ground
        mesh.add(rod(0.006, 0.006, 0.07, 8, second=0.004), BLACK, foot)
        mesh.add(rod(0.010, 0.066, 0.07, 8), RUBBER, foot)
    dome = [(0.088, 0.012), (0.088, -0.008), (0.078, -0.034), (0.052, -0.054), (0.02, -0.062)]
    mesh.add(turned([(z, r) for r, z in dome], 20), (0.24, 0.25, 0.28), (*POD, 0))
    mesh.add(rod(0.09, 0.0, 0.006, 20), YELLOW, (*POD, 0))  # a band around the pod
    return mesh.add(rod(0.07, 0.011, 0.034, 16, second=0.05), BLACK, (*POD, 0))  # the battery


def tilting_camera():
    """The camera under it, about its axle; it looks ahead."""
    mesh = Mesh().add(box(0.014, 0.05, 0.010), GREY, (-0.022, 0, 0.004)).add_pair(box(0.014, 0.005, 0.045), GREY, (-0.022, 0.0245, 0.026))
    mesh.add(ball(0.021, 12), DARK, (-0.022, 0, 0.048))
    return mesh.add(rod(0.013, -0.022, -0.003, 10), BLACK, (0, 0, 0.05), X).add(rod(0.009, -0.02, -0.002, 8), GLASS, (0, 0, 0.05), X)


# Parrot AR.Drone with its indoor hull, 52 cm wide: rings of foam around four rotors, a cross of carbon tubes, a coloured pod.

DRONE_ROTORS = [(0.13, 0.13), (-0.13, 0.13), (-0.13, -0.13), (0.13, -0.13)]


def ardrone():
    foam, mesh = (0.24, 0.25, 0.27), Mesh()
    mesh.add_at(ring(0.1185, 0.1305, -0.038, 0.012, 20), foam, [(x, y, 0) for x, y in DRONE_ROTORS])
    for turn in (0.25 * math.pi, 0.75 * math.pi):
        mesh.add(box(0.37, 0.012, 0.010), BLACK, (0, 0, -0.004), (0, 0, turn))
    for x, y in DRONE_ROTORS:
        mesh.add(box(0.03, 0.022, 0.012), WHITE, (0.9 * x, 0.9 * y, 0.002), (0, 0, math.atan2(y, x)))
        mesh.add(rod(0.011, 0.010, -0.018, 10), BLACK, (x, y, 0)).add(rod(0.022, -0.014, -0.018, 14), LIGHT, (x, y, 0))
        mesh.add(rod(0.006, 0.01, 0.04, 6), BLACK, (0.95 * x, 0.95 * y, 0)).add(
            rod(0.009, 0.036, 0.042, 6), RUBBER, (0.95 * x, 0.95 * y, 0)
        )
    # Foam between the rings, and the pod over it.
    mesh.add(
        sections(
            [
                (-0.16, 0.020, -0.010, 0.012),
                (-0.12, 0.040, -0.022, 0.026),
                (0.10, 0.042, -0.022, 0.026),
                (0.144, 0.026, -0.010, 0.016),
            ],
            0.008,
        ),
        foam,
    )
    mesh.add(
        sections(
            [
                (-0.155, 0.012, -0.026, -0.012),
                (-0.10, 0.036, -0.052, -0.012),
                (0.02, 0.042, -0.060, -0.012),
                (0.11, 0.032, -0.044, -0.012),
                (0.145, 0.014, -0.022, -0.006),
            ],
            0.010,
        ),
        ORANGE,
    )
    mesh.add(sections([(-0.09, 0.012, -0.0545, -0.04), (0.02, 0.018, -0.0625, -0.04), (0.10, 0.012, -0.0495, -0.04)], 0.003), WHITE)
    mesh.add_pair(box(0.20, 0.05, 0.012), foam, (0, 0.06, -0.004))
    mesh.add(rod(0.010, 0.135, 0.148, 10), BLACK, turn=X).add(rod(0.006, 0.135, 0.149, 8), GLASS, turn=X)
    mesh.add_pair(rod(0.011, 0.026, 0.031, 10), METAL, (0.03, 0.018, 0))  # its sonar
    mesh.add_pair(rod(0.005, -0.0, 0.004, 6), (0.2, 0.8, 0.25), (0.245, 0.09, -0.012), X)  # lamps, green ahead and red behind
    return mesh.add_pair(rod(0.005, -0.004, 0.0, 6), RED_LAMP, (-0.245, 0.09, -0.012), X)


# A small research submarine: a yellow hull with a window ahead, a tower, fins and a screw in a ring.


def submarine():
    mesh, band = Mesh(), (0.82, 0.60, 0.08)
    hull = [
        (-0.78, 0.035),
        (-0.74, 0.055),
        (-0.55, 0.13),
        (-0.32, 0.192),
        (-0.30, 0.2),
        (0.45, 0.2),
        (0.58, 0.18),
        (0.64, 0.155),
        (0.665, 0.125),
    ]
    mesh.add(turned(hull, 20), YELLOW, turn=X)
    mesh.add(rod(0.2025, -0.32, -0.29, 20), band, turn=X).add(rod(0.2025, 0.28, 0.31, 20), band, turn=X)
    mesh.add(ball(0.126, 14), GLASS, (0.60, 0, 0)).add(ring(0.112, 0.13, -0.012, 0.014, 18), METAL, (0.665, 0, 0), X)
    tower = [
        [(x + 0.05, y, z) for x, y in rounded(long, wide, 0.45 * wide, 3)]
        for z, long, wide in [(-0.17, 0.42, 0.15), (-0.30, 0.36, 0.12), (-0.32, 0.32, 0.09)]
    ]
    mesh.add(loft(tower), YELLOW).add(rod(0.045, -0.32, -0.335, 14), DARK, (0.06, 0, 0))
    mesh.add_pair(rod(0.025, 0, 0.006, 10), GLASS, (0.06, 0.066, -0.24), (-math.pi / 2, 0, 0))
    mesh.add(rod(0.012, -0.32, -0.50, 8), METAL, (0.13, 0, 0)).add(box(0.05, 0.03, 0.024), METAL, (0.14, 0, -0.505))
    for turn in (0, math.pi / 2, math.pi, 1.5 * math.pi):  # fins
        fin = prism([(-0.68, 0.05), (-0.56, 0.05), (-0.62, 0.26), (-0.70, 0.26)], -0.007, 0.007)
        mesh.add(fin, BLACK, turn=(turn, 0, 0))
    mesh.add(ring(0.150, 0.164, -0.045, 0.045, 24), BLACK, (-0.79, 0, 0), X)
    for turn in (0.25, 0.75, 1.25, 1.75):
        mesh.add(
            box(0.05, 0.008, 0.11), DARK, placed((-0.76, 0, -0.105), (0, 0, 0), (math.pi * turn, 0, 0)), (math.pi * turn, 0, 0)
        )
    for side_ in (-1, 1):  # skids and lamps
        mesh.add(tube([(-0.36, 0.13 * side_, 0.27), (0.36, 0.13 * side_, 0.27), (0.46, 0.13 * side_, 0.21)], 0.014), METAL)
        for x in (-0.25, 0.25):
            mesh.add(tube([(x, 0.10 * side_, 0.15), (x, 0.13 * side_, 0.27)], 0.011), METAL)
        mesh.add(rod(0.035, -0.05, 0.03, 12), DARK, (0.52, 0.17 * side_, 0.10), X)
        mesh.add(rod(0.029, 0.0, 0.034, 12), LAMP, (0.52, 0.17 * side_, 0.10), X)
    return mesh


FILES = {
    "robots/AirRobot": {
        "body.glb": airrobot,
        "right.glb": lambda: propeller(0.133, 0.015, -1),
        "left.glb": lambda: propeller(0.133, 0.015, 1),
    },
    "actuators/AirRobotCameraAct": {"camera.glb": tilting_camera},
    "robots/ARDrone": {
        "body.glb": ardrone,
        "right.glb": lambda: propeller(0.1, 0.012, -1, BLACK),
        "left.glb": lambda: propeller(0.1, 0.012, 1, BLACK),
    },
    "robots/Submarine": {"body.glb": submarine, "screw.glb": lambda: propeller(0.14, 0.055, 1, GOLD, 4)},
}
