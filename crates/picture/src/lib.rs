//! Pictures of a world without a graphics card.
//!
//! The renderer draws triangles with a depth buffer, light from one side with a shadow map, patterns of materials, and a grid of a metre on
//! the floor. It draws a map's solids, and a robot's visuals or else its colliding shapes. The hubs between a wheel's rollers are drawn for looks
//! only. (The crate `euc` draws triangles too, but has had no release since 2020.)

mod camera;
mod corners;
mod mesh;
mod pattern;
mod raster;
mod seen;
mod stage;

use nalgebra::{Point3, Vector3};
use scene::{PawnId, Reading, Sensed, Snapshot, WorldDef};

pub use camera::{Camera, FIELD_OF_VIEW, FROM_CORNER};
pub use corners::{corners_of_map, corners_of_object};
pub use seen::seen_places;
pub use stage::Stage;

use mesh::{Floor, Triangle};
use raster::{Depths, Projection};

/// An image with 8 bits of red, green and blue per pixel, rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// Number of pixels in a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Red, green and blue of each pixel.
    pub pixels: Vec<[u8; 3]>,
}

/// Number of samples along the edge of a pixel.
const SAMPLES: usize = 3;
/// Maximum number of samples with depths in memory at once: 64 MB. A large picture is drawn in bands.
const BAND: usize = 4 << 20;
/// Number of pixels along an edge of the shadow map.
const SHADOW_SIZE: usize = 2048;
/// Half the width of the area that casts shadows, over the distance from eye to target.
const SHADOW_REACH: f64 = 1.5;
/// Least distance between a shadow's caster and a shaded surface, as a fraction of the reach.
const SHADOW_MARGIN: f64 = 0.002;
/// Distance from a robot's camera to the middle of the area that casts shadows, and half the width of that area, m.
const VIEW_DISTANCE: f64 = 2.0;
const VIEW_REACH: f64 = 4.0;
/// Direction toward the light.
const LIGHT: [f64; 3] = [0.35, -0.6, -1.0];
/// Ambient fraction of the light.
const AMBIENT: f64 = 0.5;
/// Colour above the horizon and far away.
const SKY: [f64; 3] = [0.91, 0.93, 0.95];
/// Start and end of the fade into the sky, over the distance from eye to target. That distance counts as at least a few metres.
const FADE: [f64; 2] = [3.0, 16.0];
const LEAST_FADE_UNIT: f64 = 5.0;
/// Half the width of a line of the grid, m.
const GRID_LINE: f64 = 0.006;

/// Quality of a picture.
struct Fineness {
    /// Samples along the edge of a pixel.
    samples: usize,
    /// Pixels along an edge of the shadow map.
    shadow_size: usize,
    /// Half the width of the area that casts shadows, m.
    reach: f64,
    /// Unit of the distance over which colours fade into the sky, m.
    fade_unit: f64,
    /// True to shade a pixel once if all its samples are of one surface.
    is_quick: bool,
    /// True to draw the patterns of materials.
    has_patterns: bool,
}

/// Parts of a picture that may be left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Looks {
    /// Floors without an end.
    pub floor: bool,
    /// The grid on them.
    pub grid: bool,
    /// Colour behind the world, 0 to 1, in place of a sky into which all fades.
    pub backdrop: Option<[f64; 3]>,
}

impl Default for Looks {
    fn default() -> Self {
        Self { floor: true, grid: true, backdrop: None }
    }
}

/// Draws a snapshot of a world. Width and height are in pixels.
pub fn picture(stage: &Stage, def: &WorldDef, snapshot: &Snapshot, camera: &Camera, size: [usize; 2]) -> Image {
    picture_with(stage, def, snapshot, camera, size, &Looks::default())
}

/// Draws a snapshot of a world without some parts. Width and height are in pixels.
pub fn picture_with(
    stage: &Stage,
    def: &WorldDef,
    snapshot: &Snapshot,
    camera: &Camera,
    size: [usize; 2],
    looks: &Looks,
) -> Image {
    let distance = (camera.eye - camera.target).norm();
    let (reach, fade_unit) = (SHADOW_REACH * distance, distance.max(LEAST_FADE_UNIT));
    let (samples, shadow_size) = (SAMPLES, SHADOW_SIZE);
    let fineness = Fineness { samples, shadow_size, reach, fade_unit, is_quick: false, has_patterns: true };
    draw(stage.scene(def, snapshot, None), camera, size, &fineness, looks)
}

