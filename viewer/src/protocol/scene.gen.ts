// Generated from crates/page-protocol/src/page_scene.rs by `make figures`.

import type { Shape } from './shape.gen';

export type Scene = { version: string, seed: number | null, 
/**
 * Time step, s.
 */
time_step: number | null, 
/**
 * Port for controllers.
 */
port: number | null, 
/**
 * Maps that the server can change to.
 */
maps: Array<OtherMap>, map: Map, 
/**
 * Names of all classes.
 */
names: Array<string>, 
/**
 * Classes of a log's world. A server has each at `/class/<name>`.
 */
classes: Record<string, RobotClass>, league: League | null, scenario: Scenario | null, };

export type League = { 
/**
 * Victims to be found; 0 if they do not count.
 */
victims: number, teams: Array<Team>, 
/**
 * Places of goals that have one; victims are to be found.
 */
targets: Array<Target>, };

export type Target = { name: string, 
/**
 * Middle, m.
 */
position: [number, number, number], 
/**
 * Edges of a box, m; null for a circle.
 */
size: [number, number, number] | null, 
/**
 * Radius of a circle, m; null for a box.
 */
radius: number | null, };

export type Team = { name: string, starts: Array<NamedPlace>, 
/**
 * Classes that its robots may have; any if empty.
 */
classes: Array<string>, };

export type Scenario = { name: string, title: string, text: string, keys: string, robots: Array<ScenarioRobot>, 
/**
 * Names of the goals, in the order of the file.
 */
goals: Array<string>, 
/**
 * Simulated times for three stars and two, s.
 */
stars: [number, number], 
/**
 * Simulated time to its end, s.
 */
time_limit: number, camera: Viewpoint | null, };

export type ScenarioRobot = { class: string, name: string, };

export type Viewpoint = { from: [number, number, number], at: [number, number, number], };

export type ScenarioCard = { name: string, title: string, text: string, keys: string, map: string, robots: Array<string>, time_limit: number, stars: [number, number], 
/**
 * True if `/scenario/<name>/demo.mcap` is a run that reaches the goals.
 */
demo: boolean, 
/**
 * True if `/scenario/<name>/picture.jpg` shows it.
 */
picture: boolean, };

export type OtherMap = { name: string, description: string, };

export type Map = { name: string, description: string, 
/**
 * Classes of robots that suit it, to be offered.
 */
robots: Array<string>, solids: Array<Solid>, 
/**
 * Solids that are only seen, without edges and shadows.
 */
markings: Array<Solid>, objects: Array<Solid>, starts: Array<NamedPlace>, path_nodes: Array<NamedPlace>, sights: Array<Sight>, };

export type Sight = { kind: 'Victims' | 'Conveyors' | 'Smoke' | 'Sounds' | 'Tags', name: string, position: [number, number, number], 
/**
 * Description in a few words.
 */
about: string, };

export type Solid = { name: string, shape: Shape, pose: [number, number, number, number, number, number, number], 
/**
 * Name of the material.
 */
material: string, colour: [number, number, number], friction: number, 
/**
 * Mass of a movable object, kg.
 */
mass?: number, };

export type Spawned = { number: number, name: string, shape: Shape, pose: [number, number, number, number, number, number, number], 
/**
 * Name of the material.
 */
material: string, colour: [number, number, number], friction: number, 
/**
 * Mass of a movable object, kg.
 */
mass?: number, };

export type NamedPlace = { name: string, position: [number, number, number], 
/**
 * Roll, pitch, yaw, rad.
 */
rotation: [number, number, number], };

export type RobotClass = { description: string, steering: 'SkidSteered' | 'OmniDrive' | 'AckermanSteered' | 'Aerial' | 'Legged' | 'None', 
/**
 * Largest angles of front and rear, rad.
 */
max_steer: [number, number], drive_model: string, wheel_radius: number, track: number, wheel_base: number, 
/**
 * Pieces of the body.
 */
drawn: Array<Drawn>, 
/**
 * Links except the body and driven wheels.
 */
links: Array<Link>, 
/**
 * Driven wheels.
 */
wheels: Array<Wheel>, 
/**
 * Links with a joint that has a value, in the order of a log's positions.
 */
values: Array<string>, 
/**
 * Joints that go to positions.
 */
joints: Array<Joint>, grippers: Array<Gripper>, sensors: Array<Sensor>, };

export type Link = { name: string, 
/**
 * Index of the parent among the links; null for the body.
 */
parent: number | null, 
/**
 * Pose in the robot frame when every joint is at 0.
 */
pose: [number, number, number, number, number, number, number], drawn: Array<Drawn>, };

export type Drawn = { shape: Shape, pose: [number, number, number, number, number, number, number], colour: [number, number, number], 
/**
 * Speed about its own z axis, rad/s: it turns with the world's time.
 */
spin: number, };

export type Wheel = { name: string, 
/**
 * Index of the carrier among the links; null for the body.
 */
link: number | null, 
/**
 * Position in the carrier's frame, m.
 */
position: [number, number, number], 
/**
 * Pieces except rollers and pads.
 */
drawn: Array<Drawn>, 
/**
 * Speed limit, rad/s.
 */
max_speed: number | null, rollers: Rollers | null, 
/**
 * Half length and half width of its tyre's contact patch, m; null for a rigid disc.
 */
patch: [number, number] | null, 
/**
 * Pads of the belt around it; a wheel with a belt does not turn.
 */
belt: Belt | null, };

export type Belt = { 
/**
 * Corners of the path, x and z in the wheel's frame, m.
 */
path: Array<[number, number]>, pads: number, 
/**
 * Edges of a pad along the path, across the belt and outward, m.
 */
size: [number, number, number], 
/**
 * Travel for each rad of the sprocket, m.
 */
radius: number, colour: [number, number, number], };

export type Rollers = { 
/**
 * Poses in the wheel's frame.
 */
poses: Array<[number, number, number, number, number, number, number]>, 
/**
 * Points of the outline: along the axis and away from it, m.
 */
outline: Array<[number, number]>, colour: [number, number, number], };

export type Joint = { 
/**
 * Name, which is that of the link that it moves.
 */
name: string, 
/**
 * Unit vector in the link's frame: the link turns about it or moves along it.
 */
axis: [number, number, number], min: number, max: number, unit: 'rad' | 'm', };

export type Gripper = { name: string, joints: Array<string>, 
/**
 * Positions of the joints, rad or m.
 */
open: Array<number>, closed: Array<number>, 
/**
 * Index among the links of the one that carries the joints; null for the body.
 */
link: number | null, 
/**
 * Middle between the fingers in that link's frame, m.
 */
middle: [number, number, number], };

export type Sensor = { name: string, 
/**
 * Index of the carrier among the links; null for the body.
 */
link: number | null, 
/**
 * Pose in the carrier's frame.
 */
pose: [number, number, number, number, number, number, number], 
/**
 * Size of its pictures; null if it is no camera.
 */
camera: Camera | null, 
/**
 * Greatest range, m.
 */
max_range: number | null, fan: Fan | null, };

export type Camera = { width: number, height: number, };

export type Fan = { 
/**
 * Angle of the first beam, rad.
 */
first: number, 
/**
 * Angle between two beams, rad.
 */
resolution: number, 
/**
 * True if the beams are in the sensor's horizontal plane.
 */
level: boolean, };
