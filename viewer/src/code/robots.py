# Robots for a program of the page. Every order is awaited: it ends when it is done.
# Lengths are m, times are simulated seconds, angles are rad. Clockwise is as seen from above.

import json
import math

import _page


async def _call(name, *arguments):
    answer = json.loads(await _page.call(name, json.dumps(arguments)))
    if "error" in answer:
        raise RuntimeError(answer["error"])
    return answer.get("value")


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
        start = await self.pose()
        left = abs(metres)
        while left > 0.01:
            await self.drive(forward=math.copysign(min(0.5, 0.03 + left / 2), metres), seconds=0.04)
            at = await self.pose()
            left = abs(metres) - math.sqrt((at[0] - start[0]) ** 2 + (at[1] - start[1]) ** 2)
        await self.stop()

    # Turns on the spot, to the right if positive, by its true heading.
    async def turn(self, angle):
        heading = (await self.pose())[5]
        left = angle
        while abs(left) > 0.02:
            await self.drive(turn=math.copysign(min(0.5, 0.1 + abs(left) / 3), left), seconds=0.04)
            now = (await self.pose())[5]
            left -= (now - heading + math.pi) % (2 * math.pi) - math.pi
            heading = now
        await self.stop()

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
