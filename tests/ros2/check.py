"""Stock nodes of two distributions and a participant of CycloneDDS against the server. Usage: check.py [NAME ..]"""

import contextlib
import json
import os
import pathlib
import random
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import traceback

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parent.parent
DISTRIBUTIONS = ["jazzy", "kilted"]
SERVERS, PEERS = [], []
# What one distribution sets for itself keeps the Python of another from starting.
ENVIRONMENT = {key: value for key, value in os.environ.items() if key not in ("LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE")}
# The server speaks UDP. Shared memory between two nodes has locks, at which a node waits for ever when another one was killed.
ENVIRONMENT["FASTDDS_BUILTIN_TRANSPORTS"] = "UDPv4"


@contextlib.contextmanager
def served(*arguments, ros2=True, page=False, log=None, stderr=None):
    """A server on a free port; yields its port, or with a page all of them."""
    command = [os.environ["USARSIM"], "serve", "--port", "0", "--json", *map(str, arguments)]
    command += [] if page else ["--no-http"]
    command += ["--ros2"] if ros2 else []
    command += ["--log", log] if log else []
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=stderr, text=True)
    SERVERS.append(server.pid)
    try:
        ports = json.loads(server.stdout.readline())
        yield ports if page else ports["port"]
        assert server.poll() is None, "the server has ended"
        server.send_signal(signal.SIGTERM)
        assert server.wait(10) == 0
    finally:
        server.kill()


class Wire:
    """A client of USARSim: it has a robot, and reads what it gets. `time` is the simulated time."""

    def __init__(self, port, line):
        self.time, self.server = 0.0, SERVERS[-1:]
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.send(line)
        threading.Thread(target=self.read, daemon=True).start()

    def send(self, line):
        self.socket.sendall(f"{line}\r\n".encode())

    def read(self):
        with contextlib.suppress(OSError):
            while got := self.socket.recv(65536):
                times = re.findall(rb"{Time ([0-9.]+)}", got)
                self.time = float(times[-1]) if times else self.time

    def pace(self, work):
        """Does some work. Returns what it returns, and the simulated seconds a second meanwhile."""
        at, began = self.time, time.time()
        done = work()
        return done, (self.time - at) / (time.time() - began)

    def close(self):
        self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()


def peer(distribution, *arguments):
    script = "cyclone.py" if distribution == "cyclone" else "node.py"
    python = ROOT / "target/ros2" / distribution / "bin/python"
    PEERS.append(subprocess.Popen([python, HERE / script, *map(str, arguments)], stdout=subprocess.PIPE, text=True, env=ENVIRONMENT))
    return PEERS[-1]


def result(process, timeout=340):
    output, _ = process.communicate(timeout=timeout)
    assert process.returncode == 0, process.args
    return json.loads(output.splitlines()[-1])


def ask(distribution, *arguments):
    return result(peer(distribution, *arguments))


def check_steps(seen, topic, step, least):
    """No message of a topic is missing: all stamps are as far apart as they should be."""
    of = seen[topic]
    assert of["count"] >= least, (topic, of)
    assert set(of["steps"]) == {str(step)}, (topic, of)


def keep_pace(robot, work):
    """The world keeps its pace during some work, but for what other programs take from the machine: they do so before and after it, too.
    Returns what the work returns, and the pace."""
    rest = lambda: time.sleep(3)  # noqa: E731
    (_, before), (done, pace), (_, after) = [robot.pace(it) for it in [rest, work, rest]]
    assert pace > 0.8 * min(before, after), (before, pace, after)
    return done, pace


MAPPER = """
like = "P3AT"
description = "A P3AT that measures clouds of points and its place"
[[sensor]]
class = "RangeScanner3D"
name = "Rows"
position = [0.1, 0.0, -0.3]
[[sensor]]
class = "GPSSensor"
name = "GPS"
[[sensor]]
class = "IMU"
name = "IMU"
[[sensor]]
class = "Sonar"
name = "F1"
[[sensor]]
class = "Sonar"
name = "F2"
"""


