//! Files of other programs that come by `POST /open`, as the page sends them.

use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::Stdio;

use super::cli::{Serving, usarsim};

/// A cart of two wheels, with more inside its first link.
fn cart(name: &str, more: &str) -> String {
    let inertial = |mass: f64| {
        format!(
            "<inertial><mass value='{mass}'/><inertia ixx='0.2' iyy='0.3' izz='0.4' ixy='0' ixz='0' iyz='0'/></inertial>"
        )
    };
    let wheel = |side: &str, y: f64| {
        format!(
            "<link name='{side}'>{}<collision><origin rpy='1.5708 0 0'/><geometry><cylinder radius='0.1' length='0.05'/></geometry>\
             </collision></link><joint name='{side}_wheel' type='continuous'><parent link='base'/><child link='{side}'/>\
             <origin xyz='0 {y} 0'/><axis xyz='0 1 0'/></joint>",
            inertial(1.0)
        )
    };
    let body = "<collision><geometry><box size='0.6 0.3 0.1'/></geometry></collision>";
    let (left, right) = (wheel("left", 0.2), wheel("right", -0.2));
    format!("<robot name='{name}'><link name='base'>{}{body}{more}</link>{left}{right}</robot>", inertial(8.0))
}

/// A world with a floor and more.
fn world(more: &str) -> String {
    let ground = "<model name='g'><static>1</static><link name='l'><collision name='c'><geometry><plane/></geometry></collision></link></model>";
    format!("<sdf version='1.9'><world name='w'>{ground}{more}</world></sdf>")
}

const WALL: &str = "v 0 -1 0\nv 0 1 0\nv 0 1 1\nv 0 -1 1\nf 1 2 3 4\n";

/// Files by their paths.
type Files<'a> = &'a [(&'a str, &'a [u8])];

/// Sends files. Returns the status and the body of the answer.
fn open(server: &Serving, query: &str, headers: &str, files: Files) -> (u16, String) {
    let mut body = Vec::new();
    for (name, content) in files {
        let head = format!("--edge\r\nContent-Disposition: form-data; name=\"{name}\"; filename=\"f\"\r\n\r\n");
        body.extend([head.as_bytes(), content, b"\r\n"].concat());
    }
    body.extend(b"--edge--\r\n");
    let port = server.ready["http"].as_u64().expect("a page") as u16;
    let mut stream = TcpStream::connect(("127.0.0.1", port)).expect("a connection");
    let mut head = format!("POST /open{query} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n{headers}");
    let _ = write!(head, "Content-Type: multipart/form-data; boundary=edge\r\nContent-Length: {}\r\n\r\n", body.len());
    stream.write_all(head.as_bytes()).expect("taken");
    // Who is refused is not read to the end.
    let _ = stream.write_all(&body);
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    let answer = String::from_utf8_lossy(&answer).into_owned();
    let status = answer.split(' ').nth(1).and_then(|status| status.parse().ok());
    let (_, body) = answer.split_once("\r\n\r\n").unwrap_or_default();
    (status.unwrap_or_else(|| panic!("no answer: {answer}")), body.to_owned())
}

/// Sends lines as a controller, and returns the lines that come until one has a text.
fn wait_for(server: &Serving, lines: &str, expected: &str) -> (TcpStream, String) {
    let mut client = server.connect();
    client.write_all(lines.as_bytes()).expect("taken");
    let mut heard = String::new();
    let mut reader = BufReader::new(client.try_clone().expect("a copy"));
    while !heard.lines().any(|line| line.contains(expected)) {
        assert!(reader.read_line(&mut heard).is_ok_and(|count| count > 0), "{expected} does not come: {heard}");
    }
    (client, heard)
}

#[test]
fn a_robot_that_is_brought_drives_and_a_log_of_it_replays() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = usarsim();
    command.current_dir(folder.path()).args(["serve", "--http", "0", "--map", "smooth", "--log", "brought.mcap"]);
    let mut server = Serving::of(&mut command, Stdio::null());
    let heavier = "<collision><geometry><box size='0.2 0.2 0.2'/></geometry></collision>";
    for (name, more) in [("Handcart", ""), ("Handcart_2", heavier), ("Handcart", ""), ("Handcart_2", heavier)] {
        let text = cart("Handcart", more);
        let (status, answer) = open(&server, "", "", &[("cart.urdf", text.as_bytes())]);
        assert!(status == 200 && answer.starts_with(&format!("{{\"robot\":\"{name}\"")), "{status} {answer}");
    }
    let (_client, heard) = wait_for(&server, "GETCLASSES\r\n", "NFO {Classes");
    assert!(heard.contains(",Handcart,Handcart_2}"), "{heard}");
    let lines = "INIT {ClassName Handcart_2} {Name R1} {Location 0,0,0}\r\nDRIVE {Left 3} {Right 3}\r\n";
    let (client, _) = wait_for(&server, lines, "{Time 1.5");
    drop(client);
    server.signal("TERM");
    assert!(server.wait().success());
    let replay =
        usarsim().current_dir(folder.path()).args(["log", "replay", "brought.mcap"]).output().expect("it runs");
    let said = String::from_utf8_lossy(&replay.stdout).into_owned() + &String::from_utf8_lossy(&replay.stderr);
    assert!(replay.status.success() && said.contains("replayed with the same bits"), "{said}");
}

