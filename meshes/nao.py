"""Nao of Aldebaran, 0.57 m: white shells with blue panels between grey joints. Its left and right limbs look alike.

Limbs have their joint as origin; the arms stretch ahead when every joint is at 0.
"""

import math

from solids import *

SHELL = (0.93, 0.93, 0.94)
JOINT = (0.50, 0.52, 0.55)
PANEL = (0.20, 0.42, 0.75)
EYE = (0.15, 0.75, 0.95)


def upright(stations, corner=0.35):
    """A shell along z of rounded rectangles: z, x of its middle, edges along x and y."""
    return loft([[(cx + x, y, z) for x, y in rounded(lx, ly, corner * min(lx, ly), 1)] for z, cx, lx, ly in stations])


def ahead(stations, corner=0.38):
    """A shell along x: x, z of its middle, edges along y and z."""
    return loft([[(x, y, cz + z) for y, z in rounded(ly, lz, corner * min(ly, lz), 1)] for x, cz, ly, lz in stations])


def torso():
    mesh = Mesh().add(
        upright(
            [
                (-0.105, 0.0, 0.055, 0.10),
                (-0.095, 0.0, 0.085, 0.13),
                (-0.05, 0.002, 0.105, 0.135),
                (0.0, 0.0, 0.098, 0.115),
                (0.035, -0.002, 0.085, 0.09),
                (0.045, -0.002, 0.07, 0.08),
            ]
        ),
        SHELL,
    )
    mesh.add(
        upright(
            [(-0.075, 0.036, 0.05, 0.084), (-0.045, 0.038, 0.052, 0.090), (0.005, 0.032, 0.05, 0.062), (0.015, 0.030, 0.045, 0.05)]
        ),
        PANEL,
    )
    mesh.add(rod(0.013, 0.055, 0.0665, 12), METAL, (0, 0, -0.045), X).add(rod(0.009, 0.055, 0.068, 10), EYE, (0, 0, -0.045), X)
    mesh.add_pair(rod(0.011, 0.05, 0.0595, 10), DARK, (0, 0.036, -0.058), X)  # sonars
    mesh.add(upright([(-0.085, -0.048, 0.03, 0.10), (-0.03, -0.050, 0.03, 0.105), (0.02, -0.045, 0.03, 0.08)]), JOINT)
    mesh.add(upright([(0.04, -0.004, 0.065, 0.075), (0.06, -0.006, 0.075, 0.105), (0.082, -0.008, 0.06, 0.10)]), JOINT)
    return mesh.add_pair(rod(0.030, -0.012, 0.018, 10), JOINT, (0, 0.068, -0.08), (-math.pi / 2, 0, 0))


def neck():
    return Mesh().add(rod(0.022, 0.012, -0.03, 10), JOINT)


def head():
    mesh = Mesh().add(ball(0.062, 12, (0.98, 0.95, 0.86)), SHELL, (0.0, 0, -0.068))
    mesh.add_pair(rod(0.034, 0.044, 0.063, 12, second=0.028), JOINT, (-0.004, 0, -0.065), (-math.pi / 2, 0, 0))  # ears
    mesh.add_pair(rod(0.020, 0.06, 0.0655, 12), PANEL, (-0.004, 0, -0.065), (-math.pi / 2, 0, 0))
    for y in (-0.025, 0.025):
        mesh.add(rod(0.0155, 0.030, 0.0535, 12), DARK, (0, y, -0.07), X).add(rod(0.0115, 0.03, 0.0545, 10), EYE, (0, y, -0.07), X)
    mesh.add(rod(0.0065, 0.03, 0.0525, 8), BLACK, (0.0, 0, -0.096), X).add(rod(0.0065, 0.03, 0.0565, 8), BLACK, (0.0, 0, -0.036), X)
    mesh.add(upright([(-0.126, 0.0, 0.03, 0.018), (-0.118, 0.0, 0.052, 0.026), (-0.10, 0.0, 0.07, 0.03)]), PANEL)  # touch buttons
    return mesh.add(upright([(-0.03, -0.004, 0.05, 0.045), (-0.012, -0.004, 0.045, 0.042)]), JOINT)


