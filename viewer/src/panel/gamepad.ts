/** The first gamepad that is connected, as the standard mapping has it. */

import type { Twist } from '../protocol/client';

/** Sticks never come back to exactly 0. */
const DEAD_ZONE = 0.12;

/** Left stick: forward and right; right stick: turning; triggers: up and down. */
export function readGamepad(): Twist | null {
  const pad = navigator.getGamepads().find((pad) => pad?.connected);
  if (!pad) return null;
  const axis = (index: number) => {
    const value = pad.axes[index] ?? 0;
    return Math.abs(value) < DEAD_ZONE ? 0 : (value - Math.sign(value) * DEAD_ZONE) / (1 - DEAD_ZONE);
  };
  const trigger = (index: number) => pad.buttons[index]?.value ?? 0;
  return { forward: 0 - axis(1), right: axis(0), clockwise: axis(2), up: trigger(7) - trigger(6) };
}