/// A cart of SDF, whose body is a mesh of its folder.
const SDF: &str = "<sdf version='1.9'><model name='rover'><link name='base'><pose>0 0 0.1 0 0 0</pose><inertial><mass>8</mass></inertial>\
    <collision name='c'><geometry><mesh><uri>model://rover/meshes/body.obj</uri></mesh></geometry></collision></link>\
    <link name='l'><pose>0 0.3 0.1 -1.5708 0 0</pose><collision name='c'><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link>\
    <link name='r'><pose>0 -0.3 0.1 -1.5708 0 0</pose><collision name='c'><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link>\
    <joint name='lw' type='continuous'><parent>base</parent><child>l</child><axis><xyz>0 0 1</xyz></axis></joint>\
    <joint name='rw' type='continuous'><parent>base</parent><child>r</child><axis><xyz>0 0 1</xyz></axis></joint></model></sdf>";

#[test]
fn a_model_of_gazebo_is_a_robot_and_a_world_a_map() {
    let server = Serving::start(&["--http", "0", "--map", "smooth"]);
    let body = "v 0 0 0\nv 0.3 0 0\nv 0 0.3 0\nv 0 0 0.3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let elsewhere = SDF.replace("model://rover/meshes/body.obj", "file:///etc/hostname");
    let folder =
        |text: &'static str| [("rover/model.sdf", text.as_bytes()), ("rover/meshes/body.obj", body.as_bytes())];
    let (status, answer) = open(&server, "", "", &folder(SDF));
    assert!(status == 200 && answer.contains("\"robot\":\"rover\""), "{status} {answer}");
    assert!(answer.contains("skid, 10.0 kg") && !answer.contains("is not there"), "{answer}");
    let (status, answer) = open(&server, "", "", &[("rover.sdf", elsewhere.as_bytes())]);
    assert!(status == 200 && answer.contains("`file:///etc/hostname` is not there"), "{status} {answer}");
    let in_world = world(SDF.trim_start_matches("<sdf version='1.9'>").trim_end_matches("</sdf>"));
    let (status, answer) = open(&server, "", "", &[("field.world", in_world.as_bytes())]);
    assert!(
        status == 200 && answer.contains("\"map\":\"field\"") && answer.contains("--model rover"),
        "{status} {answer}"
    );
}

#[test]
fn files_of_strangers_lead_nowhere_outside_of_their_folder() {
    let secret = tempfile::tempdir().expect("a folder");
    let wall = secret.path().join("wall.obj");
    std::fs::write(&wall, WALL).expect("a file");
    std::fs::create_dir(secret.path().join("post")).expect("a folder");
    let post = "<sdf version='1.9'><model name='post'><static>1</static><link name='l'><collision name='c'><geometry>\
                <box><size>1 1 1</size></box></geometry></collision></link></model></sdf>";
    std::fs::write(secret.path().join("post/model.sdf"), post).expect("a file");
    let (wall, folder) = (wall.display().to_string(), secret.path().display().to_string());
    let server = Serving::start(&["--http", "0", "--map", "smooth"]);
    let up = "../".repeat(20);
    for place in [wall.clone(), format!("file://{wall}"), format!("{up}{wall}"), format!("package://cart/{up}{wall}")] {
        let mesh = format!("<visual><geometry><mesh filename='{place}'/></geometry></visual>");
        let (status, answer) = open(&server, "", "", &[("cart/cart.urdf", cart("Cart", &mesh).as_bytes())]);
        assert!(status == 200 && answer.contains("left out: mesh"), "{place}: {status} {answer}");
    }
    for place in [folder.clone() + "/post", format!("file://{folder}/post"), format!("model://{up}{folder}/post")] {
        let include = format!("<include><uri>{place}</uri></include>");
        let (status, answer) = open(&server, "", "", &[("a/b.world", world(&include).as_bytes())]);
        assert!(status == 200 && answer.contains("1 solid over"), "{place}: {status} {answer}");
    }
    for place in [wall.clone(), format!("file://{wall}"), format!("model://{up}{wall}")] {
        let model = format!(
            "<model name='m'><static>1</static><link name='l'><collision name='c'><geometry><mesh><uri>{place}</uri></mesh>\
             </geometry></collision></link></model>"
        );
        let (status, answer) = open(&server, "", "", &[("a/b.world", world(&model).as_bytes())]);
        assert!(status == 200 && answer.contains("1 solid over"), "{place}: {status} {answer}");
    }
    let gltf = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"buffers\":[{{\"uri\":\"{up}{wall}\",\"byteLength\":36}}],\
        \"bufferViews\":[{{\"buffer\":0,\"byteLength\":36}}],\"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":3,\
        \"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,1]}}],\"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}}}}]}}],\
        \"nodes\":[{{\"mesh\":0}}],\"scenes\":[{{\"nodes\":[0]}}]}}"
    );
    let (status, answer) = open(&server, "", "", &[("a.gltf", gltf.as_bytes())]);
    assert!(status == 422 && answer.contains("expected a file in the folder of the mesh"), "{status} {answer}");
}

