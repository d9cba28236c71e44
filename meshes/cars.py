"""Cars on the road: bodies with wheel arches, glass and lamps. Lengths, wheel bases and heights as in robot.toml; z is 0 at the axles."""

import math

from parts import car_wheel, wheel
from solids import *


def body(mesh, colour, stations, axles, arch, half, sill):
    """A body along x with arches over its wheels. Stations: x, half width of its shoulder, z of its top edge and of its shoulder; between
    them all is straight. Its sides end at `sill`, over the wheels at the arches; its widest half is `half`."""

    def at(x):
        for a, b in zip(stations, stations[1:]):
            if a[0] <= x <= b[0]:
                part = (x - a[0]) / (b[0] - a[0])
                return [p + part * (q - p) for p, q in zip(a, b)][1:]
        raise ValueError(x)

    cuts = {x for x, *_ in stations}
    for axle in axles:
        cuts |= {axle + arch * math.cos(math.pi * i / 8) for i in range(9)}
    rings = []
    for x in sorted(it for it in cuts if stations[0][0] <= it <= stations[-1][0]):
        wide, top, shoulder = at(x)
        low = min([sill] + [-math.sqrt(max(arch**2 - (x - axle) ** 2, 0)) for axle in axles if abs(x - axle) < arch - 1e-9])
        wide = min(wide, half)
        waist = (low + shoulder) / 2
        right = [(0.97 * wide, low), (wide, min(waist, low - 0.02)), (wide, shoulder), (0.88 * wide, top)]
        rings.append([(x, y, z) for y, z in right] + [(x, -y, z) for y, z in right[::-1]])
    mesh.add(loft(rings), colour)
    first, last = stations[0][0], stations[-1][0]
    inner = 0.62 * half  # the floor between the wheels
    return mesh.add(box(last - first - 0.2, 2 * inner, sill + 0.30), BLACK, ((first + last) / 2, 0, (sill - 0.30) / 2))


def cabin(mesh, colour, low, high, top, bottom, pillars, glass=GLASS, roof=None):
    """A roof on pillars with glass between: (x behind, x ahead, half width) at the bottom and at the top; x of the pillars' middle."""
    skin = lambda part, out: [low[i] + (high[i] - low[i]) * part + out[i] for i in range(3)]
    z = lambda part: bottom + (top - bottom) * part
    mesh.add(frustum(skin(0, (0, 0, 0)), skin(0.86, (0, 0, 0)), z(0.86), z(0)), glass)
    crown = [(skin(0.84, (-0.012, 0.012, 0.010)), 0.84), (skin(0.95, (0, 0, 0)), 0.95), (skin(1.0, (0.06, -0.08, -0.06)), 1.0)]
    mesh.add(loft([[(a, -h, z(p)), (b, -h, z(p)), (b, h, z(p)), (a, h, z(p))] for (a, b, h), p in crown]), roof or colour)
    for sign in (-1, 1):
        posts = [(low[0] + 0.03, high[0] + 0.03, 0.075), (low[1] - 0.03, high[1] - 0.03, 0.05)] + [(x, x, 0.045) for x in pillars]
        for a, b, wide in posts:
            b = a + (b - a) * 0.86
            ha, hb = low[2] + 0.004, skin(0.86, (0, 0, 0))[2] + 0.004
            mesh.add(
                loft(
                    [
                        [
                            (a - wide, sign * (ha - 0.05), z(0)),
                            (a + wide, sign * (ha - 0.05), z(0)),
                            (a + wide, sign * ha, z(0)),
                            (a - wide, sign * ha, z(0)),
                        ],
                        [
                            (b - wide, sign * (hb - 0.05), z(0.86)),
                            (b + wide, sign * (hb - 0.05), z(0.86)),
                            (b + wide, sign * hb, z(0.86)),
                            (b - wide, sign * hb, z(0.86)),
                        ],
                    ]
                ),
                colour,
            )
    return mesh


def arches(mesh, colour, axles, arch, half, width=0.05):
    for axle in axles:
        mesh.add_pair(arc(arch - 0.015, 0.05, width, 0.0, math.pi, 8), colour, (axle, half - width / 2 + 0.012, 0))
    return mesh


def doors(mesh, xs, half, top, bottom):
    """Seams and handles."""
    for x in xs:
        mesh.add_pair(box(0.012, 0.006, bottom - top), BLACK, (x, half + 0.001, (top + bottom) / 2))
    for x in xs[1:]:
        mesh.add_pair(box(0.13, 0.02, 0.024), METAL, (x + 0.14, half, top + 0.07))
    return mesh


