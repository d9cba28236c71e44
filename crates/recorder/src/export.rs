//! Export of logs to other formats.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use gamebots_proto::message::{Message, Sen};
use parquet::basic::Compression;
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use scene::WorldDef;

use crate::file::storage;
use crate::ros2::Ros2;
use crate::table::Table;
use crate::writer::refused;
use crate::{Log, Record, RecordError, Sensed, WireLine};

/// Writes a table as Parquet, with every column as doubles.
///
/// # Errors
/// When the file cannot be written.
pub fn parquet(table: &Table, path: &Path) -> Result<(), RecordError> {
    let write = || -> Result<(), ParquetError> {
        let fields: String = table.columns.iter().map(|column| format!("REQUIRED DOUBLE {};\n", column.name)).collect();
        let schema = parse_message_type(&format!("message states {{ {fields} }}"))?;
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        let mut file = SerializedFileWriter::new(File::create(path)?, Arc::new(schema), Arc::new(properties))?;
        let mut rows = file.next_row_group()?;
        let mut columns = table.columns.iter();
        while let (Some(mut writer), Some(column)) = (rows.next_column()?, columns.next()) {
            writer.typed::<DoubleType>().write_batch(&column.values, None, None)?;
            writer.close()?;
        }
        rows.close()?;
        file.close()?;
        Ok(())
    };
    write().map_err(|reason| refused(path, reason))
}

/// Writes a log as the messages of [`crate::ros2`] that the server would have written.
///
/// # Errors
/// When the log has no valid scene, or the file cannot be written.
pub fn ros2(log: &Log, path: &Path) -> Result<(), RecordError> {
    // The scene describes the sensors.
    let world = log.scene().map_err(|reason| refused(path, reason))?;
    let mut file = crate::ros2::begin(storage(path).map_err(|reason| refused(path, reason))?, path)?;
    let mut ros2 = Ros2::new(&world);
    let mut classes = BTreeMap::new();
    for entry in &log.entries {
        file.with(|file| ros2.write(entry.time, &entry.record, file))?;
        match &entry.record {
            Record::State(state) => drop(classes.insert(state.robot, state.class.as_str())),
            Record::Out(line) => {
                for sensed in sensed(&world, &classes, line) {
                    file.with(|file| ros2.write(entry.time, &sensed, file))?;
                }
            }
            _ => {}
        }
    }
    file.finish()
}

/// Extracts the readings from a sent line. A log has only the line, and the sensor's name instead of its number.
fn sensed(world: &WorldDef, classes: &BTreeMap<u64, &str>, line: &WireLine) -> Vec<Record> {
    let Some(robot) = line.robot.filter(|_| line.line.starts_with("SEN")) else { return Vec::new() };
    let Some(def) = classes.get(&robot).and_then(|class| world.robots.get(*class)) else { return Vec::new() };
    let sensed = |message| {
        let Message::Sen(Sen { reading, .. }) = message else { return None };
        let sensor = def.sensors.iter().position(|sensor| Some(sensor.name.as_str()) == reading.name())?;
        Some(Record::Sensed(Sensed { robot, sensor, reading }))
    };
    Message::read_all(&line.line).into_iter().filter_map(sensed).collect()
}
