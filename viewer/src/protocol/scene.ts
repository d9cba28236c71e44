/** The scene as `/scene.json` gives it: SI units, z down. Those in scene.gen.ts and shape.gen.ts are generated from Rust. */

export type {
  Camera,
  Drawn,
  Gripper,
  Joint,
  NamedPlace,
  RobotClass,
  Scenario,
  ScenarioCard,
  Scene,
  Sensor,
  Sight,
  Solid,
  Spawned,
  Wheel,
} from './scene.gen';
export type { HeightField, Shape } from './shape.gen';

/** Position x y z and quaternion x y z w. */
export type Pose = [number, number, number, number, number, number, number];
export type Vector = [number, number, number];
export type Colour = [number, number, number];
