//! Namespaces of robots, and names of their sensors' topics and frames.

use std::collections::{BTreeMap, BTreeSet};

use scene::RobotDef;
use scene::sensor::Config;

use crate::controller::Controller;
use crate::convert;

/// A choice of the robots' namespaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Namespaces {
    /// `/R1` for a robot of that name, and `/robot_0` for one whose name is empty or taken.
    #[default]
    Names,
    /// `/robot_0`, by the smallest free number: as many as there were robots at once. Logs have room for so many topics.
    Numbers,
    /// None for the first robot; the others as in [`Namespaces::Names`].
    NoneForTheFirst,
}

/// The namespace of a robot.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Space {
    /// Before its topics: `/R1`, or nothing.
    pub namespace: String,
    /// Before its frames: `R1/`, or nothing.
    pub prefix: String,
    /// Frame of the robot.
    pub base: String,
    /// Frame of its odometry.
    pub odom: String,
}

impl Space {
    fn of(name: &str) -> Self {
        let (namespace, prefix) =
            if name.is_empty() { Default::default() } else { (format!("/{name}"), format!("{name}/")) };
        let (base, odom) = (format!("{prefix}base_link"), format!("{prefix}odom"));
        Self { namespace, prefix, base, odom }
    }

    /// Names its frames as a controller does.
    pub(crate) fn with(self, controller: &Controller) -> Self {
        let Self { prefix, .. } = &self;
        let (base, odom) = (format!("{prefix}{}", controller.base_frame), format!("{prefix}{}", controller.odom_frame));
        Self { base, odom, ..self }
    }

    /// Returns a topic in it.
    pub fn topic(&self, name: &str) -> String {
        format!("{}/{name}", self.namespace)
    }
}

/// The namespaces that are taken.
#[derive(Debug)]
pub(crate) struct Spaces {
    namespaces: Namespaces,
    taken: BTreeMap<u64, String>,
}

impl Spaces {
    pub(crate) fn new(namespaces: Namespaces) -> Self {
        Self { namespaces, taken: BTreeMap::new() }
    }

    /// Gives a robot its namespace.
    pub(crate) fn come(&mut self, robot: u64, called: &str) -> Space {
        let taken: BTreeSet<&str> = self.taken.values().map(String::as_str).collect();
        let is_free = |name: &String| !taken.contains(name.as_str());
        let own = match self.namespaces {
            Namespaces::Numbers => None,
            Namespaces::NoneForTheFirst if taken.is_empty() => Some(String::new()),
            Namespaces::NoneForTheFirst | Namespaces::Names => {
                Some(called).filter(|called| !called.is_empty()).map(convert::name)
            }
        };
        let numbered = || (0..).map(|number: u64| format!("robot_{number}")).find(is_free).unwrap_or_default();
        let name = own.filter(is_free).unwrap_or_else(numbered);
        let space = Space::of(&name);
        self.taken.insert(robot, name);
        space
    }

    /// Frees the namespace of a robot.
    pub(crate) fn leave(&mut self, robot: u64) {
        self.taken.remove(&robot);
    }
}

/// Names of a sensor.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SensorNames {
    /// Its topic.
    pub(crate) topic: String,
    /// Its frame.
    pub(crate) frame: String,
    /// Its optical frame, if it takes pictures.
    pub(crate) optical: Option<String>,
}

impl SensorNames {
    /// Returns a topic beside its own.
    pub(crate) fn beside(&self, name: &str) -> String {
        let folder = self.topic.rsplit_once('/').map_or("", |(folder, _)| folder);
        format!("{folder}/{name}")
    }
}

/// Returns the names of a class's sensors. A topic is named by the kind of its message; where a robot has several of a kind, the sensor's
/// name comes before it: `scan`, or `Scanner1/scan` and `Scanner2/scan`.
pub(crate) fn of_sensors(def: &RobotDef, space: &Space) -> Vec<SensorNames> {
    let labels = def.sensor_labels();
    let kinds: Vec<&str> = def.sensors.iter().map(|sensor| kind(&sensor.config)).collect();
    let names = |(label, own): (&String, &&str)| {
        let is_alone = kinds.iter().filter(|kind| *kind == own).count() == 1;
        let label = convert::name(label);
        let topic = if is_alone { space.topic(own) } else { space.topic(&format!("{label}/{own}")) };
        let frame = format!("{}{label}", space.prefix);
        let optical = ["image_raw", "depth/image_raw"].contains(own).then(|| format!("{frame}_optical"));
        SensorNames { topic, frame, optical }
    };
    labels.iter().zip(&kinds).map(names).collect()
}

/// Returns the topic of a kind of sensor, as drivers of real ones name it.
fn kind(config: &Config) -> &'static str {
    match config {
        Config::Sonar(_) | Config::Infrared(_) => "range",
        Config::Imu(_) | Config::Ins(_) => "imu",
        Config::Gps(_) => "fix",
        Config::Odometry(_) => "wheel_odom",
        Config::Camera(_) => "image_raw",
        Config::KinectDepth(_) => "depth/image_raw",
        Config::RotatingPointCloud(_) | Config::SonarArray(_) | Config::RangeScanner3D(_) | Config::LineLaser(_) => {
            "points"
        }
        config if config.fan().is_some_and(|fan| fan.level) => "scan",
        // Without a message in ROS; their frames have a name.
        _ => "sensor",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(namespaces: Namespaces, expected: [&str; 5]) {
        let mut spaces = Spaces::new(namespaces);
        let mut come = |robot, name| spaces.come(robot, name).topic("odom");
        let first = [come(0, "R1"), come(1, "R1"), come(2, ""), come(3, "my robot")];
        spaces.leave(0);
        let later = spaces.come(4, "R1").topic("odom");
        assert_eq!(first.iter().chain([&later]).collect::<Vec<_>>(), expected, "{namespaces:?}");
    }

    #[test]
    fn no_two_robots_share_a_namespace() {
        check(Namespaces::Names, ["/R1/odom", "/robot_0/odom", "/robot_1/odom", "/my_robot/odom", "/R1/odom"]);
        check(
            Namespaces::Numbers,
            ["/robot_0/odom", "/robot_1/odom", "/robot_2/odom", "/robot_3/odom", "/robot_0/odom"],
        );
        check(Namespaces::NoneForTheFirst, ["/odom", "/R1/odom", "/robot_0/odom", "/my_robot/odom", "/robot_1/odom"]);
    }

    #[test]
    fn a_sensor_that_is_alone_of_its_kind_has_the_usual_name() {
        let world = scene_loader::load("rough", &[]).expect("a scene");
        let topics = |class: &str| -> Vec<String> {
            of_sensors(&world.robots[class], &Space::of("R1")).into_iter().map(|names| names.topic).collect()
        };
        let of_p3at = topics("P3AT");
        for topic in ["/R1/scan", "/R1/imu", "/R1/image_raw"] {
            assert!(of_p3at.iter().any(|known| known == topic), "{topic} in {of_p3at:?}");
        }
    }
}
