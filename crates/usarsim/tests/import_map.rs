//! `usarsim import-map`: maps from meshes and from SDF.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A floor of 8 x 6 m and a wall, both boxes, and a wedge. z is up.
const HOUSE: &str = "o Floor slab
v -4 -3 -0.2\nv 4 -3 -0.2\nv 4 3 -0.2\nv -4 3 -0.2\nv -4 -3 0\nv 4 -3 0\nv 4 3 0\nv -4 3 0
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8
o North wall
v -4 2 0\nv 4 2 0\nv 4 2.2 0\nv -4 2.2 0\nv -4 2 1\nv 4 2 1\nv 4 2.2 1\nv -4 2.2 1
f 9 12 11 10\nf 13 14 15 16\nf 9 10 14 13\nf 10 11 15 14\nf 11 12 16 15\nf 12 9 13 16
o wedge
v 1 -1 0\nv 3 -1 0\nv 3 1 0\nv 1 1 0\nv 3 -1 1\nv 3 1 1
f 17 20 19 18\nf 17 18 21\nf 20 22 19\nf 18 19 22 21\nf 17 21 22 20
";

/// Returns a world of SDF around models.
fn sdf(models: &str) -> String {
    let ground = "<model name='ground'><static>true</static><link name='l'><collision name='c'><geometry><plane>\
                  <normal>0 0 1</normal></plane></geometry></collision></link></model>";
    format!("<sdf version='1.6'><world name='w'>{ground}{models}</world></sdf>")
}

/// Returns a model of one link with one shape.
fn model(name: &str, more: &str, geometry: &str) -> String {
    format!(
        "<model name='{name}'>{more}<link name='l'><inertial><mass>0.4</mass></inertial><collision name='c'>\
         <geometry>{geometry}</geometry></collision></link></model>"
    )
}

/// Imports a file in a folder, with further files beside it.
fn import(folder: &Path, files: &[(&str, &[u8])], arguments: &[&str]) -> Output {
    for (name, content) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, content).expect("a file");
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_usarsim"));
    command.current_dir(folder).arg("import-map").args(arguments).output().expect("it runs")
}

