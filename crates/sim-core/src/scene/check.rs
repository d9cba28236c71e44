//! What a scene may hold: the range of every number, and the rules between them. Files and logs are held to the same.
//!
//! The engine never says that it cannot go on: where a mass is next to nothing every number of its robot is NaN after one
//! step. So ranges go far beyond any rescue robot and its arena, and end well before the engine does.
//! Where they end was tried: 1200 robots drawn at random from the ranges and their ends, on a plane of any friction and
//! gravity, in every drive model; none lost a finite state.

use std::fmt;

use nalgebra::{Matrix3, Vector3};

use super::{
    Battery, DriveModel, MapDef, Material, Motor, NamedPose, Object, Part, RobotDef, Rollers, SensorDef, Shape, Side,
    Solid, Steering, Wheel, WorldDef,
};
use crate::physics;

/// A range of numbers, its ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Its lower end.
    pub least: f64,
    /// Its upper end.
    pub most: f64,
    /// Unit of both with a space before it; empty for plain numbers.
    pub unit: &'static str,
}

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
const TRIANGLE_TOLERANCE: f64 = 0.01;
/// Least radius of gyration of a body over the distance to its farthest wheel. Boxes have 0.3 or more; at 0.001 a force
/// on a wheel turned a body of 1.2 t until its state was lost.
const LEAST_GYRATION: f64 = 0.01;
/// Radius of a wheel; its crown alone stands out by 2 mm.
pub const WHEEL_RADIUS: Range = Range { least: 0.004, most: 10.0, unit: " m" };
/// Width of a wheel.
pub const WHEEL_WIDTH: Range = Range { least: 0.001, most: 20.0, unit: " m" };
/// Distance of a driven wheel from the middle of the robot, toward its side.
const LEAST_OFFSET: f64 = 0.001;
/// Speed limit of a motor.
pub const MAX_SPEED: Range = Range { least: 1e-3, most: 1e3, unit: " rad/s" };
/// Gain of a servo.
pub const GAIN: Range = Range { least: 1e-6, most: 1e6, unit: " N m s/rad" };
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
const LEAST_AXIS_CIRCLE: f64 = 0.1;
/// Least radius of the end of a roller over that of the wheel: found with an engine of 32 bits.
const LEAST_ROLLER_END: f64 = 1e-3;
/// Where the first roller sits: once around either way.
pub const FIRST_ROLLER: Range = Range { least: -7.0, most: 7.0, unit: " rad" };
/// Viscous friction of a roller's bearing.
pub const ROLLER_DAMPING: Range = Range { least: 0.0, most: 10.0, unit: " N m s/rad" };
/// Seconds between two readings, if there are any.
pub const SCAN_INTERVAL: Range = Range { least: 0.002, most: 3600.0, unit: " s" };
/// Energy of a battery.
pub const BATTERY_ENERGY: Range = Range { least: 1e-3, most: 1e15, unit: " J" };
/// How long a battery lasts.
pub const BATTERY_LIFE: Range = Range { least: 1e-3, most: 1e9, unit: " s" };
/// The torque that CONF reports, in USARSim's unit.
pub const REPORTED_TORQUE: Range = Range { least: 0.0, most: 1e9, unit: "" };

