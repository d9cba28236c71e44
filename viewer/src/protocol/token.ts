/** The token of a server that asks for one. It comes with the address, as in `#token=..`, or is typed; this tab keeps it. */

const KEY = 'token';

/** The server did not accept the token, or got none. */
export class Refused extends Error {}

/** An address stays visible and in the history, a token must not. */
function takeFromAddress(): void {
  const parts = location.hash.slice(1).split('&');
  const given = parts.find((part) => part.startsWith('token='));
  if (given === undefined) return;
  setToken(decodeURIComponent(given.slice('token='.length)));
  const rest = parts.filter((part) => part !== given).join('&');
  history.replaceState(null, '', rest ? `#${rest}` : location.pathname + location.search);
}

export function token(): string | null {
  takeFromAddress();
  return sessionStorage.getItem(KEY);
}

/** Returns the line that logs a client of the protocol in; none without a token. */
export function loginLines(): string[] {
  const own = token();
  return own === null ? [] : [`LOGIN {Token ${own}}`];
}

export function setToken(text: string): void {
  sessionStorage.setItem(KEY, text.trim());
}

/** The server could not answer, for a reason in words. */
export class Failed extends Error {
  constructor(
    name: string,
    status: number,
    readonly reason: string,
  ) {
    super(`${name}: ${status} ${reason}`);
  }
}

/** Fetches from the server with the token. */
export async function fetchWithToken(name: string, init: RequestInit = {}): Promise<Response> {
  const own = token();
  const headers: HeadersInit = own === null ? {} : { Authorization: `Bearer ${own}` };
  const response = await fetch(name, { ...init, headers });
  if (response.status === 401) throw new Refused((await response.text()).trim());
  if (!response.ok) throw new Failed(name, response.status, (await response.text()).trim());
  return response;
}
