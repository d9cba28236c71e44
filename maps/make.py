#!/usr/bin/env python3
"""Makes the maps that are too long to write by hand: map.toml of rescue, factory and soccer.

    python3 maps/make.py            writes them
    python3 maps/make.py --check    fails if one is not what this file makes

Frame and units as in map.toml: x forward, y right, z down, m, rad. A solid is given by its lowest place (`at`, height over the floor) and its
edges; heights are upward here.
"""

import math
import sys
from pathlib import Path

PLY = (0.80, 0.65, 0.44)
PALE = (0.86, 0.75, 0.56)
OLD = (0.70, 0.55, 0.36)
DARK = (0.30, 0.31, 0.33)
STEEL = (0.60, 0.63, 0.66)
BLUE = (0.20, 0.36, 0.62)
RED = (0.72, 0.20, 0.16)
ORANGE = (0.90, 0.50, 0.14)
YELLOW = (0.92, 0.74, 0.18)
GREEN = (0.28, 0.52, 0.32)
WHITE = (0.93, 0.93, 0.92)
BLACK = (0.13, 0.13, 0.14)


def number(value):
    """A number with at most four decimals, always with a point."""
    text = f"{value:.4f}".rstrip("0")
    return "0.0" if text in ("0.", "-0.") else text + "0" if text.endswith(".") else text


def text_of(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, (tuple, list)):
        return "[" + ", ".join(map(number, value)) + "]"
    return number(value)


class Map:
    """The text of a map.toml, table by table."""

    def __init__(self, comment, description, robots):
        self.lines = [f"# {line}" for line in comment.strip().splitlines()]
        self.lines += ["# Made by ../make.py: change that, not this.", f"description = {text_of(description)}"]
        self.lines += [f"robots = [{', '.join(map(text_of, robots))}]"]
        self.numbers = {}

    def note(self, comment):
        self.lines += ["", f"# {comment}"]
        return self

    def table(self, kind, **keys):
        if not self.lines[-1].startswith("#") or len(self.lines) < 6:
            self.lines.append("")
        self.lines.append(f"[[{kind}]]" if kind[0] != "!" else f"[{kind[1:]}]")
        self.lines += [f"{key} = {text_of(value)}" for key, value in keys.items() if value is not None]

    def name(self, name):
        """The name, numbered if there are several of it: a name that ends in `-`."""
        if not name.endswith("-"):
            return name
        self.numbers[name] = self.numbers.get(name, 0) + 1
        return f"{name}{self.numbers[name]}"

    def box(self, name, at, size, material="plywood", turn=None, **more):
        x, y, low = at
        position = (x, y, -(low + size[2] / 2))
        self.table("box", name=self.name(name), material=material, position=position, rotation=turn, size=size, **more)

    def cylinder(self, name, at, radius, length, material="plywood", turn=None, **more):
        x, y, low = at
        position = (x, y, -(low + length / 2))
        self.table("cylinder", name=self.name(name), material=material, position=position, rotation=turn,
                   radius=radius, length=length, **more)

    def ramp(self, name, at, length, width, height, yaw=0.0, material="plywood", **more):
        """A ramp whose low edge has its middle at a place."""
        x, y, low = at
        self.table("ramp", name=self.name(name), material=material, position=(x, y, -low),
                   rotation=(0, 0, yaw) if yaw else None, length=length, width=width, height=height, **more)

    def marking(self, name, at, size, colour, turn=None, thick=0.002):
        """A patch of colour on the floor."""
        self.box(name, (*at, 0), (*size, thick), "plywood", turn, colour=colour, collides=False)

    def wall(self, name, start, end, height, doors=(), thickness=0.1, material="plywood", **more):
        """A wall along x or y with doorways, each given by its middle along the wall and its width."""
        along = 0 if start[0] != end[0] else 1
        low, high = sorted((start[along], end[along]))
        cuts = [low] + [it for middle, width in sorted(doors) for it in (middle - width / 2, middle + width / 2)] + [high]
        for begin, finish in zip(cuts[::2], cuts[1::2]):
            if finish - begin < 0.01:
                continue
            middle, length = (begin + finish) / 2, finish - begin
            at = (middle, start[1], 0) if along == 0 else (start[0], middle, 0)
            size = (length, thickness, height) if along == 0 else (thickness, length, height)
            self.box(f"{name}-", at, size, material, **more)

    def victim(self, name, at, yaw, posture, **more):
        x, y, low = at
        self.table("victim", name=name, position=(x, y, -low), rotation=(0, 0, yaw) if yaw else None, posture=posture, **more)

    def pose(self, kind, name, position, yaw=0.0):
        self.table(kind, name=name, position=(*position, 0), rotation=(0, 0, yaw) if kind == "start" or yaw else None)

    def text(self):
        return "\n".join(self.lines) + "\n"


