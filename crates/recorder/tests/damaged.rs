//! Logs that were damaged on purpose or by chance: the records before the damage are read, and the damage is described.

mod support;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

use mcap::records::{MessageHeader, op};
use mcap::{MAGIC, WriteOptions};
use proptest::prelude::*;
use proptest::sample::Index;
use recorder::{Log, Record, Table, export};
use support::{line, run, state, world, write};

/// The smallest log: magic, header and the metadata `run`.
fn beginning() -> Vec<u8> {
    beginning_with("map", "none")
}

fn beginning_with(key: &str, value: &str) -> Vec<u8> {
    let header = record(op::HEADER, &[text(""), text("test")].concat());
    let entries = [text(key), text(value)].concat();
    let run = record(op::METADATA, &[text("run"), sized(&entries)].concat());
    [MAGIC.to_vec(), header, run].concat()
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

fn sized(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes()[..], bytes].concat()
}

fn text(text: &str) -> Vec<u8> {
    sized(text.as_bytes())
}

/// A chunk that may lie about itself.
fn chunk(compression: &str, size: u64, checksum: u32, data: &[u8]) -> Vec<u8> {
    let head = [&[0; 16][..], &size.to_le_bytes(), &checksum.to_le_bytes()].concat();
    let body = [head, text(compression), (data.len() as u64).to_le_bytes().to_vec(), data.to_vec()].concat();
    record(op::CHUNK, &body)
}

/// Returns the start and length of every chunk of a file.
fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let summary = mcap::Summary::read(bytes).expect("an index").expect("an index");
    let place = |chunk: &mcap::records::ChunkIndex| (chunk.chunk_start_offset as usize, chunk.chunk_length as usize);
    summary.chunk_indexes.iter().map(place).collect()
}

fn in_file<T>(bytes: &[u8], use_it: impl FnOnce(&Path) -> T) -> T {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("log.mcap");
    std::fs::write(&file, bytes).expect("a file");
    use_it(&file)
}

fn read(bytes: &[u8]) -> Result<Log, String> {
    in_file(bytes, |file| recorder::read(file).map_err(|error| error.to_string()))
}

/// Returns the bytes of a log of these records.
fn log_of(records: &[(f64, Record)]) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("log.mcap");
    write(&file, &world(), records, support::end(1.0));
    std::fs::read(&file).expect("the log")
}

#[test]
fn a_log_of_a_newer_format_is_refused() {
    for (format, readable) in [("1", true), ("3", true), ("4", false), ("0", false), ("two", false), ("-1", false)] {
        let read = read(&beginning_with("format", format));
        assert_eq!(read.is_ok(), readable, "{format}: {read:?}");
        if let Err(error) = read {
            assert!(error.contains(&format!("format {format}, expected 1 to 3; a newer usarsim")), "{error}");
        }
    }
    let written = read(&log_of(&[])).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(written.run["format"], "3");
}

