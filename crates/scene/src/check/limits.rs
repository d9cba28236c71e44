//! Ranges of numbers and limits of counts.

use super::Range;

/// Length of a time step of a world.
pub const TIME_STEP: Range = Range { least: 1e-4, most: 0.02, unit: " s" };
/// Unit of wheel speeds on the wire: 1 for rad/s, 2 pi for revolutions a second.
pub const SPEED_UNIT: Range = Range { least: 0.01, most: 100.0, unit: " rad/s" };
/// Coordinates on a map. The shipped robots drive at its ends as they do at the origin.
pub const MAP_REACH: Range = Range { least: -1e5, most: 1e5, unit: " m" };
/// Coordinates on a robot. USARSim's largest robots measure a few metres; with a mass 10 km away the state is lost.
pub const ROBOT_REACH: Range = Range { least: -100.0, most: 100.0, unit: " m" };
/// Edges of solids on a map. Thinner solids do not affect a robot.
pub const MAP_SIZE: Range = Range { least: 1e-4, most: MAP_REACH.most, unit: " m" };
/// Edges of solids on a robot.
pub const ROBOT_SIZE: Range = Range { least: 1e-4, most: ROBOT_REACH.most, unit: " m" };
/// Height of a solid on a map. A robot spawned inside a solid is lifted onto it if the surface is within 1000 m above. Otherwise it
/// is thrown out at any speed.
pub const SOLID_HEIGHT: Range = Range { least: 0.0, most: 900.0, unit: " m" };
/// Heights of a height field above its own plane.
pub const FIELD_HEIGHT: Range = Range { least: -450.0, most: 450.0, unit: " m" };
/// Roll, pitch and yaw.
pub const ANGLE: Range = Range { least: -1000.0, most: 1000.0, unit: " rad" };
/// Speed at which a visual turns.
pub const SPIN: Range = Range { least: -1000.0, most: 1000.0, unit: " rad/s" };
/// Distance at which a tool changer takes a tool.
pub const TOOL_DISTANCE: Range = Range { least: 0.0, most: 10.0, unit: " m" };
/// Distance over which a vacuum sucks.
pub const SUCTION: Range = Range { least: 0.0, most: 1.0, unit: " m" };
/// Weight that a vacuum carries.
pub const SUCTION_FORCE: Range = Range { least: 0.0, most: 1e6, unit: " N" };
/// Angle at which a tool changer takes a tool.
pub const TOOL_ANGLE: Range = Range { least: 0.0, most: std::f64::consts::PI, unit: " rad" };
/// Gravity; the Moon has 1.6, Jupiter 25.
pub const GRAVITY: Range = Range { least: 0.0, most: 100.0, unit: " m/s²" };
/// Density of smoke; USARSim's rooms have 0.5 to 1.
pub const SMOKE_DENSITY: Range = Range { least: 0.0, most: 1000.0, unit: " 1/m" };
/// Duration of a sound, and time between two of them.
pub const SOUND_TIME: Range = Range { least: 0.01, most: 3600.0, unit: " s" };
/// Latitudes of an origin.
pub const LATITUDE: Range = Range { least: -89.0, most: 89.0, unit: " degrees" };
/// Longitudes of an origin.
pub const LONGITUDE: Range = Range { least: -180.0, most: 180.0, unit: " degrees" };
/// Velocity of a conveyor along each axis. USARSim's run at 0.24 m/s.
pub const CONVEYOR_SPEED: Range = Range { least: -10.0, most: 10.0, unit: " m/s" };
/// Coulomb friction.
pub const FRICTION: Range = Range { least: 0.0, most: 10.0, unit: "" };
/// Restitution, rolling resistance, and the components of a colour.
pub const SHARE: Range = Range { least: 0.0, most: 1.0, unit: "" };
/// Damping of a body; half of the maximum stops it within a step.
pub const BODY_DAMPING: Range = Range { least: 0.0, most: 1000.0, unit: " 1/s" };
/// Mass of one part of a body. Frames without a body of their own often have almost no mass.
pub const PART_MASS: Range = Range { least: 1e-9, most: 1e5, unit: " kg" };
/// Mass of a whole body or of an object.
pub const BODY_MASS: Range = Range { least: 1e-3, most: 1e5, unit: " kg" };
/// Mass of a wheel without its rollers, or of a caster. At 1e-10 kg the inverse of its inertia destroys the state.
pub const WHEEL_MASS: Range = Range { least: 1e-3, most: 1e4, unit: " kg" };
/// Mass of a roller. At 1e-8 kg on a light robot the inverse of its inertia destroys the state.
pub const ROLLER_MASS: Range = Range { least: 1e-4, most: 1e3, unit: " kg" };
/// Greatest ratio of masses among body, wheels and rollers: found with an engine of 32 bits, and more than any robot has.
pub const MASS_RATIO: f64 = 1e5;
/// Moments and products of inertia: the end of the range is the heaviest part at the end of the longest robot.
pub const INERTIA: Range = Range { least: -1e9, most: 1e9, unit: " kg m²" };
/// Fraction by which a moment of inertia may exceed the sum of the other two, as files round.
pub(super) const TRIANGLE_TOLERANCE: f64 = 0.01;
/// Least radius of gyration of a body over the distance to its farthest wheel. Boxes have 0.3 or more. At 0.001 a force on a wheel
/// turned a body of 1.2 t until its state was lost.
pub(super) const LEAST_GYRATION: f64 = 0.01;
/// Radius of a wheel; its crown alone protrudes by 2 mm.
pub const WHEEL_RADIUS: Range = Range { least: 0.004, most: 10.0, unit: " m" };
/// Slip stiffness of a tyre: force over load and slip. Tyres have 3 to 30, and a rigid disc has no limit.
pub const SLIP_STIFFNESS: Range = Range { least: 1.0, most: 1e4, unit: "" };
/// Friction of a tyre along or across over that of the materials.
pub const FRICTION_RATIO: Range = Range { least: 0.1, most: 10.0, unit: "" };
/// Way on which a tyre's force follows a change of slip.
pub const RELAXATION: Range = Range { least: 1e-3, most: 1.0, unit: " m" };
/// Least half length and half width of a contact patch, m.
pub(super) const LEAST_PATCH: f64 = 1e-3;
/// Width of a wheel.
pub const WHEEL_WIDTH: Range = Range { least: 0.001, most: 20.0, unit: " m" };
/// Least distance of a driven wheel from the middle of the robot, toward its side, and of a Mecanum wheel toward its end.
pub(crate) const LEAST_OFFSET: f64 = 0.001;
/// Speed limit of a motor.
pub const MAX_SPEED: Range = Range { least: 1e-3, most: 1e3, unit: " rad/s" };
/// Greatest speed of a driven wheel's rim, m/s: its speed limit times its radius. The fastest shipped robot has 2.4, a model race
/// car 20, a car on the road 40. From 20 on, an impact may end the robot: its state becomes a fault.
pub const MAX_RIM_SPEED: f64 = 40.0;
/// Greatest force with which all driven wheels together can push, over the robot's weight. Shipped robots have 0.7 to 21 (the
/// thesis's), real ones about 1. A robot with 300 threw itself over walls.
pub const MAX_PUSH: f64 = 100.0;
/// Gravity for the limit of the push, m/s²; a map may have another.
pub const EARTH_GRAVITY: f64 = 9.81;
/// Gain of a servo.
pub const GAIN: Range = Range { least: 1e-6, most: 1e6, unit: " N m s/rad" };
/// Stiffness of a position servo.
pub const STIFFNESS: Range = Range { least: 1e-6, most: 1e8, unit: " N m/rad" };
/// Viscous friction of a joint.
pub const JOINT_DAMPING: Range = Range { least: 0.0, most: 1e6, unit: " N m s/rad" };
/// Dry friction of a joint.
pub const JOINT_FRICTION: Range = Range { least: 0.0, most: 1e6, unit: " N m or N" };
/// Travel of a coupled joint for each rad or m of its leader.
pub const MULTIPLIER: Range = Range { least: -1000.0, most: 1000.0, unit: "" };
/// Limits of a joint's position.
pub const JOINT_LIMIT: Range = Range { least: -100.0, most: 100.0, unit: " rad or m" };
/// Torque limit of a motor; the thesis's is 10 000.
pub const MAX_TORQUE: Range = Range { least: 1e-6, most: 1e6, unit: " N m" };
/// Time constant of integral action. One shorter than a step would have no effect.
pub const INTEGRAL_TIME: Range = Range { least: 1e-3, most: 1e3, unit: " s" };
/// Inertia of a rotor as felt at the wheel.
pub const ARMATURE: Range = Range { least: 0.0, most: 100.0, unit: " kg m²" };
/// Number of rollers on a wheel; with fewer than three it is not round.
pub const ROLLER_COUNT: Range = Range { least: 3.0, most: 32.0, unit: " rollers" };
/// Number of rollers in a belt.
pub const BELT_ROLLERS: Range = Range { least: 1.0, most: 16.0, unit: " rollers" };
/// Angle between the axes of roller and wheel, of either sign.
pub const ROLLER_ANGLE: Range = Range { least: 0.1, most: 1.5, unit: " rad, either sign" };
/// Least radius of the circle of roller axes over the radius of the wheel; real ones have 0.6 to 0.9.
pub(super) const LEAST_AXIS_CIRCLE: f64 = 0.1;
/// Least radius of the end of a roller over that of the wheel: found with an engine of 32 bits.
pub(super) const LEAST_ROLLER_END: f64 = 1e-3;
/// Angle of the first roller: once around either way.
pub const FIRST_ROLLER: Range = Range { least: -7.0, most: 7.0, unit: " rad" };
/// Viscous friction of a roller's bearing.
pub const ROLLER_DAMPING: Range = Range { least: 0.0, most: 10.0, unit: " N m s/rad" };
/// Time between two readings, if there are any.
pub const SCAN_INTERVAL: Range = Range { least: 0.002, most: 3600.0, unit: " s" };
/// Greatest velocity of a flying robot.
pub const FLIGHT_SPEED: Range = Range { least: 0.0, most: 100.0, unit: " m/s" };
/// Greatest turn rate of a flying robot.
pub const FLIGHT_TURN: Range = Range { least: 0.0, most: 100.0, unit: " rad/s" };
/// Greatest lean of a flying robot. It ends below pi/2, where the robot has no heading.
pub const TILT: Range = Range { least: 0.0, most: 1.5, unit: " rad" };
/// Energy of a battery.
pub const BATTERY_ENERGY: Range = Range { least: 1e-3, most: 1e15, unit: " J" };
/// Time from full to empty of a battery.
pub const BATTERY_LIFE: Range = Range { least: 1e-3, most: 1e9, unit: " s" };
/// Torque that CONF reports, in USARSim's unit.
pub const REPORTED_TORQUE: Range = Range { least: 0.0, most: 1e9, unit: "" };

