//! Robots from only a URDF. Wheels, steering and motors are guessed, and the guesses are listed in the robot's assumptions. A
//! robot.toml that names the URDF is more precise.

use nalgebra::{Point3, Vector3};
use scene::{
    Footing, JointKind, Link, Material, Motor, Pose, RobotDef, SensorDef, Shape, Side, Steering, Wheel, check, sensor,
};

use super::joint::rebuilt;
use super::wheel::wrong_wheel;
use crate::materials::Materials;
use crate::problem::Problems;
use crate::source::Source;
use crate::urdf::{self, Continuous, Urdf};

/// Least cosine of the angle between an axis and the direction it is taken for.
const NEARLY: f64 = 0.95;
/// Speed limit of a wheel without one, rad/s.
const WHEEL_SPEED: f64 = 10.0;
/// Push of a wheel without a torque limit, as a fraction of the robot's weight.
const WHEEL_PUSH: f64 = 0.5;
/// Fraction of a limit that stays within it in spite of rounding.
const ROUNDING: f64 = 0.999;
const BODY: &str = "unreal-default";
const TYRE: &str = "rubber-tyre";

pub(crate) fn read(
    source: &Source,
    file: &str,
    class: &str,
    text: &str,
    materials: &Materials,
    problems: &mut Problems,
) -> Option<RobotDef> {
    let material = |name: &str| materials.get(name).cloned().unwrap_or_default();
    let urdf = urdf::read(source, file, text, material(BODY), problems).ok()?;
    let mut guess = Guess { tyre: material(TYRE), urdf, casters: Vec::new(), wheels: Vec::new() };
    guess.find_wheels();
    let steering = guess.steering();
    guess.free_casters();
    guess.limit_motors();
    let (links, mut assumptions) = guess.finish(steering);
    assumptions.push(format!("links are of `{BODY}`, wheels of `{TYRE}`"));
    let robot = RobotDef {
        class: class.to_owned(),
        description: format!("From {file}"),
        steering,
        reported_steering: None,
        drive_model: scene::DriveModel::default(),
        one_side_drives: false,
        speaks_ut2004: false,
        links,
        sensors: sensors(steering),
        actuators: Vec::new(),
        grippers: Vec::new(),
        tool_changers: Vec::new(),
        battery: None,
        reported_max_torque: 50000.0,
        footing: Footing::of(steering, None),
        assumptions,
    };
    let shown = source.display(file);
    let links = robot.links.iter().enumerate();
    let wrong = links.flat_map(|(number, link)| {
        let wrong = check::link(link, number).into_iter().chain(wrong_wheel(link));
        wrong.map(|message| format!("joint {}: {message}", link.name)).collect::<Vec<_>>()
    });
    let mut wrong: Vec<String> = wrong.collect();
    if wrong.is_empty() {
        wrong = check::robot(&robot);
    }
    wrong.into_iter().for_each(|message| problems.at(&shown, text, 0, message));
    Some(robot)
}

/// Returns a ground truth sensor, and odometry for skid robots.
fn sensors(steering: Steering) -> Vec<SensorDef> {
    let names = [("GroundTruth", "GndTruth"), ("Odometry", "Odometry")];
    let names = names.iter().take(if steering == Steering::Skid { 2 } else { 1 });
    let sensor = |(class, name): &(&str, &str)| {
        let (_, scan_interval) = *sensor::CLASSES.iter().find(|(known, _)| known == class)?;
        let config = sensor::Config::read(class, toml::Table::new())?.ok()?;
        Some(SensorDef {
            name: (*name).to_owned(),
            link: 0,
            position: [0.0; 3],
            direction: [0.0; 3],
            scan_interval,
            config,
        })
    };
    names.filter_map(sensor).collect()
}

struct Guess {
    urdf: Urdf,
    tyre: Material,
    /// Numbers of links, with the wheels made from them.
    wheels: Vec<(usize, Link)>,
    casters: Vec<(usize, Link)>,
}

impl Guess {
    /// Finds wheels: links with a shape on continuous joints about a sideways axis.
    fn find_wheels(&mut self) {
        let mass: f64 = self.urdf.links.iter().map(|link| link.mass().mass).sum();
        for continuous in &self.urdf.continuous {
            let link = &self.urdf.links[continuous.link];
            let Some(joint) = &link.joint else { continue };
            if joint.axis[1].abs() < NEARLY {
                continue;
            }
            let Some([radius, left, right]) = extent(link) else {
                let joint = &continuous.joint;
                self.urdf.assumptions.push(format!("joint {joint} has no shape, so it is no wheel"));
                continue;
            };
            let [x, y, z] = joint.anchor;
            let position = [x, y + (left + right) / 2.0, z];
            let side = if position[1] < 0.0 { Side::Left } else { Side::Right };
            let wheel = Wheel {
                side,
                radius,
                width: right - left,
                mass: link.mass().mass,
                material: self.tyre.clone(),
                rollers: None,
                belt: None,
            };
            let is_caster = is_caster(&self.urdf.links, continuous.link);
            let drive = (!is_caster).then(|| motor(continuous, mass, radius));
            let mut made = Link::of_wheel(link.name.clone(), position, drive, wheel);
            made.visuals.clone_from(&link.visuals);
            if let Some(made) = &mut made.joint {
                made.parent = joint.parent;
            }
            let list = if is_caster { &mut self.casters } else { &mut self.wheels };
            list.push((continuous.link, made));
        }
    }

