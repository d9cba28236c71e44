#!/usr/bin/env python3
"""Robots of public ROS packages and of Gazebo through `usarsim import`: loads, stands, moves. Makes the table of docs/howto-import.md.

    python3 -m venv venv && . venv/bin/activate && pip install xacro
    cargo build --release --bin usarsim      # or USARSIM names another build of the program
    python3 bench/imports.py FOLDER [--later | --sdf] [--only Husky] [--page docs/howto-import.md]

FOLDER has a checkout of each repository below, by its name without the owner. None of them is part of this project. A robot on wheels is
driven ahead at 2 rad/s and on the spot at 1 rad/s, a car with 0.2 rad of steering, for two seconds on a smooth floor, and compared with wheels
that do not slide. One with arms or legs moves its first joint that can by 0.3 rad.
Units: m, s, rad.
"""

import argparse
import json
import math
import os
import pathlib
import re
import socket
import subprocess
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor

PROGRAM = os.path.abspath(os.environ.get("USARSIM", "target/release/usarsim"))
SIMULATED = {"stand": 3.0, "drive": 2.0}
CREATE = "create3_sim/irobot_create_common/irobot_create_description"

# Class, repository, file, arguments.
ROBOTS = [
    ("Husky", "husky/husky", "husky_description/urdf/husky.urdf.xacro", []),
    ("Jackal", "jackal/jackal", "jackal_description/urdf/jackal.urdf.xacro", []),
    ("Burger", "ROBOTIS-GIT/turtlebot3", "turtlebot3_description/urdf/turtlebot3_burger.urdf", []),
    ("Waffle", "ROBOTIS-GIT/turtlebot3", "turtlebot3_description/urdf/turtlebot3_waffle.urdf", []),
    ("Create3", "iRobotEducation/create3_sim", CREATE.split("/", 1)[1] + "/urdf/create3.urdf.xacro", []),
    ("TurtleBot4", "turtlebot/turtlebot4", "turtlebot4_description/urdf/standard/turtlebot4.urdf.xacro",
     ["--package", f"irobot_create_description={CREATE}"]),
    ("SummitXL", "RobotnikAutomation/summit_xl_common", "summit_xl_description/robots/summit_xl_std.urdf.xacro",
     ["--package", "robotnik_sensors=robotnik_sensors"]),
    ("SummitXLS", "RobotnikAutomation/summit_xl_common", "summit_xl_description/robots/summit_xls_std.urdf.xacro",
     ["--package", "robotnik_sensors=robotnik_sensors"]),
    ("Panther", "husarion/panther_ros", "panther_description/urdf/panther.urdf.xacro", ["components_config_path:=None"]),
    ("PantherMecanum", "husarion/panther_ros", "panther_description/urdf/panther.urdf.xacro",
     ["components_config_path:=None", "use_sim:=true", "wheel_config_file:=panther_ros/panther_description/config/WH02.yaml"]),
    ("Lynx", "husarion/husarion_ugv_ros", "husarion_ugv_description/urdf/lynx.urdf.xacro", ["components_config_path:=None"]),
    ("RosbotXL", "husarion/rosbot_ros", "rosbot_description/urdf/rosbot.urdf.xacro", []),
    ("youBotROS", "youbot/youbot_description", "robots/youbot.urdf.xacro", []),
    ("UR5", "UniversalRobots/Universal_Robots_ROS2_Description", "urdf/ur.urdf.xacro", ["ur_type:=ur5", "name:=ur"]),
    ("Franka", "frankaemika/franka_description", "robots/fr3/fr3.urdf.xacro", []),
    ("Spot", "clearpathrobotics/spot_ros", "spot_description/urdf/spot.urdf.xacro", []),
    ("Pepper", "ros-naoqi/pepper_robot", "pepper_description/urdf/pepper1.0_generated_urdf/pepper.urdf", []),
    ("NaoV5", "ros-naoqi/nao_robot", "nao_description/urdf/naoV50_generated_urdf/nao.urdf", []),
]

