//! The kinematics that fit a class of robots, in both directions.

use kinematics::{FiniteRollers, Mecanum, Skid, Twist};
use nalgebra::Matrix2;
use scene::{Drivetrain, MountedWheel, RobotDef, Side};

use crate::mecanum;
use crate::sliding::{self, Place};
use crate::steering::centre;

/// Most corrections of the speeds of two sides.
const MOST_CORRECTIONS: usize = 30;
/// Error of a twist at which corrections end, as a fraction of it.
const CLOSE: f64 = 1e-4;
/// Difference of the slopes of front and rear wheels below which a car drives straight.
const STRAIGHT: f64 = 1e-9;

/// Assumption about wheels that cannot all roll without slip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Ideal wheels: those of a skid robot do not slip sideways, and Mecanum wheels have infinitely many rollers. USARSim and most drivers
    /// of real robots compute so.
    Ideal,
    /// Wheels as they are: those of a skid robot slide until their friction balances, and Mecanum wheels have the rollers that they have.
    True,
}

/// The kinematics of a class of robots.
#[derive(Debug, Clone, PartialEq)]
pub enum Base {
    /// Two sides whose wheels do not slip.
    Skid {
        /// Their kinematics.
        kinematics: Skid,
        /// Numbers of the foremost left and right wheel among the driven ones.
        wheels: [usize; 2],
    },
    /// Two sides whose wheels slide until their friction balances.
    Sliding(Sliding),
    /// Mecanum wheels with infinitely many rollers.
    Mecanum(Mecanum),
    /// Mecanum wheels with the rollers that they have.
    FiniteMecanum(FiniteRollers),
    /// Steered wheels.
    Car(Car),
    /// Two sides by the numbers of a driver, and the side of each driven wheel.
    Driver(DiffDrive, Vec<Side>),
}

/// Two sides as the driver of a real robot counts them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiffDrive {
    /// Distance of the sides, m, with the multiplier that its maker found.
    pub track: f64,
    /// Radii of the left and right wheels, m, with their multipliers.
    pub radii: [f64; 2],
}

/// Two sides of wheels that slide.
#[derive(Debug, Clone, PartialEq)]
pub struct Sliding {
    places: Vec<Place>,
    /// Side of each driven wheel.
    sides: Vec<Side>,
    /// Kinematics of the base if nothing slipped.
    ideal: Skid,
}

/// A base whose wheels stand on circles about one centre.
#[derive(Debug, Clone, PartialEq)]
pub struct Car {
    /// Distance of the axles, m.
    wheel_base: f64,
    /// Forward and to the right, and radius, m, of each driven wheel.
    driven: Vec<[f64; 3]>,
    /// Foremost driven wheel, m.
    front: f64,
    /// True if only the rear axle steers.
    steers_behind: bool,
}

/// A drive of a base: what its wheels and axles have to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    /// Speeds of the wheels of left and right, rad/s.
    Sides([f64; 2]),
    /// Speeds of four Mecanum wheels, rad/s: front left, front right, back left, back right.
    Wheels([f64; 4]),
    /// Speed of every driven wheel, rad/s, and the angles of front and rear axle, rad, positive to the right.
    Car {
        /// rad/s.
        speed: f64,
        /// rad.
        steer: [f64; 2],
    },
}

impl Base {
    /// Returns the kinematics of a class of robots; `None` if it has no driven wheels that they fit.
    pub fn of(robot: &RobotDef, model: Model) -> Option<Self> {
        match (robot.drivetrain(), model) {
            (Drivetrain::Mecanum, Model::Ideal) => mecanum::textbook(robot).map(Self::Mecanum),
            (Drivetrain::Mecanum, Model::True) => mecanum::finite_rollers(robot).map(Self::FiniteMecanum),
            (Drivetrain::Sides, Model::Ideal) => {
                skid(robot).map(|(kinematics, wheels)| Self::Skid { kinematics, wheels })
            }
            (Drivetrain::Sides, Model::True) => {
                let (ideal, _) = skid(robot)?;
                let sides = robot.driven().map(|wheel| wheel.side).collect();
                Some(Self::Sliding(Sliding { places: sliding::places(robot), sides, ideal }))
            }
            (Drivetrain::Steered, _) => Some(Self::Car(Car::of(robot))),
            (Drivetrain::None, _) => None,
        }
    }

