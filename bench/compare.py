#!/usr/bin/env python3
"""usarsim beside MuJoCo: the same robots, the same motions, on one core of this machine, in one run.

    python3 -m venv venv && venv/bin/pip install mujoco numpy
    cargo build --release --bin usarsim      # or USARSIM names another build of the program
    venv/bin/python bench/compare.py [--seconds 10] [--repeat 3] [--out docs/comparison.md] [--check docs/comparison.md]
    python3 -m venv older && older/bin/pip install mujoco==3.17.0 numpy
    venv/bin/python bench/compare.py --crowds --beside older/bin/python

Both are driven forward, to the right and on the spot at 1 rad/s and compared with the exact kinematics of wheels with six
rollers for the angles that the wheels turned. MuJoCo gets the robot that `usarsim show robot KUKA_YouBot` prints, with its
24 rollers as bodies on hinges.

The P3AT is driven forward and on the spot at 1 rad/s and compared with the twist at which Coulomb's friction balances: on four equal
loads at (+-a, +-b) it turns with w R b / (a^2 + b^2). In MuJoCo contacts do not feel the servos, so a rotor that the robot does not
have and a softer servo are tried beside the robot's own.

A youBot with its arm on a flat floor and a Kenaf with its flippers half on the arena's step are the same trees of links in both, with
their own servos; what is compared is the time of a step of the same length.

Crowds of P3ATs on a grid of 0.75 m drive to its middle at 5 rad/s, where they push and climb, and one drives into a wall of boxes. What is
compared is the time of a robot, or box, and step. MuJoCo's P3ATs are a box on four cylinders with the softer servo and the rotor.
MuJoCo 4.0.0's Newton solver factorises its sparse matrix wrongly (google-deepmind/mujoco#3767), so crowds can run in an older MuJoCo, too.

Every row is the fastest of the repeats, which take turns, as these machines are noisy.
Units: m, s, rad, kg; x forward, y left, z up.
"""

import argparse
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time

import mujoco
import numpy as np

USARSIM = os.environ.get("USARSIM") or os.path.join(os.path.dirname(__file__), "..", "target", "release", "usarsim")
# Front left, front right, back left, back right.
MOTIONS = {"forward": (1, 1, 1, 1), "left": (-1, 1, 1, -1), "turn": (-1, 1, -1, 1)}


def robot(name="KUKA_YouBot"):
    shown = subprocess.run([USARSIM, "show", "robot", name, "--json"], check=True, capture_output=True)
    return json.loads(shown.stdout)


def roller_geoms(shape, radius, rollers):
    """MuJoCo's shapes of a roller whose axis is y."""
    circle, angle, end = rollers["axis_circle"], abs(rollers["angle"]), rollers["last_phase"]
    thick, mass = radius - circle, rollers["mass"]
    contact = 'condim="3" friction="0.85 0 0"'
    if shape == "ellipsoid":
        # The half length at which its curvature in the middle is the roller's.
        half = math.sqrt(thick * radius) / math.sin(angle)
        return f'<geom type="ellipsoid" size="{thick} {half} {thick}" mass="{mass}" {contact}/>'
    count = int(shape.removeprefix("chain "))
    places = np.linspace(-1, 1, count) * circle * math.tan(end) / math.sin(angle)
    radii = radius - np.hypot(circle, places * math.sin(angle))
    sphere = '<geom type="sphere" pos="0 {} 0" size="{}" mass="{}" {}/>'
    return "".join(sphere.format(y, r, mass / count, contact) for y, r in zip(places, radii))


def wheel_xml(index, wheel, shape):
    rollers, radius = wheel["rollers"], wheel["radius"]
    x, y, _ = wheel["position"]
    # Ours is y right, z down.
    hand = -math.copysign(1, rollers["angle"])
    spin = wheel["mass"] * rollers["axis_circle"] ** 2 / 2
    xml = (
        f'<body pos="{x} {-y} 0"><joint name="w{index}" axis="0 1 0"/>'
        f'<inertial pos="0 0 0" mass="{wheel["mass"]}" diaginertia="{spin} {spin} {spin}"/>'
    )
    for k in range(rollers["count"]):
        turn = 2 * math.pi * k / rollers["count"]
        radial = np.array([math.cos(turn), 0, math.sin(turn)])
        tangent = np.array([-math.sin(turn), 0, math.cos(turn)])
        axis = math.cos(abs(rollers["angle"])) * np.array([0, 1, 0]) + hand * math.sin(abs(rollers["angle"])) * tangent
        # The quaternion that turns y into the axis.
        quaternion = np.array([1 + axis[1], *np.cross([0, 1, 0], axis)])
        quaternion /= np.linalg.norm(quaternion)
        place = radial * rollers["axis_circle"]
        xml += (
            f'<body pos="{place[0]} {place[1]} {place[2]}" quat="{" ".join(map(str, quaternion))}">'
            f'<joint axis="0 1 0" damping="{rollers["damping"]}"/>{roller_geoms(shape, radius, rollers)}</body>'
        )
    return xml + "</body>"


