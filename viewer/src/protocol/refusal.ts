/** Errors by which the server refuses to spawn a robot, in the words of the page. */

const HEAD = /^(?:INIT|LOGIN)(?: refused)?: /;
const TAIL = /; no robot is spawned(?:; .*)?$/s;
const WORDS: [RegExp, string][] = [
  [/^expected \{Team \.\.\} with one of (.*)$/, 'choose a team: $1'],
  [/^no team `(.*)`: expected \{Team \.\.\} with one of (.*)$/, 'there is no team $1: choose $2'],
  [/^(team \S+) has no (.*): expected one of (.*)$/, '$1 may not have a $2: choose $3'],
  [/^(team \S+) has all its \d+ robots in the world$/, '$1 has all its robots in the world: choose another team'],
  [/^\{Team [^}]*\}: expected (.*), the team of .*$/, 'your token is for team $1: choose a start of $1'],
  [/^the connection's token/, 'your token'],
  [/^\{ClassName (?:USARBot\.)?([^}]*)\} is unknown.*$/, 'the server has no class $1'],
  [/^\{(?:Start|Location) [^}]*\}: (.*)$/, '$1: choose another place'],
];

/** Returns the reason why no robot is spawned; null if an error is about something else. */
export function refusal(error: string): string | null {
  const refuses = TAIL.test(error) || /^(?:INIT|LOGIN) refused: /.test(error);
  if (!refuses) return null;
  const reason = error.replace(HEAD, '').replace(TAIL, '');
  const [pattern, words] = WORDS.find(([pattern]) => pattern.test(reason)) ?? [];
  return pattern && words ? reason.replace(pattern, words) : reason;
}