/// Draws what a camera of a robot sees. Width and height are in pixels. Shadows fall within a few metres in front of it.
fn view(stage: &Stage, def: &WorldDef, snapshot: &Snapshot, robot: PawnId, camera: &Camera, size: [usize; 2]) -> Image {
    let ahead = (camera.target - camera.eye).normalize();
    let camera = Camera { target: camera.eye + ahead * VIEW_DISTANCE, ..*camera };
    let fineness = Fineness {
        samples: 2,
        shadow_size: 512,
        reach: VIEW_REACH,
        fade_unit: LEAST_FADE_UNIT,
        is_quick: true,
        has_patterns: false,
    };
    let scene = stage.scene(def, snapshot, Some((robot, camera.eye)));
    draw(scene, &camera, size, &fineness, &Looks::default())
}

/// Width and height of the picture of a robot's camera, pixels, as USARSim's.
pub const SENSOR_SIZE: [usize; 2] = [320, 240];

/// A drawer of cameras' pictures, one scene after the other. It prepares a scene once for all pictures of it in a row.
pub struct Drawer<S>(Option<(S, Stage)>);

impl<S> Default for Drawer<S> {
    fn default() -> Self {
        Self(None)
    }
}

impl<S: AsRef<WorldDef> + Clone> Drawer<S> {
    /// Draws the picture of a camera's reading, as [`of_sensor`] does. Copies of a scene share its definition.
    pub fn of_sensor(&mut self, scene: &S, snapshot: &Snapshot, sensed: &Sensed, size: [usize; 2]) -> Option<Image> {
        let def = scene.as_ref();
        if self.0.as_ref().is_none_or(|(known, _)| !std::ptr::eq(known.as_ref(), def)) {
            self.0 = Some((scene.clone(), Stage::new(def)));
        }
        let (_, stage) = self.0.as_ref()?;
        of_sensor(stage, def, snapshot, sensed, size)
    }
}

/// Draws the picture of a camera's reading from the snapshot of its moment. `None` if the reading is another sensor's, or the robot or its
/// sensor is missing.
pub fn of_sensor(
    stage: &Stage,
    def: &WorldDef,
    snapshot: &Snapshot,
    sensed: &Sensed,
    size: [usize; 2],
) -> Option<Image> {
    let Reading::Camera(reading) = &sensed.reading else { return None };
    let seen = snapshot.robots.iter().find(|seen| seen.id == sensed.robot)?;
    let class = def.robots.get(&seen.class)?;
    let camera = Camera::of_robot(class, seen, class.sensors.get(sensed.sensor)?, reading.field_of_view, size)?;
    Some(view(stage, def, snapshot, sensed.robot, &camera, size))
}

