"""Industrial arms: castings between joints, as six-axis arms of KUKA and FANUC look. Places of joints as in actuator.toml.

A mesh's origin is its joint; every joint is at 0.
"""

import math

from parts import kinect
from solids import *

FANUC = (0.95, 0.77, 0.10)
PALE = (0.86, 0.87, 0.88)


class Six:
    """A six-axis arm: places of its joints and its tip, radii of shoulder, elbow, wrist and flange, colour."""

    def __init__(self, joints, base, shoulder, elbow, wrist, aside, colour, base_top=None):
        self.joints, self.base, self.shoulder, self.elbow, self.wrist = joints, base, shoulder, elbow, wrist
        self.aside, self.colour = aside, colour  # y of the link arm's middle
        self.top = base_top if base_top is not None else joints[0][2]

    def step(self, i):
        """From one joint to the next, the first being 1."""
        return [b - a for a, b in zip(self.joints[i - 1], self.joints[i])]

    def foot(self):
        """From the ground to the turntable."""
        r, top, (x, y, _) = self.base, self.top, self.joints[0]
        mesh = Mesh().add(prism(rounded(2.7 * r, 2.5 * r, 0.5 * r, 2), -0.12 * r, 0.0, 0.03 * r), self.colour, (x, y, 0))
        corners = [(x + sx * r, y + sy * r, 0) for sx in (-1.15, 1.15) for sy in (-1, 1)]
        mesh.add_at(rod(0.09 * r, 0, -0.17 * r, 6), DARK, corners)
        low = [(px * 1.06, py * 1.06) for px, py in rounded(2.0 * r, 2.0 * r, 0.85 * r, 3)]
        high = rounded(1.84 * r, 1.84 * r, 0.91 * r, 3)
        mesh.add(
            loft(
                [
                    [(px, py, z) for px, py in o]
                    for o, z in [(low, -0.10 * r), (low, -0.35 * r), (high, top + 0.25 * r), (high, top + 0.08 * r)]
                ]
            ),
            self.colour,
            (x, y, 0),
        )
        mesh.add(box(0.5 * r, 1.0 * r, 0.55 * r), DARK, (x - 1.05 * r, y, -0.42 * r))  # plugs
        mesh.add(rod(0.10 * r, 0, 0.12 * r, 8), BLACK, (x - 1.40 * r, y, -0.42 * r), X)
        return mesh.add(rod(0.86 * r, top + 0.1 * r, top - 0.02 * r, 14), DARK, (x, y, 0))

    def carousel(self):
        """From the turntable to the shoulder."""
        r, s, a, (dx, dy, dz) = self.base, self.shoulder, self.aside, self.step(1)
        up = self.top - self.joints[0][2]  # below the joint is positive
        w = 1.25 * s
        mesh = Mesh().add(rod(0.95 * r, up - 0.01 * r, up - 0.16 * r, 16), self.colour)
        ring_of = lambda cx, cy, z, lx, ly: [(cx + px, cy + py, z) for px, py in rounded(lx, ly, 0.3 * min(lx, ly), 2)]
        edge = dy + a + 0.55 * s  # the shoulder ends here, beside the link arm
        mid = edge + w / 2
        mesh.add(
            loft(
                [
                    ring_of(0, 0, up - 0.1 * r, 1.7 * r, 1.6 * r),
                    ring_of(0.3 * dx, mid * 0.5, up + 0.45 * (dz - up), 1.5 * r, 1.35 * w),
                    ring_of(dx, mid, dz + 0.2 * s, 1.7 * s, w),
                ]
            ),
            self.colour,
        )
        mesh.add(rod(s, edge, edge + w, 14), self.colour, (dx, 0, dz), (-math.pi / 2, 0, 0))
        mesh.add(rod(0.62 * s, edge + w, edge + w + 0.08 * s, 14), DARK, (dx, 0, dz), (-math.pi / 2, 0, 0))
        mesh.add(rod(0.40 * r, up - 0.1 * r, up - 1.15 * r, 8), BLACK, (-0.62 * r, 0.35 * r, 0))  # motor of the first axis
        mesh.add(rod(0.30 * r, up - 1.15 * r, up - 1.32 * r, 8), GREY, (-0.62 * r, 0.35 * r, 0))
        return mesh

    def link(self):
        """From shoulder to elbow, beside them, with the motor of the second axis."""
        s, e, a, (dx, dy, dz) = self.shoulder, self.elbow, self.aside, self.step(2)
        near, far = a - 0.5 * s, a + 0.5 * s
        mesh = Mesh().add(strap((0, 0, s), (dx, dz, 1.08 * e), near, far, 0.10 * s), self.colour)
        cut = lambda part, r: (dx * part, dz * part, r)
        mesh.add(
            strap(cut(0.27, 0.52 * s), cut(0.76, 0.55 * e), near - 0.012 * s, far + 0.012 * s, 0, 4),
            tuple(0.72 * part for part in self.colour),
        )  # its hollow
        for x, z, r in ((0, 0, s), (dx, dz, e)):
            mesh.add(rod(0.70 * r, near - 0.10 * r, near + 0.1 * r, 10), DARK, (x, 0, z), (-math.pi / 2, 0, 0))
        mesh.add(rod(0.50 * s, near, near - 0.75 * s, 8), BLACK, (0, 0, 0), (-math.pi / 2, 0, 0))
        return mesh.add(rod(0.38 * s, near - 0.75 * s, near - 0.92 * s, 8), GREY, (0, 0, 0), (-math.pi / 2, 0, 0))

    def arm(self):
        """From the elbow to where the forearm turns, with the motors of the wrist behind."""
        s, e, a, (dx, dy, dz) = self.shoulder, self.elbow, self.aside, self.step(3)
        edge = a + 0.5 * s + 0.02 * e
        middle = dy
        far = max(middle + 1.0 * e, edge + 1.4 * e)
        mesh = Mesh().add(rod(1.02 * e, edge, far, 14), self.colour, turn=(-math.pi / 2, 0, 0))
        back = -1.25 * e
        block = lambda x, k: [(x, middle + py * k, dz + pz * k) for py, pz in rounded(1.9 * e, 1.9 * e, 0.6 * e, 2)]
        mesh.add(
            loft([block(back, 0.92), block(back + 0.2 * e, 1.0), block(0.55 * dx, 1.0), block(dx - 0.1 * e, 0.9), block(dx, 0.86)]),
            self.colour,
        )
        mesh.add(rod(0.62 * e, far - 0.02 * e, far + 0.05 * e, 14), DARK, turn=(-math.pi / 2, 0, 0))
        for i, (y, z) in enumerate(((-0.5, 0.42), (0.5, 0.42), (0, -0.45))):
            at = (back, middle + y * e, dz + z * e)
            mesh.add(rod(0.36 * e, 0.05 * e, -1.0 * e, 8), BLACK, at, X).add(rod(0.27 * e, -1.0 * e, -1.15 * e, 8), GREY, at, X)
        return mesh.add(rod(0.80 * e, dx - 0.02 * e, dx + 0.001, 14), DARK, (0, middle, dz), X)

    def forearm(self):
        """The tube that turns, and its fork."""
        e, w, (dx, dy, dz) = self.elbow, self.wrist, self.step(4)
        stations = [(0.0, 0.84 * e), (0.12 * dx, 0.84 * e), (0.2 * dx, 0.72 * e), (0.7 * dx, 1.05 * w), (dx - 0.95 * w, 1.02 * w)]
        mesh = Mesh().add(
            loft([[(x, dy * x / dx + r * math.cos(t), r * math.sin(t)) for t in angles(12)] for x, r in stations]), self.colour
        )
        for y in (-0.86, 0.66):
            mesh.add(strap((dx - 1.1 * w, 0, 0.95 * w), (dx, 0, 0.82 * w), dy + y * w, dy + (y + 0.2) * w), self.colour)
        return mesh.add(rod(0.5 * w, -0.95 * w, 0.95 * w, 10), DARK, (dx, dy, 0), Y)

    def hand(self):
        """What nods in the fork."""
        w, (dx, dy, dz) = self.wrist, self.step(5)
        mesh = Mesh().add(rod(0.78 * w, -0.62 * w, 0.62 * w, 14), self.colour, turn=Y)
        reach = max(dx, 0.7 * w)
        return mesh.add(
            loft(
                [
                    [(x, dy * x / reach + r * math.cos(t), r * math.sin(t)) for t in angles(12)]
                    for x, r in ((0, 0.66 * w), (0.75 * reach, 0.62 * w), (reach, 0.56 * w))
                ]
            ),
            self.colour,
        )

    def flange(self):
        w, (dx, dy, dz) = self.wrist, self.step(6)
        mesh = Mesh().add(rod(0.5 * w, 0, 0.6 * dx, 14), METAL, turn=X).add(rod(0.42 * w, 0.6 * dx, dx, 14), DARK, turn=X)
        for i in range(4):
            t = math.pi / 4 + i * math.pi / 2
            mesh.add(rod(0.06 * w, dx - 0.002, dx + 0.004, 6), METAL, (0, 0.3 * w * math.cos(t), 0.3 * w * math.sin(t)), X)
        return mesh

    def files(self):
        return {
            "foot.glb": self.foot,
            "carousel.glb": self.carousel,
            "link.glb": self.link,
            "arm.glb": self.arm,
            "forearm.glb": self.forearm,
            "hand.glb": self.hand,
            "flange.glb": self.flange,
        }


