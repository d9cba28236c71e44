"""Robots on tracks. Belts are drawn from robot.toml and move; here are hulls, the wheels that are seen inside the belts, and what they carry."""

import math

from parts import add_antenna, add_camera, add_handles, add_rollers, hokuyo, sick_yellow
from solids import *

PALE = (0.86, 0.87, 0.86)


def wheels_of(tracks):
    """A mesh of the wheels inside belts: (rollers, y, width) each."""
    mesh = Mesh()
    for rollers, y, width in tracks:
        add_rollers(mesh, rollers, y, width)
    return mesh


def pair(rollers, y, width):
    return [(rollers, y, width), (rollers, -y, width)]


def flipper(radius, tip, length, width, colour, hub=LIGHT):
    """The plate and wheels of a flipper; the origin is its axle, and it points ahead."""
    mesh = Mesh()
    for sign in (-1, 1):
        y = sign * (0.45 * width + 0.003)
        mesh.add(side(belted((0, 0, 0.62 * radius), (length, 0, 0.5 * tip), 4), y - 0.003, y + 0.003), colour)
    rollers = [(0, 0, radius), (length, 0, tip)]
    return add_rollers(mesh, rollers, 0, width + 0.01, DARK, hub)


def matilda():
    """An olive tub between triangular tracks, with a mast."""
    mesh = wheels_of(pair([(-0.28, 0, 0.08), (0.16, 0, 0.08), (0.29, -0.12, 0.06), (-0.06, 0.0, 0.06)], 0.2, 0.12))
    mesh.add(
        sections(
            [(-0.33, 0.11, -0.06, 0.02), (-0.28, 0.132, -0.11, 0.04), (0.14, 0.132, -0.11, 0.04), (0.24, 0.12, -0.15, -0.06)], 0.012
        ),
        OLIVE,
    )
    mesh.add(prism(rounded(0.40, 0.24, 0.02, 1), -0.125, -0.105, 0.005), OLIVE, (-0.07, 0, 0)).add(
        box(0.15, 0.18, 0.006), DARK, (-0.17, 0, -0.127)
    )
    mesh.add(box(0.10, 0.12, 0.05), BLACK, (0.02, 0, -0.14))
    mesh.add(rod(0.016, -0.12, -0.44, 8), METAL, (-0.15, 0, 0)).add(rod(0.022, -0.12, -0.18, 8), DARK, (-0.15, 0, 0))
    add_camera(mesh, (-0.08, 0, -0.47), 0.085)
    mesh.add(box(0.07, 0.07, 0.09), DARK, (0.18, 0, -0.165))
    mesh.add_pair(rod(0.022, 0.0, 0.02, 10), LAMP, (0.20, 0.085, -0.13), X).add_pair(
        rod(0.026, -0.03, 0.012, 10), BLACK, (0.20, 0.085, -0.13), X
    )
    for x in (-0.25, 0.0):
        add_handles(mesh, (x, 0.10, -0.12), 0.10, 0.025)
    return add_antenna(mesh, (-0.27, 0.08, -0.12), 0.35, 0.004)


def rugbot():
    """A white case with a blue lid, a yellow laser ahead and a mast behind."""
    mesh = wheels_of(pair([(0.2, 0, 0.08), (-0.2, 0, 0.08), (0.0, 0.012, 0.064)], 0.2, 0.08))
    mesh.add(
        sections(
            [(-0.26, 0.12, -0.13, -0.01), (-0.22, 0.145, -0.155, 0.035), (0.19, 0.145, -0.155, 0.035), (0.25, 0.12, -0.11, 0.0)],
            0.014,
        ),
        PALE,
    )
    mesh.add(prism(rounded(0.43, 0.31, 0.03, 2), -0.175, -0.15, 0.008), BLUE, (-0.015, 0, 0))
    mesh.add(box(0.16, 0.22, 0.06), DARK, (-0.10, 0, -0.20)).add(box(0.12, 0.16, 0.006), GREY, (-0.10, 0, -0.232))
    for x in (-0.05, 0.0, 0.05):
        mesh.add_pair(box(0.03, 0.004, 0.05), DARK, (x, 0.145, -0.10))
    mesh.add(rod(0.013, -0.15, -0.48, 8), METAL, (-0.19, 0, 0)).add(rod(0.022, -0.15, -0.22, 8), DARK, (-0.19, 0, 0))
    add_camera(mesh, (-0.10, 0, -0.53), 0.09)
    mesh.add_pair(rod(0.020, 0, 0.02, 10), LAMP, (0.22, 0.09, -0.09), X).add(box(0.03, 0.05, 0.03), BLACK, (0.235, 0, -0.10))
    mesh.add(rod(0.03, -0.245, 0.245, 12), METAL, (0.2, 0, 0), Y)
    mesh.add_pair(rod(0.012, -0.15, -0.19, 8), RED_LAMP, (-0.20, 0.11, 0))
    return add_antenna(mesh, (-0.21, -0.11, -0.175), 0.40, 0.005)


