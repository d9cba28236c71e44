# Goes to the wall on its right, then along the walls by the laser, for half a minute.
robot = await take("P3AT")
await robot.turn(1.571)
end = await now() + 30
while await now() < end:
    # Ranges come from the right to the left: 181 of them, the one ahead in the middle.
    ranges = (await robot.read("RangeScanner"))["Range"]
    ahead = min(ranges[70:111])
    left = min(ranges[121:181])
    if ahead < 1.0:
        await robot.drive(turn=0.2)
    elif left > 2.0:
        await robot.drive(forward=0.5)
    else:
        await robot.drive(forward=0.5, turn=max(-0.1, min(0.1, 0.3 * (0.7 - left))))
print("half a minute is over")
await robot.stop()
