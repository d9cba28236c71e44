/** Ranges as lines of the wire say them: those of sonars, and of lasers that are not level, stand nowhere else in a log. */

/** Sensors of a line by their names, with what they measured, m; in UT2004's dialect several sonars share a line. */
export function rangesOfLine(line: string): { name: string; ranges: number[] }[] {
  if (!/^SEN .*\{Type (Sonar|RangeScanner)\}/.test(line)) return [];
  const found: { name: string; ranges: number[] }[] = [];
  let name = '';
  for (const [, block] of line.matchAll(/\{([^{}]*)\}/g)) {
    const words = block!.split(' ');
    for (let at = 0; at + 1 < words.length; at += 2) {
      if (words[at] === 'Name') name = words[at + 1]!;
      if (words[at] === 'Range') found.push({ name, ranges: words[at + 1]!.split(',').map(Number) });
    }
  }
  return found;
}
