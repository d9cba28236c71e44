/** Starts and classes of robots that a scene offers. A league offers those of its teams. */

import type { NamedPlace, Scene } from './protocol/scene';

/** Classes for maps that name none. */
const FIRST_CLASSES = ['YouBotArm', 'P3AT', 'AirRobot'];
const MOST_CLASSES = 3;

export interface Start {
  /** Name on the wire. */
  name: string;
  /** Name for people, different for each start. */
  label: string;
  team: string | null;
  position: NamedPlace['position'];
  rotation: NamedPlace['rotation'];
}

/** Returns the start poses of a class of robots; without a class those of all. */
export function startsOf({ map, league, scenario }: Scene, robotClass: string | null = null): Start[] {
  if (!league) return map.starts.map((start) => ({ ...start, label: start.name, team: null }));
  return league.teams
    .filter(({ classes }) => robotClass === null || mayHave(classes, robotClass))
    .flatMap(({ name: team, starts }) =>
      starts.map((start, index) => ({ ...start, label: scenario ? start.name : `${team} ${index + 1}`, team })),
    );
}

/** Returns the classes that can be spawned. */
export function classesOf({ names, league }: Scene): string[] {
  return league ? names.filter((name) => league.teams.some((team) => mayHave(team.classes, name))) : names;
}

/** Returns a few classes that suit the map, the best first. */
export function firstClasses(scene: Scene): string[] {
  const possible = classesOf(scene);
  const wanted = scene.map.robots.length > 0 ? scene.map.robots : FIRST_CLASSES;
  const known = wanted.filter((name) => possible.includes(name));
  return (known.length > 0 ? known : possible).slice(0, MOST_CLASSES);
}

function mayHave(classes: string[], robotClass: string): boolean {
  return classes.length === 0 || classes.includes(robotClass);
}
