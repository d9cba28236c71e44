//! Robots from only a URDF. Wheels, steering and motors are guessed, and the guesses are listed in the robot's assumptions. A
//! robot.toml that names the URDF is more precise.

mod arms;
pub(crate) mod extent;
mod legs;

use scene::{
    Actuator, JointKind, Link, Material, Motor, MountedWheel, RobotDef, Rollers, SensorDef, Side, Steering, Wheel,
    check, sensor,
};

use self::extent::{Extent, bounds};
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
/// Torque of a steering joint without an effort: that of the robot's weight at this arm, m; and its speed, rad/s.
const STEERING_PUSH: f64 = 0.2;
const STEERING_SPEED: f64 = 3.0;
/// Fraction of a limit that stays within it in spite of rounding.
const ROUNDING: f64 = 0.999;
/// Least roundness of a wheel about its axis.
const ROUND: f64 = 0.6;
/// Greatest height of a wheel above the lowest one, as a fraction of its radius.
const ABOVE_GROUND: f64 = 0.25;
/// Distance from the middle within which a wheel is a caster, m.
const MIDDLE: f64 = 0.01;
/// Height by which a caster may be lower than the driven wheels and is raised to them, m: rigid wheels would hang in the air.
const CASTER_LOWER: f64 = 0.005;
/// Height by which it is then above them, m, and the least that is worth it.
const CASTER_ABOVE: f64 = 5e-4;
const SEEN: f64 = 1e-5;
/// Mass of a caster's ball over the robot's. Its own mass stays with its link.
const BALL_MASS: f64 = 1e-3;
/// Rollers of a guessed Mecanum wheel: number, circle of their axes over the wheel's radius, and mass over the wheel's. A youBot has
/// these.
const ROLLERS: u32 = 6;
const AXIS_CIRCLE: f64 = 0.72;
const ROLLERS_MASS: f64 = 0.3;
/// Viscous friction of a roller's bearing, N m s/rad, as of a youBot.
const ROLLER_DAMPING: f64 = 5e-6;
/// Material of links.
pub(crate) const BODY: &str = "unreal-default";
/// Material of wheels.
pub(crate) const TYRE: &str = "rubber-tyre";
/// Material of rollers.
pub(crate) const ROLLER: &str = "roller";
/// Material of casters.
pub(crate) const CASTER: &str = "nylon";

/// A guessed robot, and the URDF's differences from it.
pub(crate) struct Guessed {
    pub(crate) robot: RobotDef,
    pub(crate) changes: Vec<Change>,
}

/// A change of the URDF that the guess is based on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Change {
    /// A joint is held.
    Hold(String),
    /// A joint has another name.
    Rename(String, String),
    /// A link of the URDF collides with nothing, as a caster takes its place.
    NoCollision(String),
    /// A joint has these limits of effort and velocity.
    Limit(String, [f64; 2]),
    /// The robot is turned about the vertical, rad, counterclockwise from above.
    Turn(f64),
}

/// Knowledge of a robot's wheels beside its URDF.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Known<'a> {
    /// Joints of its driven wheels; empty if they have to be found.
    pub(crate) wheels: &'a [String],
    /// Drive that somebody has chosen.
    pub(crate) drive: Option<WheelDrive>,
    /// True if the file hints at Mecanum wheels.
    pub(crate) mecanum: bool,
}

/// A way in which wheels drive a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WheelDrive {
    /// Four Mecanum wheels.
    Mecanum,
    /// Two sides.
    Sides,
    /// Steered wheels.
    Car,
}

/// A URDF from which a robot is guessed.
#[derive(Clone, Copy)]
pub(crate) struct OfUrdf<'a> {
    /// The folder of its meshes.
    pub(crate) source: &'a Source,
    /// Its name there.
    pub(crate) file: &'a str,
    pub(crate) text: &'a str,
    /// Name of the robot's class.
    pub(crate) class: &'a str,
    pub(crate) materials: &'a Materials,
    pub(crate) known: Known<'a>,
}

