//! Robots of SDF: the same cart in the ways in which files say it is one and the same robot.

use std::path::{Path, PathBuf};

use scene::{JointKind, RobotDef, Steering};
use scene_loader::{Import, Imported, LoadError, MapImport, Packages, SdfFile, SdfRobot, sdf_robot, sdf_robots};
use tempfile::TempDir;

/// A folder with files of SDF.
struct Files {
    folder: TempDir,
    models: Vec<PathBuf>,
}

impl Files {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, content) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            std::fs::write(path, content).expect("a file");
        }
        std::fs::create_dir(folder.path().join("work")).expect("a folder");
        Self { folder, models: Vec::new() }
    }

    fn with<T>(&self, file: &str, read: impl Fn(&SdfFile) -> T) -> T {
        let (file, work) = (self.folder.path().join(file), self.folder.path().join("work"));
        read(&SdfFile { file: &file, models: &self.models, within: None, work: &work })
    }

    fn robot(&self, file: &str, name: Option<&str>) -> Result<SdfRobot, LoadError> {
        self.with(file, |of| sdf_robot(of, name))
    }

    /// Imports the robot with this name.
    fn imported(&self, file: &str, name: Option<&str>) -> Imported {
        let robot = self.robot(file, name).unwrap_or_else(|error| panic!("{error}"));
        let path = self.folder.path().join(file);
        let mut packages = Packages::around(&path, &[], &[]).expect("packages");
        robot.folders.iter().for_each(|folder| packages.allow(folder));
        packages.allow(&self.folder.path().join("work"));
        let settings = Import { file: &path, text: "", class: "Cart", packages: &packages, wheels: &[], drive: None };
        robot.import(&settings).unwrap_or_else(|error| panic!("{error}:\n{}", robot.text))
    }
}

/// A link at a pose, with a mass and a shape.
fn link(name: &str, pose: &str, mass: f64, shape: &str) -> String {
    format!(
        "<link name='{name}'><pose>{pose}</pose><inertial><mass>{mass}</mass><inertia><ixx>0.05</ixx><iyy>0.05</iyy><izz>0.05</izz></inertia>\
         </inertial><collision name='c'><geometry>{shape}</geometry></collision></link>"
    )
}

fn joint(name: &str, kind: &str, ends: [&str; 2], more: &str) -> String {
    let [parent, child] = ends;
    format!("<joint name='{name}' type='{kind}'><parent>{parent}</parent><child>{child}</child>{more}</joint>")
}

const BODY: &str = "<box><size>0.5 0.3 0.1</size></box>";
const WHEEL: &str = "<cylinder><radius>0.1</radius><length>0.05</length></cylinder>";
const BALL: &str = "<sphere><radius>0.05</radius></sphere>";
const DIFF: &str = "<plugin name='d' filename='diff-drive'><left_joint>left_wheel</left_joint><right_joint>right_wheel</right_joint></plugin>";

/// The links of a cart: wheels 0.2 m to the sides and 0.15 m ahead, a ball behind.
fn links() -> String {
    let parts = [
        ("base", "0 0 0.15 0 0 0", 8.0, BODY),
        ("left", "0.15 0.2 0.1 -1.5707963 0 0", 1.0, WHEEL),
        ("right", "0.15 -0.2 0.1 -1.5707963 0 0", 1.0, WHEEL),
        ("ball", "-0.2 0 0.05 0 0 0", 0.5, BALL),
    ];
    parts.map(|(name, pose, mass, shape)| link(name, pose, mass, shape)).concat()
}

/// The joints of the cart: wheels about an axis, and the ball.
fn joints(axis: &str) -> String {
    let wheels = [("left_wheel", "left"), ("right_wheel", "right")];
    let wheels = wheels.map(|(name, child)| joint(name, "revolute", ["base", child], axis)).concat();
    wheels + &joint("caster", "ball", ["base", "ball"], "")
}

fn model(version: &str, inside: &str) -> String {
    format!("<sdf version='{version}'><model name='cart'>{inside}</model></sdf>")
}