    /// Guesses the steering. A robot without wheels on both sides is fixed, and its possible wheels are joints.
    fn steering(&mut self) -> Steering {
        let sides = [Side::Left, Side::Right];
        let is_on = |side| self.wheels.iter().any(|(_, link)| link.wheel.as_ref().is_some_and(|it| it.side == side));
        if !sides.into_iter().all(is_on) {
            self.urdf.assumptions.push("no wheels on both sides: it is fixed to the ground".to_owned());
            self.wheels.clear();
            self.casters.clear();
            return Steering::None;
        }
        let middle = self.wheels.iter().map(|(_, link)| link.origin()[0]).sum::<f64>() / self.wheels.len() as f64;
        let mut steered = Vec::new();
        for (_, wheel) in &self.wheels {
            let Some(parent) = wheel.joint.as_ref().map(|joint| joint.parent) else { continue };
            let link = &mut self.urdf.links[parent];
            let upright = |joint: &scene::Joint| joint.kind == JointKind::Revolute && joint.axis[2].abs() > NEARLY;
            if !link.joint.as_ref().is_some_and(upright) {
                continue;
            }
            if link.steered_axle().is_none() {
                let axle = if link.origin()[0] > middle { "FrontSteer" } else { "RearSteer" };
                link.name = format!("{}_{axle}", link.name);
            }
            steered.push(link.name.clone());
        }
        let wheels: Vec<&str> = self.wheels.iter().map(|(_, link)| link.name.as_str()).collect();
        let (wheels, steering) =
            (wheels.join(", "), if steered.is_empty() { Steering::Skid } else { Steering::Ackermann });
        let how = match steering {
            Steering::Ackermann => format!("steered as a car by {}", steered.join(", ")),
            _ => "steered by the sides of its wheels".to_owned(),
        };
        self.urdf.assumptions.push(format!("{how}; its driven wheels are {wheels}"));
        if steering == Steering::Ackermann {
            for motor in self.wheels.iter_mut().filter_map(|(_, link)| link.joint.as_mut()?.drive.as_mut()) {
                // Wheels of one speed have to yield in a bend.
                (motor.integral_time, motor.armature) = (None, 0.0);
            }
        }
        steering
    }

    /// Frees casters. A caster is a ball here, so the joint that it swivels about is held. A solid whose name says caster slides
    /// without friction.
    fn free_casters(&mut self) {
        for (_, caster) in &self.casters {
            let Some(parent) = caster.joint.as_ref().map(|joint| joint.parent) else { continue };
            let link = &mut self.urdf.links[parent];
            if let Some(joint) = link.joint.as_mut().filter(|joint| joint.kind == JointKind::Continuous) {
                (joint.kind, joint.drive) = (JointKind::Fixed, None);
            }
            self.urdf.assumptions.push(format!("{} is a caster, a ball that turns freely", caster.name));
        }
        for solid in self.urdf.links.iter_mut().flat_map(|link| &mut link.solids) {
            if is_called_caster(&solid.name) {
                solid.material.friction = 0.0;
                self.urdf.assumptions.push(format!("{} slides without friction, as its name says caster", solid.name));
            }
        }
    }

    /// Lowers limits that mean "none" in a URDF: with them a robot would throw itself over walls.
    fn limit_motors(&mut self) {
        let mass: f64 = self.urdf.links.iter().map(|link| link.mass().mass).sum();
        let most_push = ROUNDING * check::MAX_PUSH * check::EARTH_GRAVITY * mass / self.wheels.len().max(1) as f64;
        for (_, link) in &mut self.wheels {
            let Some(radius) = link.wheel.as_ref().map(|wheel| wheel.radius) else { continue };
            let Some(motor) = link.joint.as_mut().and_then(|joint| joint.drive.as_mut()) else { continue };
            let speed = (ROUNDING * check::MAX_RIM_SPEED / radius).min(check::MAX_SPEED.most);
            let torque = (most_push * radius).min(check::MAX_TORQUE.most);
            let Motor { max_speed, max_torque, gain, .. } = motor;
            for (limit, most, what) in [(max_speed, speed, "velocity in rad/s"), (max_torque, torque, "effort in N m")]
            {
                if *limit > most {
                    let text = format!("joint {}: {what} {limit} is taken as {most:.2}", link.name);
                    self.urdf.assumptions.push(format!("{text}, as no robot has more"));
                    *limit = most;
                }
            }
            *gain = servo_gain(motor.max_torque, motor.max_speed);
        }
    }

