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