def wheels_of(definition):
    """The wheels, each with the position of the joint that carries it."""
    return [link["wheel"] | {"position": link["joint"]["anchor"]} for link in definition["links"] if "wheel" in link]


def model(definition, shape, cone, dt):
    wheels = wheels_of(definition)
    mass = sum(part["mass"] for link in definition["links"] for part in link["parts"])
    body = "".join(wheel_xml(index, wheel, shape) for index, wheel in enumerate(wheels))
    servos = "".join(f'<velocity joint="w{index}" kv="100"/>' for index in range(4))
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{dt}" integrator="implicitfast" cone="{cone}" impratio="{10 if cone == "elliptic" else 1}"/>'
        '<default><geom contype="0" conaffinity="1" solref="0.004 1"/></default><worldbody>'
        '<geom type="plane" size="50 50 1" contype="1" friction="0.85 0 0"/>'
        f'<body pos="0 0 {wheels[0]["radius"]}"><freejoint/>'
        f'<inertial pos="0 0 0.05" mass="{mass}" diaginertia="0.2 0.4 0.5"/>{body}</body></worldbody>'
        f"<actuator>{servos}</actuator></mujoco>"
    )


def exact(definition):
    """Travel of each motion per radian of the wheels, in the mean over the phases of the rollers."""
    wheels = wheels_of(definition)
    radius, half = wheels[0]["radius"], math.pi / wheels[0]["rollers"]["count"]
    base, track = wheels[0]["position"][0], abs(wheels[0]["position"][1])
    lateral = math.sin(half) / half
    # One wheel by itself; four wheels together, as they turn in phase, are 0.1 % less.
    phases = np.linspace(-half, half, 2001)
    circle = wheels[0]["rollers"]["axis_circle"]
    turning = np.mean((base + track) / (track + circle * np.tan(phases) + base / np.cos(phases)))
    return {"forward": radius, "left": lateral * radius, "turn": turning * radius / (base + track)}


def drive(scene, speeds, actuators, joints, dt, seconds):
    """Settles, brings wheels to speeds and drives on: how far it went, turned and its wheels turned, and the seconds it took."""
    data, steps = mujoco.MjData(scene), int(seconds / dt) // 20
    mujoco.mj_step(scene, data, int(0.5 / dt))
    data.ctrl[actuators] = speeds
    mujoco.mj_step(scene, data, int(2 / dt))
    place, angles = data.qpos[:2].copy(), data.qpos[joints].copy()
    yaw, last = 0.0, 2 * math.atan2(data.qpos[6], data.qpos[3])
    start = time.perf_counter()
    for _ in range(20):
        mujoco.mj_step(scene, data, steps)
        now = 2 * math.atan2(data.qpos[6], data.qpos[3])
        yaw, last = yaw + (now - last + math.pi) % (2 * math.pi) - math.pi, now
    wall = time.perf_counter() - start
    turned = float(np.mean(np.abs(data.qpos[joints] - angles)))
    return float(np.linalg.norm(data.qpos[:2] - place)), abs(yaw), turned, wall


def driven_time(dt, seconds):
    """Simulated seconds of a drive, which are whole steps in twenty parts."""
    return int(seconds / dt) // 20 * 20 * dt


def places(scene, wheels):
    """Where the angles of wheels are in the state."""
    return [scene.joint(f"w{wheel}").qposadr[0] for wheel in wheels]


def mujoco_row(definition, shape, cone, dt, seconds):
    scene, ways = model(definition, shape, cone, dt), exact(definition)
    ratios, spent, joints = {}, 0.0, places(scene, range(4))
    for name, signs in MOTIONS.items():
        way, yaw, turned, wall = drive(scene, signs, range(4), joints, dt, seconds)
        spent += wall
        ratios[name] = (yaw if name == "turn" else way) / (ways[name] * turned)
    error = 100 * max(abs(ratio - 1) for ratio in ratios.values())
    return {"factor": len(MOTIONS) * driven_time(dt, seconds) / spent, "error": error, "ratios": ratios}


