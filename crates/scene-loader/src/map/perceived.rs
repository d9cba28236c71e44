//! Tables of `map.toml` for what sensors perceive beside shapes: victims, RFID tags, smoke and sounds.

use std::ops::Range;

use scene::{Material, RfidTag, Shape, Smoke, Solid, Sound, Victim, check};
use serde::Deserialize;

use crate::document::{Document, Table, Vector};
use crate::materials::Materials;

/// Material of clothes with its own colour.
const CLOTHES: (&str, [f64; 3]) = ("carpet", [0.22, 0.29, 0.45]);
/// Material of skin.
const SKIN: (&str, [f64; 3]) = ("nylon", [0.87, 0.68, 0.55]);
/// Time between two moans of a victim, s.
const MOAN_INTERVAL: f64 = 4.0;
/// Length of a moan, s.
const MOAN_LENGTH: f64 = 1.5;

#[derive(Deserialize, Clone, Copy, Default)]
#[serde(rename_all = "lowercase")]
enum Posture {
    #[default]
    Lying,
    Sitting,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VictimTable {
    name: String,
    position: Vector,
    #[serde(default)]
    rotation: Vector,
    #[serde(default)]
    posture: Posture,
    #[serde(default)]
    moves: bool,
    #[serde(default)]
    volume: f64,
    #[serde(default)]
    co2: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TagTable {
    id: u32,
    position: Vector,
    #[serde(default)]
    memory: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SmokeTable {
    name: String,
    position: Vector,
    size: Vector,
    density: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SoundTable {
    name: String,
    position: Vector,
    volume: f64,
    duration: f64,
    interval: f64,
}

/// Definitions from the tables of a map.
#[derive(Default)]
pub(super) struct Perceived {
    pub(super) victims: Vec<Victim>,
    pub(super) tags: Vec<RfidTag>,
    pub(super) smoke: Vec<Smoke>,
    pub(super) sounds: Vec<Sound>,
    /// The bodies of the victims.
    pub(super) solids: Vec<Solid>,
}

pub(super) fn read<'a>(document: &mut Document<'a>, root: &mut Table<'a>, materials: &Materials) -> Perceived {
    let mut all = Perceived::default();
    for (span, table) in document.list::<VictimTable>(root, "victim") {
        read_victim(document, &span, table, materials, &mut all);
    }
    for (span, TagTable { id, position, memory }) in document.list(root, "rfid") {
        let tag = RfidTag { id, position, memory };
        document.wrong(&span, check::tag(&tag));
        if all.tags.iter().any(|other| other.id == id) {
            document.problem(&span, format_args!("`id` {id} is another tag's: expected one of its own"));
        }
        all.tags.push(tag);
    }
    for (span, SmokeTable { name, position, size, density }) in document.list(root, "smoke") {
        let smoke = Smoke { name, position, size, density };
        document.wrong(&span, check::smoke(&smoke));
        all.smoke.push(smoke);
    }
    for (span, SoundTable { name, position, volume, duration, interval }) in document.list(root, "sound") {
        let sound = Sound { name, position, volume, duration, interval };
        document.wrong(&span, check::sound(&sound));
        all.sounds.push(sound);
    }
    all
}

/// A part of a body: its word, shape, position and rotation in the victim's frame, and material.
type Limb<'a> = (&'a str, Shape, [f64; 3], [f64; 3], &'a Material);

fn read_victim(
    document: &mut Document,
    span: &Range<usize>,
    table: VictimTable,
    materials: &Materials,
    all: &mut Perceived,
) {
    let VictimTable { name, position, rotation, posture, moves, volume, co2 } = table;
    let victim = Victim { name, position, rotation, moves, co2 };
    document.wrong(span, check::victim(&victim));
    if all.victims.iter().any(|other| other.name == victim.name) {
        document.problem(span, format_args!("`name` {} is another victim's: expected one of its own", victim.name));
    }
    let body = body(&victim, posture, materials);
    let head = body.first().map_or(position, |head| head.position);
    if volume != 0.0 {
        let name = victim.name.clone();
        let moan = Sound { name, position: head, volume, duration: MOAN_LENGTH, interval: MOAN_INTERVAL };
        document.wrong(span, check::sound(&moan));
        all.sounds.push(moan);
    }
    all.solids.extend(body);
    all.victims.push(victim);
}

/// Returns the solids of a body of 1.75 m, the head first. Its frame has the pelvis on the ground at the origin; the legs point to -x
/// of one who lies on the back, and to +x of one who sits.
fn body(victim: &Victim, posture: Posture, materials: &Materials) -> Vec<Solid> {
    let material = |(name, colour): (&str, [f64; 3])| {
        let material = materials.get(name).cloned().unwrap_or_default();
        Material { colour, ..material }
    };
    let [clothes, skin] = [CLOTHES, SKIN].map(material);
    let along_x = [0.0, std::f64::consts::FRAC_PI_2, 0.0];
    let (ball, limb) = (|radius| Shape::Ball { radius }, |radius, length| Shape::Cylinder { radius, length });
    let edges = |size| Shape::Box { size };
    // Of paired parts the right one, which is mirrored by its y.
    let parts: [Limb; 7] = match posture {
        Posture::Lying => [
            ("Head", ball(0.1), [0.72, 0.0, -0.1], [0.0; 3], &skin),
            ("Chest", edges([0.45, 0.36, 0.2]), [0.38, 0.0, -0.1], [0.0; 3], &clothes),
            ("Pelvis", edges([0.2, 0.32, 0.18]), [0.05, 0.0, -0.09], [0.0; 3], &clothes),
            ("Arm", limb(0.045, 0.5), [0.34, 0.24, -0.05], along_x, &clothes),
            ("Hand", ball(0.045), [0.05, 0.25, -0.045], [0.0; 3], &skin),
            ("Leg", limb(0.065, 0.75), [-0.43, 0.1, -0.065], along_x, &clothes),
            ("Foot", edges([0.08, 0.09, 0.22]), [-0.84, 0.1, -0.11], [0.0; 3], &skin),
        ],
        Posture::Sitting => [
            ("Head", ball(0.1), [-0.02, 0.0, -0.8], [0.0; 3], &skin),
            ("Chest", edges([0.2, 0.36, 0.45]), [0.0, 0.0, -0.45], [0.0; 3], &clothes),
            ("Pelvis", edges([0.22, 0.32, 0.22]), [0.0, 0.0, -0.11], [0.0; 3], &clothes),
            ("Arm", limb(0.045, 0.5), [0.04, 0.24, -0.41], [0.0; 3], &clothes),
            ("Hand", ball(0.045), [0.08, 0.25, -0.12], [0.0; 3], &skin),
            ("Leg", limb(0.065, 0.75), [0.48, 0.1, -0.065], along_x, &clothes),
            ("Foot", edges([0.08, 0.09, 0.22]), [0.9, 0.1, -0.11], [0.0; 3], &skin),
        ],
    };
    let pose = victim.pose();
    let mut solids = Vec::new();
    for (part, shape, [x, y, z], turn, material) in parts {
        let sides: &[(f64, &str)] = if y == 0.0 { &[(1.0, "")] } else { &[(1.0, "-right"), (-1.0, "-left")] };
        for (side, suffix) in sides {
            let (position, rotation) = scene::position_and_rotation(&(pose * scene::pose([x, side * y, z], turn)));
            let name = format!("{}/{part}{suffix}", victim.name);
            solids.push(Solid { name, shape: shape.clone(), position, rotation, material: material.clone() });
        }
    }
    solids
}