/// Most classes of robots; a world holds as many robots.
const MAX_ROBOTS: usize = 256;
/// Most solids of a map.
const MAX_SOLIDS: usize = 10_000;
/// Most objects of a map: all of them move.
const MAX_OBJECTS: usize = 1000;
/// Most start poses of a map and most path nodes: they go out in one line.
const MAX_POSES: usize = 1000;
/// Most parts of a robot, and most solids of its body.
const MAX_PARTS: usize = 1000;
/// Most wheels of a robot.
const MAX_WHEELS: usize = 32;
/// Most rollers of a robot: the cost of a step grows with the square of their number.
const MAX_ROLLERS: usize = 256;
/// Most sensors of a robot.
const MAX_SENSORS: usize = 256;
/// Most rays that all sensors of a robot cast at once. A P2AT has 2757; so many are some 10 ms.
const MAX_RAYS: usize = 20_000;
/// Most triangles of a mesh, and of all meshes of a map: 100 MB in the engine.
pub const MAX_TRIANGLES: usize = 1_000_000;
/// Most corners of all hulls of a map or of a robot. A body stands on a handful of them.
pub const MAX_HULL_POINTS: usize = 10_000;
/// Least surface of a mesh, m²: a square of 0.1 mm.
const LEAST_SURFACE: f64 = 1e-8;
/// Least volume of a hull, m³: a cube of 0.1 mm.
const LEAST_VOLUME: f64 = 1e-12;
/// Most characters of a name.
const MAX_NAME: usize = 256;
/// Most characters of a description or of a source.
const MAX_TEXT: usize = 10_000;

/// What is wrong with a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneProblem {
    /// Where, as in `robot P3AT, wheel FLWheel`.
    pub place: String,
    /// What is wrong and what was expected.
    pub message: String,
}

impl fmt::Display for SceneProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)
    }
}

impl std::error::Error for SceneProblem {}

impl Range {
    /// What is wrong with a number, if anything is; `key` names it.
    pub fn problem(self, key: &str, value: f64) -> Option<String> {
        (!self.holds(value)).then(|| format!("`{key}` is {}: expected {self}", Number(value)))
    }

    /// What is wrong with one of several numbers.
    pub fn problem_in(self, key: &str, values: &[f64]) -> Option<String> {
        let all = || values.iter().map(|&value| Number(value).to_string()).collect::<Vec<_>>().join(", ");
        (!values.iter().all(|&value| self.holds(value)))
            .then(|| format!("`{key}` is [{}]: expected numbers of {self}", all()))
    }

    /// Whether a number is within it.
    pub fn holds(self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {}{}", Number(self.least), Number(self.most), self.unit)
    }
}