def p3at_model(definition, shape, gain, rotor, dt):
    """A P3AT whose middle of mass is between its wheels, so that its loads are equal."""
    wheels = wheels_of(definition)
    mass = sum(part["mass"] for link in definition["links"] for part in link["parts"])
    xml = ""
    for index, wheel in enumerate(wheels):
        x, y, _ = wheel["position"]
        radius, half = wheel["radius"], wheel["width"] / 2
        geom = {"sphere": f'type="sphere" size="{radius}"', "cylinder": f'type="cylinder" size="{radius} {half}" euler="90 0 0"'}[shape]
        xml += (
            f'<body pos="{x} {-y} 0"><joint name="w{index}" axis="0 1 0" armature="{rotor}"/>'
            f'<geom {geom} mass="{wheel["mass"]}" condim="3" friction="0.85 0 0"/></body>'
        )
    servos = "".join(f'<velocity joint="w{index}" kv="{gain}" forcerange="-20 20"/>' for index in range(len(wheels)))
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="degree"/><option timestep="{dt}" integrator="implicitfast" cone="elliptic" impratio="10"/>'
        '<worldbody><geom type="plane" size="50 50 1" condim="3" friction="0.85 0 0"/>'
        f'<body pos="0 0 {wheels[0]["radius"]}"><freejoint/>'
        f'<inertial pos="0 0 0.02" mass="{mass}" diaginertia="0.1 0.2 0.25"/>{xml}</body></worldbody>'
        f"<actuator>{servos}</actuator></mujoco>"
    )


def mujoco_p3at_row(definition, shape, gain, rotor, dt, seconds):
    scene, wheels = p3at_model(definition, shape, gain, rotor, dt), wheels_of(definition)
    radius, (base, track, _) = wheels[0]["radius"], map(abs, wheels[0]["position"])
    ratios, spent, joints = {}, 0.0, places(scene, range(len(wheels)))
    for name, left in (("forward", 1), ("turn", -1)):
        signs = [1 if wheel["side"] == "Right" else left for wheel in wheels]
        way, yaw, turned, wall = drive(scene, signs, range(len(wheels)), joints, dt, seconds)
        spent += wall
        ratios[name] = (yaw / (track / (base**2 + track**2)) if name == "turn" else way) / (radius * turned)
    error = 100 * max(abs(ratio - 1) for ratio in ratios.values())
    return {"factor": 2 * driven_time(dt, seconds) / spent, "error": error, "ratios": ratios}


# Step between the numbers of the wheels of a row.
ROW = 1000


def flipped(vector):
    """From x forward, y right, z down to x forward, y left, z up; a turn about x, so axes go the same way."""
    return np.array([vector[0], -vector[1], -vector[2]])


def numbers(values):
    return " ".join(f"{value:.9g}" for value in values)


def row_xml(links, number, servos):
    """A track as a row of wheels, as MuJoCo has no belts: one at each roller, and in the middle of a long run."""
    link, joint = links[number], links[number]["joint"]
    wheel, drive = link["wheel"], joint["drive"]
    discs = [np.array(disc) for disc in wheel["belt"]["rollers"]]
    if len(discs) == 2 and np.linalg.norm(discs[0][:2] - discs[1][:2]) > 0.3:
        discs.append((discs[0] + discs[1]) / 2)
    parent, xml = links[joint["parent"]].get("joint"), ""
    for place, (x, z, radius) in enumerate(discs):
        name = f"w{number + ROW * place}"
        at = flipped([x, joint["anchor"][1], z]) - (flipped(parent["anchor"]) if parent else 0)
        most = drive["max_torque"] / len(discs)
        servos.append(f'<velocity joint="{name}" kv="{drive["gain"] / len(discs)}" forcerange="{-most} {most}"/>')
        xml += (
            f'<body pos="{numbers(at)}"><joint name="{name}" axis="{numbers(flipped(joint["axis"]))}"/><geom type="cylinder" '
            f'size="{radius} {wheel["width"] / 2}" euler="90 0 0" mass="{wheel["mass"] / len(discs)}" friction="0.85 0 0"/></body>'
        )
    return xml


