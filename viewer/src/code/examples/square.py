# A square of 1 m: four times ahead and a quarter turn to the right.
import math

robot = await take("P3AT")
for side in range(1, 5):
    await robot.go(1.0)
    await robot.turn(math.pi / 2)
    x, y, z, roll, pitch, yaw = await robot.pose()
    print("side %d: x %.2f y %.2f" % (side, x, y))
