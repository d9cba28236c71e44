# Robots for a program of the page. Every order is awaited: it ends when it is done.
# Lengths are m, times are simulated seconds, angles are rad. Clockwise is as seen from above.

import json
import math

import _page

# A robot that comes no nearer to where it goes for so long has something in its way, s.
PATIENCE = 15


async def _call(name, *arguments):
    answer = json.loads(await _page.call(name, json.dumps(arguments)))
    if "error" in answer:
        raise RuntimeError(answer["error"])
    return answer.get("value")


# An angle between -pi and pi.
def _wrapped(angle):
    return (angle + math.pi) % (2 * math.pi) - math.pi


# The part with which to drive so that a way is not passed before the next look; none for less than half of `near`.
def _part(way, gain, near):
    if abs(way) < near / 2:
        return 0
    most = min(0.5, 0.03 + abs(way))
    if gain > 0:
        most = min(most, 0.7 * abs(way) / gain)
    return math.copysign(most, way)


class Robot:
    def __init__(self, name):
        self.name = name

    def __repr__(self):
        return "<robot %s>" % self.name

    # Drives with parts of what the robot can do, -1 to 1. With `seconds` it waits so long, and drives on.
    async def drive(self, forward=0, right=0, turn=0, up=0, seconds=None):
        await _call("drive", self.name, forward, right, turn, up)
        if seconds is not None:
            await wait(seconds)

    async def stop(self):
        await self.drive()

    # Goes so far ahead, or back, by where it truly is.
    async def go(self, metres):
        x, y, _, _, _, yaw = await self.pose()
        gone = lambda at: (at[0] - x) * math.cos(yaw) + (at[1] - y) * math.sin(yaw)
        await self._steer(lambda at: (metres - gone(at), 0, 0), 0.01)

    # Turns on the spot, to the right if positive, by its true heading.
    async def turn(self, angle):
        heading = (await self.pose())[5]
        left = angle

        def left_at(at):
            nonlocal heading, left
            left -= _wrapped(at[5] - heading)
            heading = at[5]
            return 0, 0, left

        await self._steer(left_at, 0.02)

    # Goes straight to a place, for a robot that goes sideways, too. It turns to a heading if there is one.
    async def go_to(self, x, y, heading=None):
        heading = (await self.pose())[5] if heading is None else heading

        def left_at(at):
            far, cos, sin = (x - at[0], y - at[1]), math.cos(at[5]), math.sin(at[5])
            return far[0] * cos + far[1] * sin, far[1] * cos - far[0] * sin, _wrapped(heading - at[5]) / 2

        await self._steer(left_at, 0.005)

    # Drives until the robot stands and less than `near` is left of each: the way ahead, to the right, and the turn. `left_at` returns
    # them for a pose. Fails if something is in the way.
    async def _steer(self, left_at, near):
        since, at = await self._see()
        left = left_at(at)
        nearest = max(map(abs, left))
        # What a whole part changes of each until the next look: much on a slow page, which looks seldom.
        gains = [0, 0, 0]
        while True:
            if max(map(abs, left)) < near:
                await self.stop()
                left = left_at(await self._stand())
                if max(map(abs, left)) < near:
                    return
            parts = [_part(way, gain, near) for way, gain in zip(left, gains)]
            await self.drive(*parts)
            time, at = await self._see()
            before, left = left, left_at(at)
            for i, part in enumerate(parts):
                if part:
                    gains[i] = max((before[i] - left[i]) / part, 0.7 * gains[i])
            far = max(map(abs, left))
            if far < max(near, nearest - near):
                nearest, since = far, time
            elif time - since > PATIENCE:
                await self.stop()
                raise RuntimeError("%s comes no nearer: something is in its way" % self.name)

    # Waits for a time and a pose that are later than its orders, and returns both.
    async def _see(self):
        time, *pose = await _call("see", self.name)
        return time, pose

    # Waits until it stands, for a second at most: what flies never does. Returns its pose.
    async def _stand(self):
        _, at = await self._see()
        for _ in range(10):
            await wait(0.1)
            before, at = at, await self.pose()
            if max(abs(a - b) for a, b in zip(at, before)) < 0.001:
                break
        return at

    # Sends a line of the protocol as this robot's client.
    async def send(self, line):
        await _call("send", self.name, line)

    # Waits for the next reading of a sensor, by its name or its type, as a dict.
    async def read(self, sensor):
        return await _call("read", self.name, sensor)

    # Returns x, y, z, roll, pitch, yaw: where it truly is.
    async def pose(self):
        return tuple(await _call("pose", self.name))

    # Moves joints to positions, as move(ArmJoint1=0.5), and waits until they stand. True if all arrived.
    async def move(self, **joints):
        return await _call("move", self.name, joints)

    # Brings the gripper, fingers down, to a place: ahead and right of the robot, and above the floor. True if it arrived.
    async def reach(self, ahead, right, height):
        return await _call("reach", self.name, ahead, right, height)

    # Closes the gripper, and waits until its fingers stand. True if something keeps them apart.
    async def grip(self):
        return not await _call("grip", self.name, False)

    # Opens the gripper.
    async def release(self):
        await _call("grip", self.name, True)


# Takes this page's robot of a class, and spawns one if there is none. Without a class: the robot that is driven.
async def take(robot_class=None):
    return Robot(await _call("take", robot_class))


# Waits for simulated seconds.
async def wait(seconds):
    await _call("wait", seconds)


# Returns the simulated time.
async def now():
    return await _call("now")