def tree_xml(links, number, servos, height=0.0):
    """A link of the definition with what hangs on it, and its servos; the root at a height."""
    link, joint = links[number], links[number].get("joint")
    if link.get("wheel", {}).get("belt"):
        return row_xml(links, number, servos)
    if "rollers" in link.get("wheel", {}):
        servos.append(f'<velocity joint="w{number}" kv="{joint["drive"]["gain"]}"/>')
        parent = links[joint["parent"]].get("joint", {"anchor": [0, 0, 0]})["anchor"]
        place = [own - its for own, its in zip(joint["anchor"], parent)]
        xml = wheel_xml(number, link["wheel"] | {"position": place}, "ellipsoid")
        return xml.replace(' 0"><joint name', f' {-place[2]}"><joint name', 1)
    origin = flipped(joint["anchor"]) if joint else np.zeros(3)
    parent = links[joint["parent"]].get("joint") if joint else None
    place = origin - (flipped(parent["anchor"]) if parent else 0) if joint else [0, 0, height]
    xml = f'<body pos="{numbers(place)}">'
    if joint is None:
        xml += "<freejoint/>"
    else:
        drive = joint.get("drive")
        kind = "slide" if joint["kind"] == "Prismatic" else "hinge"
        ends = f' limited="true" range="{numbers(joint["limits"])}"' if "limits" in joint else ""
        xml += (
            f'<joint name="w{number}" type="{kind}" axis="{numbers(flipped(joint["axis"]))}"{ends} damping="{joint["damping"]}" '
            f'frictionloss="{joint["friction"]}" armature="{drive["armature"] if drive else 0}"/>'
        )
        if drive:
            most = f'forcerange="{-drive["max_torque"]} {drive["max_torque"]}"'
            position = f'<position joint="w{number}" kp="{drive.get("stiffness")}" kv="{drive["gain"]}" {most}/>'
            servos.append(position if "stiffness" in drive else f'<velocity joint="w{number}" kv="{drive["gain"]}" {most}/>')
    masses = [(part["mass"], flipped(part["centre"]) - origin, np.array(part["inertia"]).reshape(3, 3)) for part in link["parts"]]
    turn = np.diag([1.0, -1.0, -1.0])
    if masses:
        mass = sum(part[0] for part in masses)
        centre = sum(part[0] * part[1] for part in masses) / mass
        about = sum(turn @ own @ turn + m * ((at - centre) @ (at - centre) * np.eye(3) - np.outer(at - centre, at - centre)) for m, at, own in masses)
        full = [about[0, 0], about[1, 1], about[2, 2], about[0, 1], about[0, 2], about[1, 2]]
        xml += f'<inertial pos="{numbers(centre)}" mass="{mass}" fullinertia="{numbers(full)}"/>'
    for solid in link["solids"]:
        half = np.array(solid["shape"]["Box"]["size"]) / 2
        xml += f'<geom type="box" pos="{numbers(flipped(solid["position"]) - origin)}" size="{numbers(half)}" mass="0" friction="0.6 0 0"/>'
    if "wheel" in link:
        wheel = link["wheel"]
        xml += f'<geom type="cylinder" size="{wheel["radius"]} {wheel["width"] / 2}" euler="90 0 0" mass="{wheel["mass"]}" friction="0.85 0 0"/>'
    children = [child for child, it in enumerate(links) if it.get("joint", {}).get("parent") == number and "joint" in it]
    return xml + "".join(tree_xml(links, child, servos) for child in children) + "</body>"


def mujoco_tree_row(definition, step, cone, dt, seconds):
    """Times real time of a robot in the motions of `usarsim bench`, on a floor or half on a step."""
    servos, links = [], definition["links"]
    lowest = max(link["joint"]["anchor"][2] + link["wheel"]["radius"] for link in links if "wheel" in link)
    solid = '<geom type="box" pos="5 0 0.025" size="5 5 0.025" contype="1" friction="0.85 0 0"/>' if step else ""
    body = tree_xml(links, 0, servos, lowest + (0.051 if step else 0.001))
    scene = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="degree"/><option timestep="{dt}" integrator="implicitfast" cone="{cone}" impratio="{10 if cone == "elliptic" else 1}"/>'
        '<default><geom contype="0" conaffinity="1" condim="3" solref="0.004 1"/></default>'
        f'<worldbody><geom type="plane" size="50 50 1" contype="1" friction="0.85 0 0"/>{solid}{body}</worldbody>'
        f'<actuator>{"".join(servos)}</actuator></mujoco>'
    )
    driven = [(index, int(servo.split('"')[1][1:])) for index, servo in enumerate(servos) if servo.startswith("<velocity")]
    actuators, wheels = [index for index, _ in driven], [links[number % ROW]["wheel"] for _, number in driven]
    if "rollers" in wheels[0]:
        motions = [(1, 1, 1, 1), (1, -1, -1, 1), (1, -1, 1, -1)]
    else:
        motions = [[left if wheel["side"] == "Left" else right for wheel in wheels] for left, right in ((1, 1), (1, -1), (1, 0.5))]
    joints = places(scene, [number for _, number in driven])
    drives = [drive(scene, speeds, actuators, joints, dt, seconds) for speeds in motions]
    is_sound = all(np.isfinite(drive).all() for drive in drives)
    return len(motions) * driven_time(dt, seconds) / sum(wall for *_, wall in drives) if is_sound else 0.0


