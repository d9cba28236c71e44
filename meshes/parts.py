"""Parts that several robots have."""

import math

from solids import *


def wheel(radius, width, rim, lugs, spokes=5, colour=LIGHT, corners=16):
    """A tyre with lugs on a rim with spokes, about y. Spokes show that it turns."""
    mesh, half, lug = Mesh(), width / 2, 0.035 * radius
    tread = radius - lug if lugs else radius
    side = [(0.86 * half, rim), (half, rim + 0.6 * (tread - rim)), (0.7 * half, tread)]
    mesh.add(lathe(side + [(-y, r) for y, r in side[::-1]], corners), RUBBER)
    pitch = 2 * math.pi / max(lugs, 1)
    for i in range(lugs):
        angle, y = i * pitch, (1 if i % 2 else -1) * 0.3 * half
        place = ((radius - lug) * math.cos(angle), y, (radius - lug) * math.sin(angle))
        block = frustum(
            (-0.28 * pitch * radius, 0.28 * pitch * radius, 0.6 * half),
            (-0.2 * pitch * radius, 0.2 * pitch * radius, 0.5 * half),
            -0.96 * lug,
            0.5 * lug,
        )
        mesh.add(block, RUBBER, place, (0, -angle - math.pi / 2, 0), stands=True)
    mesh.add(rod(rim * 1.02, -0.62 * half, 0.62 * half, corners), DARK, turn=Y)
    for i in range(spokes):
        angle = 2 * math.pi * i / spokes
        place = (0.52 * rim * math.cos(angle), 0, -0.52 * rim * math.sin(angle))
        mesh.add(box(0.98 * rim, 1.56 * half, 0.24 * rim), colour, place, (0, angle, 0))
    return mesh.add(rod(0.3 * rim, -0.86 * half, 0.86 * half, 8), colour, turn=Y)


def sick():
    """SICK LMS 200, 0.156 x 0.155 m as commonly quoted; the origin is in the plane of its beams."""
    outline = rounded(0.155, 0.156, 0.025)
    mesh = Mesh().add(prism(outline, 0.022, 0.12), BLUE)
    mesh.add(prism(outline, -0.063, -0.024, 0.006), BLUE)
    mesh.add(box(0.055, 0.15, 0.05), BLUE, (-0.0495, 0, -0.001))
    window = [[(x, y, z) for x, y in inset(outline, by)] for by, z in [(0.010, 0.022), (0.024, -0.024)]]
    mesh.add(loft(window), BLACK)
    return mesh.add(box(0.004, 0.07, 0.022), LIGHT, (0.0775, 0, 0.046))


def hokuyo():
    """Hokuyo URG-04LX, 50 x 50 x 70 mm as commonly quoted; the origin is in the plane of its beams."""
    mesh = Mesh().add(prism(rounded(0.05, 0.05, 0.006, 2), 0.012, 0.045), DARK)
    mesh.add(rod(0.021, 0.012, -0.012), BLACK).add(rod(0.023, -0.012, -0.025, second=0.019), GREY)
    return mesh.add(box(0.002, 0.028, 0.012), YELLOW, (0.0255, 0, 0.030))


def car_wheel(radius, width, rim, spokes, colour=METAL):
    """A smooth tyre on a rim of a car."""
    return wheel(radius, width, rim, 0, spokes, colour, 20)


def kinect():
    """A Kinect of 28 x 6 cm on its foot; the origin is the middle of the bar."""
    mesh = Mesh().add(prism(rounded(0.06, 0.282, 0.018, 2), -0.019, 0.019, 0.006), BLACK)
    mesh.add(box(0.004, 0.262, 0.026), DARK, (0.0295, 0, 0.001))
    for y, radius in ((-0.088, 0.011), (-0.012, 0.010), (0.016, 0.010)):  # projector, colour and depth
        mesh.add(rod(radius, 0.028, 0.034, 10), GREY, (0, y, 0), X).add(rod(0.6 * radius, 0.03, 0.035, 8), GLASS, (0, y, 0), X)
    mesh.add(box(0.003, 0.012, 0.003), (0.3, 0.8, 0.35), (0.031, -0.055, 0.002))
    mesh.add(rod(0.016, 0.018, 0.032, 10, second=0.024), BLACK)
    return mesh.add(prism(rounded(0.07, 0.075, 0.02, 2), 0.032, 0.040, 0.004), BLACK)


