//! Checks of robots.

use nalgebra::{Matrix3, Vector3};

use super::limits::*;
use super::map::{material, object};
use super::shape::{hull_points, shape, solid, triangles};
use super::{Number, Range, SceneProblem, count, first, name, shown, text, wire_name};
use crate::{
    Actuator, Aerial, Battery, Belt, Coupling, CouplingKind, Drivetrain, Gripper, Joint, JointKind, Link, Motor,
    MountedWheel, Part, RobotDef, Rollers, SensorDef, Shape, Side, Solid, Steering, Tool, ToolChanger, Tyre, Vacuum,
    Visual, WHEEL_AXIS, Wheel,
};

/// Checks a whole class.
///
/// # Errors
/// The first number outside the limits, and its place.
pub fn check_robot(def: &RobotDef) -> Result<(), SceneProblem> {
    let class = format!("robot {}", shown(&def.class));
    // Sums over parts come last, as they need valid numbers.
    first(&class, counts(def))?;
    for (number, it) in def.links.iter().enumerate() {
        first(&format!("{class}, link {}", shown(&it.name)), link(it, number))?;
    }
    for it in def.links.iter().flat_map(|link| &link.parts) {
        first(&format!("{class}, part {}", shown(&it.name)), part(it))?;
    }
    for it in def.links.iter().flat_map(|link| &link.solids) {
        let wrong = body_solid(it).into_iter().chain(material(&it.material));
        first(&format!("{class}, solid {}", shown(&it.name)), wrong)?;
    }
    for (link, it) in def.links.iter().flat_map(|link| link.visuals.iter().map(move |it| (link, it))) {
        first(&format!("{class}, visual of {}", shown(&link.name)), visual(it))?;
    }
    for it in def.wheels() {
        let materials = std::iter::once(&it.material).chain(it.rollers.iter().map(|rollers| &rollers.material));
        let rollers = it.rollers.iter().flat_map(|it_rollers| rollers(it_rollers, it.radius));
        let wrong = wheel(&it).into_iter().chain(rollers).chain(materials.flat_map(material));
        first(&format!("{class}, wheel {}", shown(it.name)), wrong)?;
    }
    for it in &def.sensors {
        first(&format!("{class}, sensor {}", shown(&it.name)), sensor(it))?;
    }
    first(&class, def.actuators.iter().flat_map(|it| actuator(it, &def.links)))?;
    first(&class, def.grippers.iter().flat_map(|it| gripper(it, &def.links)))?;
    first(&class, def.tool_changers.iter().flat_map(|it| tool_changer(it, &def.links)))?;
    first(&class, def.vacuums.iter().flat_map(|it| vacuum(it, &def.links)))?;
    let tools = def.tool_changers.iter().filter_map(|it| it.tool.as_ref());
    first(&class, tools.flat_map(|tool| material(&tool.object.solid.material)))?;
    first(&class, def.battery.iter().flat_map(battery))?;
    first(&class, def.footing.aerial().iter().flat_map(aerial))?;
    first(&class, robot(def))
}

/// Lists the problems of a solid of a robot's body; its material has its own check.
pub fn body_solid(def: &Solid) -> Vec<String> {
    let mut wrong = name("name", &def.name);
    wrong.extend(solid(def, ROBOT_REACH, ROBOT_SIZE));
    if matches!(def.shape, Shape::HalfSpace | Shape::Mesh { .. } | Shape::HeightField(_)) {
        wrong.push(
            "a shape without an end or without a volume: expected a box, a cylinder, a ball or a hull".to_owned(),
        );
    }
    wrong
}

/// Lists the problems of a visual of a link.
pub fn visual(def: &Visual) -> Vec<String> {
    let mut wrong: Vec<String> = ROBOT_REACH.problem_in("position", &def.position).into_iter().collect();
    wrong.extend(ANGLE.problem_in("rotation", &def.rotation));
    wrong.extend(SHARE.problem_in("colour", &def.colour));
    wrong.extend(SPIN.problem("spin", def.spin));
    wrong.extend(shape(&def.shape, ROBOT_REACH, ROBOT_SIZE));
    if def.shape == Shape::HalfSpace {
        wrong.push("a shape without an end: expected one with an end".to_owned());
    }
    wrong
}

