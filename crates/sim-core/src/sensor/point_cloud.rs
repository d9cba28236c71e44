//! Points in the frame of the sensor: of a fan of beams that nods, and of a grid of parallel beams, as RotatingPointCloudScanner.uc and
//! ExampleSonarArray.uc mean them. In the original their beams have no robot and never fire.

use gamebots_proto::message::{ItemConf, PlainConf, PointCloud, SonarArray};
use nalgebra::{Point3, Vector3};
use scene::sensor::point_cloud::{Grid, Reading, Rotating};
use scene::{Pose, SensorDef};

use super::{Mount, Sensor, View, beam, points};

#[derive(Clone)]
enum Form {
    Rotating(Rotating),
    Grid(Grid),
}

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    form: Form,
    /// Time at which it was mounted, s.
    start: f64,
}

pub(super) fn build_rotating(config: &Rotating, mount: Mount) -> Mounted {
    build(Form::Rotating(config.clone()), mount)
}

pub(super) fn build_grid(config: &Grid, mount: Mount) -> Mounted {
    build(Form::Grid(config.clone()), mount)
}

fn build(form: Form, mount: Mount) -> Mounted {
    Mounted { name: mount.name.to_owned(), pose: mount.pose, form, start: mount.view.time }
}

/// Returns the reading of a fan for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> PointCloud {
    PointCloud { name: def.name.clone(), points: points(&reading.points) }
}

/// Returns the reading of a grid for the wire.
pub(super) fn wire_grid(def: &SensorDef, reading: &Reading) -> SonarArray {
    SonarArray { name: def.name.clone(), points: points(&reading.points) }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "PCL"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let pose = view.carrier.pose * self.pose;
        let points = match &self.form {
            Form::Rotating(config) => {
                let turn = ((view.time - self.start) / config.spin_time).rem_euclid(1.0);
                let pitch = config.vertical_field_of_view * (turn - 0.5);
                let sight = view.sight(&pose.translation.vector.into(), config.max_range);
                let direction = |number: u32| {
                    let share = f64::from(number) / f64::from(config.beams - 1);
                    beam(config.horizontal_field_of_view * (share - 0.5), pitch)
                };
                let directions = (0..config.beams).map(direction);
                let ranges = sight.ranges(directions.clone().map(|direction| pose.rotation * direction));
                let points = directions.zip(ranges).map(|(direction, range)| direction * range);
                points.flat_map(<[f64; 3]>::from).collect()
            }
            Form::Grid(config) => {
                let ahead = pose.rotation * Vector3::x();
                let middle = f64::from(config.size - 1) / 2.0;
                let place = |number: u32| (f64::from(number) - middle) * config.spacing;
                let point = |number: u32| {
                    let (row, column) = (number / config.size, number % config.size);
                    let origin = Point3::new(0.0, place(column), place(row));
                    [view.sight(&(pose * origin), config.max_range).range(&ahead), origin.y, origin.z]
                };
                (0..config.size * config.size).flat_map(point).collect()
            }
        };
        Some(Reading { points }.into())
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
