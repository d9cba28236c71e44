"""Pioneers: outlines as in robot.toml, looks from memory; sonars where robot.toml has them."""

import math

from parts import sick, wheel
from solids import *


SONARS_AT = [(0.145, 0.13, 90), (0.185, 0.115, 50), (0.22, 0.08, 30), (0.24, 0.025, 10)]
SONARS_DX = [(0.075, 0.13, 90), (0.115, 0.115, 50), (0.15, 0.08, 30), (0.17, 0.025, 10)]


def all_around(sonars, back):
    """Sonars of the right front on the left and, if there are, at the back too: x, y, degrees, clockwise from above."""
    front = [(x, -y, -a) for x, y, a in sonars] + sonars[::-1]
    return front + ([(-x, -y, a + 180) for x, y, a in front] if back else [])


def outline_of(sonars, out=0.0):
    """The outline with a face behind each sonar."""
    lines = []
    for x, y, degrees in sonars:
        normal = (math.cos(math.radians(degrees)), math.sin(math.radians(degrees)))
        line = (*normal, normal[0] * x + normal[1] * y - 0.003 + out)
        if not lines or abs(lines[-1][0] * normal[1] - lines[-1][1] * normal[0]) > 1e-6:
            lines.append(line)
    return lines


def closed(lines):
    return [crossing(a, b) for a, b in zip(lines[-1:] + lines[:-1], lines)]


def add_sonars(mesh, sonars, z):
    for x, y, degrees in sonars:
        mesh.add(rod(0.017, -0.006, 0.0, 8), GOLD, (x, y, z), (0, math.pi / 2, math.radians(degrees)), stands=True)


def pioneer_at(deck, sonar, bottom, bumpers=None):
    """A body between four wheels: z of its deck, of its sonars and of its belly."""
    sonars = sorted(all_around(SONARS_AT, True), key=lambda it: it[2] % 360)
    mesh, ring = Mesh(), closed(outline_of(sonars))
    low = sonar + 0.024
    mesh.add(loft([[(x, y, z) for x, y in inset(rounded(0.47, 0.27, 0.035, 4), by)]
                   for by, z in [(0.025, bottom), (0.0, bottom - 0.03), (0.0, low + 0.01), (0.01, low)]]), RED)
    mesh.add(prism(ring, deck + 0.012, low), BLACK)
    mesh.add(box(0.25, 0.262, low - deck - 0.010), RED, (0, 0, (low + deck + 0.011) / 2))  # between the sonars
    mesh.add(prism(closed(outline_of(sonars, 0.010)), deck + 0.005, deck + 0.012), RED)
    mesh.add(prism(closed(outline_of(sonars, 0.002)), deck, deck + 0.006), BLACK)
    mesh.add_pair(box(0.075, 0.004, 0.018), LIGHT, (0, 0.131, sonar))  # its name
    mesh.add(box(0.09, 0.07, 0.004), GREY, (-0.13, 0.03, deck - 0.001))  # its panel of buttons
    mesh.add(rod(0.008, 0, -0.006, 8), RED_LAMP, (-0.15, 0.045, deck - 0.002))
    add_sonars(mesh, sonars, sonar)
    for end in (1, -1) if bumpers else ():
        for i in range(-2, 3):
            place = (end * (0.276 - 0.003 * i * i), i * 0.092, bumpers)
            mesh.add(box(0.02, 0.088, 0.04), RUBBER, place, (0, 0, -end * i * 0.06))
        mesh.add(box(0.012, 0.40, 0.02), GREY, (end * 0.258, 0, bumpers))
        mesh.add_pair(box(0.05, 0.03, 0.016), GREY, (end * 0.24, 0.08, bumpers - 0.004))
    return mesh


def pioneer_dx():
    """A body round at the back, with two wheels beside it and a caster."""
    mesh, sonars = Mesh(), all_around(SONARS_DX, False)
    back = lambda x, ry, rx: [(x - rx * math.sin(a), ry * math.cos(a)) for a in [math.pi * i / 10 for i in range(11)]]
    ring = [crossing(a, b) for a, b in zip(outline_of(sonars), outline_of(sonars)[1:])]
    mesh.add(prism(ring + [(0.04, 0.127), (0.04, -0.127)], -0.122, -0.066), BLACK)
    body = ring + back(-0.11, 0.126, 0.115)
    mesh.add(prism(inset(body, 0.004), -0.068, 0.005), RED)
    mesh.add(prism([(0.05, 0.1265), *back(-0.11, 0.1265, 0.116), (0.05, -0.1265)], -0.122, -0.064), RED)
    lines = outline_of(sonars, 0.002)
    deck = [crossing(a, b) for a, b in zip(lines, lines[1:])] + back(-0.11, 0.139, 0.127)
    mesh.add(prism(deck, -0.126, -0.121), RED).add(prism(inset(deck, 0.006), -0.131, -0.1255), BLACK)
    mesh.add(prism(rounded(0.24, 0.19, 0.02), 0.003, 0.032), DARK)
    mesh.add(rod(0.012, 0.12, 0.16, 10), GREY, turn=Y).add(rod(0.012, -0.16, -0.12, 10), GREY, turn=Y)
    mesh.add(rod(0.04, -0.002, 0.014, 14), DARK, (-0.2, 0, 0))  # fork of the caster
    mesh.add_pair(box(0.03, 0.006, 0.05), METAL, (-0.2, 0.041, 0.028))
    mesh.add_pair(box(0.08, 0.004, 0.02), LIGHT, (-0.08, 0.1265, -0.095))
    mesh.add(box(0.06, 0.05, 0.003), GREY, (-0.15, 0.04, -0.132))
    add_sonars(mesh, sonars, -0.09)
    return mesh


FILES = {
    "robots/P3AT": {"body.glb": lambda: pioneer_at(-0.08, -0.048, 0.113, 0.088), "sick.glb": sick,
                    "wheel.glb": lambda: wheel(0.098, 0.075, 0.054, 10)},
    "robots/P2AT": {"body.glb": lambda: pioneer_at(-0.152, -0.12, 0.045), "sick.glb": sick,
                    "wheel.glb": lambda: wheel(0.1075, 0.075, 0.059, 10)},
    "robots/P2DX": {"body.glb": pioneer_dx, "sick.glb": sick, "wheel.glb": lambda: wheel(0.0825, 0.037, 0.058, 0, 6, corners=24)},
}
