"""A stock node of ROS 2. Usage: node.py TASK ARGUMENTS; it prints what it saw as JSON."""

import collections
import faulthandler
import json
import math
import os
import sys
import time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import BatteryState, CameraInfo, CompressedImage, Imu, JointState, LaserScan, NavSatFix, PointCloud2, Range
from std_msgs.msg import Bool, Float64MultiArray, String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

# Time after which a node hangs, s. `follow` takes longest, and four times as long on a busy machine.
HANGS = 320
# Messages that a subscriber keeps until it takes them.
ROOM = 1000
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TYPES = {
    "joint_states": JointState,
    "odom": Odometry,
    "ground_truth": Odometry,
    "scan": LaserScan,
    "imu": Imu,
    "battery_state": BatteryState,
    "fix": NavSatFix,
    "camera_info": CameraInfo,
    "compressed": CompressedImage,
    "points": PointCloud2,
    "range": Range,
}


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


class Node:
    def __init__(self):
        rclpy.init()
        self.node = rclpy.create_node("peer")
        self.began = time.time()
        self.stamps = collections.defaultdict(list)
        self.last = {}
        # The newest messages: of what comes fifty times a second, those of four seconds.
        self.newest = collections.defaultdict(lambda: collections.deque(maxlen=200))

    def subscribe(self, topic, kind=None, qos=10):
        def take(message):
            stamp = message.clock if kind is Clock else getattr(message, "header", None) and message.header.stamp
            self.stamps[topic].append(seconds(stamp) if stamp else time.time() - self.began)
            self.last[topic] = message
            self.newest[topic].append(message)

        self.node.create_subscription(kind or TYPES[topic.split("/")[-1]], topic, take, qos)

    def spin(self, duration, each=lambda: None, until=lambda: False, interval=0.05):
        end, due = time.time() + duration, 0.0
        while time.time() < end and not until():
            if time.time() >= due:
                due = time.time() + interval
                each()
            rclpy.spin_once(self.node, timeout_sec=0.01)

    def wait(self, until, duration=60.0, each=lambda: None):
        self.spin(duration, each=each, until=until)
        assert until(), f"waited {duration} s"

    def pass_time(self, topic, duration, each=lambda: None):
        """Waits until a topic's stamps have gone on by so much. A busy machine simulates less than a second in a second."""
        end = self.stamps[topic][-1] + duration
        self.wait(lambda: self.stamps[topic][-1] >= end, 20 + 5 * duration, each)


def listen(duration, *topics):
    """Counts messages and the steps between their stamps."""
    node = Node()
    # There is room for what comes while the machine stalls.
    node.subscribe("/clock", Clock, ROOM)
    node.subscribe("/diagnostics", DiagnosticArray)
    for topic in topics:
        if topic.endswith("robot_description"):
            node.subscribe(topic, String, LATCHED)
        else:
            node.subscribe(topic, qos=qos_profile_sensor_data if topic.endswith("scan") else ROOM)
    node.wait(lambda: all(node.stamps[topic] for topic in ["/clock", *topics]))
    node.pass_time("/clock", float(duration))
    result = {}
    for topic, stamps in node.stamps.items():
        steps = [round(b - a, 4) for a, b in zip(stamps, stamps[1:])]
        result[topic] = {"count": len(stamps), "steps": dict(collections.Counter(steps)), "first": stamps[0] if stamps else None}
    for topic, message in node.last.items():
        if isinstance(message, CompressedImage):
            data = bytes(message.data)
            at = data.find(b"\xff\xc0")
            result[topic]["size"] = [int.from_bytes(data[at + 7 : at + 9], "big"), int.from_bytes(data[at + 5 : at + 7], "big")]
            result[topic]["bytes"] = len(data)
        if isinstance(message, PointCloud2):
            result[topic]["whole"] = len(message.data) == message.row_step * message.height and message.width > 0
        if isinstance(message, String):
            result[topic]["text"] = message.data[:40]
        if isinstance(message, LaserScan):
            result[topic]["beams"] = len(message.ranges)
        if isinstance(message, DiagnosticArray):
            result[topic]["values"] = {value.key: value.value for value in message.status[0].values}
    result["nodes"] = node.node.get_node_names()
    result["published"] = [name for name, _ in node.node.get_publisher_names_and_types_by_node("usarsim", "/")]
    result["topics"] = dict(node.node.get_topic_names_and_types())
    print(json.dumps(result))


