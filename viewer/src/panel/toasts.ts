/** Messages that stand in the view for a few seconds. One that comes again is counted. */

import { find, make, setText } from './dom';

/** Time for which a message stays, ms, and most messages at a time. */
const SHOWN_TIME = 6000;
const MAX_SHOWN = 4;

interface Toast {
  text: string;
  count: number;
  element: HTMLElement;
  timer: number;
}

export class Toasts {
  private readonly element = find('toasts');
  private shown: Toast[] = [];

  show(text: string): void {
    const again = this.shown.find((toast) => toast.text === text);
    if (again) {
      again.count++;
      setText(again.element, `${text} (${again.count} times)`);
      clearTimeout(again.timer);
      again.timer = this.endLater(again);
      return;
    }
    const toast: Toast = { text, count: 1, element: make('p', {}, text), timer: 0 };
    toast.timer = this.endLater(toast);
    this.shown.push(toast);
    this.element.append(toast.element);
    if (this.shown.length > MAX_SHOWN && this.shown[0]) this.end(this.shown[0]);
  }

  private endLater(toast: Toast): number {
    return window.setTimeout(() => this.end(toast), SHOWN_TIME);
  }

  private end(toast: Toast): void {
    clearTimeout(toast.timer);
    toast.element.remove();
    this.shown = this.shown.filter((other) => other !== toast);
  }
}
