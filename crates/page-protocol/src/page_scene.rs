//! The scene for viewers: the definitions, together with derived values, so that a viewer needs no formulas of its own.
//!
//! Shapes are serialized directly: as a tree of JSON values, the meshes of a map would take a gigabyte.

use std::borrow::Cow;
use std::collections::BTreeMap;

use nalgebra::Vector3;
use scene::goal::Goal;
use scene::{
    Drawn as DrawnPiece, Geometry, JointKind, MapDef, MountedWheel, Moves, ObjectSnapshot, Pads, Pose, RobotDef,
    SensorDef, Shape, WorldDef,
};
use serde::Serialize;

use picture::SENSOR_SIZE;

/// The server's settings that a page needs beside the world.
#[derive(Debug, Clone)]
pub struct About {
    /// Seed of the world.
    pub seed: u64,
    /// Time step, s.
    pub time_step: f64,
    /// Port for controllers.
    pub port: u16,
    /// Maps that it can change to, with their descriptions.
    pub maps: Vec<(String, String)>,
}

/// Position x y z, m, and quaternion x y z w, in the frame of the parent.
type Place = [f64; 7];

/// Defines structs of the scene, and in tests their TypeScript.
macro_rules! page_types {
    ($($(#[$of_type:meta])* struct $name:ident$(<$a:lifetime>)? { $($(#[$of_field:meta])* $field:ident: $type:ty,)* })*) => {
        $(
            $(#[$of_type])*
            #[derive(Serialize)]
            #[cfg_attr(test, derive(ts_rs::TS))]
            struct $name$(<$a>)? { $($(#[$of_field])* $field: $type,)* }
        )*

        /// Returns the TypeScript of every type.
        #[cfg(test)]
        fn declarations() -> Vec<String> {
            let config = ts_rs::Config::default();
            vec![$(<$name as ts_rs::TS>::decl(&config)),*]
        }
    };
}

page_types! {
    /// The scene of `/scene.json`. Without a server, as for a log's world, its settings are null.
    struct Scene<'a> {
        version: &'a str,
        #[cfg_attr(test, ts(type = "number | null"))]
        seed: Option<u64>,
        /// Time step, s.
        time_step: Option<f64>,
        /// Port for controllers.
        port: Option<u16>,
        /// Maps that the server can change to.
        maps: Vec<OtherMap<'a>>,
        map: Map<'a>,
        /// Names of all classes.
        names: Vec<&'a str>,
        /// Classes of a log's world. A server has each at `/class/<name>`.
        #[cfg_attr(test, ts(type = "Record<string, RobotClass>"))]
        classes: BTreeMap<&'a str, RobotClass<'a>>,
        league: Option<League<'a>>,
        scenario: Option<Scenario<'a>>,
    }

    /// Rules of the league that is played.
    struct League<'a> {
        /// Victims to be found; 0 if they do not count.
        victims: usize,
        teams: Vec<Team<'a>>,
        /// Places of goals that have one; victims are to be found.
        targets: Vec<Target<'a>>,
    }

    /// Place of a goal: a box, or a circle on the ground.
    struct Target<'a> {
        name: &'a str,
        /// Middle, m.
        position: [f64; 3],
        /// Edges of a box, m; null for a circle.
        size: Option<[f64; 3]>,
        /// Radius of a circle, m; null for a box.
        radius: Option<f64>,
    }

    struct Team<'a> {
        name: &'a str,
        starts: Vec<NamedPlace<'a>>,
        /// Classes that its robots may have; any if empty.
        classes: &'a [String],
    }

    /// The scenario that is played.
    struct Scenario<'a> {
        name: &'a str,
        title: &'a str,
        text: &'a str,
        keys: &'a str,
        robots: Vec<ScenarioRobot<'a>>,
        /// Names of the goals, in the order of the file.
        goals: Vec<&'a str>,
        /// Simulated times for three stars and two, s.
        stars: [f64; 2],
        /// Simulated time to its end, s.
        time_limit: f64,
        camera: Option<Viewpoint>,
    }

    /// A robot that plays, at the start of its name.
    struct ScenarioRobot<'a> {
        class: &'a str,
        name: &'a str,
    }

    /// A place to look from, and the point in the middle, m.
    struct Viewpoint {
        from: [f64; 3],
        at: [f64; 3],
    }

    /// A scenario as `/scenarios.json` lists it.
    struct ScenarioCard<'a> {
        name: &'a str,
        title: &'a str,
        text: &'a str,
        keys: &'a str,
        map: &'a str,
        robots: &'a [String],
        time_limit: f64,
        stars: [f64; 2],
        /// True if `/scenario/<name>/demo.mcap` is a run that reaches the goals.
        demo: bool,
        /// True if `/scenario/<name>/picture.jpg` shows it.
        picture: bool,
    }

    struct OtherMap<'a> {
        name: &'a str,
        description: &'a str,
    }

    struct Map<'a> {
        name: &'a str,
        description: &'a str,
        /// Classes of robots that suit it, to be offered.
        robots: &'a [String],
        solids: Vec<Solid<'a>>,
        /// Solids that are only seen, without edges and shadows.
        markings: Vec<Solid<'a>>,
        objects: Vec<Solid<'a>>,
        starts: Vec<NamedPlace<'a>>,
        path_nodes: Vec<NamedPlace<'a>>,
        sights: Vec<Sight<'a>>,
    }

    /// A part of the map beside solids and objects, for lists.
    struct Sight<'a> {
        #[cfg_attr(test, ts(type = "'Victims' | 'Conveyors' | 'Smoke' | 'Sounds' | 'Tags'"))]
        kind: &'a str,
        name: Cow<'a, str>,
        position: [f64; 3],
        /// Description in a few words.
        about: String,
    }

    struct Solid<'a> {
        name: &'a str,
        #[cfg_attr(test, ts(type = "Shape"))]
        shape: Cow<'a, Shape>,
        pose: Place,
        /// Name of the material.
        material: &'a str,
        colour: [f64; 3],
        friction: f64,
        /// Mass of a movable object, kg.
        #[serde(skip_serializing_if = "Option::is_none")]
        #[cfg_attr(test, ts(optional))]
        mass: Option<f64>,
    }

    /// An object that the map does not have.
    struct Spawned<'a> {
        #[cfg_attr(test, ts(type = "number"))]
        number: u64,
        #[serde(flatten)]
        solid: Solid<'a>,
    }

    struct NamedPlace<'a> {
        name: &'a str,
        position: [f64; 3],
        /// Roll, pitch, yaw, rad.
        rotation: [f64; 3],
    }

    struct RobotClass<'a> {
        description: &'a str,
        #[cfg_attr(test, ts(type = "'SkidSteered' | 'OmniDrive' | 'AckermanSteered' | 'Aerial' | 'Legged' | 'None'"))]
        steering: &'a str,
        /// Largest angles of front and rear, rad.
        max_steer: [f64; 2],
        drive_model: &'a str,
        wheel_radius: f64,
        track: f64,
        wheel_base: f64,
        /// Pieces of the body.
        drawn: Vec<Drawn<'a>>,
        /// Links except the body and driven wheels.
        links: Vec<Link<'a>>,
        /// Driven wheels.
        wheels: Vec<Wheel<'a>>,
        /// Links with a joint that has a value, in the order of a log's positions.
        values: Vec<&'a str>,
        /// Joints that go to positions.
        joints: Vec<Joint<'a>>,
        grippers: Vec<Gripper<'a>>,
        sensors: Vec<Sensor<'a>>,
    }

    struct Link<'a> {
        name: &'a str,
        /// Index of the parent among the links; null for the body.
        parent: Option<usize>,
        /// Pose in the robot frame when every joint is at 0.
        pose: Place,
        drawn: Vec<Drawn<'a>>,
    }

    /// A piece of a robot in the frame of its link.
    struct Drawn<'a> {
        #[cfg_attr(test, ts(type = "Shape"))]
        shape: Cow<'a, Shape>,
        pose: Place,
        colour: [f64; 3],
        /// Speed about its own z axis, rad/s: it turns with the world's time.
        spin: f64,
    }

    struct Wheel<'a> {
        name: &'a str,
        /// Index of the carrier among the links; null for the body.
        link: Option<usize>,
        /// Position in the carrier's frame, m.
        position: [f64; 3],
        /// Pieces except rollers and pads.
        drawn: Vec<Drawn<'a>>,
        /// Speed limit, rad/s.
        max_speed: Option<f64>,
        rollers: Option<Rollers>,
        /// Half length and half width of its tyre's contact patch, m; null for a rigid disc.
        patch: Option<[f64; 2]>,
        /// Pads of the belt around it; a wheel with a belt does not turn.
        belt: Option<Belt>,
    }

    /// Boxes that move along a closed path around a sprocket.
    struct Belt {
        /// Corners of the path, x and z in the wheel's frame, m.
        path: Vec<[f64; 2]>,
        pads: usize,
        /// Edges of a pad along the path, across the belt and outward, m.
        size: [f64; 3],
        /// Travel for each rad of the sprocket, m.
        radius: f64,
        colour: [f64; 3],
    }

    struct Rollers {
        /// Poses in the wheel's frame.
        poses: Vec<Place>,
        /// Points of the outline: along the axis and away from it, m.
        outline: Vec<[f64; 2]>,
        colour: [f64; 3],
    }

    /// A joint that goes to a position by `SET {Type Joint}`.
    struct Joint<'a> {
        /// Name, which is that of the link that it moves.
        name: &'a str,
        /// Unit vector in the link's frame: the link turns about it or moves along it.
        axis: [f64; 3],
        min: f64,
        max: f64,
        #[cfg_attr(test, ts(type = "'rad' | 'm'"))]
        unit: &'a str,
    }

    /// Joints that open and close together.
    struct Gripper<'a> {
        name: &'a str,
        joints: Vec<&'a str>,
        /// Positions of the joints, rad or m.
        open: &'a [f64],
        closed: &'a [f64],
        /// Index among the links of the one that carries the joints; null for the body.
        link: Option<usize>,
        /// Middle between the fingers in that link's frame, m.
        middle: [f64; 3],
    }

    struct Sensor<'a> {
        name: &'a str,
        /// Index of the carrier among the links; null for the body.
        link: Option<usize>,
        /// Pose in the carrier's frame.
        pose: Place,
        /// Size of its pictures; null if it is no camera.
        camera: Option<Camera>,
        /// Greatest range, m.
        max_range: Option<f64>,
        fan: Option<Fan>,
    }

    /// Size of a camera's pictures, pixels.
    struct Camera {
        width: usize,
        height: usize,
    }

    /// Beams of a laser.
    struct Fan {
        /// Angle of the first beam, rad.
        first: f64,
        /// Angle between two beams, rad.
        resolution: f64,
        /// True if the beams are in the sensor's horizontal plane.
        level: bool,
    }
}

