"""A participant of CycloneDDS: transforms, and the services of simulation_interfaces, which no package of PyPI has. Usage: cyclone.py
TASK ARGUMENTS; it prints what it saw as JSON."""

import collections
import json
import sys
import time

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
from cyclonedds.core import InstanceState, Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct
from cyclonedds.idl.types import float64, int32, sequence, uint8, uint16, uint32, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


def message(kind, **fields):
    package, name = kind.split("/")
    return make_idl_struct(name, f"{package}::msg::dds_::{name}_", fields)


Time = message("builtin_interfaces/Time", sec=int32, nanosec=uint32)
Header = message("std_msgs/Header", stamp=Time, frame_id=str)
Vector3 = message("geometry_msgs/Vector3", x=float64, y=float64, z=float64)
Point = message("geometry_msgs/Point", x=float64, y=float64, z=float64)
Quaternion = message("geometry_msgs/Quaternion", x=float64, y=float64, z=float64, w=float64)
Transform = message("geometry_msgs/Transform", translation=Vector3, rotation=Quaternion)
TransformStamped = message("geometry_msgs/TransformStamped", header=Header, child_frame_id=str, transform=Transform)
TFMessage = message("tf2_msgs/TFMessage", transforms=sequence[TransformStamped])
Pose = message("geometry_msgs/Pose", position=Point, orientation=Quaternion)
PoseStamped = message("geometry_msgs/PoseStamped", header=Header, pose=Pose)
Twist = message("geometry_msgs/Twist", linear=Vector3, angular=Vector3)
Accel = message("geometry_msgs/Accel", linear=Vector3, angular=Vector3)
Result = message("simulation_interfaces/Result", result=uint8, error_message=str)
Resource = message("simulation_interfaces/Resource", uri=str, resource_string=str)
EntityState = message("simulation_interfaces/EntityState", header=Header, pose=Pose, twist=Twist, acceleration=Accel)
EntityCategory = message("simulation_interfaces/EntityCategory", category=uint8)
TagsFilter = message("simulation_interfaces/TagsFilter", tags=sequence[str], filter_mode=uint8)
Bounds = message("simulation_interfaces/Bounds", type=uint8, points=sequence[Vector3])
EntityFilters = message("simulation_interfaces/EntityFilters", filter=str, categories=sequence[EntityCategory], tags=TagsFilter, bounds=Bounds)
SimulatorFeatures = message("simulation_interfaces/SimulatorFeatures", features=sequence[uint16], spawn_formats=sequence[str], custom_info=str)
SimulationState = message("simulation_interfaces/SimulationState", state=uint8)
Spawnable = message("simulation_interfaces/Spawnable", entity_resource=Resource, description=str, spawn_bounds=Bounds)
WorldResource = message("simulation_interfaces/WorldResource", name=str, world_resource=Resource, description=str, tags=sequence[str])

EMPTY = {"structure_needs_at_least_one_member": uint8}
SERVICES = {
    "GetSimulatorFeatures": (EMPTY, {"features": SimulatorFeatures}),
    "GetSimulationState": (EMPTY, {"state": SimulationState, "result": Result}),
    "SetSimulationState": ({"state": SimulationState}, {"result": Result}),
    "StepSimulation": ({"steps": uint64}, {"result": Result}),
    "ResetSimulation": ({"scope": uint8}, {"result": Result}),
    "GetEntities": ({"filters": EntityFilters}, {"result": Result, "entities": sequence[str]}),
    "GetEntityState": ({"entity": str}, {"result": Result, "state": EntityState}),
    "SetEntityState": ({"entity": str, "state": EntityState}, {"result": Result}),
    "GetSpawnables": ({"sources": sequence[str]}, {"result": Result, "spawnables": sequence[Spawnable]}),
    "SpawnEntity": (
        {"name": str, "allow_renaming": bool, "entity_resource": Resource, "entity_namespace": str, "initial_pose": PoseStamped},
        {"result": Result, "entity_name": str},
    ),
    "DeleteEntity": ({"entity": str}, {"result": Result}),
    "GetCurrentWorld": (EMPTY, {"result": Result, "world": WorldResource}),
    "LoadWorld": (
        {"world_resource": Resource, "fail_on_unsupported_element": bool, "ignore_missing_or_unsupported_assets": bool},
        {"result": Result, "world": WorldResource},
    ),
}
RELIABLE = Policy.Reliability.Reliable(duration(seconds=1))