#[test]
fn a_log_that_says_too_much_of_itself_is_read_up_to_there() {
    let with = |bytes: Vec<u8>| [beginning(), bytes].concat();
    let length = |opcode: u8, length: u64| [&[opcode][..], &length.to_le_bytes()].concat();
    let overfull = length(op::MESSAGE, 1000);
    for (what, bytes, expected) in [
        ("nothing more", with(Vec::new()), "it is cut off at byte"),
        ("half a head", with(vec![op::MESSAGE, 22, 0]), "it is cut off"),
        ("a record of 3.9 exabytes", with(length(op::MESSAGE, 3_905_519_317_170_743_614)), "length exceeds limit"),
        ("a record of 2^64 bytes", with(length(op::METADATA, u64::MAX)), "length exceeds limit"),
        ("a record of 100 MB that is not there", with(length(op::METADATA, 100 << 20)), "it is cut off"),
        ("a text of 4 GB", with(record(op::CHANNEL, &[&[1, 0, 0, 0][..], &[255; 4]].concat())), "it is too short"),
        ("a map of 4 GB", with(record(op::METADATA, &[text("end"), vec![255; 4]].concat())), "it is too short"),
        ("a name that is no text", with(record(op::METADATA, &sized(&[0xff, 0xfe]))), "invalid utf-8"),
        ("an attachment without a checksum", with(record(op::ATTACHMENT, &[0; 32])), "it is cut off"),
        ("a record that nobody knows", with(record(0x7f, &[1, 2, 3])), "it is cut off"),
        ("a chunk without a head", with(record(op::CHUNK, &[0; 20])), "it is too short"),
        ("a chunk in an unknown compression", with(chunk("zstd", 0, 0, &[])), "`zstd`: expected lz4 or none"),
        ("a chunk of ten bytes and 200 MB", with(chunk("lz4", 200 << 20, 1, &[4; 10])), "expected at most 2550"),
        ("a chunk of 2^64 bytes", with(chunk("lz4", u64::MAX, 1, &[4; 10])), "expected at most 2550"),
        ("a chunk that is no LZ4", with(chunk("lz4", 100, 1, &[4; 100])), "LZ4"),
        ("an uncompressed chunk whose record is longer", with(chunk("", 9, 0, &overfull)), "do not fill it"),
        ("an uncompressed chunk of another size", with(chunk("", 3, 0, &record(0x7f, &[]))), "do not fill it"),
        ("an uncompressed chunk that expands", with(chunk("", 10, 0, &record(0x7f, &[]))), "expected at most 9"),
    ] {
        let said = match read(&bytes) {
            Ok(log) => log.damage.unwrap_or_default(),
            Err(error) => error,
        };
        assert!(said.contains(expected), "{what}: {said}");
        assert!(read(&bytes).is_ok_and(|log| log.run["map"] == "none"), "{what}: what comes before is there");
    }
    assert!(read(b"hello").is_err_and(|error| error.contains("not an MCAP file")));
    assert!(read(MAGIC).is_err_and(|error| error.contains("not a log of usarsim")));
}

#[test]
fn messages_that_no_run_has_end_a_log() {
    let robot = |wheels| Record::State(recorder::RobotState { joint_positions: vec![0.0; wheels], ..state(0, "P3AT") });
    for (record, expected) in [
        (Record::In(line("x".repeat(200_000))), "a line of 200000 bytes: expected at most 196608"),
        (robot(151), "a robot with 151 joints: expected at most 150"),
    ] {
        let good = (0.0, Record::Warning("before".to_owned()));
        let log = read(&log_of(&[good, (0.5, record), (0.6, Record::In(line("after")))])).expect("a log");
        assert_eq!(log.entries.len(), 1);
        let damage = log.damage.unwrap_or_default();
        assert!(damage.contains(expected), "{damage}");
    }
}

#[test]
fn a_chunk_is_used_only_when_its_checksum_is_right() {
    let whole = good().clone();
    let entries = read(&whole).expect("a log").entries;
    let mut before = Vec::new();
    for (start, length) in chunks(&whole) {
        let mut bytes = whole.clone();
        bytes[start + length - 20] ^= 1;
        let log = read(&bytes).expect("a log");
        let damage = log.damage.clone().unwrap_or_default();
        assert!(damage.starts_with(&format!("the record at byte {start}: ")), "{damage}");
        assert_eq!(log.entries, entries[..log.entries.len()]);
        before.push(log.entries.len());
    }
    // The first chunk has the drawing of the map, and the second the first records.
    assert_eq!(before[..2], [0, 0]);
    assert!(before.len() > 3 && before[1..].is_sorted_by(|a, b| a < b), "{before:?}");
    assert!(before.last() < Some(&entries.len()));
    // The checksum of the whole file covers bytes outside chunks.
    let gravity = whole.windows(7).position(|bytes| bytes == b"gravity").expect("the scene");
    let mut bytes = whole;
    bytes[gravity + 9] ^= 1;
    let log = read(&bytes).expect("a log");
    assert!(log.damage.is_some_and(|damage| damage.contains("Data section CRC failed")));
    assert_eq!(log.entries, entries);
}

