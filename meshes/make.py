#!/usr/bin/env python3
"""Makes the meshes by which the shipped robots are seen: every `*.glb` below assets.

    python3 meshes/make.py           writes them, and prints their triangles and bytes
    python3 meshes/make.py --check   fails if one of the files differs

The same files, byte for byte, come of it each time. Meshes are only looked at: what touches the world is in robot.toml.
A folder has all that its robot needs, so that it can be copied; a mesh of several robots is in each of their folders.
"""

import sys
from pathlib import Path

import airborne
import arms
import basic
import cars
import kenaf
import nao
import pioneer
import stands
import tracked
import wheeled
import youbot

ASSETS = Path(__file__).parent.parent / "assets"
MODULES = [airborne, arms, basic, cars, kenaf, nao, pioneer, stands, tracked, wheeled, youbot]
# Most bytes of a folder's meshes: the program has all of them in it.
BUDGET = 45_000


def main(check):
    wrong, total = [], 0
    folders = {}
    for module in MODULES:
        for folder, meshes in module.FILES.items():
            folders[folder] = folders.get(folder, {}) | meshes
    for folder, meshes in sorted(folders.items()):
        size = 0
        for file, make in meshes.items():
            path, mesh = ASSETS / folder / file, make()
            data = mesh.glb()
            size += len(data)
            if not check:
                path.write_bytes(data)
                print(f"{folder}/{file}: {mesh.count()} triangles, {len(data)} bytes")
            elif not path.is_file() or path.read_bytes() != data:
                wrong.append(f"{folder}/{file}: not what meshes/make.py makes")
        unknown = {path.name for path in (ASSETS / folder).glob("*.glb")} - set(meshes)
        wrong += [f"{folder}/{file}: made by nothing" for file in sorted(unknown)]
        if size > BUDGET:
            wrong.append(f"{folder}: {size} bytes of meshes, the budget is {BUDGET}")
        total += size
    print(f"{total} bytes of meshes")
    if wrong:
        sys.exit("\n".join(wrong))


if __name__ == "__main__":
    main("--check" in sys.argv[1:])