/// A number as it is best read: 1e300 has no 300 zeros.
struct Number(f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 {
            f.write_str("0")
        } else if (1e-4..1e7).contains(&size) {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

impl WorldDef {
    /// Checks everything that a world is made of: with what passes, no world panics or loses a finite state.
    ///
    /// # Errors
    /// The first number, name or count that a world cannot be made with.
    pub fn check(&self) -> Result<(), SceneProblem> {
        first("the scene", count("classes of robots", self.robots.len(), MAX_ROBOTS))?;
        check_map(&self.map)?;
        self.robots.values().try_for_each(check_robot)
    }
}

fn check_map(def: &MapDef) -> Result<(), SceneProblem> {
    first("the map", map(def))?;
    let solids = def.solids.iter().map(|it| (it, map_solid(it)));
    let objects = def.objects.iter().map(|it| (&it.solid, object(it)));
    for (it, wrong) in solids.chain(objects) {
        first(&format!("the map, solid {}", shown(&it.name)), wrong.into_iter().chain(material(&it.material)))?;
    }
    for pose in def.starts.iter().chain(&def.path_nodes) {
        first(&format!("the map, pose {}", shown(&pose.name)), named_pose(pose))?;
    }
    Ok(())
}

fn check_robot(def: &RobotDef) -> Result<(), SceneProblem> {
    let class = format!("robot {}", shown(&def.class));
    // Sums over parts come last: they need numbers.
    first(&class, counts(def))?;
    for it in &def.parts {
        first(&format!("{class}, part {}", shown(&it.name)), part(it))?;
    }
    for it in &def.solids {
        let wrong = body_solid(it).into_iter().chain(material(&it.material));
        first(&format!("{class}, solid {}", shown(&it.name)), wrong)?;
    }
    for it in &def.wheels {
        let materials = std::iter::once(&it.material).chain(it.rollers.iter().map(|rollers| &rollers.material));
        let rollers = it.rollers.iter().flat_map(|it_rollers| rollers(it_rollers, it.radius));
        let wrong = wheel(it).into_iter().chain(rollers).chain(materials.flat_map(material));
        first(&format!("{class}, wheel {}", shown(&it.name)), wrong)?;
    }
    for it in &def.sensors {
        first(&format!("{class}, sensor {}", shown(&it.name)), sensor(it))?;
    }
    first(&class, def.battery.iter().flat_map(battery))?;
    first(&class, robot(def))
}

fn first(place: &str, messages: impl IntoIterator<Item = String>) -> Result<(), SceneProblem> {
    let problem = |message| SceneProblem { place: place.to_owned(), message };
    messages.into_iter().next().map_or(Ok(()), |message| Err(problem(message)))
}

/// A name of a stranger's scene, for a message.
fn shown(name: &str) -> String {
    name.chars().take(60).flat_map(char::escape_debug).collect()
}

/// What is wrong with a map as a whole; its solids and poses are checked by themselves.
pub fn map(def: &MapDef) -> Vec<String> {
    let shapes = || def.solids.iter().chain(def.objects.iter().map(|object| &object.solid)).map(|solid| &solid.shape);
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(text("description", &def.description));
    wrong.extend(GRAVITY.problem("gravity", def.gravity));
    wrong.extend(count("solids", def.solids.len(), MAX_SOLIDS));
    wrong.extend(count("objects", def.objects.len(), MAX_OBJECTS));
    wrong.extend(count("start poses", def.starts.len(), MAX_POSES));
    wrong.extend(count("path nodes", def.path_nodes.len(), MAX_POSES));
    wrong.extend(count("triangles", shapes().map(triangles).sum(), MAX_TRIANGLES));
    wrong.extend(count("corners of hulls", shapes().map(hull_points).sum(), MAX_HULL_POINTS));
    wrong
}

/// What is wrong with a material.
pub fn material(def: &Material) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    for (range, key, value) in [
        (FRICTION, "friction", def.friction),
        (SHARE, "restitution", def.restitution),
        (SHARE, "rolling_resistance", def.rolling_resistance),
        (BODY_DAMPING, "linear_damping", def.linear_damping),
        (BODY_DAMPING, "angular_damping", def.angular_damping),
    ] {
        wrong.extend(range.problem(key, value));
    }
    wrong.extend(SHARE.problem_in("colour", &def.colour));
    wrong.extend(text("source", &def.source));
    wrong
}

/// What is wrong with a named place of a map.
pub fn named_pose(def: &NamedPose) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(MAP_REACH.problem_in("position", &def.position));
    wrong.extend(ANGLE.problem_in("rotation", &def.rotation));
    wrong
}

/// What is wrong with a solid of a map; its material is checked by itself.
pub fn map_solid(def: &Solid) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(solid(def, MAP_REACH, MAP_SIZE));
    if wrong.is_empty() {
        wrong.extend(height(def));
    }
    wrong
}

/// What is wrong with an object of a map; its material is checked by itself.
pub fn object(def: &Object) -> Vec<String> {
    let mut wrong = map_solid(&def.solid);
    if matches!(def.solid.shape, Shape::HalfSpace | Shape::Mesh { .. }) {
        wrong.push("a mass: expected a box, a cylinder, a ball or a hull".to_owned());
    }
    wrong.extend(BODY_MASS.problem("mass", def.mass));
    wrong
}

/// What is wrong with a solid of a robot's body; its material is checked by itself.
pub fn body_solid(def: &Solid) -> Vec<String> {
    let mut wrong = name("name", &def.name);
    wrong.extend(solid(def, ROBOT_REACH, ROBOT_SIZE));
    if matches!(def.shape, Shape::HalfSpace | Shape::Mesh { .. }) {
        wrong.push(
            "a shape without an end or without a volume: expected a box, a cylinder, a ball or a hull".to_owned(),
        );
    }
    wrong
}

fn solid(def: &Solid, reach: Range, size: Range) -> Vec<String> {
    let mut wrong: Vec<String> = reach.problem_in("position", &def.position).into_iter().collect();
    wrong.extend(ANGLE.problem_in("rotation", &def.rotation));
    wrong.extend(shape(&def.shape, reach, size));
    wrong
}