def trees(seconds, repeat):
    """The table of robots whose trees both have, each the fastest of the repeats."""
    lines = ["| robot | step, ms | MuJoCo, pyramidal | MuJoCo, elliptic | usarsim, `articulated` | times the faster |", "|---|---|---|---|---|---|"]
    for name, place, floor in (("YouBotArm", "a floor", None), ("Kenaf", "the arena's step", "bench/floors/step.toml")):
        definition = robot(name)
        for dt in (0.002, 0.004, 0.008):
            best = [0.0] * 3
            for turn in range(repeat):
                print(f"\r{turn + 1}/{repeat} {name} {1e3 * dt:g} ms {'':60}", end="", flush=True, file=sys.stderr)
                found = [mujoco_tree_row(definition, floor, cone, dt, seconds) for cone in ("pyramidal", "elliptic")]
                found.append(usarsim_row("articulated", dt, seconds, name, (), floor or "rough")["factor"])
                best = [max(pair) for pair in zip(best, found)]
            factors = " | ".join(f"{factor:.0f}" for factor in best)
            lines.append(f"| {name} on {place} | {1e3 * dt:g} | {factors} | {best[2] / max(best[:2]):.1f} |")
    return lines


def crowd_body(number, x, y, yaw):
    """A P3AT as a box on four cylinders at a place, heading somewhere."""
    wheel = (
        '<body pos="{} {} 0"><joint name="r{}w{}" axis="0 1 0" armature="0.5"/>'
        '<geom type="cylinder" size="0.098 0.0375" euler="90 0 0" mass="0.1" friction="0.85 0 0"/></body>'
    )
    corners = [(1, 1), (1, -1), (-1, 1), (-1, -1)]
    wheels = "".join(wheel.format(0.124 * ahead, 0.18 * aside, number, wheel_number) for wheel_number, (ahead, aside) in enumerate(corners))
    return (
        f'<body pos="{x} {y} 0.0985" euler="0 0 {math.degrees(yaw)}"><freejoint/>'
        f'<geom type="box" size="0.23 0.135 0.09" pos="0 0 0.02" mass="11.5" friction="0.4 0 0"/>{wheels}</body>'
    )


