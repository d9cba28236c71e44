//! USARSim's classes of sensors and their keys in its ini files. To add a class, add its row.
//!
//! A class has the value of its own section for a key, otherwise that of its parent's section, and so on. A partial ini is read as if it
//! came after DefaultUSAR.ini: a key that DefaultUSAR.ini sets for a class itself (`own`) is not inherited.

/// A class of sensors.
pub(super) struct Row {
    /// Names of the class: in UDK, then in UT2004.
    names: &'static [&'static str],
    /// Class that it extends.
    parent: Option<&'static str>,
    /// Class of robot.toml; `None` for one that cannot be mounted.
    pub(super) here: Option<&'static str>,
    /// Keys of the ini, and the keys of robot.toml that they set. Those that change nothing here have none.
    keys: &'static [(&'static str, &'static str)],
    /// Keys that DefaultUSAR.ini sets for this class itself.
    own: &'static [&'static str],
    /// Settings that differ from those of the class of robot.toml.
    pub(super) settings: &'static [(&'static str, &'static str)],
}

const PLAIN: Row = Row { names: &[], parent: Some("Sensor"), here: None, keys: &[], own: &[], settings: &[] };

const ROWS: &[Row] = &[
    Row {
        names: &["Sensor"],
        parent: None,
        keys: &[("ScanInterval", "scan_interval")],
        own: &["ScanInterval"],
        ..PLAIN
    },
    Row {
        names: &["GroundTruth"],
        here: Some("GroundTruth"),
        keys: &[("FixedToPlatform", "fixed_to_platform")],
        own: &["ScanInterval", "FixedToPlatform"],
        ..PLAIN
    },
    Row {
        names: &["GroundTruthMovable"],
        parent: Some("GroundTruth"),
        here: Some("GroundTruth"),
        own: &["ScanInterval", "FixedToPlatform"],
        settings: &[("fixed_to_platform", "false")],
        ..PLAIN
    },
    Row {
        names: &["INS", "INSSensor"],
        here: Some("INS"),
        keys: &[("Drifting", "drifting"), ("Precision", "precision")],
        own: &["ScanInterval", "Drifting", "Precision"],
        ..PLAIN
    },
    Row { names: &["IMU"], here: Some("IMU"), ..PLAIN },
    Row { names: &["Odometry", "OdometrySensor"], here: Some("Odometry"), own: &["ScanInterval"], ..PLAIN },
    Row { names: &["WheelSensor"], ..PLAIN },
    Row {
        names: &["Encoder", "EncoderSensor"],
        parent: Some("WheelSensor"),
        here: Some("Encoder"),
        keys: &[("Resolution", "resolution"), ("Noise", "noise")],
        own: &["Resolution", "Noise"],
        ..PLAIN
    },
    Row {
        names: &["Tachometer", "TachometerSensor"],
        parent: Some("WheelSensor"),
        here: Some("Tachometer"),
        own: &["ScanInterval"],
        ..PLAIN
    },
    Row {
        names: &["RangeSensor"],
        keys: &[("MaxRange", "max_range"), ("MinRange", "min_range")],
        own: &["MaxRange", "MinRange"],
        ..PLAIN
    },
    Row {
        names: &["RangeScanner"],
        parent: Some("RangeSensor"),
        here: Some("RangeScanner"),
        keys: &[("Resolution", "resolution"), ("ScanFov", "field_of_view"), ("bYaw", "yaw"), ("bPitch", "pitch")],
        own: &["MaxRange", "MinRange", "ScanInterval", "Resolution", "ScanFov", "bYaw", "bPitch"],
        ..PLAIN
    },
    Row {
        names: &["SICK", "SICKLMS"],
        parent: Some("RangeScanner"),
        here: Some("SICK"),
        own: &["MaxRange", "Resolution", "ScanFov"],
        ..PLAIN
    },
    Row {
        names: &["HokuyoURG04LX", "Hokuyo"],
        parent: Some("RangeScanner"),
        here: Some("HokuyoURG04LX"),
        own: &["MaxRange", "Resolution", "ScanFov", "ScanInterval"],
        ..PLAIN
    },
    Row {
        names: &["SonarSensor", "Sonar"],
        parent: Some("RangeSensor"),
        here: Some("Sonar"),
        keys: &[
            ("beamAngle", "beam_angle"),
            ("maxAngleOfIncidence", "max_angle_of_incidence"),
            ("numberOfCones", "number_of_cones"),
            ("tracesPerCone", "traces_per_cone"),
        ],
        own: &[
            "ScanInterval",
            "MaxRange",
            "MinRange",
            "beamAngle",
            "maxAngleOfIncidence",
            "numberOfCones",
            "tracesPerCone",
        ],
        ..PLAIN
    },
    Row {
        names: &["Touch", "TouchSensor"],
        here: Some("Touch"),
        keys: &[("Diameter", "diameter")],
        own: &["ScanInterval", "Diameter"],
        ..PLAIN
    },
    Row {
        names: &["USARCamera", "RobotCamera"],
        here: Some("Camera"),
        keys: &[
            ("CameraFOV", "field_of_view"),
            ("CameraMinFOV", "min_field_of_view"),
            ("CameraMaxFOV", "max_field_of_view"),
        ],
        own: &["CameraFOV", "CameraMinFOV", "CameraMaxFOV"],
        ..PLAIN
    },
    Row { names: &["AirRobotCamera"], parent: Some("USARCamera"), here: Some("Camera"), ..PLAIN },
    Row { names: &["Acceleration"], here: Some("Acceleration"), ..PLAIN },
    Row { names: &["Accelerometer"], here: Some("Accelerometer"), ..PLAIN },
    Row { names: &["AltitudeSensor"], here: Some("AltitudeSensor"), ..PLAIN },
    Row { names: &["MagneticCompass"], here: Some("MagneticCompass"), ..PLAIN },
    Row { names: &["MissionTime"], here: Some("MissionTime"), ..PLAIN },
    Row {
        names: &["IRSensor", "IR2Sensor"],
        parent: Some("RangeSensor"),
        here: Some("IRSensor"),
        own: &["MaxRange", "MinRange"],
        ..PLAIN
    },
    // Without yaw, as DefaultUSAR.ini has it, it would not scan.
    Row {
        names: &["IRScanner"],
        parent: Some("IRSensor"),
        here: Some("IRScanner"),
        keys: &[("Resolution", "resolution"), ("ScanFov", "field_of_view"), ("bYaw", ""), ("bPitch", "")],
        own: &["MaxRange", "MinRange", "ScanInterval", "Resolution", "ScanFov"],
        ..PLAIN
    },
    Row {
        names: &["RangeScanner3D"],
        here: Some("RangeScanner3D"),
        keys: &[
            ("MaxRange", "max_range"),
            ("MinRange", "min_range"),
            ("VerticalFOV", "vertical_field_of_view"),
            ("VerticalResolution", "vertical_resolution"),
            ("HorizontalFOV", "horizontal_field_of_view"),
            ("HorizontalResolution", "horizontal_resolution"),
        ],
        own: &["ScanInterval"],
        ..PLAIN
    },
    Row {
        names: &["KinectDepth"],
        parent: Some("RangeSensor"),
        here: Some("KinectDepth"),
        own: &["MaxRange"],
        ..PLAIN
    },
    Row {
        names: &["LineLaser"],
        parent: Some("RangeSensor"),
        here: Some("LineLaser"),
        keys: &[
            ("FOV", "field_of_view"),
            ("Resolution", "beams"),
            ("squareSize", ""),
            ("lineSpace", ""),
            ("isPointOnLineVariance", ""),
        ],
        own: &["ScanInterval", "FOV", "Resolution", "MaxRange", "MinRange"],
        ..PLAIN
    },
    // The interval of its beams is that of its readings here.
    Row {
        names: &["RotatingPointCloudScanner"],
        here: Some("RotatingPointCloudScanner"),
        keys: &[
            ("scanRate", "scan_interval"),
            ("numberOfBeams", "beams"),
            ("HFieldOfView", "horizontal_field_of_view"),
            ("VFieldOfView", "vertical_field_of_view"),
            ("maxRange", "max_range"),
            ("spinRate", "spin_time"),
        ],
        own: &["ScanInterval"],
        ..PLAIN
    },
    Row { names: &["RangeSensorArray"], ..PLAIN },
    Row {
        names: &["ExampleSonarArray"],
        parent: Some("RangeSensorArray"),
        here: Some("ExampleSonarArray"),
        keys: &[("gridSize", "size"), ("spacing", "spacing"), ("maxRange", "max_range")],
        own: &["ScanInterval"],
        ..PLAIN
    },
    Row {
        names: &["BumperArray"],
        here: Some("BumperArray"),
        keys: &[
            ("TouchRange", "reach"),
            ("Diameter", "diameter"),
            ("arcRadius", "arc_radius"),
            ("arcAngle", "arc_angle"),
            ("ScanStep", ""),
            ("PointsPerCircle", ""),
        ],
        ..PLAIN
    },
    // A class without a published source carries the GPS of AirRobot.
    Row {
        names: &["GPSSensor", "GPSSensor_FIXED"],
        here: Some("GPSSensor"),
        keys: &[
            ("maxNoise", "max_noise"),
            ("minNoise", "min_noise"),
            (LATITUDE, "latitude"),
            (LONGITUDE, "longitude"),
            (ORIGIN, ""),
        ],
        own: &["ScanInterval"],
        ..PLAIN
    },
    Row {
        names: &["AcousticArraySensor", "ExampleAcousticArray"],
        here: Some("AcousticArraySensor"),
        keys: &[("SoundSpeed", "sound_speed"), ("HearThreshold", "hear_threshold"), ("InitLoudnessRadius", "")],
        own: &["ScanInterval"],
        ..PLAIN
    },
    Row {
        names: &["ObjectSensor"],
        here: Some("ObjectSensor"),
        keys: &[
            ("MaxRange", "max_range"),
            ("ScanFov", "field_of_view"),
            ("Resolution", "resolution"),
            ("bYaw", ""),
            ("bPitch", ""),
        ],
        own: &["ScanInterval"],
        ..PLAIN
    },
    Row { names: &["RFIDSensor"], here: Some("RFIDSensor"), keys: &[("MaxRange", "max_range")], own: OWN, ..PLAIN },
    Row { names: &["RFIDReleaser"], here: Some("RFIDReleaser"), own: OWN, ..PLAIN },
    Row { names: &["VictSensor"], here: Some("VictSensor"), keys: &[("MaxRange", "max_range")], own: OWN, ..PLAIN },
    Row {
        names: &["HumanMotionSensor"],
        here: Some("HumanMotionSensor"),
        keys: &[("MaxRange", "max_range")],
        own: OWN,
        ..PLAIN
    },
    Row { names: &["SoundSensor"], here: Some("SoundSensor"), own: OWN, ..PLAIN },
    Row { names: &["CO2Sensor"], here: Some("CO2Sensor"), own: OWN, ..PLAIN },
    Row { names: &["INUSensor", "INU"], here: Some("INUSensor"), own: OWN, ..PLAIN },
    Row { names: &[BATTERY], here: Some(BATTERY), keys: &[(MAX_ENERGY, MAX_ENERGY), (LIFE, LIFE)], ..PLAIN },
];