# Robots that were chosen afterwards, to see if what was learnt from those above is enough.
LATER = [
    ("Fetch", "fetchrobotics/fetch_ros", "fetch_description/robots/fetch.urdf", []),
    ("Freight", "fetchrobotics/fetch_ros", "fetch_description/robots/freight.urdf", []),
    ("Hunter2", "agilexrobotics/ugv_gazebo_sim", "hunter/hunter2_base/urdf/hunter2_base.urdf", []),
    ("HunterSE", "agilexrobotics/ugv_gazebo_sim", "hunter_se/hunter_se_description/urdf/hunter_se_description.urdf", []),
    ("ScoutMini", "agilexrobotics/ugv_gazebo_sim", "scout/scout_description/urdf/scout_mini.xacro", []),
    ("ScoutV2", "agilexrobotics/ugv_gazebo_sim", "scout/scout_description/urdf/scout_v2.xacro", []),
    ("Bunker", "agilexrobotics/ugv_gazebo_sim", "bunker/bunker_description/urdf/bunker.urdf.xacro", []),
    ("LimoFour", "agilexrobotics/ugv_gazebo_sim", "limo/limo_description/urdf/limo_four_diff.xacro", ["robot_namespace:=limo"]),
    ("LimoAckermann", "agilexrobotics/ugv_gazebo_sim", "limo/limo_description/urdf/limo_ackerman.xacro", ["robot_namespace:=limo"]),
    ("Autokit", "agilexrobotics/ugv_gazebo_sim", "autokit/urdf/autokit.urdf", []),
    ("TracerMini", "agilexrobotics/ugv_gazebo_sim", "tracer_mini/urdf/tracer_mini.urdf", []),
    ("Tracer", "agilexrobotics/ugv_gazebo_sim", "tracer/tracer_description/urdf/tracer_v1.xacro", []),
    ("RangerMini2", "agilexrobotics/ugv_gazebo_sim", "ranger_mini/ranger_mini_v2/urdf/ranger_mini.xacro", []),
    ("RangerMini3", "agilexrobotics/ugv_gazebo_sim", "ranger_mini/ranger_mini_v3/urdf/ranger_mini.xacro", []),
    ("LimoS2", "agilexrobotics/ugv_gazebo_sim", "limo_s2/limo_s2_description/urdf/limo_s2.xacro", ["robot_namespace:=limo"]),
    ("SteerBot", "agilexrobotics/ugv_gazebo_sim", "hunter/steer_drive_controller/test/common/urdf/steerbot.xacro", []),
    ("MP400", "neobotix/neo_simulation2", "robots/mp_400/mp_400.urdf", []),
    ("MP500", "neobotix/neo_simulation2", "robots/mp_500/mp_500.urdf", []),
    ("MPO500", "neobotix/neo_simulation2", "robots/mpo_500/mpo_500.urdf", []),
    ("MPO700", "neobotix/neo_simulation2", "robots/mpo_700/mpo_700.urdf", []),
    ("Lino2WD", "linorobot/linorobot2", "linorobot2_description/urdf/robots/2wd.urdf.xacro", []),
    ("Lino4WD", "linorobot/linorobot2", "linorobot2_description/urdf/robots/4wd.urdf.xacro", []),
    ("LinoMecanum", "linorobot/linorobot2", "linorobot2_description/urdf/robots/mecanum.urdf.xacro", []),
    ("LinoTurtle", "linorobot/linorobot2", "linorobot2_description/urdf/robots/turtlebot.urdf.xacro", []),
    ("Vattenkar", "linorobot/linorobot2", "linorobot2_description/urdf/robots/vattenkar.urdf.xacro", []),
    ("DiffBot", "ros-mobile-robots/diffbot", "diffbot_description/urdf/diffbot.urdf.xacro", []),
    ("Kobuki", "kobuki-base/kobuki_ros", "kobuki_description/urdf/kobuki_standalone.urdf.xacro", []),
    ("Leo", "LeoRover/leo_common-ros2", "leo_description/urdf/leo.urdf.xacro", []),
    ("PMB2", "pal-robotics/pmb2_robot", "pmb2_description/robots/pmb2.urdf.xacro", []),
    ("Tiago", "Gepetto/example-robot-data", "robots/tiago_description/robots/tiago.urdf", []),
    ("TiagoDual", "Gepetto/example-robot-data", "robots/tiago_description/robots/tiago_dual.urdf", []),
    ("TiagoPro", "Gepetto/example-robot-data", "robots/tiago_pro_description/robots/tiago_pro.urdf", []),
    ("PR2", "Gepetto/example-robot-data", "robots/pr2_description/urdf/pr2.urdf", []),
    ("ANYmalB", "Gepetto/example-robot-data", "robots/anymal_b_simple_description/robots/anymal.urdf", []),
    ("ANYmalC", "Gepetto/example-robot-data", "robots/anymal_c_simple_description/urdf/anymal.urdf", []),
    ("HyQ", "Gepetto/example-robot-data", "robots/hyq_description/robots/hyq_no_sensors.urdf", []),
    ("Solo12", "Gepetto/example-robot-data", "robots/solo_description/robots/solo12.urdf", []),
    ("Bolt", "Gepetto/example-robot-data", "robots/bolt_description/robots/bolt.urdf", []),
    ("Talos", "Gepetto/example-robot-data", "robots/talos_data/robots/talos_full_v2.urdf", []),
    ("ICub", "Gepetto/example-robot-data", "robots/icub_description/robots/icub.urdf", []),
    ("Romeo", "Gepetto/example-robot-data", "robots/romeo_description/urdf/romeo.urdf", []),
    ("UR3", "Gepetto/example-robot-data", "robots/ur_description/urdf/ur3_robot.urdf", []),
    ("UR10", "Gepetto/example-robot-data", "robots/ur_description/urdf/ur10_robot.urdf", []),
    ("PandaArm", "Gepetto/example-robot-data", "robots/panda_description/urdf/panda.urdf", []),
    ("Kinova", "Gepetto/example-robot-data", "robots/kinova_description/robots/kinova.urdf", []),
    ("Baxter", "Gepetto/example-robot-data", "robots/baxter_description/urdf/baxter.urdf", []),
    ("Bravo7", "Gepetto/example-robot-data", "robots/bravo7_description/urdf/bravo7_gripper.urdf", []),
    ("Allegro", "Gepetto/example-robot-data", "robots/allegro_hand_description/urdf/allegro_right_hand.urdf", []),
    ("Iris", "Gepetto/example-robot-data", "robots/iris_description/robots/iris.urdf", []),
    ("Hextilt", "Gepetto/example-robot-data", "robots/hextilt_description/urdf/hextilt_flying_arm_5.urdf", []),
    ("BlueVolta", "Gepetto/example-robot-data", "robots/bluevolta_description/urdf/bluevolta.urdf", []),
    ("Stretch", "hello-robot/stretch_ros", "stretch_description/urdf/stretch_description_standard.xacro", []),
    ("StretchDex", "hello-robot/stretch_ros", "stretch_description/urdf/stretch_description_dex.xacro", []),
    ("Racecar", "erwincoumans/pybullet_robots", "data/f10_racecar/racecar_differential.urdf", []),
    ("RacecarF10", "erwincoumans/pybullet_robots", "data/f10_racecar/racecar.urdf", []),
    ("R2D2", "erwincoumans/pybullet_robots", "data/r2d2.urdf", []),
    ("TurtleBot2", "erwincoumans/pybullet_robots", "data/turtlebot.urdf", []),
    ("Cassie", "erwincoumans/pybullet_robots", "data/cassie/urdf/cassie.urdf", []),
    ("Atlas", "erwincoumans/pybullet_robots", "data/atlas/atlas_v4_with_multisense.urdf", []),
    ("Sawyer", "erwincoumans/pybullet_robots", "data/sawyer_robot/sawyer_description/urdf/sawyer.urdf", []),
    ("Dobot", "erwincoumans/pybullet_robots", "data/dobot/dobot.urdf", []),
    ("B2W", "unitreerobotics/unitree_ros", "robots/b2w_description/urdf/b2w_description.urdf", []),
    ("Go2W", "unitreerobotics/unitree_ros", "robots/go2w_description/urdf/go2w_description.urdf", []),
    ("A1", "unitreerobotics/unitree_ros", "robots/a1_description/urdf/a1.urdf", []),
    ("Go1", "unitreerobotics/unitree_ros", "robots/go1_description/urdf/go1.urdf", []),
    ("Go2", "unitreerobotics/unitree_ros", "robots/go2_description/urdf/go2_description.urdf", []),
    ("B2", "unitreerobotics/unitree_ros", "robots/b2_description/urdf/b2_description.urdf", []),
    ("Aliengo", "unitreerobotics/unitree_ros", "robots/aliengo_description/urdf/aliengo.urdf", []),
    ("Laikago", "unitreerobotics/unitree_ros", "robots/laikago_description/urdf/laikago.urdf", []),
    ("G1", "unitreerobotics/unitree_ros", "robots/g1_description/g1_29dof.urdf", []),
    ("H1", "unitreerobotics/unitree_ros", "robots/h1_description/urdf/h1.urdf", []),
    ("R1", "unitreerobotics/unitree_ros", "robots/r1_description/R1.urdf", []),
    ("Z1", "unitreerobotics/unitree_ros", "robots/z1_description/xacro/z1.urdf", []),
    ("XArm7", "xArm-Developer/xarm_ros2", "xarm_description/urdf/xarm_device.urdf.xacro", ["dof:=7"]),
    ("Lite6", "xArm-Developer/xarm_ros2", "xarm_description/urdf/xarm_device.urdf.xacro", ["dof:=6", "robot_type:=lite"]),
]

