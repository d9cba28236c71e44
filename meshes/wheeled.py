"""Further robots on wheels: iRobot ATRV, KURT2, Zerg, Kiva, TurtleBot 2. Outlines as in robot.toml, looks from memory."""

import math

from parts import add_antenna, add_camera, hokuyo, kinect, sick, sick_yellow, wheel
from solids import *


def atrv(s, sonar, deck):
    """A red tub between four large wheels, with sonars around; `s` is its size beside an ATRV, `deck` the z of its top."""
    mesh = Mesh()
    low, wide = deck + 0.36 * s, 0.25 * s
    mesh.add(
        sections(
            [
                (-0.51 * s, 0.70 * wide, deck + 0.10 * s, low - 0.10 * s),
                (-0.44 * s, wide, deck + 0.01 * s, low),
                (0.44 * s, wide, deck + 0.01 * s, low),
                (0.51 * s, 0.70 * wide, deck + 0.10 * s, low - 0.10 * s),
            ],
            0.03 * s,
        ),
        RED,
    )
    mesh.add(
        sections([(-0.47 * s, 0.98 * wide, deck, deck + 0.05 * s), (0.47 * s, 0.98 * wide, deck, deck + 0.05 * s)], 0.015 * s), RED
    )
    mesh.add(prism(rounded(0.66 * s, 0.40 * s, 0.04 * s, 2), deck - 0.006 * s, deck + 0.02 * s), BLACK)
    mesh.add_pair(box(0.80 * s, 0.006, 0.055 * s), BLACK, (0, wide, sonar)).add_pair(
        box(0.16 * s, 0.008, 0.03 * s), LIGHT, (0.0, wide + 0.002, deck + 0.06 * s)
    )
    for i in range(6):
        mesh.add_pair(rod(0.019 * s, 0, 0.012 * s, 8), GOLD, ((-0.30 + 0.12 * i) * s, wide, sonar), (-math.pi / 2, 0, 0))
    for end in (-1, 1):
        for y in (-0.12, -0.04, 0.04, 0.12):
            mesh.add(rod(0.019 * s, 0, 0.014 * s, 8), GOLD, (end * 0.508 * s, y * s, sonar), (0, end * math.pi / 2, 0))
        bumper = [(end * x * s, y * s, low - 0.13 * s) for x, y in ((0.47, -0.24), (0.545, -0.18), (0.545, 0.18), (0.47, 0.24))]
        mesh.add(tube(bumper, 0.024 * s, 6), BLACK)
        mesh.add_pair(rod(0.030 * s, 0, -0.022 * s, 8), YELLOW, (end * 0.40 * s, 0.20 * s, deck))  # emergency stops
        mesh.add_pair(rod(0.021 * s, -0.022 * s, -0.045 * s, 8), RED_LAMP, (end * 0.40 * s, 0.20 * s, deck))
    for y in (-0.19, 0.19):  # rails to lift it by
        mesh.add(
            tube(
                [
                    (-0.28 * s, y * s, deck),
                    (-0.28 * s, y * s, deck - 0.05 * s),
                    (0.28 * s, y * s, deck - 0.05 * s),
                    (0.28 * s, y * s, deck),
                ],
                0.010 * s,
                6,
            ),
            METAL,
        )
    for x in (-1, 1):
        mesh.add(rod(0.035 * s, -1.30 * wide, 1.30 * wide, 8), DARK, (x * 0.30 * s, 0, 0), Y)
    eye = (0.135 * s, 0, deck - 0.27 * s)
    add_camera(mesh, eye, 0.09 * s)
    mesh.add(rod(0.016 * s, deck, eye[2] + 0.06 * s, 8), DARK, (eye[0] - 0.068 * s, 0, 0))
    return add_antenna(mesh, (-0.33 * s, 0.12 * s, deck), 0.45 * s, 0.008 * s)


def kurt():
    """A box of aluminium over six wheels, with a case of yellow for the laser."""
    mesh = Mesh().add(prism(rounded(0.43, 0.245, 0.012, 1), -0.138, 0.018, 0.006), LIGHT)
    mesh.add(prism(rounded(0.44, 0.255, 0.012, 1), -0.152, -0.136, 0.004), DARK)
    for z in (-0.10, -0.05):
        mesh.add_pair(box(0.42, 0.004, 0.008), METAL, (0, 0.1225, z))
    mesh.add_pair(box(0.14, 0.004, 0.026), RED, (0.0, 0.123, -0.075))
    for end in (-1, 1):
        mesh.add(box(0.008, 0.20, 0.07), DARK, (end * 0.216, 0, -0.045)).add_pair(
            rod(0.016, 0, 0.008, 8), GOLD, (end * 0.214, 0.055, -0.10), (0, end * math.pi / 2, 0)
        )
    mesh.add(tube([(-0.20, -0.105, -0.15), (-0.20, -0.105, -0.27), (-0.20, 0.105, -0.27), (-0.20, 0.105, -0.15)], 0.008), METAL)
    mesh.add(box(0.13, 0.16, 0.006), BLACK, (-0.11, 0, -0.155)).add(box(0.09, 0.03, 0.02), GREY, (-0.11, 0.06, -0.165))
    for x in (-0.22, 0, 0.22):
        mesh.add(rod(0.014, -0.15, 0.15, 8), METAL, (x, 0, 0), Y)
    mesh.add(rod(0.009, -0.15, -0.33, 8), METAL, (0.058, 0, 0))
    add_camera(mesh, (0.10, 0.0, -0.355), 0.055)
    return add_antenna(mesh, (-0.17, 0.09, -0.152), 0.22, 0.004)


