/** Asks the server for classes of robots: its scene names those of its start, and has none. */

import type { RobotClass, Scene } from './scene';

export class ClassQuestions {
  private scene: Scene | null = null;
  private readonly answers = new Map<string, Promise<RobotClass | null>>();

  /** `came` hears that the scene has another class. */
  constructor(
    private readonly came: () => void,
    private readonly fetch: (name: string) => Promise<RobotClass>,
  ) {}

  /** Begins with a scene, maybe of another server. */
  restart(scene: Scene): void {
    this.scene = scene;
    this.answers.clear();
  }

  /** Goes on with another map of the same server. */
  keep(scene: Scene): void {
    scene.classes = this.scene?.classes ?? {};
    this.scene = scene;
  }

  /** Returns a class, which is then in the scene; null if the server has none of that name, or is lost. */
  want(name: string): Promise<RobotClass | null> {
    const known = this.answers.get(name);
    if (known || !this.scene) return known ?? Promise.resolve(null);
    const { classes, names } = this.scene;
    const answer = this.fetch(name).then(
      (robotClass) => {
        classes[name] = robotClass;
        // A class may come while the server runs.
        if (!names.includes(name)) names.push(name);
        if (classes === this.scene?.classes) this.came();
        return robotClass;
      },
      () => {
        // The next one who asks tries again.
        if (this.answers.get(name) === answer) this.answers.delete(name);
        return null;
      },
    );
    this.answers.set(name, answer);
    return answer;
  }
}