/// Guesses a robot. One whose wheels roll along another axis than x is turned, so that it drives along its x.
pub(crate) fn read(of: &OfUrdf, problems: &mut Problems) -> Option<Guessed> {
    let (guessed, yaw) = guess(of, problems)?;
    let turned = |yaw: f64| {
        let text = &urdf::turned(of.text, yaw)?;
        let mut wrong = Problems::default();
        let (guessed, _) = guess(&OfUrdf { text, ..*of }, &mut wrong)?;
        (wrong.count() == 0 && stands_on_wheels(&guessed.robot)).then_some((guessed, yaw))
    };
    // A car that has to be turned anyway steers in front.
    let turned = yaw.and_then(|yaw| {
        let first = turned(yaw)?;
        let is_backward = steers_behind(&first.0.robot);
        is_backward.then(|| turned(yaw - yaw.signum() * std::f64::consts::PI)).flatten().or(Some(first))
    });
    let Some((mut guessed, yaw)) = turned else { return Some(guessed) };
    let degrees = -yaw.to_degrees();
    let turned =
        format!("its wheels roll at {degrees:.0} degrees to its x, so it is turned by as much and drives along its x");
    guessed.robot.assumptions.insert(0, turned);
    guessed.changes.push(Change::Turn(yaw));
    Some(guessed)
}

/// Number of the rear axle.
const REAR: usize = 1;

/// True for a car that only steers behind.
fn steers_behind(robot: &RobotDef) -> bool {
    let mut axles = robot.links.iter().filter_map(Link::steered_axle).peekable();
    axles.peek().is_some() && axles.all(|axle| axle == REAR)
}

/// True if the wheels that drive a robot are the lowest of it: the motors of an arm are none.
fn stands_on_wheels(robot: &RobotDef) -> bool {
    let lowest = robot.links.iter().flat_map(|link| &link.solids);
    let lowest = lowest.map(|solid| bounds(&solid.shape, &solid.pose())[1].z).fold(f64::MIN, f64::max);
    let reaches = |wheel: MountedWheel| wheel.position[2] + (1.0 + ABOVE_GROUND) * wheel.radius > lowest;
    robot.steering.is_on_wheels() && robot.driven().all(reaches)
}

/// Guesses a robot as its file has it. Also returns the angle by which it has to be turned for its joints to be wheels, if any.
fn guess(of: &OfUrdf, problems: &mut Problems) -> Option<(Guessed, Option<f64>)> {
    let &OfUrdf { source, file, text, class, materials, known } = of;
    let material = |name: &str| materials.get(name).cloned().unwrap_or_default();
    let urdf = urdf::read(source, file, text, material(BODY), problems).ok()?;
    let mut guess = Guess {
        material: &material,
        known,
        urdf,
        casters: Vec::new(),
        wheels: Vec::new(),
        balls: Vec::new(),
        changes: Vec::new(),
        other_axes: Vec::new(),
    };
    let shown = source.display(file);
    for joint in known.wheels.iter().filter(|joint| !guess.urdf.continuous.iter().any(|it| &it.joint == *joint)) {
        let turning = || guess.urdf.continuous.iter().map(|it| it.joint.as_str());
        let (all, meant) = (names::listed(turning()), names::did_you_mean(joint, turning()));
        problems.at(
            &shown,
            text,
            0,
            format_args!("no turning joint `{joint}` for a wheel: expected some of {all}{meant}"),
        );
    }
    guess.find_wheels();
    let steering = guess.steering();
    let yaw = rolling_yaw(&guess.other_axes);
    guess.free_casters();
    guess.hold_followers();
    guess.limit_motors();
    let changes = std::mem::take(&mut guess.changes);
    let (links, mut assumptions) = guess.finish();
    let wheels = if steering.is_on_wheels() { format!(", wheels of `{TYRE}`") } else { String::new() };
    assumptions.push(format!("links are of `{BODY}`{wheels}"));
    let actuators = arms::actuators(&links);
    if !actuators.is_empty() {
        let named = |it: &Actuator| format!("{} ({})", it.name, names::count(it.links.len(), "joint"));
        let names: Vec<String> = actuators.iter().map(named).collect();
        assumptions.push(format!("actuators are chains of joints with servos: {}", names.join(", ")));
    }
    let robot = RobotDef {
        description: format!("From {file}"),
        sensors: sensors(steering),
        actuators,
        assumptions,
        ..RobotDef::new(class, steering, links)
    };
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
    let yaw = if steering.is_on_wheels() { None } else { yaw };
    Some((Guessed { robot, changes }, yaw))
}

