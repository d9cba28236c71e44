//! Parameters of a robot's controller, as its ROS package has them in a YAML file.

use std::collections::BTreeMap;

use base_motion::DiffDrive;
use kinematics::Mecanum;
use ros2_topics::{Controller, Limit, VARIANCES, Wheels};
use scene::{Drivetrain, RobotDef};
use serde_json::Value;

/// Longest file, bytes.
const MOST_BYTES: usize = 1 << 20;
/// Types of controllers that drive bases, by a part of their names.
const KINDS: [(&str, Kind); 4] = [
    ("diff_drive_controller", Kind::Sides),
    ("mecanum_drive_controller", Kind::Mecanum),
    ("ackermann_steering_controller", Kind::Car),
    ("bicycle_steering_controller", Kind::Car),
];
/// Time without an order after which ros2_control's controllers stop a robot, s.
const TIMEOUT: f64 = 0.5;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Sides,
    Mecanum,
    Car,
}

/// A controller in a file, with its parameters by their whole names: `linear.x.max_velocity`.
#[derive(Debug, Clone, PartialEq)]
pub struct ControllerFile {
    name: String,
    kind: Kind,
    parameters: BTreeMap<String, Value>,
}

impl ControllerFile {
    /// Reads the one controller of a file that drives a base. Others, as those of arms, do not count.
    ///
    /// # Errors
    /// The reason in words.
    pub fn read(yaml: &str) -> Result<Self, String> {
        if yaml.len() > MOST_BYTES {
            return Err(format!("{} bytes: expected at most {MOST_BYTES}", yaml.len()));
        }
        let tree: Value = serde_saphyr::from_str(yaml).map_err(|error| error.to_string())?;
        let (mut nodes, mut types) = (BTreeMap::new(), BTreeMap::new());
        collect("", &tree, &mut nodes, &mut types);
        let kind_of = |name: &String| {
            let kind: &String = types.get(name)?;
            KINDS.iter().find(|(part, _)| kind.contains(part)).map(|(_, kind)| *kind)
        };
        let mut found = nodes.into_iter().filter_map(|(name, parameters)| {
            let kind = kind_of(&name)?;
            Some(Self { name, kind, parameters })
        });
        match (found.next(), found.next()) {
            (Some(only), None) => Ok(only),
            (None, _) => {
                let known: Vec<&str> = KINDS.iter().map(|(name, _)| *name).collect();
                Err(format!("no controller that drives a base: expected one of type {}", known.join(", ")))
            }
            (Some(one), Some(other)) => {
                Err(format!("two controllers that drive a base, `{}` and `{}`: expected one", one.name, other.name))
            }
        }
    }

    /// Makes the controller of a class of robots, whose dimensions count where the file has none.
    ///
    /// # Errors
    /// The reason in words.
    pub fn of(&self, robot: &RobotDef) -> Result<Controller, String> {
        let fits = matches!(
            (self.kind, robot.drivetrain()),
            (Kind::Sides, Drivetrain::Sides) | (Kind::Mecanum, Drivetrain::Mecanum) | (Kind::Car, Drivetrain::Steered)
        );
        if !fits {
            return Err(format!("`{}` is a controller of other wheels than {} has", self.name, robot.class));
        }
        let geometry = robot.wheel_geometry();
        let positive = |name: &str, default: f64| {
            let number = self.number(name)?.unwrap_or(default);
            let is_good = number.is_finite() && number > 0.0;
            if is_good { Ok(number) } else { Err(format!("`{name}` is {number}: expected a positive number")) }
        };
        let wheels = match self.kind {
            Kind::Sides => {
                let track =
                    positive("wheel_separation", geometry.track)? * positive("wheel_separation_multiplier", 1.0)?;
                let radius = positive("wheel_radius", geometry.radius)? * positive("wheel_radius_multiplier", 1.0)?;
                let [left, right] =
                    ["left", "right"].map(|side| positive(&format!("{side}_wheel_radius_multiplier"), 1.0));
                Wheels::Sides(DiffDrive { track, radii: [radius * left?, radius * right?] })
            }
            Kind::Mecanum => {
                let separations = positive("wheel_separation_x", geometry.wheel_base)?
                    + positive("wheel_separation_y", geometry.track)?;
                let sum = positive("kinematics.sum_of_robot_center_projection_on_X_Y_axis", separations / 2.0)?;
                let sum = sum * positive("wheel_separation_multiplier", 1.0)?;
                let radius = positive("kinematics.wheels_radius", positive("wheel_radius", geometry.radius)?)?;
                let radius = radius * positive("wheel_radius_multiplier", 1.0)?;
                // Only the sum of both counts.
                Wheels::Mecanum(Mecanum { half_wheelbase: sum / 2.0, half_track: sum / 2.0, wheel_radius: radius })
            }
            Kind::Car => {
                let radius = ["traction_wheels_radius", "rear_wheels_radius", "front_wheels_radius", "wheel_radius"];
                let given = radius.iter().find(|name| self.parameters.contains_key(**name)).unwrap_or(&"wheel_radius");
                Wheels::Car {
                    wheel_base: positive("wheelbase", geometry.wheel_base)?,
                    radius: positive(given, geometry.radius)?,
                }
            }
        };
        let frame = |name: &str, default: &str| {
            let given = self.parameters.get(name).and_then(Value::as_str).unwrap_or(default);
            given.trim_start_matches('/').to_owned()
        };
        let timeout = self.number("cmd_vel_timeout")?.or(self.number("reference_timeout")?).unwrap_or(TIMEOUT);
        Ok(Controller {
            name: self.name.clone(),
            wheels,
            odom_frame: frame("odom_frame_id", "odom"),
            base_frame: frame("base_frame_id", "base_link"),
            publishes_transform: self.parameters.get("enable_odom_tf").and_then(Value::as_bool).unwrap_or(true),
            variances: [self.diagonal("pose_covariance_diagonal")?, self.diagonal("twist_covariance_diagonal")?],
            timeout: timeout.clamp(0.0, 1e9),
            limits: [self.limit("linear.x")?, self.limit("linear.y")?, self.limit("angular.z")?],
        })
    }