fn shape(shape: &Shape, reach: Range, size: Range) -> Vec<String> {
    match shape {
        Shape::HalfSpace => Vec::new(),
        Shape::Box { size: edges } => size.problem_in("size", edges).into_iter().collect(),
        Shape::Cylinder { radius, length } => {
            size.problem("radius", *radius).into_iter().chain(size.problem("length", *length)).collect()
        }
        Shape::Ball { radius } => size.problem("radius", *radius).into_iter().collect(),
        Shape::Hull { points } => {
            let far = corners(points, reach);
            let flat = far.is_none() && volume(points) < LEAST_VOLUME;
            let flat = flat.then(|| format!("a hull of {} points in one plane: expected a volume", points.len()));
            far.into_iter().chain(flat).collect()
        }
        Shape::Mesh { vertices, triangles } => mesh(vertices, triangles, reach),
    }
}

/// The first corner out of reach.
fn corners(points: &[[f64; 3]], reach: Range) -> Option<String> {
    points.iter().find_map(|point| reach.problem_in("corner", point))
}

/// Volume of the convex hull of some points, m³.
fn volume(points: &[[f64; 3]]) -> f64 {
    let Some(Shape::Mesh { vertices, triangles }) = physics::hull_surface(points) else { return 0.0 };
    let corner = |index: u32| Vector3::from(vertices[index as usize]) - Vector3::from(vertices[0]);
    let sixfold = |&[a, b, c]: &[u32; 3]| corner(a).cross(&corner(b)).dot(&corner(c));
    triangles.iter().map(sixfold).sum::<f64>().abs() / 6.0
}

fn mesh(vertices: &[[f64; 3]], triangles: &[[u32; 3]], reach: Range) -> Vec<String> {
    if let Some(far) = corners(vertices, reach) {
        return vec![far];
    }
    if let Some(index) = triangles.iter().flatten().find(|&&index| index as usize >= vertices.len()) {
        return vec![format!("a triangle has the corner {index}: expected less than {}", vertices.len())];
    }
    let corner = |index: u32| Vector3::from(vertices[index as usize]);
    let surface = |&[a, b, c]: &[u32; 3]| (corner(b) - corner(a)).cross(&(corner(c) - corner(a))).norm() / 2.0;
    let surface: f64 = triangles.iter().map(surface).sum();
    if surface < LEAST_SURFACE {
        let count = triangles.len();
        return vec![format!("a mesh of {count} triangles and {} m²: expected a surface", Number(surface))];
    }
    Vec::new()
}

/// From the lowest to the highest point of a solid as it stands.
fn height(def: &Solid) -> Option<String> {
    let turn = def.pose().rotation;
    let down = turn.inverse() * Vector3::z();
    let height = match &def.shape {
        Shape::HalfSpace | Shape::Mesh { .. } => return None,
        Shape::Box { size } => Vector3::from(*size).dot(&down.abs()),
        Shape::Cylinder { radius, length } => length * down.z.abs() + 2.0 * radius * down.x.hypot(down.y),
        Shape::Ball { radius } => 2.0 * radius,
        Shape::Hull { points } => {
            let depths = || points.iter().map(|point| Vector3::from(*point).dot(&down));
            depths().fold(f64::MIN, f64::max) - depths().fold(f64::MAX, f64::min)
        }
    };
    SOLID_HEIGHT.problem("height", height)
}

fn triangles(shape: &Shape) -> usize {
    if let Shape::Mesh { vertices, triangles } = shape { triangles.len().max(vertices.len()) } else { 0 }
}

fn hull_points(shape: &Shape) -> usize {
    if let Shape::Hull { points } = shape { points.len() } else { 0 }
}

/// What is wrong with a part of a robot's body.
pub fn part(def: &Part) -> Vec<String> {
    let mut wrong = name("name", &def.name);
    wrong.extend(PART_MASS.problem("mass", def.mass));
    wrong.extend(ROBOT_REACH.problem_in("centre", def.centre.as_slice()));
    wrong.extend(inertia(&def.inertia));
    wrong
}