/// Returns the classes and names of a guessed robot's sensors: ground truth, and odometry if its wheels can have one.
pub(crate) fn sensor_names(steering: Steering) -> &'static [(&'static str, &'static str)] {
    const NAMES: [(&str, &str); 2] = [("GroundTruth", "GndTruth"), ("Odometry", "Odometry")];
    if matches!(steering, Steering::Skid | Steering::Omni) { &NAMES } else { &NAMES[..1] }
}

fn sensors(steering: Steering) -> Vec<SensorDef> {
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
    sensor_names(steering).iter().filter_map(sensor).collect()
}

struct Guess<'a> {
    material: &'a dyn Fn(&str) -> Material,
    known: Known<'a>,
    urdf: Urdf,
    /// Numbers of links, with the wheels made from them.
    wheels: Vec<(usize, Link)>,
    casters: Vec<(usize, Link)>,
    /// Casters as the robot has them.
    balls: Vec<Link>,
    changes: Vec<Change>,
    /// Axes of turning joints that are not sideways.
    other_axes: Vec<[f64; 3]>,
}

/// Returns the angle by which a robot has to be turned for these axes to be sideways, rad, counterclockwise from above; `None` if they are
/// not level or not parallel. Of both directions the one nearer to x, or else to the left, becomes forward.
fn rolling_yaw(axes: &[[f64; 3]]) -> Option<f64> {
    let (&[x, y, _], others) = axes.split_first()?;
    let is_like = |axis: &[f64; 3]| (axis[0] * x + axis[1] * y).abs() > NEARLY;
    if others.is_empty() || x.hypot(y) < NEARLY || !others.iter().all(is_like) {
        return None;
    }
    // In the robot frame y is to the right.
    let forward = [y, x];
    let is_backward = if forward[0].abs() > 1.0 - NEARLY { forward[0] < 0.0 } else { forward[1] < 0.0 };
    let [x, y] = if is_backward { forward.map(|part| -part) } else { forward };
    Some(-y.atan2(x))
}