/// Lists the problems of the link with this number; its parts, solids and wheel have their own checks.
pub fn link(def: &Link, number: usize) -> Vec<String> {
    let mut wrong = name("name", &def.name);
    match &def.joint {
        None if number > 0 => wrong.push("no joint: expected one to a parent".to_owned()),
        Some(_) if number == 0 => wrong.push("a joint: expected none of the first link, which is the root".to_owned()),
        Some(joint) => wrong.extend(self::joint(joint, number, def.wheel.as_ref())),
        None => {}
    }
    if number > 0 && def.parts.is_empty() == def.wheel.is_none() {
        wrong.push("expected at least one part with a mass, or a wheel without other parts".to_owned());
    }
    wrong
}

/// Lists the problems of a link's joint. The check of a wheel covers the position and the motor of its joint.
fn joint(def: &Joint, number: usize, of_wheel: Option<&Wheel>) -> Vec<String> {
    let mut wrong = Vec::new();
    if def.parent >= number {
        wrong.push(format!("its parent is link {}: expected one of the {number} before it", def.parent));
    }
    let length = Vector3::from(def.axis).norm();
    if (length - 1.0).abs() > 1e-6 || length.is_nan() {
        wrong.push(format!("`axis` has the length {}: expected 1", Number(length)));
    }
    wrong.extend(JOINT_DAMPING.problem("damping", def.damping));
    wrong.extend(JOINT_FRICTION.problem("friction", def.friction));
    if let Some(Coupling { multiplier, offset, kind, .. }) = def.coupling {
        wrong.extend(MULTIPLIER.problem("multiplier", multiplier));
        wrong.extend(JOINT_LIMIT.problem("offset", offset));
        let servo = def.drive.as_ref().is_some_and(|motor| motor.stiffness.is_some());
        match kind {
            CouplingKind::Mimic if def.drive.is_some() => {
                wrong.push("a motor of a joint that is moved by another: expected none".to_owned());
            }
            CouplingKind::Target if !servo => {
                wrong.push("a joint that follows a target: expected a motor with a `stiffness`".to_owned());
            }
            CouplingKind::Mimic | CouplingKind::Target => {}
        }
    }
    if let Some(wheel) = of_wheel {
        if def.kind != wheel.joint_kind(def.drive.is_some()) || def.axis != WHEEL_AXIS {
            wrong.push(
                "a wheel's joint: expected a continuous one with a motor about the left, a belt, or a ball".to_owned(),
            );
        }
        if def.friction != 0.0 || def.drive.as_ref().is_some_and(|motor| motor.stiffness.is_some()) {
            wrong.push("a wheel's joint with `friction` or `stiffness`: expected neither".to_owned());
        }
    } else {
        wrong.extend(ROBOT_REACH.problem_in("position", &def.anchor));
        wrong.extend(def.drive.iter().flat_map(motor));
    }
    if def.kind == JointKind::Belt && of_wheel.is_none() {
        wrong.push("a belt without a sprocket: expected a [[track]]".to_owned());
    }
    let has_ends = matches!(def.kind, JointKind::Revolute | JointKind::Prismatic);
    match def.limits {
        Some([least, most]) if has_ends => {
            wrong.extend(JOINT_LIMIT.problem_in("limits", &[least, most]));
            if least >= most {
                wrong.push(format!("`limits` are {} and {}: expected the least first", Number(least), Number(most)));
            }
        }
        None if has_ends => wrong.push("no `limits`: expected the least and the greatest value".to_owned()),
        Some(_) => wrong.push("`limits` of a joint without ends: expected none".to_owned()),
        None => {}
    }
    if def.drive.is_some() && !def.kind.has_value() {
        wrong.push("a motor of a joint that has no axis: expected revolute, continuous or prismatic".to_owned());
    }
    wrong
}

/// Lists the problems of a part of a robot's body.
pub fn part(def: &Part) -> Vec<String> {
    let mut wrong = name("name", &def.name);
    wrong.extend(PART_MASS.problem("mass", def.mass));
    wrong.extend(ROBOT_REACH.problem_in("centre", def.centre.as_slice()));
    wrong.extend(inertia(&def.inertia));
    wrong
}

/// Checks an inertia. A moment sums the squares of two coordinates over the mass, so none exceeds the sum of the other two.
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

/// Returns the principal moments of an inertia, the least first.
fn principal_moments(inertia: &Matrix3<f64>) -> [f64; 3] {
    // Scaling keeps small moments from being lost in squares.
    let size = inertia.amax().max(f64::MIN_POSITIVE);
    let mut moments: [f64; 3] = (inertia / size).symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    // Rounding leaves a residue of a moment that is zero.
    moments.map(|moment| if moment.abs() < 1e-12 { 0.0 } else { moment * size })
}