fn draw(
    (triangles, floors): (Vec<Triangle>, &[Floor]),
    camera: &Camera,
    [width, height]: [usize; 2],
    &Fineness { samples, shadow_size, reach, fade_unit, is_quick, has_patterns }: &Fineness,
    looks: &Looks,
) -> Image {
    let floors = if looks.floor { floors } else { &[] };
    let sky = Vector3::from(looks.backdrop.unwrap_or(SKY));
    let whole = Projection::perspective(camera, width * samples, height * samples);
    let light = Projection::parallel(camera.target, Vector3::from(LIGHT), reach, shadow_size);
    let mut shadows = Depths::new(shadow_size, shadow_size);
    triangles.iter().enumerate().for_each(|(index, triangle)| shadows.add(&light, &triangle.corners, index));
    let margin = SHADOW_MARGIN * SHADOW_SIZE as f64 / shadow_size as f64 * reach;
    // Breadth of a sample at a distance of 1 m; patterns are gone from afar.
    let breadth = if has_patterns { 1.0 / whole.scale() } else { f64::INFINITY };
    let sample = |view: &Projection, surfaces: &Depths, x: usize, y: usize| {
        let ray = view.ray(x, y);
        let place_at = |distance: f64| camera.eye + ray * distance;
        let solid = surfaces.at(x, y).map(|(depth, index)| (view.distance(depth, &ray), &triangles[index]));
        let floor = floors.iter().filter_map(|floor| Some((floor.distance(&camera.eye, &ray)?, floor)));
        let floor = floor.min_by(|a, b| a.0.total_cmp(&b.0));
        let (distance, normal, colour) = match (solid, floor) {
            (Some((distance, triangle)), floor) if floor.is_none_or(|(floor, _)| distance < floor) => {
                let normal = triangle.normal();
                let colour = triangle.colour_at(&place_at(distance), distance * breadth);
                (distance, if normal.dot(&ray) > 0.0 { -normal } else { normal }, colour)
            }
            (_, Some((distance, floor))) => {
                let place = place_at(distance);
                let shade = if looks.grid { grid(&place, distance) } else { 1.0 };
                (distance, floor.normal, floor.colour_at(&place, distance * breadth) * shade)
            }
            _ => return sky,
        };
        let bright = normal.dot(&Vector3::from(LIGHT).normalize()).max(0.0);
        let is_lit = bright > 0.0 && !shadows.hides(&light, &place_at(distance), margin);
        let lit = colour * (AMBIENT + if is_lit { (1.0 - AMBIENT) * bright } else { 0.0 });
        if looks.backdrop.is_some() {
            return lit;
        }
        let fade = ((distance / fade_unit - FADE[0]) / (FADE[1] - FADE[0])).clamp(0.0, 1.0);
        lit * (1.0 - fade) + sky * fade
    };
    let mut pixels = Vec::with_capacity(width * height);
    let rows = (BAND / (width * samples * samples).max(1)).max(1);
    for first in (0..height).step_by(rows) {
        let rows = rows.min(height - first);
        let view = whole.below(first * samples);
        let mut surfaces = Depths::new(width * samples, rows * samples);
        triangles.iter().enumerate().for_each(|(index, triangle)| surfaces.add(&view, &triangle.corners, index));
        pixels.extend((0..width * rows).map(|index| {
            let (left, top) = (index % width * samples, index / width * samples);
            let places = || (0..samples * samples).map(|part| (left + part % samples, top + part / samples));
            let surface = |(x, y)| surfaces.at(x, y).map(|(_, surface)| surface);
            let first = surface((left, top));
            let is_one = is_quick && places().skip(1).all(|place| surface(place) == first);
            let colour = if is_one {
                sample(&view, &surfaces, left + samples / 2, top + samples / 2)
            } else {
                places().map(|(x, y)| sample(&view, &surfaces, x, y)).sum::<Vector3<f64>>() / (samples * samples) as f64
            };
            <[f64; 3]>::from(colour).map(|part| (part.clamp(0.0, 1.0) * 255.0).round() as u8)
        }));
    }
    Image { width, height, pixels }
}

/// Returns the shade of a floor's grid lines, one per metre and a stronger one every five.
fn grid(place: &Point3<f64>, distance: f64) -> f64 {
    // Lines get wider with the distance, so that they do not flicker from pixel to pixel.
    let half = GRID_LINE + 0.0012 * distance;
    let near = |value: f64, step: f64| (value - step * (value / step).round()).abs() < half;
    let on = |step: f64| near(place.x, step) || near(place.y, step);
    if on(5.0) {
        0.72
    } else if on(1.0) {
        0.86
    } else {
        1.0
    }
}

impl Image {
    /// Encodes the image as a PNG file.
    ///
    /// # Errors
    /// When it has no pixels.
    pub fn to_png(&self) -> Result<Vec<u8>, png::EncodingError> {
        self.encoded(png::ColorType::Rgb, self.pixels.as_flattened())
    }

    /// Returns bytes of pixels of this image's size as a PNG file.
    fn encoded(&self, kind: png::ColorType, bytes: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width as u32, self.height as u32);
        encoder.set_color(kind);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.write_header()?.write_image_data(bytes)?;
        Ok(file)
    }
}

/// Encodes images of one size as an animated PNG that repeats. Each frame after the first holds only the box that changed, so a
/// camera that stands still makes small files.
///
/// # Errors
/// When there is no image, or it has no pixels.
pub fn film(pictures: &[Image], frames_per_second: u16) -> Result<Vec<u8>, png::EncodingError> {
    let (width, height) = pictures.first().map_or((0, 0), |first| (first.width, first.height));
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Best);
    encoder.set_animated(pictures.len() as u32, 0)?;
    encoder.set_frame_delay(1, frames_per_second)?;
    let mut writer = encoder.write_header()?;
    let mut before: Option<&Image> = None;
    for picture in pictures {
        let [left, top, wide, high] = before.map_or([0, 0, width, height], |before| picture.changed_since(before));
        writer.set_frame_dimension(wide as u32, high as u32)?;
        writer.set_frame_position(left as u32, top as u32)?;
        let rows = picture.pixels.chunks(width).skip(top).take(high);
        let bytes: Vec<u8> = rows.flat_map(|row| &row[left..left + wide]).flatten().copied().collect();
        writer.write_image_data(&bytes)?;
        before = Some(picture);
    }
    writer.finish()?;
    Ok(file)
}