    fn number(&self, name: &str) -> Result<Option<f64>, String> {
        match self.parameters.get(name) {
            None | Some(Value::Null) => Ok(None),
            Some(value) => match value.as_f64().or_else(|| value.as_str()?.parse().ok()) {
                Some(number) => Ok(Some(number)),
                None => Err(format!("`{name}` is {value}: expected a number")),
            },
        }
    }

    fn diagonal(&self, name: &str) -> Result<[f64; 6], String> {
        let Some(value) = self.parameters.get(name) else { return Ok(VARIANCES) };
        let numbers = value.as_array().and_then(|it| it.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>());
        let six = numbers.and_then(|numbers| numbers.try_into().ok());
        six.ok_or_else(|| format!("`{name}` is {value}: expected six numbers"))
    }

    /// Reads the limits of an axis. Without a least one, it is the greatest backwards.
    fn limit(&self, axis: &str) -> Result<Limit, String> {
        let is_on = |what: &str| {
            let flag = self.parameters.get(&format!("{axis}.has_{what}_limits")).and_then(Value::as_bool);
            flag.unwrap_or(true)
        };
        let number = |name: &str| Ok::<_, String>(self.number(&format!("{axis}.{name}"))?.filter(|it| it.is_finite()));
        let pair = |most: Option<f64>, least: Option<f64>| {
            let most = most.map_or(f64::INFINITY, f64::abs);
            [least.map_or(-most, |least| -least.abs()), most]
        };
        let mut limit = Limit::NONE;
        if is_on("velocity") {
            limit.velocity = pair(number("max_velocity")?, number("min_velocity")?);
        }
        if is_on("acceleration") {
            let least = number("min_acceleration")?.or(number("max_deceleration")?);
            limit.acceleration = pair(number("max_acceleration")?, least);
        }
        Ok(limit)
    }
}

/// Collects the parameters of each node below a name, and the type of each controller.
fn collect(
    name: &str,
    tree: &Value,
    nodes: &mut BTreeMap<String, BTreeMap<String, Value>>,
    types: &mut BTreeMap<String, String>,
) {
    let Value::Object(map) = tree else { return };
    if let Some(Value::String(kind)) = map.get("type") {
        types.insert(name.to_owned(), kind.clone());
        // ROS 1 has parameters beside the type.
        if map.len() > 1 {
            flatten("", tree, nodes.entry(name.to_owned()).or_default());
        }
    }
    for (key, value) in map {
        if key == "ros__parameters" {
            flatten("", value, nodes.entry(name.to_owned()).or_default());
        }
        let below = if key == "ros__parameters" { name } else { key };
        collect(below, value, nodes, types);
    }
}