/// Lists the problems of a wheel or a caster. Its materials have their own checks, as do the numbers that its rollers share with
/// those of other wheels.
pub fn wheel(def: &MountedWheel) -> Vec<String> {
    let mut wrong = name("name", def.name);
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
    wrong.extend(def.drive.into_iter().flat_map(motor));
    if wrong.is_empty() {
        wrong.extend(def.drive.and_then(|motor| rim_speed(motor, def.radius)));
    }
    if let Some(rollers) = &def.rollers {
        if !ROLLER_ANGLE.holds(rollers.angle.abs()) {
            wrong.push(format!("`roller_angle` is {}: expected {ROLLER_ANGLE}", Number(rollers.angle)));
        }
        wrong.extend(FIRST_ROLLER.problem("first_roller", rollers.first_roller));
    }
    if def.drive.is_none() && (def.rollers.is_some() || def.belt.is_some()) {
        wrong.push("a caster with rollers or a belt: expected a ball".to_owned());
    }
    wrong.extend(def.belt.iter().flat_map(|belt| self::belt(belt, def)));
    wrong.extend(def.tyre.iter().flat_map(|tyre| self::tyre(tyre, def)));
    wrong
}

/// Lists the problems of a tyre on a wheel.
fn tyre(def: &Tyre, wheel: &MountedWheel) -> Vec<String> {
    let mut wrong = Vec::new();
    if wheel.drive.is_none() || wheel.rollers.is_some() || wheel.belt.is_some() {
        wrong.push("`tyre`: expected a driven wheel without rollers or belt".to_owned());
    }
    wrong.extend(SLIP_STIFFNESS.problem_in("stiffness", &def.stiffness));
    wrong.extend(FRICTION_RATIO.problem_in("friction", &def.friction));
    wrong.extend(RELAXATION.problem("relaxation", def.relaxation()));
    // With a friction of 1 a tread slides as a whole when it is bent by this.
    let bent = 3.0 * def.relaxation() / def.stiffness[0].min(def.stiffness[1]);
    if wrong.is_empty() && bent > wheel.radius {
        let (got, most) = (Number(def.relaxation()), Number(def.relaxation() * wheel.radius / bent));
        wrong.push(format!("`relaxation` is {got}: expected at most {most} m, a third of stiffness times radius"));
    }
    // The patch is a part of the wheel.
    for (key, value, most) in [("length", def.patch[0], wheel.radius), ("width", def.patch[1], wheel.width)] {
        if !(LEAST_PATCH..=most).contains(&value) {
            let got = Number(value);
            wrong.push(format!("half {key} in `patch` is {got}: expected {LEAST_PATCH} to {most} m"));
        }
    }
    wrong
}

/// Checks a belt, and that the wheel is its first roller.
fn belt(def: &Belt, wheel: &MountedWheel) -> Vec<String> {
    let mut wrong = Vec::new();
    if !BELT_ROLLERS.holds(def.rollers.len() as f64) {
        wrong.push(format!("a belt around {} rollers: expected {BELT_ROLLERS}", def.rollers.len()));
    }
    for &[x, z, radius] in &def.rollers {
        wrong.extend(ROBOT_REACH.problem_in("rollers", &[x, z]));
        wrong.extend(WHEEL_RADIUS.problem("radius of a roller", radius));
    }
    let [x, _, z] = wheel.position;
    if def.rollers.first() != Some(&[x, z, wheel.radius]) {
        wrong.push("a belt whose first roller is not its sprocket: expected the wheel's place and radius".to_owned());
    }
    if wheel.rollers.is_some() {
        wrong.push("a belt around a Mecanum wheel: expected a plain one".to_owned());
    }
    wrong
}

/// Checks the speed of the rim: a valid motor speed and a valid radius together can be absurd.
fn rim_speed(motor: &Motor, radius: f64) -> Option<String> {
    let speed = motor.max_speed * radius;
    let (turn, radius) = (Number(motor.max_speed), Number(radius));
    (speed > MAX_RIM_SPEED).then(|| {
        format!(
            "`max_speed` {turn} rad/s at `radius` {radius} m is {speed:.1} m/s at the rim: expected at most {MAX_RIM_SPEED} m/s"
        )
    })
}

