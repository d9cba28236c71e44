//! Robots of four wheels, or two and casters, from their dimensions.

use std::f64::consts::{FRAC_PI_4, PI};

use nalgebra::{Matrix3, Vector3};
use scene::{
    Link, MapDef, Material, Motor, Part, RobotDef, Rollers, Shape, Side, Solid, Steering, Tyre, Wheel, WorldDef,
};
use serde::Deserialize;

/// Class of the robot in its world.
pub(super) const CLASS: &str = "Measured";
/// Share of the robot's mass in each wheel.
const WHEEL_SHARE: f64 = 0.02;
/// Share of a wheel's mass in its rollers.
const ROLLER_SHARE: f64 = 0.2;
/// Radius on which the axes of rollers lie over that of the wheel.
const AXIS_CIRCLE: f64 = 0.75;
/// Greatest speed of a rim, m/s.
const FASTEST: f64 = 5.0;

/// Dimensions of a robot, SI units.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dimensions {
    /// Whole mass.
    pub mass: f64,
    /// Distance of the axles; 0 is one axle, with casters before and behind it.
    pub wheelbase: f64,
    /// Distance of the wheels' middles across.
    pub track: f64,
    /// Radius of a wheel.
    pub radius: f64,
    /// Width of a wheel.
    pub width: f64,
    /// Way of the centre of mass ahead of the middle of the wheels.
    #[serde(default)]
    pub centre: f64,
    /// Height of the centre of mass above the floor; by default that of the axles.
    pub height: Option<f64>,
    /// Tyre; without one the wheels are rigid discs.
    pub tyre: Option<Tyre>,
    /// Rollers; with them the wheels are Mecanum wheels.
    pub rollers: Option<RollersEntry>,
    /// Motors that slow down under a load; without them the wheels keep their speeds.
    pub motor: Option<LinearMotor>,
}

/// Rollers of a Mecanum wheel.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RollersEntry {
    /// Number on a wheel.
    pub count: u32,
    /// Dry friction of their bearings over the load.
    #[serde(default)]
    pub bearing_friction: f64,
}

/// A motor whose torque falls evenly with its speed, at the wheel.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinearMotor {
    /// N m.
    pub stall_torque: f64,
    /// rad/s.
    pub free_speed: f64,
}

/// Floor that a robot was measured on.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Floor {
    /// Coulomb friction between tyre and floor.
    pub friction: f64,
    /// Rolling resistance between tyre and floor.
    pub rolling_resistance: f64,
}

impl Floor {
    /// Returns a level map of it.
    pub(crate) fn map(self) -> MapDef {
        let ground = solid("floor", Shape::HalfSpace, self.material("floor", self.rolling_resistance));
        MapDef { name: "floor".to_owned(), gravity: 9.81, solids: vec![ground], ..MapDef::default() }
    }

    /// Returns a material with its friction: a pair has the mean of both. Of rolling resistances a pair has the sum.
    fn material(self, name: &str, rolling_resistance: f64) -> Material {
        Material { name: name.to_owned(), friction: self.friction, rolling_resistance, ..Material::default() }
    }
}

fn solid(name: &str, shape: Shape, material: Material) -> Solid {
    Solid { name: name.to_owned(), shape, position: [0.0; 3], rotation: [0.0; 3], material }
}

impl Dimensions {
    /// Checks what the world of the robot is computed from. The world has checks of its own.
    pub(super) fn check(&self) -> Result<(), String> {
        let rollers = self.rollers.map_or(3, |rollers| rollers.count);
        for (key, value, range) in [
            ("mass", self.mass, 0.01..=1e5),
            ("wheelbase", self.wheelbase, 0.0..=20.0),
            ("track", self.track, 0.01..=20.0),
            ("radius", self.radius, 0.004..=5.0),
            ("width", self.width, 0.001..=self.track),
            ("count of rollers", f64::from(rollers), 3.0..=32.0),
        ] {
            if !range.contains(&value) {
                return Err(format!("`{key}` is {value}: expected {} to {}", range.start(), range.end()));
            }
        }
        if self.rollers.is_some() && self.wheelbase == 0.0 {
            return Err("`rollers` on one axle: expected a `wheelbase`".to_owned());
        }
        Ok(())
    }