# ---------------------------------------------------------------------------------------------------------------------------------

TILE = 1.2
RISE = TILE * math.tan(math.radians(15))
POST = 0.2

# Heights of the posts of a field, in steps of 10 cm.
PINWHEEL = ["210000", "210222", "210111", "111012", "222012", "000012"]
HILL = ["000000", "011110", "012210", "012210", "011110", "000000"]
RIDGE = ["001221", "001221", "001221", "122100", "122100", "122100"]
BARS = ["002200", "001100", "111111", "222222", "001100", "002200"]


def rectangles(cells):
    """Covers a set of cells with rectangles: row and column of the first cell, and counts of both."""
    left, found = set(cells), []
    while left:
        row, column = min(left)
        wide = 1
        while (row, column + wide) in left:
            wide += 1
        high = 1
        while all((row + high, column + it) in left for it in range(wide)):
            high += 1
        found.append((row, column, high, wide))
        left -= {(row + r, column + c) for r in range(high) for c in range(wide)}
    return found


def step_field(field, x, y, pattern):
    """Posts of 20 x 20 cm in a tile around a place. Those of one height that stand beside each other are one box."""
    for layer, colour in ((1, PALE), (2, OLD)):
        cells = [(r, c) for r in range(6) for c in range(6) if int(pattern[r][c]) >= layer]
        for row, column, high, wide in rectangles(cells):
            middle = (x + (row + high / 2 - 3) * POST, y + (column + wide / 2 - 3) * POST)
            size = (high * POST, wide * POST, 0.1)
            field.box("step-", (*middle, 0.1 * (layer - 1)), size, colour=colour)


def box_with_hole(arena, x, y, yaw):
    """A box of 0.6 x 0.6 x 0.6 m with a hole of 20 cm in the side that faces along its x axis."""
    edge, thick = 0.6, 0.02

    def panel(ahead, aside, height, size):
        at = (x + ahead * math.cos(yaw) - aside * math.sin(yaw), y + ahead * math.sin(yaw) + aside * math.cos(yaw), height)
        arena.box("panel-", at, size, turn=(0, 0, yaw) if yaw else None, colour=PALE)

    half = (edge - thick) / 2
    panel(-half, 0, 0, (thick, edge, edge))
    panel(0, -half, 0, (edge - 2 * thick, thick, edge))
    panel(0, half, 0, (edge - 2 * thick, thick, edge))
    panel(0, 0, edge - thick, (edge - 2 * thick, edge - 2 * thick, thick))
    panel(half, 0, 0, (thick, edge, 0.2))
    panel(half, 0, 0.4, (thick, edge, 0.2))