impl Image {
    /// Returns a picture of a world before nothing as a PNG file: what is behind it is transparent. It is made of two pictures of the same size,
    /// before black and before white.
    ///
    /// # Errors
    /// When the picture has no pixels.
    pub fn cut_out(on_black: &Self, on_white: &Self) -> Result<Vec<u8>, png::EncodingError> {
        let pixels = on_black.pixels.iter().zip(&on_white.pixels).flat_map(|(black, white)| {
            let seen_through = black.iter().zip(white).map(|(black, white)| white.saturating_sub(*black)).min();
            let alpha = 255 - seen_through.unwrap_or_default();
            let part = |black: u8| (f64::from(black) * 255.0 / f64::from(alpha.max(1))).round().min(255.0) as u8;
            let [red, green, blue] = black.map(part);
            [red, green, blue, alpha]
        });
        on_black.encoded(png::ColorType::Rgba, &pixels.collect::<Vec<u8>>())
    }

    /// Returns left, top, width and height of the box in which an image of the same size differs, or one pixel if none does.
    fn changed_since(&self, before: &Self) -> [usize; 4] {
        let changed = self.pixels.iter().zip(&before.pixels).enumerate().filter(|(_, (now, then))| now != then);
        let places = changed.map(|(index, _)| [index % self.width, index / self.width]);
        let hull = places.fold(None, |hull: Option<[usize; 4]>, [x, y]| {
            let [left, top, right, bottom] = hull.unwrap_or([x, y, x, y]);
            Some([left.min(x), top.min(y), right.max(x), bottom.max(y)])
        });
        let [left, top, right, bottom] = hull.unwrap_or_default();
        [left, top, right - left + 1, bottom - top + 1]
    }
}

#[cfg(test)]
mod tests {
    use sim_core::{Options, World};

    use super::*;

    fn world(robot: bool) -> World {
        let def = scene_loader::load("rough", &[]).unwrap();
        let mut world = World::new(def, Options::default());
        if robot {
            let init = gamebots_proto::command::Init { class_name: "KUKA_YouBot".to_owned(), ..Default::default() };
            world.init(&init, &mut Vec::new()).unwrap();
        }
        world
    }

    fn whole(world: &World, camera: &Camera, size: [usize; 2]) -> Image {
        picture(&Stage::new(world.def()), world.def(), &world.snapshot(), camera, size)
    }

    fn from_above(world: &World) -> Image {
        let (eye, target) = (Point3::new(0.0, 0.0, -2.0), Point3::origin());
        whole(world, &Camera { eye, target, down: Vector3::z(), field_of_view: 0.6 }, [90, 60])
    }

    /// Returns red, green and blue at fractions of width and height.
    fn at(image: &Image, x: f64, y: f64) -> [u8; 3] {
        image.pixels[(y * image.height as f64) as usize * image.width + (x * image.width as f64) as usize]
    }

    #[test]
    fn a_robot_is_orange_on_a_floor_that_is_not() {
        let (empty, image) = (from_above(&world(false)), from_above(&world(true)));
        let is_orange = |[red, green, blue]: [u8; 3]| red > 180 && green < 140 && blue < 80;
        assert!(is_orange(at(&image, 0.5, 0.5)) && !is_orange(at(&empty, 0.5, 0.5)));
        assert!(!is_orange(at(&image, 0.1, 0.5)));
        // It is longer than wide; its length is along x, which is up in the picture.
        let count = |pixels: &mut dyn Iterator<Item = [u8; 3]>| pixels.filter(|&pixel| is_orange(pixel)).count();
        let column = count(&mut (0..60).map(|y| image.pixels[y * 90 + 45]));
        let row = count(&mut (0..90).map(|x| image.pixels[30 * 90 + x]));
        assert!(column > row, "{column} high, {row} wide");
        assert_eq!(image, from_above(&world(true)), "the same again");
    }