impl Guess<'_> {
    fn say(&mut self, assumption: String) {
        self.urdf.assumptions.push(assumption);
    }

    fn mass(&self) -> f64 {
        self.urdf.links.iter().map(|link| link.mass().mass).sum()
    }

    /// Finds wheels: links with a round shape on continuous joints about a sideways axis, on the ground.
    fn find_wheels(&mut self) {
        let mass = self.mass();
        let mut found = Vec::new();
        let is_known = |name: &String| self.known.wheels.contains(name);
        let mut other_axes = Vec::new();
        for continuous in &self.urdf.continuous {
            let link = &self.urdf.links[continuous.link];
            let name = &continuous.joint;
            if !self.known.wheels.is_empty() && !is_known(name) {
                continue;
            }
            let Some(joint) = link.joint.as_ref() else { continue };
            if joint.axis[1].abs() < NEARLY {
                if joint.axis[2].abs() < NEARLY {
                    other_axes.push((name.clone(), joint.axis));
                }
                continue;
            }
            let Some(Extent { radius, left, right, roundness }) = Extent::of(link) else {
                self.urdf.assumptions.push(format!("joint {name} has no shape, so it is no wheel"));
                continue;
            };
            if self.urdf.links.iter().any(|it| it.joint.as_ref().is_some_and(|it| it.parent == continuous.link)) {
                self.urdf.assumptions.push(format!("joint {name} carries other joints, so it is no wheel"));
                continue;
            }
            if roundness < ROUND && !is_known(name) {
                self.urdf.assumptions.push(format!("joint {name} is not round about its axis, so it is no wheel"));
                continue;
            }
            let [x, y, z] = joint.anchor;
            let position = [x, y + (left + right) / 2.0, z];
            let side = if position[1] < 0.0 { Side::Left } else { Side::Right };
            let wheel = Wheel {
                side,
                radius,
                width: right - left,
                mass: link.mass().mass,
                material: (self.material)(TYRE),
                rollers: None,
                belt: None,
                tyre: None,
            };
            let drive = motor(continuous, mass, radius);
            let mut made = Link::of_wheel(link.name.clone(), position, Some(drive), wheel);
            made.visuals.clone_from(&link.visuals);
            if let Some(made) = &mut made.joint {
                made.parent = joint.parent;
            }
            found.push((continuous.link, made));
        }
        for (joint, axis) in other_axes {
            self.other_axes.push(axis);
            self.urdf.say_of(&joint, "no wheel, as it does not turn about y: a robot drives along its x");
        }
        let ground = found.iter().map(|(_, wheel)| bottom(wheel)).fold(f64::MIN, f64::max);
        for (number, wheel) in found {
            let radius = wheel.wheel.as_ref().map_or(0.0, |wheel| wheel.radius);
            if bottom(&wheel) < ground - ABOVE_GROUND * radius && self.known.wheels.is_empty() {
                self.say(format!("joint {} is above the ground, so it is no wheel", wheel.name));
                continue;
            }
            let is_caster = self.known.wheels.is_empty() && is_caster(&self.urdf.links, number);
            if is_caster { &mut self.casters } else { &mut self.wheels }.push((number, wheel));
        }
        if !on_both_sides(&self.wheels) && on_both_sides(&self.casters) {
            self.drive_casters();
        }
    }

    /// Drives the wheels that seemed casters, as there are no others: a youBot calls its wheels so.
    fn drive_casters(&mut self) {
        let (middle, sides) = std::mem::take(&mut self.casters).into_iter().partition(|(_, it)| is_in_middle(it));
        self.casters = middle;
        self.wheels.extend::<Vec<_>>(sides);
        for number in 0..self.wheels.len() {
            self.hold_swivel(self.wheels[number].0);
        }
        self.say("wheels that are called casters are driven, as there are no others".to_owned());
    }

    /// Guesses the steering. A robot without wheels on both sides stands on legs or is fixed, and its possible wheels are joints.
    fn steering(&mut self) -> Steering {
        if !on_both_sides(&self.wheels) {
            self.wheels.clear();
            self.casters.clear();
            let feet = legs::feet(&self.urdf.links);
            if feet.is_empty() {
                self.say("no wheels on both sides: it is fixed to the ground".to_owned());
                return Steering::None;
            }
            self.say(format!("no wheels, but legs: it stands on {}", feet.join(", ")));
            return Steering::Legged;
        }
        let names =
            |wheels: &[(usize, Link)]| wheels.iter().map(|(_, link)| link.name.as_str()).collect::<Vec<_>>().join(", ");
        let Known { drive, mecanum, .. } = self.known;
        let may_steer = drive.is_none_or(|drive| drive == WheelDrive::Car);
        let steered = if may_steer { self.name_steered() } else { Vec::new() };
        if steered.is_empty() {
            if drive == Some(WheelDrive::Car) {
                self.say("no joint steers a wheel, so it is no car".to_owned());
            }
            let is_mecanum = drive.map_or(mecanum, |drive| drive == WheelDrive::Mecanum);
            if is_mecanum && self.add_rollers() {
                let wheels = names(&self.wheels);
                let who = if drive.is_some() { "as was said" } else { "as names or Gazebo's settings say" };
                self.say(format!("Mecanum wheels, {who}: {wheels}"));
                self.say(format!(
                    "rollers are guessed: {ROLLERS} on each wheel at 45 degrees, their axes at {AXIS_CIRCLE} of its radius"
                ));
                return Steering::Omni;
            }
            let wheels = names(&self.wheels);
            self.say(format!("steered by the sides of its wheels; its driven wheels are {wheels}"));
            return Steering::Skid;
        }
        let wheels = names(&self.wheels);
        self.say(format!("steered as a car by {}; its driven wheels are {wheels}", steered.join(", ")));
        for motor in self.wheels.iter_mut().filter_map(|(_, link)| link.joint.as_mut()?.drive.as_mut()) {
            // Wheels of one speed have to yield in a bend.
            (motor.integral_time, motor.armature) = (None, 0.0);
        }
        Steering::Ackermann
    }

    /// Returns the joints that steer wheels, and names them as a car's.
    fn name_steered(&mut self) -> Vec<String> {
        let middle = self.wheels.iter().map(|(_, link)| link.origin()[0]).sum::<f64>() / self.wheels.len() as f64;
        let mut steered = Vec::new();
        let parents: Vec<usize> = self.wheels.iter().filter_map(|(_, it)| Some(it.joint.as_ref()?.parent)).collect();
        for parent in parents {
            let link = &mut self.urdf.links[parent];
            let upright = |joint: &scene::Joint| joint.kind == JointKind::Revolute && joint.axis[2].abs() > NEARLY;
            if !link.joint.as_ref().is_some_and(upright) {
                continue;
            }
            let name = link.name.clone();
            self.urdf.is_driven(&name);
            let link = &mut self.urdf.links[parent];
            if link.steered_axle().is_none() {
                let axle = if link.origin()[0] > middle { "FrontSteer" } else { "RearSteer" };
                let name = format!("{}_{axle}", link.name);
                self.changes.push(Change::Rename(std::mem::replace(&mut link.name, name.clone()), name));
            }
            steered.push(link.name.clone());
            self.set_steering_motor(parent);
        }
        steered
    }

    /// Gives a joint that steers a servo that holds its angle against friction, as a joint with a name of USARSim gets. Where the file gives
    /// no effort, as some exporters write it, torque and speed are guessed.
    fn set_steering_motor(&mut self, number: usize) {
        let torque =
            (STEERING_PUSH * check::EARTH_GRAVITY * self.mass()).clamp(check::MAX_TORQUE.least, check::MAX_TORQUE.most);
        let inertia = urdf::inertia_beyond(&self.urdf.links, number);
        let link = &mut self.urdf.links[number];
        let Some(joint) = link.joint.as_mut().filter(|joint| joint.drive.is_some() || joint.coupling.is_none()) else {
            return;
        };
        let given = joint.drive.as_ref().map(|motor| (motor.max_speed, motor.max_torque));
        let (max_speed, max_torque) = given.unwrap_or((STEERING_SPEED, torque));
        joint.drive = Some(urdf::servo(joint.kind, max_speed, max_torque, inertia, urdf::STEERING_ERROR));
        if given.is_none() {
            let name = link.name.clone();
            self.changes.push(Change::Limit(name.clone(), [torque, STEERING_SPEED]));
            self.urdf
                .say_of(&name, format!("steers with {torque:.1} N m and {STEERING_SPEED} rad/s, as the effort is 0"));
        }
    }

    /// Adds rollers to four wheels, and orders them as an omni base. Returns false if they do not form one.
    fn add_rollers(&mut self) -> bool {
        let corner = |link: &Link| (link.origin()[0] < 0.0, link.origin()[1] > 0.0);
        let mut corners: Vec<_> = self.wheels.iter().map(|(_, link)| corner(link)).collect();
        corners.sort_unstable();
        if corners != [(false, false), (false, true), (true, false), (true, true)] {
            self.say("Mecanum wheels are plain ones: expected four, around the origin".to_owned());
            return false;
        }
        self.wheels.sort_by_key(|(_, link)| corner(link));
        let material = (self.material)(ROLLER);
        for ((_, link), sign) in self.wheels.iter_mut().zip([1.0, -1.0, -1.0, 1.0]) {
            let Some(wheel) = &mut link.wheel else { continue };
            let mass = (ROLLERS_MASS * wheel.mass / f64::from(ROLLERS)).max(check::ROLLER_MASS.least);
            wheel.mass *= 1.0 - ROLLERS_MASS;
            wheel.rollers = Some(Rollers {
                count: ROLLERS,
                axis_circle: AXIS_CIRCLE * wheel.radius,
                angle: sign * std::f64::consts::FRAC_PI_4,
                first_roller: 0.0,
                last_phase: std::f64::consts::PI / f64::from(ROLLERS),
                mass,
                damping: ROLLER_DAMPING,
                bearing_friction: 0.0,
                material: material.clone(),
            });
        }
        true
    }

    /// Puts balls in the place of casters. Joints that they swivel about are held.
    fn free_casters(&mut self) {
        let ground = self.wheels.iter().map(|(_, wheel)| bottom(wheel)).fold(f64::MIN, f64::max);
        for (number, caster) in std::mem::take(&mut self.casters) {
            self.hold_swivel(number);
            self.hold(number);
            let solids = std::mem::take(&mut self.urdf.links[number].solids);
            self.changes.extend(solids.into_iter().map(|solid| Change::NoCollision(solid.name)));
            let radius = caster.wheel.as_ref().map_or(0.0, |wheel| wheel.radius);
            self.add_ball(&caster.name, caster.origin(), radius, number);
        }
        if self.wheels.is_empty() {
            return;
        }
        let tolerance =
            ABOVE_GROUND * self.wheels.iter().filter_map(|(_, it)| Some(it.wheel.as_ref()?.radius)).fold(0.0, f64::max);
        for number in 0..self.urdf.links.len() {
            if self.wheels.iter().any(|(wheel, _)| *wheel == number) {
                continue;
            }
            let solids = std::mem::take(&mut self.urdf.links[number].solids);
            let (casters, others) = solids.into_iter().partition(|solid| {
                let [_, high] = bounds(&solid.shape, &solid.pose());
                is_called_caster(&solid.name) && (high.z - ground).abs() < tolerance
            });
            self.urdf.links[number].solids = others;
            for solid in casters.into_iter() as std::vec::IntoIter<scene::Solid> {
                let [low, high] = bounds(&solid.shape, &solid.pose());
                let radius = ((high.z - low.z) / 2.0).max(check::WHEEL_RADIUS.least);
                let middle = nalgebra::center(&low, &high);
                self.add_ball(&solid.name, [middle.x, middle.y, high.z - radius], radius, number);
                self.changes.push(Change::NoCollision(solid.name));
            }
        }
    }

    fn add_ball(&mut self, of: &str, mut position: [f64; 3], radius: f64, on: usize) {
        let ground = self.wheels.iter().map(|(_, wheel)| bottom(wheel)).fold(f64::MIN, f64::max);
        let lower = position[2] + radius - ground;
        let is_raised = (SEEN..CASTER_LOWER).contains(&lower);
        if is_raised {
            position[2] -= lower + CASTER_ABOVE;
        }
        let links = &self.urdf.links;
        let held = |number: &usize| links[*number].joint.as_ref().filter(|it| it.kind == JointKind::Fixed);
        let carrier = std::iter::successors(Some(on), |number| held(number).map(|joint| joint.parent)).last();
        let side = if position[1] < 0.0 { Side::Left } else { Side::Right };
        let mass = (BALL_MASS * self.mass()).max(check::WHEEL_MASS.least);
        let width = 2.0 * radius;
        let wheel = Wheel {
            side,
            radius,
            width,
            mass,
            material: (self.material)(CASTER),
            rollers: None,
            belt: None,
            tyre: None,
        };
        let mut name = format!("{of}_ball");
        while self.balls.iter().any(|ball| ball.name == name) {
            name.push('_');
        }
        let mut ball = Link::of_wheel(name, position, None, wheel);
        if let Some(joint) = &mut ball.joint {
            joint.parent = carrier.unwrap_or(0);
        }
        let raised = if is_raised { ", raised above the ground of the driven wheels" } else { "" };
        self.say(format!("{of} is a caster, a ball of {radius:.4} m that turns freely{raised}"));
        self.balls.push(ball);
    }

    /// Holds the joint that carries a link's joint, if that swivels.
    fn hold_swivel(&mut self, number: usize) {
        let Some(parent) = self.urdf.links[number].joint.as_ref().map(|joint| joint.parent) else { return };
        if self.urdf.links[parent].joint.as_ref().is_some_and(|joint| joint.kind == JointKind::Continuous) {
            self.hold(parent);
        }
    }

    /// Holds joints that follow a wheel, which has no position to follow.
    fn hold_followers(&mut self) {
        let is_wheel = |number: usize| self.wheels.iter().any(|(wheel, _)| *wheel == number);
        let leader = |link: &Link| link.joint.as_ref().and_then(|joint| joint.coupling).map(|it| it.leader);
        let links = self.urdf.links.iter().enumerate();
        let followers = links.filter(|(number, link)| !is_wheel(*number) && leader(link).is_some_and(is_wheel));
        for number in followers.map(|(number, _)| number).collect::<Vec<_>>() {
            self.hold(number);
            self.say(format!("joint {} follows a wheel and is held", self.urdf.links[number].name));
        }
    }

    fn hold(&mut self, number: usize) {
        let link = &mut self.urdf.links[number];
        if let Some(joint) = &mut link.joint {
            (joint.kind, joint.limits, joint.drive, joint.coupling) = (JointKind::Fixed, None, None, None);
            self.changes.push(Change::Hold(link.name.clone()));
        }
    }

    /// Lowers limits that mean "none" in a URDF: with them a robot would throw itself over walls.
    fn limit_motors(&mut self) {
        let mass = self.mass();
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

    fn finish(mut self) -> (Vec<Link>, Vec<String>) {
        self.urdf.finish_notes();
        let (numbers, made): (Vec<usize>, Vec<Link>) = self.wheels.into_iter().unzip();
        (rebuilt(self.urdf.links, &numbers, made.into_iter().chain(self.balls)), self.urdf.assumptions)
    }
}

