/** Readings in lines of the protocol. */

/** Value of a reading: a number, a list of numbers, or a text. */
type Value = number | number[] | string;

/**
 * Returns a sensor's reading in a line, by its name or its type; null if the line has none of it. One line may have readings of several
 * sensors of a type: each begins with its name.
 */
export function readingIn(line: string, sensor: string): Record<string, Value> | null {
  if (!line.startsWith('SEN ')) return null;
  const common: Record<string, Value> = {};
  const readings: Record<string, Value>[] = [];
  for (const [, key = '', value = ''] of line.matchAll(/\{(\w+) ([^{}]*)\}/g)) {
    if (key === 'Name') readings.push({ Name: value });
    else (readings.at(-1) ?? common)[key] = valueOf(value);
  }
  const found = common.Type === sensor ? (readings[0] ?? {}) : readings.find(({ Name }) => Name === sensor);
  return found ? { ...common, ...found } : null;
}

function valueOf(text: string): Value {
  const numbers = text.split(',').map((part) => (part.trim() === '' ? NaN : Number(part)));
  if (numbers.some(Number.isNaN)) return text;
  return numbers.length === 1 ? numbers[0]! : numbers;
}
