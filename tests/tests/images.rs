//! The image server: requests, pictures, many clients and slow ones.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use gamebots_proto::Dialect;
use gamebots_server::{ImageKind, Listener, Service};
use system_tests::{PATIENCE, Peer, Server, wait_until};

/// Pixels of the sky on a map, far above the ground: light, and bluer than red.
const SKY: [u8; 2] = [120, 60];

fn server(kind: ImageKind) -> Server {
    Server::start("hall", &[], |config| {
        config.listeners.push(Listener::new(Service::Images, 0));
        config.image_kind = kind;
    })
}

fn connect(server: &Server) -> TcpStream {
    let stream = TcpStream::connect(server.images.expect("a port")).expect("a connection");
    stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    stream
}

/// Reads a picture: its kind and its bytes.
fn read(stream: &mut TcpStream) -> (u8, Vec<u8>) {
    let mut head = [0; 5];
    stream.read_exact(&mut head).expect("a head");
    let mut bytes = vec![0; u32::from_be_bytes([head[1], head[2], head[3], head[4]]) as usize];
    stream.read_exact(&mut bytes).expect("a picture");
    (head[0], bytes)
}

/// Reads raw pixels: width, height and rows of blue, green and red.
fn read_raw(stream: &mut TcpStream) -> ([usize; 2], Vec<u8>) {
    let (kind, bytes) = read(stream);
    assert_eq!(kind, 0);
    let size = [0, 2].map(|at| usize::from(u16::from_be_bytes([bytes[at], bytes[at + 1]])));
    assert_eq!(bytes.len(), 4 + size[1] * (3 * size[0]).next_multiple_of(4));
    (size, bytes[4..].to_vec())
}

fn robot(server: &Server, place: &str) -> Peer {
    let mut peer = server.client();
    peer.send(&format!("INIT {{ClassName USARBot.P3AT}} {{Location {place}}}"));
    peer.ground_truth();
    peer
}

fn part(numbers: [u32; 4]) -> Vec<u8> {
    [&b"U"[..], &numbers.map(u32::to_be_bytes).concat()].concat()
}

/// Cases 116 and 118.
#[test]
fn a_picture_comes_for_each_ok_and_none_before() {
    let server = server(ImageKind::Raw);
    let _robot = robot(&server, "0,0,0");
    let mut client = connect(&server);
    client.set_read_timeout(Some(Duration::from_millis(300))).expect("a timeout");
    assert!(client.read(&mut [0]).is_err(), "nothing comes unasked");
    client.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    client.write_all(b"xyOK").expect("to send");
    let (size, pixels) = read_raw(&mut client);
    assert_eq!(size, [640, 480]);
    let at = |x: usize, y: usize| &pixels[3 * (640 * y + x)..][..3];
    assert!(at(160, 10)[0] > SKY[0] && at(160, 10)[2] > SKY[1], "the camera's sky or wall: {:?}", at(160, 10));
    assert_eq!(at(400, 100), [0, 0, 0], "no second camera");
    client.set_read_timeout(Some(Duration::from_millis(300))).expect("a timeout");
    assert!(client.read(&mut [0]).is_err(), "one picture for one request");
}

/// UvA's clients send OK after each picture and none before the first.
#[test]
fn in_legacy_mode_the_first_picture_comes_unasked() {
    let server = Server::start("hall", &[], |config| {
        config.listeners.push(Listener::new(Service::Images, 0));
        config.image_legacy = true;
    });
    let _robot = robot(&server, "0,0,0");
    let mut client = connect(&server);
    for _ in 0..2 {
        assert_eq!(read_raw(&mut client).0, [640, 480]);
        client.write_all(b"OK").expect("to send");
    }
    read_raw(&mut client);
    client.set_read_timeout(Some(Duration::from_millis(300))).expect("a timeout");
    assert!(client.read(&mut [0]).is_err(), "one unasked picture alone");
}