KR3 = Six(
    [
        (0, 0, -0.21),
        (0.1, 0, -0.35),
        (0.1, 0, -0.615),
        (0.235, 0, -0.615),
        (0.37, 0, -0.615),
        (0.4225, 0, -0.615),
        (0.445, 0, -0.615),
    ],
    0.10,
    0.058,
    0.050,
    0.036,
    -0.062,
    ORANGE,
)
KR5 = Six(
    [(0, 0, -0.24), (0.18, 0, -0.4), (0.18, 0, -1.0), (0.49, 0, -1.12), (0.8, 0, -1.12), (0.8805, 0, -1.12), (0.915, 0, -1.12)],
    0.155,
    0.10,
    0.082,
    0.056,
    -0.105,
    ORANGE,
)
KR6 = Six(
    [
        (0, 0, -0.405),
        (0.26, 0, -0.675),
        (0.26, 0, -1.355),
        (0.595, 0, -1.39),
        (0.93, 0, -1.39),
        (1.0406, 0, -1.39),
        (1.088, 0, -1.39),
    ],
    0.20,
    0.13,
    0.105,
    0.075,
    -0.135,
    ORANGE,
    -0.32,
)
KR60 = Six(
    [
        (0.07, 0.01, -0.413),
        (0.494, -0.2, -0.796),
        (0.49, -0.14, -1.801),
        (0.981, 0.022, -1.97),
        (1.473, 0.09, -1.97),
        (1.625, 0.02, -1.97),
        (1.702, 0.02, -1.97),
    ],
    0.34,
    0.19,
    0.165,
    0.115,
    0.0,
    ORANGE,
    -0.34,
)
M16 = Six(
    [
        (0.052, 0, -0.384),
        (0.204, -0.112, -0.384),
        (0.2, -0.112, -1.156),
        (0.384, 0, -1.256),
        (0.944, 0, -1.256),
        (1.036, 0, -1.256),
        (1.075, 0, -1.256),
    ],
    0.20,
    0.13,
    0.115,
    0.072,
    -0.02,
    FANUC,
    -0.20,
)