    #[test]
    fn a_picture_of_several_bands_is_that_of_one() {
        // The picture is larger than a band.
        let world = world(true);
        let (eye, target) = (Point3::new(-2.0, 0.3, -1.0), Point3::new(0.0, 0.0, -0.1));
        let camera = Camera { eye, target, down: Vector3::z(), field_of_view: 0.6 };
        let (width, height) = (900, 700);
        assert!(width * height * SAMPLES * SAMPLES > BAND);
        let large = whole(&world, &camera, [width, height]);
        let small = whole(&world, &camera, [width / 10, height / 10]);
        let mut differing = 0;
        for (index, pixel) in small.pixels.iter().enumerate() {
            let (x, y) = (index % 90 * 10, index / 90 * 10);
            let block = (0..100).map(|part| large.pixels[(y + part / 10) * width + x + part % 10]);
            let sum = block.fold([0; 3], |sum, it| [0, 1, 2].map(|part| sum[part] + u32::from(it[part])));
            let far = (0..3).any(|part| (sum[part] as f64 / 100.0 - f64::from(pixel[part])).abs() > 25.0);
            differing += usize::from(far);
        }
        // Edges are sampled more finely in the large one.
        assert!(differing < small.pixels.len() / 50, "{differing} of {}", small.pixels.len());
    }

    #[test]
    fn a_robot_throws_a_shadow() {
        let (empty, image) = (from_above(&world(false)), from_above(&world(true)));
        let sum = |pixel: &[u8; 3]| pixel.iter().map(|&part| u32::from(part)).sum::<u32>();
        let darker = image.pixels.iter().zip(&empty.pixels).filter(|(a, b)| a[0] < 150 && sum(a) + 40 < sum(b)).count();
        assert!(darker > 10, "{darker}");
    }

    /// Two P3ATs, one in front of the other.
    #[test]
    fn a_camera_sees_the_robot_ahead_and_not_its_own_housing() {
        let def = scene_loader::load("rough", &[]).unwrap();
        let mut world = World::new(def, Options::default());
        let spawn = |world: &mut World, x: f64| {
            let init = gamebots_proto::command::Init {
                class_name: "P3AT".to_owned(),
                location: [x, 0.0, -0.2],
                ..Default::default()
            };
            world.init(&init, &mut Vec::new()).unwrap()
        };
        let robot = spawn(&mut world, 0.0);
        let stage = Stage::new(world.def());
        let see = |world: &World| {
            let (snapshot, def) = (world.snapshot(), world.robot(robot).unwrap());
            let sensor = def.sensors.iter().find(|sensor| sensor.name == "Camera").unwrap();
            let camera = Camera::of_robot(def, &snapshot.robots[0], sensor, 1.4, [80, 60]).unwrap();
            view(&stage, world.def(), &snapshot, robot, &camera, [80, 60])
        };
        let alone = see(&world);
        // The sky is above the middle, the floor below it.
        let sky = SKY.map(|part| (part * 255.0_f64).round() as u8);
        assert_eq!((at(&alone, 0.1, 0.1), at(&alone, 0.5, 0.1)), (sky, sky));
        assert!(at(&alone, 0.5, 0.6) != sky && at(&alone, 0.5, 0.6) != [0; 3]);
        spawn(&mut world, 2.0);
        let met = see(&world);
        let changed = met.changed_since(&alone);
        let [left, _, wide, _] = changed;
        assert!((5..60).contains(&wide) && left < 40 && left + wide > 40, "{changed:?}");
        assert_eq!(met, see(&world), "the same again");
    }