/// Checks that a robot is the cart.
fn assert_cart(robot: &RobotDef, case: &str) {
    assert_eq!(robot.steering, Steering::Skid, "{case}: {:?}", robot.assumptions);
    assert!((robot.mass() - 10.5).abs() < 0.02, "{case}: {} kg", robot.mass());
    let mut wheels: Vec<_> = robot.driven().collect();
    wheels.sort_by(|a, b| a.position[1].total_cmp(&b.position[1]));
    let places: Vec<[f64; 3]> = wheels.iter().map(|wheel| wheel.position).collect();
    for (place, expected) in places.iter().zip([[0.15, -0.2, -0.1], [0.15, 0.2, -0.1]]) {
        let is_there = place.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(is_there, "{case}: a wheel at {place:?}, not {expected:?}");
    }
    assert!(wheels.len() == 2 && wheels.iter().all(|wheel| (wheel.radius - 0.1).abs() < 1e-6), "{case}");
    let body = robot.links[0].mass();
    assert!((body.centre.z + 0.15).abs() < 0.01, "{case}: the body's centre is at {}", body.centre);
}

#[test]
fn a_cart_is_the_same_robot_however_its_file_says_it() {
    let own_axis = "<axis><xyz>0 0 1</xyz></axis>";
    let of_model = "<axis><xyz>0 1 0</xyz></axis>";
    let parent_frame = "<axis><xyz>0 1 0</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>";
    let expressed = "<axis><xyz expressed_in='__model__'>0 1 0</xyz></axis>";
    let of_base = "<axis><xyz expressed_in='base'>0 1 0</xyz></axis>";
    let no_end = "<axis><xyz>0 0 1</xyz><limit><lower>-1.79769e+308</lower><upper>1.79769e+308</upper></limit></axis>";
    let plain = |axis: &str| links() + &joints(axis) + DIFF;
    let placed = plain("<pose>0 0 0 1.5707963 0 0</pose><axis><xyz>0 1 0</xyz></axis>");
    let on_frames = links().replace("<pose>-0.2 0 0.05 0 0 0</pose>", "<pose relative_to='rear'>0 0 0 0 0 0</pose>")
        + "<frame name='rear'><pose relative_to='base'>-0.2 0 -0.1 0 0 0</pose></frame>"
        + &joints(own_axis)
        + DIFF;
    let reversed = links()
        + &joint("left_wheel", "continuous", ["left", "base"], &format!("<pose relative_to='left'/>{of_base}"))
        + &joint("right_wheel", "continuous", ["right", "base"], &format!("<pose relative_to='right'/>{of_base}"))
        + &joint("caster", "ball", ["base", "ball"], "")
        + DIFF;
    let looped = plain(own_axis) + &joint("again", "fixed", ["left", "ball"], "");
    let inside = format!("<model name='inner'><pose>0 0 0.5 0 0 0</pose>{}</model>", links());
    let nested = inside.replace("0 0 0.5", "0 0 0")
        + &joints(own_axis).replace("<parent>", "<parent>inner::").replace("<child>", "<child>inner::")
        + DIFF;
    let included = "<include><uri>model://cart</uri></include>".to_owned() + DIFF;
    let merged = "<include merge='true'><uri>model://cart</uri><pose>0 0 0 0 0 0</pose></include>".to_owned() + DIFF;
    let beside = model("1.6", &(links() + &joints(own_axis)));
    let gauge = |inside: String| inside + &link("gauge", "0 0 0.2 0 0 0", 0.001, BALL);
    for (case, version, inside) in [
        ("axes of joints", "1.6", plain(own_axis)),
        ("version 1.10 is later than 1.5", "1.10", plain(own_axis)),
        ("axes of the model", "1.4", plain(of_model)),
        ("axes of the parent's model", "1.5", plain(parent_frame)),
        ("axes expressed in the model", "1.9", plain(expressed)),
        ("axes expressed in a link", "1.9", plain(of_base)),
        (
            "ends as attributes",
            "1.0",
            plain(of_model)
                .replace("<parent>", "<parent link='")
                .replace("</parent>", "'/>")
                .replace("<child>", "<child link='")
                .replace("</child>", "'/>"),
        ),
        ("limits that are none", "1.6", plain(no_end)),
        ("a pose of the joint", "1.7", placed),
        ("a link on a frame", "1.9", on_frames),
        ("wheels that carry the body", "1.9", reversed),
        ("a loop", "1.6", looped),
        ("a model inside", "1.9", nested),
        ("a model that is included", "1.9", included),
        ("a model that is merged", "1.9", merged),
        ("a link that hangs on nothing", "1.6", gauge(plain(own_axis))),
        ("no plugin", "1.6", links() + &joints(own_axis)),
    ] {
        let files = Files::new(&[("robot.sdf", &model(version, &inside)), ("cart/model.sdf", &beside)]);
        let imported = files.imported("robot.sdf", None);
        assert_cart(&imported.robot, case);
    }
}

