#!/usr/bin/env python3
"""Makes the meshes by which the shipped robots are seen: every `*.glb` beside a robot.toml.

    python3 assets/robots/meshes.py

The same files, byte for byte, come of it each time. Meshes are only looked at: what touches the world is in robot.toml.
Frame and units as there: x forward, y right, z down, m, rad. Colours are red, green and blue, 0 to 1, sRGB.
A folder has all that its robot needs, so that it can be copied; a mesh of several robots is in each of their folders.
"""

import json
import math
import struct
from pathlib import Path

BLACK = (0.10, 0.10, 0.11)
RUBBER = (0.13, 0.13, 0.14)
DARK = (0.20, 0.21, 0.23)
GREY = (0.45, 0.47, 0.50)
METAL = (0.66, 0.67, 0.69)
LIGHT = (0.80, 0.80, 0.78)
GLASS = (0.13, 0.18, 0.24)
LAMP = (0.97, 0.94, 0.78)
RED_LAMP = (0.75, 0.08, 0.08)
RED = (0.74, 0.09, 0.14)
ORANGE = (0.93, 0.45, 0.12)
YELLOW = (0.90, 0.70, 0.12)
BLUE = (0.20, 0.36, 0.62)
GOLD = (0.74, 0.62, 0.34)

# Corners lie on multiples of 1/4096 m, which are short as decimals: logs and the page have them as text.
GRID = 4096