/// Returns the map and the names of all classes as JSON. Without `about`, as for a log's world, it has no settings of a server, but every
/// class.
pub fn scene_json(world: &WorldDef, about: Option<&About>) -> String {
    let maps = about.iter().flat_map(|about| &about.maps);
    let classes = about.is_none().then(|| world.robots.iter()).into_iter().flatten();
    let scene = Scene {
        version: env!("CARGO_PKG_VERSION"),
        seed: about.map(|about| about.seed),
        time_step: about.map(|about| about.time_step),
        port: about.map(|about| about.port),
        maps: maps.map(|(name, description)| OtherMap { name, description }).collect(),
        map: map(&world.map),
        names: world.robots.keys().map(String::as_str).collect(),
        classes: classes.map(|(name, def)| (name.as_str(), class(def))).collect(),
        league: world.league.as_ref().map(|rules| league(rules, &world.map)),
        scenario: world
            .scenario
            .as_ref()
            .zip(world.league.as_ref())
            .map(|(it, league)| scenario(it, league, &world.map)),
    };
    // Every key is a string, so serialization cannot fail.
    serde_json::to_string(&scene).unwrap_or_default()
}

/// Returns scenarios as JSON, each with whether it has a demo and a picture.
pub fn scenarios_json<'a>(scenarios: impl Iterator<Item = (&'a scene::ScenarioCard, bool, bool)>) -> String {
    let card = |(card, demo, picture): (&'a scene::ScenarioCard, bool, bool)| ScenarioCard {
        name: &card.name,
        title: &card.title,
        text: &card.text,
        keys: &card.keys,
        map: &card.map,
        robots: &card.robots,
        time_limit: card.time_limit,
        stars: card.stars,
        demo,
        picture,
    };
    // Every key is a string, so serialization cannot fail.
    serde_json::to_string(&scenarios.map(card).collect::<Vec<_>>()).unwrap_or_default()
}