/// Adds the parameters of a tree, each by its whole name.
fn flatten(prefix: &str, tree: &Value, parameters: &mut BTreeMap<String, Value>) {
    match tree {
        Value::Object(map) => map.iter().for_each(|(key, value)| {
            let name = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
            flatten(&name, value, parameters);
        }),
        value => _ = parameters.insert(prefix.to_owned(), value.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DIFF: &str = "
controller_manager:
  ros__parameters:
    update_rate: 50
    arm_controller: {type: joint_trajectory_controller/JointTrajectoryController}
    platform_velocity_controller: {type: diff_drive_controller/DiffDriveController}
arm_controller:
  ros__parameters: {joints: [a, b]}
platform_velocity_controller:
  ros__parameters:
    wheel_separation: 0.4
    wheel_radius: 0.1
    wheel_separation_multiplier: 1.5
    right_wheel_radius_multiplier: 1.1
    base_frame_id: base_footprint
    cmd_vel_timeout: 0.25
    pose_covariance_diagonal: [1, 2, 3, 4, 5, 6]
    linear.x.max_velocity: 2.0
    linear.x.min_velocity: -1.0
    angular:
      z: {has_velocity_limits: false, max_velocity: 4.0, max_acceleration: 5.0}
";

    fn p3at() -> RobotDef {
        let part = scene::Part {
            name: String::new(),
            mass: 1.0,
            centre: nalgebra::Vector3::zeros(),
            inertia: nalgebra::Matrix3::identity(),
        };
        let motor = scene::Motor {
            max_speed: 10.0,
            gain: 5.0,
            max_torque: 2.0,
            stiffness: None,
            integral_time: None,
            armature: 0.0,
        };
        let mut links = vec![scene::Link { parts: vec![part], ..scene::Link::default() }];
        for (y, side) in [(-0.2, scene::Side::Left), (0.2, scene::Side::Right)] {
            let wheel = scene::Wheel {
                side,
                radius: 0.1,
                width: 0.1,
                mass: 0.1,
                material: scene::Material::default(),
                rollers: None,
                belt: None,
                tyre: None,
            };
            links.push(scene::Link::of_wheel(format!("wheel {y}"), [0.0, y, 0.0], Some(motor.clone()), wheel));
        }
        RobotDef::new("Cart", scene::Steering::Skid, links)
    }

    #[test]
    fn the_controller_of_a_base_is_found_among_others() {
        let file = ControllerFile::read(DIFF).expect("a controller");
        let controller = file.of(&p3at()).expect("it fits");
        assert_eq!(controller.name, "platform_velocity_controller");
        let Wheels::Sides(DiffDrive { track, radii }) = controller.wheels else { panic!("{controller:?}") };
        assert!((track - 0.6).abs() < 1e-12 && (radii[0] - 0.1).abs() < 1e-12 && (radii[1] - 0.11).abs() < 1e-12);
        assert_eq!((controller.base_frame.as_str(), controller.timeout), ("base_footprint", 0.25));
        assert_eq!(controller.variances, [[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], VARIANCES]);
        assert_eq!(controller.limits[0].velocity, [-1.0, 2.0]);
        assert_eq!(controller.limits[2], Limit { velocity: Limit::NONE.velocity, acceleration: [-5.0, 5.0] });
        assert_eq!(controller.topics(), ["platform_velocity_controller/cmd_vel", "platform_velocity_controller/odom"]);
    }

    #[test]
    fn a_file_of_ros_1_has_its_parameters_beside_the_type() {
        let yaml =
            "jackal:\n  type: \"diff_drive_controller/DiffDriveController\"\n  wheel_separation_multiplier: 1.5\n";
        let controller = ControllerFile::read(yaml).and_then(|file| file.of(&p3at())).expect("a controller");
        let Wheels::Sides(DiffDrive { track, .. }) = controller.wheels else { panic!("{controller:?}") };
        assert!((track - 0.6).abs() < 1e-12, "{track}");
    }

    #[test]
    fn a_wrong_file_says_what_is_wrong() {
        let check = |yaml: &str, expected: &str| {
            let error = ControllerFile::read(yaml).and_then(|file| file.of(&p3at())).expect_err(yaml);
            assert!(error.contains(expected), "{yaml}: {error}");
        };
        check("a: [", "");
        check("a: {type: x/Y}", "no controller that drives a base");
        check("a: {type: diff_drive_controller/D, wheel_radius: big}", "`wheel_radius` is \"big\": expected a number");
        check("a: {type: diff_drive_controller/D, wheel_radius: -1}", "expected a positive number");
        check("a: {type: diff_drive_controller/D, k: 1}\nb: {type: diff_drive_controller/D, k: 1}", "two controllers");
        check("a: {type: mecanum_drive_controller/M, k: 1}", "controller of other wheels");
        check("a: {type: diff_drive_controller/D, pose_covariance_diagonal: [1]}", "expected six numbers");
    }
}
