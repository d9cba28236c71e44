/** What sensors say on the wire, as numbers by name. */

/** By `Type Name` of a sensor, the numbers that it said last, by their names. */
export type SensorValues = Map<string, Map<string, number>>;

/** Longer lists of numbers, as those of a laser, are shown by their least. */
const LONGEST = 6;
const AXES = ['x', 'y', 'z'];

/** Adds what a line `SEN {Type Sonar} {Name F1 Range 4.2} ..` says; other lines say nothing of sensors. */
export function readSensorLine(text: string, into: SensorValues): void {
  if (!text.startsWith('SEN ')) return;
  let type = 'Sensor';
  let numbers: Map<string, number> | null = null;
  for (const [, block = ''] of text.matchAll(/\{([^{}]*)\}/g)) {
    const words = block.trim().split(/\s+/);
    for (let at = 0; at + 1 < words.length; at += 2) {
      const [key = '', word = ''] = [words[at], words[at + 1]];
      if (key === 'Type') type = word;
      else if (key === 'Name') {
        const sensor = `${type} ${word}`;
        numbers = into.get(sensor) ?? new Map();
        into.set(sensor, numbers);
      } else if (key !== 'Time') {
        if (!numbers) into.set(type, (numbers = new Map()));
        addNumbers(numbers, key, word);
      }
    }
  }
}

function addNumbers(numbers: Map<string, number>, key: string, word: string): void {
  const list = word.split(',').map(Number);
  if (list.some(Number.isNaN)) return;
  if (list.length === 1) numbers.set(key, list[0] ?? 0);
  else if (list.length > LONGEST) numbers.set(`smallest ${key}`, Math.min(...list));
  else list.forEach((number, index) => numbers.set(`${key} ${AXES[index] ?? index}`, number));
}