#[test]
fn what_cannot_be_opened_is_refused_with_the_reason() {
    let server = Serving::start(&["--http", "0", "--map", "smooth"]);
    let text = cart("Cart", "");
    let text = text.as_bytes();
    let many: Vec<(String, &[u8])> = (0..2001).map(|number| (format!("{number}.stl"), &b"x"[..])).collect();
    let many: Vec<(&str, &[u8])> = many.iter().map(|(name, content)| (name.as_str(), *content)).collect();
    let xacro =
        b"<robot name='x' xmlns:xacro='http://ros.org/wiki/xacro'><xacro:include filename='$(find x)/y'/></robot>";
    let rows: [(&str, Files, u16, &str); 12] = [
        ("", &[("a/x.urdf", text), ("a/y.urdf", text)], 200, "{\"choices\":[\"a/x.urdf\",\"a/y.urdf\"]}"),
        ("?file=a/y.urdf", &[("a/x.urdf", text), ("a/y.urdf", text)], 200, "{\"robot\":\"Cart\""),
        ("?file=a/z.urdf", &[("a/x.urdf", text)], 422, "a/z.urdf is not among the files"),
        ("", &[("../x.urdf", text)], 422, "../x.urdf: expected the path of a file in a folder"),
        ("", &[("/tmp/x.urdf", text)], 422, "/tmp/x.urdf: expected the path"),
        ("", &[("x.txt", text)], 422, "nothing here can be opened: expected a .urdf"),
        ("", &[], 422, "nothing here can be opened"),
        ("", &[("x.urdf", b"<robot name='x'>")], 422, "x.urdf:1:"),
        ("", &[("x.urdf.xacro", xacro)], 422, "drop what `xacro x.urdf.xacro` prints"),
        ("", &[("x.stl", b"solid x")], 422, "x.stl"),
        // A path that is a file and a folder.
        ("", &[("a", text), ("a/x.urdf", text)], 422, "the files cannot be written"),
        ("", &many, 413, "expected at most 2000 files"),
    ];
    for (query, files, expected, part) in rows {
        let (status, answer) = open(&server, query, "", files);
        assert!(status == expected && answer.contains(part), "{part}: {status} {answer}");
    }
    let (status, answer) = open(&server, "", "Origin: http://elsewhere.example\r\n", &[("x.urdf", text)]);
    assert!(status == 403 && answer.contains("expected a page of this server"), "{status} {answer}");
    let huge = vec![0; 129 << 20];
    assert_eq!(open(&server, "", "", &[("huge.stl", &huge)]).0, 413);
    // One was opened above.
    let other = |number: usize| cart(&format!("Cart{number}"), "");
    for count in 1..64 {
        let (status, answer) = open(&server, "", "", &[("x.urdf", other(count).as_bytes())]);
        assert_eq!(status, 200, "robot {count}: {answer}");
    }
    let (status, answer) = open(&server, "", "", &[("x.urdf", other(64).as_bytes())]);
    assert!(status == 422 && answer.contains("64 classes were added"), "{status} {answer}");
}

#[test]
fn who_may_not_control_the_world_brings_nothing_into_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("tokens.toml");
    let roles = "[[token]]\ntoken = \"drv-0123456789abcdef\"\nroles = [\"viewer\", \"driver\"]\n\
                 [[token]]\ntoken = \"ref-0123456789abcdef\"\nroles = [\"viewer\", \"referee\"]\n";
    std::fs::write(&file, roles).expect("a file");
    let text = cart("Cart", "");
    let files: Files = &[("x.urdf", text.as_bytes())];
    let server = Serving::start(&["--http", "0", "--map", "smooth", "--token-file", &file.display().to_string()]);
    for (token, expected) in [
        ("", 401),
        ("Authorization: Bearer drv-0123456789abcdef\r\n", 401),
        ("Authorization: Bearer ref-0123456789abcdef\r\n", 200),
    ] {
        let (status, answer) = open(&server, "", token, files);
        assert_eq!(status, expected, "{token}: {answer}");
    }
    let server = Serving::start(&["--http", "0", "--map", "smooth", "--control", "nobody"]);
    let (status, answer) = open(&server, "", "", files);
    assert!(status == 403 && answer.contains("no page controls this world"), "{status} {answer}");
    // A league stays on its map.
    let server = Serving::start(&["--http", "0", "--league", "rescue", "--control", "everyone"]);
    let (status, answer) = open(&server, "", "", &[("w.world", world("").as_bytes())]);
    assert!(status == 422 && answer.contains("a league stays on its map"), "{status} {answer}");
}
