//! The messages of `proto/usarsim.proto`.

use foxglove::{Encode, Schema};
use nalgebra::{Quaternion as Parts, Translation3, UnitQuaternion};
use prost::Message;
use prost::bytes::BufMut;
use scene::{
    Fnv, JointState, Object, ObjectSnapshot, PawnId, Pose, Reading, RobotDef, RobotSnapshot, Score, Sensed, Standings,
};

include!(concat!(env!("OUT_DIR"), "/usarsim.rs"));

/// Descriptor of every message in the file, for readers that do not know it.
const DESCRIPTOR: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/usarsim.desc"));

macro_rules! encode {
    ($($name:ident,)*) => {$(
        impl Encode for $name {
            type Error = prost::EncodeError;

            fn get_schema() -> Option<Schema> {
                Some(Schema::new(concat!("usarsim.", stringify!($name)), "protobuf", DESCRIPTOR))
            }

            fn get_message_encoding() -> String {
                "protobuf".to_owned()
            }

            fn encode(&self, buffer: &mut impl BufMut) -> Result<(), Self::Error> {
                Message::encode(self, buffer)
            }
        }
    )*};
}

encode! {
    WireLine, RobotLeft, RobotState, ObjectState, ObjectSpawned, ObjectRemoved, SensorReading, PictureTaken, LeagueScore,
    LeagueStandings,
}

impl RobotState {
    /// Creates the state of a robot from its snapshot.
    pub fn new(robot: &RobotSnapshot) -> Self {
        let RobotSnapshot { id, class, name, body, joints, .. } = robot;
        let (position, orientation) = parts(&body.pose);
        Self {
            robot: id.0,
            class: class.clone(),
            name: name.clone(),
            position: Some(position),
            orientation: Some(orientation),
            linear_velocity: Some(vector(&body.linear)),
            angular_velocity: Some(vector(&body.angular)),
            joint_positions: joints.iter().map(|joint| joint.position).collect(),
            joint_speeds: joints.iter().map(|joint| joint.speed).collect(),
        }
    }

    /// Returns positions and speeds of the joints that have a value. Numbers that a damaged log lacks are NaN.
    pub fn joints(&self) -> Vec<JointState> {
        let count = self.joint_positions.len().max(self.joint_speeds.len());
        let number = |numbers: &[f64], index: usize| numbers.get(index).copied().unwrap_or(f64::NAN);
        let joint = |index| JointState {
            position: number(&self.joint_positions, index),
            speed: number(&self.joint_speeds, index),
        };
        (0..count).map(joint).collect()
    }

    /// Returns the joints of wheels, and all other joints. If the class is unknown, all count as wheels.
    pub fn wheels_and_others(&self, def: Option<&RobotDef>) -> [Vec<JointState>; 2] {
        let known = def.into_iter().flat_map(RobotDef::with_values).map(|link| link.wheel.is_some());
        let joints = self.joints().into_iter().zip(known.chain(std::iter::repeat(true)));
        let (wheels, others): (Vec<_>, Vec<_>) = joints.partition(|(_, is_wheel)| *is_wheel);
        [wheels, others].map(|joints| joints.into_iter().map(|(joint, _)| joint).collect())
    }

    /// Returns the robot's pose in the world frame.
    pub fn pose(&self) -> Pose {
        pose(self.position, self.orientation)
    }

    /// Returns the velocity, m/s, and the angular velocity, rad/s, in world axes.
    pub fn velocity(&self) -> (nalgebra::Vector3<f64>, nalgebra::Vector3<f64>) {
        let axes = |vector: Option<Vector>| {
            vector.map_or_else(nalgebra::Vector3::zeros, |Vector { x, y, z }| nalgebra::Vector3::new(x, y, z))
        };
        (axes(self.linear_velocity), axes(self.angular_velocity))
    }
}

impl ObjectState {
    pub(crate) fn new(object: &ObjectSnapshot) -> Self {
        let (position, orientation) = parts(&object.pose);
        let (number, name) = (object.id.0 as u32, object.def.solid.name.clone());
        Self { object: number, name, position: Some(position), orientation: Some(orientation) }
    }