    fn finish(self, steering: Steering) -> (Vec<Link>, Vec<String>) {
        let Self { urdf: Urdf { links, mut assumptions, .. }, wheels, casters, .. } = self;
        if steering != Steering::None && links.iter().any(|link| link.name.to_ascii_lowercase().contains("mecanum")) {
            assumptions.push("wheels are plain ones: a URDF has no rollers, a robot.toml can name them".to_owned());
        }
        let (numbers, made): (Vec<usize>, Vec<Link>) = wheels.into_iter().chain(casters).unzip();
        (rebuilt(links, &numbers, made.into_iter()), assumptions)
    }
}

/// Returns a wheel's motor: the limits of the URDF, and a speed servo as other joints have.
fn motor(continuous: &Continuous, robot_mass: f64, radius: f64) -> Motor {
    let max_speed = continuous.max_speed.unwrap_or(WHEEL_SPEED);
    let max_torque = continuous.max_torque.unwrap_or(WHEEL_PUSH * robot_mass * check::EARTH_GRAVITY * radius);
    // The rotor has the inertia that `Motor::armature` requires.
    let armature = robot_mass / 4.0 * radius * radius;
    let gain = servo_gain(max_torque, max_speed);
    Motor { max_speed, gain, max_torque, stiffness: None, integral_time: Some(0.1), armature }
}

fn servo_gain(max_torque: f64, max_speed: f64) -> f64 {
    max_torque / (urdf::FULL_TORQUE_LAG * max_speed)
}

/// Returns the radius of a link's shapes about its joint's axis, and their reach to the left (negative) and right of the joint, m.
/// Uses the colliding shapes, or the visuals if there are none.
fn extent(link: &Link) -> Option<[f64; 3]> {
    let solids: Vec<(Pose, &Shape)> = link.solids.iter().map(|it| (link.pose_of(it), &it.shape)).collect();
    let [x, y, z] = link.origin();
    let seen = link.visuals.iter().map(|it| {
        let pose = scene::pose(it.position, it.rotation);
        (nalgebra::Translation3::new(-x, -y, -z) * pose, &it.shape)
    });
    let shapes = if solids.is_empty() { seen.collect() } else { solids };
    let ends = shapes.iter().flat_map(|(pose, shape)| corners(shape).into_iter().map(move |corner| pose * corner));
    let [mut radius, mut left, mut right]: [f64; 3] = [0.0, f64::MAX, f64::MIN];
    for corner in ends {
        radius = radius.max(corner.x.hypot(corner.z));
        (left, right) = (left.min(corner.y), right.max(corner.y));
    }
    (radius > 0.0 && right > left).then_some([radius, left, right])
}

/// Returns points of a shape's outline.
fn corners(shape: &Shape) -> Vec<Point3<f64>> {
    const AROUND: u32 = 64;
    let around = |radius: f64, z: f64| {
        (0..AROUND).map(move |part| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(part) / f64::from(AROUND)).sin_cos();
            Point3::new(radius * cos, radius * sin, z)
        })
    };
    match shape {
        Shape::HalfSpace => Vec::new(),
        Shape::Box { size: [x, y, z] } => {
            let signs = [-0.5, 0.5];
            let corner = |sx: f64| signs.map(|sy| signs.map(|sz| Point3::new(sx * x, sy * y, sz * z)));
            signs.map(corner).into_iter().flatten().flatten().collect()
        }
        Shape::Cylinder { radius, length } => {
            around(*radius, -length / 2.0).chain(around(*radius, length / 2.0)).collect()
        }
        Shape::Ball { radius } => {
            let ends = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| axis * *radius);
            ends.iter().flat_map(|end| [Point3::from(*end), Point3::from(-end)]).collect()
        }
        Shape::HeightField(field) => field.corners().map(Point3::from).collect(),
        Shape::Hull { points: vertices } | Shape::Mesh { vertices, .. } => {
            vertices.iter().map(|&vertex| Point3::from(vertex)).collect()
        }
    }
}

/// True for a caster: its name or that of its carrier says so, or it is in the middle.
fn is_caster(links: &[Link], number: usize) -> bool {
    let link = &links[number];
    let parent = link.joint.as_ref().and_then(|joint| links.get(joint.parent));
    let named =
        |link: &Link| is_called_caster(&link.name) || link.parts.iter().any(|part| is_called_caster(&part.name));
    let swivels = parent.filter(|it| it.joint.as_ref().is_some_and(|joint| joint.kind == JointKind::Continuous));
    named(link) || swivels.is_some_and(named) || link.origin()[1].abs() < 0.01
}

fn is_called_caster(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    ["caster", "castor"].iter().any(|word| name.contains(word))
}
