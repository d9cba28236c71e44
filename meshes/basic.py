"""Cars and plain robots of USARSim, whose meshes are not public: bodies over the boxes that collide."""

import math

from parts import wheel
from solids import *


def windows(mesh, low, high, top, bottom, panes):
    """Glass a little outside of a cabin (x from, x to, half of y, at the bottom and at the top)."""
    at = lambda part: [low[i] + (high[i] - low[i]) * part for i in range(3)]
    a, b = at(0.15), at(0.85)
    z = [bottom + (top - bottom) * part for part in (0.15, 0.85)]
    gap = 0.004
    mesh.add(frustum((a[0] - gap, a[1] + gap, a[2] - 0.02), (b[0] - gap, b[1] + gap, b[2] - 0.02), z[1], z[0]), GLASS)
    width = (b[1] - b[0]) / panes
    for i in range(panes):
        start = b[0] + i * width + 0.012
        lean = [(a[1] - b[1]) if i == panes - 1 else 0, (a[0] - b[0]) if i == 0 else 0]
        pane = frustum((start + lean[1], start + width - 0.024 + lean[0], a[2] + gap),
                       (start, start + width - 0.024, b[2] + gap), z[1], z[0])
        mesh.add(pane, GLASS)


def front_ackerman():
    """An old-timer: a bonnet between free wheels that are steered with their mudguards, and a cabin."""
    mesh, low, high = Mesh(), (-0.46, 0.26, 0.145), (-0.40, 0.14, 0.115)
    mesh.add(sections([(-0.585, 0.11, 0.25, 0.39), (-0.54, 0.15, 0.235, 0.42), (0.26, 0.15, 0.235, 0.42),
                       (0.35, 0.085, 0.25, 0.42), (0.66, 0.075, 0.27, 0.41)], 0.015), RED)
    mesh.add(frustum(low, high, 0.112, 0.24), RED)
    mesh.add(prism([(x - 0.13, y) for x, y in rounded(0.57, 0.245, 0.02)], 0.100, 0.113, 0.006), RED)
    windows(mesh, low, high, 0.112, 0.24, 2)
    mesh.add(box(0.03, 0.13, 0.11), DARK, (0.665, 0, 0.345))  # radiator
    for z in (0.31, 0.335, 0.36, 0.385):
        mesh.add(box(0.006, 0.11, 0.008), METAL, (0.681, 0, z))
    mesh.add_pair(rod(0.033, -0.03, 0.012, 14), METAL, (0.62, 0.108, 0.265), X)
    mesh.add_pair(rod(0.028, 0.0, 0.016, 14), LAMP, (0.62, 0.108, 0.265), X)
    mesh.add(box(0.012, 0.22, 0.012), METAL, (0.605, 0, 0.272))
    mesh.add(box(0.028, 0.34, 0.035), METAL, (0.70, 0, 0.42)).add(box(0.028, 0.32, 0.035), METAL, (-0.60, 0, 0.41))
    mesh.add_pair(box(0.05, 0.02, 0.02), DARK, (0.67, 0.05, 0.41)).add_pair(box(0.05, 0.02, 0.02), DARK, (-0.575, 0.05, 0.40))
    mesh.add_pair(box(0.012, 0.045, 0.03), RED_LAMP, (-0.583, 0.075, 0.30))
    mesh.add_pair(box(0.30, 0.03, 0.02), DARK, (0.09, 0.155, 0.412))  # running boards
    mesh.add(rod(0.018, -0.13, 0.13, 10), DARK, (0.54, 0, 0.456), Y)  # axles
    mesh.add(rod(0.02, -0.22, 0.22, 10), DARK, (-0.416, 0, 0.512), Y)
    mesh.add_pair(box(0.10, 0.02, 0.06), DARK, (0.54, 0.05, 0.43)).add_pair(box(0.06, 0.03, 0.11), DARK, (-0.416, 0.10, 0.46))
    mesh.add_pair(arc(0.138, 0.012, 0.096, 0.25, math.pi - 0.25, 10), RED, (-0.416, 0.248, 0.512))
    mesh.add_pair(box(0.08, 0.07, 0.012), RED, (-0.416, 0.174, 0.371))
    return mesh


def front_knuckle():
    """What steers with the right front wheel; its origin is the wheel's middle."""
    mesh = Mesh().add(arc(0.194, 0.012, 0.09, 0.5, math.pi - 0.5, 10), RED)
    mesh.add(box(0.03, 0.008, 0.19), DARK, (0, -0.05, -0.104)).add(box(0.03, 0.05, 0.008), DARK, (0, -0.03, -0.197))
    return mesh.add(rod(0.022, -0.042, 0.09, 10), DARK, turn=Y).add(rod(0.02, -0.045, 0.045, 10), GREY, (0, -0.08, 0))


