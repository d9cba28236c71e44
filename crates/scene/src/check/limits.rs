//! The ranges and counts.

use super::Range;

/// Coordinates on a map. Shipped robots drive at its ends as at the origin.
pub const MAP_REACH: Range = Range { least: -1e5, most: 1e5, unit: " m" };
/// Coordinates on a robot. USARSim's largest robots have a few metres; with a mass 10 km away the state is lost.
pub const ROBOT_REACH: Range = Range { least: -100.0, most: 100.0, unit: " m" };
/// Edges of solids on a map. What is thinner no robot would notice.
pub const MAP_SIZE: Range = Range { least: 1e-4, most: MAP_REACH.most, unit: " m" };
/// Edges of solids on a robot.
pub const ROBOT_SIZE: Range = Range { least: 1e-4, most: ROBOT_REACH.most, unit: " m" };
/// Height of a solid on a map. A robot put into a solid is lifted onto it if the surface is within 1000 m above, and
/// thrown out at any speed otherwise.
pub const SOLID_HEIGHT: Range = Range { least: 0.0, most: 900.0, unit: " m" };
/// Roll, pitch and yaw.
pub const ANGLE: Range = Range { least: -1000.0, most: 1000.0, unit: " rad" };
/// Gravity; the Moon has 1.6, Jupiter 25.
pub const GRAVITY: Range = Range { least: 0.0, most: 100.0, unit: " m/s²" };
/// Coulomb friction.
pub const FRICTION: Range = Range { least: 0.0, most: 10.0, unit: "" };
/// Restitution and rolling resistance, and the parts of a colour.
pub const SHARE: Range = Range { least: 0.0, most: 1.0, unit: "" };
/// Damping of a body; half of the highest stops it within a step.
pub const BODY_DAMPING: Range = Range { least: 0.0, most: 1000.0, unit: " 1/s" };
/// Mass of one part of a body; frames without a body of their own often weigh next to nothing.
pub const PART_MASS: Range = Range { least: 1e-9, most: 1e5, unit: " kg" };
/// Mass of a whole body or of an object.
pub const BODY_MASS: Range = Range { least: 1e-3, most: 1e5, unit: " kg" };
/// Mass of a wheel without its rollers, or of a caster. At 1e-10 kg the inverse of its inertia ends the state.
pub const WHEEL_MASS: Range = Range { least: 1e-3, most: 1e4, unit: " kg" };
/// Mass of a roller. At 1e-8 kg on a light robot the inverse of its inertia ends the state.
pub const ROLLER_MASS: Range = Range { least: 1e-4, most: 1e3, unit: " kg" };
/// Heaviest over lightest of body, wheels and rollers: found with an engine of 32 bits, and more than any robot has.
pub const MASS_RATIO: f64 = 1e5;
/// Moments and products of inertia: the heaviest part at the end of the longest robot.
pub const INERTIA: Range = Range { least: -1e9, most: 1e9, unit: " kg m²" };
/// A moment of inertia may be more than the sum of the other two by this part of itself: files round.
pub(super) const TRIANGLE_TOLERANCE: f64 = 0.01;
/// Least radius of gyration of a body over the distance to its farthest wheel. Boxes have 0.3 or more; at 0.001 a force
/// on a wheel turned a body of 1.2 t until its state was lost.
pub(super) const LEAST_GYRATION: f64 = 0.01;
/// Radius of a wheel; its crown alone stands out by 2 mm.
pub const WHEEL_RADIUS: Range = Range { least: 0.004, most: 10.0, unit: " m" };
/// Width of a wheel.
pub const WHEEL_WIDTH: Range = Range { least: 0.001, most: 20.0, unit: " m" };
/// Distance of a driven wheel from the middle of the robot, toward its side.
pub(super) const LEAST_OFFSET: f64 = 0.001;
/// Speed limit of a motor.
pub const MAX_SPEED: Range = Range { least: 1e-3, most: 1e3, unit: " rad/s" };
/// Speed of a driven wheel's rim, m/s: its speed limit times its radius. The fastest shipped robot has 2.4, a
/// model race car 20, a car on the road 40. From 20 on an impact may end the robot: its state becomes a fault.
pub const MAX_RIM_SPEED: f64 = 40.0;
/// Force with which all driven wheels together can push, over the robot's weight. Shipped robots have 0.7 to 21 (the
/// thesis's), real ones about 1. A robot with 300 threw itself over walls.
pub const MAX_PUSH: f64 = 100.0;
/// Gravity by which a push is judged, m/s²: a map may have another.
pub const EARTH_GRAVITY: f64 = 9.81;
/// Gain of a servo.
pub const GAIN: Range = Range { least: 1e-6, most: 1e6, unit: " N m s/rad" };
/// Stiffness of a servo of the position.
pub const STIFFNESS: Range = Range { least: 1e-6, most: 1e8, unit: " N m/rad" };
/// Viscous friction of a joint.
pub const JOINT_DAMPING: Range = Range { least: 0.0, most: 1e6, unit: " N m s/rad" };
/// Dry friction of a joint.
pub const JOINT_FRICTION: Range = Range { least: 0.0, most: 1e6, unit: " N m or N" };
/// How far a joint goes for each rad or m of the one that it follows.
pub const MULTIPLIER: Range = Range { least: -1000.0, most: 1000.0, unit: "" };
/// Ends of a joint.
pub const JOINT_LIMIT: Range = Range { least: -100.0, most: 100.0, unit: " rad or m" };
/// Torque limit of a motor; the thesis's is 10 000.
pub const MAX_TORQUE: Range = Range { least: 1e-6, most: 1e6, unit: " N m" };
/// Time constant of integral action: less than a step would be none.
pub const INTEGRAL_TIME: Range = Range { least: 1e-3, most: 1e3, unit: " s" };
/// Inertia of a rotor as felt at the wheel.
pub const ARMATURE: Range = Range { least: 0.0, most: 100.0, unit: " kg m²" };
/// Rollers of a wheel; with fewer than three it is not round.
pub const ROLLER_COUNT: Range = Range { least: 3.0, most: 32.0, unit: " rollers" };
/// Angle between the axes of roller and wheel, whatever its sign.
pub const ROLLER_ANGLE: Range = Range { least: 0.1, most: 1.5, unit: " rad, either sign" };
/// Least circle of the rollers' axes over the radius of the wheel; real ones have 0.6 to 0.9.
pub(super) const LEAST_AXIS_CIRCLE: f64 = 0.1;
/// Least radius of the end of a roller over that of the wheel: found with an engine of 32 bits.
pub(super) const LEAST_ROLLER_END: f64 = 1e-3;
/// Where the first roller sits: once around either way.
pub const FIRST_ROLLER: Range = Range { least: -7.0, most: 7.0, unit: " rad" };
/// Viscous friction of a roller's bearing.
pub const ROLLER_DAMPING: Range = Range { least: 0.0, most: 10.0, unit: " N m s/rad" };
/// Seconds between two readings, if there are any.
pub const SCAN_INTERVAL: Range = Range { least: 0.002, most: 3600.0, unit: " s" };
/// Greatest velocity of a robot in the air.
pub const FLIGHT_SPEED: Range = Range { least: 0.0, most: 100.0, unit: " m/s" };
/// Its greatest turn rate.
pub const FLIGHT_TURN: Range = Range { least: 0.0, most: 100.0, unit: " rad/s" };
/// How far it leans; upright has no heading.
pub const TILT: Range = Range { least: 0.0, most: 1.5, unit: " rad" };
/// Energy of a battery.
pub const BATTERY_ENERGY: Range = Range { least: 1e-3, most: 1e15, unit: " J" };
/// How long a battery lasts.
pub const BATTERY_LIFE: Range = Range { least: 1e-3, most: 1e9, unit: " s" };
/// The torque that CONF reports, in USARSim's unit.
pub const REPORTED_TORQUE: Range = Range { least: 0.0, most: 1e9, unit: "" };