#[test]
fn times_that_no_run_has_are_not_replayed() {
    let (records, end) = run();
    let bytes = log_of(&records);
    let mut good = read(&bytes).expect("a log");
    good.end.insert("seconds".to_owned(), end.time.to_string());
    good.end.insert("digest".to_owned(), format!("{:016x}", end.digest.expect("a digest")));
    let replayed = logbook::replay(&good).unwrap_or_else(|error| panic!("{error}"));
    assert!(replayed.is_same() && replayed.states > 20, "{replayed:?}");
    let last = good.entries.len() - 1;
    let half = good.entries.len() / 2;
    let without_robots = |log: &mut Log| log.entries.retain(|entry| !matches!(entry.record, Record::In(_)));
    let check = |what: &str, expected: &str, change: &dyn Fn(&mut Log)| {
        let mut log = good.clone();
        change(&mut log);
        let said = logbook::replay(&log).map_or_else(|error| error.to_string(), |replay| format!("{replay:?}"));
        assert!(said.contains(expected), "{what}: {said}");
    };
    check("a month", "expected at most 2678400", &|log| log.entries[half].time = 1e9);
    check("an hour", "expected at most 0.04 s without a record", &|log| log.entries[last].time = 3600.0);
    check("a tenth of a second", "expected at most 0.04 s", &|log| log.entries[last].time += 0.1);
    check("back", "its times go back from", &|log| log.entries[half].time = 0.0);
    check("an end before the end", "its times go back from", &|log| {
        drop(log.end.insert("seconds".into(), "0.1".into()))
    });
    check("an end long after", "expected at most 0.04 s", &|log| drop(log.end.insert("seconds".into(), "9".into())));
    check("nobody is there for a week", "expected at most 86400 s", &|log| {
        without_robots(log);
        log.entries[0].time = 7.0 * 86400.0;
    });
    check("nobody is there for a second", "first_difference", &|log| {
        without_robots(log);
        log.entries.truncate(1);
        log.end.clear();
        log.entries[0].time = 1.0;
    });
    check("a class of another log", "its class P3AT: missing field", &|log| {
        drop(log.classes.insert("P3AT".into(), "{}".into()))
    });
    check("no scene", "no `scene` in its metadata", &|log| drop(log.run.remove("scene")));
    check("a wheel like a hair", "robot P3AT, wheel", &|log| {
        let class = log.classes.get_mut("P3AT").expect("a class");
        *class = class.replace("\"radius\":0.098,", "\"radius\":0.000098,");
    });
    for (key, value) in [("speed_unit", "inf"), ("speed_unit", "1e300"), ("speed_unit", "NaN"), ("time_step", "1e-9")] {
        check(key, "expected 0.", &|log| drop(log.run.insert(key.into(), value.into())));
    }
}

/// The log of [`run`].
fn good() -> &'static Vec<u8> {
    static LOG: OnceLock<Vec<u8>> = OnceLock::new();
    LOG.get_or_init(|| {
        let (folder, (records, end)) = (tempfile::tempdir().expect("a folder"), run());
        let file = folder.path().join("log.mcap");
        write(&file, &world(), &records, end);
        std::fs::read(&file).expect("the log")
    })
}

/// Checks that every reader of logs comes to an end, whatever is in a file: with an error, or with the part that could be
/// saved.
fn comes_to_an_end(bytes: &[u8]) {
    in_file(bytes, |file| {
        let (copy, ros2) = (file.with_extension("copy"), file.with_extension("ros2"));
        let recovered = recorder::recover(file, &copy);
        let Ok(log) = recorder::read(file) else { return };
        // The recovered file has the same content.
        let recovered = recovered.unwrap_or_else(|error| panic!("{error}"));
        let again = recorder::read(&copy).unwrap_or_else(|error| panic!("{error}"));
        // Compared as text, in which NaN equals itself.
        let text = |log: &Log| format!("{:?} {:?} {:?}", log.run, log.end, log.entries);
        assert!(text(&again) == text(&log), "{:?} but {:?}", again.damage, log.damage);
        assert!(recovered.messages >= log.entries.len() as u64 / 2, "{recovered:?}");
        assert!(log.entries.iter().all(|entry| entry.time.is_finite()));
        let _ = logbook::replay(&log);
        let table = Table::of(&log, None);
        assert_eq!((table.to_csv().count(), table.to_tum().count()), (table.rows() + 1, table.rows()));
        let _ = export::ros2(&log, &ros2);
        export::parquet(&table, &file.with_extension("parquet")).unwrap_or_else(|error| panic!("{error}"));
    });
}