def zerg():
    """A small yellow hull with a deck of plates for computer and laser."""
    mesh = Mesh().add(
        sections(
            [(-0.15, 0.06, -0.055, -0.005), (-0.125, 0.092, -0.07, 0.012), (0.11, 0.092, -0.07, 0.012), (0.15, 0.065, -0.045, 0.0)],
            0.012,
        ),
        YELLOW,
    )
    mesh.add(prism(rounded(0.24, 0.165, 0.02, 1), -0.078, -0.066, 0.004), BLACK)
    for x in (-0.09, 0.055):
        mesh.add_pair(rod(0.005, -0.078, -0.112, 6), METAL, (x, 0.065, 0))
    mesh.add(prism(rounded(0.19, 0.155, 0.015, 1), -0.117, -0.111), (0.55, 0.60, 0.62), (-0.02, 0, 0)).add(
        box(0.11, 0.11, 0.028), (0.16, 0.36, 0.20), (-0.05, 0, -0.094)
    )
    mesh.add(rod(0.014, -0.10, 0.10, 8), DARK, (0.08, 0, 0), Y).add(rod(0.014, -0.10, 0.10, 8), DARK, (-0.08, 0, 0), Y)
    mesh.add(box(0.03, 0.03, 0.05), DARK, (0.08, 0, -0.09)).add_pair(rod(0.010, 0, 0.006, 8), LAMP, (0.142, 0.04, -0.025), X)
    mesh.add(box(0.03, 0.05, 0.026), BLACK, (0.02, 0, -0.135)).add(rod(0.009, 0, 0.02, 8), GLASS, (0.022, 0, -0.138), X)
    mesh.add_pair(box(0.10, 0.003, 0.02), BLACK, (-0.01, 0.092, -0.045))
    return add_antenna(mesh, (-0.105, 0.055, -0.117), 0.20, 0.0035)


def kiva():
    """An orange shell with black bumpers, low enough for shelves, and the screw under its plate."""
    mesh = Mesh().add(prism(rounded(0.90, 0.585, 0.09, 3), -0.03, 0.195, 0.035), ORANGE)
    mesh.add(prism(rounded(0.955, 0.56, 0.10, 3), 0.085, 0.175), BLACK).add(prism(rounded(0.94, 0.55, 0.09, 2), 0.19, 0.215), DARK)
    mesh.add(prism(rounded(0.58, 0.46, 0.06, 2), -0.048, -0.028, 0.008), DARK)
    mesh.add(rod(0.19, -0.045, -0.075, 24), GREY)
    for i in range(3):
        mesh.add(rod(0.150, -0.08 - 0.04 * i, -0.10 - 0.04 * i, 20), METAL).add(
            rod(0.138, -0.06 - 0.04 * i, -0.08 - 0.04 * i, 16), DARK
        )
    mesh.add(rod(0.10, -0.18, -0.212, 16), GREY)
    for end in (-1, 1):
        mesh.add(box(0.006, 0.30, 0.045), GLASS, (end * 0.476, 0, 0.13)).add_pair(
            box(0.008, 0.05, 0.03), LAMP if end > 0 else RED_LAMP, (end * 0.476, 0.20, 0.13)
        )
        mesh.add(rod(0.058, 0.19, 0.215, 12), METAL, (end * 0.432, 0, 0))
    mesh.add_pair(box(0.22, 0.006, 0.07), BLACK, (0, 0.2925, 0.09)).add_pair(
        rod(0.026, 0, 0.01, 10), RED_LAMP, (-0.36, 0.20, -0.03), (math.pi, 0, 0)
    )
    mesh.add_pair(prism([(0.05, 0.0), (0.0, 0.028), (0.0, -0.028)], -0.002, 0.002), YELLOW, (0.33, 0.15, -0.031))
    mesh.add(box(0.04, 0.06, 0.18), DARK, (0.43, 0, -0.115)).add(box(0.13, 0.12, 0.012), DARK, (0.44, 0, -0.19))
    return mesh