def rugbot_flipper():
    mesh = Mesh().add(rod(0.022, -0.29, 0.29, 12), METAL, turn=Y)
    for sign in (-1, 1):
        for part in (-1, 1):
            y = sign * 0.27 + part * 0.021
            mesh.add(side(belted((0, 0, 0.042), (0.2, 0, 0.02), 4), y - 0.003, y + 0.003), BLUE)
        add_rollers(mesh, [(0, 0, 0.07), (0.2, 0, 0.04)], sign * 0.27, 0.05, DARK)
    return mesh


def talon():
    """An olive hull, an arm with a gripper that rests ahead, and a mast with cameras."""
    tan = (0.46, 0.44, 0.32)
    mesh = wheels_of(
        pair([(-0.3, -0.02, 0.11), (0.3, -0.02, 0.11), (0.0, 0.035, 0.06), (-0.15, 0.035, 0.06), (0.15, 0.035, 0.06)], 0.21, 0.15)
    )
    mesh.add(
        sections(
            [(-0.40, 0.10, -0.09, -0.01), (-0.34, 0.13, -0.13, 0.03), (0.34, 0.13, -0.13, 0.03), (0.40, 0.10, -0.10, -0.02)], 0.012
        ),
        tan,
    )
    mesh.add(box(0.30, 0.24, 0.09), tan, (-0.17, 0, -0.165)).add(box(0.26, 0.20, 0.006), DARK, (-0.17, 0, -0.212))
    mesh.add_pair(box(0.42, 0.13, 0.010), tan, (0, 0.21, -0.145)).add_pair(box(0.10, 0.09, 0.07), OLIVE, (-0.10, 0.205, -0.18))
    # Turret, shoulder, upper arm back and up, forearm ahead, gripper.
    mesh.add(rod(0.075, -0.13, -0.17, 14), DARK, (0.10, 0, 0)).add(box(0.11, 0.10, 0.11), tan, (0.10, 0, -0.21))
    mesh.add(rod(0.042, -0.075, 0.075, 12), METAL, (0.10, 0, -0.24), Y)
    for y in (-0.034, 0.034):
        mesh.add(strap((0.10, -0.24, 0.036), (-0.13, -0.43, 0.030), y - 0.012, y + 0.012, 0, 4), tan)
    mesh.add(rod(0.034, -0.06, 0.06, 12), METAL, (-0.13, -0.0, -0.43), Y)
    mesh.add(tube([(-0.13, 0, -0.43), (0.26, 0, -0.33)], 0.026, 8), tan).add(
        rod(0.036, -0.045, 0.045, 10), METAL, (0.26, 0, -0.33), Y
    )
    mesh.add(tube([(0.26, 0, -0.33), (0.36, 0, -0.285)], 0.022, 8), BLACK)
    for y in (-0.045, 0.045):
        mesh.add(tube([(0.355, 0.3 * y, -0.287), (0.39, y, -0.272), (0.46, 0.35 * y, -0.240)], 0.010, 5), BLACK)
    mesh.add(box(0.05, 0.05, 0.04), BLACK, (0.30, 0, -0.37)).add(rod(0.014, 0, 0.03, 8), GLASS, (0.32, 0, -0.37), X)
    # Mast
    mesh.add(rod(0.020, -0.20, -0.70, 8), BLACK, (-0.26, 0, 0)).add(rod(0.03, -0.20, -0.28, 8), DARK, (-0.26, 0, 0))
    add_camera(mesh, (-0.14, 0, -0.76), 0.12)
    mesh.add_pair(rod(0.03, -0.02, 0.03, 10), BLACK, (-0.22, 0.10, -0.74), X).add_pair(
        rod(0.024, 0, 0.035, 10), LAMP, (-0.22, 0.10, -0.74), X
    )
    mesh.add(rod(0.010, -0.10, 0.10, 6), METAL, (-0.23, 0, -0.74), Y).add(box(0.09, 0.09, 0.05), DARK, (0.30, 0, -0.145))
    return add_antenna(mesh, (-0.33, -0.10, -0.21), 0.55, 0.005)