def drive(space, x, y, turn, kind="Twist", duration="5"):
    """Drives with one velocity and reports the mean velocity of the last two seconds, then that after one and a half of silence."""
    node = Node()
    stamped = kind == "TwistStamped"
    publisher = node.node.create_publisher(TwistStamped if stamped else Twist, f"{space}/cmd_vel", 10)
    truth, odom = f"{space}/ground_truth", f"{space}/odom"
    for topic in [truth, odom]:
        node.subscribe(topic, qos=ROOM)
    node.wait(lambda: publisher.get_subscription_count() > 0 and len(node.last) == 2)

    def each():
        message = TwistStamped() if stamped else Twist()
        twist = message.twist if stamped else message
        twist.linear.x, twist.linear.y, twist.angular.z = float(x), float(y), float(turn)
        publisher.publish(message)

    def mean(topic):
        end = seconds(node.last[topic].header.stamp)
        late = [message for message in node.newest[topic] if seconds(message.header.stamp) > end - 2]
        return [sum(part) / len(late) for part in zip(*((m.twist.twist.linear.x, m.twist.twist.linear.y, m.twist.twist.angular.z) for m in late))]

    node.pass_time(truth, float(duration), each)
    result = {"truth": mean(truth), "odom": mean(odom)}
    node.pass_time(truth, 1.5)
    after = node.last[truth].twist.twist
    result["after"] = [after.linear.x, after.linear.y, after.angular.z]
    print(json.dumps(result))


def joints(space, joint, target):
    """Moves one joint along a trajectory, then by an array of all."""
    node = Node()
    node.subscribe(f"{space}/joint_states")
    trajectories = node.node.create_publisher(JointTrajectory, f"{space}/joint_trajectory", 10)
    arrays = node.node.create_publisher(Float64MultiArray, f"{space}/commands", 10)
    node.wait(lambda: trajectories.get_subscription_count() > 0 and arrays.get_subscription_count() > 0 and f"{space}/joint_states" in node.last)

    def position():
        state = node.last[f"{space}/joint_states"]
        return state.position[list(state.name).index(joint)]

    point = JointTrajectoryPoint()
    point.positions = [float(target)]
    point.time_from_start.sec = 2
    trajectory = JointTrajectory()
    trajectory.joint_names, trajectory.points = [joint], [point]
    start = position()
    trajectories.publish(trajectory)
    node.pass_time(f"{space}/joint_states", 1.0)
    half = position()
    node.wait(lambda: abs(position() - float(target)) < 0.02)
    print(json.dumps({"start": start, "half": half, "end": position()}))


def grip(space):
    """Opens a gripper, which comes closed, and closes it."""
    node = Node()
    node.subscribe(f"{space}/joint_states")
    publisher = node.node.create_publisher(Bool, f"{space}/gripper", 10)
    node.wait(lambda: publisher.get_subscription_count() > 0 and f"{space}/joint_states" in node.last)

    def fingers():
        state = node.last[f"{space}/joint_states"]
        return [position for name, position in zip(state.name, state.position) if "Finger" in name]

    moved = {}
    for closes in [False, True]:
        before = fingers()
        publisher.publish(Bool(data=closes))
        node.wait(lambda: max(abs(a - b) for a, b in zip(before, fingers())) > 0.005)
        node.pass_time(f"{space}/joint_states", 1.0)
        moved[str(closes)] = [after - old for old, after in zip(before, fingers())]
    print(json.dumps(moved))