/// Returns a robot class as JSON.
pub fn class_json(def: &RobotDef) -> String {
    // Every key is a string, so serialization cannot fail.
    serde_json::to_string(&class(def)).unwrap_or_default()
}

/// Returns objects beside the map's as JSON.
pub fn objects_json(objects: &[ObjectSnapshot]) -> String {
    let objects = objects.iter().map(|object| Spawned { number: object.id.0, solid: object_solid(&object.def) });
    serde_json::to_string(&objects.collect::<Vec<_>>()).unwrap_or_default()
}

fn map(map: &MapDef) -> Map<'_> {
    Map {
        name: &map.name,
        description: &map.description,
        robots: &map.robots,
        solids: map.solids.iter().map(solid).collect(),
        markings: map.markings.iter().map(solid).collect(),
        objects: map.objects.iter().map(object_solid).collect(),
        starts: map.starts.iter().map(named).collect(),
        path_nodes: map.path_nodes.iter().map(named).collect(),
        sights: sights(map),
    }
}

/// Lists what a map has beside solids and objects.
fn sights(map: &MapDef) -> Vec<Sight<'_>> {
    fn sight<'a>(kind: &'a str, name: impl Into<Cow<'a, str>>, position: [f64; 3], about: String) -> Sight<'a> {
        Sight { kind, name: name.into(), position, about }
    }
    let victims = map.victims.iter().map(|it| {
        let moves = if it.moves { "moves" } else { "lies still" };
        sight("Victims", &it.name, it.position, format!("{moves}, CO2 {}", it.co2))
    });
    let conveyors = map.conveyors.iter().filter_map(|it| {
        let belt = map.solids.get(it.solid)?;
        let speed = it.velocity.iter().map(|part| part * part).sum::<f64>().sqrt();
        Some(sight("Conveyors", &belt.name, belt.position, format!("{speed:.2} m/s")))
    });
    let smoke = map.smoke.iter().map(|it| {
        let [x, y, z] = it.size;
        sight("Smoke", &it.name, it.position, format!("{x} x {y} x {z} m, density {} per m", it.density))
    });
    let sounds = map
        .sounds
        .iter()
        .map(|it| sight("Sounds", &it.name, it.position, format!("volume {}, every {} s", it.volume, it.interval)));
    let tags = map.tags.iter().map(|it| sight("Tags", it.id.to_string(), it.position, "RFID".to_owned()));
    victims.chain(conveyors).chain(smoke).chain(sounds).chain(tags).collect()
}