/// Imports a file that is good. Returns the text of map.toml and what was printed.
#[track_caller]
fn good(files: &[(&str, &[u8])], arguments: &[&str]) -> (String, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let output = import(folder.path(), files, &[arguments, &["--name", "made"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let map = folder.path().join("made/map.toml");
    let loaded = scene_loader::load(&map.display().to_string(), &[]).unwrap_or_else(|error| panic!("{error}"));
    assert!(!loaded.map.starts.is_empty());
    (fs::read_to_string(map).expect("a map"), String::from_utf8_lossy(&output.stdout).into_owned())
}

#[test]
fn objects_of_a_mesh_become_solids_with_materials() {
    let (map, printed) = good(
        &[("house.obj", HOUSE.as_bytes())],
        &["house.obj", "--material", "floor*=carpet", "--material", "*WALL=plywood"],
    );
    for expected in [
        "[[box]]\nname = \"Floor_slab\"\nmaterial = \"carpet\"\nposition = [0.0, 0.0, 0.1]\nsize = [8.0, 6.0, 0.2]\n",
        // y is to the right on the map, and z down.
        "[[box]]\nname = \"North_wall\"\nmaterial = \"plywood\"\nposition = [0.0, -2.1, -0.5]\nsize = [8.0, 0.2, 1.0]\n",
        "[[mesh]]\nname = \"wedge\"\nmaterial = \"concrete\"\nfile = \"wedge.obj\"\n",
        "[[start]]\nname = \"PlayerStart_0\"\nposition = [0.0, 0.0, ",
    ] {
        assert!(map.contains(expected), "{expected}\n{map}");
    }
    for expected in ["Floor_slab: box, carpet", "North_wall: box, plywood", "wedge: mesh of 8 triangles, concrete"] {
        assert!(printed.lines().any(|line| line == expected), "{expected}\n{printed}");
    }
}

#[test]
fn a_scan_gets_a_floor_and_a_scale() {
    let text = "v 1 -1 3\nv 3 -1 3\nv 3 1 3\nv 3 -1 5\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    let (map, printed) = good(&[("scan.obj", text.as_bytes())], &["scan.obj", "--scale", "0.5", "--floor"]);
    let floor = "[[half_space]]\nname = \"floor\"\nmaterial = \"concrete\"\nposition = [0.0, 0.0, -1.5]\n";
    assert!(map.contains(floor), "{map}");
    assert!(printed.contains("scan: mesh of 4 triangles"), "{printed}");
}

#[test]
fn a_shipped_glb_keeps_its_colours() {
    let body = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/robots/P3AT/body.glb");
    let (map, _) = good(&[], &[body.to_str().expect("a path"), "--floor"]);
    assert!(map.matches("[[mesh]]").count() > 3 && map.matches("colour = ").count() > 3, "{map}");
}

#[test]
fn a_world_of_sdf_keeps_shapes_poses_and_masses() {
    let shelf = "<sdf version='1.6'><model name='shelf'><static>1</static><link name='l'>\
                 <collision name='back'><pose>0 0.2 0.5 0 0 0</pose><geometry><box><size>1 0.05 1</size></box></geometry></collision>\
                 <collision name='board'><geometry><sphere><radius>0.3</radius></sphere></geometry></collision>\
                 </link></model></sdf>";
    let models = [
        "<light name='sun'/><include><uri>model://shelf</uri><name>left</name><pose>3 2 0 0 0 0</pose></include>"
            .to_owned(),
        model(
            "wall 1",
            "<static>true</static><pose degrees='true'>0 -3 0.5 0 10 30</pose>",
            "<box><size>4 0.2 1</size></box>",
        ),
        model("can", "<pose>1 0 0.1 0 0 0</pose>", "<cylinder><radius>0.05</radius><length>0.2</length></cylinder>"),
        model("hill", "<static>true</static>", "<heightmap/>"),
        model("scan", "<static>true</static>", "<mesh><uri>model://house.obj</uri><scale>0.5 0.5 0.5</scale></mesh>"),
    ]
    .concat();
    let files: [(&str, &[u8]); 3] = [
        ("a.world", &sdf(&models).into_bytes()),
        ("models/shelf/model.sdf", shelf.as_bytes()),
        ("house.obj", HOUSE.as_bytes()),
    ];
    let (map, printed) = good(&files, &["a.world"]);
    for expected in [
        "[[box]]\nname = \"left-back\"\nmaterial = \"concrete\"\nposition = [3.0, -2.2, -0.5]\nsize = [1.0, 0.05, 1.0]\n",
        "[[ball]]\nname = \"left-board\"\nmaterial = \"concrete\"\nposition = [3.0, -2.0, 0.0]\nradius = 0.3\n",
        "[[half_space]]\nname = \"ground\"\n",
        "name = \"wall_1\"\nmaterial = \"concrete\"\nposition = [0.0, 3.0, -0.5]\nrotation = [0.0, -0.17453, -0.5236]\n",
        "[[cylinder]]\nname = \"can\"\nmaterial = \"concrete\"\nposition = [1.0, 0.0, -0.1]\nradius = 0.05\nlength = 0.2\nmass = 0.4\n",
        "[[mesh]]\nname = \"scan\"\nmaterial = \"concrete\"\nfile = \"scan.obj\"\n",
    ] {
        assert!(map.contains(expected), "{expected}\n{map}");
    }
    for expected in [
        "note: <light> is left out",
        "note: a shape <heightmap> without a picture is left out",
        "can: cylinder, concrete, can be pushed",
    ] {
        assert!(printed.lines().any(|line| line == expected), "{expected}\n{printed}");
    }
    let (_, json) = good(&files, &["a.world", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["solids"][4]["name"], "can");
    assert_eq!(json["solids"][4]["movable"], true);
    assert_eq!(json["starts"][0]["name"], "PlayerStart_0");
    assert_eq!(json["notes"].as_array().map(Vec::len), Some(2));
}

#[test]
fn a_world_without_a_floor_gets_one_and_the_verdict_says_what_it_is() {
    // Between the places that are tried, so that no robot stands on a box.
    let post = |name: &str, x: f64, y: f64| {
        model(name, &format!("<static>1</static><pose>{x} {y} 0.5 0 0 0</pose>"), "<box/>")
    };
    let posts = post("a", 3.75, 0.75) + &post("b", -3.75, -0.75);
    let text = format!("<sdf version='1.6'><world name='w'>{posts}</world></sdf>");
    let (map, printed) = good(&[("a.sdf", text.as_bytes())], &["a.sdf"]);
    assert!(map.contains("[[half_space]]\nname = \"floor\""), "{map}");
    for expected in [
        "note: a <box> without <size>: 1 m, as Gazebo takes it (2 times)",
        "note: a floor is added below everything, as there is no place on which a robot could stand",
        "made: 3 solids over 8.5 x 2.5 x 1.0 m, none can be pushed",
        "materials: 3 of concrete; --material 'PATTERN=MATERIAL' changes them",
        "left out or changed: 2 notes, above",
    ] {
        assert!(printed.lines().any(|line| line == expected), "{expected}\n{printed}");
    }
}

#[test]
fn what_cannot_be_imported_is_refused_by_name_and_leaves_nothing() {
    let empty = "<sdf version='1.6'><model name='m'/></sdf>";
    let recursive = "<sdf version='1.6'><model name='m'><include><uri>model://m</uri></include></model></sdf>";
    let relative = model("a", "<pose relative_to='b'>0 0 0 0 0 0</pose>", "<box><size>1 1 1</size></box>");
    for (file, text, more, code, expected) in [
        ("a.fbx", "", &[][..], 65, "a.fbx: expected a .sdf, .world, .glb, .gltf, .obj, .stl or .dae file"),
        (
            "none.obj",
            "",
            &["--material", "x=plywod"],
            65,
            "unknown material `plywod` (did you mean `plywood`?): expected one of",
        ),
        ("a.obj", "v 0 0 0\n", &[], 65, "mesh `a.obj` has 0 triangles: expected 1 to"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n", &[], 65, "no place on which a robot could stand"),
        ("a.obj", HOUSE, &["--name", "../x"], 2, "expected up to 60 letters, digits, -, _ or points"),
        ("a.obj", HOUSE, &["--material", "plywood"], 2, "expected PATTERN=MATERIAL"),
        ("a.sdf", "<robot/>", &[], 65, "a.sdf: cannot be read: <robot>: expected <sdf>"),
        ("a.sdf", "<sdf", &[], 65, "not XML"),
        ("a.sdf", "<sdf><world/></sdf>", &[], 65, "a.sdf has 0 colliding shapes: expected 1 to 10000"),
        (
            "a.sdf",
            &sdf("<include><uri>model://x</uri></include>"),
            &["--strict"],
            65,
            ": `model://x` is not there: expected it beside this file, in a folder above",
        ),
        (
            "a.sdf",
            &sdf("<include><uri>model://m</uri></include>"),
            &[],
            65,
            "expected at most 16 models inside each other",
        ),
        (
            "a.sdf",
            &sdf(&"<include><uri>model://empty</uri></include>".repeat(1001)),
            &[],
            65,
            "more than 1000 included models",
        ),
        ("a.sdf", &sdf(&relative), &[], 65, "no frame `b`"),
        ("a.sdf", &sdf(&model("a", "<pose>1 2 x</pose>", "")), &[], 65, "a pose that is not `x y z roll pitch yaw`"),
        (
            "a.sdf",
            &sdf(&model("a", "", "<box><size>1 1 -1</size></box>")),
            &[],
            65,
            "`size` is [1, 1, -1]: expected numbers of",
        ),
        (
            "a.sdf",
            &sdf(&model("a", "", "<mesh><uri>none.stl</uri></mesh>")),
            &["--strict"],
            65,
            "`none.stl` is not there",
        ),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let files =
            [(file, text.as_bytes()), ("m/model.sdf", recursive.as_bytes()), ("empty/model.sdf", empty.as_bytes())];
        let named: &[&str] = if more.contains(&"--name") { &[] } else { &["--name", "made"] };
        let output = import(folder.path(), &files, &[&[file], named, more].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(code) && said.contains(expected), "{file}: {expected}\n{said}");
        assert!(!folder.path().join("made").exists(), "{file}: {expected}");
    }
}

#[test]
fn a_folder_that_exists_is_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let files: [(&str, &[u8]); 2] = [("house.obj", HOUSE.as_bytes()), ("made/mine.txt", b"mine")];
    let output = import(folder.path(), &files, &["house.obj", "--name", "made"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && said.contains("made: exists already"), "{said}");
    assert_eq!(fs::read(folder.path().join("made/mine.txt")).expect("a file"), b"mine");
}

/// A soup that takes a while: SIGTERM comes when its folder is there.
#[test]
fn an_import_that_is_broken_off_leaves_no_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("soup.obj"), soup(20_000)).expect("a file");
    let mut command = Command::new(env!("CARGO_BIN_EXE_usarsim"));
    command.current_dir(folder.path()).args(["import-map", "soup.obj", "--name", "made"]);
    let mut child = command.stderr(std::process::Stdio::piped()).spawn().expect("it runs");
    let made = folder.path().join("made");
    while !made.join("map.toml").exists() {
        assert!(child.try_wait().expect("a child").is_none(), "it ends before its folder is there");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    // The shell's own kill: not every machine has a program of that name.
    let signal = Command::new("sh").args(["-c", &format!("kill -TERM {}", child.id())]).status();
    assert!(signal.is_ok_and(|it| it.success()));
    let output = child.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && said.contains("made: stopped, and removed"), "{said}");
    assert!(!made.exists());
}

/// Returns triangles of a metre in disorder in a cube of 10 m, as OBJ.
fn soup(triangles: usize) -> String {
    let mut state = 1_u64;
    let mut next = |size: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1_u64 << 31) as f64 * size
    };
    let mut text = String::new();
    for number in 0..triangles {
        let middle = [next(10.0), next(10.0), next(10.0)];
        for _ in 0..3 {
            let [x, y, z] = middle.map(|part| part + next(1.0));
            text += &format!("v {x:.4} {y:.4} {z:.4}\n");
        }
        text += &format!("f {} {} {}\n", 3 * number + 1, 3 * number + 2, 3 * number + 3);
    }
    text
}
