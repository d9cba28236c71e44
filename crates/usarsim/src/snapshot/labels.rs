//! Names of what a picture shows.

use charts::Label;
use nalgebra::Point3;
use picture::{Camera, Stage};
use sim_core::World;

/// Thickness of what may stand in front of a name without hiding it, m.
const MARGIN: f64 = 0.1;

/// Returns the names of the robots, the objects and the starts that a camera sees: each kind from near to far.
pub(super) fn labels(stage: &Stage, world: &World, camera: &Camera, size: [usize; 2]) -> Vec<Label> {
    let (def, snapshot) = (world.def(), world.snapshot());
    let robots = snapshot.robots.iter().map(|robot| {
        let corners = stage.corners_of(def, &snapshot, robot);
        let name = if robot.name.is_empty() { &robot.class } else { &robot.name };
        (name.clone(), above(robot.body.pose.translation.vector.into(), &corners))
    });
    let objects = snapshot.objects.iter().map(|object| {
        let place = above(object.pose.translation.vector.into(), &picture::corners_of_object(object));
        (object.def.solid.name.clone(), place)
    });
    let starts = def.map.starts.iter().map(|start| (start.name.clone(), Point3::from(start.position)));
    let distance = |(_, place): &(String, Point3<f64>)| (place - camera.eye).norm();
    let mut names = Vec::new();
    for mut kind in [robots.collect::<Vec<_>>(), objects.collect(), starts.collect()] {
        kind.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        names.append(&mut kind);
    }
    let places: Vec<Point3<f64>> = names.iter().map(|(_, place)| *place).collect();
    let seen = picture::seen_places(stage, def, &snapshot, camera, size, &places, MARGIN);
    let robots = snapshot.robots.len();
    let label = |(number, ((text, _), at)): (usize, ((String, _), Option<[f64; 2]>))| {
        Some(Label { text, at: at?, is_above: number < robots })
    };
    names.into_iter().zip(seen).enumerate().filter_map(label).collect()
}

/// Returns the place above a middle at the height of the highest corner: z points down.
fn above(middle: Point3<f64>, corners: &[Point3<f64>]) -> Point3<f64> {
    let highest = corners.iter().map(|corner| corner.z).fold(middle.z, f64::min);
    Point3::new(middle.x, middle.y, highest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gamebots_proto::command::Init;
    use sim_core::Options;

    #[test]
    fn robots_come_before_objects_and_objects_before_starts() {
        let mut world = World::new(scene_loader::load("hall", &[]).unwrap(), Options::default());
        for (name, x) in [("Nina", 0.0), ("", 2.0)] {
            let init = Init {
                class_name: "P3AT".to_owned(),
                name: name.to_owned(),
                location: [x, 0.0, -0.2],
                ..Init::default()
            };
            world.init(&init, &mut Vec::new()).unwrap();
        }
        let size = [1280, 720];
        let camera = Camera::of_map(&world.def().map, size);
        let labels = labels(&Stage::new(world.def()), &world, &camera, size);
        let names: Vec<&str> = labels.iter().map(|label| label.text.as_str()).collect();
        let kind = |name: &&str| match *name {
            "Nina" | "P3AT" => 0,
            start if world.def().map.starts.iter().any(|known| known.name == start) => 2,
            _ => 1,
        };
        let kinds: Vec<i32> = names.iter().map(kind).collect();
        assert_eq!(names[..2], ["Nina", "P3AT"]);
        assert!(kinds.is_sorted() && kinds.contains(&1) && kinds.contains(&2), "{names:?}");
    }
}