    /// Returns the kinematics of a class of robots by the numbers of its driver.
    pub fn of_driver(robot: &RobotDef, numbers: DiffDrive) -> Self {
        Self::Driver(numbers, robot.driven().map(|wheel| wheel.side).collect())
    }

    /// Returns the kinematics of a car by the numbers of its driver: the distance of its axles and the radius of its wheels, m.
    pub fn of_car_driver(robot: &RobotDef, wheel_base: f64, radius: f64) -> Self {
        let mut car = Car::of(robot);
        car.wheel_base = wheel_base;
        car.driven.iter_mut().for_each(|[.., own]| *own = radius);
        Self::Car(car)
    }

    /// Returns the displacement of the base, m and rad clockwise, while its driven wheels turn by `turned` to `angles`, rad. `steer` is the
    /// mean angle of a car's front and rear axle, rad, positive to the right.
    pub fn displacement(&self, turned: &[f64], angles: &[f64], steer: [f64; 2]) -> Twist {
        let of = |numbers: &[f64], wheel: usize| numbers.get(wheel).copied().unwrap_or(0.0);
        // Angles instead of speeds give a displacement instead of a twist, because time cancels out.
        match self {
            Self::Skid { kinematics, wheels } => kinematics.forward(wheels.map(|wheel| of(turned, wheel))),
            Self::Sliding(sliding) => sliding::twist(&sliding.places, turned),
            Self::Mecanum(kinematics) => kinematics.forward(std::array::from_fn(|wheel| of(turned, wheel))),
            Self::FiniteMecanum(kinematics) => {
                // The phase at the middle of the interval.
                let phase = |wheel| kinematics.phase(wheel, of(angles, wheel) - of(turned, wheel) / 2.0);
                kinematics.forward(std::array::from_fn(|wheel| of(turned, wheel)), std::array::from_fn(phase))
            }
            Self::Car(car) => car.displacement(turned, steer),
            Self::Driver(DiffDrive { track, radii }, sides) => {
                let mean = |side: Side| {
                    let on_side = sides.iter().zip(turned).filter(|(of, _)| **of == side).map(|(_, turned)| *turned);
                    let count = sides.iter().filter(|of| **of == side).count();
                    on_side.sum::<f64>() / count.max(1) as f64
                };
                let [left, right] = [mean(Side::Left) * radii[0], mean(Side::Right) * radii[1]];
                Twist { forward: (left + right) / 2.0, right: 0.0, clockwise: (left - right) / track }
            }
        }
    }

    /// Returns the drive that moves the base with a twist. A part of it that the base cannot do is left out.
    pub fn drive(&self, twist: Twist) -> Drive {
        match self {
            Self::Skid { kinematics, .. } => Drive::Sides(kinematics.inverse(twist)),
            Self::Sliding(sliding) => Drive::Sides(sliding.inverse(twist)),
            Self::Mecanum(kinematics) => Drive::Wheels(kinematics.inverse(twist)),
            Self::FiniteMecanum(rollers) => Drive::Wheels(rollers.base.inverse(Twist {
                forward: twist.forward,
                right: twist.right / rollers.mean_lateral_ratio(),
                clockwise: twist.clockwise / rollers.mean_rotation_ratio(),
            })),
            Self::Car(car) => car.drive(twist),
            Self::Driver(DiffDrive { track, radii: [left, right] }, _) => {
                let turn = twist.clockwise * track / 2.0;
                Drive::Sides([(twist.forward + turn) / left, (twist.forward - turn) / right])
            }
        }
    }
}

/// Returns the kinematics of two sides without slip, and the numbers of the foremost left and right driven wheel (Odometry.uc:40-97).
fn skid(robot: &RobotDef) -> Option<(Skid, [usize; 2])> {
    let foremost = |side| {
        let on_side = robot.driven().enumerate().filter(|(_, wheel)| wheel.side == side);
        on_side.max_by(|a, b| a.1.position[0].total_cmp(&b.1.position[0]))
    };
    let ((left, _), (right, wheel)) = foremost(Side::Left).zip(foremost(Side::Right))?;
    Some((Skid { wheel_radius: wheel.radius, track: 2.0 * wheel.position[1] }, [left, right]))
}

