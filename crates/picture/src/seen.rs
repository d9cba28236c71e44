//! Places in a picture.

use nalgebra::Point3;
use scene::{Snapshot, WorldDef};

use crate::raster::{Depths, Projection};
use crate::{Camera, Stage};

/// Longest edge of the depth buffer, pixels: it is coarser than a large picture.
const LONGEST: usize = 1024;

/// Returns the column and row in a picture of each place that lies in it with nothing in front. What is nearer to the eye than a place by less
/// than `margin`, m, does not hide it.
pub fn seen_places(
    stage: &Stage,
    def: &WorldDef,
    snapshot: &Snapshot,
    camera: &Camera,
    size: [usize; 2],
    places: &[Point3<f64>],
    margin: f64,
) -> Vec<Option<[f64; 2]>> {
    let shrink = (size[0].max(size[1]) as f64 / LONGEST as f64).max(1.0);
    let [width, height] = size.map(|edge| (edge as f64 / shrink).ceil() as usize);
    let view = Projection::perspective(camera, width, height);
    let mut depths = Depths::new(width, height);
    let (triangles, _) = stage.scene(def, snapshot, None);
    triangles.iter().enumerate().for_each(|(index, triangle)| depths.add(&view, &triangle.corners, index));
    let place = |place: &Point3<f64>| {
        let [x, y] = view.pixel_of(place)?;
        let inside = (0.0..width as f64).contains(&x) && (0.0..height as f64).contains(&y);
        (inside && !depths.hides(&view, place, margin)).then_some([x * shrink, y * shrink])
    };
    places.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FIELD_OF_VIEW;
    use sim_core::{Options, World};

    #[test]
    fn a_place_behind_a_wall_or_outside_the_picture_is_not_seen() {
        let world = World::new(scene_loader::load("hall", &[]).unwrap(), Options::default());
        let (def, snapshot) = (world.def(), world.snapshot());
        let eye = Point3::new(0.0, 0.0, -30.0);
        let camera =
            Camera { eye, target: Point3::origin(), down: -nalgebra::Vector3::x(), field_of_view: FIELD_OF_VIEW };
        let stage = Stage::new(def);
        let above = Point3::new(0.0, 0.0, -5.0);
        let places = [above, Point3::new(0.0, 0.0, -31.0), Point3::new(90.0, 0.0, -1.0)];
        for size in [[300, 200], [3000, 2000]] {
            let seen = seen_places(&stage, def, &snapshot, &camera, size, &places, 0.1);
            let [Some([x, y]), None, None] = seen[..] else { panic!("{seen:?}") };
            assert!((x - size[0] as f64 / 2.0).abs() < 3.0 && (y - size[1] as f64 / 2.0).abs() < 3.0, "{x} {y}");
        }
        // From the corner, a place on the far side of a solid is behind it.
        let camera = Camera::of_map(&def.map, [300, 200]);
        let solid = def.map.solids.iter().find(|solid| matches!(solid.shape, scene::Shape::Box { .. })).unwrap();
        let middle = Point3::from(solid.pose().translation.vector);
        let [before, behind] = [-3.0, 3.0].map(|by| middle + (middle - camera.eye).normalize() * by);
        let seen = seen_places(&stage, def, &snapshot, &camera, [300, 200], &[before, behind], 0.1);
        assert!(seen[0].is_some() && seen[1].is_none(), "{seen:?}");
    }
}
