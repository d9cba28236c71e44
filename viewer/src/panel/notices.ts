/** The server's messages, for people. The Wire tab keeps their own words. */

import { refusal } from '../protocol/refusal';

/** A problem with a line that a client sent, and with which line. */
const OF_LINE = /^connection (\d+)(?:, line \d+)?: (.*)$/s;
/** The line itself, which is quoted at the end. */
const QUOTED = /: ([A-Z]+\d*(?: \{.*)?)$/s;
const SAME_NAME = /^\{Name (\S+)\} is the name of another robot/;

/**
 * Returns the text without numbers of connections and lines; `nameOf` returns the robots of a connection. Returns null for a refusal
 * of this page's own INIT line, as the page tells that itself.
 */
export function plainNotice(
  text: string,
  nameOf: (connection: number) => string | null,
  isOwn: (line: string) => boolean,
): string | null {
  const [, connection, said] = OF_LINE.exec(text) ?? [];
  if (connection === undefined || said === undefined) return text;
  const [, name] = SAME_NAME.exec(said) ?? [];
  if (name !== undefined) return `Another robot is named ${name}, too`;
  const [, line = ''] = QUOTED.exec(said) ?? [];
  const problem = said.replace(QUOTED, '');
  if (isOwn(line) && refusal(problem) !== null) return null;
  return `${nameOf(Number(connection)) ?? `Client ${connection}`}: ${problem}`;
}