impl Sliding {
    /// Returns the twist for speeds of left and right, rad/s.
    fn forward(&self, [left, right]: [f64; 2]) -> Twist {
        let speed = |side: &Side| if *side == Side::Left { left } else { right };
        sliding::twist(&self.places, &self.sides.iter().map(speed).collect::<Vec<f64>>())
    }

    /// Returns the speeds of left and right, rad/s, at which friction balances at a twist, as far as two sides can do it. The search is
    /// Newton's, from the speeds without slip; the slopes are differences.
    fn inverse(&self, twist: Twist) -> [f64; 2] {
        let lever = self.ideal.track / 2.0;
        let error = |speeds: [f64; 2]| {
            let got = self.forward(speeds);
            [twist.forward - got.forward, lever * (twist.clockwise - got.clockwise)]
        };
        let size = twist.forward.abs() + lever * twist.clockwise.abs();
        let start = self.ideal.inverse(twist);
        let mut speeds = start;
        for _ in 0..MOST_CORRECTIONS {
            let now = error(speeds);
            if now[0].abs() + now[1].abs() <= CLOSE * size {
                return speeds;
            }
            let step = 1e-3 * size / self.ideal.wheel_radius;
            let [left, right] = [error([speeds[0] + step, speeds[1]]), error([speeds[0], speeds[1] + step])];
            let slopes = Matrix2::new(left[0] - now[0], right[0] - now[0], left[1] - now[1], right[1] - now[1]) / step;
            let Some(inverse) = slopes.try_inverse() else { break };
            let correction = inverse * nalgebra::Vector2::from(now);
            speeds = [speeds[0] - correction.x, speeds[1] - correction.y];
        }
        if speeds.iter().all(|speed| speed.is_finite()) { speeds } else { start }
    }
}

impl Car {
    fn of(robot: &RobotDef) -> Self {
        let place = |wheel: MountedWheel| [wheel.position[0], wheel.position[1], wheel.radius];
        let driven: Vec<[f64; 3]> = robot.driven().map(place).collect();
        let front = driven.iter().map(|[x, ..]| *x).fold(f64::NEG_INFINITY, f64::max);
        let steers = |axle| robot.links.iter().any(|link| link.steered_axle() == Some(axle));
        Self { wheel_base: robot.wheel_geometry().wheel_base, driven, front, steers_behind: steers(1) && !steers(0) }
    }

    /// Returns the turning centre, forward and to the right, m; `None` if the car drives straight.
    fn centre(&self, steer: [f64; 2]) -> Option<[f64; 2]> {
        let [front, rear] = steer.map(libm::tan);
        ((front - rear).abs() > STRAIGHT).then(|| centre(self.wheel_base, self.front, steer))
    }

    /// Returns the sum of the distances that the driven wheels roll while the base turns by 1 rad about a centre.
    fn rolled(&self, [x, y]: [f64; 2]) -> f64 {
        let distance = |[wheel_x, wheel_y, _]: &[f64; 3]| {
            let [dx, dy] = [x - wheel_x, y - wheel_y];
            (dx * dx + dy * dy).sqrt()
        };
        y.signum() * self.driven.iter().map(distance).sum::<f64>()
    }

    fn displacement(&self, turned: &[f64], steer: [f64; 2]) -> Twist {
        let rolled = self.driven.iter().zip(turned).map(|([.., radius], turned)| radius * turned).sum::<f64>();
        match self.centre(steer) {
            None => Twist { forward: rolled / self.driven.len().max(1) as f64, ..Twist::default() },
            Some([x, y]) => {
                let clockwise = rolled / self.rolled([x, y]);
                Twist { forward: clockwise * y, right: -clockwise * x, clockwise }
            }
        }
    }

