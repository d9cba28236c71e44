/** Files that a person brings, by the button or by dropping them anywhere: a log is played, a robot or a map comes into the world. */

import { Failed } from '../protocol/token';
import type { Opened, Transport } from '../protocol/transport';
import type { Vector } from '../protocol/scene';
import { closeDialog, showDialog } from './dialog';
import { find, make } from './dom';

/** Most files of a folder, as the server takes. */
const MAX_FILES = 2000;

/** Files by their paths in what was dropped. */
type Files = Map<string, File>;

/** Uses of what was opened. */
interface Uses {
  log(file: File): void;
  /** Takes a class of robots, and the place where it was dropped. */
  robot(robotClass: string, place: Vector | null): void;
  map(name: string): void;
  /** The ground at a point of the screen. */
  groundAt(x: number, y: number): Vector | null;
  say(text: string): void;
  /** The reason why this page may not bring robots and maps. */
  refused(): string | null;
}

export class Opening {
  private readonly card = find('opened');

  constructor(
    private readonly transport: Transport,
    private readonly uses: Uses,
  ) {
    const input = find<HTMLInputElement>('log-file');
    find('open-log').onclick = () => input.click();
    input.onchange = () => {
      void this.take(new Map([...(input.files ?? [])].map((file) => [file.name, file])), null);
      // So that the same file can be chosen again.
      input.value = '';
    };
    window.addEventListener('dragover', (event) => event.preventDefault());
    window.addEventListener('drop', (event) => {
      event.preventDefault();
      if (event.dataTransfer) void this.drop(event.dataTransfer, uses.groundAt(event.clientX, event.clientY));
    });
  }

  private async drop(data: DataTransfer, place: Vector | null): Promise<void> {
    // The browser forgets what was dropped when this function first waits.
    const entries = [...data.items].map((item) => item.webkitGetAsEntry()).filter((entry) => entry !== null);
    const files: Files = new Map([...data.files].map((file) => [file.name, file]));
    if (entries.some((entry) => entry.isDirectory)) {
      files.clear();
      for (const entry of entries) await collect(entry, files);
    }
    await this.take(files, place);
  }

  private async take(files: Files, place: Vector | null): Promise<void> {
    const [first] = files.values();
    if (!first) return;
    if (first.name.toLowerCase().endsWith('.mcap')) return this.uses.log(first);
    const refused = this.uses.refused();
    if (refused !== null) return this.uses.say(`Not opened: ${refused}`);
    if (files.size > MAX_FILES) return this.uses.say(`Not opened: more than ${MAX_FILES} files`);
    const name = files.size === 1 ? first.name : `${files.size} files`;
    this.show(name, make('p', { role: 'status' }, 'Opening …'));
    await this.open(name, files, null, place);
  }

  private async open(name: string, files: Files, chosen: string | null, place: Vector | null): Promise<void> {
    let opened: Opened;
    try {
      opened = await this.transport.openFiles(files, chosen);
    } catch (error) {
      const reason = error instanceof Failed ? error.reason : String(error);
      return this.show(`${name} is not opened`, make('p', { class: 'problem' }, reason));
    }
    if ('choices' in opened) {
      this.card.hidden = true;
      return this.choose(opened.choices, (choice) => void this.open(choice, files, choice, place));
    }
    const what = 'robot' in opened ? opened.robot : opened.map;
    const notes = opened.notes.map((note) => make('li', {}, note));
    const title = notes.length === 1 ? '1 note' : `${notes.length} notes`;
    this.show(
      what,
      ...opened.verdict.map((line) => make('p', {}, line)),
      notes.length > 0
        ? make('details', { open: '' }, make('summary', {}, title), make('ul', {}, ...notes))
        : make('p', {}, 'Nothing was guessed or left out.'),
    );
    if ('robot' in opened) this.uses.robot(what, place);
    else this.uses.map(what);
  }

  /** Asks which file is meant. */
  private choose(choices: string[], chosen: (choice: string) => void): void {
    const buttons = choices.map((choice) => {
      const button = make('button', { type: 'button', class: 'choice', 'data-file': choice }, choice);
      button.onclick = () => {
        closeDialog();
        chosen(choice);
      };
      return button;
    });
    void showDialog('Which one?', make('div', { class: 'choices' }, ...buttons));
  }

  /** Shows a card in the view. */
  private show(title: string, ...content: Node[]): void {
    const close = make('button', { type: 'button', class: 'plain icon', 'aria-label': 'Close' }, '✕');
    close.onclick = () => (this.card.hidden = true);
    this.card.replaceChildren(make('header', {}, make('h2', {}, title), close), ...content);
    this.card.hidden = false;
  }
}

/** Adds the files of a folder, with those of the folders in it. */
async function collect(entry: FileSystemEntry, files: Files): Promise<void> {
  if (files.size > MAX_FILES) return;
  if (isFile(entry)) {
    const file = await new Promise<File>((found, failed) => entry.file(found, failed));
    files.set(entry.fullPath.replace(/^\//, ''), file);
  } else if (isFolder(entry)) {
    const reader = entry.createReader();
    // A browser lists some hundred entries at a time, and none at the end.
    for (;;) {
      const some = await new Promise<FileSystemEntry[]>((found, failed) => reader.readEntries(found, failed));
      if (some.length === 0) return;
      for (const inside of some) if (!inside.name.startsWith('.')) await collect(inside, files);
    }
  }
}

const isFile = (entry: FileSystemEntry): entry is FileSystemFileEntry => entry.isFile;
const isFolder = (entry: FileSystemEntry): entry is FileSystemDirectoryEntry => entry.isDirectory;
