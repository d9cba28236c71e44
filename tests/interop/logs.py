"""Logs of a live run, read by readers not written here: mcap with its protobuf and ROS 2 decoders, and rosbags.

Usage: logs.py PATH_OF_USARSIM
"""

import collections
import csv
import json
import math
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile

import pyarrow.parquet
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory as Protobuf
from mcap_ros2.decoder import DecoderFactory as Ros2
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

NATIVE = {
    "usarsim.WireLine",
    "usarsim.RobotLeft",
    "usarsim.RobotState",
    "usarsim.ObjectState",
    "usarsim.SensorReading",
    "foxglove.FrameTransforms",
    "foxglove.JointStates",
    "foxglove.LaserScan",
    "foxglove.Log",
    "foxglove.PoseInFrame",
    "foxglove.SceneUpdate",
}
ROS2 = {
    "nav_msgs/msg/Odometry",
    "rosgraph_msgs/msg/Clock",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/NavSatFix",
    "sensor_msgs/msg/Range",
    "std_msgs/msg/String",
    "tf2_msgs/msg/TFMessage",
}

MAP = """
description = "A floor, a wall, and a light box in the way of the youBot"
[[half_space]]
name = "floor"
material = "carpet"
[[box]]
name = "wall"
material = "plywood"
position = [6.0, 0.0, -0.5]
size = [0.1, 10.0, 1.0]
[[box]]
name = "parcel"
material = "plywood"
position = [4.0, 1.35, -0.1]
size = [0.2, 0.2, 0.2]
mass = 0.5
[[start]]
name = "RobotStart1"
position = [0.0, 0.0, 0.0]
rotation = [0.0, 0.0, 0.0]
"""


class Client:
    """A controller that drives until its status says that enough simulated time has passed."""

    def __init__(self, port, init):
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.lines = self.socket.makefile("r", newline="\r\n")
        self.send(init)
        self.wait(0)

    def send(self, line):
        self.socket.sendall(line.encode() + b"\r\n")

    def wait(self, seconds):
        for line in self.lines:
            if line.startswith("SEN {Time ") and float(line.split("{Time ")[1].split("}")[0]) > seconds:
                return
        raise SystemExit("the server closed the connection")