#[test]
fn what_a_tree_cannot_have_is_said() {
    let axis = "<axis><xyz>0 0 1</xyz></axis>";
    let more = joint("again", "fixed", ["left", "ball"], "")
        + &joint("geared", "gearbox", ["base", "left"], "")
        + &joint("screwed", "screw", ["base", "nut"], axis)
        + &joint("lost", "fixed", ["base", "nobody"], "")
        + &link("nut", "0 0 0.3 0 0 0", 0.1, BALL)
        + &link("gauge", "0 0 0.2 0 0 0", 0.001, BALL)
        + "<link name='dish'><collision name='c'><geometry><plane/></geometry></collision></link>";
    let files = Files::new(&[("robot.sdf", &model("1.6", &(links() + &joints(axis) + &more)))]);
    let said = files.robot("robot.sdf", None).expect("a robot").left_out.join("\n");
    for words in [
        "joints that close a loop are left out: again",
        "gearboxes of two joints are left out: geared",
        "joints of type `screw` are held: screwed",
        "joints are left out, as there is no link `nobody`: lost",
        "links that hang on nothing are held on base: dish, gauge",
        "a collision of a <plane> is left out",
    ] {
        assert!(said.contains(words), "{words} is not in:\n{said}");
    }
}

#[test]
fn only_joints_that_a_plugin_names_are_driven() {
    let (free, end) = ("<axis><xyz>0 0 1</xyz></axis>", "<limit><lower>-1</lower><upper>1</upper></limit>");
    let more = link("mast", "0 0 0.3 0 0 0", 0.5, BALL)
        + &link("flag", "0 0 0.5 0 0 0", 0.5, BALL)
        + &joint("mast_joint", "revolute", ["base", "mast"], &format!("<axis><xyz>0 0 1</xyz>{end}</axis>"))
        + &joint("flag_joint", "revolute", ["mast", "flag"], &format!("<axis><xyz>0 0 1</xyz>{end}</axis>"));
    let of_mast = "<plugin name='p' filename='position'><joint_name>mast_joint</joint_name></plugin>";
    let inside = links() + &joints(free) + &more + DIFF + of_mast;
    let files = Files::new(&[("robot.sdf", &model("1.6", &inside))]);
    let imported = files.imported("robot.sdf", None);
    let drive = |name: &str| {
        let link = imported.robot.links.iter().find(|link| link.name == name).expect("a link");
        link.joint.as_ref().expect("a joint").drive.is_some()
    };
    assert!(drive("left_wheel") && drive("right_wheel") && drive("mast_joint") && !drive("flag_joint"));
    let said = imported.left_out.join("\n");
    assert!(said.contains("no plugin drives these joints, so they swing freely: flag_joint"), "{said}");
    assert!(said.contains("no limit of effort: up to") && said.contains("mast_joint"), "{said}");
    // Without a plugin nobody says which, and all are.
    let files = Files::new(&[("robot.sdf", &model("1.6", &(links() + &joints(free) + &more)))]);
    let imported = files.imported("robot.sdf", None);
    assert!(
        imported.robot.links.iter().filter_map(|link| link.joint.as_ref()).filter(|it| it.drive.is_some()).count() == 4
    );
}