    /// Returns the world of the robot on a level floor.
    pub(super) fn world(&self, floor: Floor) -> WorldDef {
        let map = floor.map();
        let material = |name: &str, rolling_resistance: f64| floor.material(name, rolling_resistance);
        let robots = [(CLASS.to_owned(), self.robot(&material))].into();
        WorldDef { map, robots, ..WorldDef::default() }
    }

    fn robot(&self, material: &dyn Fn(&str, f64) -> Material) -> RobotDef {
        let &Self { mass, wheelbase, track, radius, width, centre, height, .. } = self;
        let wheel_mass = mass * WHEEL_SHARE;
        let ways: &[f64] = if wheelbase > 0.0 { &[1.0, -1.0] } else { &[0.0] };
        let wheels = 2.0 * ways.len() as f64;
        let body = mass - wheels * wheel_mass;
        // Wheels are at the height of the frame, which points down.
        let size = [wheelbase.max(track), track - width, radius];
        let up = (height.unwrap_or(radius) - radius) * mass / body;
        let moments = [0, 1, 2].map(|axis| {
            let [one, other] = [size[(axis + 1) % 3], size[(axis + 2) % 3]];
            body * (one * one + other * other) / 12.0
        });
        let part = Part {
            name: "body".to_owned(),
            mass: body,
            centre: Vector3::new(centre * mass / body, 0.0, -up),
            inertia: Matrix3::from_diagonal(&moments.into()),
        };
        let solids = vec![solid("body", Shape::Box { size: size.map(|length| length * 0.9) }, material("body", 0.0))];
        let mut links = vec![Link { name: "body".to_owned(), parts: vec![part], solids, ..Link::default() }];
        // Without a motor the wheels keep their speeds.
        let stiff = Motor {
            max_speed: FASTEST / radius,
            gain: 100.0 * mass * radius * radius,
            max_torque: 10.0 * mass * radius,
            stiffness: None,
            integral_time: Some(0.05),
            armature: 0.0,
        };
        let linear = |LinearMotor { stall_torque, free_speed }: LinearMotor| Motor {
            max_speed: free_speed,
            gain: stall_torque / free_speed,
            max_torque: stall_torque,
            integral_time: None,
            ..stiff.clone()
        };
        let motor = self.motor.map_or_else(|| stiff.clone(), linear);
        let wheel = |side| Wheel {
            side,
            radius,
            width,
            mass: wheel_mass,
            material: material("tyre", 0.0),
            rollers: None,
            belt: None,
            tyre: self.tyre,
        };
        // Axes of the rollers form an X as seen from above.
        let rollers = |RollersEntry { count, bearing_friction }: RollersEntry, sign: f64| Rollers {
            count,
            axis_circle: AXIS_CIRCLE * radius,
            angle: sign * FRAC_PI_4,
            first_roller: 0.0,
            last_phase: PI / f64::from(count),
            mass: wheel_mass * ROLLER_SHARE / f64::from(count),
            damping: 0.0,
            bearing_friction,
            material: material("roller", 0.0),
        };
        for (row, way) in ways.iter().enumerate() {
            for (name, y, side) in [("Left", -track / 2.0, Side::Left), ("Right", track / 2.0, Side::Right)] {
                let position = [way * wheelbase / 2.0, y, 0.0];
                let rollers = self.rollers.map(|it| rollers(it, -way * y.signum()));
                let wheel = Wheel { rollers, ..wheel(side) };
                links.push(Link::of_wheel(format!("{name}{row}"), position, Some(motor.clone()), wheel));
            }
        }
        if wheelbase <= 0.0 {
            for (name, x) in [("FrontCaster", 0.8), ("BackCaster", -0.8)] {
                let ball = Wheel { radius: radius / 2.0, tyre: None, ..wheel(Side::Left) };
                links.push(Link::of_wheel(name.to_owned(), [x * track / 2.0, 0.0, radius / 2.0], None, ball));
            }
        }
        let steering = if self.rollers.is_some() { Steering::Omni } else { Steering::Skid };
        RobotDef::new(CLASS, steering, links)
    }
}