def low_hull(long, wide, deck, colour, lid, rollers, y, width, shafts):
    """A flat hull between two tracks with a lid, and the shafts of four flippers."""
    mesh = wheels_of(pair(rollers, y, width))
    mesh.add(
        sections(
            [
                (-long / 2 - 0.025, 0.7 * wide, deck + 0.035, 0.005),
                (-long / 2 + 0.01, wide, deck + 0.008, 0.028),
                (long / 2 - 0.01, wide, deck + 0.008, 0.028),
                (long / 2 + 0.025, 0.7 * wide, deck + 0.035, 0.005),
            ],
            0.010,
        ),
        colour,
    )
    mesh.add(prism(rounded(0.82 * long, 1.75 * wide, 0.02, 2), deck, deck + 0.014, 0.005), lid)
    for x in (-1, 1):
        mesh.add(rod(0.013, -shafts[1], shafts[1], 8), METAL, (x * shafts[0], 0, 0), Y)
    return mesh


def tarantula():
    mesh = low_hull(
        0.34, 0.088, -0.085, DARK, YELLOW, [(0.15, 0, 0.06), (-0.15, 0, 0.06), (0.0, 0.01, 0.045)], 0.12, 0.05, (0.16, 0.20)
    )
    mesh.add(box(0.12, 0.10, 0.05), DARK, (-0.05, 0, -0.105)).add(box(0.08, 0.07, 0.006), GREY, (-0.05, 0, -0.132))
    mesh.add(box(0.05, 0.05, 0.035), DARK, (0.10, 0, -0.095)).add(rod(0.009, -0.085, -0.18, 8), METAL, (0.11, 0, 0))
    add_camera(mesh, (0.15, 0, -0.2), 0.055)
    mesh.add_pair(rod(0.011, 0, 0.014, 8), LAMP, (0.175, 0.05, -0.045), X)
    for x in (-0.12, 0.06):
        add_handles(mesh, (x, 0.07, -0.085), 0.05, 0.03, METAL)
    return add_antenna(mesh, (-0.13, 0.05, -0.085), 0.24, 0.004)


def crawler():
    mesh = low_hull(
        0.40,
        0.092,
        -0.085,
        (0.30, 0.32, 0.34),
        ORANGE,
        [(0.2, 0, 0.06), (-0.2, 0, 0.06), (-0.07, 0.01, 0.045), (0.07, 0.01, 0.045)],
        0.12,
        0.06,
        (0.21, 0.215),
    )
    mesh.add(box(0.17, 0.12, 0.055), DARK, (-0.06, 0, -0.108)).add(box(0.13, 0.08, 0.006), LIGHT, (-0.06, 0, -0.138))
    mesh.add(box(0.05, 0.05, 0.03), DARK, (0.15, 0, -0.095)).add(rod(0.010, -0.085, -0.19, 8), METAL, (0.115, 0, 0))
    add_camera(mesh, (0.165, 0, -0.21), 0.055)
    mesh.add_pair(rod(0.012, 0, 0.016, 8), LAMP, (0.215, 0.055, -0.045), X)
    for x in (-0.16, 0.08):
        add_handles(mesh, (x, 0.075, -0.085), 0.06, 0.035)
    return add_antenna(mesh, (-0.17, 0.0, -0.085), 0.20, 0.005)


def telemax():
    """A case between four flippers, and a folded arm of five joints with a gripper."""
    mesh = Mesh().add(
        sections(
            [(-0.29, 0.10, -0.14, -0.03), (-0.25, 0.125, -0.185, 0.005), (0.25, 0.125, -0.185, 0.005), (0.29, 0.10, -0.14, -0.03)],
            0.014,
        ),
        SAND,
    )
    mesh.add(prism(rounded(0.44, 0.22, 0.02, 2), -0.20, -0.18, 0.006), SAND).add(box(0.14, 0.18, 0.03), DARK, (-0.15, 0, -0.21))
    for x in (-0.12, 0.12):
        mesh.add(rod(0.05, -0.145, 0.145, 14), DARK, (x, 0, 0), Y)
    # Arm: turntable, upper arm up and back, forearm ahead, wrist, gripper.
    mesh.add(rod(0.085, -0.20, -0.245, 18), DARK, (-0.02, 0, 0)).add(box(0.10, 0.11, 0.10), SAND, (-0.02, 0, -0.29))
    mesh.add(rod(0.050, -0.075, 0.075, 14), DARK, (-0.02, 0, -0.32), Y)
    mesh.add(strap((-0.02, -0.32, 0.042), (-0.16, -0.66, 0.036), -0.030, 0.030, 0.008, 4), SAND)
    mesh.add(rod(0.046, -0.062, 0.062, 14), DARK, (-0.16, 0, -0.66), Y)
    mesh.add(strap((-0.16, -0.66, 0.036), (0.10, -0.67, 0.030), 0.034, 0.085, 0.008, 4), SAND)
    mesh.add(rod(0.040, -0.02, 0.095, 12), DARK, (0.10, 0, -0.67), Y)
    mesh.add(strap((0.10, -0.67, 0.028), (0.28, -0.65, 0.024), -0.026, 0.024, 0.006, 4), SAND).add(
        rod(0.034, -0.036, 0.034, 12), DARK, (0.28, 0, -0.65), Y
    )
    mesh.add(tube([(0.28, 0, -0.65), (0.365, 0, -0.635)], 0.022, 10), METAL).add(
        box(0.03, 0.10, 0.03), DARK, (0.37, 0, -0.634), (0, -0.17, 0)
    )
    for y in (-0.042, 0.042):
        mesh.add(strap((0.37, -0.633, 0.014), (0.45, -0.618, 0.008), y - 0.007, y + 0.007, 0, 3), METAL)
    add_camera(mesh, (0.10, 0, -0.5), 0.07)
    mesh.add(rod(0.012, -0.20, -0.455, 8), METAL, (0.048, 0, 0))
    mesh.add(box(0.05, 0.05, 0.03), DARK, (0.2, 0, -0.21)).add_pair(rod(0.022, 0, 0.018, 10), LAMP, (0.275, 0.06, -0.11), X)
    return add_antenna(mesh, (-0.22, 0.09, -0.19), 0.45, 0.005)