/// Random damage to the bytes of a file.
#[derive(Debug, Clone)]
enum Harm {
    Flip(Index, u8),
    Cut(Index),
    Repeat(Index, Index, usize),
    Remove(Index, usize),
    Insert(Index, u8, u64, Vec<u8>),
}

fn harm() -> impl Strategy<Value = Harm> {
    let length = prop_oneof![0..100_u64, any::<u64>(), Just(u64::MAX)];
    let bytes = proptest::collection::vec(any::<u8>(), 0..60);
    prop_oneof![
        4 => (any::<Index>(), 0..8_u8).prop_map(|(at, bit)| Harm::Flip(at, bit)),
        1 => any::<Index>().prop_map(Harm::Cut),
        2 => (any::<Index>(), any::<Index>(), 1..3000_usize).prop_map(|(from, to, count)| Harm::Repeat(from, to, count)),
        1 => (any::<Index>(), 1..3000_usize).prop_map(|(at, count)| Harm::Remove(at, count)),
        2 => (any::<Index>(), 0..17_u8, length, bytes).prop_map(|(at, opcode, length, bytes)| Harm::Insert(at, opcode, length, bytes)),
    ]
}

fn harmed(mut bytes: Vec<u8>, harm: &Harm) -> Vec<u8> {
    let count = bytes.len().max(1);
    match harm {
        Harm::Flip(at, bit) => bytes.get_mut(at.index(count)).into_iter().for_each(|byte| *byte ^= 1 << bit),
        Harm::Cut(at) => bytes.truncate(at.index(count)),
        Harm::Repeat(from, to, length) => {
            let from = from.index(count);
            let part = bytes.iter().skip(from).take(*length).copied().collect::<Vec<_>>();
            let to = to.index(count).min(bytes.len());
            bytes.splice(to..to, part);
        }
        Harm::Remove(at, length) => {
            let at = at.index(count).min(bytes.len());
            bytes.drain(at..(at + length).min(bytes.len()));
        }
        Harm::Insert(at, opcode, length, body) => {
            let at = at.index(count).min(bytes.len());
            let inserted = [&[*opcode][..], &length.to_le_bytes(), body].concat();
            bytes.splice(at..at, inserted);
        }
    }
    bytes
}

/// A message in a file: topic, time in nanoseconds, bytes.
type Message = (String, u64, Vec<u8>);

/// Returns the messages of the good log, and its metadata.
fn parts() -> (Vec<Message>, BTreeMap<String, BTreeMap<String, String>>) {
    let messages = mcap::MessageStream::new(good()).expect("messages").map(|message| {
        let message = message.expect("a message");
        (message.channel.topic.clone(), message.log_time, message.data.into_owned())
    });
    let Log { run, end, .. } = read(good()).expect("a log");
    (messages.collect(), [("run".to_owned(), run), ("end".to_owned(), end)].into())
}

/// Returns a file of these messages and metadata, with every checksum right.
fn joined(messages: &[Message], metadata: &BTreeMap<String, BTreeMap<String, String>>) -> Vec<u8> {
    let options = WriteOptions::new().compression(Some(mcap::Compression::Lz4));
    let mut writer = options.create(std::io::Cursor::new(Vec::new())).expect("a writer");
    let mut put = |name: &str| {
        let metadata = metadata[name].clone();
        let metadata = mcap::records::Metadata { name: name.to_owned(), metadata };
        writer.write_metadata(&metadata).expect("metadata");
        for (topic, time, data) in messages.iter().filter(|_| name == "run") {
            let channel_id = writer.add_channel(0, topic, "protobuf", &BTreeMap::new()).expect("a channel");
            let header = MessageHeader { channel_id, sequence: 0, log_time: *time, publish_time: *time };
            writer.write_to_known_channel(&header, data).expect("a message");
        }
    };
    ["run", "end"].into_iter().for_each(&mut put);
    writer.finish().expect("a file");
    writer.into_inner().into_inner()
}

