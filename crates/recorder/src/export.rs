//! Export of logs to other formats.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use crate::error::refused;
use crate::file::storage;
use crate::ros2::Ros2;
use crate::table::Table;
use crate::{Log, RecordError};

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
    for entry in &log.entries {
        file.with(|file| ros2.write(entry.time, &entry.record, file))?;
    }
    file.finish()
}
