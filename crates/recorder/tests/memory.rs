//! A small file must not fill the memory. This test has its own process, because it measures the peak memory of the process.

mod support;

use std::collections::BTreeMap;
use std::path::Path;

use mcap::WriteOptions;
use mcap::records::MessageHeader;
use prost::Message;
use recorder::Table;

/// Returns the peak memory of this process, bytes, as Linux reports it; elsewhere it is unknown.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

/// Writes a log of one message, repeated.
fn repeated(path: &Path, topic: &str, message: &[u8], count: u32) {
    let file = std::io::BufWriter::new(std::fs::File::create(path).expect("a file"));
    let options = WriteOptions::new().compression(Some(mcap::Compression::Lz4)).emit_message_indexes(false);
    let mut writer = options.create(file).expect("a writer");
    let channel_id = writer.add_channel(0, topic, "protobuf", &BTreeMap::new()).expect("a channel");
    for _ in 0..count {
        let header = MessageHeader { channel_id, sequence: 0, log_time: 0, publish_time: 0 };
        writer.write_to_known_channel(&header, message).expect("a message");
    }
    writer.finish().expect("a file");
}

#[test]
fn a_file_that_expands_without_end_takes_a_bounded_part_of_the_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("log.mcap");
    let Some(before) = peak() else { return };
    let line = support::line("x".repeat(1 << 20)).encode_to_vec();
    let wide = recorder::RobotState { joint_positions: vec![0.0; 100], ..support::state(0, "P3AT") }.encode_to_vec();
    for (topic, message, count) in
        [("/wire/out", &line[..], 600), ("/robot/0/state", &[], 400_000), ("/robot/0/state", &wide, 400_000)]
    {
        repeated(&file, topic, message, count);
        let size = file.metadata().expect("a file").len();
        let log = recorder::read(&file).unwrap_or_else(|error| panic!("{error}"));
        let damage = log.damage.clone().unwrap_or_default();
        assert!(damage.contains("more than 32 times the memory"), "{topic}, {size} bytes: {damage}");
        assert!(!log.entries.is_empty());
        let rows = Table::of(&log, None).rows();
        assert_eq!(rows, if topic == "/wire/out" { 0 } else { log.entries.len() });
        let copy = folder.path().join("copy.mcap");
        let recovered = recorder::recover(&file, &copy).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(recovered.messages, u64::from(count));
        std::fs::remove_file(&copy).expect("a copy");
        let more = peak().unwrap_or(0).saturating_sub(before) >> 20;
        assert!(more < 400, "{topic}: {size} bytes took {more} MiB");
        println!("{topic}: {size} bytes took {more} MiB so far");
    }
}
