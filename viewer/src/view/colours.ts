/** The robots' own colours and those of the two themes. */

/**
 * After Okabe and Ito, so that the colour-blind can tell them apart; made to be seen on light and on dark. Red is kept
 * for errors.
 */
export const COLOURS = [
  '#1f83d6',
  '#e69f00',
  '#00a37a',
  '#cc79a7',
  '#4cc3ee',
  '#8b6ad8',
  '#d9c622',
  '#a0693a',
  '#7f9a2e',
  '#8a8f98',
] as const;

/**
 * Returns the colour of a robot. It goes by the robot's name: every page shows the same, also after the robot is spawned again. The
 * number at the end of a name is counted, so that Robot1 to Robot10 differ.
 */
export function colourOf({ id, name }: { id: number; name: string }): string {
  const [, stem = '', number = ''] = /^(.*?)(\d{0,9})$/s.exec(name || String(id)) ?? [];
  // The page's first robot, Robot1, has the first colour.
  let hash = 2;
  for (const letter of stem) hash = (31 * hash + (letter.codePointAt(0) ?? 0)) % 65_521;
  return colourAt(hash + Number(number));
}

/** Returns the colour at a place of the list, which begins again after its end. */
function colourAt(index: number): string {
  return COLOURS[index % COLOURS.length] ?? '#8a8f98';
}

/** Colours of teams that are called after one. */
const NAMED: Record<string, string> = {
  red: '#d64550',
  blue: '#1f83d6',
  green: '#00a37a',
  yellow: '#d9c622',
  orange: '#e69f00',
  purple: '#8b6ad8',
  pink: '#cc79a7',
  brown: '#a0693a',
};

/** Returns the colour of a team by its name, or else by its place in the league. */
export function teamColour(name: string, index: number): string {
  return NAMED[name.toLowerCase()] ?? colourAt(index);
}

/** Returns the colours of a chart's curves: a robot's first curve has the colour of the robot, every other one a free colour. */
export function curveColours(curves: { robot: number; colour: string }[]): string[] {
  const isFirst = curves.map(({ robot }, index) => curves.findIndex((curve) => curve.robot === robot) === index);
  const taken = new Set(curves.filter((_, index) => isFirst[index]).map(({ colour }) => colour));
  const free = COLOURS.filter((colour) => !taken.has(colour));
  let next = 0;
  return curves.map(({ colour }, index) => {
    if (isFirst[index]) return colour;
    return (free.length > 0 ? free[next++ % free.length] : undefined) ?? colourAt(index);
  });
}

/** Colours of contact forces, which no robot and no axis has: of a contact with all of its friction left, and of one that slides. */
export const FORCE_COLOURS = ['#ff10c0', '#6a00ff'] as const;

/** Colours of the axes x, y and z. */
export const AXIS_COLOURS = ['#e0525e', '#3fa66a', '#4a7fe0'] as const;

export interface Theme {
  /** Colours of the sky at the horizon, and straight above. */
  horizon: string;
  zenith: string;
  /** Ambient light: from above, and back from the ground. */
  fromSky: string;
  fromGround: string;
  ambient: number;
  key: string;
  keyStrength: number;
  /** Strength of the environment that shiny things reflect. */
  reflection: number;
  line: string;
  lineStrength: number;
  edge: string;
  edgeStrength: number;
}

export const LIGHT: Theme = {
  horizon: '#e6ebf0',
  zenith: '#b3c6da',
  fromSky: '#eef4ff',
  fromGround: '#b9b3a8',
  ambient: 1.75,
  key: '#fff4e2',
  keyStrength: 1.9,
  reflection: 0.55,
  line: '#2b3440',
  lineStrength: 0.2,
  edge: '#20242b',
  edgeStrength: 0.38,
};

export const DARK: Theme = {
  horizon: '#1d1f26',
  zenith: '#101116',
  fromSky: '#b9c6e0',
  fromGround: '#5b5650',
  ambient: 0.62,
  key: '#ffeed8',
  keyStrength: 0.85,
  reflection: 0.25,
  line: '#dfe5f0',
  lineStrength: 0.11,
  edge: '#000000',
  edgeStrength: 0.5,
};