def topics():
    """Every topic at its rate, without a loss, to both distributions and CycloneDDS at once; late subscribers get what does not change."""
    seconds = float(os.environ.get("SECONDS_OF_TOPICS", 6))
    with tempfile.TemporaryDirectory() as folder:
        mapper = pathlib.Path(folder) / "Mapper"
        mapper.mkdir()
        (mapper / "robot.toml").write_text(MAPPER)
        return topics_of(mapper, seconds)


def topics_of(mapper, seconds):
    with served("--map", "arena", "--robot", mapper) as port:
        classes = ["P3AT", "KUKA_YouBot", "Mapper"]
        robots = [Wire(port, f"INIT {{ClassName USARBot.{kind}}} {{Name R{number}}} {{Location {number - 3},0,0}}") for number, kind in enumerate(classes, 1)]
        wanted = [f"/R1/{topic}" for topic in ["odom", "ground_truth", "joint_states", "scan", "imu", "image_raw/compressed", "camera_info", "battery_state", "robot_description"]]
        wanted += ["/R2/odom", "/R2/scan", "/R2/joint_states", "/R3/points", "/R3/fix", "/R3/imu", "/R3/F1/range", "/R3/F2/range"]
        peers = [peer(distribution, "listen", seconds, *wanted) for distribution in DISTRIBUTIONS]
        transforms = peer("cyclone", "transforms", seconds, "R1/lms200")
        for seen in map(result, peers):
            for topic in ["/R1/odom", "/R1/ground_truth", "/R1/joint_states", "/R2/odom", "/R2/joint_states"]:
                check_steps(seen, topic, 0.02, 50 * seconds)
            check_steps(seen, "/clock", 0.01, 100 * seconds)
            for topic in ["/R1/scan", "/R1/imu"]:
                check_steps(seen, topic, 0.2, 5 * (seconds - 1))
            # A picture is left out where the machine does not draw it in time.
            for topic in ["/R1/image_raw/compressed", "/R1/camera_info"]:
                of = seen[topic]
                assert of["count"] >= 5 * (seconds - 1) and set(of["steps"]) <= {f"{number / 10}" for number in range(1, 6)}, (topic, of)
            for topic in ["/R3/points", "/R3/fix", "/R3/F1/range", "/R3/F2/range"]:
                check_steps(seen, topic, 0.2, 5 * (seconds - 1))
            assert seen["/R3/points"]["whole"], seen["/R3/points"]
            assert seen["/R1/image_raw/compressed"]["size"] == [640, 480], seen["/R1/image_raw/compressed"]
            assert seen["/R1/scan"]["beams"] == 181
            assert seen["/R1/robot_description"]["text"].startswith("<?xml"), seen["/R1/robot_description"]
            assert "usarsim" in seen["nodes"], seen["nodes"]
            assert seen["topics"]["/R1/cmd_vel"] == ["geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"], seen["topics"]
            assert seen["/diagnostics"]["values"]["messages left out"] == "0", seen["/diagnostics"]
        hung = result(transforms)
        assert set(hung["steps"]) == {"0.02"} and hung["count"] > 50 * (seconds - 2), hung
        assert hung["chain"] == ["R1/lms200", "R1/base_link", "R1/odom"], hung
        del robots
    pictures = seen["/R1/image_raw/compressed"]["count"]
    return f"{len(wanted) + 2} topics, {pictures} pictures in {seconds:.0f} s"