/// Keys that the sensors of UT2004 set themselves.
const OWN: &[&str] = &["ScanInterval"];

/// The key of a GPS whose value in parentheses is the latitude and longitude of the map's origin, and the keys of these, degrees.
pub(super) const ORIGIN: &str = "ZeroZeroLocation";
pub(super) const LATITUDE: &str = "Latitude";
pub(super) const LONGITUDE: &str = "Longitude";

/// The class whose settings are those of the robot's battery, and its keys.
pub(super) const BATTERY: &str = "Battery";
pub(super) const MAX_ENERGY: &str = "maxEnergy";
pub(super) const LIFE: &str = "batteryLife";

/// Keys of sensors that change nothing that a controller can notice, or that this server leaves to itself: lines have a time where
/// DefaultUSAR.ini gives them one.
const WITHOUT_EFFECT: [&str; 14] = [
    "bWithTimeStamp",
    "HiddenSensor",
    "Weight",
    "Mass",
    "Noise",
    "bDebug",
    "bSendRange",
    "bSendPoints",
    "bDrawLines",
    "CameraNearPlane",
    "CameraFarPlane",
    "currentEnergy",
    "OutputCurve",
    "bUseGaussian",
];

/// Actuators of USARSim that have another name here.
pub(super) const ACTUATORS: [(&str, &str); 1] = [("ForkLift", "ForkliftArm")];