/// A moment of inertia sums the squares of two coordinates over the mass, so none is more than the other two together.
fn inertia(def: &Matrix3<f64>) -> Option<String> {
    if let Some(wrong) = INERTIA.problem_in("inertia", def.as_slice()) {
        return Some(wrong);
    }
    let size = def.amax();
    if (def - def.transpose()).amax() > 1e-9 * size {
        return Some("`inertia` is not symmetric: expected the same product of inertia for x y and y x".to_owned());
    }
    let [least, middle, most] = principal_moments(def);
    if least > 0.0 && least + middle >= most * (1.0 - TRIANGLE_TOLERANCE) {
        return None;
    }
    let [least, middle, most] = [least, middle, most].map(Number);
    let expected = "expected three above 0, none more than the other two together";
    Some(format!("`inertia` has the principal moments {least}, {middle} and {most} kg m²: {expected}"))
}

/// Principal moments of an inertia, the least first.
fn principal_moments(inertia: &Matrix3<f64>) -> [f64; 3] {
    // So small moments are not lost in squares.
    let size = inertia.amax().max(f64::MIN_POSITIVE);
    let mut moments: [f64; 3] = (inertia / size).symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    // What rounding leaves of a moment that is zero.
    moments.map(|moment| if moment.abs() < 1e-12 { 0.0 } else { moment * size })
}

/// What is wrong with a wheel or a caster; its materials are checked by themselves, and what its rollers share with those
/// of other wheels.
pub fn wheel(def: &Wheel) -> Vec<String> {
    let mut wrong = name("name", &def.name);
    wrong.extend(ROBOT_REACH.problem_in("position", &def.position));
    for (range, key, value) in
        [(WHEEL_RADIUS, "radius", def.radius), (WHEEL_WIDTH, "width", def.width), (WHEEL_MASS, "mass", def.mass)]
    {
        wrong.extend(range.problem(key, value));
    }
    let (side, sign) = match def.side {
        Side::Left => ("left", -1.0),
        Side::Right => ("right", 1.0),
    };
    // Odometry and Mecanum kinematics divide by the distance between the sides.
    let outward = Range { least: LEAST_OFFSET, ..ROBOT_REACH };
    if def.drive.is_some() && !outward.holds(def.position[1] * sign) {
        let beyond = if sign < 0.0 { "less" } else { "more" };
        let expected =
            format!("expected {} m or {beyond} of a {side} wheel, as y is to the right", sign * LEAST_OFFSET);
        wrong.push(format!("`position` has y {}: {expected}", Number(def.position[1])));
    }
    wrong.extend(def.drive.iter().flat_map(motor));
    if let Some(rollers) = &def.rollers {
        if !ROLLER_ANGLE.holds(rollers.angle.abs()) {
            wrong.push(format!("`roller_angle` is {}: expected {ROLLER_ANGLE}", Number(rollers.angle)));
        }
        wrong.extend(FIRST_ROLLER.problem("first_roller", rollers.first_roller));
    }
    if def.drive.is_none() && def.rollers.is_some() {
        wrong.push("a caster with rollers: expected a ball".to_owned());
    }
    wrong
}

fn motor(def: &Motor) -> Vec<String> {
    let mut wrong = Vec::new();
    for (range, key, value) in [
        (MAX_SPEED, "max_speed", Some(def.max_speed)),
        (GAIN, "gain", Some(def.gain)),
        (MAX_TORQUE, "max_torque", Some(def.max_torque)),
        (INTEGRAL_TIME, "integral_time", def.integral_time),
        (ARMATURE, "armature", Some(def.armature)),
    ] {
        wrong.extend(value.and_then(|value| range.problem(key, value)));
    }
    wrong
}