# Robots that are SDF, of worlds and of models.
WORLDS = "examples/worlds"
SDF = [
    ("VehicleBlue", "gazebosim/gz-sim", f"{WORLDS}/diff_drive.sdf", ["--model", "vehicle_blue"]),
    ("SkidSteer", "gazebosim/gz-sim", f"{WORLDS}/diff_drive_skid.sdf", []),
    ("GzAckermann", "gazebosim/gz-sim", f"{WORLDS}/ackermann_steering.sdf", []),
    ("GzMecanum", "gazebosim/gz-sim", f"{WORLDS}/mecanum_drive.sdf", []),
    ("TrisphereGz", "gazebosim/gz-sim", f"{WORLDS}/trisphere_cycle_wheel_slip.sdf", ["--model", "trisphere_cycle0"]),
    ("Tunnel", "gazebosim/gz-sim", f"{WORLDS}/tunnel.sdf", []),
    ("VehicleLidar", "gazebosim/gz-sim", f"{WORLDS}/visualize_lidar.sdf", []),
    ("ArmTrajectory", "gazebosim/gz-sim", f"{WORLDS}/joint_trajectory_controller.sdf", ["--model", "RR_position_control"]),
    ("CartFront", "osrf/gazebo_models", "cart_front_steer/model.sdf", []),
    ("CartRigid", "osrf/gazebo_models", "cart_rigid_suspension/model.sdf", []),
    ("CartSoft", "osrf/gazebo_models", "cart_soft_suspension/model.sdf", []),
    ("Create", "osrf/gazebo_models", "create/model.sdf", []),
    ("Follower", "osrf/gazebo_models", "follower_vehicle/model.sdf", []),
    ("GzHusky", "osrf/gazebo_models", "husky/model.sdf", []),
    ("Pioneer2DX", "osrf/gazebo_models", "pioneer2dx/model.sdf", []),
    ("Pioneer3AT", "osrf/gazebo_models", "pioneer3at/model.sdf", []),
    ("Polaris", "osrf/gazebo_models", "polaris_ranger_ev/model.sdf", []),
    ("Prius", "osrf/gazebo_models", "prius_hybrid/model.sdf", []),
    ("GzPR2", "osrf/gazebo_models", "pr2/model.sdf", []),
    ("GzTurtlebot", "osrf/gazebo_models", "turtlebot/model.sdf", []),
    ("UtilityCart", "osrf/gazebo_models", "utility_cart/model.sdf", []),
    ("SimpleArm", "osrf/gazebo_models", "simple_arm/model.sdf", []),
]