def orders():
    """Robots go what is asked, within 1 %, whoever owns them, and stop when nothing is asked; the log replays."""
    asked = [
        ("R1", "P3AT", [0.3, 0.0, 0.0], "Twist"),
        ("R1", "P3AT", [0.0, 0.0, 0.5], "TwistStamped"),
        ("R2", "KUKA_YouBot", [0.0, 0.2, 0.0], "Twist"),
        ("R2", "KUKA_YouBot", [0.2, 0.0, 0.0], "TwistStamped"),
    ]
    with tempfile.TemporaryDirectory() as folder:
        log = f"{folder}/run.mcap"
        with served("--map", "rough", log=log) as port:
            robots = [Wire(port, "INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}"), Wire(port, "INIT {ClassName USARBot.KUKA_YouBot} {Name R2} {Location 0,4,0}")]
            for index, (space, _, velocity, kind) in enumerate(asked):
                got = ask(DISTRIBUTIONS[index % 2], "drive", f"/{space}", *velocity, kind)
                for name in ["truth", "odom"]:
                    for part, number in zip(got[name], velocity):
                        # A skid robot whose weight is off its middle slips sideways when it turns.
                        slack = 0.02 if space == "R1" and velocity[2] != 0 and number == 0 else 0.01 * max(map(abs, velocity))
                        assert abs(part - number) <= slack, (space, velocity, name, got)
                assert all(abs(part) < 0.01 for part in got["after"]), (space, velocity, got)
            del robots
        replayed = subprocess.run([os.environ["USARSIM"], "log", "replay", log], capture_output=True, text=True)
        assert replayed.returncode == 0 and "same bits" in replayed.stdout, replayed
    return f"{len(asked)} velocities"


def joints():
    """An arm follows a trajectory."""
    with served("--map", "rough") as port:
        robot = Wire(port, "INIT {ClassName USARBot.Kenaf} {Name K} {Location 0,0,0}")
        got = ask("jazzy", "joints", "/K", "FLFlipper", "-0.8")
        assert -0.6 < got["half"] < -0.2, got
        del robot
    return f"half way at {got['half']:.2f} rad"


def gripper():
    """A gripper closes and opens."""
    with served("--map", "rough") as port:
        robot = Wire(port, "INIT {ClassName USARBot.YouBotArm} {Name Y} {Location 0,0,0}")
        got = ask("kilted", "grip", "/Y")
        assert all(a * b < 0 for a, b in zip(got["True"], got["False"])), got
        del robot
    return "closes and opens"


CONTROLLER = """
base_controller:
  ros__parameters:
    type: diff_drive_controller/DiffDriveController
    wheel_separation: 0.36
    wheel_radius: 0.098
    wheel_separation_multiplier: {multiplier}
    odom_frame_id: wheels
    base_frame_id: base_footprint
    linear.x.max_velocity: 0.25
    linear.x.max_acceleration: 0.5
"""


def controller():
    """With its maker's numbers a robot is driven as its controller drives it: the turn is right only if they are."""
    got = {}
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "control.yaml"
        for multiplier in [1.0, 1.5]:
            file.write_text(CONTROLLER.format(multiplier=multiplier))
            with served("--map", "rough", "--ros2-controller", f"P3AT={file}") as port:
                robot = Wire(port, "INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}")
                turn = ask("jazzy", "drive", "/R1", 0, 0, 0.5)
                got[multiplier] = turn["truth"][2]
                assert abs(turn["odom"][2] - 0.5) < 0.005, turn
                ahead = ask("kilted", "drive", "/R1", 1.0, 0, 0)
                assert abs(ahead["truth"][0] - 0.25) < 0.005, ahead
                seen = ask("kilted", "listen", 1, "/R1/base_controller/odom")
                assert "/R1/base_controller/cmd_vel" in seen["topics"], seen["topics"]
                del robot
        file.write_text("base_controller: {ros__parameters: {type: diff_drive_controller/D, wheel_radius: big}}")
        command = [os.environ["USARSIM"], "serve", "--port", "0", "--no-http", "--ros2", "--ros2-controller", f"P3AT={file}"]
        refused = subprocess.run(command, capture_output=True, text=True, timeout=20)
        assert refused.returncode == 78 and "expected a number" in refused.stderr, refused
    # The wheels of a P3AT slide: 1.5 is its calibration, give or take, and without one it turns two thirds.
    assert abs(got[1.5] - 0.5) < 0.02 and abs(got[1.0] - 0.33) < 0.02, got
    return f"asked 0.5 rad/s, {got[1.0]:.3f} without a multiplier, {got[1.5]:.3f} with 1.5"


def services():
    """std_srvs stop, step and reset the world."""
    with served("--map", "rough") as port:
        robot = Wire(port, "INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}")
        for distribution in DISTRIBUTIONS:
            got = ask(distribution, "services")
            assert got["paused"] == 0 and got["stepped"] >= 1 and got["reset"] < 2.0, got
        del robot
    return "pause, step, resume, reset"


