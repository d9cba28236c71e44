"""A client of Foxglove's WebSocket protocol, not ours, reads the live channels and calls the services.

Usage: foxglove.py PROGRAM. Messages are decoded by their own schemas, as Foxglove and Lichtblick do.
"""

import asyncio
import base64
import json
import socket
import struct
import subprocess
import sys

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from websockets.asyncio.client import connect

PATIENCE = 30


class Client:
    """Subscribes to every channel and keeps the newest message of each topic, and how many came."""

    def __init__(self, socket):
        self.socket = socket
        self.channels, self.subscriptions, self.services = {}, {}, {}
        self.newest, self.counts, self.time = {}, {}, 0
        self.answers, self.changed, self.sessions = {}, asyncio.Condition(), []

    async def run(self):
        async for raw in self.socket:
            if isinstance(raw, bytes):
                self.take(raw)
            else:
                await self.take_text(json.loads(raw))
            async with self.changed:
                self.changed.notify_all()

    def take(self, raw):
        if raw[0] == 1:
            subscription, log_time = struct.unpack_from("<IQ", raw, 1)
            topic, read = self.subscriptions[subscription]
            self.newest[topic] = (log_time, read(raw[13:]))
            self.counts[topic] = self.counts.get(topic, 0) + 1
        elif raw[0] == 2:
            self.time = struct.unpack_from("<Q", raw, 1)[0] / 1e9
        elif raw[0] == 3:
            _, call, length = struct.unpack_from("<III", raw, 1)
            self.answers[call] = json.loads(raw[13 + length :])

    async def take_text(self, message):
        if message["op"] == "serverInfo":
            assert {"time", "services"} <= set(message["capabilities"]), message
            self.sessions.append(message.get("sessionId"))
        elif message["op"] == "advertise":
            wanted = []
            for channel in message["channels"]:
                subscription = len(self.subscriptions) + 1
                self.subscriptions[subscription] = (channel["topic"], reader(channel))
                wanted.append({"id": subscription, "channelId": channel["id"]})
            await self.socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
        elif message["op"] == "advertiseServices":
            self.services |= {service["name"]: service["id"] for service in message["services"]}
        elif message["op"] == "serviceCallFailure":
            self.answers[message["callId"]] = message["message"]

    async def call(self, service, request):
        call = len(self.answers) + 1
        payload = json.dumps(request).encode()
        head = struct.pack("<BIII", 2, self.services[service], call, 4) + b"json"
        await self.socket.send(head + payload)
        await self.until(lambda: call in self.answers, f"an answer of {service}")
        return self.answers[call]

    async def until(self, fits, what):
        async with self.changed:
            try:
                await asyncio.wait_for(self.changed.wait_for(fits), PATIENCE)
            except TimeoutError:
                raise AssertionError(f"never came: {what}; topics {sorted(self.counts)}") from None


def reader(channel):
    """Decodes the messages of a channel by the schema that it came with."""
    assert channel["encoding"] == "protobuf" and channel["schemaEncoding"] == "protobuf", channel["topic"]
    files = descriptor_pb2.FileDescriptorSet.FromString(base64.b64decode(channel["schema"]))
    pool = descriptor_pool.DescriptorPool()
    for file in files.file:
        pool.Add(file)
    kind = message_factory.GetMessageClass(pool.FindMessageTypeByName(channel["schemaName"]))
    return kind.FromString


async def check(port, foxglove):
    robot = socket.create_connection(("127.0.0.1", port))
    robot.sendall(b"INIT {ClassName USARBot.KUKA_YouBot} {Name R1} {Start PlayerStart_0}\r\nDRIVE {Left 2} {Right 2}\r\n")
    # Later than the robot: what was told once has to come again.
    await asyncio.sleep(1)
    async with connect(f"ws://127.0.0.1:{foxglove}", subprotocols=["foxglove.sdk.v1"], max_size=None) as ws:
        client = Client(ws)
        running = asyncio.create_task(client.run())
        topics = [
            "/tf_static", "/map/scene", "/robot/0/scene", "/robot/0/tf_static", "/robot/0/tf", "/robot/0/pose",
            "/robot/0/state", "/robot/0/joints", "/robot/0/sensor/Hokuyo", "/wire/out",
        ]  # fmt: skip
        await client.until(lambda: all(topic in client.newest for topic in topics), "every topic")
        await client.until(lambda: client.counts["/robot/0/pose"] > 50, "poses")
        parts = [entity for entity in client.newest["/robot/0/scene"][1].entities]
        assert len(parts) == 5 and sum(len(part.cylinders) for part in parts) > 24, "a body and four wheels with rollers"
        here = lambda: client.newest["/robot/0/pose"][1].pose.position.x
        await client.until(lambda: here() > 0.2, "it drives")
        assert abs(client.newest["/robot/0/pose"][0] / 1e9 - client.time) < 1, "time is simulated"

        assert await client.call("pause", {"pause": True}) == {"success": True}
        await asyncio.sleep(0.5)
        paused = client.time
        await asyncio.sleep(0.5)
        assert client.time == paused, "time stands still"
        assert await client.call("step", {"step": 10}) == {"success": True}
        await client.until(lambda: abs(client.time - paused - 0.02) < 1e-6, "ten steps")
        assert "expected" in await client.call("pause", {"pause": 1}), "a bad request is answered"
        assert "expected" in await client.call("step", {"pause": True}), "and one for another service"
        await client.call("pause", {"pause": False})
        await client.call("reset", {})
        await client.until(lambda: client.time < paused and len(client.sessions) == 2, "a new session")
        await client.until(lambda: abs(here()) < 0.01, "the robot is back")
        count = client.counts["/robot/0/scene"]
        robot.close()
        await client.until(lambda: client.counts["/robot/0/scene"] > count, "its drawing is deleted")
        assert len(client.newest["/robot/0/scene"][1].deletions) == 1
        running.cancel()
        print(f"foxglove: {len(client.counts)} topics, {sum(client.counts.values())} messages, services answer")


async def check_watching(_port, foxglove):
    """Where Foxglove may not control the world it still sees it, and is offered no service."""
    async with connect(f"ws://127.0.0.1:{foxglove}", subprotocols=["foxglove.sdk.v1"], max_size=None) as ws:
        info = json.loads(await asyncio.wait_for(ws.recv(), PATIENCE))
        assert info["op"] == "serverInfo" and "services" not in info["capabilities"], info
        ops = []
        while "advertise" not in ops:
            message = await asyncio.wait_for(ws.recv(), PATIENCE)
            ops += [json.loads(message)["op"]] if isinstance(message, str) else []
        assert "advertiseServices" not in ops, ops


def main():
    serve_and(check)
    serve_and(check_watching, "--control", "local")


def serve_and(check, *options):
    command = [sys.argv[1], "--quiet", "serve", "--json", "--port", "0", "--no-http", "--foxglove", "0", *options]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        ready = json.loads(server.stdout.readline())
        asyncio.run(check(ready["port"], ready["foxglove"]))
    finally:
        server.terminate()
        server.wait()


main()