def shoulder():
    return Mesh().add(ball(0.030, 10), JOINT, (0.004, 0, 0)).add(rod(0.026, -0.034, 0.034, 12), SHELL, turn=Y)


def upper_arm():
    mesh = Mesh().add(
        ahead([(0.005, 0, 0.045, 0.05), (0.03, 0, 0.056, 0.060), (0.075, 0, 0.050, 0.052), (0.098, 0, 0.038, 0.042)]), SHELL
    )
    return mesh.add(ahead([(0.035, -0.012, 0.036, 0.042), (0.070, -0.009, 0.030, 0.038)]), PANEL)


def elbow():
    return Mesh().add(ball(0.022, 10), JOINT)


def forearm():
    mesh = Mesh().add(
        ahead([(0.004, 0, 0.030, 0.034), (0.020, 0, 0.044, 0.048), (0.055, 0, 0.046, 0.046), (0.075, 0, 0.034, 0.036)]), SHELL
    )
    mesh.add(ahead([(0.072, 0, 0.026, 0.03), (0.080, 0, 0.028, 0.034), (0.098, 0, 0.026, 0.034)]), JOINT)  # palm
    for y in (-0.011, 0.0, 0.011):
        mesh.add(box(0.032, 0.008, 0.010), SHELL, (0.110, y, -0.005), (0, -0.12, 0))
    return mesh.add(box(0.022, 0.009, 0.009), SHELL, (0.096, 0, 0.017))


def hip():
    return Mesh().add(ball(0.031, 10), JOINT)


def thigh():
    mesh = Mesh().add(rod(0.027, -0.029, 0.029, 10), JOINT, turn=Y)
    mesh.add(
        upright(
            [(0.004, 0.002, 0.055, 0.056), (0.02, 0.004, 0.068, 0.064), (0.055, 0.008, 0.066, 0.060), (0.082, 0.010, 0.05, 0.052)]
        ),
        SHELL,
    )
    return mesh.add(box(0.012, 0.034, 0.044), PANEL, (0.038, 0, 0.045))


def shank():
    mesh = Mesh().add(rod(0.025, -0.030, 0.030, 10), JOINT, turn=Y).add(rod(0.018, -0.032, 0.032, 10), PANEL, turn=Y)
    mesh.add(
        upright(
            [(0.010, 0.004, 0.05, 0.05), (0.03, 0.002, 0.068, 0.06), (0.06, -0.002, 0.066, 0.056), (0.092, -0.004, 0.046, 0.046)]
        ),
        SHELL,
    )
    return mesh.add(box(0.012, 0.030, 0.036), PANEL, (0.030, 0, 0.05))


def ankle():
    return Mesh().add(ball(0.027, 10), JOINT).add(rod(0.018, -0.028, 0.028, 10), JOINT, turn=Y)


def foot():
    sole = lambda long, wide, z: [(0.020 + x, y, z) for x, y in rounded(long, wide, 0.4 * wide, 2)]
    mesh = Mesh().add(loft([sole(0.16, 0.090, 0.050), sole(0.16, 0.090, 0.043)]), JOINT)
    top = [(0.0 + x, y, 0.008) for x, y in rounded(0.09, 0.052, 0.02, 2)]
    mesh.add(loft([sole(0.158, 0.088, 0.044), sole(0.150, 0.082, 0.030), top]), SHELL)
    mesh.add(rod(0.012, -0.036, 0.036, 10), PANEL, (-0.02, 0, 0.026), Y)
    return mesh.add_pair(box(0.012, 0.03, 0.012), DARK, (0.093, 0.018, 0.038))


FILES = {
    "robots/Nao": {
        "torso.glb": torso,
        "neck.glb": neck,
        "head.glb": head,
        "shoulder.glb": shoulder,
        "upper-arm.glb": upper_arm,
        "elbow.glb": elbow,
        "forearm.glb": forearm,
        "hip.glb": hip,
        "thigh.glb": thigh,
        "shank.glb": shank,
        "ankle.glb": ankle,
        "foot.glb": foot,
    }
}