def flood(space, duration):
    """Publishes velocities and calls a service as fast as it can."""
    node = Node()
    publisher = node.node.create_publisher(Twist, f"{space}/cmd_vel", 10)
    client = node.node.create_client(Trigger, "/usarsim/resume")
    node.wait(lambda: publisher.get_subscription_count() > 0 and client.service_is_ready())
    twist, end, sent, asked = Twist(), time.time() + float(duration), 0, 0
    while time.time() < end:
        for _ in range(100):
            twist.linear.x = 0.1 if sent % 2 else -0.1
            publisher.publish(twist)
            sent += 1
            client.call_async(Trigger.Request())
            asked += 1
        rclpy.spin_once(node.node, timeout_sec=0)
    print(json.dumps({"sent": sent, "asked": asked}))


def services():
    """Stops, steps and resets the world."""
    node = Node()
    node.subscribe("/clock", Clock, qos_profile_sensor_data)

    def call(name):
        client = node.node.create_client(Trigger, f"/usarsim/{name}")
        assert client.wait_for_service(10), name
        # A request that is sent before the server knows the client comes with Fast DDS's next heartbeat, after 3 s.
        node.spin(0.1)
        answer = client.call_async(Trigger.Request())
        node.wait(answer.done)
        assert answer.result().success, (name, answer.result().message)

    node.wait(lambda: node.stamps["/clock"])
    call("pause")
    node.spin(0.3)
    stopped = len(node.stamps["/clock"])
    node.spin(0.5)
    paused = len(node.stamps["/clock"]) - stopped
    for _ in range(10):
        call("step")
    node.spin(0.2)
    stepped = len(node.stamps["/clock"]) - stopped - paused
    call("resume")
    node.wait(lambda: len(node.stamps["/clock"]) > stopped + paused + stepped + 20)
    before = node.stamps["/clock"][-1]
    call("reset")
    node.wait(lambda: node.stamps["/clock"][-1] < before)
    print(json.dumps({"paused": paused, "stepped": stepped, "reset": node.stamps["/clock"][-1]}))


def follow(space, duration="300"):
    """Follows the wall on its right until it is where it began, once round."""
    node = Node()
    publisher = node.node.create_publisher(Twist, f"{space}/cmd_vel", 10)
    node.subscribe(f"{space}/ground_truth")
    corners = set()

    def steer(scan):
        beams = [(scan.angle_min + number * scan.angle_increment, reading) for number, reading in enumerate(scan.ranges)]
        near = lambda first, last: min((reading for angle, reading in beams if first <= angle <= last), default=9.0)  # noqa: E731
        ahead, right = near(-0.4, 0.4), near(-1.6, -0.6)
        command = Twist()
        command.linear.x = 0.4 if ahead > 0.8 else 0.0
        command.angular.z = 0.8 if ahead < 0.8 else max(-0.6, min(0.6, 1.5 * (0.4 - right)))
        publisher.publish(command)

    def is_round():
        at = node.last[f"{space}/ground_truth"].pose.pose.position
        corners.add((at.x > 3, at.y > 2) if abs(at.x) > 3 and abs(at.y) > 2 else None)
        return len(corners - {None}) == 4 and math.hypot(at.x - start.x, at.y - start.y) < 1

    node.wait(lambda: node.last)
    start, began = node.last[f"{space}/ground_truth"].pose.pose.position, seconds(node.last[f"{space}/ground_truth"].header.stamp)
    node.node.create_subscription(LaserScan, f"{space}/scan", steer, qos_profile_sensor_data)
    node.spin(float(duration), until=is_round)
    publisher.publish(Twist())
    node.spin(0.2)
    last = node.last[f"{space}/ground_truth"]
    print(json.dumps({"round": is_round(), "took": seconds(last.header.stamp) - began, "at": [last.pose.pose.position.x, last.pose.pose.position.y]}))


if __name__ == "__main__":
    # A node that hangs says where, before its caller gives up.
    faulthandler.dump_traceback_later(HANGS, exit=True)
    globals()[sys.argv[1]](*sys.argv[2:])
    # Fast DDS can wait for its own threads for ever when Python takes it down, so it is not taken down.
    sys.stdout.flush()
    os._exit(0)