#[test]
fn a_universal_joint_is_two_joints_that_steer_and_roll() {
    let axes = "<axis><xyz>0 1 0</xyz><limit><lower>-0.5</lower><upper>0.5</upper></limit></axis><axis2><xyz>0 0 1</xyz></axis2>";
    let front = |name: &str, y: f64| {
        link(name, &format!("0.3 {y} 0.1 -1.5707963 0 0"), 1.0, WHEEL)
            + &joint(&format!("{name}_hub"), "universal", ["base", name], axes)
    };
    let rear = |name: &str, y: f64| {
        link(name, &format!("-0.3 {y} 0.1 -1.5707963 0 0"), 1.0, WHEEL)
            + &joint(&format!("{name}_wheel"), "continuous", ["base", name], "<axis><xyz>0 0 1</xyz></axis>")
    };
    let inside = link("base", "0 0 0.15 0 0 0", 8.0, BODY)
        + &front("fl", 0.2)
        + &front("fr", -0.2)
        + &rear("rl", 0.2)
        + &rear("rr", -0.2);
    let files = Files::new(&[("car.sdf", &model("1.6", &inside))]);
    let imported = files.imported("car.sdf", None);
    let robot = &imported.robot;
    assert_eq!((robot.steering, robot.driven().count()), (Steering::Ackermann, 4), "{:?}", robot.assumptions);
    assert!((robot.mass() - 12.0).abs() < 1e-6, "the link between takes its mass of the wheel: {} kg", robot.mass());
    let steered = robot.links.iter().filter(|link| link.name.contains("FrontSteer"));
    let kinds: Vec<JointKind> = steered.filter_map(|link| Some(link.joint.as_ref()?.kind)).collect();
    assert_eq!(kinds, [JointKind::Revolute; 2]);
}

#[test]
fn sensors_and_parts_of_meshes_are_where_the_file_has_them() {
    let sensor = "<sensor name='eye' type='ray'><pose>0.2 0 0.1 0 0 0</pose><ray><scan><horizontal><samples>11</samples>\
        <min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan><range><min>0.1</min><max>5</max></range></ray></sensor>";
    let part = "<mesh><uri>parts.obj</uri><submesh><name>near</name><center>true</center></submesh></mesh>";
    let head = link("head", "0.1 0 0.4 0 0 1.5707963", 0.5, part).replace("</link>", &format!("{sensor}</link>"));
    let inside = links()
        + &joints("<axis><xyz>0 0 1</xyz></axis>")
        + &head
        + &joint("neck", "fixed", ["base", "head"], "<pose>0 0 -0.1 0 0 0</pose>")
        + DIFF;
    let cube = |name: &str, x: f64, first: usize| {
        let corner = |bits: usize| {
            let [a, b, c] = [0, 1, 2].map(|axis| f64::from(u8::from(bits >> axis & 1 == 1)) * 0.1);
            format!("v {} {b} {c}\n", x + a)
        };
        let faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"];
        let face = |face: &str| {
            let corners =
                face.split(' ').map(|corner| (corner.parse::<usize>().expect("a number") + first).to_string());
            format!("f {}\n", corners.collect::<Vec<_>>().join(" "))
        };
        format!("o {name}\n{}{}", (0..8).map(corner).collect::<String>(), faces.map(face).concat())
    };
    let parts = cube("near", 1.0, 0) + &cube("far", 9.0, 8);
    let files = Files::new(&[("robot.sdf", &model("1.6", &inside)), ("parts.obj", &parts)]);
    let imported = files.imported("robot.sdf", None);
    let eye = imported.robot.sensors.iter().find(|sensor| sensor.name == "eye").expect("a laser");
    let expected = [0.1, -0.2, -0.5];
    assert!(eye.position.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "z down: {:?}", eye.position);
    assert!((eye.direction[2] + std::f64::consts::FRAC_PI_2).abs() < 1e-6, "it looks to the left: {:?}", eye.direction);
    let head = imported.robot.links[0].solids.iter().find(|solid| solid.name == "head").expect("the part of a mesh");
    let scene::Shape::Hull { points } = &head.shape else { panic!("{:?}", head.shape) };
    assert!(points.iter().flatten().all(|at| (at.abs() - 0.05).abs() < 1e-6), "a cube around its middle: {points:?}");
    assert!((head.position[2] + 0.4).abs() < 1e-6, "{:?}", head.position);
}