def mirrors(mesh, colour, at):
    return mesh.add_pair(box(0.09, 0.15, 0.10), colour, at).add_pair(box(0.02, 0.12, 0.08), GLASS, (at[0] - 0.045, at[1], at[2]))


def cooper():
    """A Mini: short, upright, with a white roof, stripes on the bonnet and round lamps."""
    mesh, half, axles = Mesh(), 0.83, (-1.235, 1.235)
    stations = [
        (-1.80, 0.66, -0.34, -0.20),
        (-1.72, 0.78, -0.52, -0.36),
        (-1.35, 0.83, -0.56, -0.44),
        (0.75, 0.83, -0.56, -0.42),
        (1.35, 0.82, -0.50, -0.36),
        (1.70, 0.76, -0.42, -0.26),
        (1.80, 0.64, -0.28, -0.16),
    ]
    body(mesh, RED, stations, axles, 0.34, half, 0.12)
    cabin(mesh, RED, (-1.62, 0.72, 0.74), (-1.36, 0.28, 0.60), -1.12, -0.54, (-0.22,), roof=WHITE)
    arches(mesh, BLACK, axles, 0.33, half)
    mesh.add_pair(box(1.75, 0.02, 0.09), BLACK, (0, half - 0.01, 0.09))
    for sign in (-1, 1):  # stripes
        mesh.add(
            loft(
                [
                    [
                        (x, sign * y, z - 0.006),
                        (x, sign * (y + 0.13), z - 0.006),
                        (x, sign * (y + 0.13), z + 0.01),
                        (x, sign * y, z + 0.01),
                    ]
                    for x, y, z in ((0.78, 0.20, -0.562), (1.35, 0.20, -0.502), (1.66, 0.20, -0.432))
                ]
            ),
            WHITE,
        )
    mesh.add_pair(rod(0.125, -0.08, 0.075, 14), METAL, (1.72, 0.53, -0.27), X).add_pair(
        rod(0.105, 0.0, 0.09, 14), LAMP, (1.72, 0.53, -0.27), X
    )
    mesh.add(box(0.05, 0.62, 0.10), BLACK, (1.785, 0, -0.20)).add(box(0.055, 0.66, 0.02), METAL, (1.79, 0, -0.26))
    mesh.add(box(0.055, 0.70, 0.10), BLACK, (1.80, 0, 0.03))
    mesh.add_pair(rod(0.055, 0.0, 0.05, 10), LAMP, (1.78, 0.50, 0.0), X)
    for x, z in ((1.82, -0.07), (-1.81, -0.02)):
        mesh.add(box(0.06, 1.30, 0.08), METAL, (x, 0, z))
    mesh.add_pair(box(0.05, 0.12, 0.24), RED_LAMP, (-1.765, 0.62, -0.30)).add(box(0.03, 0.5, 0.11), WHITE, (-1.80, 0, -0.14))
    mesh.add_pair(rod(0.03, -0.06, 0.0, 8), METAL, (-1.80, 0.10, 0.09), X)
    doors(mesh, [0.66, -0.50], half, -0.42, 0.08)
    return mirrors(mesh, WHITE, (0.52, 0.86, -0.60))


def sedan():
    mesh, half, axles = Mesh(), 0.86, (-1.35, 1.35)
    stations = [
        (-2.19, 0.66, -0.40, -0.24),
        (-2.12, 0.80, -0.55, -0.40),
        (-1.55, 0.86, -0.60, -0.48),
        (0.90, 0.86, -0.58, -0.45),
        (1.60, 0.84, -0.50, -0.36),
        (2.08, 0.76, -0.40, -0.25),
        (2.19, 0.62, -0.28, -0.16),
    ]
    body(mesh, BLUE, stations, axles, 0.37, half, 0.14)
    cabin(mesh, BLUE, (-1.62, 1.00, 0.76), (-1.02, 0.26, 0.60), -1.13, -0.57, (-0.18,))
    doors(mesh, [0.86, -0.20, -1.02], half, -0.45, 0.10)
    mesh.add_pair(box(2.0, 0.012, 0.03), BLACK, (-0.1, half, -0.16))
    for sign in (-1, 1):
        lamp = [(2.0, 0.40), (2.195, 0.40), (2.187, 0.60), (2.105, 0.74), (1.98, 0.785)]
        mesh.add(prism([(x, sign * y) for x, y in lamp], -0.30, -0.19, 0.03), LAMP)
    mesh.add(box(0.05, 0.62, 0.13), BLACK, (2.175, 0, -0.21))
    for z in (-0.245, -0.21, -0.175):
        mesh.add(box(0.055, 0.58, 0.012), METAL, (2.18, 0, z))
    mesh.add(box(0.05, 1.1, 0.10), BLACK, (2.17, 0, 0.04)).add_pair(rod(0.05, 0, 0.03, 10), LAMP, (2.17, 0.60, 0.03), X)
    mesh.add(box(0.06, 1.30, 0.09), BLUE, (2.19, 0, -0.05)).add(box(0.06, 1.34, 0.11), BLUE, (-2.19, 0, -0.03))
    mesh.add_pair(box(0.10, 0.34, 0.13), RED_LAMP, (-2.135, 0.57, -0.34), (0, 0, -0.22)).add(
        box(0.03, 0.52, 0.11), WHITE, (-2.20, 0, -0.20)
    )
    mesh.add(rod(0.04, -0.1, 0.0, 8), METAL, (-2.16, 0.5, 0.09), X)
    return mirrors(mesh, BLUE, (0.68, 0.90, -0.64))


