# Picks up the cube of the map "hall": a youBot goes there, puts its hand over the cube, and grips.
robot = await take("YouBotArm")

async def go_to(to_x, to_y):
    while True:
        x, y, z, roll, pitch, yaw = await robot.pose()
        ahead, right = to_x - x, to_y - y
        if abs(ahead) + abs(right) < 0.008:
            return await robot.stop()
        limited = [max(-0.4, min(0.4, 2 * way)) for way in (ahead, right)]
        await robot.drive(limited[0], limited[1], turn=-yaw, seconds=0.03)

await robot.reach(0.4, 0, 0.2)
await robot.release()
await go_to(-0.9, -1.5)
await robot.reach(0.4, 0, 0.1)
await robot.reach(0.4, 0, 0.03)
held = await robot.grip()
await robot.reach(0.4, 0, 0.2)
print("the cube is in the hand" if held else "the hand is empty")