def rescue():
    arena = Map("""
An arena after NIST's standard test methods for response robots (ASTM E54): tiles of 1.2 m, walls of plywood 1.2 m high.
Yellow is a maze, orange has ramps and stairs, red has step fields. The arena is 16.8 x 12 m, with six victims and ten RFID tags.""",
                "Rescue arena of 16.8 x 12 m: rooms, a corridor, ramps, step fields, a stair, inclined planes, smoke and six victims",
                ("Kenaf", "P3AT", "AirRobot"))
    arena.table("half_space", name="floor", material="concrete")
    wall = 1.2
    arena.note("The outer walls, and those of the rooms with their doorways.")
    arena.wall("wall-front", (8.45, -6.1), (8.45, 6.1), wall)
    arena.wall("wall-back", (-8.45, -6.1), (-8.45, 6.1), wall)
    arena.wall("wall-left", (-8.4, -6.05), (8.4, -6.05), wall)
    arena.wall("wall-right", (-8.4, 6.05), (8.4, 6.05), wall)
    arena.wall("hall-left", (-4.8, -6.0), (-4.8, -0.6), wall, [(-3.3, 1.0)])
    arena.wall("hall-right", (-4.8, 0.6), (-4.8, 6.0), wall, [(5.3, 1.0)])
    arena.wall("corridor-left", (-4.75, -0.65), (8.4, -0.65), wall, [(0.6, 0.9), (7.8, 0.9)])
    arena.wall("corridor-right", (-4.75, 0.65), (8.4, 0.65), wall, [(-1.8, 0.9), (4.5, 0.9)])
    arena.wall("room-left", (-1.2, -6.0), (-1.2, -0.7), wall, [(-3.3, 1.0)])
    arena.wall("stairs", (2.4, -6.0), (2.4, -0.7), wall, [(-3.75, 1.2)])
    arena.wall("maze", (-1.2, 0.7), (-1.2, 6.0), wall, [(4.2, 1.0)])
    arena.wall("fields", (3.6, 0.7), (3.6, 6.0), wall, [(2.4, 1.0), (5.2, 0.9)])

    arena.note("The colours of the floor, which are only seen.")
    arena.marking("floor-maze", (-3.0, 3.35), (3.5, 5.3), (0.80, 0.72, 0.42))
    arena.marking("floor-ramps", (-3.0, -3.35), (3.5, 5.3), (0.78, 0.58, 0.40))
    arena.marking("floor-stairs", (5.4, -3.35), (5.9, 5.3), (0.78, 0.58, 0.40))
    arena.marking("floor-fields", (1.2, 3.35), (4.7, 5.3), (0.72, 0.44, 0.40))
    arena.marking("floor-rubble", (6.0, 3.35), (4.7, 5.3), (0.72, 0.44, 0.40))

    arena.note("Crossing ramps of 15 degrees, one to a tile.")
    for row in range(3):
        for column in range(4):
            x, y = -4.2 + row * TILE, -5.4 + column * TILE
            yaw = (0 if row % 2 else math.pi) if (row + column) % 2 else (math.pi / 2 if column % 2 else -math.pi / 2)
            low = (x - 0.6 * math.cos(yaw), y - 0.6 * math.sin(yaw), 0)
            arena.ramp("crossing-ramp-", low, TILE, TILE, RISE, yaw, colour=PALE if (row + column) % 2 else PLY)

    arena.note("An office with two tables and a shelf.")
    for x, y in ((0.9, -5.5), (1.9, -2.2)):
        size = (1.2, 0.7) if x < 1 else (0.7, 1.2)
        arena.box("table-", (x, y, 0.68), (*size, 0.04), colour=PALE)
        for side in (-1, 1):
            leg = (0.04, size[1], 0.68) if x < 1 else (size[0], 0.04, 0.68)
            at = (x + side * (size[0] / 2 - 0.06), y, 0) if x < 1 else (x, y + side * (size[1] / 2 - 0.06), 0)
            arena.box("table-leg-", at, leg, "aluminium", colour=DARK)
    arena.box("cupboard", (-0.9, -5.4, 0), (0.45, 1.0, 1.1), colour=OLD)

    arena.note("A stair of 17 x 28 cm up to a landing, 30 degrees down again, and a lower landing with a plane of 15 degrees.")
    rise, run, landing = 0.17, 0.28, 6 * 0.17
    for step in range(6):
        size = ((6 - step) * run, 1.4, rise)
        arena.box("stair-", (5.88 - size[0] / 2, -5.3, step * rise), size, colour=PALE if step % 2 else PLY)
    arena.box("landing", (6.54, -4.5, 0), (1.32, 3.0, landing), colour=PLY)
    arena.ramp("plane-30", (5.88 - landing / math.tan(math.radians(30)), -3.75, 0),
               landing / math.tan(math.radians(30)), 1.5, landing, colour=PALE)
    arena.box("landing-low", (6.54, -1.9, 0), (1.32, 2.2, 3 * rise), colour=PLY)
    for step, deep in ((0, 0.56), (1, 0.28)):
        arena.box("stair-low-", (6.54, -3.0 + deep / 2, (3 + step) * rise), (1.32, deep, rise), colour=PALE if step else PLY)
    arena.ramp("plane-15", (5.88 - 3 * rise / math.tan(math.radians(15)), -1.6, 0),
               3 * rise / math.tan(math.radians(15)), 1.5, 3 * rise, colour=PALE)
    arena.box("rail-landing", (7.18, -4.5, landing), (0.04, 3.0, 0.5), "aluminium", colour=YELLOW)
    arena.box("rail-stair", (5.04, -4.56, 0), (1.68, 0.04, 1.2), "aluminium", colour=YELLOW)

    arena.note("A maze of half-high walls.")
    for start, end in (((-3.6, 0.7), (-3.6, 2.4)), ((-3.6, 3.6), (-3.6, 4.8)), ((-3.6, 4.8), (-2.4, 4.8)),
                       ((-2.4, 2.4), (-2.4, 4.8)), ((-2.4, 2.4), (-1.25, 2.4))):
        arena.wall("maze-wall", start, end, 0.8, colour=PALE)

    arena.note("Step fields: posts of 20 x 20 cm, 10 and 20 cm high, and flat ground between.")
    patterns = [[PINWHEEL, HILL, RIDGE], [HILL, BARS, PINWHEEL], [RIDGE, PINWHEEL, HILL]]
    for row in range(3):
        for column in range(3):
            step_field(arena, 0.0 + row * TILE, 2.2 + column * TILE, patterns[row][column])

    arena.note("Rubble: boards that lean on blocks, pipes and drums.")
    arena.box("block-1", (5.2, 5.2, 0), (0.5, 0.5, 0.5), "concrete")
    arena.box("board-1", (5.2, 4.5, 0.1), (0.7, 1.5, 0.04), turn=(0.36, 0, 0), colour=OLD)
    arena.box("block-2", (7.4, 2.2, 0), (0.4, 1.0, 0.35), "concrete")
    arena.box("board-2", (6.7, 2.3, 0.03), (1.5, 0.8, 0.04), turn=(0, 0.21, 0.12), colour=PALE)
    for x, y, yaw in ((6.3, 3.9, 0.5), (7.2, 4.6, -0.4), (5.0, 2.0, 1.2)):
        arena.cylinder("pipe-", (x, y, 0.06 - 0.6), 0.06, 1.2, "aluminium", turn=(0, math.pi / 2, yaw), colour=STEEL)
    for x, y in ((7.9, 5.5), (8.0, 1.2)):
        arena.cylinder("pillar-", (x, y, 0), 0.16, wall, "concrete")

    arena.note("Boxes with a hole. In each is a tag.")
    boxes = ((-4.4, 4.3, 0.0), (1.1, -1.2, -math.pi / 2), (8.05, -5.6, math.pi / 2), (2.0, -5.65, math.pi / 2),
             (8.05, 3.4, math.pi), (-0.8, 5.65, 0.0))
    for x, y, yaw in boxes:
        box_with_hole(arena, x, y, yaw)
    arena.note("A shelter with a gap, in which a victim lies.")
    arena.box("shelter-roof", (-7.3, 5.5, 0.6), (2.1, 0.95, 0.02), colour=PALE)
    arena.box("shelter-front", (-7.3, 5.03, 0.35), (2.06, 0.02, 0.25), colour=PALE)
    for x in (-8.34, -6.26):
        arena.box("shelter-end-", (x, 5.5, 0), (0.02, 0.95, 0.6), colour=PALE)

    arena.note("Victims: their pelvis, and what of them sensors notice.")
    arena.victim("office", (-0.8, -1.7, 0), 0.0, "sitting", moves=True, volume=0.4, co2=0.8)
    arena.victim("landing", (6.8, -4.8, 1.02), -math.pi / 2, "lying", co2=0.6)
    arena.victim("maze", (-3.0, 4.35, 0), -math.pi / 2, "sitting", moves=True, co2=0.9)
    arena.victim("fields", (1.2, 5.62, 0), 0.0, "lying", volume=0.6, co2=0.7)
    arena.victim("rubble", (6.6, 5.5, 0), math.pi, "lying", moves=True, volume=0.8, co2=1.0)
    arena.victim("shelter", (-7.3, 5.55, 0), 0.0, "lying", volume=0.3, co2=0.8)

    arena.note("Tags: one in each box, the others at doorways.")
    places = [(x, y, 0.1, "box") for x, y, _ in boxes]
    places += [(-4.8, -4.0, 0.6, "ramps"), (0.0, -0.65, 0.6, "smoke"), (3.9, 0.65, 0.6, "rubble"), (2.4, -3.0, 0.6, "stair")]
    for number, (x, y, high, memory) in enumerate(places, 1):
        arena.table("rfid", id=number, position=(x, y, -high), memory=memory)

    arena.note("The office is full of smoke.")
    arena.table("smoke", name="office", position=(0.6, -3.35, -0.6), size=(3.5, 5.3, 1.2), density=0.5)

    arena.note("Things to push.")
    for x, y, edge, mass, colour in ((-6.4, -4.2, 0.4, 4.0, OLD), (-6.9, 4.6, 0.3, 2.0, PLY), (-6.7, 4.65, 0.2, 0.8, PALE),
                                     (2.9, 0.1, 0.25, 1.5, PLY), (5.6, 1.3, 0.4, 4.0, OLD), (4.6, 3.6, 0.3, 2.0, PALE),
                                     (-2.9, 1.4, 0.3, 2.0, PLY), (0.2, -2.4, 0.4, 4.0, OLD)):
        low = 0.3 if edge == 0.2 else 0.0
        arena.box("crate-", (x, y if not low else 4.6, low), (edge, edge, edge), turn=(0, 0, 0.3 * x), mass=mass, colour=colour)
    arena.cylinder("drum-1", (6.9, 1.5, 0), 0.2, 0.6, "aluminium", mass=8.0, colour=BLUE)
    arena.cylinder("drum-2", (-7.6, -5.2, 0), 0.2, 0.6, "aluminium", mass=8.0, colour=RED)

    arena.note("Robots start in the hall at the back.")
    arena.pose("start", "PlayerStart_0", (-6.6, 0.0))
    for index, y in enumerate((-2.2, 2.2, -3.4, 3.4)):
        arena.pose("start", f"RobotStart{index + 1}", (-6.6, y) if index < 2 else (-7.4, y))
    nodes = [("Hall", (-6.6, 0.0)), ("Corridor", (2.0, 0.0)), ("Office", (0.6, -3.6)), ("Ramps", (-5.4, -3.3)),
             ("Stair", (3.2, -5.2)), ("Planes", (3.2, -2.4)), ("Maze", (-1.8, 1.5)), ("Fields", (-0.85, 4.2)),
             ("Rubble", (4.6, 1.2))]
    for name, place in nodes:
        arena.pose("path_node", name, place)
    return arena.text()