    /// Returns the object's pose in the world frame.
    pub fn pose(&self) -> Pose {
        pose(self.position, self.orientation)
    }
}

impl ObjectSpawned {
    pub(crate) fn new(object: &ObjectSnapshot) -> Self {
        // A definition has only text and numbers, so serialization cannot fail.
        let definition = serde_json::to_string(&*object.def).unwrap_or_default();
        Self { object: object.id.0 as u32, definition }
    }

    /// Returns the definition, or `None` if the text is none, as in a damaged log.
    pub fn def(&self) -> Option<Object> {
        let def: Object = serde_json::from_str(&self.definition).ok()?;
        scene::check::spawned_object(&def).is_empty().then_some(def)
    }
}

impl SensorReading {
    pub(crate) fn new(sensed: &Sensed) -> Self {
        let quantity = |scene::Quantity { name, unit, values }| {
            let (name, unit) = (str::to_owned(name), str::to_owned(unit));
            Quantity { name, unit, values }
        };
        Self {
            robot: sensed.robot.0,
            sensor: sensed.sensor as u32,
            r#type: sensed.reading.type_name().to_owned(),
            quantities: sensed.reading.quantities().into_iter().map(quantity).collect(),
        }
    }

    /// Returns the reading, or `None` for a type that this program does not know.
    pub(crate) fn sensed(&self) -> Option<Sensed> {
        let find = |name: &str| {
            let named = self.quantities.iter().find(|quantity| quantity.name == name);
            named.map(|quantity| quantity.values.as_slice())
        };
        let reading = Reading::read(&self.r#type, &find)?;
        Some(Sensed { robot: PawnId(self.robot), sensor: self.sensor as usize, reading })
    }
}

impl LeagueScore {
    pub(crate) fn new(score: &Score) -> Self {
        let Score { time, team, robot, reason, points, total, position } = score;
        let [x, y, z] = *position;
        let position = Some(Vector { x, y, z });
        let (team, reason) = (team.clone(), reason.clone());
        Self { time: *time, team, robot: *robot, reason, points: *points, total: *total, position }
    }

    pub(crate) fn score(self) -> Score {
        let Self { time, team, robot, reason, points, total, position } = self;
        let Vector { x, y, z } = position.unwrap_or_default();
        Score { time, team, robot, reason, points, total, position: [x, y, z] }
    }
}

impl LeagueStandings {
    pub(crate) fn new(standings: &Standings) -> Self {
        // Standings have only text and numbers, so serialization cannot fail.
        Self { standings: serde_json::to_string(standings).unwrap_or_default() }
    }

    /// Returns the standings, or `None` if the text is none, as in a damaged log.
    pub(crate) fn read(&self) -> Option<Standings> {
        serde_json::from_str(&self.standings).ok()
    }
}

impl PictureTaken {
    /// Creates the record of the picture of a camera's reading at a simulated time, s. `png` is its file.
    pub fn new(sensed: &Sensed, moment: f64, png: &[u8]) -> Self {
        let mut digest = Fnv::default();
        digest.mix(png);
        Self { robot: sensed.robot.0, sensor: sensed.sensor as u32, moment, digest: digest.value() }
    }
}

fn vector(vector: &nalgebra::Vector3<f64>) -> Vector {
    Vector { x: vector.x, y: vector.y, z: vector.z }
}

fn parts(pose: &Pose) -> (Vector, Quaternion) {
    let nalgebra::Vector4 { data, .. } = pose.rotation.coords;
    let [[x, y, z, w]] = data.0;
    (vector(&pose.translation.vector), Quaternion { x, y, z, w })
}

/// Restores a pose with the bits that were written: the quaternion is not normalised again.
fn pose(position: Option<Vector>, orientation: Option<Quaternion>) -> Pose {
    let Vector { x, y, z } = position.unwrap_or_default();
    let turn = orientation.unwrap_or(Quaternion { w: 1.0, ..Quaternion::default() });
    let turn = UnitQuaternion::new_unchecked(Parts::new(turn.w, turn.x, turn.y, turn.z));
    Pose::from_parts(Translation3::new(x, y, z), turn)
}