def telemax_flipper():
    mesh = flipper(0.09, 0.09, 0.26, 0.1, (0.28, 0.29, 0.30), SAND)
    return mesh


def soryu_shell(front=False):
    """A red shell between two belts, with a rib over them; the origin is its middle."""
    mesh = wheels_of(
        pair([(0.13, 0, 0.05), (-0.13, 0, 0.05), (0.0, 0.0, 0.036), (0.065, 0.0, 0.036), (-0.065, 0.0, 0.036)], 0.05, 0.04)
    )
    mesh.add(
        sections(
            [
                (-0.147, 0.020, -0.035, 0.02),
                (-0.13, 0.027, -0.052, 0.032),
                (0.13, 0.027, -0.052, 0.032),
                (0.147, 0.020, -0.035, 0.02),
            ],
            0.006,
        ),
        RED,
    )
    mesh.add(side([(-0.12, -0.055), (-0.11, -0.064), (0.11, -0.064), (0.12, -0.055)], -0.05, 0.05), RED).add(
        box(0.12, 0.06, 0.006), BLACK, (0, 0, -0.066)
    )
    if front:
        mesh.add(prism(rounded(0.03, 0.07, 0.012, 2), -0.045, 0.015, 0.005), BLACK, (0.160, 0, 0))
        mesh.add(rod(0.013, 0, 0.022, 10), GLASS, (0.160, 0, -0.02), X).add_pair(
            rod(0.009, 0, 0.019, 8), LAMP, (0.160, 0.022, -0.02), X
        )
    else:
        mesh.add(rod(0.004, -0.064, -0.09, 6), METAL, (0.08, 0, 0))
    return mesh


def soryu_joint():
    """Bellows between two bodies."""
    mesh = Mesh()
    for i in range(-2, 3):
        mesh.add(rod(0.030, -0.008, 0.0, 12, second=0.022), BLACK, (0.016 * i, 0, -0.01), X).add(
            rod(0.022, 0.0, 0.008, 12, second=0.030), BLACK, (0.016 * i, 0, -0.01), X
        )
    return mesh


FILES = {
    "robots/Matilda": {"body.glb": matilda, "sick.glb": hokuyo},
    "robots/Rugbot": {"body.glb": rugbot, "flipper.glb": rugbot_flipper, "sick.glb": sick_yellow},
    "robots/Talon": {"body.glb": talon, "hokuyo.glb": hokuyo},
    "robots/Tarantula": {
        "body.glb": tarantula,
        "flipper.glb": lambda: flipper(0.055, 0.035, 0.16, 0.04, YELLOW),
        "hokuyo.glb": hokuyo,
    },
    "robots/Crawler_Robot": {
        "body.glb": crawler,
        "flipper.glb": lambda: flipper(0.055, 0.035, 0.2, 0.05, ORANGE),
        "hokuyo.glb": hokuyo,
    },
    "robots/TeleMax": {"body.glb": telemax, "flipper.glb": telemax_flipper, "hokuyo.glb": hokuyo},
    "robots/Soryu": {"body.glb": soryu_shell, "front.glb": lambda: soryu_shell(True), "joint.glb": soryu_joint},
}