fn league<'a>(rules: &'a scene::League, map: &MapDef) -> League<'a> {
    let team = |team: &'a scene::Team| Team {
        name: &team.name,
        starts: team.starts.iter().map(named).collect(),
        classes: &team.classes,
    };
    League {
        victims: rules.victims.map_or(0, |_| map.victims.len()),
        teams: rules.teams.iter().map(team).collect(),
        targets: rules.goals.iter().filter_map(target).collect(),
    }
}

fn target(goal: &scene::ScoredGoal) -> Option<Target<'_>> {
    let name = &goal.name;
    let circle = |[x, y]: [f64; 2], radius| Target { name, position: [x, y, 0.0], size: None, radius: Some(radius) };
    let middle = |ranges: [[f64; 2]; 2]| ranges.map(|[least, most]| (least + most) / 2.0);
    match &goal.goal {
        Goal::Zone(zone) => Some(Target { name, position: zone.position, size: Some(zone.size), radius: None }),
        Goal::Reach(reach) => Some(circle(reach.point?, reach.tolerance)),
        Goal::Push(push) => Some(circle(middle(push.target), push.tolerance)),
        Goal::Fetch(fetch) => Some(circle(middle(fetch.target), fetch.tolerance)),
        Goal::Follow(_) | Goal::Explore(_) | Goal::Find(_) => None,
    }
}

fn scenario<'a>(def: &'a scene::Scenario, league: &'a scene::League, map: &'a MapDef) -> Scenario<'a> {
    let victims = league.victims.iter().flat_map(|_| &map.victims).map(|victim| victim.name.as_str());
    Scenario {
        name: &def.name,
        title: &def.title,
        text: &def.text,
        keys: &def.keys,
        robots: def.robots.iter().map(|it| ScenarioRobot { class: &it.class, name: &it.name }).collect(),
        goals: victims.chain(league.goals.iter().map(|goal| goal.name.as_str())).collect(),
        stars: def.stars,
        time_limit: league.time_limit,
        camera: def.camera.map(|scene::Viewpoint { from, at }| Viewpoint { from, at }),
    }
}