class Client:
    """A server with one class, and a connection to it."""

    def __init__(self, robot):
        command = [PROGRAM, "serve", "--map", "smooth", "--robot", str(robot), "--port", "0", "--json", "--quiet", "--rtf", "10"]
        self.server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        ready = json.loads(self.server.stdout.readline())
        self.socket = socket.create_connection(("127.0.0.1", ready["port"]))
        self.lines = self.socket.makefile("r")
        self.time, self.position, self.angles, self.joints = 0.0, None, None, {}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()
        self.server.terminate()
        self.server.wait()

    def send(self, line):
        self.socket.sendall(f"{line}\r\n".encode())

    def wait(self, seconds):
        """Reads until so much simulated time has passed since the last reading."""
        end = self.time + seconds
        while self.time < end:
            line = self.lines.readline()
            if line.startswith("SEN") and "GroundTruth" in line:
                self.time = numbers(line, "Time")[0]
                self.position, self.angles = numbers(line, "Location"), numbers(line, "Orientation")
            elif line.startswith("ASTA"):
                name = re.search(r"{Name (\S+)}", line).group(1)
                self.joints[name] = [float(value) for value in re.findall(r"{Value ([-\d.]+)}", line)]
            elif not line:
                raise RuntimeError("the server is gone")


def numbers(line, key):
    return [float(number) for number in re.search(rf"{{{key} ([^}}]+)}}", line).group(1).split(",")]