def basic_ackerman():
    """A flat car."""
    green, mesh = (0.16, 0.40, 0.31), Mesh()
    low, high = (-0.30, 0.22, 0.38), (-0.20, 0.06, 0.31)
    mesh.add(sections([(-0.45, 0.41, 0.0, 0.08), (-0.40, 0.45, -0.025, 0.1), (0.30, 0.45, -0.02, 0.1),
                       (0.45, 0.40, 0.02, 0.085)], 0.02), green)
    mesh.add(frustum(low, high, -0.095, -0.015), green)
    mesh.add(prism([(x - 0.07, y) for x, y in rounded(0.27, 0.63, 0.03)], -0.1, -0.094), green)
    windows(mesh, low, high, -0.095, -0.015, 2)
    mesh.add_pair(box(0.02, 0.12, 0.032), LAMP, (0.444, 0.30, 0.045)).add(box(0.015, 0.36, 0.03), DARK, (0.446, 0, 0.05))
    mesh.add_pair(box(0.016, 0.12, 0.028), RED_LAMP, (-0.446, 0.31, 0.035))
    mesh.add(box(0.04, 0.76, 0.03), DARK, (0.44, 0, 0.082)).add(box(0.04, 0.78, 0.03), DARK, (-0.44, 0, 0.078))
    for x in (0.30, -0.30):
        mesh.add(rod(0.022, -0.53, 0.53, 10), DARK, (x, 0, 0.064), Y)
    return mesh


def plain(colour, height, mesh):
    """A platform of 0.9 x 0.9 m with its load bed and an arrow that says where ahead is."""
    half = height / 2
    mesh.add(prism(rounded(0.88, 0.88, 0.07, 3), -half + 0.045, half), DARK)
    mesh.add(prism(rounded(0.90, 0.90, 0.08, 3), -half, -half + 0.05, 0.012), colour)
    mesh.add(prism(rounded(0.68, 0.68, 0.04, 2), -half - 0.003, -half + 0.01), GREY)
    for i in range(-3, 4):
        mesh.add(box(0.62, 0.012, 0.004), DARK, (0, i * 0.085, -half - 0.004))
    mesh.add(prism([(0.425, 0.0), (0.36, 0.09), (0.36, -0.09)], -half - 0.003, -half + 0.01), YELLOW)
    mesh.add_pair(box(0.016, 0.11, 0.03), LAMP, (0.436, 0.28, -half + 0.072))
    mesh.add_pair(box(0.016, 0.09, 0.024), RED_LAMP, (-0.436, 0.29, -half + 0.07))
    return mesh


def basic_skid():
    mesh = plain((0.20, 0.38, 0.60), 0.2, Mesh())
    for x in (0.30, -0.30):
        mesh.add(rod(0.028, -0.53, 0.53, 10), METAL, (x, 0, 0.064), Y)
    return mesh


def caster_skid():
    mesh = plain((0.13, 0.47, 0.48), 0.15, Mesh())
    mesh.add(rod(0.028, -0.53, 0.53, 10), METAL, (-0.3, 0, 0.064), Y)
    mesh.add(rod(0.062, 0.07, 0.088, 16), METAL, (0.384, 0, 0))  # fork of the caster
    return mesh.add_pair(box(0.05, 0.008, 0.07), METAL, (0.384, 0.061, 0.113))


FILES = {
    "robots/FrontAckerman": {"body.glb": front_ackerman, "knuckle.glb": front_knuckle,
                             "front-wheel.glb": lambda: wheel(0.184, 0.08, 0.125, 0, 6, RED, 22),
                             "rear-wheel.glb": lambda: wheel(0.128, 0.08, 0.085, 0, 6, RED, 18)},
    "robots/BasicAckermanRobot": {"body.glb": basic_ackerman,
                                  "wheel.glb": lambda: wheel(0.128, 0.1, 0.08, 0, 5, corners=20)},
    "robots/BasicSkidRobot": {"body.glb": basic_skid, "wheel.glb": lambda: wheel(0.128, 0.1, 0.07, 14)},
    "robots/CasterSkidRobot": {"body.glb": caster_skid, "wheel.glb": lambda: wheel(0.128, 0.1, 0.07, 14)},
}