/// Checks the push of all wheels: valid motors, radii and masses together can be absurd.
fn push(def: &RobotDef) -> Option<String> {
    let force: f64 = def.driven().filter_map(|wheel| Some(wheel.drive?.stall_torque() / wheel.radius)).sum();
    let weight = f64::from(def.mass()) * EARTH_GRAVITY;
    let times = force / weight;
    (times > MAX_PUSH).then(|| {
        format!(
            "its wheels push with {force:.0} N, {times:.0} times its weight of {weight:.2} N: expected at most {MAX_PUSH} times; \
             lower `max_torque` (or `max_current`) or `gain`, or raise `radius` or `mass`"
        )
    })
}

fn motor(def: &Motor) -> Vec<String> {
    let mut wrong = Vec::new();
    for (range, key, value) in [
        (MAX_SPEED, "max_speed", Some(def.max_speed)),
        (GAIN, "gain", Some(def.gain)),
        (MAX_TORQUE, "max_torque", Some(def.max_torque)),
        (INTEGRAL_TIME, "integral_time", def.integral_time),
        (STIFFNESS, "stiffness", def.stiffness),
        (ARMATURE, "armature", Some(def.armature)),
    ] {
        wrong.extend(value.and_then(|value| range.problem(key, value)));
    }
    wrong
}

/// Lists the problems of the rollers of a wheel with a valid radius; their material has its own check.
pub fn rollers(def: &Rollers, wheel_radius: f64) -> Vec<String> {
    let mut wrong = Vec::new();
    for (range, key, value) in [
        (ROLLER_COUNT, "count", f64::from(def.count)),
        (ROLLER_MASS, "mass", def.mass),
        (ROLLER_DAMPING, "damping", def.damping),
        (SHARE, "bearing_friction", def.bearing_friction),
    ] {
        wrong.extend(range.problem(key, value));
    }
    // The axis is farthest out at the ends of a roller; the roller must still be inside the wheel there.
    let least_phase = std::f64::consts::PI / f64::from(def.count.max(3));
    let (least, outermost) = (LEAST_AXIS_CIRCLE * wheel_radius, (1.0 - LEAST_ROLLER_END) * wheel_radius);
    let most = outermost * libm::cos(least_phase);
    if !(least..=most).contains(&def.axis_circle) {
        let got = Number(def.axis_circle);
        wrong.push(format!("`axis_circle` is {got}: expected {least:.4} to {most:.4} m"));
    }
    let most_phase = libm::acos(def.axis_circle / outermost);
    if wrong.is_empty() && !(least_phase * (1.0 - 1e-9)..=most_phase * (1.0 + 1e-9)).contains(&def.last_phase) {
        let got = Number(def.last_phase);
        wrong.push(format!("`last_phase` is {got}: expected {least_phase:.4} to {most_phase:.4} rad"));
    }
    wrong
}

/// Lists the problems of a sensor.
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

/// Lists the problems of a battery.
pub fn battery(def: &Battery) -> Vec<String> {
    let energy = BATTERY_ENERGY.problem("max_energy", def.max_energy);
    energy.into_iter().chain(BATTERY_LIFE.problem("life", def.life)).collect()
}

fn counts(def: &RobotDef) -> Vec<String> {
    let rays = def.sensors.iter().map(|sensor| sensor.config.rays()).fold(0, usize::saturating_add);
    let mut wrong = wire_name("class", &def.class);
    wrong.extend(text("description", &def.description));
    let solids = || def.links.iter().flat_map(|link| &link.solids);
    wrong.extend(count("links", def.links.len(), MAX_LINKS));
    wrong.extend(count("parts", def.links.iter().map(|link| link.parts.len()).sum(), MAX_PARTS));
    wrong.extend(count("solids", solids().count(), MAX_PARTS));
    let visuals = || def.links.iter().flat_map(|link| &link.visuals);
    wrong.extend(count("visuals", visuals().count(), MAX_PARTS));
    let seen = visuals().map(|it| triangles(&it.shape)).fold(0, usize::saturating_add);
    wrong.extend(count("triangles of visuals", seen, MAX_VISUAL_TRIANGLES));
    let hulls = visuals().map(|it| hull_points(&it.shape)).sum();
    wrong.extend(count("corners of visible hulls", hulls, MAX_HULL_POINTS));
    wrong.extend(count("wheels", def.wheels().count(), MAX_WHEELS));
    wrong.extend(count("rollers", def.wheels().map(|wheel| wheel.roller_count()).sum(), MAX_ROLLERS));
    wrong.extend(count("actuators and grippers", def.actuators.len() + def.grippers.len(), MAX_SENSORS));
    wrong.extend(count("tool changers", def.tool_changers.len(), MAX_TOOL_CHANGERS));
    wrong.extend(count("vacuums", def.vacuums.len(), MAX_TOOL_CHANGERS));
    wrong.extend(count("sensors", def.sensors.len(), MAX_SENSORS));
    wrong.extend(count("corners of hulls", solids().map(|it| hull_points(&it.shape)).sum(), MAX_HULL_POINTS));
    wrong.extend(count("rays", rays, MAX_RAYS));
    wrong
}