# KUKA LWR: rounded shells that twist in turn, orange with pale joints. Places as in actuator.toml.


def lwr_foot():
    mesh = Mesh().add(prism(rounded(0.22, 0.22, 0.06, 3), -0.02, 0, 0.005), PALE)
    mesh.add(turned([(-0.015, 0.098), (-0.05, 0.088), (-0.10, 0.068), (-0.118, 0.066)], 20), ORANGE)
    return mesh.add(box(0.05, 0.08, 0.05), DARK, (-0.10, 0, -0.035))


def lwr_twist(length, wide, narrow):
    """A shell from a joint about z up to one about x."""
    mesh = Mesh().add(rod(1.02 * wide, 0.003, -0.014, 20), PALE)
    mesh.add(turned([(-0.012, 0.98 * wide), (-0.4 * length, 0.95 * wide), (-0.7 * length, 0.9 * wide)], 18), ORANGE)
    mesh.add(rod(0.86 * narrow, -1.02 * narrow, 1.02 * narrow, 18), ORANGE, (0, 0, -length), X)
    for end in (-1, 1):
        mesh.add(rod(0.78 * narrow, 1.0 * end * narrow, 1.12 * end * narrow, 16, second=0.62 * narrow), PALE, (0, 0, -length), X)
    return mesh