/// What is wrong with the rollers of a wheel of a good radius; their material is checked by itself.
pub fn rollers(def: &Rollers, wheel_radius: f64) -> Vec<String> {
    let mut wrong = Vec::new();
    for (range, key, value) in [
        (ROLLER_COUNT, "count", f64::from(def.count)),
        (ROLLER_MASS, "mass", def.mass),
        (ROLLER_DAMPING, "damping", def.damping),
    ] {
        wrong.extend(range.problem(key, value));
    }
    // At the ends the axis is farthest out; the roller must still be inside the wheel there.
    let least_phase = std::f64::consts::PI / f64::from(def.count.max(3));
    let (least, outermost) = (LEAST_AXIS_CIRCLE * wheel_radius, (1.0 - LEAST_ROLLER_END) * wheel_radius);
    let most = outermost * least_phase.cos();
    if !(least..=most).contains(&def.axis_circle) {
        let got = Number(def.axis_circle);
        wrong.push(format!("`axis_circle` is {got}: expected {least:.4} to {most:.4} m"));
    }
    let most_phase = (def.axis_circle / outermost).acos();
    if wrong.is_empty() && !(least_phase * (1.0 - 1e-9)..=most_phase * (1.0 + 1e-9)).contains(&def.last_phase) {
        let got = Number(def.last_phase);
        wrong.push(format!("`last_phase` is {got}: expected {least_phase:.4} to {most_phase:.4} rad"));
    }
    wrong
}

/// What is wrong with a sensor.
pub fn sensor(def: &SensorDef) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(ROBOT_REACH.problem_in("position", &def.position));
    wrong.extend(ANGLE.problem_in("direction", &def.direction));
    if def.scan_interval != 0.0 && !SCAN_INTERVAL.holds(def.scan_interval) {
        let got = Number(def.scan_interval);
        wrong.push(format!("`scan_interval` is {got}: expected 0 or {SCAN_INTERVAL}"));
    }
    wrong.extend(def.config.validate().err().map(|expected| format!("sensor {}: expected {expected}", def.name)));
    wrong
}

/// What is wrong with a battery.
pub fn battery(def: &Battery) -> Vec<String> {
    let energy = BATTERY_ENERGY.problem("max_energy", def.max_energy);
    energy.into_iter().chain(BATTERY_LIFE.problem("life", def.life)).collect()
}

fn counts(def: &RobotDef) -> Vec<String> {
    let rays = def.sensors.iter().map(|sensor| sensor.config.rays()).fold(0, usize::saturating_add);
    let mut wrong = wire_name("class", &def.class);
    wrong.extend(text("description", &def.description));
    wrong.extend(count("parts", def.parts.len(), MAX_PARTS));
    wrong.extend(count("solids", def.solids.len(), MAX_PARTS));
    wrong.extend(count("wheels", def.wheels.len(), MAX_WHEELS));
    wrong.extend(count("rollers", def.wheels.iter().map(Wheel::roller_count).sum(), MAX_ROLLERS));
    wrong.extend(count("sensors", def.sensors.len(), MAX_SENSORS));
    wrong.extend(count("corners of hulls", def.solids.iter().map(|it| hull_points(&it.shape)).sum(), MAX_HULL_POINTS));
    wrong.extend(count("rays", rays, MAX_RAYS));
    wrong
}

/// What is wrong with a robot as a whole; its parts, solids, wheels, sensors and battery are checked by themselves, and
/// have to be right.
pub fn robot(def: &RobotDef) -> Vec<String> {
    let mut wrong = counts(def);
    wrong.extend(REPORTED_TORQUE.problem("reported_max_torque", def.reported_max_torque));
    if def.parts.is_empty() {
        wrong.push("no part: expected at least one with a mass".to_owned());
    }
    if def.driven().is_empty() {
        wrong.push("no driven wheel: expected at least one".to_owned());
    }
    if def.wheels.iter().filter(|wheel| wheel.drive.is_some()).count() != def.driven().len() {
        wrong.push("a driven wheel behind a caster: expected driven wheels first".to_owned());
    }
    wrong.extend(omni(def));
    if wrong.is_empty() {
        wrong.extend(masses(def));
    }
    wrong
}

