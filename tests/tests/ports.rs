//! The ports beside the controllers': bytes, strangers and slow clients.

use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};

use gamebots_server::{IfTaken, Listener, Service};
use system_tests::{PATIENCE, Server};

const SERVICES: [Service; 3] = [Service::Controllers { dialect: None }, Service::Truth, Service::Positions];

fn server(map: &str) -> Server {
    Server::start(map, &[], |config| config.listeners = SERVICES.map(|service| Listener::new(service, 0)).into())
}

fn connect(address: Option<SocketAddr>) -> TcpStream {
    let stream = TcpStream::connect(address.expect("a port")).expect("a connection");
    stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    stream
}

/// Sends bytes and returns all that comes until the server closes.
fn ask(address: Option<SocketAddr>, bytes: &[u8]) -> String {
    let mut stream = connect(address);
    stream.write_all(bytes).expect("to send");
    stream.shutdown(Shutdown::Write).expect("to end");
    let mut text = String::new();
    stream.read_to_string(&mut text).expect("text");
    text
}

#[test]
fn answers_have_the_bytes_of_usarsim() {
    let server = server("rough");
    let rows: [(_, &[u8], &str); 8] = [
        (server.truth, b"\r\n", "{End}\r\n"),
        (server.truth, b"", ""),
        (server.truth, b"{class No.Such}", "{End}\r\n"),
        (server.truth, b"\xff\xfe{cl\0ass\n", "{End}\r\n"),
        (server.positions, b"GETOBS\r\n", "\r\n"),
        (server.positions, b"GETPOS\n\nDRIVE\n", "POSITIONS {Robots 0}\r\n"),
        (
            server.positions,
            b"GETOBS {Start nan,1e99,x} {End -1e300,inf,0}\n",
            "NUMOBS {Start nan,1e99,x} {End -1e300,inf,0} {ObstCount 0.0000}\r\n",
        ),
        (server.positions, b"GETPOS", "POSITIONS {Robots 0}\r\n"),
    ];
    for (address, bytes, expected) in rows {
        assert_eq!(ask(address, bytes), expected, "{}", String::from_utf8_lossy(bytes));
    }
}

/// MetricTool reads as many bytes as are there at the first one, again and again, until fewer come. Otherwise it waits for 4 s.
#[test]
fn the_end_of_truth_comes_apart_from_its_rows_and_is_shorter() {
    let server = server("rescue");
    let mut client = connect(server.truth);
    client.set_read_timeout(Some(std::time::Duration::from_millis(500))).expect("a timeout");
    let mut apart = 0;
    for _ in 0..20 {
        client.write_all(b"\r\n").expect("to send");
        let mut buffer = vec![0; 64 * 1024];
        let count = client.read(&mut buffer).expect("rows");
        if buffer[..count].ends_with(b"{End}\r\n") {
            // This machine was too busy to read the rows in time.
            continue;
        }
        let rest = client.read(&mut buffer[..count]).expect("the end");
        assert!(rest < count, "{rest} after {count}");
        apart += 1;
    }
    assert!(apart > 0, "rows and end always come together");
}

/// Score boards look for them.
#[test]
fn truth_has_the_victims_of_a_map() {
    let server = server("rescue");
    let text = ask(server.truth, b"{class USARVictim.MaleVictim}\r\n");
    let victims = server_victims();
    assert_eq!(text.lines().filter(|line| line.contains("{Class MaleVictim}")).count(), victims, "{text}");
    assert!(victims > 3);
    assert!(ask(server.truth, b"{Actors}\r\n").contains("{Name MaleVictim_0} {Class MaleVictim} {Time "));
}

fn server_victims() -> usize {
    scene_loader::load("rescue", &[]).expect("a map").map.victims.len()
}

/// MetricTool reads what is there at the first byte.
#[test]
fn the_rows_of_truth_leave_in_one_piece() {
    let server = server("rough");
    let mut controller = server.client();
    controller.send("INIT {ClassName USARBotAPI.WorldController}");
    for number in 0..100 {
        let place = format!("{},{},-0.25", number % 10, number / 10);
        controller
            .send(&format!("CONTROL {{Type Create}} {{ClassName WCCrate}} {{Name box{number}}} {{Location {place}}}"));
    }
    controller.send("CONTROL {Type GetSTA}");
    assert!(controller.reply().contains("{Name box99}"));
    let mut truth = connect(server.truth);
    let mut buffer = vec![0; 64 * 1024];
    for _ in 0..20 {
        truth.write_all(b"{class WCObject}\r\n").expect("to send");
        let count = truth.read(&mut buffer).expect("an answer");
        let mut text = String::from_utf8_lossy(&buffer[..count]).into_owned();
        assert!(text.matches("{Name box").count() == 100 && text.ends_with("\r\n"), "{count} bytes");
        while !text.ends_with("{End}\r\n") {
            let count = truth.read(&mut buffer).expect("the end");
            text.push_str(&String::from_utf8_lossy(&buffer[..count]));
        }
        assert_eq!(text.lines().count(), 101);
    }
}

#[test]
fn a_page_of_the_web_gets_nothing() {
    let server = server("rough");
    for address in [server.truth, server.positions] {
        let request = b"POST / HTTP/1.1\r\nHost: x\r\n\r\n{class Pawn}\r\nGETPOS\r\n\r\n";
        let mut stream = connect(address);
        stream.write_all(request).expect("to send");
        let mut text = Vec::new();
        // The server closes with unread bytes, which may reset the connection.
        let _ = stream.read_to_end(&mut text);
        assert_eq!(String::from_utf8_lossy(&text), "");
    }
}

/// Clients flood the ports and read nothing. A robot's client loses no line, and others are answered.
#[test]
fn clients_that_do_not_read_hold_up_nobody() {
    let server = server("rescue");
    let mut bystander = server.bystander();
    let flood: Vec<TcpStream> = [server.truth, server.positions]
        .into_iter()
        .flat_map(|address| (0..8).map(move |_| connect(address)))
        .map(|mut stream| {
            stream.set_nonblocking(true).expect("no waiting");
            let lines = b"\r\n{Actors}\r\nGETPOS\r\nGETOBS {Start -20,-20,-0.2} {End 20,20,-0.2}\r\n".repeat(2000);
            let _ = stream.write(&lines);
            stream
        })
        .collect();
    bystander.check_undisturbed();
    assert!(ask(server.truth, b"{class P3AT}\r\n").starts_with("{Name P3AT_0} {Class P3AT}"));
    assert!(ask(server.positions, b"GETPOS\r\n").starts_with("POSITIONS {Robots 1} {Name Bystander Location "));
    drop(flood);
}

#[test]
fn a_port_that_is_taken_is_left_out() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("an address").port();
    let server = Server::start("rough", &[], |config| {
        config.listeners.push(Listener { service: Service::Truth, port, if_taken: IfTaken::LeaveOut });
    });
    assert_eq!(server.truth, None);
    server.client();
}
