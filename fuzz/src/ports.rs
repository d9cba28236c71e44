//! Bytes of a client of the ports beside the controllers'.

use gamebots_proto::Framing;
use gamebots_proto::ports::{
    ComAnswer, ComCommand, ComFraming, ComLink, PictureRequests, Place, PositionsQuestion, Row, TruthQuestion,
    WirelessCommand, login, read_login, rows,
};

/// Bytes that ask for truth, positions, pictures or the radio.
///
/// How the bytes are cut does not matter, places are finite, and an answer repeats no more than its question.
pub fn ports(bytes: &[u8]) {
    let mut requests = PictureRequests::default();
    let count = bytes.iter().filter_map(|&byte| requests.push(byte)).count();
    assert!(2 * count <= bytes.len(), "{count} requests for pictures in {} bytes", bytes.len());
    let lines = framed(&[bytes]);
    let (first, second) = bytes.split_at(bytes.len() / 2);
    let [mut whole, mut cut] = [ComLink::default(), ComLink::default()];
    let (passed, is_over) = whole.push(bytes);
    let (mut passed_cut, is_over_cut) = cut.push(first);
    if !is_over_cut {
        passed_cut.extend(cut.push(second).0);
    }
    assert!(passed == passed_cut && (is_over || !is_over_cut), "a link depends on how the bytes are cut");
    for command in ComFraming::default().push(bytes) {
        if let ComCommand::Register { name, .. } = ComCommand::read(&command) {
            assert!(ComAnswer::Taken(&name).text().len() <= command.len() + 100, "{command:?}");
        }
    }
    assert_eq!(framed(&[first, second]), lines, "the lines depend on how the bytes are cut");
    for line in lines {
        if let WirelessCommand::Init { ports: Some(ports), .. } = WirelessCommand::read(&line) {
            assert!(ports.len() <= 16, "{line:?}");
        }
        // A token that is sent on is read as the same one.
        if let Some(token) = read_login(&line) {
            assert_eq!(read_login(&login(&token)).as_deref(), Some(token.as_str()), "{line:?}");
        }
        let TruthQuestion { class, name } = TruthQuestion::read(&line);
        let row = Row { name: &name, class: &class, ..Row::default() };
        assert!(rows([row]).len() <= line.len() + 200, "{line:?}");
        if let Some(PositionsQuestion::Obstacles(between)) = PositionsQuestion::read(&line) {
            assert!(between.answer(-1.0).len() <= line.len() + 100, "{line:?}");
            for place in between.places() {
                assert!(!matches!(place, Place::Point(point) if point.iter().any(|it| !it.is_finite())), "{line:?}");
            }
        }
    }
}

/// Returns the lines, empty ones included.
fn framed(segments: &[&[u8]]) -> Vec<String> {
    let mut framing = Framing::with_empty_lines();
    let mut lines: Vec<_> = segments.iter().flat_map(|segment| framing.push(segment)).collect();
    lines.extend(framing.finish());
    lines.into_iter().flatten().collect()
}