# ---------------------------------------------------------------------------------------------------------------------------------


def factory():
    hall = Map("""
A factory hall after the industrial competitions of the Virtual Manufacturing Automation Challenge: two conveyors, shelves, tables
with parts and trays, and pallets. A world controller sets a conveyor's speed: CONTROL {Type Conveyor} {Name belt-1} {Speed 0}.
Masses of parts and trays are USARSim's.""",
                "Factory hall of 16 x 12 m with two conveyors, shelves, pallets, and parts and trays on tables",
               ("Kiva4Wheel", "KR60", "YouBotArm"))
    hall.table("!material.belt", friction=0.9, colour=BLACK, source="a belt of ribbed rubber")
    hall.table("half_space", name="floor", material="concrete")
    wall = 1.0
    hall.wall("wall-front", (8.05, -6.1), (8.05, 6.1), wall, material="concrete", colour=(0.78, 0.79, 0.78))
    hall.wall("wall-back", (-8.05, -6.1), (-8.05, 6.1), wall, material="concrete", colour=(0.78, 0.79, 0.78))
    hall.wall("wall-left", (-8.0, -6.05), (8.0, -6.05), wall, material="concrete", colour=(0.78, 0.79, 0.78))
    hall.wall("wall-right", (-8.0, 6.05), (8.0, 6.05), wall, material="concrete", colour=(0.78, 0.79, 0.78))
    for x in (-4.0, 0.0, 4.0):
        for y in (-5.8, 5.8):
            hall.box("column-", (x, y, 0), (0.3, 0.3, 2.6), "concrete", colour=STEEL)

    hall.note("Lanes for vehicles, which are only seen.")
    for y in (-1.1, 1.1):
        hall.marking("lane-", (-0.9, y), (12.0, 0.1), YELLOW)
    for x in (-6.9, 5.1):
        hall.marking("lane-", (x, 0), (0.1, 2.3), YELLOW)
    for x in (-5.4, -3.8, -2.2):
        for side in (-0.65, 0.65):
            hall.marking("bay-", (x + side, 4.6), (0.06, 1.3), WHITE)
        hall.marking("bay-", (x, 5.25), (1.36, 0.06), WHITE)

    hall.note("The conveyors: the first runs to the left (-y), as USARSim's, the second on ahead (+x) from its end.")
    hall.box("belt-1", (2.6, -0.3, 0.4), (0.6, 4.8, 0.1), "belt", conveyor=(0, -0.24, 0))
    hall.box("belt-2", (4.45, -3.0, 0.34), (4.3, 0.6, 0.1), "belt", conveyor=(0.24, 0, 0))
    for x in (2.28, 2.92):
        high = (0.05, 5.4, 0.2) if x < 2.5 else (0.05, 4.8, 0.2)
        hall.box("guide-", (x, -0.6 if x < 2.5 else -0.3, 0.38), high, "aluminium", colour=STEEL)
    for y in (-3.32, -2.68):
        long = 4.35 if y < -3 else 3.67
        hall.box("guide-", (6.6 - long / 2, y, 0.32), (long, 0.05, 0.2), "aluminium", colour=STEEL)
    hall.box("stop", (6.62, -3.0, 0.32), (0.05, 0.6, 0.2), "aluminium", colour=STEEL)
    for y in (-2.4, -0.6, 1.8):
        hall.box("frame-", (2.6, y, 0), (0.5, 0.08, 0.4), "aluminium", colour=BLUE)
    for x in (3.6, 5.0, 6.4):
        hall.box("frame-", (x, -3.0, 0), (0.08, 0.5, 0.34), "aluminium", colour=BLUE)

    hall.note("Shelves.")
    for x in (-6.2, -4.2, -2.2):
        for side in (-0.78, 0.78):
            hall.box("shelf-side-", (x + side, -5.5, 0), (0.04, 0.6, 1.8), "aluminium", colour=BLUE)
        for high in (0.1, 0.7, 1.3):
            hall.box("shelf-", (x, -5.5, high), (1.52, 0.6, 0.04), "aluminium", colour=ORANGE)

    for x, high, colour in ((-6.5, 0.14, GREEN), (-5.9, 0.74, RED), (-4.3, 0.74, BLUE), (-2.5, 0.14, BLUE), (-1.9, 1.34, GREEN)):
        hall.box("store-", (x, -5.5, high), (0.45, 0.4, 0.25), "nylon", mass=4.0, colour=colour)

    hall.note("Tables with parts and trays.")
    for x, y in ((-3.6, -2.6), (-0.6, -2.6), (0.4, 2.9), (-2.4, 2.4), (6.2, 2.6)):
        hall.box("table-", (x, y, 0.56), (1.4, 0.8, 0.04), colour=PALE)
        for side in (-0.6, 0.6):
            hall.box("table-leg-", (x + side, y, 0), (0.06, 0.7, 0.56), "aluminium", colour=DARK)

    top = 0.6

    def part(name, x, y, size, mass, colour, low=top):
        hall.box(name, (x, y, low), size, "nylon", mass=mass, colour=colour)

    for place, colour, edge, mass, name in ((-4.1, RED, 0.1, 1.0, "part-a-"), (-3.6, GREEN, 0.08, 0.5, "part-b-"),
                                            (-3.1, BLUE, 0.12, 1.5, "part-c-")):
        for column in range(2):
            for row in range(2):
                part(name, place + 0.18 * column - 0.09, -2.7 + 0.22 * row, (edge, edge, edge), mass, colour)
    part("kit-tray-1", -0.9, -2.6, (0.6, 0.4, 0.05), 5.0, DARK)
    part("kit-tray-2", -0.25, -2.6, (0.4, 0.3, 0.05), 5.0, DARK)
    for column in range(3):
        hall.cylinder("gear-", (0.1 + 0.25 * column, 2.8, top), 0.05, 0.03, "aluminium", mass=1.0)
        hall.cylinder("shaft-", (0.1 + 0.25 * column, 3.05, top), 0.02, 0.12, "aluminium", mass=1.0)
    part("tray-gears", -2.4, 2.4, (0.6, 0.4, 0.1), 10.0, GREEN)
    part("bin", 6.2, 2.6, (0.6, 0.4, 0.3), 10.0, BLUE)

    hall.note("Pallets with crates, and what rides on the first conveyor.")
    for x, y in ((-5.4, 4.6), (-3.8, 4.6)):
        hall.box("pallet-", (x, y, 0), (1.2, 0.8, 0.144), mass=18.0, colour=OLD)
        hall.box("crate-", (x - 0.25, y, 0.144), (0.5, 0.5, 0.5), mass=5.0, colour=PALE)
        if x < -5:
            hall.box("crate-", (x + 0.3, y, 0.144), (0.4, 0.4, 0.4), mass=3.0, colour=PLY)
    hall.box("parcel", (2.6, 1.6, 0.5), (0.3, 0.3, 0.2), mass=2.0, colour=OLD)

    hall.note("Robots start in the lane.")
    hall.pose("start", "PlayerStart_0", (-5.6, 0.0))
    hall.pose("start", "RobotStart1", (-3.6, 0.0))
    hall.pose("start", "RobotStart2", (-1.0, 0.0))
    hall.pose("start", "RobotStart3", (5.6, 4.4), -math.pi / 2)
    hall.pose("start", "RobotStart4", (4.4, 0.0), math.pi)
    for name, place in (("Parts", (-3.6, -1.8)), ("Kits", (-0.6, -1.8)), ("Gears", (0.4, 2.1)), ("Pallets", (-4.6, 3.5)),
                        ("BeltBegin", (1.8, 1.8)), ("BeltEnd", (6.2, -1.9))):
        hall.pose("path_node", name, place)
    return hall.text()