    #[test]
    fn a_world_is_cut_out_of_what_is_behind_it() {
        let world = world(true);
        let (eye, target) = (Point3::new(0.0, 0.0, -2.0), Point3::origin());
        let camera = Camera { eye, target, down: Vector3::z(), field_of_view: 0.6 };
        let draw = |looks: &Looks| {
            picture_with(&Stage::new(world.def()), world.def(), &world.snapshot(), &camera, [90, 60], looks)
        };
        let before = |shade| draw(&Looks { floor: false, grid: false, backdrop: Some([shade; 3]) });
        let file = Image::cut_out(&before(0.0), &before(1.0)).unwrap();
        let mut reader = png::Decoder::new(file.as_slice()).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size()];
        reader.next_frame(&mut bytes).unwrap();
        let pixel = |x: usize, y: usize| &bytes[4 * (y * 90 + x)..][..4];
        let [red, green, blue, alpha] = pixel(45, 30) else { panic!("four bytes of a pixel") };
        assert!(*red > 180 && *green < 140 && *blue < 80 && *alpha == 255);
        assert_eq!(pixel(5, 30), [0; 4]);
        // With its floor the picture is full.
        let full = Image::cut_out(&from_above(&world), &from_above(&world)).unwrap();
        assert_ne!(full, file);
        let shades =
            |looks: &Looks| draw(looks).pixels.iter().map(|pixel| pixel[0]).collect::<std::collections::BTreeSet<_>>();
        assert!(shades(&Looks::default()).len() > shades(&Looks { grid: false, ..Looks::default() }).len());
    }

    #[test]
    fn the_sky_is_above_the_horizon() {
        let (eye, target) = (Point3::new(-2.0, 0.0, -1.0), Point3::new(0.0, 0.0, -1.0));
        let world = world(true);
        let image = whole(&world, &Camera { eye, target, down: Vector3::z(), field_of_view: 0.6 }, [90, 60]);
        assert_eq!(at(&image, 0.5, 0.05), SKY.map(|part| (part * 255.0_f64).round() as u8));
        assert_ne!(at(&image, 0.5, 0.95), at(&image, 0.5, 0.05));
        let png = image.to_png().unwrap();
        assert!(png.starts_with(b"\x89PNG"));
    }

    #[test]
    fn a_film_has_every_picture_and_of_the_later_ones_what_changed() {
        let plain = Image { width: 40, height: 30, pixels: vec![[200; 3]; 1200] };
        let mut dotted = plain.clone();
        dotted.pixels[5 * 40 + 7] = [10, 20, 30];
        dotted.pixels[6 * 40 + 9] = [10, 20, 30];
        let pictures = [plain.clone(), dotted, plain];
        let file = film(&pictures, 15).unwrap();
        let mut reader = png::Decoder::new(file.as_slice()).read_info().unwrap();
        assert_eq!(reader.info().animation_control().map(|control| control.num_frames), Some(3));
        let mut boxes = Vec::new();
        for _ in &pictures {
            let mut bytes = vec![0; reader.output_buffer_size()];
            reader.next_frame(&mut bytes).unwrap();
            let control = reader.info().frame_control().unwrap();
            boxes.push([control.x_offset, control.y_offset, control.width, control.height]);
        }
        assert_eq!(boxes, [[0, 0, 40, 30], [7, 5, 3, 2], [7, 5, 3, 2]]);
        assert!(film(&[], 15).is_err());
    }

    #[test]
    fn no_robot_hides_the_view_of_its_cameras() {
        let def = scene_loader::load("smooth", &[]).unwrap();
        let (stage, mut world) = (Stage::new(&def), World::new(def.clone(), Options::default()));
        // In the air, far from each other and from their shadows.
        for (number, class) in def.robots.keys().enumerate() {
            let location = [20.0 * number as f64, 0.0, -10.0];
            let init = gamebots_proto::command::Init { class_name: class.clone(), location, ..Default::default() };
            world.init(&init, &mut Vec::new()).unwrap();
        }
        let (snapshot, size) = (world.snapshot(), [32, 24]);
        let only = |robots: &[scene::RobotSnapshot]| Snapshot { robots: robots.to_vec(), ..snapshot.clone() };
        let mut blind = Vec::new();
        for robot in &snapshot.robots {
            let class = &def.robots[&robot.class];
            for sensor in class.sensors.iter().filter(|sensor| sensor.config.is_camera()) {
                let camera = Camera::of_robot(class, robot, sensor, 0.8, size).unwrap();
                let draw = |snapshot: &Snapshot| view(&stage, &def, snapshot, robot.id, &camera, size).pixels;
                let (with, without) = (draw(&only(std::slice::from_ref(robot))), draw(&only(&[])));
                let hidden = with.iter().zip(without).filter(|(with, without)| *with != without).count();
                if hidden > 32 * 24 / 2 {
                    blind.push(format!("{}, {}: {hidden} of 768 pixels", robot.class, sensor.name));
                }
            }
        }
        assert!(blind.is_empty(), "{blind:#?}");
    }
}