/// Items that are part of the actuator.toml that carries them. An ini cannot move them.
pub(super) const BUILT_IN: [&str; 3] = ["ToolChanger", "VacuumCup", "VacuumGripper"];

/// Returns the class with a name, in any case.
pub(super) fn row(name: &str) -> Option<&'static Row> {
    ROWS.iter().find(|row| is_among(row.names, name))
}

/// Returns all classes.
pub(super) fn rows() -> impl Iterator<Item = &'static Row> {
    ROWS.iter()
}

/// Returns the names of all classes.
pub(super) fn names() -> impl Iterator<Item = &'static str> + Clone {
    ROWS.iter().flat_map(|row| row.names.iter().copied())
}

impl Row {
    /// Returns its name in UDK.
    pub(super) fn name(&self) -> &'static str {
        self.names.first().copied().unwrap_or_default()
    }

    /// Returns this class, its parent, and so on.
    pub(super) fn chain(&'static self) -> impl Iterator<Item = &'static Self> + Clone {
        std::iter::successors(Some(self), |row| row.parent.and_then(self::row))
    }

    /// Returns the keys of the ini that set something, its own and its parents', and the keys of robot.toml.
    pub(super) fn all_keys(&'static self) -> impl Iterator<Item = (&'static str, &'static str)> + Clone {
        self.chain().flat_map(|row| row.keys.iter().copied())
    }

    /// True if DefaultUSAR.ini sets a key for this class itself.
    pub(super) fn owns(&self, key: &str) -> bool {
        is_among(self.own, key)
    }

    /// True if USARSim has a key that changes nothing here.
    pub(super) fn ignores(&self, key: &str) -> bool {
        is_among(&WITHOUT_EFFECT, key)
    }
}

