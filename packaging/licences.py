#!/usr/bin/env python3
"""The licences of everything that is built into the program: crates, and packages of the page.

Usage: licences.py TARGET > copyright
"""

import glob
import json
import os
import subprocess
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
NAMES = ["LICENSE*", "LICENCE*", "COPYING*", "UNLICENSE*", "license*", "NOTICE*"]


# Debian has it once, and so has an archive.
APACHE = "The Apache License 2.0: /usr/share/common-licenses/Apache-2.0 on Debian, otherwise the file LICENSE-APACHE."


def texts(folder):
    """The licence files of a folder."""
    files = {file for name in NAMES for file in glob.glob(os.path.join(folder, name)) if os.path.isfile(file)}
    read = (open(file, encoding="utf-8", errors="replace").read().strip() for file in files)
    return sorted(APACHE if text.startswith("Apache License") else text for text in read)


def crates(target):
    """Name, licence and folder of every crate of others that the program is linked with."""
    run = lambda *arguments: subprocess.run(["cargo", *arguments], check=True, capture_output=True, text=True, cwd=ROOT).stdout
    tree = run("tree", "-p", "usarsim", "-e", "normal", "--target", target, "--prefix", "none", "--format", "{p}", "--locked")
    linked = {tuple(line.split()[:2]) for line in tree.splitlines() if line}
    metadata = json.loads(run("metadata", "--format-version", "1", "--filter-platform", target, "--locked"))
    for package in metadata["packages"]:
        if package["source"] and (package["name"], "v" + package["version"]) in linked:
            folder = os.path.dirname(package["manifest_path"])
            yield f"{package['name']} {package['version']}", package["license"] or "see below", folder


def modules():
    """The same of the packages that the page is made of."""
    with open(os.path.join(ROOT, "viewer/package.json")) as file:
        names = json.load(file).get("dependencies", {})
    for name in names:
        folder = os.path.join(ROOT, "viewer/node_modules", name)
        if os.path.isdir(folder):
            with open(os.path.join(folder, "package.json")) as file:
                package = json.load(file)
            yield f"{name} {package['version']}", package["license"], folder


def main():
    used = {}
    print("usarsim is under the MIT licence or the Apache License 2.0, as you like. Both are below.\n")
    print("Built into it are these works of others:\n")
    for name, licence, folder in [("usarsim", "", ROOT), *sorted(crates(sys.argv[1])), *modules()]:
        if licence:
            print(f"  {name}: {licence}")
        for text in texts(folder):
            used.setdefault(text, []).append(name)
    for text, names in used.items():
        print(f"\n{'-' * 80}\n{', '.join(names)}\n\n{text}")


main()