def stands(client):
    client.wait(SIMULATED["stand"])
    before = client.position
    client.wait(0.5)
    drift = math.dist(before, client.position) / 0.5
    tilt = math.degrees(max(abs(angle) for angle in client.angles[:2]))
    return f"yes, {tilt:.1f} degrees" if tilt < 5 and drift < 1e-3 else f"no: {tilt:.1f} degrees, {1000 * drift:.0f} mm/s"


def drives(client, wheels, steering):
    """Compares a steady motion with that of wheels that do not slide."""
    driven = [wheel for wheel in wheels if wheel["driven"]]
    radius = sum(wheel["radius"] for wheel in driven) / len(driven)
    # Mecanum wheels turn a base by the sum of track and wheelbase.
    axes = 2 if steering == "omni" else 1
    span = 2 * sum(abs(wheel["position"][1 - axis]) for wheel in driven for axis in range(axes)) / len(driven)
    is_car = steering == "ackermann"
    steer = 0.2
    straight, stop, turn = ("DRIVE {Left 2} {Right 2}", "DRIVE {Left 0} {Right 0}", "DRIVE {Left 1} {Right -1}")
    if is_car:
        straight, stop, turn = (f"DRIVE {{Speed {v}}} {{FrontSteer {f}}} {{RearSteer 0}}" for v, f in ((2, 0), (0, 0), (2, steer)))
    ends = []
    for line in (straight, stop, turn):
        client.send(line)
        client.wait(1.0)
        before = (client.time, client.position, client.angles[2])
        client.wait(SIMULATED["drive"])
        ends.append((before, (client.time, client.position, client.angles[2])))
    (start, a, _), (end, b, _) = ends[0]
    ahead = math.dist(a, b) / (end - start) / (2 * radius)
    (start, _, a), (end, _, b) = ends[2]
    turned = (b - a) % (2 * math.pi) / (end - start)
    if is_car:
        # The arc between two places is longer than its chord.
        chord, angle = math.dist(ends[2][0][1], ends[2][1][1]), turned * (end - start)
        ideal = max(x["position"][0] for x in wheels) - min(x["position"][0] for x in wheels)
        circle = chord / (2 * math.sin(angle / 2)) / (ideal / math.tan(steer)) if angle > 0.01 else math.inf
        return f"ahead {100 * ahead:.0f} %, circle {100 * circle:.0f} %"
    turned /= 2 * radius / span
    return f"ahead {100 * ahead:.0f} %, turns {100 * turned:.0f} %"


def moves_joint(client, actuators):
    """Moves joints in turn until one goes where it is told."""
    best = "no joint"
    for actuator in actuators:
        for link, value in enumerate(client.joints.get(actuator["name"], [])):
            for step in (0.3, -0.3):
                client.send(f"ACT {{Name {actuator['name']}}} {{Link {link}}} {{Value {value + step}}}")
                client.wait(2.0)
                moved = client.joints[actuator["name"]][link] - value
                best = f"joint {actuator['joints'][link]}: {moved:.2f} rad"
                if abs(moved - step) < 0.02:
                    return best
    return best