/// Returns the height of a wheel's lowest point, z down, m.
fn bottom(wheel: &Link) -> f64 {
    wheel.origin()[2] + wheel.wheel.as_ref().map_or(0.0, |wheel| wheel.radius)
}

fn on_both_sides(wheels: &[(usize, Link)]) -> bool {
    let is_on = |left: bool| wheels.iter().any(|(_, it)| !is_in_middle(it) && (it.origin()[1] < 0.0) == left);
    is_on(true) && is_on(false)
}

fn is_in_middle(link: &Link) -> bool {
    link.origin()[1].abs() < MIDDLE
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

/// True for a caster: its name or that of its carrier says so, or it is in the middle.
fn is_caster(links: &[Link], number: usize) -> bool {
    let link = &links[number];
    let parent = link.joint.as_ref().and_then(|joint| links.get(joint.parent));
    let named =
        |link: &Link| is_called_caster(&link.name) || link.parts.iter().any(|part| is_called_caster(&part.name));
    let swivels = parent.filter(|it| it.joint.as_ref().is_some_and(|joint| joint.kind == JointKind::Continuous));
    named(link) || swivels.is_some_and(named) || is_in_middle(link)
}

fn is_called_caster(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    ["caster", "castor"].iter().any(|word| name.contains(word))
}