/// Case 117, and the six writes of the ardrone's look-alike.
#[test]
fn a_part_of_the_picture_comes_for_its_numbers_however_they_are_cut() {
    let server = server(ImageKind::Raw);
    let _robot = robot(&server, "0,0,0");
    let mut client = connect(&server);
    client.set_nodelay(true).expect("to send at once");
    client.write_all(&part([0, 0, 320, 240])).expect("to send");
    let (kind, bytes) = read(&mut client);
    assert_eq!((kind, bytes.len()), (0, 4 + 240 * 960));
    assert_eq!(bytes[..4], [1, 0x40, 0, 0xf0]);
    for piece in [&b"U"[..], &[0; 4], &[0; 4], &[0, 0, 1, 0x40], &[0, 0, 0, 0xf0], b"\r\n"] {
        client.write_all(piece).expect("to send");
    }
    assert_eq!(read_raw(&mut client).0, [320, 240]);
    client.write_all(&part([u32::MAX, 0, 5, 5])).expect("to send");
    assert_eq!(read_raw(&mut client).0, [0, 0]);
}

/// Robots come and go, and their cameras tell their tiles.
#[test]
fn cameras_take_free_tiles_and_say_which() {
    let server = server(ImageKind::Raw);
    let mut robots: Vec<Peer> = (0..5).map(|number| robot(&server, &format!("0,{number},0"))).collect();
    let mut offset = |peer: &mut Peer| {
        peer.send("GETCONF {Type Camera}");
        let conf = peer.wait_for("CONF", |line| line.starts_with("CONF {Type Camera}"));
        let number = |key: &str| {
            let (_, rest) = conf.split_once(key).expect("a key");
            rest.split('}').next().expect("a number").trim().parse::<usize>().expect("a number")
        };
        [number("{TextureOffsetX "), number("{TextureOffsetY ")]
    };
    let offsets: Vec<_> = robots.iter_mut().map(&mut offset).collect();
    assert_eq!(offsets, [[0, 0], [320, 0], [0, 240], [320, 240], [0, 0]]);
    let mut client = connect(&server);
    let tiles = |client: &mut TcpStream| {
        client.write_all(b"OK").expect("to send");
        let (_, pixels) = read_raw(client);
        let is_drawn = |[x, y]: [usize; 2]| pixels[3 * (640 * (y + 5) + x + 5)..][..3] != [0, 0, 0];
        [[0, 0], [320, 0], [0, 240], [320, 240]].map(is_drawn)
    };
    wait_until(|| tiles(&mut client) == [true; 4]);
    robots.remove(1);
    wait_until(|| tiles(&mut client) == [true, false, true, true]);
    let mut next = robot(&server, "3,0,0");
    assert_eq!(offset(&mut next), [320, 0]);
    wait_until(|| tiles(&mut client) == [true; 4]);
}