/// Lists the problems of a robot as a whole. Its parts, solids, wheels, sensors and battery have their own checks, and have to be
/// valid.
pub fn robot(def: &RobotDef) -> Vec<String> {
    let mut wrong = counts(def);
    wrong.extend(REPORTED_TORQUE.problem("reported_max_torque", def.reported_max_torque));
    if def.links.first().is_none_or(|root| root.parts.is_empty()) {
        wrong.push("no part: expected at least one with a mass".to_owned());
    }
    if def.steering.is_on_wheels() && def.driven().next().is_none() {
        wrong.push("no driven wheel: expected at least one".to_owned());
    }
    if !def.wheels().is_sorted_by_key(|wheel| wheel.drive.is_none()) {
        wrong.push("a driven wheel behind a caster: expected driven wheels first".to_owned());
    }
    wrong.extend(omni(def));
    wrong.extend(couplings(def));
    for sensor in def.sensors.iter().filter(|sensor| sensor.link >= def.links.len()) {
        let (name, count) = (shown(&sensor.name), def.links.len());
        wrong.push(format!("sensor {name}: it is on link {}: expected less than {count}", sensor.link));
    }
    if def.footing.aerial().is_some() != (def.steering == Steering::Aerial) {
        wrong.push("what it can do in the air: expected of steering \"aerial\", and of that alone".to_owned());
    }
    if def.steering == Steering::Ackermann && def.drivetrain() != Drivetrain::Steered {
        let expected = "expected a revolute [[joint]] with FrontSteer or RearSteer in its name";
        wrong.push(format!("steering \"ackermann\": {expected}"));
    }
    if !def.can_have(def.drive_model) {
        let name = def.drive_model.name();
        wrong.push(format!("`drive_model` \"{name}\": expected \"articulated\", with four Mecanum wheels any, or without tracks \"bodies\""));
    }
    if wrong.is_empty() {
        wrong.extend(masses(def).into_iter().chain(push(def)));
    }
    wrong
}

/// Lists the problems of a robot's flight limits.
pub fn aerial(def: &Aerial) -> Vec<String> {
    let velocity = FLIGHT_SPEED.problem_in("max_velocity", &def.max_velocity);
    let turn = FLIGHT_TURN.problem("max_turn", def.max_turn);
    velocity.into_iter().chain(turn).chain(TILT.problem("max_tilt", def.max_tilt)).collect()
}

/// Lists the problems of an actuator of a robot with these links.
pub fn actuator(def: &Actuator, links: &[Link]) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(ROBOT_REACH.problem_in("tip", &def.tip));
    wrong.extend(driven_joints(&def.name, &def.links, links));
    wrong
}

/// Lists the problems of a gripper of a robot with these links.
pub fn gripper(def: &Gripper, links: &[Link]) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(JOINT_LIMIT.problem_in("open", &def.open));
    wrong.extend(JOINT_LIMIT.problem_in("closed", &def.closed));
    if [def.open.len(), def.closed.len()] != [def.links.len(); 2] {
        wrong.push(format!("gripper {}: expected as many values `open` and `closed` as joints", shown(&def.name)));
    }
    wrong.extend(driven_joints(&def.name, &def.links, links));
    wrong
}

/// Lists the problems of a tool changer of a robot with these links. The material of its tool has its own check.
pub fn tool_changer(def: &ToolChanger, links: &[Link]) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(on_no_wheel("tool changer", &def.name, def.link, links));
    wrong.extend(ROBOT_REACH.problem_in("position", &def.position));
    wrong.extend(ANGLE.problem_in("direction", &def.direction));
    wrong.extend(TOOL_DISTANCE.problem("position_tolerance", def.position_tolerance));
    wrong.extend(TOOL_ANGLE.problem("angle_tolerance", def.angle_tolerance));
    if let Some(Tool { kind, object: body }) = &def.tool {
        wrong.extend(wire_name("type", kind));
        wrong.extend(object(body));
        wrong.extend(ROBOT_REACH.problem_in("position", &body.solid.position));
    }
    wrong
}