#[test]
fn robots_of_a_world_are_found_by_their_names() {
    let cart = |name: &str| {
        format!(
            "<model name='{name}'><pose>3 4 0 0 0 1</pose>{}{}{DIFF}</model>",
            links(),
            joints("<axis><xyz>0 0 1</xyz></axis>")
        )
    };
    let ground =
        format!("<model name='ground'><static>1</static>{}</model>", link("l", "0 0 0 0 0 0", 1.0, "<plane/>"));
    let house = format!("<model name='house'><static>1</static>{}</model>", link("l", "0 9 0 0 0 0", 1.0, BODY));
    let include =
        "<include><uri>model://cart</uri><name>third</name></include><include><uri>model://absent</uri></include>";
    let beside = model("1.6", &(links() + &joints("<axis><xyz>0 0 1</xyz></axis>") + DIFF));
    let world = |inside: &str| format!("<sdf version='1.6'><world name='w'>{ground}{house}{inside}</world></sdf>");
    let files = Files::new(&[
        ("one.world", &world(&cart("alone"))),
        ("many.world", &world(&(cart("first") + &cart("second") + include))),
        ("none.world", &world("<include><uri>model://absent</uri></include>")),
        ("models/cart/model.sdf", &beside),
    ]);
    for (file, name) in [("one.world", None), ("many.world", Some("second")), ("many.world", Some("third"))] {
        assert_cart(&files.imported(file, name).robot, &format!("{file}, {name:?}"));
    }
    let listed = files.with("many.world", |of| sdf_robots(of).expect("robots"));
    assert_eq!(listed, ["first", "second", "third"]);
    for (file, name, words) in [
        ("many.world", None, "3 robots: name one by --model: first, second, third"),
        ("many.world", Some("secnd"), "no model `secnd` (did you mean `second`?)"),
        ("none.world", None, "no model with joints that move: expected a robot; --model names one of ground, house"),
        ("none.world", None, "note: model `model://absent` is not there"),
        ("absent.world", None, "absent.world: cannot be read"),
    ] {
        let error = files.robot(file, name).expect_err("no robot").to_string();
        assert!(error.contains(words), "{words} is not in:\n{error}");
    }
    // The map of that world has the robots as statues, but for those that are left out.
    let import = |without: &[String]| {
        let file: &Path = &files.folder.path().join("many.world");
        let import = MapImport { without, ..MapImport::new(file) };
        scene_loader::import_map(&import)
    };
    let made = import(&[]).expect("a map");
    let said = made.notes.join("\n");
    assert!(said.contains("first, second, third: `usarsim import many.world --model first"), "{said}");
    let without = import(&["second".to_owned(), "third".to_owned()]).expect("a map");
    let standing = |name: &str| without.solids.iter().any(|solid| solid.name.starts_with(name));
    assert!(standing("first") && standing("house") && !standing("second") && !standing("third"));
    let error = import(&["fourth".to_owned()]).expect_err("no such model").to_string();
    assert!(error.contains("no model `fourth` to leave out"), "{error}");
}

#[test]
fn hostile_models_are_bounded() {
    let inside = "<include><uri>model://loop</uri><name>again</name></include>".to_owned() + &links();
    let of_links = |count: usize| (0..count).map(|number| format!("<link name='l{number}'/>")).collect::<String>();
    let chain = |count: usize| {
        let joint = |number: usize| joint(&format!("j{number}"), "fixed", ["l0", &format!("l{}", number % 900)], "");
        of_links(900) + &(1..=count).map(joint).collect::<String>()
    };
    let files = Files::new(&[
        ("models/loop/model.sdf", &model("1.6", &inside)),
        ("loop.sdf", &model("1.6", &inside)),
        ("links.sdf", &model("1.6", &of_links(1001))),
        ("joints.sdf", &model("1.6", &chain(2100))),
    ]);
    let robot = files.robot("loop.sdf", Some("cart")).expect("the outer ones");
    assert!(robot.left_out.join("\n").contains("or 16 inside each other"), "{:?}", robot.left_out);
    for (file, words) in [("links.sdf", "at most 1000 links"), ("joints.sdf", "at most 2000 joints")] {
        let error = files.robot(file, Some("cart")).map(|_| ()).expect_err("too many").to_string();
        assert!(error.contains(words), "{words} is not in:\n{error}");
    }
}