# ---------------------------------------------------------------------------------------------------------------------------------


def soccer():
    length, width, line, border = 9.0, 6.0, 0.05, 0.7
    field = Map("""
The field of RoboCup's Standard Platform League: 9 x 6 m with a border of 0.7 m, goals of 1.5 m and a ball of 10 cm. Lines are only seen, so
that no wheel feels them and no laser measures them.""",
                "Soccer field of RoboCup's Standard Platform League, 9 x 6 m, with two goals and a ball",
                ("SoccerRobot", "Nao", "YouBot"))
    field.table("!material.ball", friction=0.5, restitution=0.4, angular_damping=0.3, colour=ORANGE,
                source="a foam ball on carpet; it rolls a few metres")
    field.table("!material.artificial-grass", friction=0.8, rolling_resistance=0.03, colour=(0.20, 0.45, 0.22),
                source="as the shipped carpet, in green")
    field.table("half_space", name="field", material="artificial-grass")

    def white(name, x, y, along, across, turn=None):
        field.marking(name, (x, y), (along, across), WHITE, turn, thick=0.004)

    field.note("Lines of 5 cm.")
    for side in (-1, 1):
        white("touch-line-", 0, side * width / 2, length + line, line)
        white("goal-line-", side * length / 2, 0, line, width - line)
    white("halfway-line", 0, 0, line, width - line)
    white("centre-mark", 0, 0, 0.1, line)
    for side in (-1, 1):
        for name, deep, wide in (("goal-area", 0.6, 2.2), ("penalty-area", 1.65, 4.0)):
            white(f"{name}-", side * (length / 2 - deep), 0, line, wide + line)
            for across in (-1, 1):
                white(f"{name}-", side * (length / 2 - deep / 2), across * wide / 2, deep - line, line)
        for along, across in ((0.1, line), (line, 0.1)):
            white("penalty-mark-", side * (length / 2 - 1.3), 0, along, across)
    count = 36
    for part in range(count):
        angle = 2 * math.pi * (part + 0.5) / count
        white("circle-", 0.75 * math.cos(angle), 0.75 * math.sin(angle), line, 2 * math.pi * 0.775 / count, (0, 0, angle))

    field.note("Goals, with nets behind that balls do not pass.")
    for side, name in ((-1, "own"), (1, "other")):
        x = side * (length / 2)
        for across in (-0.8, 0.8):
            field.cylinder(f"{name}-post-", (x, across, 0), 0.05, 0.85, "aluminium", colour=WHITE)
            field.box(f"{name}-net-", (x + side * 0.27, across, 0), (0.44, 0.03, 0.5), "aluminium", colour=(0.78, 0.80, 0.82))
        field.cylinder(f"{name}-bar", (x, 0, 0), 0.05, 1.7, "aluminium", turn=(math.pi / 2, 0, 0), colour=WHITE)
        field.box(f"{name}-net-", (x + side * 0.5, 0, 0), (0.03, 1.63, 0.5), "aluminium", colour=(0.78, 0.80, 0.82))

    field.note("Boards around the border keep the ball in.")
    for side in (-1, 1):
        field.box("board-", (0, side * (width / 2 + border + 0.02), 0), (length + 2 * border, 0.04, 0.15), colour=DARK)
        field.box("board-", (side * (length / 2 + border + 0.02), 0, 0), (0.04, width + 2 * border + 0.08, 0.15), colour=DARK)

    field.note("The ball.")
    field.table("ball", name="ball", material="ball", position=(0, 0, -0.05), radius=0.05, mass=0.044)

    field.note("Robots start in the left half, which is at the back, and look at the other goal.")
    field.pose("start", "PlayerStart_0", (-1.5, 0.0))
    for index, place in enumerate(((-2.4, -1.6), (-2.4, 1.6), (-3.6, 0.0), (1.5, 0.0), (2.4, 1.6), (2.4, -1.6), (3.6, 0.0))):
        field.pose("start", f"RobotStart{index + 1}", place, math.pi if place[0] > 0 else 0.0)
    for name, place in (("Centre", (0, 0)), ("OwnGoal", (-length / 2, 0)), ("OtherGoal", (length / 2, 0))):
        field.pose("path_node", name, place)
    return field.text()


def main():
    stale = []
    for make in (rescue, factory, soccer):
        file = Path(__file__).parent / make.__name__ / "map.toml"
        text = make()
        if "--check" in sys.argv[1:]:
            if not file.is_file() or file.read_text() != text:
                stale.append(file)
            continue
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
        print(f"{file.parent.name}: {text.count('[[') } tables, {len(text)} bytes")
    if stale:
        sys.exit("not as made by maps/make.py: " + ", ".join(map(str, stale)))


if __name__ == "__main__":
    main()