def sick_yellow():
    """A SICK LMS 200 as some robots carry it, with a yellow case."""
    mesh = sick()
    mesh.triangles = {(YELLOW if colour == BLUE else colour): it for colour, it in mesh.triangles.items()}
    return mesh


def add_camera(mesh, at, size=0.05):
    """A camera on a pan and tilt head; `at` is the sensor, just before its lens, which hides nothing from it."""
    lens, y, z = at[0] - 0.22 * size, at[1], at[2]
    x = lens - 0.53 * size
    mesh.add(prism(rounded(1.1 * size, 0.9 * size, 0.25 * size, 2), -0.4 * size, 0.4 * size, 0.1 * size), LIGHT, (x, y, z))
    mesh.add(rod(0.28 * size, 0, 0.18 * size, 10), BLACK, (lens, y, z), X)
    mesh.add(rod(0.18 * size, 0, 0.2 * size, 8), GLASS, (lens, y, z), X)
    mesh.add_pair(box(0.4 * size, 0.12 * size, 0.8 * size), DARK, (x, 0.52 * size, z + 0.25 * size))
    return mesh.add(rod(0.45 * size, 0.55 * size, 0.9 * size, 12), DARK, (x, y, z))


def add_antenna(mesh, at, height, radius=0.006):
    """A whip on a foot."""
    x, y, z = at
    mesh.add(rod(2.6 * radius, 0, -4 * radius, 8, second=1.8 * radius), BLACK, at)
    return mesh.add(rod(radius, -4 * radius, -height, 6, second=0.5 * radius), BLACK, (x, y, z))


def add_rollers(mesh, rollers, y, width, colour=GREY, hub=LIGHT, origin=(0, 0)):
    """The wheels of a track, seen from outside: rollers as in robot.toml, with the belt's radius."""
    least = min(radius for *_, radius in rollers)
    for x, z, radius in rollers:
        at, inside = (x - origin[0], y, z - origin[1]), radius - min(0.15 * least, 0.012) - 0.004
        half = 0.45 * width + 0.004
        mesh.add(rod(0.92 * inside, -half, half, 12), colour, at, Y)
        mesh.add(rod(0.72 * inside, -half - 0.002, half + 0.002, 10), DARK, at, Y)
        mesh.add(rod(0.36 * inside, -half - 0.006, half + 0.006, 6), hub, at, Y)
    return mesh


def propeller(radius, chord, sense, colour=(0.32, 0.33, 0.35), blades=2):
    """Blades about z, twisted from root to tip; `sense` is 1 for one that pulls up when it turns right-handed."""
    mesh = Mesh()
    for blade in range(blades):
        stations = [(0.08, 0.6, 0.4), (0.38, 1.0, 0.30), (0.75, 0.85, 0.2), (1.0, 0.45, 0.12)]
        rings = [
            [
                placed(corner, (0, 0, 0), (sense * pitch, 0, 0))
                for corner in [
                    (r * radius, -c * chord, 0),
                    (r * radius, 0, -0.1 * chord),
                    (r * radius, c * chord, 0),
                    (r * radius, 0, 0.1 * chord),
                ]
            ]
            for r, c, pitch in stations
        ]
        mesh.add(loft(rings), colour, turn=(0, 0, 2 * math.pi * blade / blades))
    return mesh.add(rod(0.1 * radius, -0.06 * radius, 0.05 * radius, 8), BLACK)


def add_handles(mesh, at, length, height, colour=BLACK):
    """Two bows ahead of a place on a deck, on the right and the left of the middle."""
    bow = tube([(0, 0, 0), (0, 0, -height), (length, 0, -height), (length, 0, 0)], 0.006)
    return mesh.add_pair(bow, colour, at)
