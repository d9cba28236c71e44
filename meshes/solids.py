"""Triangle meshes, the solids that they are made of, and their colours.

Frame and units as in robot.toml: x forward, y right, z down, m, rad. Colours are red, green and blue, 0 to 1, sRGB.
"""

import json
import math
import struct

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
WHITE = (0.92, 0.92, 0.93)
OLIVE = (0.30, 0.36, 0.22)
SAND = (0.70, 0.62, 0.45)
BLUE = (0.20, 0.36, 0.62)
GOLD = (0.74, 0.62, 0.34)

# Corners lie on multiples of half a millimetre, which are short as decimals: logs and the page have them as text.
GRID = 2000


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

    def add_at(self, solid, colour, places, turn=(0, 0, 0)):
        """At several places."""
        for at in places:
            self.add(solid, colour, at, turn)
        return self

    def count(self):
        return sum(map(len, self.triangles.values()))

    def glb(self):
        """A binary glTF 2.0 of one mesh, one primitive a colour. In glTF y is up."""
        places, numbers, accessors, materials, primitives = b"", b"", [], [], []
        for colour, triangles in self.triangles.items():
            corners = [tuple(round(part * GRID) / GRID + 0.0 for part in (x, -z, y)) for it in triangles for x, y, z in it]
            number = {corner: index for index, corner in enumerate(dict.fromkeys(corners))}
            least, most = ([pick(axis) for axis in zip(*number)] for pick in (min, max))
            accessors.append({"bufferView": 0, "byteOffset": len(places), "componentType": 5126, "count": len(number),
                              "type": "VEC3", "min": least, "max": most})
            accessors.append({"bufferView": 1, "byteOffset": len(numbers), "componentType": 5123, "count": len(corners),
                              "type": "SCALAR"})
            places += b"".join(struct.pack("<3f", *corner) for corner in number)
            numbers += struct.pack(f"<{len(corners)}H", *(number[corner] for corner in corners))
            factor = [round(linear(part), 4) for part in colour] + [1]
            materials.append({"pbrMetallicRoughness": {"baseColorFactor": factor, "metallicFactor": 0}})
            first = 2 * len(primitives)
            primitives.append({"attributes": {"POSITION": first}, "indices": first + 1, "material": len(primitives)})
        binary = places + numbers + bytes(-len(numbers) % 4)
        views = [{"buffer": 0, "byteLength": len(places)},
                 {"buffer": 0, "byteOffset": len(places), "byteLength": len(numbers)}]
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


def unit(a):
    length = math.hypot(*a)
    return tuple(part / length for part in a)


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


def ball(radius, count=12, squash=(1, 1, 1)):
    """A ball, or an ellipsoid of three radii over the radius."""
    a, b, c = (radius * part for part in squash)
    around = [math.pi * i / (count // 2) for i in range(count // 2 + 1)]
    return loft([[(a * math.sin(u) * math.cos(v), b * math.sin(u) * math.sin(v), -c * math.cos(u)) for v in angles(count)]
                 for u in around])


def turned(outline, count):
    """Places along z and radii, turned about z, with an end at the first and the last."""
    return loft([[(r * math.cos(a), r * math.sin(a), z) for a in angles(count)] for z, r in outline])


def ring(inner, outer, top, bottom, count):
    """A flat ring about z."""
    section = [(inner, top), (outer, top), (outer, bottom), (inner, bottom)]
    return loft([[(r * math.cos(a), r * math.sin(a), z) for r, z in section] for a in angles(count)], closed=True)


def tube(path, radius, count=6):
    """A round bar along a path of places."""
    rings, across = [], None
    for i, place in enumerate(path):
        before, after = path[max(i - 1, 0)], path[min(i + 1, len(path) - 1)]
        along = unit([q - p for p, q in zip(before, after)])
        if across is None:
            across = unit(cross(along, (0, 0, 1) if abs(along[2]) < 0.9 else (0, 1, 0)))
        across = unit(cross(cross(along, across), along))
        other = cross(along, across)
        rings.append([tuple(place[k] + radius * (math.cos(a) * across[k] + math.sin(a) * other[k]) for k in range(3))
                      for a in angles(count)])
    return loft(rings)


def side(outline, near, far, bevel=0.0):
    """A convex outline in the plane of x and z from one y to another, with the edges of both ends cut."""
    levels = [(bevel, near), (0, near + bevel), (0, far - bevel), (bevel, far)] if bevel else [(0, near), (0, far)]
    return loft([[(x, y, z) for x, z in inset(outline, by)] for by, y in levels])


def belted(one, other, steps=6):
    """The outline around two circles, each of two coordinates and a radius."""
    (ax, ay, ar), (bx, by, br) = one, other
    ahead, lean = math.atan2(by - ay, bx - ax), math.asin((ar - br) / math.hypot(bx - ax, by - ay))
    outline = []
    for x, y, r, first, last in [(bx, by, br, lean - math.pi / 2, math.pi / 2 - lean),
                                 (ax, ay, ar, math.pi / 2 - lean, 1.5 * math.pi + lean)]:
        turns = [ahead + first + (last - first) * i / steps for i in range(steps + 1)]
        outline += [(x + r * math.cos(a), y + r * math.sin(a)) for a in turns]
    return outline


def strap(one, other, near, far, bevel=0.0, steps=5):
    """A plate with round ends about y: places (x, z, radius) and its extent along y."""
    return side(belted(one, other, steps), near, far, bevel)


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
