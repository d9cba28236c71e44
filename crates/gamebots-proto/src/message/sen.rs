//! `SEN`: one reading of one sensor (protocol.md 4.3, 4.4). A header comes first, then the body of its type.

use crate::field::{self, Field, Format, Record, Table, Written};
use crate::{Dialect, Line};

/// The body of one type of sensor.
pub(crate) trait Body: Record {
    /// The word in `{Type ..}`.
    const TYPE: &'static str;
    /// Format of the time in the header.
    const TIME: [Format; 2];
    /// True if the readings of one step share a line in UT2004's dialect.
    const IS_GROUPED: bool = false;
    /// Returns the name of the sensor.
    fn name(&self) -> Option<&str>;
    /// True if a body that was read is complete.
    fn is_whole(&self) -> bool {
        true
    }
}

/// One reading with its time.
#[derive(Debug, Clone, PartialEq)]
pub struct Sen {
    /// Simulated time, s; `None` for the types that carry none.
    pub time: Option<f32>,
    /// The sensor's reading.
    pub reading: Reading,
}

macro_rules! readings {
    ($($file:ident::$name:ident,)*) => {
        $(
            mod $file;
            pub use $file::$name;
        )*

        /// The reading of any sensor.
        #[derive(Debug, Clone, PartialEq)]
        #[expect(missing_docs, reason = "each variant is documented at its type")]
        pub enum Reading { $($name($name),)* }

        /// All types, with the time in their header and their tables.
        pub(crate) const TABLES: &[(&str, Field, Table)] = &[$(($name::TYPE, time($name::TIME), $name::TABLE),)*];

        impl Reading {
            /// Returns the word in `{Type ..}`.
            pub fn type_name(&self) -> &'static str {
                match self { $(Self::$name(_) => $name::TYPE,)* }
            }

            /// Returns the sensor's name. Several encoders give the first name; a camera has none.
            pub fn name(&self) -> Option<&str> {
                match self { $(Self::$name(reading) => reading.name(),)* }
            }

            /// Adds the simulated time, s, if UDK's lines of this type carry it.
            pub fn at(self, time: f32) -> Sen {
                let is_stamped = self.time().format[0] != Format::Absent;
                Sen { time: is_stamped.then_some(time), reading: self }
            }

            /// True if the readings of one step share a line in a dialect.
            pub(crate) fn is_grouped(&self, dialect: Dialect) -> bool {
                dialect == Dialect::Ut2004 && match self { $(Self::$name(_) => $name::IS_GROUPED,)* }
            }

            fn time(&self) -> Field {
                match self { $(Self::$name(_) => time($name::TIME),)* }
            }

            fn write(&self, dialect: Dialect) -> Vec<Written> {
                match self { $(Self::$name(reading) => reading.write(dialect),)* }
            }

            fn read(line: &Line) -> Option<Self> {
                let type_name = line.get("Type")?;
                // Two types share the word PCL; their points have other separators.
                $(if type_name == $name::TYPE
                    && let Some(reading) = $name::read(line).filter(Body::is_whole)
                {
                    return Some(Self::$name(reading));
                })*
                None
            }
        }

        $(impl From<$name> for Reading {
            fn from(reading: $name) -> Self { Self::$name(reading) }
        })*
    };
}

readings! {
    ground_truth::GroundTruth,
    ins::Ins,
    imu::Imu,
    odometry::Odometry,
    encoder::Encoder,
    tachometer::Tachometer,
    range_scanner::RangeScanner,
    sonar::Sonar,
    touch::Touch,
    camera::Camera,
    acceleration::Acceleration,
    accelerometer::AcceleroMeter,
    altitude::AltitudeSensor,
    compass::MagneticCompass,
    mission_time::MissionTime,
    ir::Ir,
    ir_scanner::IrScanner,
    range_scanner_3d::RangeScanner3D,
    range_imager::RangeImager,
    line_laser::LineLaser,
    point_cloud::PointCloud,
    sonar_array::SonarArray,
    touch_array::TouchArray,
    gps::Gps,
    acoustic::Acoustic,
    object_sensor::ObjectSensor,
    rfid::Rfid,
    victim::VictSensor,
    human_motion::HumanMotion,
    sound::Sound,
    co2::Co2,
    inu::Inu,
}

pub use acoustic::Heard;
pub use encoder::Tick;
pub use gps::Bearing;
pub use ir::IrConf;
pub use line_laser::LineLaserConf;
pub use object_sensor::SeenObject;
pub use range_imager::RangeImagerConf;
pub use range_scanner_3d::RangeScanner3DConf;
pub use rfid::SeenTag;
pub use touch::TouchConf;
pub use touch_array::{ArcRotation, TouchArrayConf};
pub use victim::SeenPart;

const fn time(format: [Format; 2]) -> Field {
    Field::new("Time", format[0]).ut2004(format[1]).unit("s").about(" Simulated time.")
}

impl Sen {
    pub(super) fn write(&self, dialect: Dialect) -> String {
        Self::write_together(&[self], dialect)
    }

    /// Writes one line for a reading, or for several of one type that share it. An empty body still leaves the space before it
    /// (Item.uc:43).
    pub(super) fn write_together(readings: &[&Self], dialect: Dialect) -> String {
        let Some(first) = readings.first() else { return String::new() };
        let body: Vec<Written> = readings.iter().flat_map(|it| it.reading.write(dialect)).collect();
        let body = match body.is_empty() {
            true => " ".to_owned(),
            false if first.reading.is_grouped(dialect) => field::merged(&body),
            false => field::blocks(body),
        };
        first.head(dialect) + &body
    }

    fn head(&self, dialect: Dialect) -> String {
        let mut time = Vec::new();
        self.time.iter().for_each(|value| self.reading.time().write(value, dialect, &mut time));
        format!("SEN{} {{Type {}}}", field::blocks(time), self.reading.type_name())
    }

    /// Reads a line of either dialect. Lines of UT2004 can have several readings.
    pub(super) fn read(line: &Line) -> Option<Vec<Self>> {
        let type_name = line.get("Type")?;
        let (.., table) = TABLES.iter().find(|(known, ..)| *known == type_name)?;
        let time = match line.get("Time") {
            Some(time) => Some(time.parse().ok()?),
            None => None,
        };
        let item = table.each.first().unwrap_or(table);
        let (head, body): (Vec<_>, Vec<_>) =
            line.blocks.iter().cloned().partition(|block| matches!(block.key.as_str(), "Time" | "Type"));
        let items: Vec<_> = body.iter().map(|block| item.unmerged(block)).collect();
        let is_merged = items.iter().any(|item| item.len() > 1);
        let lines = if is_merged { items } else { vec![body] };
        let read = |body: Vec<_>| {
            let line = Line { blocks: [head.clone(), body].concat(), ..Line::default() };
            Some(Self { time, reading: Reading::read(&line)? })
        };
        lines.into_iter().map(read).collect()
    }
}