def snake(name):
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name).lstrip("_")


class Client:
    """Calls services. The reply's identity is in its header, which this library does not show, so there is one call at a time."""

    def __init__(self):
        self.participant = DomainParticipant(0)
        self.open = {}

    def call(self, name, *arguments):
        if name not in self.open:
            request, response = SERVICES[name]
            types = [make_idl_struct(f"{name}_{part}", f"simulation_interfaces::srv::dds_::{name}_{part}_", fields) for part, fields in [("Request", request), ("Response", response)]]
            # A reply must not be missed because its reader is not known yet.
            qos = Qos(RELIABLE, Policy.History.KeepLast(10))
            topics = [Topic(self.participant, f"{prefix}/usarsim/{snake(name)}{part}", kind) for prefix, part, kind in zip(["rq", "rr"], ["Request", "Reply"], types)]
            reader = DataReader(self.participant, topics[1], qos)
            writer = DataWriter(self.participant, topics[0], qos)
            end = time.time() + 10
            while not (writer.get_matched_subscriptions() and reader.get_matched_publications()):
                assert time.time() < end, f"no service {name}"
                time.sleep(0.02)
            time.sleep(0.1)
            self.open[name] = (writer, reader, types[0])
        writer, reader, request = self.open[name]
        writer.write(request(*arguments))
        end = time.time() + 15
        while time.time() < end:
            for reply in reader.take(10):
                return reply
            time.sleep(0.01)
        raise AssertionError(f"{name} did not answer")


def pose(x, y, z, frame="map"):
    return PoseStamped(Header(Time(0, 0), frame), Pose(Point(x, y, z), Quaternion(0.0, 0.0, 0.0, 1.0)))


def nothing(kind):
    return EntityFilters(kind, [], TagsFilter([], 0), Bounds(0, []))


def transforms(seconds, frame):
    """Counts the transforms of so many simulated seconds and says how a frame hangs on its roots."""
    participant = DomainParticipant(0)
    topics = [Topic(participant, name, TFMessage) for name in ["rt/tf", "rt/tf_static"]]
    moving = DataReader(participant, topics[0], Qos(RELIABLE, Policy.History.KeepLast(1000)))
    fixed = DataReader(participant, topics[1], Qos(RELIABLE, Policy.Durability.TransientLocal, Policy.History.KeepLast(10)))
    end, parents, stamps = time.time() + 20 + 5 * float(seconds), {}, []
    while not (stamps and stamps[-1] - stamps[0] >= float(seconds)):
        assert time.time() < end, f"{len(stamps)} transforms"
        for reader in [moving, fixed]:
            for taken in reader.take(100):
                for transform in taken.transforms:
                    parents[transform.child_frame_id] = transform.header.frame_id
                if reader is moving:
                    at = taken.transforms[0].header.stamp
                    stamps.append(at.sec + at.nanosec * 1e-9)
        time.sleep(0.005)
    chain = [frame]
    while chain[-1] in parents:
        chain.append(parents[chain[-1]])
    steps = collections.Counter(round(b - a, 4) for a, b in zip(stamps, stamps[1:]))
    print(json.dumps({"count": len(stamps), "steps": dict(steps), "chain": chain}))


def graph(seconds):
    """Lists the topics that others publish."""
    participant = DomainParticipant(0)
    reader = BuiltinDataReader(participant, BuiltinTopicDcpsPublication)
    names, end = {}, time.time() + float(seconds)
    while time.time() < end:
        for sample in reader.take(1000):
            if sample.sample_info.instance_state == InstanceState.Alive:
                names[str(sample.key)] = sample.topic_name
            else:
                names.pop(str(sample.key), None)
        time.sleep(0.02)
    print(json.dumps(sorted(set(names.values()))))


INERTIAL = '<inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
WHEEL = (
    '<link name="{0}">' + INERTIAL + '<collision><origin rpy="1.5708 0 0"/><geometry><cylinder radius="0.1" length="0.05"/></geometry>'
    '</collision></link><joint name="{0}_wheel" type="continuous"><parent link="base"/><child link="{0}"/>'
    '<origin xyz="0 {1} 0"/><axis xyz="0 1 0"/></joint>'
)
CART = (
    '<robot name="cart"><link name="base">' + INERTIAL + '<collision><geometry><box size="0.5 0.3 0.1"/></geometry></collision></link>'
    + WHEEL.format("left", 0.2) + WHEEL.format("right", -0.2) + "</robot>"
)