/// A false statement in a log, with right checksums.
#[derive(Debug, Clone)]
enum Lie {
    Byte(Index, Index, u8),
    Text(Index, Vec<u8>),
    Time(Index, u64),
    Shift(Index, i64),
    Drop(Index),
    Repeat(Index, Index),
    Metadata(usize, String),
    Scene(Index, char),
}

/// The metadata that replay reads, except the scene.
const KEYS: [(&str, &str); 6] = [
    ("run", "seed"),
    ("run", "time_step"),
    ("run", "speed_unit"),
    ("end", "seconds"),
    ("end", "digest"),
    ("end", "dropped"),
];

fn lie() -> impl Strategy<Value = Lie> {
    let number = any::<f64>().prop_map(|number| number.to_string());
    let value = prop_oneof![number, "[0-9eE.+-]{0,6}", Just("inf".to_owned()), Just(String::new())];
    let seconds = -5_000_000_000..5_000_000_000_i64;
    // Wrong times are far off, because simulating a day of an empty world would show nothing.
    let time = prop_oneof![Just(0), Just(u64::MAX), 10_000_000_000_000_000..u64::MAX];
    prop_oneof![
        4 => (any::<Index>(), any::<Index>(), 0..8_u8).prop_map(|(message, at, bit)| Lie::Byte(message, at, bit)),
        1 => (any::<Index>(), proptest::collection::vec(any::<u8>(), 0..40)).prop_map(|(message, bytes)| Lie::Text(message, bytes)),
        1 => (any::<Index>(), time).prop_map(|(message, time)| Lie::Time(message, time)),
        1 => (any::<Index>(), seconds).prop_map(|(message, shift)| Lie::Shift(message, shift)),
        1 => any::<Index>().prop_map(Lie::Drop),
        1 => (any::<Index>(), any::<Index>()).prop_map(|(message, at)| Lie::Repeat(message, at)),
        1 => (0..KEYS.len(), value).prop_map(|(key, value)| Lie::Metadata(key, value)),
        1 => (any::<Index>(), "[0-9.e-]").prop_map(|(at, text)| Lie::Scene(at, text.chars().next().unwrap_or('0'))),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_file_that_chance_has_changed_is_read_or_refused(harms in proptest::collection::vec(harm(), 1..4)) {
        comes_to_an_end(&harms.iter().fold(good().clone(), harmed));
    }

    #[test]
    fn a_log_that_lies_is_read_or_refused(lies in proptest::collection::vec(lie(), 1..4)) {
        let (mut messages, mut metadata) = parts();
        for lie in &lies {
            let count = messages.len();
            match lie {
                Lie::Byte(message, at, bit) => {
                    let data = &mut messages[message.index(count)].2;
                    let length = data.len().max(1);
                    data.get_mut(at.index(length)).into_iter().for_each(|byte| *byte ^= 1 << bit);
                }
                Lie::Text(message, bytes) => messages[message.index(count)].2.clone_from(bytes),
                Lie::Time(message, time) => messages[message.index(count)].1 = *time,
                Lie::Shift(message, shift) => {
                    let time = &mut messages[message.index(count)].1;
                    *time = time.saturating_add_signed(*shift);
                }
                Lie::Drop(message) => drop(messages.remove(message.index(count))),
                Lie::Repeat(message, at) => {
                    let message = messages[message.index(count)].clone();
                    messages.insert(at.index(count), message);
                }
                Lie::Scene(at, with) => {
                    let scene = metadata.get_mut("run").and_then(|run| run.get_mut("scene")).expect("a scene");
                    // Changes a digit of a number.
                    let digits: Vec<usize> = scene.match_indices(|c: char| c.is_ascii_digit()).map(|(at, _)| at).collect();
                    let at = digits[at.index(digits.len())];
                    scene.replace_range(at..=at, &with.to_string());
                }
                Lie::Metadata(key, value) => {
                    let (name, key) = KEYS[*key];
                    metadata.entry(name.to_owned()).or_default().insert(key.to_owned(), value.clone());
                }
            }
        }
        comes_to_an_end(&joined(&messages, &metadata));
    }
}