def hummer():
    """A HMMWV: wide, flat, high over the ground, with a raked back."""
    mesh, half, axles = Mesh(), 1.05, (-1.65, 1.65)
    stations = [
        (-2.28, 1.00, -0.60, -0.50),
        (-2.2, 1.05, -0.66, -0.56),
        (0.75, 1.05, -0.70, -0.56),
        (0.85, 1.05, -0.68, -0.50),
        (2.10, 1.00, -0.52, -0.34),
        (2.27, 0.92, -0.40, -0.28),
    ]
    body(mesh, SAND, stations, axles, 0.54, half, 0.02)
    cabin(mesh, SAND, (-2.10, 0.72, 0.98), (-1.05, 0.46, 0.90), -1.37, -0.66, (-0.62,))
    mesh.add(
        loft(
            [
                [(-2.12, -0.99, -0.64), (-2.12, 0.99, -0.64), (-2.12, 0.99, -0.60), (-2.12, -0.99, -0.60)],
                [(-1.05, -0.93, -1.34), (-1.05, 0.93, -1.34), (-1.05, 0.93, -0.60), (-1.05, -0.93, -0.60)],
            ]
        ),
        SAND,
    )  # the raked back
    doors(mesh, [0.70, -0.58, -1.05], half, -0.56, -0.02)
    mesh.add(box(0.05, 0.95, 0.22), BLACK, (2.26, 0, -0.30))
    for i in range(8):
        mesh.add(box(0.06, 0.035, 0.22), SAND, (2.265, -0.42 + 0.12 * i, -0.30))
    mesh.add_pair(rod(0.115, 0.0, 0.05, 14), BLACK, (2.24, 0.68, -0.30), X).add_pair(
        rod(0.095, 0.0, 0.06, 14), LAMP, (2.24, 0.68, -0.30), X
    )
    mesh.add_pair(box(0.05, 0.06, 0.08), ORANGE, (2.27, 0.86, -0.32))
    for x, z in ((2.32, 0.0), (-2.30, -0.02)):
        mesh.add(box(0.10, 1.9, 0.16), BLACK, (x, 0, z))
    mesh.add_pair(box(0.10, 0.05, 0.14), RED, (2.38, 0.40, -0.01)).add_pair(box(0.05, 0.14, 0.14), RED_LAMP, (-2.29, 0.86, -0.30))
    mesh.add(rod(0.42, -0.02, -0.20, 18), RUBBER, (-2.26, 0, -0.40), X).add(rod(0.22, -0.18, -0.21, 14), SAND, (-2.26, 0, -0.40), X)
    mesh.add(box(0.55, 0.9, 0.03), DARK, (1.45, 0, -0.615), (0, 0.136, 0))
    mesh.add(rod(0.05, -0.40, -1.30, 10), BLACK, (0.92, 0.99, 0)).add(box(0.3, 0.10, 0.2), BLACK, (1.1, 1.02, -0.55))  # snorkel
    mesh.add_pair(rod(0.012, -0.6, -1.9, 6), BLACK, (-2.05, 0.95, 0))
    return mirrors(mesh, BLACK, (0.72, 1.12, -0.86))


FILES = {
    "robots/Cooper": {"body.glb": cooper, "wheel.glb": lambda: car_wheel(0.29, 0.18, 0.20, 8, WHITE)},
    "robots/Sedan": {"body.glb": sedan, "wheel.glb": lambda: car_wheel(0.32, 0.2, 0.22, 5)},
    "robots/Hummer": {"body.glb": hummer, "wheel.glb": lambda: wheel(0.46, 0.3, 0.23, 14, 8, SAND, 20)},
}
