//! Runs of a measured robot in the world.

use gamebots_proto::command::Init;
use nalgebra::Vector3;
use scene::{RobotDef, Shape, Side, Solid, WorldDef, wrapped};
use sim_core::{Options, PawnId, World};

use super::robot::{CLASS, LinearMotor};
use super::{Dimensions, Figure, Measured, Quantity, Row, Strafe, Turn};
use crate::course::{Course, Motion, MotionError, Travel, drive, heading};

/// Speed of the faster side's wheels, m/s.
const SPEED: f64 = 0.4;
/// Time in which a robot settles and comes to its speed, and time of a measurement, s.
const TIMES: [f64; 2] = [3.0, 6.0];
/// Time in which a robot settles before it drives, s.
const SETTLING: f64 = 0.5;
/// Slope on which a robot without power rolls, rad.
const ROLLING: f64 = 0.2;
/// Iterations of the search for a limit. They narrow it to a thousandth of its range.
const HALVINGS: usize = 10;
/// Steepest slope that is tried, rad.
const STEEPEST: f64 = 1.0;

/// Runs every measurement of a file.
///
/// # Errors
/// When the world refuses the robot.
pub fn run(measured: &Measured) -> Result<Vec<Row>, MotionError> {
    let turn = |turn: &Turn| {
        let what = match turn.curvature {
            0.0 => "effective over geometric track, on the spot".to_owned(),
            curvature => format!("effective over geometric track, curvature {curvature}"),
        };
        let Dimensions { radius, track, .. } = measured.robot;
        let def = measured.robot.world(measured.floor);
        let ours = effective_track(def, CLASS, radius, turn.curvature)? / track;
        Ok(Row { curvature: Some(turn.curvature), ..Row::new(what, turn.chi, [turn.spread, turn.within], ours) })
    };
    let strafe = |strafe: &Strafe| {
        let what = if strafe.full_power { "top speed sideways over ahead" } else { "way sideways over ahead" };
        let ours = sideways(measured, strafe.full_power)?;
        Ok(Row::new(what.to_owned(), strafe.ratio, [strafe.spread, strafe.within], ours))
    };
    let figure = |figure: &Figure| {
        let ours = match figure.what {
            Quantity::Sum => sum(measured)?,
            Quantity::Coasting => coasting(measured)?,
            Quantity::Step => highest(1.5 * measured.robot.radius, |step| climbs_step(measured, step))?,
            Quantity::Slope => highest(STEEPEST, |slope| Ok(way(measured, slope)? > SPEED * TIMES[1] / 2.0))?,
            Quantity::Uphill => way(measured, figure.slope)? / way(measured, 0.0)?,
        };
        let (what, is_limit) = (figure.what.name(figure.slope), figure.what.is_limit());
        Ok(Row { is_limit, ..Row::new(what, figure.value, [figure.spread, figure.within], ours) })
    };
    let rows = measured.turn.iter().map(turn).chain(measured.strafe.iter().map(strafe));
    rows.chain(measured.figure.iter().map(figure)).collect()
}

/// Drives a robot on level ground.
fn travel(measured: &Measured, motion: Motion, speed: f64) -> Result<Travel, MotionError> {
    let world = World::new(measured.robot.world(measured.floor), Options::default());
    let mut course = Course::start(world, CLASS, 1, motion, speed)?;
    course.run(TIMES[1]);
    course.travel().ok_or_else(|| MotionError::UnknownRobot(CLASS.to_owned()))
}

/// Measures the way sideways over the way ahead of a Mecanum robot: for the angle that its wheels turned, or in equal times.
fn sideways(measured: &Measured, full_power: bool) -> Result<f64, MotionError> {
    let Dimensions { radius, motor, .. } = &measured.robot;
    let speed = motor.filter(|_| full_power).map_or(SPEED / radius, |motor| motor.free_speed);
    let way = |motion: Motion| {
        let travel = travel(measured, motion, speed)?;
        let [ahead, aside, _] = travel.moved;
        Ok(ahead.hypot(aside) / if full_power { 1.0 } else { travel.turned })
    };
    Ok(way(Motion::Right)? / way(Motion::Forward)?)
}

/// Measures the effective over the geometric lx + ly of a Mecanum robot.
fn sum(measured: &Measured) -> Result<f64, MotionError> {
    let Dimensions { radius, wheelbase, track, .. } = measured.robot;
    let Travel { moved: [.., turn], turned, .. } = travel(measured, Motion::Clockwise, SPEED / radius)?;
    Ok(turned * radius / (turn * (wheelbase + track) / 2.0))
}

/// Measures by how much more a robot without power is braked sideways than ahead, m/s². It rolls down a slope ahead, and one to its side.
fn coasting(measured: &Measured) -> Result<f64, MotionError> {
    let free = LinearMotor { stall_torque: 1e-9, free_speed: 1.0 };
    let free = Measured { robot: Dimensions { motor: Some(free), ..measured.robot.clone() }, ..measured.clone() };
    let acceleration = |slope: [f64; 2]| -> Result<f64, MotionError> {
        let mut run = Run::new(sloped(&free, slope), CLASS, [slope[0], slope[1], 0.0])?;
        run.pass(1.0);
        let speed = |run: &Run| run.world.state(run.robot).map_or(0.0, |(body, _)| body.linear.norm());
        let before = speed(&run);
        run.pass(1.0);
        Ok(speed(&run) - before)
    };
    Ok((acceleration([0.0, -ROLLING])? - acceleration([ROLLING, 0.0])?) / libm::cos(ROLLING))
}