def lwr_bend(length, wide, narrow):
    """A shell from a joint about x up to one about z."""
    mesh = Mesh().add(ball(0.97 * wide, 14), ORANGE)
    mesh.add(
        turned(
            [(-0.1 * wide, 0.80 * wide), (-0.45 * length, 0.88 * narrow), (-0.85 * length, narrow), (-length + 0.006, narrow)], 18
        ),
        ORANGE,
    )
    mesh.add(box(0.016, 2.02 * narrow, 0.3 * length), DARK, (0, 0, -0.62 * length))
    return mesh


def lwr_wrist():
    """Up to the seventh axis, from the fifth: it bears the sixth aside."""
    mesh = Mesh().add(rod(0.060, 0.003, -0.012, 18), PALE)
    mesh.add(
        loft(
            [
                [(x0 + r * math.cos(t), r * math.sin(t), z) for t in angles(16)]
                for z, r, x0 in ((-0.010, 0.057, 0), (-0.09, 0.052, -0.01), (-0.14, 0.044, -0.035), (-0.205, 0.040, -0.05))
            ]
        ),
        ORANGE,
    )
    return mesh.add(rod(0.036, -0.035, 0.010, 16), PALE, (-0.045, 0, -0.18), X)


def lwr_head():
    mesh = Mesh().add(ball(0.043, 14), ORANGE, (0.025, 0, 0)).add(rod(0.036, -0.006, 0.02, 14), PALE, turn=X)
    return mesh.add(turned([(0.0, 0.038), (-0.052, 0.036)], 16), ORANGE, (0.045, 0, 0))


def lwr_flange():
    mesh = Mesh().add(rod(0.034, 0.002, -0.03, 18), PALE).add(rod(0.0315, -0.03, -0.065, 18), METAL)
    return mesh.add(rod(0.012, -0.064, -0.067, 10), DARK)


LWR = {
    "foot.glb": lwr_foot,
    "twist.glb": lambda: lwr_twist(0.19, 0.064, 0.060),
    "bend.glb": lambda: lwr_bend(0.21, 0.060, 0.056),
    "wrist.glb": lwr_wrist,
    "head.glb": lwr_head,
    "flange.glb": lwr_flange,
}


# Small things that arms and stands carry.


def platform():
    """The plate under what is fixed to the ground: 0.6 x 0.6 m, with its bolts and a seam."""
    mesh = Mesh().add(prism(rounded(0.6, 0.6, 0.03, 1), -0.015, 0.0, 0.006), GREY)
    mesh.add(prism(rounded(0.47, 0.47, 0.02, 1), -0.018, -0.01), METAL)
    for x in (-0.262, 0.262):
        mesh.add_pair(rod(0.016, -0.014, -0.024, 6), DARK, (x, 0.262, 0))
    return mesh


def fork_mast():
    """Two rails with a chain and a ram between, about the axle at its foot."""
    mesh = (
        Mesh()
        .add_pair(box(0.042, 0.026, 0.50), YELLOW, (0.04, 0.135, -0.10))
        .add_pair(box(0.03, 0.016, 0.49), DARK, (0.046, 0.116, -0.10))
    )
    for z in (0.14, -0.13, -0.335):
        mesh.add(box(0.026, 0.27, 0.03), YELLOW, (0.034, 0, z))
    mesh.add(rod(0.016, 0.14, -0.12, 10), METAL, (0.035, 0, 0)).add(rod(0.022, 0.14, 0.0, 10), BLACK, (0.035, 0, 0))
    mesh.add_pair(box(0.006, 0.012, 0.46), BLACK, (0.052, 0.035, -0.10))
    return mesh.add(rod(0.022, -0.13, 0.13, 10), DARK, turn=Y)