/// Lists the problems of a vacuum of a robot with these links.
pub fn vacuum(def: &Vacuum, links: &[Link]) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(on_no_wheel("vacuum", &def.name, def.link, links));
    wrong.extend(ROBOT_REACH.problem_in("position", &def.position));
    wrong.extend(ANGLE.problem_in("direction", &def.direction));
    wrong.extend(SUCTION.problem("reach", def.reach));
    wrong.extend(SUCTION_FORCE.problem("force", def.force));
    wrong.extend(def.tool.iter().flat_map(|tool| wire_name("tool", tool)));
    wrong
}

/// Checks that an item is on a link that is no wheel.
fn on_no_wheel(kind: &str, name: &str, number: usize, links: &[Link]) -> Option<String> {
    let is_well = links.get(number).is_some_and(|link| link.wheel.is_none());
    (!is_well).then(|| format!("{kind} {}: it is on link {number}: expected one that is no wheel", shown(name)))
}

/// Checks that the joints of an actuator have motors and are not those of wheels.
fn driven_joints(name: &str, numbers: &[usize], links: &[Link]) -> Option<String> {
    let moves = |&number: &usize| {
        let link = links.get(number)?;
        let driven = link.joint.as_ref().is_some_and(|joint| joint.drive.is_some());
        (link.wheel.is_none() && link.has_value() && driven).then_some(())
    };
    let good =
        !numbers.is_empty() && numbers.len() <= MAX_LINKS && numbers.iter().all(|number| moves(number).is_some());
    let expected = "expected at least one, none of a wheel, each with a motor";
    (!good).then(|| format!("the joints of {}: {expected}", shown(name)))
}

/// Checks that each leader has no coupling itself, so that no joint depends on a chain or a cycle.
fn couplings(def: &RobotDef) -> impl Iterator<Item = String> {
    let coupled = |link: &Link| Some((link.name.clone(), link.joint.as_ref()?.coupling?.leader));
    let leads = |link: &Link| link.has_value() && link.joint.as_ref().is_some_and(|joint| joint.coupling.is_none());
    let followers = def.links.iter().filter_map(coupled);
    let lost = followers.filter(move |&(_, leader)| !def.links.get(leader).is_some_and(leads));
    lost.map(|(name, leader)| {
        format!("link {}: it follows link {leader}: expected one that turns or slides and follows none", shown(&name))
    })
}

/// Checks that an omni base has the wheels that its kinematics and its encoders use.
fn omni(def: &RobotDef) -> Option<String> {
    let expected = "expected four wheels front left, front right, back left, back right with `roller_angle` +, -, -, +";
    let is_well = def.steering != Steering::Omni || def.drivetrain() == Drivetrain::Mecanum;
    (!is_well).then(|| format!("steering \"omni\": {expected}"))
}

fn masses(def: &RobotDef) -> Vec<String> {
    let body = def.body_mass();
    let rollers = def.wheels().filter_map(|wheel| wheel.wheel.rollers.as_ref()).map(|rollers| rollers.mass);
    let links = def.links.iter().skip(1).filter(|link| link.wheel.is_none()).map(|link| link.mass().mass);
    let masses = || links.clone().chain([body.mass]).chain(def.wheels().map(|wheel| wheel.mass)).chain(rollers.clone());
    let (least, most) = (masses().fold(f64::MAX, f64::min), masses().fold(0.0, f64::max));
    let mut wrong: Vec<String> = BODY_MASS.problem("mass of the body", body.mass).into_iter().collect();
    if most > least * MASS_RATIO {
        let (least, most) = (Number(least), Number(most));
        wrong.push(format!(
            "its body, wheels and rollers weigh {least} to {most} kg: expected at most {MASS_RATIO} times the lightest"
        ));
    }
    let farthest = def.wheels().map(|wheel| (Vector3::from(wheel.position) - body.centre).norm()).fold(0.0, f64::max);
    let [moment, ..] = principal_moments(&body.inertia);
    let (gyration, least) = ((moment / body.mass).max(0.0).sqrt(), LEAST_GYRATION * farthest);
    if !(least..=ROBOT_SIZE.most).contains(&gyration) {
        let expected = format!("{least:.6} (a hundredth of the way to its farthest wheel) to {} m", ROBOT_SIZE.most);
        wrong.push(format!("its body's radius of gyration is {gyration:.6} m: expected {expected}"));
    }
    wrong
}