def standard():
    """simulation_interfaces spawns, moves and deletes robots, steps, and changes the world."""
    with served("--map", "rough"):
        got = ask("cyclone", "standard")
    return f"{got['features']} features, {got['spawnables']} classes"


def comings_and_goings():
    """A node that is killed holds up nobody, and a robot that leaves takes its topics along; with ten robots each has its own."""
    with served("--map", "rough") as port:
        robots = [Wire(port, f"INIT {{ClassName USARBot.P3AT}} {{Name R{number}}} {{Location {2 * number},0,0}}") for number in range(10)]
        wanted = [f"/R{number}/odom" for number in range(10)]
        killed = peer("jazzy", "listen", 60, *wanted)
        time.sleep(3)
        watching = peer("kilted", "listen", 8, *wanted)
        time.sleep(3)
        killed.kill()
        killed.wait()
        seen = result(watching)
        for topic in wanted:
            check_steps(seen, topic, 0.02, 350)
        robots.pop().close()
        time.sleep(1)
        # A node that comes now does not see it at the server's node, nor does CycloneDDS in its graph. (Fast DDS ignores a disposal
        # without its key's hash, which RustDDS does not send, and keeps the names of its topics.)
        later = ask("kilted", "listen", 1, "/R0/odom")
        assert "/R9/odom" not in later["published"] and "/R8/odom" in later["published"], later["published"]
        names = ask("cyclone", "graph", 1)
        assert "rt/R9/odom" not in names and "rt/R8/odom" in names, names
        del robots
    return "10 robots"


def closed():
    """Without --ros2 there is no socket of it; with tokens it has to be allowed; a variable of ROS can close it."""
    count = lambda: sum(len(pathlib.Path(f"/proc/net/{name}").read_text().splitlines()) - 1 for name in ["udp", "udp6"])  # noqa: E731
    with served("--map", "rough", ros2=False):
        assert count() == 0, count()
    with served("--map", "rough"):
        assert count() > 0
    with tempfile.TemporaryDirectory() as folder:
        tokens = pathlib.Path(folder) / "tokens.toml"
        tokens.write_text('[[token]]\ntoken = "0123456789abcdef0123456789abcdef"\nroles = ["driver"]\n')
        command = [os.environ["USARSIM"], "serve", "--port", "0", "--no-http", "--ros2", "--token-file", str(tokens)]
        refused = subprocess.run(command, capture_output=True, text=True, timeout=20)
        assert refused.returncode == 2 and "--ros2-unguarded" in refused.stderr, refused
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "OFF"
    with served("--map", "rough"):
        assert count() == 0, count()
    del os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"]
    return "no socket"


def forged(is_enough):
    """Sends packets that nodes did not send: garbage, genuine ones with changed bytes, and HEARTBEATs of a known writer that promise a
    million million messages. Each makes a participant of RustDDS take all memory that it can have. It ends when they are enough, after 8 s
    at the earliest and a minute at the latest."""
    ear = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))
    ear.bind(("lo", 0))
    ear.settimeout(0.2)
    mouth = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    heard, prefixes, sent, began = [], set(), 0, time.time()
    while time.time() < began + 8 or not is_enough() and time.time() < began + 60:
        with contextlib.suppress(TimeoutError):
            packet = ear.recv(65536)[42:]
            if packet[:4] == b"RTPS" and len(heard) < 500:
                heard.append(packet)
                prefixes.add(packet[:20])
        for packet in random.sample(heard, min(len(heard), 20)):
            changed = bytearray(packet)
            for _ in range(4):
                changed[random.randrange(20, len(changed))] = random.randrange(256)
            garbage = random.randbytes(random.randrange(1, 1400))
            beats = [prefix + struct.pack("<BBHIIiIiIi", 7, 1, 28, 0, 0xC2030000, 0, 1, 256, 0, 1 << 20) for prefix in prefixes]
            for port in range(7410, 7420):
                for bytes_ in [bytes(changed), garbage, *beats]:
                    with contextlib.suppress(OSError):
                        mouth.sendto(bytes_, ("127.0.0.1", port))
                        sent += 1
    return sent