#[test]
fn a_robot_chooses_among_its_cameras_and_leaves_those_of_others_alone() {
    let server = server(ImageKind::Raw);
    let mut stereo = server.client();
    stereo.dialect = Dialect::Ut2004;
    stereo.send("INIT {ClassName USARBot.StereoP2AT} {Name S} {Location 0,0,0}");
    let mut offset = |name: &str, set: &str| {
        stereo.send(set);
        stereo.send(&format!("GETCONF {{Type Camera}} {{Name {name}}}"));
        let is_conf = |line: &str| line.starts_with("CONF {Type Camera}") && line.contains(name);
        let conf = stereo.wait_for("CONF", is_conf);
        let number = |key: &str| conf.split_once(key).and_then(|(_, rest)| rest.split('}').next()?.trim().parse().ok());
        [number("{TextureOffsetX "), number("{TextureOffsetY ")].map(|it: Option<u32>| it.expect("a number"))
    };
    assert_eq!(offset("LeftCamera", "GETCLASSES"), [0, 0]);
    assert_eq!(offset("RightCamera", "GETCLASSES"), [320, 0]);
    let both = "SET {Type Viewports} {Config QuadView} {Viewport1 RightCamera} {Viewport4 LeftCamera}";
    assert_eq!(offset("RightCamera", both), [0, 0]);
    assert_eq!(offset("LeftCamera", "GETCLASSES"), [320, 240]);
    // The other robot's camera takes the second tile, and keeps it.
    let other = robot(&server, "0,3,0");
    let taken = "SET {Type Viewports} {Viewport3 LeftCamera} {Viewport2 RightCamera}";
    assert_eq!(offset("LeftCamera", taken), [320, 240]);
    assert_eq!(offset("LeftCamera", "SET {Type Viewports} {Viewport3 LeftCamera} {Viewport1 Nothing}"), [320, 240]);
    drop(other);
    let single = "SET {Type Viewports} {Config SingleView} {Viewport1 LeftCamera}";
    assert_eq!(offset("LeftCamera", single), [0, 0]);
    let mut client = connect(&server);
    // Each pixel is there twice in both directions.
    let is_double = |client: &mut TcpStream| {
        client.write_all(b"OK").expect("to send");
        let (_, pixels) = read_raw(client);
        let row = |y: usize| &pixels[3 * 640 * y..][..3 * 640];
        let is_drawn = row(100) != vec![0; 3 * 640];
        let is_twice = |y: usize| row(y) == row(y + 1) && row(y).chunks(6).all(|pair| pair[..3] == pair[3..]);
        is_drawn && (0..480).step_by(2).all(is_twice)
    };
    wait_until(|| is_double(&mut client));
    let _other = robot(&server, "0,3,0");
    wait_until(|| !is_double(&mut client));
}

#[test]
fn a_jpeg_is_small_enough_for_the_clients_of_the_league() {
    let server = server(ImageKind::Good);
    let _robots: Vec<Peer> = (0..4).map(|number| robot(&server, &format!("0,{number},0"))).collect();
    let mut client = connect(&server);
    for _ in 0..10 {
        client.write_all(b"OK").expect("to send");
        let (kind, bytes) = read(&mut client);
        assert_eq!(kind, 2);
        assert!(bytes.len() < 250_000, "{} bytes", bytes.len());
        assert_eq!((&bytes[..2], &bytes[bytes.len() - 2..]), (&[0xff, 0xd8][..], &[0xff, 0xd9][..]));
    }
}

#[test]
fn without_cameras_the_picture_is_black() {
    let server = server(ImageKind::Raw);
    let mut client = connect(&server);
    client.write_all(b"OK").expect("to send");
    let (size, pixels) = read_raw(&mut client);
    assert_eq!(size, [640, 480]);
    assert!(pixels.iter().all(|&byte| byte == 0));
}

/// Clients ask without pause, one reads nothing and one speaks HTTP. A robot's client loses no line.
#[test]
fn greedy_and_stalled_clients_hold_up_nobody() {
    let server = server(ImageKind::Raw);
    let mut bystander = server.bystander();
    let _robot = robot(&server, "0,0,0");
    let mut stalled = connect(&server);
    stalled.write_all(&b"OK".repeat(5000)).expect("to send");
    let mut page = connect(&server);
    page.write_all(b"GET /OK HTTP/1.1\r\n\r\n").expect("to send");
    let mut text = Vec::new();
    let _ = page.read_to_end(&mut text);
    assert_eq!(text, b"");
    let mut greedy: Vec<TcpStream> = (0..5).map(|_| connect(&server)).collect();
    greedy.iter_mut().for_each(|client| client.write_all(&b"OK".repeat(8)).expect("to send"));
    let start = Instant::now();
    for _ in 0..8 {
        for client in &mut greedy {
            assert_eq!(read_raw(client).0, [640, 480]);
        }
    }
    assert!(start.elapsed() > Duration::from_millis(300), "a client that asks without pause waits for new pictures");
    bystander.check_undisturbed();
    drop(stalled);
}