fn solid(solid: &scene::Solid) -> Solid<'_> {
    Solid {
        name: &solid.name,
        shape: shape(Cow::Borrowed(&solid.shape)),
        pose: place(&solid.pose()),
        material: &solid.material.name,
        colour: solid.material.colour,
        friction: solid.material.friction,
        mass: None,
    }
}

fn object_solid(object: &scene::Object) -> Solid<'_> {
    Solid { mass: Some(object.mass), ..solid(&object.solid) }
}

fn named(place: &scene::NamedPose) -> NamedPlace<'_> {
    NamedPlace { name: &place.name, position: place.position, rotation: place.rotation }
}

fn class(def: &RobotDef) -> RobotClass<'_> {
    let drawn: Vec<_> = def.drawn().collect();
    let wheels = drawn.iter().enumerate().filter_map(|(number, (link, pieces))| {
        let wheel = MountedWheel::of((number, link)).filter(|wheel| wheel.drive.is_some())?;
        Some(self::wheel(def, wheel, pieces))
    });
    // Poses with every joint at 0: logs from before robots were trees do not have them.
    let at_rest = def.placed_links(&[]);
    let links = drawn.iter().zip(&at_rest).enumerate().skip(1);
    let links = links.filter(|(_, ((link, _), _))| !link.is_driven_wheel());
    let geometry = def.wheel_geometry();
    RobotClass {
        description: &def.description,
        steering: def.steering.wire_name(),
        max_steer: [0, 1].map(|axle| most_steered(def, axle)),
        drive_model: def.drive_model.name(),
        wheel_radius: geometry.radius,
        track: geometry.track,
        wheel_base: geometry.wheel_base,
        drawn: drawn.first().map_or_else(Vec::new, |(_, pieces)| still(pieces)),
        links: links
            .map(|(number, ((link, pieces), (_, at)))| Link {
                name: &link.name,
                parent: def.parent_of(number).and_then(|parent| link_number(def, parent)),
                pose: place(at),
                drawn: still(pieces),
            })
            .collect(),
        wheels: wheels.collect(),
        values: def.with_values().map(|link| link.name.as_str()).collect(),
        joints: def.with_values().filter_map(joint).collect(),
        grippers: def.grippers.iter().map(|it| gripper(def, it)).collect(),
        sensors: def.sensors.iter().map(|it| sensor(def, it)).collect(),
    }
}

fn sensor<'a>(def: &RobotDef, sensor: &'a SensorDef) -> Sensor<'a> {
    let [width, height] = SENSOR_SIZE;
    let fan = |fan: scene::sensor::Fan| Fan { first: fan.first, resolution: fan.resolution, level: fan.level };
    Sensor {
        name: &sensor.name,
        link: link_number(def, sensor.link),
        pose: place(&def.mount_of(sensor).map_or_else(Pose::identity, |(_, _, mount)| mount)),
        camera: sensor.config.is_camera().then_some(Camera { width, height }),
        max_range: sensor.config.max_range(),
        fan: sensor.config.fan().map(fan),
    }
}

fn joint(link: &scene::Link) -> Option<Joint<'_>> {
    let [min, max] = link.position_limits()?;
    let joint = link.joint.as_ref()?;
    let slides = joint.kind == JointKind::Prismatic;
    Some(Joint { name: &link.name, axis: joint.axis, min, max, unit: if slides { "m" } else { "rad" } })
}

fn gripper<'a>(def: &'a RobotDef, gripper: &'a scene::Gripper) -> Gripper<'a> {
    let fingers = || gripper.links.iter().filter_map(|&link| def.links.get(link));
    let joints = fingers().map(|link| link.name.as_str()).collect();
    let carrier = gripper.links.first().and_then(|&link| def.parent_of(link)).unwrap_or(0);
    let solids: Vec<_> = fingers().flat_map(|link| &link.solids).map(|solid| Vector3::from(solid.position)).collect();
    let middle = solids.iter().sum::<Vector3<f64>>() / solids.len().max(1) as f64;
    let middle = (middle - Vector3::from(def.links.get(carrier).map_or([0.0; 3], scene::Link::origin))).into();
    let (open, closed) = (&gripper.open, &gripper.closed);
    Gripper { name: &gripper.name, joints, open, closed, link: link_number(def, carrier), middle }
}

