//! Outcomes as a Parquet table, a row a run, and back.
//!
//! Columns: `run`, `seed`, `main`, `error` (m) and `yaw` (rad) after the last step, `wheels_turned` (rad), `seconds`, `digest`, then the
//! labels of the runs by name. `steps` and `labels` are JSON, from which outcomes are read back with every bit.

use std::sync::Arc;

use parquet::basic::Compression;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::record::RowAccessor;
use parquet::schema::parser::parse_message_type;

use crate::plot::Quantity;
use crate::run::Outcome;

/// Columns that every table has, with their types.
const COLUMNS: [(&str, Kind); 10] = [
    ("run", Kind::Text),
    ("seed", Kind::Whole),
    ("main", Kind::Number),
    ("error", Kind::Number),
    ("yaw", Kind::Number),
    ("wheels_turned", Kind::Number),
    ("seconds", Kind::Number),
    ("digest", Kind::Text),
    ("steps", Kind::Text),
    ("labels", Kind::Text),
];

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Text,
    Whole,
    Number,
}

/// Writes outcomes as a Parquet file.
pub(super) fn to_parquet(outcomes: &[Outcome]) -> Result<Vec<u8>, ParquetError> {
    let labels: Vec<&str> = outcomes.first().map_or_else(Vec::new, |first| {
        // A label that is called as a column keeps only its place in `labels`.
        let names = first.labels.iter().map(|(name, _)| name.as_str());
        names.filter(|name| is_plain(name) && !COLUMNS.iter().any(|(known, _)| known == name)).collect()
    });
    let columns = COLUMNS.into_iter().chain(labels.iter().map(|label| (*label, Kind::Text)));
    let fields = columns.clone().map(|(name, kind)| match kind {
        Kind::Text => format!("REQUIRED BYTE_ARRAY {name} (UTF8);\n"),
        Kind::Whole => format!("REQUIRED INT64 {name};\n"),
        Kind::Number => format!("REQUIRED DOUBLE {name};\n"),
    });
    let schema = parse_message_type(&format!("message runs {{ {} }}", fields.collect::<String>()))?;
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut bytes = Vec::new();
    let mut file = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
    let mut rows = file.next_row_group()?;
    for (name, kind) in columns {
        let Some(mut writer) = rows.next_column()? else { break };
        match kind {
            Kind::Text => {
                let texts: Vec<ByteArray> =
                    outcomes.iter().map(|outcome| ByteArray::from(text(outcome, name).into_bytes())).collect();
                writer.typed::<ByteArrayType>().write_batch(&texts, None, None)?;
            }
            Kind::Whole => {
                let seeds: Vec<i64> = outcomes.iter().map(|outcome| outcome.seed.cast_signed()).collect();
                writer.typed::<Int64Type>().write_batch(&seeds, None, None)?;
            }
            Kind::Number => {
                let numbers: Vec<f64> = outcomes.iter().map(|outcome| number(outcome, name)).collect();
                writer.typed::<DoubleType>().write_batch(&numbers, None, None)?;
            }
        }
        writer.close()?;
    }
    rows.close()?;
    file.close()?;
    Ok(bytes)
}

/// Reads outcomes from a Parquet file of [`to_parquet`].
pub(super) fn from_parquet(bytes: Vec<u8>) -> Result<Vec<Outcome>, String> {
    let said = |error: ParquetError| error.to_string();
    let file = SerializedFileReader::new(bytes::Bytes::from(bytes)).map_err(said)?;
    let mut outcomes = Vec::new();
    for row in file.get_row_iter(None).map_err(said)? {
        let row = row.map_err(said)?;
        let text = |column: usize| row.get_string(column).map_err(said);
        let number = |column: usize| row.get_double(column).map_err(said);
        let json = |error: serde_json::Error| error.to_string();
        outcomes.push(Outcome {
            id: text(0)?.clone(),
            seed: row.get_long(1).map_err(said)?.cast_unsigned(),
            wheels_turned: number(5)?,
            seconds: number(6)?,
            digest: text(7)?.clone(),
            steps: serde_json::from_str(text(8)?).map_err(json)?,
            labels: serde_json::from_str(text(9)?).map_err(json)?,
        });
    }
    Ok(outcomes)
}

fn text(outcome: &Outcome, column: &str) -> String {
    match column {
        "run" => outcome.id.clone(),
        "digest" => outcome.digest.clone(),
        "steps" => serde_json::to_string(&outcome.steps).unwrap_or_default(),
        "labels" => serde_json::to_string(&outcome.labels).unwrap_or_default(),
        label => outcome.label(label).unwrap_or_default().to_owned(),
    }
}

fn number(outcome: &Outcome, column: &str) -> f64 {
    match column {
        "main" => Quantity::Main.of(outcome, usize::MAX),
        "error" => Quantity::Error.of(outcome, usize::MAX),
        "yaw" => Quantity::Yaw.of(outcome, usize::MAX),
        "wheels_turned" => outcome.wheels_turned,
        _ => outcome.seconds,
    }
}

/// True if a name can be a column: letters, digits and underscores, not a digit first.
fn is_plain(name: &str) -> bool {
    let is_good = |c: char| c.is_ascii_alphanumeric() || c == '_';
    name.chars().all(is_good) && name.chars().next().is_some_and(|first| !first.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Step;

    #[test]
    fn outcomes_read_back_with_every_bit() {
        let outcome = |number: u64| Outcome {
            id: format!("plan/a-{number}"),
            labels: [("floor", "a"), ("two words", "x"), ("main", "y"), ("sample", "1")]
                .map(|(name, value)| (name.to_owned(), value.to_owned()))
                .to_vec(),
            seed: u64::MAX - number,
            steps: vec![Step { main: 0.1 + 0.2, error: -1e-300, yaw: 1.0 / 3.0 }; number as usize],
            wheels_turned: number as f64 / 7.0,
            digest: "00ff".to_owned(),
            seconds: 1e9 / 3.0,
        };
        let all: Vec<Outcome> = (0..5).map(outcome).collect();
        let bytes = to_parquet(&all).expect("a table");
        assert_eq!(bytes, to_parquet(&all).expect("a table"), "the same bytes");
        assert_eq!(from_parquet(bytes.clone()), Ok(all));
        for cut in [0, 1, 20, bytes.len() / 2, bytes.len() - 1] {
            assert!(from_parquet(bytes[..cut].to_vec()).is_err(), "{cut}");
        }
    }
}
