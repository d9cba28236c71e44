// Generated from crates/page-protocol/src/live.rs by `make figures`.

export type Request = { "token": string } | { "fit": Fit } | { "echo": number } | Listen | Control;

export type Listen = { 
/**
 * True for every line of the wire.
 */
wire: boolean, 
/**
 * Numbers of the robots whose readings it wants.
 */
robots: Array<number>, 
/**
 * Numbers of the robots whose cameras' pictures it wants.
 */
cameras: Array<number>, };

export type Control = { "pause": boolean } | { "step": number } | { "speed": number } | "reset" | { "record": boolean } | "save" | { "remove": number } | { "map": string } | { "scenario": string };

export type Fit = { 
/**
 * Its class.
 */
class: string, 
/**
 * As in INIT, m.
 */
location: [number, number, number], 
/**
 * Heading, rad.
 */
yaw: number, };

export type Message = { "status": Status } | { "line": WireLine } | { "reading": Reading } | { "said": string } | { "missed": number } | { "fit": FitAnswer } | { "echo": number } | { 
/**
 * Name of the page, as shown to everyone.
 */
you: string, 
/**
 * Reason why it may not control the world, if any.
 */
refused: string | null, };

export type FitAnswer = { 
/**
 * True if the robot can stand right there.
 */
stands: boolean, 
/**
 * The obstacle, in words.
 */
why: string | null, 
/**
 * Its class.
 */
class: string, 
/**
 * As in INIT, m.
 */
location: [number, number, number], 
/**
 * Heading, rad.
 */
yaw: number, };

export type WireLine = { 
/**
 * Simulated time, s.
 */
time: number, 
/**
 * `in` from a client, `out` to it.
 */
direction: 'in' | 'out', 
/**
 * The client's connection.
 */
connection: number, 
/**
 * The robot that it is for or about, if any.
 */
robot: number | null, 
/**
 * The line, cut if it is long.
 */
text: string, };

export type Reading = { 
/**
 * Simulated time, s.
 */
time: number, 
/**
 * Number of its robot.
 */
robot: number, 
/**
 * Number of the sensor in the robot's class.
 */
sensor: number, type: string, quantities: { name: string, unit: string, values: number[] }[], };

export type Status = { 
/**
 * Simulated seconds per real second, over the last half second.
 */
real_time_factor: number, 
/**
 * Requested real-time factor; 0 is as fast as possible.
 */
speed: number, 
/**
 * True while time stands still.
 */
paused: boolean, 
/**
 * Number of the scene. When it changes, a page must fetch the scene again.
 */
scene: number, 
/**
 * Number of changes of the objects beside the map's. When it changes, a page must fetch them again.
 */
objects: number, 
/**
 * Open pages.
 */
viewers: number, 
/**
 * Number of times that the world started over.
 */
resets: number, 
/**
 * Number of times that the world was saved.
 */
saves: number, 
/**
 * Steps of robots whose contacts did not converge.
 */
unsettled_steps: number, 
/**
 * File of the log that is being written.
 */
recording: string | null, 
/**
 * The league that is played, if any.
 */
league: League | null, 
/**
 * All robots.
 */
robots: Array<RobotStatus>, 
/**
 * All clients.
 */
clients: Array<ClientStatus>, };

export type League = { name: string, 
/**
 * Simulated time that is left, s.
 */
time_left: number, 
/**
 * True from the first robot's arrival.
 */
has_begun: boolean, 
/**
 * True if the time is up.
 */
is_over: boolean, 
/**
 * Teams, the best first.
 */
teams: Array<TeamStatus>, };

export type TeamStatus = { 
/**
 * Place, from 1; equal points share one.
 */
place: number, name: string, points: number, 
/**
 * Number of victims that it found.
 */
found: number, 
/**
 * Simulated time from the first robot's arrival to its last goal, when it has reached all, s.
 */
finished: number | null, 
/**
 * Names of the goals that it has reached, in that order.
 */
reached: Array<string>, 
/**
 * Numbers of the robots that entered for it.
 */
robots: Array<number>, 
/**
 * The last changes of its points, newest first.
 */
scores: { time: number, robot: number, reason: string, points: number, total: number }[], };

export type RobotStatus = { 
/**
 * Its number.
 */
id: number, 
/**
 * Its class.
 */
class: string, 
/**
 * Its name; empty if it has none.
 */
name: string, 
/**
 * The connection that it reports to.
 */
connection: number | null, 
/**
 * Battery life left, whole s.
 */
battery: number | null, };

export type ClientStatus = { 
/**
 * Its connection.
 */
connection: number, 
/**
 * Its address.
 */
peer: string, 
/**
 * Lines received from it.
 */
lines: number, 
/**
 * Periodic lines dropped because it was too slow.
 */
dropped: number, 
/**
 * Bytes that wait to be sent to it.
 */
waiting_bytes: number, };