/// Measures how far a robot drives up a slope, rad, or on level ground, m.
fn way(measured: &Measured, slope: f64) -> Result<f64, MotionError> {
    let mut run = Run::new(sloped(measured, [0.0, slope]), CLASS, [0.0, slope, 0.0])?;
    run.pass(SETTLING);
    let start = run.place();
    run.drive(SPEED / measured.robot.radius);
    run.pass(TIMES[1]);
    Ok((run.place() - start).dot(&Vector3::new(libm::cos(slope), 0.0, -libm::sin(slope))))
}

/// Tells if a robot climbs a step, m, that is ahead of it.
fn climbs_step(measured: &Measured, step: f64) -> Result<bool, MotionError> {
    let Dimensions { wheelbase, radius, track, .. } = measured.robot;
    let mut def = measured.robot.world(measured.floor);
    let from = wheelbase / 2.0 + 1.5 * radius;
    let size = [4.0 * wheelbase + 10.0 * radius, 4.0 * track, 1.0];
    def.map.solids.extend(def.map.solids.first().cloned().map(|floor| Solid {
        name: "step".to_owned(),
        shape: Shape::Box { size },
        position: [from + size[0] / 2.0, 0.0, 0.5 - step],
        ..floor
    }));
    let mut run = Run::new(def, CLASS, [0.0; 3])?;
    run.pass(SETTLING);
    run.drive(SPEED / radius);
    // Twice the time that it needs without slip.
    run.pass(2.0 * (2.0 * wheelbase + 4.0 * radius) / SPEED);
    Ok(run.place().x - wheelbase / 2.0 > from && -run.place().z > step + radius / 2.0)
}

/// Returns the greatest number up to `most` that passes. The numbers below it pass, too.
fn highest(most: f64, mut passes: impl FnMut(f64) -> Result<bool, MotionError>) -> Result<f64, MotionError> {
    let (mut low, mut high) = (0.0, most);
    for _ in 0..HALVINGS {
        let middle = (low + high) / 2.0;
        if passes(middle)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(low)
}

/// Returns the world of a robot whose floor has a roll and a pitch, rad.
fn sloped(measured: &Measured, [roll, pitch]: [f64; 2]) -> WorldDef {
    let mut def = measured.robot.world(measured.floor);
    def.map.solids.iter_mut().for_each(|floor| floor.rotation = [roll, pitch, 0.0]);
    def
}

/// Measures the effective track of a robot that turns by a difference of its sides, m: the difference of their wheel speeds over the yaw rate.
pub(crate) fn effective_track(def: WorldDef, class: &str, radius: f64, curvature: f64) -> Result<f64, MotionError> {
    let mut run = Run::new(def, class, [0.0; 3])?;
    let fast = SPEED / radius;
    let slow = fast * (curvature - 1.0) / (curvature + 1.0);
    run.world.execute(Some(run.robot), &drive(&[("Left", fast), ("Right", slow)]), &mut Vec::new());
    run.pass(TIMES[0]);
    let difference = |run: &Run| {
        let wheels = run.world.state(run.robot).map(|(_, wheels)| wheels).unwrap_or_default();
        let sides = run.world.robot(run.robot).into_iter().flat_map(RobotDef::driven).map(|wheel| wheel.side);
        let [mut left, mut right] = [[0.0; 2]; 2];
        for (side, wheel) in sides.zip(&wheels) {
            let [sum, count] = if side == Side::Left { &mut left } else { &mut right };
            (*sum, *count) = (*sum + wheel.angle, *count + 1.0);
        }
        left[0] / left[1] - right[0] / right[1]
    };
    let heading = |run: &Run| run.world.state(run.robot).map_or(0.0, |(body, _)| heading(&body));
    let start = difference(&run);
    let (mut turned, mut last) = (0.0, heading(&run));
    for _ in 0..run.steps(TIMES[1]) {
        run.world.step();
        let now = heading(&run);
        turned += wrapped(now - last);
        last = now;
    }
    Ok((difference(&run) - start) * radius / turned)
}

/// A robot in its world.
struct Run {
    world: World,
    robot: PawnId,
}

impl Run {
    fn new(def: WorldDef, class: &str, rotation: [f64; 3]) -> Result<Self, MotionError> {
        let mut world = World::new(def, Options::default());
        let mut problems = Vec::new();
        let init = Init { class_name: class.to_owned(), rotation, ..Init::default() };
        let robot = world.init(&init, &mut problems).ok_or(MotionError::Refused(problems))?;
        Ok(Self { world, robot })
    }

    /// Drives ahead with wheels at a speed, rad/s.
    fn drive(&mut self, speed: f64) {
        if let Some(def) = self.world.robot(self.robot) {
            let command = Motion::Forward.command(def, speed);
            self.world.execute(Some(self.robot), &command, &mut Vec::new());
        }
    }

    /// Advances the world by a time, s.
    fn pass(&mut self, seconds: f64) {
        (0..self.steps(seconds)).for_each(|_| drop(self.world.step()));
    }

    fn steps(&self, seconds: f64) -> u64 {
        (seconds / self.world.time_step()).round() as u64
    }

    fn place(&self) -> Vector3<f64> {
        self.world.state(self.robot).map_or_else(Vector3::zeros, |(body, _)| body.pose.translation.vector)
    }
}