def wall_of_boxes(count):
    """Boxes of 0.2 m, ten high: the place of each, x forward, y left, z up."""
    return [(2, (number // 10 - count // 20) * 0.201, 0.1 + number % 10 * 0.2) for number in range(count)]


def mujoco_crowd_row(robots, boxes, cone, dt, seconds):
    """Microseconds a robot, or box, and step, and how often MuJoCo found its state to be unstable and began anew."""
    side = math.ceil(math.sqrt(robots))
    bodies = ""
    for number in range(robots):
        x, y = ((place - (side - 1) / 2) * 0.75 for place in (number % side, number // side))
        bodies += crowd_body(number, x, y, math.atan2(-y, -x) if x or y else 0)
    for x, y, z in wall_of_boxes(boxes):
        bodies += f'<body pos="{x} {y} {z}"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1" friction="0.4 0 0"/></body>'
    servos = "".join(f'<velocity joint="r{number}w{wheel}" kv="5" forcerange="-20 20"/>' for number in range(robots) for wheel in range(4))
    scene = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="degree"/><size memory="2G"/><option timestep="{dt}" integrator="implicitfast" cone="{cone}" impratio="{10 if cone == "elliptic" else 1}"/>'
        f'<worldbody><geom type="plane" size="50 50 1" friction="0.85 0 0"/>{bodies}</worldbody><actuator>{servos}</actuator></mujoco>'
    )
    data, steps = mujoco.MjData(scene), int(seconds / dt)
    data.ctrl[:] = 5
    start, unstable = time.perf_counter(), 0
    for _ in range(steps):
        mujoco.mj_step(scene, data)
        if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
            # It has begun anew, with commands of 0.
            unstable, data.ctrl[:] = unstable + 1, 5
            data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number = 0
    return 1e6 * (time.perf_counter() - start) / steps / max(robots, boxes), unstable


def usarsim_crowd_row(robots, boxes, dt, seconds, folder):
    """The same of usarsim, without sensors, and the longest step in ms."""
    path = os.path.join(folder, f"wall-{boxes}.toml")
    with open(path, "w") as file:
        file.write('description = "A floor, with a wall of boxes"\n[[half_space]]\nname = "floor"\nmaterial = "concrete"\n[[start]]\nname = "start"\nposition = [0.0, 0.0, 0.0]\nrotation = [0.0, 0.0, 0.0]\n')
        for number, (x, y, z) in enumerate(wall_of_boxes(boxes)):
            file.write(f'[[box]]\nname = "box-{number}"\nmaterial = "plywood"\nposition = [{x}.0, {y:.4f}, {-z:.4f}]\nsize = [0.2, 0.2, 0.2]\nmass = 1.0\n')
    bare = os.path.join(folder, "P3AT", "robot.toml")
    command = [USARSIM, "bench", "--crowd", "--robot", bare, "--robots", str(robots), "--dt", str(dt), "--seconds", str(seconds), "--map", path, "--json"]
    report = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    return report["microseconds_per_robot_and_step"] * robots / max(robots, boxes), report["worst_step_milliseconds"]


def crowd_row_of(python, *row):
    """A crowd's row by another Python, which has another MuJoCo."""
    made = subprocess.run([python, __file__, "--crowd-row", json.dumps(row)], check=True, capture_output=True)
    return json.loads(made.stdout)


def version_of(python):
    """The version of another Python's MuJoCo."""
    made = subprocess.run([python, "-c", "import mujoco; print(mujoco.__version__)"], check=True, capture_output=True, text=True)
    return made.stdout.strip()


def crowds(seconds, repeat, folder, beside=None):
    """The table of crowds and walls, each time the shortest of the repeats. `beside` is a Python with another MuJoCo."""
    runs = {mujoco.__version__: mujoco_crowd_row}
    if beside:
        runs[version_of(beside)] = lambda *row: crowd_row_of(beside, *row)
    runs = {(version, cone): run for version, run in runs.items() for cone in ("pyramidal", "elliptic")}
    head = " | ".join(f"MuJoCo {version}, {cone}, us" for version, cone in runs)
    lines = [f"| what | step, ms | {head} | usarsim, us | usarsim, longest step, ms | times the faster |", "|---|---|" + "---|" * (len(runs) + 3)]
    for robots, boxes in ((5, 0), (20, 0), (80, 0), (1, 500)):
        for dt in (0.002, 0.004):
            best, own, longest, unstable = [math.inf] * len(runs), math.inf, math.inf, 0
            for turn in range(repeat):
                print(f"\r{turn + 1}/{repeat} {robots} robots, {boxes} boxes, {1e3 * dt:g} ms {'':60}", end="", flush=True, file=sys.stderr)
                found = [run(robots, boxes, cone, dt, seconds) for (_, cone), run in runs.items()]
                unstable = max(unstable, *(count for _, count in found))
                best = [min(pair) for pair in zip(best, (each for each, _ in found))]
                each, worst = usarsim_crowd_row(robots, boxes, dt, seconds, folder)
                own, longest = min(own, each), min(longest, worst)
            what = f"{robots} P3ATs" if robots > 1 else f"a wall of {boxes} boxes"
            note = f" (unstable, begun anew {unstable} times)" if unstable else ""
            theirs = " | ".join(f"{each:.1f}" for each in best)
            lines.append(f"| {what}{note} | {1e3 * dt:g} | {theirs} | {own:.1f} | {longest:.1f} | {min(best) / own:.2f} |")
    return lines


def without_sensors(name, folder):
    """A robot file without the sensors that MuJoCo's robots have not, and without looks, whose meshes lie beside the shipped one."""
    shipped = os.path.join(os.path.dirname(__file__), "..", "assets", "robots", name, "robot.toml")
    with open(shipped) as file:
        tables = re.split(r"(?m)^(?=\[)", file.read())
    path = os.path.join(folder, name, "robot.toml")
    os.makedirs(os.path.dirname(path))
    with open(path, "w") as file:
        file.write("".join(table for table in tables if not table.startswith(("[[sensor]]", "[[visual]]"))))
    return path


def usarsim_row(drive_model, dt, seconds, robot="KUKA_YouBot", motions=("forward", "right", "clockwise"), floor="rough"):
    command = [USARSIM, "bench", "--robot", robot, "--drive-model", drive_model, "--dt", str(dt), "--seconds", str(seconds), "--map", floor, "--json"]
    report = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    ratios = {name: report["motions"][name]["ratio"] for name in motions}
    return {"factor": report["real_time_factor"], "error": report["worst_error_percent"], "ratios": ratios}


def check(made, shown):
    """Ends the program if two lists of rows differ in more than the times, the third cell of a row."""
    untimed = [[row.split("|")[:3] + row.split("|")[4:] for row in rows] for rows in (made, shown)]
    if untimed[0] != untimed[1]:
        raise SystemExit("\n".join(["", "not what usarsim gives (`make figures` renews it):", *shown, "made:", *made]))
    print("\rthe rows of usarsim are those that it gives")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--out", help="write the table as Markdown")
    parser.add_argument("--crowds", action="store_true", help="make the table of crowds and walls alone")
    parser.add_argument("--beside", metavar="PYTHON", help="a Python with another version of MuJoCo, which runs the crowds, too")
    parser.add_argument("--crowd-row", type=json.loads, help=argparse.SUPPRESS)
    parser.add_argument("--check", help="compare with the rows of usarsim in this file, all but times; MuJoCo is not run")
    arguments = parser.parse_args()
    if arguments.crowd_row:
        print(json.dumps(mujoco_crowd_row(*arguments.crowd_row)))
        return
    if arguments.crowds:
        with tempfile.TemporaryDirectory() as folder:
            without_sensors("P3AT", folder)
            print("\r" + "\n".join(crowds(5, arguments.repeat, folder, arguments.beside)))
        return
    definition, seconds = robot(), arguments.seconds
    peers = [(shape, cone, dt) for shape in ("ellipsoid", "chain 5", "chain 9") for cone in ("pyramidal", "elliptic") for dt in (0.002, 0.004, 0.008, 0.012, 0.016, 0.02)]
    runs = {f"MuJoCo {mujoco.__version__}, {shape}, {cone}|{1e3 * dt:g}": (lambda s=shape, c=cone, t=dt: mujoco_row(definition, s, c, t, seconds)) for shape, cone, dt in peers}
    ours = [("bodies", 0.002), ("bodies", 0.004), ("articulated", 0.002), ("articulated", 0.004), ("articulated", 0.008), ("articulated", 0.012), ("articulated", 0.016), ("analytic", 0.002), ("analytic", 0.004), ("analytic", 0.008), ("analytic", 0.012), ("analytic", 0.016), ("analytic", 0.02), ("kinematic", 0.016)]
    runs |= {f"usarsim, {name}|{1e3 * dt:g}": (lambda n=name, t=dt: usarsim_row(n, t, seconds)) for name, dt in ours}
    p3at = robot("P3AT")
    peers = [(shape, gain, rotor, dt) for shape in ("sphere", "cylinder") for gain, rotor in ((50, 0), (5, 0.5)) for dt in (0.002, 0.008)]
    sliding = {
        f"MuJoCo {mujoco.__version__}, {shape}, servo {gain} N m s/rad, rotor {rotor} kg m²|{1e3 * dt:g}": (
            lambda a=(shape, gain, rotor, dt): mujoco_p3at_row(p3at, *a, seconds)
        )
        for shape, gain, rotor, dt in peers
    }
    ours = [("bodies", 0.002), ("articulated", 0.002), ("articulated", 0.008), ("articulated", 0.016), ("articulated", 0.02)]
    sliding |= {f"usarsim, {name}|{1e3 * dt:g}": (lambda n=name, t=dt: usarsim_row(n, t, seconds, "P3AT", ("forward", "clockwise"))) for name, dt in ours}
    folder = tempfile.TemporaryDirectory()
    bare = without_sensors("P3AT", folder.name)
    ours = [("articulated", 0.002), ("articulated", 0.016), ("articulated", 0.02)]
    sliding |= {f"usarsim, {name}, no sensors|{1e3 * dt:g}": (lambda n=name, t=dt: usarsim_row(n, t, seconds, bare, ("forward", "clockwise"))) for name, dt in ours}
    tables = [(runs, "forward | sideways | turning"), (sliding, "forward | on the spot")]
    if arguments.check:
        arguments.repeat = 1
        tables = [({key: run for key, run in runs.items() if key.startswith("usarsim")}, head) for runs, head in tables]
    made = [table(runs, head, arguments.repeat) for runs, head in tables]
    if arguments.check:
        with open(arguments.check) as file:
            shown = [line.rstrip("\n") for line in file if line.startswith("| usarsim")]
        check([line for lines, _ in made for line in lines[2:]], shown)
        return
    text = f"One youBot at 1 rad/s on one core, each row the fastest of {arguments.repeat} turns of 3 x {seconds:g} simulated seconds. Made by `bench/compare.py`; see there what is compared.\n\n"
    text += "\n".join(made[0][0]) + "\n\n" + verdict(made[0][1], 1, 0.3)
    text += f"\n\n## A robot that has to slide\n\nA P3AT forward and on the spot at 1 rad/s, 2 x {seconds:g} seconds, beside the twist at which Coulomb's friction balances (docs/kinematics.md). MuJoCo's contacts do not feel the servo: with the robot's own it turns a sixth as far as it should or less, with a softer one and an invented rotor nearly as far.\n\n"
    text += "\n".join(made[1][0]) + "\n\n" + verdict(made[1][1], 2, 0.3)
    text += " MuJoCo's P3AT has no sensors; usarsim's has a laser of 181 beams and seven others, which are in its time, but where the row says not."
    text += f"\n\n## Trees\n\nThe same trees of links with the same servos, times real time in the motions of `usarsim bench` (3 x {seconds:g} seconds): a youBot with its arm and 24 rollers, and a Kenaf that starts with its front half on a step of 5 cm, whose tracks are rows of wheels in MuJoCo. usarsim's have their sensors, too.\n\n"
    text += "\n".join(trees(seconds, arguments.repeat))
    text += "\n\n## Crowds and walls\n\nP3ATs without sensors on a grid of 0.75 m that all drive to its middle at 5 rad/s, and one that drives into a wall of boxes, ten high, for 5 simulated seconds: microseconds of one core for each robot, or box, and step (`bench/compare.py --crowds`). MuJoCo's P3AT is a box on four cylinders with the softer servo and the rotor of above. In crowds of 20 and more usarsim takes longer than the faster of them: it solves Coulomb's cone to a millimetre a second, with the servos' stiffness in the contacts, where MuJoCo's pyramids or soft cones are convex. MuJoCo 4.0.0 factorises its sparse matrix wrongly (google-deepmind/mujoco#3767); with `--beside` an older one runs beside it. A wall of boxes costs next to nothing while it sleeps.\n\n"
    text += "\n".join(crowds(5, arguments.repeat, folder.name, arguments.beside))
    print("\r" + text)
    if arguments.out:
        with open(arguments.out, "w") as file:
            file.write("# usarsim beside MuJoCo\n\n" + text + "\n")


def table(runs, head, repeat):
    """The fastest row of every run, and the table of them."""
    best = {}
    for turn in range(repeat):
        for key, run in runs.items():
            print(f"\r{turn + 1}/{repeat} {key:70}", end="", flush=True, file=sys.stderr)
            row = run()
            if key not in best or row["factor"] > best[key]["factor"]:
                best[key] = row
    lines = [f"| simulator | step, ms | times real time | worst error, % | {head} |", "|---|---|---|---|" + "---|" * (head.count("|") + 1)]
    for key, row in best.items():
        name, dt = key.split("|")
        ratios = " | ".join(f"{ratio:.4f}" for ratio in row["ratios"].values())
        lines.append(f"| {name} | {dt} | {row['factor']:.0f} | {row['error']:.2f} | {ratios} |")
    return lines, best


def verdict(best, their_error, our_error):
    """How much faster usarsim's models are at an error of at most so many percent."""
    good = [row["factor"] for key, row in best.items() if key.startswith("MuJoCo") and row["error"] <= their_error]
    text = f"MuJoCo's best at an error of at most {their_error} %: {max(good):.0f} times real time." if good else f"MuJoCo is never within {their_error} %."
    for model in ("articulated", "articulated, no sensors", "analytic"):
        ours = [row["factor"] for key, row in best.items() if key.startswith(f"usarsim, {model}|") and row["error"] <= our_error]
        if ours:
            text += f" usarsim's {model} at an error of at most {our_error} %: {max(ours):.0f} times"
            text += f", {max(ours) / max(good):.1f} times as fast." if good else "."
    return text


if __name__ == "__main__":
    main()