def fork():
    """The carriage with its two tines; the origin is its middle."""
    mesh = Mesh().add(box(0.018, 0.27, 0.024), BLACK, (0.012, 0, -0.04)).add(box(0.018, 0.27, 0.024), BLACK, (0.012, 0, 0.04))
    for y in (-0.10, -0.04, 0.04, 0.10):
        mesh.add(box(0.010, 0.012, 0.18), BLACK, (0.006, y, -0.07))
    mesh.add(box(0.012, 0.24, 0.012), BLACK, (0.006, 0, -0.155))
    for y in (-0.08, 0.08):
        mesh.add(box(0.016, 0.044, 0.11), METAL, (0.026, y, -0.006))
        tine = loft(
            [
                [(x, y + s * w, z + t) for s, z in ((-1, 0.035), (1, 0.035), (1, 0.049), (-1, 0.049))]
                for x, w, t in ((0.02, 0.022, 0), (0.20, 0.022, 0), (0.272, 0.012, 0.0))
            ]
        )
        mesh.add(tine, METAL)
    return mesh


def gripper_body():
    mesh = Mesh().add(prism(rounded(0.105, 0.16, 0.02, 2), -0.03, 0.03, 0.006), RED, (0.0875, 0, 0))
    mesh.add(rod(0.036, 0.005, 0.04, 16), BLACK, turn=X).add(rod(0.042, 0.0, 0.010, 16), METAL, turn=X)
    mesh.add(box(0.05, 0.10, 0.004), DARK, (0.085, 0, -0.031))
    return mesh.add_pair(rod(0.018, -0.034, 0.034, 10), DARK, (0.14, 0.06, 0))


def finger():
    """A finger about the axle at its root, to the right; it looks the same from both sides."""
    outline = [(-0.010, 0.012), (0.11, 0.012), (0.172, 0.007), (0.172, -0.007), (0.11, -0.012), (-0.010, -0.012)]
    mesh = Mesh().add(prism(outline, -0.004, 0.026), METAL)
    mesh.add(prism([(0.10, 0.0145), (0.165, 0.0095), (0.165, -0.0095), (0.10, -0.0145)], -0.001, 0.023), RUBBER)
    return mesh.add(rod(0.013, -0.03, 0.032, 10), GREY)


def palm():
    mesh = Mesh().add(turned([(0.0, 0.046), (-0.008, 0.058), (-0.04, 0.058), (-0.052, 0.05)], 18), METAL)
    mesh.add(rod(0.0585, -0.016, -0.03, 18), DARK).add(rod(0.03, -0.05, -0.0535, 14), RUBBER)
    return mesh


def knuckle():
    return Mesh().add(rod(0.0135, 0.004, -0.010, 10), DARK)


def phalanx(length, colour):
    """A part of a finger up from its joint, round, with its pad all around."""
    mesh = Mesh().add(
        turned([(0.002, 0.007), (-0.004, 0.0105), (-0.5 * length, 0.0092), (-length + 0.004, 0.008), (-length, 0.005)], 10), colour
    )
    return mesh.add(rod(0.0094, -0.55 * length, -0.82 * length, 8), RUBBER).add(rod(0.0105, -0.011, 0.011, 8), DARK, turn=Y)


def carriage():
    """What runs below a rail; the arm hangs from it."""
    mesh = Mesh().add(prism(rounded(0.5, 0.46, 0.03, 1), 0.02, 0.15, 0.02), GREY).add(rod(0.24, 0.15, 0.192, 24), DARK)
    for x in (-0.17, 0.17):
        mesh.add_pair(box(0.11, 0.05, 0.10), DARK, (x, 0.185, -0.02))
        mesh.add_pair(rod(0.035, -0.02, 0.02, 12), METAL, (x, 0.165, -0.045), Y)
    mesh.add(rod(0.06, 0.0, 0.22, 12), BLACK, (0.25, 0.12, 0.085), X).add(box(0.12, 0.16, 0.10), YELLOW, (-0.29, 0, 0.08))
    return mesh


RAIL = (0.20, 0.36, 0.62)