class Mesh:
    """Triangles by colour."""

    def __init__(self):
        self.triangles = {}

    def add(self, solid, colour, at=(0, 0, 0), turn=(0, 0, 0), stands=False):
        """Adds a closed solid, a list of convex polygons, turned by roll, pitch and yaw and put somewhere. Of one that stands on
        something its first polygon, the end at which its rings begin, is left out."""
        corners = [[placed(corner, at, turn) for corner in polygon] for polygon in solid]
        fan = lambda it: [(it[0], it[i], it[i + 1]) for i in range(1, len(it) - 1)]
        inward = sum(volume(it) for polygon in corners for it in fan(polygon)) < 0  # pages draw what is seen from outside
        for polygon in corners[1:] if stands else corners:
            triangles = [it for it in fan(polygon[::-1] if inward else polygon) if area(it) > 1e-10]
            self.triangles.setdefault(colour, []).extend(triangles)
        return self

    def add_pair(self, solid, colour, at, turn=(0, 0, 0)):
        """On the right and, mirrored by its place alone, on the left."""
        for side in (1, -1):
            self.add(solid, colour, (at[0], side * at[1], at[2]), (side * turn[0], turn[1], side * turn[2]))
        return self

    def count(self):
        return sum(map(len, self.triangles.values()))

    def glb(self):
        """A binary glTF 2.0 of one mesh, one primitive a colour. In glTF y is up."""
        binary, views, accessors, materials, primitives = b"", [], [], [], []

        def accessor(data, target, **kind):
            nonlocal binary
            views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), "target": target})
            accessors.append({"bufferView": len(views) - 1, **kind})
            binary += data + bytes(-len(data) % 4)
            return len(accessors) - 1

        for colour, triangles in self.triangles.items():
            corners = [tuple(round(part * GRID) / GRID + 0.0 for part in (x, -z, y)) for it in triangles for x, y, z in it]
            number = {corner: index for index, corner in enumerate(dict.fromkeys(corners))}
            indices = [number[corner] for corner in corners]
            least, most = ([pick(axis) for axis in zip(*number)] for pick in (min, max))
            position = accessor(
                b"".join(struct.pack("<3f", *corner) for corner in number), 34962,
                componentType=5126, count=len(number), type="VEC3", min=least, max=most,
            )
            index = accessor(
                struct.pack(f"<{len(indices)}H", *indices), 34963, componentType=5123, count=len(indices), type="SCALAR"
            )
            factor = [round(linear(part), 4) for part in colour] + [1]
            look = {"baseColorFactor": factor, "metallicFactor": 0, "roughnessFactor": 1}
            materials.append({"pbrMetallicRoughness": look})
            primitives.append({"attributes": {"POSITION": position}, "indices": index, "material": len(materials) - 1})
        root = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": primitives}], "materials": materials, "accessors": accessors,
            "bufferViews": views, "buffers": [{"byteLength": len(binary)}],
        }
        text = json.dumps(root, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + 8 + len(binary)
        chunk = lambda kind, data: struct.pack("<I4s", len(data), kind) + data
        return struct.pack("<4sII", b"glTF", 2, length) + chunk(b"JSON", text) + chunk(b"BIN\0", binary)


def linear(part):
    """Light of a part of an sRGB colour (IEC 61966-2-1)."""
    return part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4


def placed(corner, at, turn):
    x, y, z = corner
    roll, pitch, yaw = ((math.cos(it), math.sin(it)) for it in turn)
    y, z = y * roll[0] - z * roll[1], y * roll[1] + z * roll[0]
    x, z = x * pitch[0] + z * pitch[1], z * pitch[0] - x * pitch[1]
    x, y = x * yaw[0] - y * yaw[1], x * yaw[1] + y * yaw[0]
    return (x + at[0], y + at[1], z + at[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def area(triangle):
    a, b, c = triangle
    return math.hypot(*cross([q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)])) / 2


def volume(triangle):
    a, b, c = triangle
    return sum(p * q for p, q in zip(a, cross(b, c))) / 6


# Solids: lists of convex polygons.


def loft(rings, closed=False):
    """A skin over rings of as many corners each, with an end at the first and the last, or closed to a ring."""
    count = len(rings[0])
    pairs = list(zip(rings, rings[1:] + rings[:1])) if closed else list(zip(rings, rings[1:]))
    skin = [[a[i], a[(i + 1) % count], b[(i + 1) % count], b[i]] for a, b in pairs for i in range(count)]
    return skin if closed else [rings[0][::-1], *skin, rings[-1]]


def box(x, y, z):
    """Of these edges about the origin."""
    return prism([(x / 2, y / 2), (-x / 2, y / 2), (-x / 2, -y / 2), (x / 2, -y / 2)], -z / 2, z / 2)


def prism(outline, top, bottom, bevel=0.0):
    """An outline in the plane of x and y from one z to another, with its upper edge cut."""
    levels = [(0.0, bottom), (0.0, top + bevel), (bevel, top)] if bevel else [(0.0, bottom), (0.0, top)]
    return loft([[(x, y, z) for x, y in inset(outline, by)] for by, z in levels])


def inset(outline, by):
    """A convex outline whose edges are moved inward."""
    if not by:
        return outline
    sense = 1 if sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(outline, outline[1:] + outline[:1])) > 0 else -1
    lines = []
    for (ax, ay), (bx, by_) in zip(outline, outline[1:] + outline[:1]):
        length = math.hypot(bx - ax, by_ - ay)
        normal = (sense * (by_ - ay) / length, sense * (ax - bx) / length)
        lines.append((*normal, normal[0] * ax + normal[1] * ay - by))
    return [crossing(a, b) for a, b in zip(lines[-1:] + lines[:-1], lines)]


def crossing(a, b):
    """Where two lines cross, each of a normal and a distance."""
    det = a[0] * b[1] - a[1] * b[0]
    return ((a[2] * b[1] - a[1] * b[2]) / det, (a[0] * b[2] - a[2] * b[0]) / det)


def rounded(x, y, radius, steps=3):
    """A rectangle of these edges with round corners."""
    outline = []
    for quarter, (sx, sy) in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
        for step in range(steps + 1):
            angle = math.pi / 2 * (quarter + step / steps)
            middle = (sx * (x / 2 - radius), sy * (y / 2 - radius))
            outline.append((middle[0] + radius * math.cos(angle), middle[1] + radius * math.sin(angle)))
    return outline


def rod(radius, start, end, count=16, second=None):
    """A cylinder along z from one place to another, or a cone to a second radius."""
    ring = lambda z, r: [(r * math.cos(a), r * math.sin(a), z) for a in angles(count)]
    return loft([ring(start, radius), ring(end, radius if second is None else second)])


def angles(count):
    return [2 * math.pi * i / count for i in range(count)]


def lathe(outline, count):
    """A closed outline of places along y and radii, turned about y to a ring."""
    turned = [[(r * math.cos(a), y, r * math.sin(a)) for y, r in outline] for a in angles(count)]
    return loft(turned, closed=True)


def frustum(low, high, top, bottom):
    """From a rectangle (x from, x to, half of y) at the bottom to one at the top."""
    ring = lambda it, z: [(it[0], -it[2], z), (it[1], -it[2], z), (it[1], it[2], z), (it[0], it[2], z)]
    return loft([ring(low, bottom), ring(high, top)])


def sections(stations, cut):
    """A hull along x: (x, half of y, top, bottom) each, with edges cut."""
    ring = lambda x, y, t, b: [
        (x, -y, b - cut), (x, -y, t + cut), (x, cut - y, t), (x, y - cut, t),
        (x, y, t + cut), (x, y, b - cut), (x, y - cut, b), (x, cut - y, b),
    ]
    return loft([ring(*station) for station in stations])


def arc(radius, thickness, width, start, end, count):
    """A strip bent about y; angles from x forward, upward positive."""
    def ring(angle):
        c, s = math.cos(angle), -math.sin(angle)
        inner, outer = radius, radius + thickness
        corners = [(inner, -width / 2), (outer, -width / 2), (outer, width / 2), (inner, width / 2)]
        return [(r * c, y, r * s) for r, y in corners]
    return loft([ring(start + (end - start) * i / count) for i in range(count + 1)])


X = (0, math.pi / 2, 0)  # turns what is along z to along x
Y = (math.pi / 2, 0, 0)  # to along y


# What several robots have.


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
        block = frustum((-0.28 * pitch * radius, 0.28 * pitch * radius, 0.6 * half),
                        (-0.2 * pitch * radius, 0.2 * pitch * radius, 0.5 * half), -0.96 * lug, 0.5 * lug)
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


# Pioneers: outlines as in robot.toml, looks from memory; sonars where robot.toml has them.

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


# KUKA youBot: 0.58 x 0.38 x 0.14 m as commonly quoted; here over the 0.56 x 0.34 m that collide. The origin is between its axles.


def youbot_base():
    mesh, long, wide = Mesh(), rounded(0.56, 0.226, 0.04), rounded(0.334, 0.336, 0.015, 2)
    mesh.add(prism(inset(long, 0.004), -0.04, 0.028), BLACK).add(prism(inset(wide, 0.004), -0.04, 0.024), BLACK)
    mesh.add(prism(long, -0.0615, -0.022, 0.007), ORANGE).add(prism(wide, -0.0605, -0.021, 0.007), ORANGE)
    for x in (-0.07, -0.12, -0.17, -0.22):  # ribs of the plate for loads
        mesh.add(box(0.008, 0.12, 0.004), DARK, (x, 0, -0.0620))
    for end in (1, -1):
        mesh.add_pair(prism(rounded(0.07, 0.05, 0.012, 1), -0.0635, 0.0), BLACK, (end * 0.2475, 0.0895, 0))
        mesh.add(box(0.02, 0.13, 0.036), DARK, (end * 0.278, 0, -0.002))
    mesh.add_pair(box(0.15, 0.008, 0.022), DARK, (0, 0.167, -0.004))  # sills
    for end in (1, -1):
        mesh.add_pair(rod(0.014, -0.012, 0.012, 10), METAL, (end * 0.2355, 0.117, 0), Y)
    return mesh.add(box(0.06, 0.052, 0.007), DARK, (0.300, 0, 0.0185))  # holds the laser


def mecanum_hub():
    """What holds the rollers, which are drawn by themselves; 0.0569 m wide. A coloured bolt shows that it turns."""
    mesh = Mesh().add(rod(0.021, -0.025, 0.025, 10), DARK, turn=Y, stands=True)
    star = [(r * math.cos(a), r * math.sin(a)) for a, r in zip(angles(12), [0.041, 0.031] * 6)]
    for y in (-0.0262, 0.0262):
        plate = [[(x * part, y + t, z * part) for x, z in star] for part, t in
                 [(0, -0.0018), (1, -0.0018), (1, 0.0018), (0, 0.0018)]]
        mesh.add(loft(plate), METAL)
    for i in range(3):
        colour, angle = (ORANGE if i == 0 else DARK), i * math.pi / 1.5
        place = (0.031 * math.cos(angle), 0, -0.031 * math.sin(angle))
        mesh.add(rod(0.006, -0.0292, 0.0292, 6), colour, place, Y)
    return mesh.add(rod(0.013, -0.0305, 0.0305, 10), DARK, turn=Y)


# Its arm, each link from its joint upward, as it stands with every joint at 0.


def bar(mesh, length, wide, narrow):
    """An orange link between two joints about y, with the black covers of the upper one."""
    mesh.add(rod(0.62 * wide, -0.46 * wide, 0.46 * wide, 16), ORANGE, turn=Y)
    outline = lambda edge, z: [(x, y, z) for x, y in rounded(edge, 0.9 * edge, 0.25 * edge, 2)]
    mesh.add(loft([outline(wide, -0.2 * wide), outline(narrow, -length + 0.2 * narrow)]), ORANGE)
    covers(mesh, 0.62 * narrow, 0.47 * narrow, (0, 0, -length))
    return mesh


def covers(mesh, radius, half, at):
    """Of a joint about y, on both sides of the link that it turns, and what holds them."""
    for side in (1, -1):
        y = side * (half + 0.007)
        mesh.add(rod(radius * 1.06, -0.007, 0.007, 12), BLACK, (at[0], at[1] + y, at[2]), Y)
        mesh.add(rod(radius * 0.45, -0.0085, 0.0085, 6), GREY, (at[0], at[1] + y, at[2]), Y)


def arm_foot():
    mesh = Mesh().add(prism(rounded(0.125, 0.115, 0.025, 3), 0.072, 0.112, 0.006), BLACK, (-0.012, 0, 0))
    mesh.add(rod(0.056, 0.074, 0.03, 16, second=0.05), BLACK, stands=True)
    return mesh.add(rod(0.047, 0.031, 0.022), GREY, stands=True)


def arm_1():
    mesh = Mesh().add(rod(0.054, 0.0235, 0.002), ORANGE)
    mesh.add(prism(rounded(0.098, 0.082, 0.02, 2), -0.016, 0.004, 0.004), ORANGE, (0.012, 0, 0))
    covers(mesh, 0.036, 0.029, (0.033, 0, -0.019))
    return mesh


def arm_2():
    return bar(Mesh(), 0.155, 0.058, 0.050)


def arm_3():
    return bar(Mesh(), 0.135, 0.050, 0.044)


def arm_4():
    mesh = Mesh().add(rod(0.027, -0.02, 0.02, 16), ORANGE, turn=Y)
    outline = lambda edge, z: [(x, y, z) for x, y in rounded(edge, 0.9 * edge, 0.3 * edge, 2)]
    mesh.add(loft([outline(0.044, -0.008), outline(0.05, -0.05), outline(0.05, -0.095)]), ORANGE)
    return mesh.add(rod(0.027, -0.094, -0.124), BLACK)


def arm_5():
    mesh = Mesh().add(rod(0.024, 0.007, -0.006), METAL)
    mesh.add(prism(rounded(0.046, 0.10, 0.012, 2), -0.036, -0.005, 0.004), BLACK)
    return mesh.add(box(0.048, 0.05, 0.008), ORANGE, (0, 0, -0.018)).add(box(0.016, 0.11, 0.008), METAL, (0, 0, -0.038))


def finger():
    mesh = Mesh().add(frustum((-0.011, 0.011, 0.007), (-0.009, 0.009, 0.0035), -0.047, 0.006), DARK)
    return mesh.add(box(0.024, 0.016, 0.022), GREY, (0, 0, 0.012))


# Kenaf of the IRS and Tohoku University: grey, with black tracks and flippers. Places and radii as in robot.toml.


def belt(large, small, length, width, cleats):
    """A track around wheels of two radii, the second so far ahead; its cleats reach those radii. The first is at the origin."""
    lean = math.asin((large - small) / length)
    outline = []  # from above the first wheel, forward, as places, and away from the track
    for x, radius, first, last in [(length, small, math.pi / 2 - lean, lean - math.pi / 2),
                                   (0, large, lean - math.pi / 2, -1.5 * math.pi - lean)]:
        for i in range(6):
            angle = first + (last - first) * i / 5
            outline.append((x, radius, angle))
    cleat, thick, mesh = 0.006, 0.007, Mesh()
    ring = lambda it: [(it[0] + r * math.cos(it[2]), y, -r * math.sin(it[2])) for r, y in (
        (it[1] - cleat, -width / 2), (it[1] - cleat, width / 2),
        (it[1] - cleat - thick, width / 2), (it[1] - cleat - thick, -width / 2))]
    mesh.add(loft([ring(it) for it in outline], closed=True), RUBBER)
    outer = [(x + (r - cleat) * math.cos(a), -(r - cleat) * math.sin(a)) for x, r, a in outline]
    edges = list(zip(outer, outer[1:] + outer[:1]))
    pitch, gone, due = sum(math.dist(*edge) for edge in edges) / cleats, 0.0, 0.0
    for (ax, az), (bx, bz) in edges:
        step = math.dist((ax, az), (bx, bz))
        while due < gone + step - 1e-9:
            part = (due - gone) / step
            place = (ax + part * (bx - ax), 0, az + part * (bz - az))
            ends = [[(-0.007, y, 0.002), (0.007, y, 0.002), (0.0, y, -0.98 * cleat)] for y in (-width / 2, width / 2)]
            end, bottom, *rest = loft(ends)
            mesh.add([bottom, end, *rest], BLACK, place, (0, -math.atan2(bz - az, bx - ax), 0), stands=True)
            due += pitch
        gone += step
    return mesh


def flipper():
    mesh = belt(0.06, 0.04, 0.145, 0.04, 14)
    side = lambda r, x, first, last: [(x + r * math.cos(a), r * math.sin(a)) for a in
                                      [first + (last - first) * i / 6 for i in range(7)]]
    plate = side(0.034, 0.0, math.pi / 2, 1.5 * math.pi) + side(0.018, 0.145, -math.pi / 2, math.pi / 2)
    mesh.add(prism(plate, -0.006, 0.006), YELLOW, turn=Y)
    return mesh


def road_wheel(radius):
    """Inside a track; its spokes show that it turns."""
    mesh = Mesh().add(rod(radius, -0.016, 0.016, 10), GREY, turn=Y)
    mesh.add(box(1.7 * radius, 0.0335, 0.22 * radius), LIGHT)
    return mesh.add(box(0.22 * radius, 0.0350, 1.7 * radius), DARK)


def kenaf_body():
    mesh = Mesh().add(sections([(-0.215, 0.07, -0.02, 0.02), (-0.19, 0.084, -0.045, 0.03),
                                (0.17, 0.084, -0.045, 0.03), (0.215, 0.07, -0.015, 0.02)], 0.006), GREY)
    mesh.add(prism(rounded(0.30, 0.255, 0.03), -0.082, -0.064, 0.008), (0.58, 0.59, 0.60))  # lid over hull and tracks
    mesh.add(prism(rounded(0.26, 0.14, 0.015, 1), -0.066, -0.04), DARK)
    mesh.add(box(0.10, 0.257, 0.006), YELLOW, (-0.02, 0, -0.072))
    mesh.add(prism(rounded(0.15, 0.09, 0.012, 1), -0.094, -0.08, 0.004), DARK, (-0.04, 0, 0))
    for x in (-0.225, 0.225):  # shafts and motors of the flippers
        mesh.add(rod(0.013, -0.225, 0.225, 6), METAL, (x, 0, 0), Y)
        mesh.add_pair(rod(0.032, -0.032, 0.032, 10), GREY, (x, 0.172, 0), Y)
        mesh.add_pair(rod(0.033, -0.006, 0.006, 10), YELLOW, (x, 0.172, 0), Y)
    mesh.add_pair(box(0.45, 0.01, 0.028), GREY, (0, 0.1395, 0))  # beams that carry them
    mesh.add_pair(box(0.39, 0.024, 0.07), DARK, (0, 0.11, 0))  # behind the wheels of the tracks
    mesh.add_pair(rod(0.012, 0.0, 0.008, 8), LAMP, (0.200, 0.05, -0.024), X)
    for x in (-0.13, 0.13):  # handles
        mesh.add_pair(box(0.01, 0.01, 0.03), BLACK, (x, 0.055, -0.09))
        mesh.add(box(0.012, 0.12, 0.01), BLACK, (x, 0, -0.104))
    track = belt(0.06, 0.06, 0.4, 0.04, 24)
    for colour, triangles in track.triangles.items():
        for y in (-0.11, 0.11):
            moved = [tuple((px - 0.2, py + y, pz) for px, py, pz in it) for it in triangles]
            mesh.triangles.setdefault(colour, []).extend(moved)
    return mesh


# AirRobot AR100: four rotors in a ring of carbon fibre around a round pod, from memory.

ROTORS = [(0.17, 0.175), (-0.2167, 0.175), (-0.2167, -0.211), (0.17, -0.211)]
POD = (-0.023, -0.018)


def airrobot():
    mesh = Mesh()
    path = []
    for quarter, (x, y) in enumerate(ROTORS):
        for step in range(7):
            path.append((x, y, math.pi / 2 * (quarter + step / 6)))
    section = [(r * math.cos(a), r * math.sin(a)) for a, r in zip(angles(6), [0.010] * 6)]
    ring = [[(x + (0.146 + out) * math.cos(a), y + (0.146 + out) * math.sin(a), -0.01 + up) for out, up in section]
            for x, y, a in path]
    mesh.add(loft(ring, closed=True), DARK)
    for number, (x, y) in enumerate(ROTORS):
        dx, dy = x - POD[0], y - POD[1]
        angle, length = math.atan2(dy, dx), math.hypot(dx, dy)
        reach = length + 0.137  # the arm goes on to the ring
        middle = (POD[0] + reach / 2 * math.cos(angle), POD[1] + reach / 2 * math.sin(angle), 0.004)
        mesh.add(box(reach, 0.018, 0.012), BLACK, middle, (0, 0, angle))
        mesh.add(rod(0.02, 0.012, -0.018, 12), GREY, (x, y, 0))
        mesh.add(rod(0.012, -0.018, -0.034, 10, second=0.005), RED if x > 0 else DARK, (x, y, 0))  # red is ahead
        for blade in range(2):  # twisted, from root to tip
            sense = 1 if number % 2 else -1
            along = 0.5 + number * 0.9 + blade * math.pi
            stations = [(0.01, 0.008, 0.4), (0.05, 0.015, 0.30), (0.10, 0.013, 0.2), (0.133, 0.007, 0.12)]
            rings = [[placed(corner, (0, 0, 0), (sense * pitch, 0, 0)) for corner in
                      [(r, -chord, 0), (r, 0, -0.0015), (r, chord, 0), (r, 0, 0.0015)]] for r, chord, pitch in stations]
            mesh.add(loft(rings), (0.32, 0.33, 0.35), (x, y, -0.025), (0, 0, along))
        foot = (POD[0] + 0.42 * dx, POD[1] + 0.42 * dy, 0)  # legs down to what touches the ground
        mesh.add(rod(0.006, 0.006, 0.07, 8, second=0.004), BLACK, foot)
        mesh.add(rod(0.010, 0.066, 0.07, 8), RUBBER, foot)
    dome = [(0.088, 0.012), (0.088, -0.008), (0.078, -0.034), (0.052, -0.054), (0.02, -0.062)]
    shell = [[(r * math.cos(a), r * math.sin(a), z) for a in angles(20)] for r, z in dome]
    mesh.add(loft(shell), (0.24, 0.25, 0.28), (*POD, 0))
    mesh.add(rod(0.09, 0.0, 0.006, 20), YELLOW, (*POD, 0))  # a band around the pod
    mesh.add(rod(0.07, 0.011, 0.034, 16, second=0.05), BLACK, (*POD, 0))  # the battery
    camera = (POD[0] + 0.055, POD[1], 0.046)
    mesh.add(box(0.05, 0.058, 0.026), DARK, camera).add(box(0.02, 0.03, 0.024), GREY, (POD[0] + 0.04, POD[1], 0.028))
    return mesh.add(rod(0.011, 0, 0.014, 12), GLASS, (camera[0] + 0.024, *camera[1:]), X)


# Cars and plain robots, whose meshes are not public: bodies over the boxes that collide.


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


YOUBOT = {"base.glb": youbot_base, "hub.glb": mecanum_hub, "hokuyo.glb": hokuyo}
ARM = {"arm-foot.glb": arm_foot, "arm-1.glb": arm_1, "arm-2.glb": arm_2, "arm-3.glb": arm_3, "arm-4.glb": arm_4,
       "arm-5.glb": arm_5, "finger.glb": finger}
FILES = {
    "P3AT": {"body.glb": lambda: pioneer_at(-0.08, -0.048, 0.113, 0.088), "sick.glb": sick,
             "wheel.glb": lambda: wheel(0.098, 0.075, 0.054, 10)},
    "P2AT": {"body.glb": lambda: pioneer_at(-0.152, -0.12, 0.045), "sick.glb": sick,
             "wheel.glb": lambda: wheel(0.1075, 0.075, 0.059, 10)},
    "P2DX": {"body.glb": pioneer_dx, "sick.glb": sick, "wheel.glb": lambda: wheel(0.0825, 0.037, 0.058, 0, 6, corners=24)},
    "KUKA_YouBot": YOUBOT,
    "YouBot": YOUBOT,
    "YouBotArm": YOUBOT | ARM,
    "Kenaf": {"body.glb": kenaf_body, "flipper.glb": flipper, "wheel.glb": lambda: road_wheel(0.0465),
              "tip-wheel.glb": lambda: road_wheel(0.0265)},
    "AirRobot": {"body.glb": airrobot},
    "FrontAckerman": {"body.glb": front_ackerman, "knuckle.glb": front_knuckle,
                      "front-wheel.glb": lambda: wheel(0.184, 0.08, 0.125, 0, 6, RED, 22),
                      "rear-wheel.glb": lambda: wheel(0.128, 0.08, 0.085, 0, 6, RED, 18)},
    "BasicAckermanRobot": {"body.glb": basic_ackerman, "wheel.glb": lambda: wheel(0.128, 0.1, 0.08, 0, 5, corners=20)},
    "BasicSkidRobot": {"body.glb": basic_skid, "wheel.glb": lambda: wheel(0.128, 0.1, 0.07, 14)},
    "CasterSkidRobot": {"body.glb": caster_skid, "wheel.glb": lambda: wheel(0.128, 0.1, 0.07, 14)},
}

if __name__ == "__main__":
    for robot, meshes in FILES.items():
        for file, make in meshes.items():
            mesh = make()
            data = mesh.glb()
            (Path(__file__).parent / robot / file).write_bytes(data)
            print(f"{robot}/{file}: {mesh.count()} triangles, {len(data)} bytes")