def standard():
    """Uses the services of simulation_interfaces."""
    client = Client()
    features = client.call("GetSimulatorFeatures", 0).features.features
    assert {0, 1, 10, 11, 14, 20, 24, 25, 26, 31, 32} <= set(features), features
    spawnables = [it.entity_resource.uri for it in client.call("GetSpawnables", []).spawnables]
    assert "P3AT" in spawnables and "KUKA_YouBot" in spawnables, spawnables
    spawn = lambda name, renaming, uri, at: client.call("SpawnEntity", name, renaming, Resource(uri, ""), "", at)  # noqa: E731
    assert spawn("", False, "P3AT", pose(0.0, 0.0, 0.3)).result.result == 102
    assert spawn("R9", False, "", pose(0.0, 0.0, 0.3)).result.result == 104
    assert spawn("R9", False, "P3AT", pose(0.0, 0.0, 0.3, "moon")).result.result == 109
    unknown = spawn("R9", False, "P3ATT", pose(0.0, 0.0, 0.3)).result
    assert unknown.result == 4 and "P3AT" in unknown.error_message, unknown
    came = spawn("R9", False, "P3AT", pose(0.0, 0.0, 0.3))
    assert (came.result.result, came.entity_name) == (1, "R9"), came
    end = time.time() + 5
    while "R9" not in client.call("GetEntities", nothing("")).entities:
        assert time.time() < end
        time.sleep(0.05)
    assert client.call("GetEntities", nothing("R.")).entities == ["R9"]
    assert client.call("GetEntities", nothing("(")).result.result == 4
    assert spawn("R9", False, "P3AT", pose(3.0, 0.0, 0.3)).result.result == 101
    again = spawn("R9", True, "P3AT", pose(3.0, 0.0, 0.3))
    assert (again.result.result, again.entity_name) == (1, "R9_2"), again
    by_text = lambda name, text: client.call("SpawnEntity", name, False, Resource("", text), "", pose(-3.0, 0.0, 0.3))  # noqa: E731
    came = by_text("R10", CART)
    assert (came.result.result, came.entity_name) == (1, "R10"), came
    assert "cart" in [it.entity_resource.uri for it in client.call("GetSpawnables", []).spawnables]
    broken = by_text("R11", CART.replace("</robot>", ""))
    assert broken.result.result == 106 and "robot.urdf:1:" in broken.result.error_message, broken
    assert client.call("DeleteEntity", "R10").result.result == 1
    assert client.call("GetEntityState", "ghost").result.result == 2
    still = Twist(Vector3(0.0, 0.0, 0.0), Vector3(0.0, 0.0, 0.0))
    state = EntityState(pose(1.0, -2.0, 0.3).header, pose(1.0, -2.0, 0.3).pose, still, Accel(still.linear, still.angular))
    moved = client.call("SetEntityState", "R9", state).result
    assert moved.result == 1, moved
    assert client.call("SetSimulationState", SimulationState(2)).result.result == 1
    assert client.call("SetSimulationState", SimulationState(2)).result.result == 101
    assert client.call("GetSimulationState", 0).state.state == 2
    assert client.call("StepSimulation", 50).result.result == 1
    now = client.call("GetEntityState", "R9").state
    assert abs(now.pose.position.x - 1.0) < 0.05 and abs(now.pose.position.y + 2.0) < 0.05, now
    assert client.call("SetSimulationState", SimulationState(1)).result.result == 1
    assert client.call("StepSimulation", 1).result.result == 3
    assert client.call("DeleteEntity", "R9_2").result.result == 1
    assert client.call("GetCurrentWorld", 0).world.name == "rough"
    loaded = client.call("LoadWorld", Resource("hall", ""), False, False)
    assert (loaded.result.result, loaded.world.name) == (1, "hall"), loaded
    assert client.call("LoadWorld", Resource("moon", ""), False, False).result.result == 2
    assert client.call("ResetSimulation", 255).result.result == 1
    time.sleep(0.5)
    left = client.call("GetEntities", nothing("R.*")).entities
    assert left == [], left
    print(json.dumps({"features": len(features), "spawnables": len(spawnables)}))


if __name__ == "__main__":
    globals()[sys.argv[1]](*sys.argv[2:])