def turtlebot():
    """A round Kobuki with three plates on posts over it."""
    mesh = Mesh().add(turned([(0.012, 0.135), (-0.038, 0.177), (-0.052, 0.172), (-0.062, 0.150)], 20), BLACK)
    mesh.add(turned([(-0.004, 0.1785), (-0.030, 0.1785)], 20), DARK)  # bumper
    mesh.add(turned([(-0.058, 0.157), (-0.066, 0.148), (-0.066, 0.02)], 20), (0.30, 0.31, 0.33))
    mesh.add(box(0.012, 0.075, 0.012), (0.75, 0.76, 0.78), (-0.162, 0, -0.04))
    for i in range(3):
        mesh.add(rod(0.009, -0.066, -0.0685, 8), LIGHT, (-0.128, -0.035 + 0.035 * i, 0))
    mesh.add(rod(0.004, -0.066, -0.069, 6), (0.2, 0.85, 0.3), (-0.128, 0.055, 0))
    for z in (-0.125, -0.187, -0.392):
        cut = [(0.163 * math.cos(a), 0.163 * math.sin(a)) for a in angles(16)]
        mesh.add(prism([(min(x, 0.14), y) for x, y in cut], z - 0.003, z + 0.003), BLACK)
    for x, y in ((0.10, 0.115), (-0.112, 0.10)):
        mesh.add_pair(rod(0.0065, -0.060, -0.185, 6), METAL, (x, y, 0)).add_pair(rod(0.0065, -0.187, -0.392, 6), METAL, (x, y, 0))
        mesh.add_pair(rod(0.011, -0.395, -0.400, 6), GREY, (x, y, 0))
    mesh.add(box(0.05, 0.10, 0.05), DARK, (-0.08, 0, -0.214))  # under the Kinect
    mesh.add(box(0.20, 0.23, 0.014), (0.62, 0.63, 0.65), (-0.02, 0, -0.137)).add(
        box(0.20, 0.23, 0.006), DARK, (-0.02, 0, -0.147)
    )  # a laptop, shut
    for x in (0.115, -0.135):
        mesh.add(box(0.02, 0.012, 0.02), DARK, (x, 0, 0.010))
    return mesh


def soccer():
    """A drum of RoboCup's small-size league, with a kicker ahead and the pattern of its team on top."""
    drum = [(0.088 * math.cos(a), 0.088 * math.sin(a)) for a in angles(20)]
    ahead = [(min(x, 0.073), y) for x, y in drum]
    mesh = Mesh().add(prism([(x, max(min(y, 0.069), -0.069)) for x, y in ahead], -0.04, 0.012), DARK)
    mesh.add(prism(ahead, -0.094, -0.034), BLACK).add(prism(ahead, -0.098, -0.093), (0.24, 0.25, 0.27))
    mesh.add(rod(0.025, -0.097, -0.1, 16), (0.10, 0.25, 0.85))
    for x, y, colour in (
        (0.038, 0.045, (0.95, 0.25, 0.6)),
        (0.038, -0.045, (0.2, 0.8, 0.3)),
        (-0.045, 0.032, (0.95, 0.25, 0.6)),
        (-0.045, -0.032, (0.95, 0.25, 0.6)),
    ):
        mesh.add(rod(0.017, -0.097, -0.1, 12), colour, (x, y, 0))
    mesh.add(box(0.006, 0.07, 0.022), METAL, (0.075, 0, 0.0)).add(rod(0.006, -0.034, 0.034, 8), ORANGE, (0.081, 0, -0.024), Y)
    mesh.add_pair(box(0.018, 0.005, 0.024), METAL, (0.075, 0.037, -0.022))
    return mesh.add(box(0.012, 0.024, 0.02), GREY, (0.071, 0, -0.078)).add(rod(0.006, 0, 0.008, 8), GLASS, (0.074, 0, -0.08), X)


SICK = {"sick.glb": sick}
FILES = {
    "robots/SoccerRobot": {"body.glb": soccer, "wheel.glb": lambda: wheel(0.03, 0.015, 0.02, 0, 5, METAL)},
    "robots/ATRV": {"body.glb": lambda: atrv(1.0, -0.26, -0.375), "wheel.glb": lambda: wheel(0.2, 0.12, 0.105, 12)} | SICK,
    "robots/ATRV2": {"body.glb": lambda: atrv(1.0, -0.26, -0.375), "wheel.glb": lambda: wheel(0.2, 0.12, 0.105, 12)} | SICK,
    "robots/ATRVJr": {"body.glb": lambda: atrv(0.74, -0.20, -0.296), "wheel.glb": lambda: wheel(0.16, 0.1, 0.085, 12)} | SICK,
    "robots/KURT2D": {"body.glb": kurt, "sick.glb": sick_yellow, "wheel.glb": lambda: wheel(0.08, 0.05, 0.05, 0, 5)},
    "robots/Zerg": {"body.glb": zerg, "hokuyo.glb": hokuyo, "wheel.glb": lambda: wheel(0.06, 0.04, 0.035, 8)},
    "robots/Kiva4Wheel": {"body.glb": kiva, "wheel.glb": lambda: wheel(0.098, 0.05, 0.06, 0, 5, GREY)} | SICK,
    "robots/turtlebot_with_sensors": {
        "body.glb": turtlebot,
        "kinect.glb": kinect,
        "hokuyo.glb": hokuyo,
        "wheel.glb": lambda: wheel(0.035, 0.02, 0.022, 0, 5, GREY),
    },
}