    /// Turns the steering axle so that the middle of the other one follows the twist. A car cannot turn on the spot.
    fn drive(&self, twist: Twist) -> Drive {
        let slope = self.wheel_base * twist.clockwise / twist.forward;
        let steer = if !slope.is_finite() {
            [0.0; 2]
        } else if self.steers_behind {
            [0.0, -libm::atan(slope)]
        } else {
            [libm::atan(slope), 0.0]
        };
        let rolled = match self.centre(steer) {
            None => twist.forward * self.driven.len() as f64,
            Some(centre) => twist.clockwise * self.rolled(centre),
        };
        // All turn at one speed, also where their radii differ.
        Drive::Car { speed: rolled / self.driven.iter().map(|[.., radius]| radius).sum::<f64>(), steer }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(class: &str, twist: Twist, tolerance: f64) {
        let world = scene_loader::load("rough", &[]).expect("a scene");
        let robot = &world.robots[class];
        let base = Base::of(robot, Model::True).expect("a base on wheels");
        let (speeds, steer): (Vec<f64>, [f64; 2]) = match base.drive(twist) {
            Drive::Sides([left, right]) => {
                (robot.driven().map(|it| if it.side == Side::Left { left } else { right }).collect(), [0.0; 2])
            }
            Drive::Wheels(speeds) => (speeds.to_vec(), [0.0; 2]),
            Drive::Car { speed, steer } => (robot.driven().map(|_| speed).collect(), steer),
        };
        // A whole turn of the wheels, as the displacement of rollers depends on their phases.
        let steps = 1000;
        let mut got = [0.0; 3];
        for step in 0..steps {
            let angles: Vec<f64> = speeds.iter().map(|speed| speed * f64::from(step + 1) / 100.0).collect();
            let turned: Vec<f64> = speeds.iter().map(|speed| speed / 100.0).collect();
            let Twist { forward, right, clockwise } = base.displacement(&turned, &angles, steer);
            got = [got[0] + forward, got[1] + right, got[2] + clockwise];
        }
        let got = got.map(|sum| sum * 100.0 / f64::from(steps));
        let expected = [twist.forward, twist.right, twist.clockwise];
        // Nothing steers where a base that slides goes sideways.
        let is_free = |axis| axis == 1 && matches!(base, Base::Sliding(_));
        let close = (0..3).all(|axis| is_free(axis) || (got[axis] - expected[axis]).abs() <= tolerance);
        assert!(close, "{class}: {got:?}, not {expected:?}");
    }

    #[test]
    fn a_drive_gives_its_twist() {
        let twist = |forward, right, clockwise| Twist { forward, right, clockwise };
        check("P3AT", twist(0.5, 0.0, 0.0), 1e-3);
        check("P3AT", twist(0.0, 0.0, 0.5), 1e-3);
        check("P3AT", twist(0.3, 0.0, -0.4), 1e-3);
        check("P3AT", twist(-0.3, 0.0, 0.01), 1e-3);
        check("P2DX", twist(0.3, 0.0, -0.4), 1e-3);
        check("Kenaf", twist(0.2, 0.0, 0.3), 1e-3);
        check("KUKA_YouBot", twist(0.3, 0.0, 0.0), 2e-3);
        check("KUKA_YouBot", twist(0.0, 0.3, 0.0), 2e-3);
        check("KUKA_YouBot", twist(0.0, 0.0, 0.5), 3e-3);
    }

    #[test]
    fn a_car_turns_about_the_middle_of_the_axle_that_does_not_steer() {
        let world = scene_loader::load("rough", &[]).expect("a scene");
        let car = Car::of(&world.robots["FrontAckerman"]);
        let twist = Twist { forward: 0.5, right: 0.0, clockwise: 0.3 };
        let Drive::Car { speed, steer } = car.drive(twist) else { panic!("no car") };
        let turned: Vec<f64> = car.driven.iter().map(|_| speed).collect();
        let got = car.displacement(&turned, steer);
        assert!((got.forward - 0.5).abs() < 1e-9 && (got.clockwise - 0.3).abs() < 1e-9, "{got:?}");
        let stopped = car.drive(Twist { forward: 0.0, right: 0.0, clockwise: 1.0 });
        assert_eq!(stopped, Drive::Car { speed: 0.0, steer: [0.0; 2] });
    }
}
