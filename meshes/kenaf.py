"""Kenaf of the IRS and Tohoku University: grey, with yellow bands. Places and radii as in robot.toml."""

from parts import add_rollers
from solids import *
from tracked import flipper


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
    for y in (-0.11, 0.11):
        add_rollers(mesh, [(0.2, 0, 0.06), (-0.2, 0, 0.06), (-0.07, 0, 0.06), (0.07, 0, 0.06)], y, 0.05)
    mesh.add_pair(rod(0.012, 0.0, 0.008, 8), LAMP, (0.200, 0.05, -0.024), X)
    for x in (-0.13, 0.13):  # handles
        mesh.add_pair(box(0.01, 0.01, 0.03), BLACK, (x, 0.055, -0.09))
        mesh.add(box(0.012, 0.12, 0.01), BLACK, (x, 0, -0.104))
    return mesh


FILES = {"robots/Kenaf": {"body.glb": kenaf_body, "flipper.glb": lambda: flipper(0.06, 0.04, 0.145, 0.04, YELLOW)}}
