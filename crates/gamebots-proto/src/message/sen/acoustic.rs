//! `{Name n} {None}`, or per sound `{Far}` or `{Direction x,y,z} {Volume v} {Duration d} {Delay t}` (AcousticArraySensor.uc:62-162).

use super::Body;
use crate::field::{Field, Format, Record, Table, Written, record};
use crate::{Dialect, Line};

record! {
    /// A sound that was heard.
    Heard {
        /// Direction of the source in the frame of the sensor, of length 1, with z up.
        direction: [f32; 3] = Field::new("Direction", Format::Rounded(2)),
        /// Loudness at the sensor.
        volume: f32 = Field::new("Volume", Format::Rounded(4)).unit("dB"),
        /// Length of the sound.
        duration: f32 = Field::new("Duration", Format::Rounded(4)).unit("s"),
        /// Time until the sound reaches the sensor.
        delay: f32 = Field::new("Delay", Format::Rounded(4)).unit("s"),
    }
}

/// Sounds since the last reading.
#[derive(Debug, Clone, PartialEq)]
pub struct Acoustic {
    /// Name of the sensor.
    pub name: String,
    /// Sounds in the order of their sources. One that is too far to be heard is `None`.
    pub sounds: Vec<Option<Heard>>,
}

/// Key of the name.
const NAME: Field = Field::new("Name", Format::Word);

impl Record for Acoustic {
    const TABLE: Table = Table {
        name: "Acoustic",
        about: " Sounds since the last reading: `{None}`, or for each `{Far}` or the following blocks.",
        fields: &[NAME.about(" Name of the sensor.")],
        each: &[Heard::TABLE],
    };

    fn write(&self, dialect: Dialect) -> Vec<Written> {
        let mut blocks = Vec::new();
        NAME.write(&self.name, dialect, &mut blocks);
        for sound in &self.sounds {
            match sound {
                Some(sound) => blocks.extend(sound.write(dialect)),
                None => blocks.push(Written::new("", "Far")),
            }
        }
        if self.sounds.is_empty() {
            blocks.push(Written::new("", "None"));
        }
        blocks
    }

    fn read(line: &Line) -> Option<Self> {
        let begins = |key: &str| key == "Direction" || key == "Far";
        let runs = line.blocks.chunk_by(|_, next| !begins(&next.key));
        let runs = runs.filter(|run| run.first().is_some_and(|block| begins(&block.key)));
        let sound = |blocks: &[crate::Block]| match blocks {
            [block, ..] if block.key == "Far" => Some(None),
            _ => Heard::read(&Line { blocks: blocks.to_vec(), ..Line::default() }).map(Some),
        };
        Some(Self { name: NAME.read(line)?, sounds: runs.map(sound).collect::<Option<_>>()? })
    }
}

impl Body for Acoustic {
    const TYPE: &'static str = "Acoustic";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Rounded(4)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