/// Most classes of robots; a world holds as many robots.
pub(super) const MAX_ROBOTS: usize = 256;
/// Most solids of a map.
pub(super) const MAX_SOLIDS: usize = 10_000;
/// Most objects of a map: all of them move.
pub(super) const MAX_OBJECTS: usize = 1000;
/// Most start poses of a map and most path nodes: they go out in one line.
pub(super) const MAX_POSES: usize = 1000;
/// Most parts of a robot, and most solids of its body.
pub const MAX_PARTS: usize = 1000;
/// Most links of a robot, beside its rollers: a Nao has 25, and the cost of a step grows with the square of their number.
pub const MAX_LINKS: usize = 100;
/// Most wheels of a robot.
pub(super) const MAX_WHEELS: usize = 32;
/// Most rollers of a robot: the cost of a step grows with the square of their number.
pub(super) const MAX_ROLLERS: usize = 256;
/// Most sensors of a robot.
pub(super) const MAX_SENSORS: usize = 256;
/// Most rays that all sensors of a robot cast at once. A P2AT has 2757; so many are some 10 ms.
pub(super) const MAX_RAYS: usize = 20_000;
/// Most triangles of a mesh, and of all meshes of a map: 100 MB in the engine.
pub const MAX_TRIANGLES: usize = 1_000_000;
/// Triangles that are only seen of a robot: they are in every log and go to every page.
pub(super) const MAX_VISUAL_TRIANGLES: usize = 300_000;
/// Most corners of all hulls of a map or of a robot. A body stands on a handful of them.
pub const MAX_HULL_POINTS: usize = 10_000;
/// Least surface of a mesh, m²: a square of 0.1 mm.
pub(super) const LEAST_SURFACE: f64 = 1e-8;
/// Least volume of a hull, m³: a cube of 0.1 mm.
pub(super) const LEAST_VOLUME: f64 = 1e-12;
/// Most characters of a name.
pub(super) const MAX_NAME: usize = 256;
/// Most characters of a description or of a source.
pub(super) const MAX_TEXT: usize = 10_000;
