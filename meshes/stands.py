"""What stands: a base station, a camera on a post, a post for a gripper, and what two Pioneers carry."""

import math

from parts import add_camera
from solids import *


def station():
    """A rugged case with an open laptop, and a mast with antennas on a tripod's foot."""
    mesh = (
        Mesh()
        .add(prism(rounded(0.46, 0.36, 0.03, 2), -0.24, -0.02, 0.0), OLIVE)
        .add(prism(rounded(0.47, 0.37, 0.03, 2), -0.30, -0.25, 0.012), OLIVE)
    )
    mesh.add(prism(rounded(0.45, 0.35, 0.03, 1), -0.25, -0.24), BLACK)
    for y in (-0.11, 0.11):
        mesh.add(box(0.012, 0.05, 0.06), BLACK, (0.232, y, -0.25)).add(box(0.03, 0.05, 0.02), BLACK, (-0.235, y, -0.25))
    mesh.add(tube([(0.23, -0.05, -0.15), (0.26, -0.05, -0.15), (0.26, 0.05, -0.15), (0.23, 0.05, -0.15)], 0.008), BLACK)
    for x in (-0.2, 0.2):
        mesh.add_pair(rod(0.02, -0.02, 0.0, 8), BLACK, (x, 0.15, 0))
    mesh.add(box(0.22, 0.31, 0.014), DARK, (0.03, -0.01, -0.307)).add(box(0.15, 0.27, 0.002), GREY, (0.045, -0.01, -0.3145))
    lid = [(0.0, 0.0), (-0.075, -0.20), (-0.087, -0.197), (-0.012, 0.0)]
    mesh.add(side(lid, -0.155, 0.155), DARK, (-0.08, -0.01, -0.31))
    mesh.add(
        side([(0.0, 0.0), (-0.066, -0.176), (-0.068, -0.175), (-0.002, 0.0)], -0.14, 0.14),
        (0.25, 0.50, 0.80),
        (-0.0815, -0.01, -0.322),
    )
    mesh.add(box(0.05, 0.05, 0.30), DARK, (-0.24, 0.12, -0.15)).add(rod(0.018, -0.28, -0.85, 10), METAL, (-0.24, 0.12, 0)).add(
        rod(0.013, -0.85, -1.08, 8), METAL, (-0.24, 0.12, 0)
    )
    mesh.add(rod(0.024, -0.82, -0.88, 10), BLACK, (-0.24, 0.12, 0)).add(box(0.02, 0.22, 0.02), METAL, (-0.24, 0.12, -0.98))
    for y in (0.01, 0.23):
        mesh.add(rod(0.011, -0.99, -1.22, 8), WHITE, (-0.24, y, 0)).add(rod(0.014, -0.97, -1.0, 8), BLACK, (-0.24, y, 0))
    return mesh.add(ball(0.02, 8), RED, (-0.24, 0.12, -1.10))


def post():
    """A post of 1.5 m with a camera at its top."""
    mesh = Mesh().add(rod(0.14, 0.0, -0.03, 20), DARK).add(rod(0.05, -0.03, -0.10, 12, second=0.028), DARK)
    mesh.add(rod(0.025, -0.10, -0.95, 10), METAL).add(rod(0.030, -0.93, -0.98, 10), BLACK).add(rod(0.019, -0.98, -1.46, 10), METAL)
    mesh.add(tube([(0.03, 0, -0.04), (0.035, 0, -0.7), (0.03, 0, -1.45)], 0.005, 5), BLACK)
    add_camera(mesh, (0.10, 0, -1.52), 0.12)
    return mesh.add(box(0.10, 0.12, 0.008), WHITE, (0.03, 0, -1.575))


def bracket():
    """A post from the ground with an arm that holds a gripper."""
    mesh = (
        Mesh()
        .add(rod(0.12, 0, -0.02, 16), DARK)
        .add(rod(0.024, -0.02, -1.60, 10), METAL)
        .add(box(0.06, 0.08, 0.06), DARK, (0, 0, -1.60))
    )
    mesh.add(tube([(0, 0, -1.0), (0, 0, -1.40)], 0.030, 8), YELLOW)
    return mesh.add(box(0.06, 0.05, 0.05), GREY, (0.04, 0, -1.62))


def talking_head():
    """A head on a mast."""
    mesh = (
        Mesh()
        .add(rod(0.05, -0.15, -0.16, 12), DARK)
        .add(rod(0.016, -0.15, -0.80, 10), METAL)
        .add(rod(0.03, -0.79, -0.83, 12), BLACK)
    )
    mesh.add(prism(rounded(0.10, 0.15, 0.04, 2), -0.98, -0.83, 0.03), (0.80, 0.70, 0.55))
    for y in (-0.035, 0.035):
        mesh.add(rod(0.021, 0.03, 0.056, 12), WHITE, (0, y, -0.93), X).add(rod(0.010, 0.03, 0.059, 8), BLACK, (0, y, -0.93), X)
        mesh.add(box(0.010, 0.045, 0.008), DARK, (0.05, y, -0.960))
    mesh.add(box(0.012, 0.06, 0.012), RED, (0.048, 0, -0.865)).add(rod(0.008, 0.03, 0.056, 8), GLASS, (0, 0, -0.90), X)
    return mesh


def stereo():
    """Two cameras on a bar; the origin is between their lenses."""
    mesh = (
        Mesh()
        .add(box(0.03, 0.20, 0.014), METAL, (-0.03, 0, 0.024))
        .add(rod(0.012, 0.03, 0.16, 10), METAL, (-0.03, 0, 0))
        .add(rod(0.04, 0.235, 0.25, 12), DARK, (-0.03, 0, 0))
    )
    mesh.add(rod(0.014, 0.10, 0.25, 10), DARK, (-0.03, 0, 0))
    for y in (-0.06, 0.06):
        mesh.add(box(0.05, 0.044, 0.036), BLACK, (-0.046, y, 0)).add(rod(0.015, -0.025, -0.004, 10), DARK, (0, y, 0), X).add(
            rod(0.010, -0.02, -0.002, 8), GLASS, (0, y, 0), X
        )
    return mesh


# A Canon VC-C4: a round foot, a yoke that pans, and a head that tilts in it.


def camera_foot():
    return Mesh().add(prism(rounded(0.09, 0.08, 0.03, 3), -0.03, 0.0, 0.006), DARK).add(rod(0.032, -0.029, -0.041, 16), BLACK)


def camera_yoke():
    """About its joint, which pans."""
    mesh = Mesh().add(rod(0.031, 0.0, -0.006, 16), DARK)
    return mesh.add_pair(strap((0, -0.004, 0.016), (0, -0.030, 0.014), -0.005, 0.005), DARK, (0, 0.04, 0))


def camera_head():
    """About its joint, which tilts; its lens looks ahead."""
    mesh = Mesh().add(rod(0.014, -0.042, 0.042, 12), GREY, turn=Y).add(prism(rounded(0.062, 0.062, 0.02, 2), -0.026, 0.026, 0.008), BLACK)
    return mesh.add(rod(0.023, 0.02, 0.042, 14, second=0.02), DARK, turn=X).add(rod(0.016, 0.03, 0.045, 12), GLASS, turn=X)


FILES = {
    "actuators/CameraPanTilt": {"foot.glb": camera_foot, "yoke.glb": camera_yoke, "head.glb": camera_head},
    "robots/ComStation": {"body.glb": station},
    "robots/MultiView": {"post.glb": post},
    "robots/GripperBase": {"post.glb": bracket},
    "robots/Cramer": {"head.glb": talking_head},
    "robots/StereoP2AT": {"cameras.glb": stereo},
}