/// Maximum number of robot classes; a world holds the same number of robots.
pub(super) const MAX_ROBOTS: usize = 256;
/// Maximum number of solids of a map.
pub const MAX_SOLIDS: usize = 10_000;
/// Maximum number of objects of a map; all of them move.
pub const MAX_OBJECTS: usize = 1000;
/// Maximum number of start poses of a map, and of path nodes; each list is sent in one line.
pub(super) const MAX_POSES: usize = 1000;
/// Maximum number of RFID tags, those that robots release included.
pub const MAX_TAGS: usize = 1000;
/// Maximum number of boxes of smoke; each laser beam is compared with all.
pub(super) const MAX_SMOKE: usize = 64;
/// Maximum number of parts of a robot, and of solids of its body.
pub const MAX_PARTS: usize = 1000;
/// Maximum number of links of a robot without its rollers. A Nao has 25, a Tiago with two hands 106; the cost of a step grows with the square of the number.
pub const MAX_LINKS: usize = 150;
/// Maximum number of wheels of a robot.
pub(super) const MAX_WHEELS: usize = 32;
/// Maximum number of rollers of a robot; the cost of a step grows with the square of the number.
pub(super) const MAX_ROLLERS: usize = 256;
/// Maximum number of sensors of a robot.
pub(super) const MAX_SENSORS: usize = 256;
pub(super) const MAX_TOOL_CHANGERS: usize = 16;
/// Maximum number of rays that all sensors of a robot cast at once. A P2AT has 2757; 20 000 take some 10 ms.
pub(super) const MAX_RAYS: usize = 20_000;
/// Maximum number of triangles of a mesh, and of all meshes of a map: 100 MB in the engine.
pub const MAX_TRIANGLES: usize = 1_000_000;
/// Maximum number of visual-only triangles of a robot; every log and every page contains them.
pub(super) const MAX_VISUAL_TRIANGLES: usize = 300_000;
/// Maximum number of corners of all hulls of a map or of a robot. A body stands on a handful of them.
pub const MAX_HULL_POINTS: usize = 10_000;
/// Least surface of a mesh, m²: a square of 0.1 mm.
pub(super) const LEAST_SURFACE: f64 = 1e-8;
/// Least volume of a hull, m³: a cube of 0.1 mm.
pub(super) const LEAST_VOLUME: f64 = 1e-12;
/// Maximum number of characters of a name.
pub const MAX_NAME: usize = 256;
/// Maximum number of characters of a description or of a source.
pub(super) const MAX_TEXT: usize = 10_000;
/// Duration of a league, and of a stay in it. A day is longer than any round.
pub const LEAGUE_TIME: Range = Range { least: 0.01, most: 86_400.0, unit: " s" };
/// Distance from which a victim is found.
pub const SIGHT: Range = Range { least: 0.01, most: 100.0, unit: " m" };
/// Points for one event.
pub const POINTS: Range = Range { least: -1e6, most: 1e6, unit: "" };
/// Most teams of a league.
pub const MAX_TEAMS: usize = 16;
/// Most start poses of a team.
pub const MAX_STARTS: usize = 16;
/// Most goals of a league.
pub const MAX_GOALS: usize = 256;
/// Coordinates of goals.
pub const GOAL_REACH: Range = Range { least: -1000.0, most: 1000.0, unit: " m" };
/// Distance at which a goal is reached.
pub const TOLERANCE: Range = Range { least: 1e-3, most: 100.0, unit: " m" };
/// Distance beside a path, and between the points of it that a robot observes.
pub const PATH_WIDTH: Range = Range { least: 0.01, most: 100.0, unit: " m" };
/// Edge of a cell of an explored area.
pub const CELL: Range = Range { least: 0.01, most: 10.0, unit: " m" };
/// Most points of a path.
pub const MAX_PATH_POINTS: usize = 1000;
/// Most cells of an explored area.
pub const MAX_CELLS: f64 = 1e6;
/// Most points of all paths of a league: each robot has its own.
pub const MAX_LEAGUE_POINTS: usize = 10_000;
/// Most cells of all explored areas of a league: each robot remembers what it has seen.
pub const MAX_LEAGUE_CELLS: f64 = 1e5;
/// Longest sight of an explored area of a league, in cells: a beam is looked at in steps of half a cell.
pub const MAX_LEAGUE_SIGHT: f64 = 1000.0;
