/** Readings of sensors, and their numbers by name. */

import type { Reading } from './live.gen';

export type { Reading } from './live.gen';

export type Quantity = Reading['quantities'][number];

export interface SensorValue {
  value: number;
  unit: string;
}

/** Numbers of each sensor's last reading by name; sensors by `Type Name`. */
export type SensorValues = Map<string, Map<string, SensorValue>>;

/** Longer lists of numbers, as those of a laser, are shown by their least. */
const LONGEST = 6;
const AXES = ['x', 'y', 'z'];

/** Adds the numbers of a reading of the sensor with a name. */
export function addReading({ type, quantities }: Reading, name: string, into: SensorValues): void {
  const sensor = `${type} ${name}`;
  const numbers = into.get(sensor) ?? new Map<string, SensorValue>();
  for (const { name: key, unit, values } of quantities) {
    const set = (key: string, value: number) => numbers.set(key, { value, unit });
    if (values.length === 1) set(key, values[0]!);
    else if (values.length > LONGEST) set(`smallest ${key}`, Math.min(...values));
    else values.forEach((value, index) => set(`${key} ${AXES[index] ?? index}`, value));
  }
  if (numbers.size > 0) into.set(sensor, numbers);
}