/// True if a name is among names, in any case.
pub(super) fn is_among(names: &[&str], name: &str) -> bool {
    names.iter().any(|known| known.eq_ignore_ascii_case(name))
}

#[cfg(test)]
mod tests {
    use scene::sensor::{CLASSES, Config};

    use super::*;

    #[test]
    fn every_row_names_classes_and_keys_that_exist() {
        for row in ROWS {
            assert!(row.parent.is_none_or(|parent| self::row(parent).is_some()), "{}", row.name());
            assert!(row.own.iter().all(|own| row.all_keys().any(|(key, _)| key == *own)), "{}", row.name());
            let Some(here) = row.here else { continue };
            assert!(CLASSES.iter().any(|(class, _)| *class == here), "{here}");
            let settings = row.all_keys().map(|(_, key)| key).chain(row.settings.iter().map(|(key, _)| *key));
            for key in settings.filter(|key| !["", "scan_interval", MAX_ENERGY, LIFE].contains(key)) {
                let value = ["1.0", "1", "true"].into_iter().find(|value| {
                    let table = toml::Table::from_iter([(key.to_owned(), value.parse().expect("TOML"))]);
                    Config::read(here, table).expect("a class").is_ok()
                });
                assert!(value.is_some(), "{here} has no {key}");
            }
        }
    }

    /// A class that an ini names first is what its section sets.
    #[test]
    fn every_class_of_sensors_has_a_row() {
        let missing: Vec<&str> = CLASSES
            .iter()
            .map(|(class, _)| *class)
            .filter(|class| !ROWS.iter().any(|row| row.here == Some(*class)))
            .collect();
        assert!(missing.is_empty(), "{missing:?}");
    }
}