/// Returns the largest angle that all joints of an axle can steer to both sides, rad.
fn most_steered(def: &RobotDef, axle: usize) -> f64 {
    def.steering_limits(axle).map(|[least, most]| most.min(-least)).reduce(f64::min).unwrap_or(0.0)
}

fn wheel<'a>(def: &RobotDef, wheel: MountedWheel<'a>, drawn: &[DrawnPiece<'a>]) -> Wheel<'a> {
    let carrier = def.links.get(wheel.parent).map_or([0.0; 3], scene::Link::origin);
    let [x, y, z] = wheel.position;
    let [from_x, from_y, from_z] = carrier;
    let rollers: Vec<&DrawnPiece> = drawn.iter().filter(|it| it.moves == Moves::Roller).collect();
    let outline = rollers.first().and_then(|it| match &it.geometry {
        Geometry::Revolved(outline) => Some((outline, it.colour)),
        Geometry::Shape(_) => None,
    });
    Wheel {
        name: wheel.name,
        link: link_number(def, wheel.parent),
        position: [x - from_x, y - from_y, z - from_z],
        drawn: still(drawn),
        max_speed: wheel.drive.as_ref().map(|motor| motor.max_speed),
        rollers: outline.map(|(outline, colour)| Rollers {
            poses: rollers.iter().map(|roller| place(&roller.pose)).collect(),
            outline: outline.clone(),
            colour,
        }),
        patch: wheel.tyre.map(|tyre| tyre.patch),
        belt: wheel.belt.as_ref().map(|belt| {
            let Pads { path, count, size, radius } = belt.pads(wheel.width);
            Belt { path, pads: count, size, radius, colour: wheel.material.colour }
        }),
    }
}

/// Returns a link's index among the page's links; `None` for the body and driven wheels.
fn link_number(def: &RobotDef, link: usize) -> Option<usize> {
    let links = def.links.iter().enumerate().skip(1).filter(|(_, link)| !link.is_driven_wheel());
    links.map(|(number, _)| number).position(|number| number == link)
}

/// Returns the drawn pieces of a link, except rollers and pads, in its frame.
fn still<'a>(drawn: &[DrawnPiece<'a>]) -> Vec<Drawn<'a>> {
    let piece = |it: &DrawnPiece<'a>| {
        let spin = match it.moves {
            Moves::Still => 0.0,
            Moves::Spin(speed) => speed,
            Moves::Roller | Moves::Belt(_) => return None,
        };
        let Geometry::Shape(drawn) = &it.geometry else { return None };
        Some(Drawn { shape: shape(drawn.clone()), pose: place(&it.pose), colour: it.colour, spin })
    };
    drawn.iter().filter_map(piece).collect()
}

/// Returns a shape that a viewer can draw: a hull becomes its surface.
fn shape(shape: Cow<'_, Shape>) -> Cow<'_, Shape> {
    match &*shape {
        Shape::Hull { points } => scene::hull_surface(points).map_or(shape, Cow::Owned),
        _ => shape,
    }
}

fn place(pose: &Pose) -> Place {
    let ([x, y, z], [i, j, k, w]): ([f64; 3], [f64; 4]) = (pose.translation.vector.into(), pose.rotation.coords.into());
    [x, y, z, i, j, k, w]
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// `UPDATE_FIGURES=1` renews the file.
    #[test]
    fn the_page_has_the_types_of_the_scene() {
        let types: String = declarations().iter().map(|it| format!("\nexport {it}\n")).collect();
        let text = format!(
            "// Generated from crates/page-protocol/src/page_scene.rs by `make figures`.\n\n\
             import type {{ Shape }} from './shape.gen';\n{types}"
        );
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../viewer/src/protocol/scene.gen.ts");
        if std::env::var_os("UPDATE_FIGURES").is_some() {
            std::fs::write(&path, &text).expect("a file");
        }
        let found = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(found == text, "{} is out of date: `make figures` renews it", path.display());
    }
}
