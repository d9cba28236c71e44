"""KUKA youBot: 0.58 x 0.38 x 0.14 m as commonly quoted; here over the 0.56 x 0.34 m that collide. The origin is between its axles."""

import math

from parts import hokuyo
from solids import *


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


YOUBOT = {"base.glb": youbot_base, "hub.glb": mecanum_hub, "hokuyo.glb": hokuyo}
ARM = {"arm-foot.glb": arm_foot, "arm-1.glb": arm_1, "arm-2.glb": arm_2, "arm-3.glb": arm_3, "arm-4.glb": arm_4,
       "arm-5.glb": arm_5, "finger.glb": finger}
FILES = {"robots/KUKA_YouBot": YOUBOT, "robots/YouBot": YOUBOT, "robots/YouBotArm": YOUBOT | ARM}