def notes(imported):
    """What was guessed or is missing, in few words."""
    guessed, replaced, left_out = (imported[key] for key in ("guessed", "replaced", "left_out"))
    parts = []
    casters = sum(" is a caster" in it for it in guessed)
    count = lambda number, thing: f"{number} {thing}{'' if number == 1 else 's'}"
    if casters:
        parts.append(f"{count(casters, 'caster')} by name or place")
    for words, short in [
        ("rollers are guessed", "Mecanum wheels and their rollers"),
        ("called casters are driven", "wheels that it calls casters are driven"),
        ("stands on", "legs"),
        ("fixed to the ground", "fixed to the ground"),
    ]:
        if any(words in it for it in guessed):
            parts.append(short)
    if replaced:
        parts.append(f"{len(replaced)} masses or inertias replaced" if len(replaced) > 1 else "1 mass or inertia replaced")
    meshes = 0
    for it in left_out:
        if it.startswith("mesh"):
            more = re.search(r"` and (\d+) more: ", it)
            meshes += len(re.findall(r"`[^`]+`(?=[,:]| and \d)", it.split("package `")[0])) + (int(more.group(1)) if more else 0)
        elif it.startswith("package"):
            parts.append(f"package {it.split('`')[1]} missing")
        elif "a second" in it:
            parts.append(it.split(",")[0].replace("<", "`<").replace(">", ">`"))
        elif "no colliding shape" in it:
            parts.append("touches nothing")
    if meshes:
        parts.append(f"{meshes} meshes missing" if meshes > 1 else "1 mesh missing")
    return "; ".join(parts) or "nothing"


def row(folder, work, name, repository, file, arguments):
    checkout = repository.split("/")[1]
    local = [re.sub(r"(:?=)([\w.]+/\S+|robotnik_sensors)$", rf"\1{folder}/\2", it) for it in arguments]
    command = [PROGRAM, "import", str(folder / checkout / file), "--class", name, "--json", *local]
    done = subprocess.run(command, cwd=work, capture_output=True, text=True)
    cells = [name, f"[{repository}](https://github.com/{repository})"]
    if done.returncode:
        return cells + ["no", "", "", done.stderr.strip().splitlines()[0]]
    imported = json.loads(done.stdout)
    subprocess.run([PROGRAM, "check", str(work / name)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(work / name / "robot.toml", "rb") as toml:
        actuators = tomllib.load(toml).get("actuator", [])
    steering, mass = imported["steering"], imported["mass"]
    fixed = steering == "none"
    with Client(work / name / "robot.toml") as client:
        client.send(f"INIT {{ClassName USARBot.{name}}} {{Location 0,0,{-1 if fixed else -0.3}}}")
        stood = stands(client)
        has_wheels = any(wheel["driven"] for wheel in imported["wheels"])
        moved = drives(client, imported["wheels"], steering) if has_wheels else moves_joint(client, actuators)
    return cells + [f"{steering}, {mass:.1f} kg", "fixed" if fixed else stood, moved, notes(imported)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--only", help="a class")
    parser.add_argument("--later", action="store_true", help="the robots that were chosen afterwards")
    parser.add_argument("--sdf", action="store_true", help="the robots that are SDF")
    parser.add_argument("--page", type=pathlib.Path, help="page whose table is renewed")
    arguments = parser.parse_args()
    rows = [["robot", "source", "loads", "stands", "moves", "guessed or missing"], ["---"] * 6]
    robots = [robot for robot in (SDF if arguments.sdf else LATER if arguments.later else ROBOTS) if arguments.only in (None, robot[0])]
    with tempfile.TemporaryDirectory() as work, ThreadPoolExecutor(os.cpu_count()) as threads:
        for cells in threads.map(lambda robot: row(arguments.folder.resolve(), pathlib.Path(work), *robot), robots):
            rows.append(cells)
            print(" | ".join(cells), flush=True)
    table = "\n".join(f"| {' | '.join(cells)} |" for cells in rows)
    if arguments.page:
        text = arguments.page.read_text()
        begin, end = f"<!-- table of bench/imports.py{' --sdf' if arguments.sdf else ' --later' if arguments.later else ''} -->\n", "<!-- end -->"
        before, rest = text.split(begin)
        arguments.page.write_text(f"{before}{begin}\n{table}\n\n{end}{rest.split(end, 1)[1]}")


if __name__ == "__main__":
    main()
