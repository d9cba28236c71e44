/** The few helpers that the page's elements are made and found with. */

export function find<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no #${id}`);
  return element as T;
}

/** An element with attributes and children; text is text, never markup. */
export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Record<string, string> = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  Object.entries(attributes).forEach(([name, value]) => element.setAttribute(name, value));
  element.append(...children);
  return element;
}

/** Sets a text only when it is another: most of them stay. */
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** Something that stays from visit to visit, where the browser lets it. */
export function remembered(key: string): string | null {
  try {
    return localStorage.getItem(`usarsim.${key}`);
  } catch {
    return null;
  }
}

export function remember(key: string, value: string): void {
  try {
    localStorage.setItem(`usarsim.${key}`, value);
  } catch {
    // Then it is forgotten.
  }
}

/** A number with so many digits after the point, without the sign of a zero. */
export function fixed(number: number, digits: number): string {
  return number.toFixed(digits).replace(/^-(0(\.0*)?)$/, '$1');
}

/** Gives a person something as a file. */
export function save(content: Blob, name: string): void {
  const url = URL.createObjectURL(content);
  make('a', { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** Time between two acts while a button is held, ms. */
const REPEAT_INTERVAL = 120;

/** Acts at a press, by pointer or keys, and again and again while the pointer holds the button. */
export function repeat(button: HTMLElement, act: () => void): void {
  let timer: ReturnType<typeof setInterval> | undefined;
  button.onpointerdown = (event) => {
    if (event.button !== 0) return;
    act();
    clearInterval(timer);
    // The button may go while it is held, or be of no use.
    timer = setInterval(() => {
      if (button.isConnected && button.matches(':enabled')) act();
      else clearInterval(timer);
    }, REPEAT_INTERVAL);
  };
  button.onpointerup = button.onpointerleave = button.onpointercancel = () => clearInterval(timer);
  // A key's click has no pointer.
  button.onclick = ({ detail }) => detail === 0 && act();
}