/// An omni base has four wheels with rollers in a fixed order, as its kinematics and its encoders count them.
fn omni(def: &RobotDef) -> Option<String> {
    const ORDER: [(f64, Side, f64); 4] =
        [(1.0, Side::Left, 1.0), (1.0, Side::Right, -1.0), (-1.0, Side::Left, -1.0), (-1.0, Side::Right, 1.0)];
    if def.steering != Steering::Omni {
        let bodies = def.drive_model == DriveModel::Bodies;
        return (!bodies).then(|| "`drive_model` other than \"bodies\": expected steering \"omni\"".to_owned());
    }
    let fits = |(wheel, (front, side, angle)): (&Wheel, (f64, Side, f64))| {
        wheel.position[0] * front >= LEAST_OFFSET
            && wheel.side == side
            && wheel.rollers.as_ref().is_some_and(|rollers| rollers.angle * angle > 0.0)
    };
    let good = def.driven().len() == 4 && def.driven().iter().zip(ORDER).all(fits);
    let expected = "expected four wheels front left, front right, back left, back right with `roller_angle` +, -, -, +";
    (!good).then(|| format!("steering \"omni\": {expected}"))
}

fn masses(def: &RobotDef) -> Vec<String> {
    let body = physics::body_mass(def);
    let rollers = def.wheels.iter().filter_map(|wheel| wheel.rollers.as_ref()).map(|rollers| rollers.mass);
    let masses = || std::iter::once(body.mass).chain(def.wheels.iter().map(|wheel| wheel.mass)).chain(rollers.clone());
    let (least, most) = (masses().fold(f64::MAX, f64::min), masses().fold(0.0, f64::max));
    let mut wrong: Vec<String> = BODY_MASS.problem("mass of the body", body.mass).into_iter().collect();
    if most > least * MASS_RATIO {
        let (least, most) = (Number(least), Number(most));
        wrong.push(format!(
            "its body, wheels and rollers weigh {least} to {most} kg: expected at most {MASS_RATIO} times the lightest"
        ));
    }
    let farthest =
        def.wheels.iter().map(|wheel| (Vector3::from(wheel.position) - body.centre).norm()).fold(0.0, f64::max);
    let [moment, ..] = principal_moments(&body.inertia);
    let (gyration, least) = ((moment / body.mass).max(0.0).sqrt(), LEAST_GYRATION * farthest);
    if !(least..=ROBOT_SIZE.most).contains(&gyration) {
        let expected = format!("{least:.6} (a hundredth of the way to its farthest wheel) to {} m", ROBOT_SIZE.most);
        wrong.push(format!("its body's radius of gyration is {gyration:.6} m: expected {expected}"));
    }
    wrong
}

fn count(what: &str, got: usize, most: usize) -> Option<String> {
    (got > most).then(|| format!("{got} {what}: expected at most {most}"))
}

fn text(key: &str, got: &str) -> Option<String> {
    let length = got.chars().count();
    (length > MAX_TEXT).then(|| format!("`{key}` has {length} characters: expected at most {MAX_TEXT}"))
}

/// A name that is only shown.
fn name(key: &str, got: &str) -> Vec<String> {
    let length = got.chars().count();
    let good = (1..=MAX_NAME).contains(&length) && !got.contains(char::is_control);
    let problem = || format!("{key} `{}`: expected 1 to {MAX_NAME} characters, none of control", shown(got));
    (!good).then(problem).into_iter().collect()
}

/// A name that is sent on the wire.
fn wire_name(key: &str, got: &str) -> Vec<String> {
    let length = got.chars().count();
    let apart = |c: char| c.is_whitespace() || c.is_control() || c == '{' || c == '}';
    let good = (1..=MAX_NAME).contains(&length) && !got.contains(apart);
    let problem = || format!("{key} `{}`: expected a name without spaces and braces", shown(got));
    (!good).then(problem).into_iter().collect()
}