def rail():
    """A beam of 4.4 m on two portals."""
    mesh = (
        Mesh()
        .add(box(4.4, 0.24, 0.05), RAIL, (0, 0, -3.225))
        .add(box(4.4, 0.24, 0.05), RAIL, (0, 0, -2.975))
        .add(box(4.4, 0.06, 0.24), RAIL, (0, 0, -3.1))
    )
    mesh.add_pair(box(4.3, 0.02, 0.03), METAL, (0, 0.13, -2.97))
    for i in range(9):
        mesh.add_pair(box(0.03, 0.09, 0.21), RAIL, (-1.92 + 0.48 * i, 0.07, -3.1))
    for x in (-2.1, 2.1):
        mesh.add(box(0.16, 2.0, 0.2), RAIL, (x, 0, -3.1)).add(
            box(0.05, 0.30, 0.30), YELLOW, (x + (0.12 if x > 0 else -0.12), 0, -3.1)
        )
        mesh.add_pair(box(0.15, 0.15, 3.0), RAIL, (x, 0.9, -1.5)).add_pair(box(0.32, 0.32, 0.03), GREY, (x, 0.9, -0.015))
        mesh.add_pair(box(0.05, 0.05, 0.75), RAIL, (x, 0.66, -2.78), (-math.pi / 4, 0, 0))
        mesh.add_pair(box(0.154, 0.154, 0.25), YELLOW, (x, 0.9, -0.35))
    return mesh


def two_link(length, colour):
    """A link along x between two round ends."""
    mesh = Mesh().add(
        side([(0.06, 0.05), (length - 0.06, 0.05), (length - 0.06, -0.05), (0.06, -0.05)], -0.05, 0.05, 0.012), colour
    )
    for x in (0.35, 0.7, 1.05, 1.4, 1.75):
        mesh.add(rod(0.026, -0.0515, 0.0515, 12), DARK, (x, 0, 0))
    mesh.add(rod(0.11, 0.055, -0.055, 20), colour).add(rod(0.06, 0.075, -0.075, 14), METAL)
    return mesh.add(rod(0.075, 0.055, -0.055, 16), colour, (length - 0.02, 0, 0))


def kinect_foot():
    return Mesh().add(prism(rounded(0.085, 0.105, 0.02, 2), -0.008, 0.010, 0.004), BLACK).add(rod(0.014, -0.006, -0.03, 10), DARK)


def kinect_head():
    """The bar over its hinge."""
    mesh, own = Mesh(), kinect()
    for colour, triangles in own.triangles.items():
        mesh.triangles[colour] = [tuple((x, y, z - 0.03) for x, y, z in it) for it in triangles]
    return mesh


def lift_plate():
    """The round plate of a Kiva, with its holes and a mark ahead."""
    mesh = Mesh().add(turned([(0.008, 0.185), (-0.002, 0.2), (-0.012, 0.2), (-0.018, 0.192)], 28), DARK)
    for i in range(8):
        t = (i + 0.5) * math.pi / 4
        mesh.add(rod(0.022, -0.0175, -0.0195, 10), BLACK, (0.15 * math.cos(t), 0.15 * math.sin(t), 0))
    mesh.add(rod(0.06, -0.0175, -0.020, 16), GREY)
    return mesh.add(prism([(0.185, 0.0), (0.12, 0.035), (0.12, -0.035)], -0.0205, -0.017), ORANGE)


FILES = {
    "actuators/KR3Arm": KR3.files(),
    "actuators/KR5Arm": KR5.files(),
    "actuators/KR6Arm": KR6.files(),
    "actuators/KR60Arm": KR60.files(),
    "actuators/FanucM16Arm": M16.files(),
    "actuators/Fanuc_M16iB20Arm": M16.files(),
    "actuators/kuka_lwr": LWR,
    "actuators/FanucCarriage": {"carriage.glb": carriage},
    "actuators/ForkliftArm": {"mast.glb": fork_mast, "fork.glb": fork},
    "actuators/GripperEffector": {"body.glb": gripper_body, "finger.glb": finger},
    "actuators/Hand": {
        "palm.glb": palm,
        "knuckle.glb": knuckle,
        "root.glb": lambda: phalanx(0.094, GREY),
        "tip.glb": lambda: phalanx(0.06, LIGHT),
    },
    "actuators/KinectActuator": {"foot.glb": kinect_foot, "head.glb": kinect_head},
    "actuators/TwoLinkArm": {"first.glb": lambda: two_link(2.1, BLUE), "second.glb": lambda: two_link(2.1, RED)},
    "actuators/kivaTop": {"plate.glb": lift_plate},
    "robots/Fanuc_Robot_And_Rail": {"rail.glb": rail},
} | {
    f"robots/{name}": {"platform.glb": platform}
    for name in ("FanucM16", "Fanuc_M16iB20", "KR3", "KR5", "KR6", "KR60", "KUKA_LWR_BOT", "StaticPlatform", "MultiView")
}