def flood():
    """Forged packets do not reach the world: it keeps its pace and its memory, and the node is there again after them."""
    with tempfile.NamedTemporaryFile("w") as said, served("--map", "rough", stderr=said) as port:
        is_enough = lambda: "it is started again" in pathlib.Path(said.name).read_text()  # noqa: E731
        robot = Wire(port, "INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}")
        victim = peer("kilted", "listen", 30, "/R1/odom")
        sent, pace = keep_pace(robot, lambda: forged(is_enough))
        victim.kill()
        assert is_enough(), "the packets did no harm: this test shows nothing"
        seen = ask("jazzy", "listen", 2, "/R1/odom")
        check_steps(seen, "/R1/odom", 0.02, 90)
        memory = max(int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1]) * 4096 for pid in robot.server)
        assert memory < 300e6, memory
        del robot
    return f"{sent} packets, pace {pace:.3f}, {memory / 1e6:.0f} MB"


def flood_of_orders():
    """Nodes that publish velocities and call services as fast as they can do not slow the world down, and a bystander hears all."""
    with served("--map", "rough") as port:
        robots = [Wire(port, f"INIT {{ClassName USARBot.P3AT}} {{Name R{number}}} {{Location {2 * number},0,0}}") for number in range(2)]

        def flooded():
            flooding = [peer(distribution, "flood", "/R0", 6) for distribution in DISTRIBUTIONS]
            watching = peer("cyclone", "transforms", 6, "R1/lms200")
            return [result(process) for process in flooding], watching

        (sent, watching), pace = keep_pace(robots[1], flooded)
        hung = result(watching)
        assert min(of["sent"] for of in sent) > 1000 and min(of["asked"] for of in sent) > 1000, sent
        assert set(hung["steps"]) <= {"0.02", "0.04"}, hung
        memory = max(int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1]) * 4096 for pid in robots[1].server)
        assert memory < 300e6, memory
        del robots
    total = {key: sum(of[key] for of in sent) for key in ["sent", "asked"]}
    return f"{total['sent']} velocities, {total['asked']} calls, pace {pace:.3f}, {memory / 1e6:.0f} MB"


def rosbridge():
    """A stock client of rosbridge sees a robot, drives it and pauses the world."""
    with served("--map", "rough", "--rosbridge", "--http", "0", page=True, ros2=False) as ports:
        robot = Wire(ports["port"], "INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}")
        python = ROOT / "target/ros2/rosbridge/bin/python"
        client = subprocess.Popen([python, HERE / "roslib.py", str(ports["http"])], stdout=subprocess.PIPE, text=True, env=ENVIRONMENT)
        got = result(client)
        assert got["topics"]["/R1/odom"] == "nav_msgs/msg/Odometry" and got["paused"]["success"], got
        assert abs(got["speed"] - 0.5) < 0.01, got
        del robot
    return f"{len(got['topics'])} topics, {len(got['services'])} services"


def wall_follower():
    """A few lines of rclpy drive round the arena, through its corridor."""
    with served("--map", "arena", "--rtf", "2") as port:
        robot = Wire(port, "INIT {ClassName USARBot.P3AT} {Name R1} {Start RobotStart1}")
        got = ask("kilted", "follow", "/R1")
        assert got["round"], got
        del robot
    return f"once round in {got['took']:.0f} s"


CHECKS = [topics, orders, joints, gripper, controller, services, standard, comings_and_goings, closed, flood, flood_of_orders, rosbridge, wall_follower]


def main():
    names = sys.argv[1:]
    failed = []
    for check in CHECKS:
        if not names or check.__name__ in names:
            start = time.time()
            # After a failure it goes on, so that one run shows all failures.
            try:
                said = check()
            except Exception:
                traceback.print_exc()
                failed.append(check.__name__)
                said = "FAILED"
            print(f"{check.__name__}: {said} ({time.time() - start:.0f} s)", flush=True)
            for process in PEERS:
                process.kill()
            PEERS.clear()
    sys.exit(f"failed: {', '.join(failed)}" if failed else 0)


if __name__ == "__main__":
    main()