def record(usarsim, log):
    """Robots drive for three seconds, and one hovers; one leaves, the others stay; a line is wrong."""
    maps = pathlib.Path(log).parent / "map.toml"
    maps.write_text(MAP)
    command = [usarsim, "serve", "--map", str(maps), "--port", "0", "--json", "--log", log, "--log-format", "ros2"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    port = json.loads(server.stdout.readline())["port"]
    mecanum = Client(port, "INIT {ClassName USARBot.KUKA_YouBot} {Name Kuka} {Location 4,1,0}")
    skid = Client(port, "INIT {ClassName USARBot.P2DX} {Name Pioneer} {Location 0,0,0}")
    laser = Client(port, "INIT {ClassName USARBot.P3AT} {Location 0,2,0}")
    flier = Client(port, "INIT {ClassName USARBot.AirRobot} {Location 0,-4,-1}")
    mecanum.send("DRIVE {Front-Left 2}{Front-Right -2}{Back-Left -2}{Back-Right 2}")
    laser.send("DRIVE {Left 2} {Right 1}")
    skid.send("DRIVE {Left what}")
    mecanum.wait(3)
    laser.socket.shutdown(socket.SHUT_RDWR)
    skid.wait(4)
    flier.wait(4)
    server.send_signal(signal.SIGTERM)
    assert server.wait() == 0


def decoded(log, factory):
    """Every message by its schema."""
    messages = collections.defaultdict(list)
    with open(log, "rb") as file:
        reader = make_reader(file, decoder_factories=[factory], validate_crcs=True)
        header = reader.get_header()
        for schema, channel, message, content in reader.iter_decoded_messages():
            messages[schema.name].append((message.log_time / 1e9, channel.topic, content))
        assert sum(map(len, messages.values())) == reader.get_summary().statistics.message_count
    return header, messages


def check_native(log):
    header, messages = decoded(log, Protobuf())
    assert header.profile == "" and set(messages) == NATIVE, set(messages) ^ NATIVE
    # The pose in the scene is the pose of the state, and the ground truth on the wire but for its rounding.
    states = {(time, state.robot): state for time, _, state in messages["usarsim.RobotState"]}
    compared = 0
    for time, topic, transforms in messages["foxglove.FrameTransforms"]:
        for transform in transforms.transforms:
            if transform.parent_frame_id == "world" and transform.child_frame_id.startswith("robot/"):
                state = states[time, int(transform.child_frame_id.split("/")[1])]
                assert (transform.translation.x, transform.translation.y) == (state.position.x, state.position.y)
                assert transform.rotation.w == state.orientation.w
                compared += 1
    assert compared == len(states) > 300
    frames = {
        (transform.child_frame_id, transform.parent_frame_id)
        for _, _, message in messages["foxglove.FrameTransforms"]
        for transform in message.transforms
    }
    parents = dict(frames)
    assert len(parents) == len(frames), "each frame has one parent"
    drawn = [entity for _, _, update in messages["foxglove.SceneUpdate"] for entity in update.entities]
    for frame in [entity.frame_id for entity in drawn] + [m.frame_id for _, _, m in messages["foxglove.LaserScan"]]:
        while frame != "map":
            frame = parents[frame]
    wheels = [entity for entity in drawn if entity.frame_id.startswith("robot/0/")]
    assert sum(len(entity.cylinders) for entity in wheels) == 4 * 6 * 8, "rollers, as stacks of cylinders"
    assert sum(len(entity.triangles) > 0 for entity in wheels) == 4, "a hub on each wheel, a mesh"
    pushed = [state.position.y for _, _, state in messages["usarsim.ObjectState"]]
    assert pushed[-1] > pushed[0] + 0.05, (pushed[0], pushed[-1])
    deleted = [topic for _, topic, update in messages["foxglove.SceneUpdate"] if update.deletions]
    assert deleted == ["/robot/2/scene"], deleted
    readings = {(time, r.robot): r for time, _, r in messages["usarsim.SensorReading"] if r.type == "GroundTruth"}
    assert {robot for _, robot in readings} == {0, 1, 2, 3}, "every robot's readings"
    for at, reading in readings.items():
        position = reading.quantities[0]
        assert (position.name, position.unit) == ("position", "m")
        if at in states:
            true = states[at].position
            assert list(position.values) == [true.x, true.y, true.z]
    warned = [m.message for _, _, m in messages["foxglove.Log"] if m.level == 3]
    assert any("DRIVE" in text and "what" in text for text in warned), warned
    assert all(topic.split("/")[3] == "sensor" for _, topic, _ in messages["foxglove.LaserScan"])
    scans = {topic: (len(s.ranges), s.start_angle, s.end_angle) for _, topic, s in messages["foxglove.LaserScan"]}
    for beams, first, last in scans.values():
        assert (beams, round(first, 2), round(last, 2)) in [(181, 1.57, -1.57), (228, 2.09, -2.08)], scans
    return {name: len(content) for name, content in sorted(messages.items())}


def check_ros2(log):
    header, messages = decoded(log, Ros2())
    assert header.profile == "ros2" and set(messages) == ROS2, set(messages) ^ ROS2
    # The youBot drives to its right: negative y, no turn; the twist is the robot's.
    path = [(m.pose.pose.position, m.twist.twist.linear) for _, t, m in messages["nav_msgs/msg/Odometry"] if t == "/robot_0/ground_truth"]
    assert path[0][0].y - path[-1][0].y > 0.2 and abs(path[0][0].x - path[-1][0].x) < 0.01
    assert -0.11 < path[-1][1].y < -0.08, path[-1][1].y
    for _, _, scan in messages["sensor_msgs/msg/LaserScan"]:
        beams = (scan.angle_max - scan.angle_min) / scan.angle_increment + 1
        assert math.isclose(beams, len(scan.ranges), abs_tol=0.01) and scan.range_max in (4.0, 20.0)
        # The wall is ahead of everyone and everything else is free.
        assert min(scan.ranges) > 1 and min(scan.ranges) < scan.range_max or scan.range_max == 4.0
        assert all(reading < scan.range_max or reading == math.inf for reading in scan.ranges)
    # The robots' wheels say where they are, up to slip, and the frames hang together.
    estimated, true = ([m.pose.pose.position for _, t, m in messages["nav_msgs/msg/Odometry"] if t == f"/robot_0/{name}"] for name in ["odom", "ground_truth"])
    assert abs(estimated[-1].y - (true[-1].y - true[0].y)) < 0.02, (estimated[-1], true[0], true[-1])
    parents = {
        transform.child_frame_id: transform.header.frame_id
        for _, _, message in messages["tf2_msgs/msg/TFMessage"]
        for transform in message.transforms
    }
    for frame in [scan.header.frame_id for _, _, scan in messages["sensor_msgs/msg/LaserScan"]] + ["robot_0/base_link"]:
        while frame != "map":
            frame = parents[frame]
    descriptions = {topic: text.data for _, topic, text in messages["std_msgs/msg/String"]}
    assert len(descriptions) == 4 and '<joint name="FLWheel"' in descriptions["/robot_0/robot_description"], descriptions
    imus = collections.defaultdict(list)
    for _, _, imu in messages["sensor_msgs/msg/Imu"]:
        imus[imu.angular_velocity_covariance[0] != -1].append(imu)
    assert all(imu.linear_acceleration_covariance[0] == -1 for imu in imus[False]), "an INS measures the orientation alone"
    hovering = imus[True][-1]
    assert abs(hovering.linear_acceleration.z - 9.81) < 0.05 and abs(hovering.angular_velocity.z) < 0.01, hovering
    counts = {name: len(content) for name, content in sorted(messages.items())}
    # rosbags reads the same messages, by the definitions in the file and by those of a distribution.
    for store in [Stores.EMPTY, Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY]:
        seen = collections.Counter()
        with AnyReader([pathlib.Path(log)], default_typestore=get_typestore(store)) as reader:
            for connection, _, raw in reader.messages():
                message = reader.deserialize(raw, connection.msgtype)
                seen[connection.msgtype] += 1
                if connection.topic == "/robot_0/ground_truth":
                    last = message.pose.pose.position
        assert dict(seen) == counts, (store, seen, counts)
        assert last.y == path[-1][0].y
    return counts


def values(message):
    """Every number and text of a message of ROS 2, in order; NaN as a text, which is equal to itself."""
    if isinstance(message, list | tuple):
        return [value for part in message for value in values(part)]
    if hasattr(message, "__slots__"):
        return [value for name in message.__slots__ for value in values(getattr(message, name))]
    return ["nan" if isinstance(message, float) and math.isnan(message) else message]


def check_exports(usarsim, folder, states):
    """The table is the same as CSV and Parquet; the messages of ROS 2 made later are the same."""

    def export(*arguments):
        return subprocess.run([usarsim, "log", "export", f"{folder}/run.mcap", *arguments], check=True, capture_output=True, text=True).stdout

    export("--parquet", "--out", f"{folder}/states.parquet")
    table = pyarrow.parquet.read_table(f"{folder}/states.parquet")
    rows = csv.DictReader(export("--csv").splitlines())
    assert table.num_rows == states
    for row, expected in zip(rows, table.to_pylist(), strict=True):
        same = (float(row[name]) == value or math.isnan(value) for name, value in expected.items())
        assert all(same), (row, expected)
    export("--ros2", "--out", f"{folder}/later.mcap")
    later, live = (decoded(f"{folder}/{name}.mcap", Ros2())[1] for name in ["later", "run.ros2"])
    assert later.keys() == live.keys()
    for schema, messages in live.items():
        for (time, topic, read), (same_time, same_topic, measured) in zip(later[schema], messages, strict=True):
            assert (time, topic) == (same_time, same_topic)
            assert values(read) == values(measured), (schema, topic)


def main():
    usarsim = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        log = f"{folder}/run.mcap"
        record(usarsim, log)
        subprocess.run([usarsim, "log", "replay", log], check=True)
        native = check_native(log)
        check_exports(usarsim, folder, native["usarsim.RobotState"])
        print("native:", native)
        print("ROS 2:", check_ros2(f"{folder}/run.ros2.mcap"))


main()
