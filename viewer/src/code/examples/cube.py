# Picks up the cube of the map "hall": a youBot goes there, puts its hand over the cube, and grips.
robot = await take("YouBotArm")

await robot.reach(0.4, 0, 0.2)
await robot.release()
await robot.go_to(-0.9, -1.5, heading=0)
await robot.reach(0.4, 0, 0.1)
await robot.reach(0.4, 0, 0.03)
held = await robot.grip()
await robot.reach(0.4, 0, 0.2)
print("the cube is in the hand" if held else "the hand is empty")
