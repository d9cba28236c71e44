//! Files as they lie in public: what ROS, Gazebo and Blender read is read, and what is changed or left out is said.

use std::path::{Path, PathBuf};

use scene::{JointKind, RobotDef, Shape, Steering};
use scene_loader::{Import, ImportedMap, MapImport, Packages, import, import_map};
use tempfile::TempDir;

/// A folder with files, each with its name.
fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, content) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, content).expect("a file");
    }
    folder
}

/// A wheel of a cart: name, place, axis, limits of its joint, and its type.
struct WheelOf<'a>(&'a str, [f64; 3], &'a str, &'a str, &'a str);

impl WheelOf<'_> {
    fn text(&self) -> String {
        let Self(name, [x, y, z], axis, limit, kind) = self;
        let roll = if *axis == "0 1 0" { "1.5707963 0 0" } else { "0 1.5707963 0" };
        format!(
            "<joint name='{name}_joint' type='{kind}'><origin xyz='{x} {y} {z}'/><parent link='base'/><child link='{name}'/>\
             <axis xyz='{axis}'/>{limit}</joint>\n<link name='{name}'><inertial><mass value='1'/>\
             <inertia ixx='0.003' ixy='0' ixz='0' iyy='0.005' iyz='0' izz='0.003'/></inertial>\
             <collision><origin rpy='{roll}'/><geometry><cylinder radius='0.1' length='0.05'/></geometry></collision></link>\n"
        )
    }
}

/// The body of a cart.
const BODY: &str = "<link name='base'><inertial><origin xyz='0 0 0.1'/><mass value='10'/>\
    <inertia ixx='0.1' ixy='0' ixz='0' iyy='0.2' iyz='0' izz='0.25'/></inertial>\
    <collision><origin xyz='0 0 0.15'/><geometry><box size='0.5 0.3 0.1'/></geometry></collision></link>\n";

/// Returns a cart of a body and four wheels, with further elements.
fn cart(body: &str, limit: &str, kind: &str, more: &str) -> String {
    let places = [("fl", 0.2, 0.2), ("fr", 0.2, -0.2), ("rl", -0.2, 0.2), ("rr", -0.2, -0.2)];
    let wheels: String = places.map(|(name, x, y)| WheelOf(name, [x, y, 0.1], "0 1 0", limit, kind).text()).concat();
    format!("<?xml version=\"1.0\"?>\n<robot name='cart'>\n{body}{wheels}{more}</robot>\n")
}

fn plain(more: &str) -> String {
    cart(BODY, "", "continuous", more)
}

/// Loads a URDF as it is.
fn load(bytes: &[u8]) -> Result<RobotDef, String> {
    let folder = folder(&[("cart.urdf", bytes)]);
    scene_loader::robot(&folder.path().join("cart.urdf").display().to_string(), &[]).map_err(|error| error.to_string())
}

/// Loads a URDF, which has to be good, and has to say these words.
fn said(text: &str, words: &[&str]) -> RobotDef {
    let robot = load(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"));
    let all = robot.assumptions.join("\n");
    words.iter().for_each(|word| assert!(all.contains(word), "{word} is not in:\n{all}"));
    robot
}

fn joint<'a>(robot: &'a RobotDef, name: &str) -> &'a scene::Joint {
    let link = robot.links.iter().find(|link| link.name == name).unwrap_or_else(|| panic!("no {name}"));
    link.joint.as_ref().expect("a joint")
}

/// A further link on a joint of the body.
fn link(name: &str, joint: &str) -> String {
    format!(
        "<joint name='{name}' {joint}<parent link='base'/><child link='{name}_l'/></joint><link name='{name}_l'><inertial>\
         <mass value='0.3'/><inertia ixx='0.001' ixy='0' ixz='0' iyy='0.001' iyz='0' izz='0.001'/></inertial></link>"
    )
}

#[test]
fn xml_is_read_as_the_field_reads_it() {
    let good = plain("");
    let body = |text: &str| text.strip_prefix("<?xml version=\"1.0\"?>\n").expect("a declaration").to_owned();
    let wide = format!("<?xml version=\"1.0\" encoding=\"utf-16\"?>{}", body(&good));
    let utf16: Vec<u8> = [0xff, 0xfe].into_iter().chain(wide.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    let mut latin = "<?xml version=\"1.0\" encoding=\"iso-8859-1\"?><!-- gr".as_bytes().to_vec();
    latin.extend(b"\xfc\xdfe -->");
    latin.extend(body(&good).as_bytes());
    for bytes in [
        good.clone().into_bytes(),
        utf16,
        latin,
        format!("\n{good}").into_bytes(),
        plain("<!-- left -- right --->").into_bytes(),
        plain("<gazebo><plugin gz:name='x' ignition::name='y'/></gazebo>").into_bytes(),
        plain("<gazebo><a b='1' b='2'/></gazebo> stray text & more").into_bytes(),
        plain("<transmission><type>$(find x)</type></transmission>").into_bytes(),
    ] {
        let robot = load(&bytes).unwrap_or_else(|error| panic!("{}: {error}", String::from_utf8_lossy(&bytes)));
        assert_eq!(robot.steering, Steering::Skid);
    }
}

#[test]
fn looks_refuse_no_robot() {
    let visual = |inside: &str| BODY.replace("<collision>", &format!("<visual>{inside}</visual><collision>"));
    let of_box = "<geometry><box size='0.5 0.3 0.1'/></geometry>";
    let material = "<material name='a'><color rgba='1 0 0 1'/></material>";
    for (inside, word) in [
        (format!("{of_box}{material}<material name='b'/>"), "a second <material>"),
        (format!("{of_box}<material name='a'><color rgba='1 0'/></material>"), "a colour that is not four numbers"),
        (format!("{of_box}<material name='a'><color rgba='1 0 0'/></material>"), ""),
        (format!("{of_box}<material><color rgba='1 0 0 1'/></material>"), ""),
        ("<geometry><box size='0.5 nonsense'/></geometry>".to_owned(), "a visual that is not read"),
        ("<origin xyz='0 0'/><geometry><box size='1 1 1'/></geometry>".to_owned(), "a visual that is not read"),
        ("<geometry><torus/></geometry>".to_owned(), "a visual that is not read"),
        (String::new(), "a visual that is not read"),
    ] {
        said(&cart(&visual(&inside), "", "continuous", ""), &[word]);
    }
    let two = BODY.replace("<box size='0.5 0.3 0.1'/>", "<box size='0.5 0.3 0.1'/><box size='0.4 0.3 0.1'/>");
    let robot = said(&cart(&two, "", "continuous", ""), &["a second shape of a <geometry>"]);
    assert_eq!(robot.links[0].solids[0].shape, Shape::Box { size: [0.5, 0.3, 0.1] });
    // A wrong shape of a collision is a mistake, at its line.
    let wrong = cart(&BODY.replace("<box size='0.5 0.3 0.1'/>", "\n<torus/>"), "", "continuous", "");
    let error = load(wrong.as_bytes()).expect_err("it is wrong");
    assert!(error.contains(":4:1: shape <torus>: expected box"), "{error}");
}

#[test]
fn numbers_that_mean_none_refuse_no_robot() {
    let mast = |limit: &str| plain(&link("mast", &format!("type='revolute'><axis xyz='0 0 1'/><limit {limit}/>")));
    let robot = said(&mast("lower='-1' upper='1' effort='1e7' velocity='1e6'"), &["velocity 1000000 is taken as 1000"]);
    let motor = joint(&robot, "mast").drive.as_ref().expect("a servo");
    assert!(motor.max_speed == 1000.0 && motor.max_torque < 2e4, "{motor:?}");
    said(&mast("lower='-1' upper='1' effort='-1' velocity='-1'"), &["effort -1 is taken as"]);
    let robot = said(&mast("lower='-1' upper='1' effort='5' velocity='0'"), &["velocity 0 is taken as 3"]);
    assert_eq!(joint(&robot, "mast").drive.as_ref().expect("a servo").max_torque, 5.0);
    let robot = said(&mast("lower='-1' upper='1' effort='0' velocity='0'"), &["joint mast: free to swing"]);
    assert_eq!(joint(&robot, "mast").drive, None);
    let robot = said(&mast("lower='1' upper='-1' effort='5' velocity='1'"), &["are exchanged"]);
    assert_eq!(joint(&robot, "mast").limits, Some([-1.0, 1.0]));
    let robot =
        said(&mast("lower='-1e10' upper='1e10' effort='5' velocity='1'"), &["joint mast: limits of -10000000000 to"]);
    assert_eq!(joint(&robot, "mast").limits, Some([-100.0, 100.0]));
}

#[test]
fn a_revolute_joint_that_turns_many_times_is_a_wheel_on_the_ground() {
    for limits in ["lower='-180' upper='180'", "lower='-50' upper='50'", "lower='-1e16' upper='1e16'"] {
        let limit = format!("<limit {limits} effort='10' velocity='20'/>");
        let robot = load(cart(BODY, &limit, "revolute", "").as_bytes()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((robot.steering, robot.wheels().count()), (Steering::Skid, 4), "{limits}");
    }
    let arm =
        link("arm", "type='revolute'><axis xyz='0 0 1'/><limit lower='-6.3' upper='6.3' effort='9' velocity='1'/>");
    let robot = said(&plain(&arm), &[]);
    assert_eq!(joint(&robot, "arm").kind, JointKind::Revolute);
    assert!(joint(&robot, "arm").drive.as_ref().is_some_and(|motor| motor.stiffness.is_some()));
}

#[test]
fn a_robot_that_faces_elsewhere_is_turned_to_drive_along_its_x() {
    // Its front is at y, so its left is at -x.
    let places = [("fl", -0.2, 0.3), ("fr", 0.2, 0.3), ("rl", -0.2, -0.3), ("rr", 0.2, -0.3)];
    let wheels = places.map(|(name, x, y)| WheelOf(name, [x, y, 0.1], "1 0 0", "", "continuous").text()).concat();
    let text = format!("<robot name='r'>{BODY}{wheels}</robot>");
    let robot = said(&text, &["roll at 90 degrees to its x, so it is turned"]);
    // The robot that import writes is turned, too.
    let folder = folder(&[("r.urdf", text.as_bytes())]);
    let file = &folder.path().join("r.urdf");
    let packages = &Packages::around(file, &[], &[]).expect("packages");
    let made = import(&Import { file, text: &text, class: "R", packages, wheels: &[], drive: None })
        .unwrap_or_else(|error| panic!("{error}"));
    let written = made.files.iter().find_map(|(name, content)| match content {
        scene_loader::Content::Text(text) if name.ends_with(".urdf") => Some(text),
        _ => None,
    });
    let again = load(written.expect("a URDF").as_bytes()).unwrap_or_else(|error| panic!("{error}"));
    for robot in [robot, made.robot, again] {
        assert_eq!(robot.steering, Steering::Skid);
        for (name, place) in [("fl", [0.3, -0.2]), ("fr", [0.3, 0.2]), ("rl", [-0.3, -0.2]), ("rr", [-0.3, 0.2])] {
            let wheel = robot.wheels().find(|wheel| wheel.name == format!("{name}_joint")).expect("a wheel");
            let far = [0, 1].map(|axis| (wheel.position[axis] - place[axis]).abs());
            assert!(far.iter().all(|far| *far < 1e-9), "{name}: {:?}", wheel.position);
        }
    }
}

#[test]
fn a_wheel_about_another_axis_is_said_to_be_none() {
    let wheel = |(name, x, y): (&str, f64, f64), axis: &str| WheelOf(name, [x, y, 0.1], axis, "", "continuous").text();
    // Three axes in a star, and two that are parallel but carry no wheels of two sides.
    let star = ["1 0 0", "-0.5 0.866 0", "-0.5 -0.866 0"];
    let places = [("a", 0.2, 0.0), ("b", -0.1, 0.17), ("c", -0.1, -0.17)];
    let star: String = places.into_iter().zip(star).map(|(place, axis)| wheel(place, axis)).collect();
    let aside = [("a", 0.2, 0.1), ("b", 0.2, -0.1)].map(|place| wheel(place, "1 0 0")).concat();
    for (wheels, joints) in [(star, "joints a_joint, b_joint, c_joint"), (aside, "joints a_joint, b_joint")] {
        let text = format!("<robot name='r'>{BODY}{wheels}</robot>");
        let robot = said(&text, &[&format!("{joints}: no wheel, as")]);
        assert_eq!(robot.steering, Steering::None);
    }
}

#[test]
fn a_steering_joint_without_an_effort_steers() {
    let steer = |name: &str, y: f64| {
        format!(
            "<joint name='{name}_steer' type='revolute'><origin xyz='0.2 {y} 0.1'/><parent link='base'/><child link='{name}_k'/>\
             <axis xyz='0 0 1'/><limit lower='-0.6' upper='0.6' effort='0' velocity='0'/></joint><link name='{name}_k'><inertial>\
             <mass value='0.2'/><inertia ixx='0.001' ixy='0' ixz='0' iyy='0.001' iyz='0' izz='0.001'/></inertial></link>{}",
            WheelOf(name, [0.0, 0.0, 0.0], "0 1 0", "", "continuous")
                .text()
                .replace("link='base'", &format!("link='{name}_k'"))
        )
    };
    let rear =
        [("rl", 0.2), ("rr", -0.2)].map(|(name, y)| WheelOf(name, [-0.2, y, 0.1], "0 1 0", "", "continuous").text());
    let text = format!("<robot name='car'>{BODY}{}{}{}</robot>", steer("fl", 0.2), steer("fr", -0.2), rear.concat());
    let robot = said(&text, &["steers with"]);
    assert_eq!(robot.steering, Steering::Ackermann);
    assert!(joint(&robot, "fl_steer_FrontSteer").drive.as_ref().is_some_and(|motor| motor.max_torque > 1.0));
    // The robot that is written steers, too.
    let folder = folder(&[("car.urdf", text.as_bytes())]);
    let file = &folder.path().join("car.urdf");
    let packages = &Packages::around(file, &[], &[]).expect("packages");
    let made = import(&Import { file, text: &text, class: "Car", packages, wheels: &[], drive: None })
        .unwrap_or_else(|error| panic!("{error}"));
    let urdf = made.files.iter().find_map(|(name, content)| match content {
        scene_loader::Content::Text(text) if name.ends_with(".urdf") => Some(text),
        _ => None,
    });
    assert!(urdf.expect("a URDF").contains("velocity=\"3\""), "{urdf:?}");
}

#[test]
fn a_mimic_of_a_mimic_follows_the_leader() {
    let limits = "<axis xyz='0 0 1'/><limit lower='-3' upper='3' effort='20' velocity='5'/>";
    let follower = |name: &str, of: &str, multiplier: f64, offset: f64| {
        let mimic = format!("<mimic joint='{of}' multiplier='{multiplier}' offset='{offset}'/>");
        link(name, &format!("type='revolute'>{limits}{mimic}"))
    };
    let chain = [
        link("lead", &format!("type='revolute'>{limits}")),
        follower("g", "f", 0.5, 0.0),
        follower("f", "lead", -2.0, 0.1),
    ];
    let robot = said(&plain(&chain.concat()), &[]);
    let coupling = joint(&robot, "g").coupling.expect("a coupling");
    assert_eq!(robot.links[coupling.leader].name, "lead");
    assert!((coupling.multiplier + 1.0).abs() < 1e-12 && (coupling.offset - 0.05).abs() < 1e-12, "{coupling:?}");
    for (more, why) in [
        (follower("g", "nobody", 1.0, 0.0), "its leader is not there"),
        (follower("g", "h", 1.0, 0.0) + &follower("h", "g", 1.0, 0.0), "in a circle"),
        (link("held", "type='fixed'>") + &follower("g", "held", 1.0, 0.0), "its leader does not move"),
    ] {
        let robot = said(&plain(&more), &[why]);
        assert_eq!(joint(&robot, "g").kind, JointKind::Fixed);
    }
}

#[test]
fn a_laser_has_as_many_beams_as_its_file_says() {
    for (samples, from, to, beams) in
        [(1, -1.0, 1.0, 1), (401, -2.0, 2.0, 401), (360, 0.0, 6.2, 360), (1, 0.0, 0.0, 1), (3, -0.5, 0.5, 3)]
    {
        let scan = format!(
            "<horizontal><samples>{samples}</samples><min_angle>{from}</min_angle><max_angle>{to}</max_angle></horizontal>"
        );
        let sensor = format!(
            "<gazebo reference='base'><sensor name='scan' type='gpu_lidar'><ray><scan>{scan}</scan>\
             <range><min>0.05</min><max>8</max></range></ray></sensor></gazebo>"
        );
        let text = plain(&sensor);
        let folder = folder(&[("cart.urdf", text.as_bytes())]);
        let file = &folder.path().join("cart.urdf");
        let packages = &Packages::around(file, &[], &[]).expect("packages");
        let made = import(&Import { file, text: &text, class: "Cart", packages, wheels: &[], drive: None })
            .unwrap_or_else(|error| panic!("{error}"));
        let laser = made.robot.sensors.iter().find(|sensor| sensor.name == "scan").expect("a laser");
        let fan = laser.config.fan().expect("a fan");
        let count = (2.0 * fan.first / fan.resolution) as usize + 1;
        assert_eq!(count, beams, "{samples} from {from} to {to}: {fan:?}");
        if beams == 1 {
            assert!(fan.first.abs() < 1e-9, "{fan:?}");
        }
    }
}

/// Makes a map of a file in a folder.
fn map(folder: &TempDir, file: &str, models: &[PathBuf]) -> Result<ImportedMap, String> {
    let file = &folder.path().join(file);
    let import = MapImport { models, ..MapImport::new(file) };
    import_map(&import).map_err(|error| error.to_string())
}

/// Returns the table of a solid in a map's text.
fn table<'a>(map: &'a ImportedMap, name: &str) -> &'a str {
    let mut tables = map.text.split("\n[[");
    tables
        .find(|table| table.contains(&format!("name = \"{name}\"")))
        .unwrap_or_else(|| panic!("no {name}:\n{}", map.text))
}

const GROUND: &str = "<model name='ground'><static>1</static><link name='l'><collision name='c'><geometry><plane/></geometry></collision></link></model>";

fn crate_of(pose: &str, size: &str) -> String {
    format!(
        "<sdf version='1.6'><model name='crate'>{pose}<static>true</static><link name='l'><collision name='c'><geometry>\
         <box><size>{size}</size></box></geometry></collision></link></model></sdf>"
    )
}

fn world(inside: &str) -> String {
    format!("<sdf version='1.9'><world name='w'>{GROUND}{inside}</world></sdf>")
}

#[test]
fn the_pose_of_an_include_replaces_that_of_the_model() {
    let own = crate_of("<pose>0 0 0.5 0 0 0</pose>", "1 1 1");
    let inside = "<include><uri>model://crate</uri><name>near</name><pose>2 0 0.5 0 0 0</pose></include>\
                  <include><uri>model://crate</uri><name>own</name></include>";
    let folder = folder(&[("w.world", world(inside).as_bytes()), ("models/crate/model.sdf", own.as_bytes())]);
    let made = map(&folder, "w.world", &[]).expect("a map");
    assert!(table(&made, "near").contains("position = [2.0, 0.0, -0.5]"), "{}", made.text);
    assert!(table(&made, "own").contains("position = [0.0, 0.0, -0.5]"), "{}", made.text);
}

#[test]
fn what_every_gazebo_has_is_known_and_what_is_missing_is_a_note() {
    let inside = "<include><uri>model://sun</uri></include><include><uri>model://ground_plane</uri></include>\
                  <include><uri>https://fuel.gazebosim.org/1.0/OpenRobotics/models/Ground Plane</uri></include>\
                  <include><uri>model://nobody</uri></include><include><uri>model://nobody</uri></include><light name='x'/>\
                  <plugin name='p'/><plugin name='q'/>";
    let folder = folder(&[("w.world", world(inside).as_bytes())]);
    let made = map(&folder, "w.world", &[]).expect("a map");
    let notes = made.notes.join("\n");
    assert_eq!(made.solids.len(), 3, "{}", made.text);
    for word in ["`model://nobody` (2 times)", "--models", "<light> is left out", "<plugin> is left out (2 times)"] {
        assert!(notes.contains(word), "{word} is not in {notes}");
    }
    let file = &folder.path().join("w.world");
    let import = MapImport { is_strict: true, ..MapImport::new(file) };
    let error = import_map(&import).expect_err("it is strict").to_string();
    assert!(error.contains("`model://nobody` is not there"), "{error}");
}

#[test]
fn models_are_found_where_packages_and_caches_have_them() {
    let own = crate_of("", "1 2 1");
    let config = "<model><name>c</name><sdf version='1.4'>old.sdf</sdf><sdf version='1.10'>new.sdf</sdf></model>";
    let inside = |uri: &str| world(&format!("<include><uri>{uri}</uri></include>"));
    let files: [(&str, Vec<u8>); 8] = [
        ("models/one/model.sdf", own.clone().into_bytes()),
        ("elsewhere/two/model.config", config.into()),
        ("elsewhere/two/new.sdf", own.clone().into_bytes()),
        ("elsewhere/two/old.sdf", crate_of("", "9 9 9").into_bytes()),
        ("elsewhere/big crate/3/model.sdf", own.clone().into_bytes()),
        ("elsewhere/big crate/12/model.sdf", own.into_bytes()),
        ("pkg/worlds/deep/near.world", inside("model://one").into_bytes()),
        ("pkg/models/three/model.sdf", crate_of("", "1 2 1").into_bytes()),
    ];
    let listed: Vec<(&str, &[u8])> = files.iter().map(|(name, content)| (*name, content.as_slice())).collect();
    let folder = folder(&listed);
    for uri in [
        "model://one",
        "model://three",
        "package://pkg/models/three",
        "model://two",
        "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Big%20Crate",
        "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Big Crate/12",
    ] {
        std::fs::write(folder.path().join("pkg/worlds/deep/near.world"), inside(uri)).expect("a file");
        let made = map(&folder, "pkg/worlds/deep/near.world", &[folder.path().join("elsewhere")]).expect("a map");
        assert!(table(&made, "crate").contains("size = [1.0, 2.0, 1.0]"), "{uri}: {:?}", made.notes);
    }
}

#[test]
fn frames_submeshes_and_surfaces_count() {
    let inside = "<frame name='dock'><pose>4 1 0 0 0 1.5707963267948966</pose></frame><frame name='far' attached_to='dock'><pose>1 0 0 0 0 0</pose></frame>\
        <model name='post'><static>true</static><pose relative_to='dock'>1 0 0.5 0 0 0</pose><link name='l'><collision name='c'><geometry>\
        <box><size>0.2 0.4 1</size></box></geometry></collision></link></model>\
        <model name='next'><static>true</static><pose relative_to='far'/><link name='a'><pose>0 0 1 0 0 0</pose></link>\
        <link name='b'><pose relative_to='a'>0 0 1 0 0 0</pose><collision name='c'><geometry><sphere><radius>0.5</radius></sphere></geometry></collision></link></model>\
        <model name='placed' placement_frame='top'><static>true</static><pose>0 0 3 0 0 0</pose><link name='top'><pose>0 0 1 0 0 0</pose></link><link name='l'><collision name='c'>\
        <geometry><sphere><radius>0.5</radius></sphere></geometry></collision></link></model>\
        <model name='slick'><static>true</static><link name='l'><collision name='c'><geometry><box><size>1 1 1</size></box></geometry>\
        <surface><friction><ode><mu>0.1</mu><mu2>0.1</mu2></ode></friction></surface></collision></link></model>\
        <model name='door'><static>true</static><link name='l'><collision name='c'><geometry><mesh><uri>two.obj</uri><submesh><name>Left</name></submesh></mesh></geometry></collision></link></model>";
    let two = "o Left\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no Right\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 4 5 6\n";
    let folder = folder(&[("w.sdf", world(inside).as_bytes()), ("two.obj", two.as_bytes())]);
    let made = map(&folder, "w.sdf", &[]).expect("a map");
    // z is down, and y to the right.
    assert!(table(&made, "post").contains("position = [4.0, -2.0, -0.5]"), "{}", made.text);
    assert!(table(&made, "next").contains("position = [4.0, -2.0, -2.0]"), "{}", made.text);
    assert!(table(&made, "placed").contains("position = [0.0, 0.0, -2.0]"), "{}", made.text);
    assert!(table(&made, "slick").contains("material = \"friction-0.1\""), "{}", made.text);
    assert!(made.text.contains("[material.\"friction-0.1\"]\nfriction = 0.1\n"), "{}", made.text);
    let door = made.solids.iter().find(|solid| solid.name == "door").expect("a door");
    assert_eq!(door.triangles, 1);
    for (pose, why) in
        [("<pose relative_to='nobody'/>", "no frame `nobody`"), ("<pose>1 2</pose>", "a pose that is not")]
    {
        let text = world(&format!("<model name='m'>{pose}<link name='l'/></model>"));
        std::fs::write(folder.path().join("w.sdf"), text).expect("a file");
        let error = map(&folder, "w.sdf", &[]).expect_err("it is wrong");
        assert!(error.contains(why), "{error}");
    }
    let circle = "<frame name='a' attached_to='b'/><frame name='b' attached_to='a'/><model name='m'><pose relative_to='a'/><link name='l'/></model>";
    std::fs::write(folder.path().join("w.sdf"), world(circle)).expect("a file");
    assert!(map(&folder, "w.sdf", &[]).expect_err("a circle").contains("in a circle"));
}

/// A box from 2.5, -0.5, 0 to 3.5, 0.5, 1 in COLLADA with a primitive; the scene and its node have one id.
fn collada(primitive: &str) -> String {
    format!(
        "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'><asset><unit meter='1'/></asset>\
         <library_geometries><geometry id='g'><mesh><source id='p'><float_array id='pa' count='24'>2.5 -0.5 0 2.5 -0.5 1 2.5 0.5 0 \
         2.5 0.5 1 3.5 -0.5 0 3.5 -0.5 1 3.5 0.5 0 3.5 0.5 1</float_array><technique_common><accessor source='#pa' count='8' stride='3'/>\
         </technique_common></source><vertices id='v'><input semantic='POSITION' source='#p'/></vertices>{primitive}</mesh></geometry>\
         </library_geometries><library_visual_scenes><visual_scene id='Crate'><node id='Crate' name='Crate'><instance_geometry url='#g'/>\
         </node></visual_scene></library_visual_scenes><scene><instance_visual_scene url='#Crate'/></scene></COLLADA>"
    )
}

#[test]
fn what_a_body_does_otherwise_in_gazebo_is_a_note() {
    let body = |name: &str, link: &str, surface: &str| {
        format!(
            "<model name='{name}'><link name='l'>{link}<collision name='c'><geometry><box><size>1 1 1</size></box></geometry>\
             <surface>{surface}</surface></collision></link></model>"
        )
    };
    for (link, surface, note, stays, moves) in [
        ("<gravity>false</gravity>", "", "a body that does not fall stands fast", true, false),
        ("<kinematic>1</kinematic>", "", "a body that does not fall stands fast", true, false),
        ("<gravity>1</gravity>", "", "", true, true),
        ("<inertial><pose>0 0 0.3 0 0 0</pose><mass>2</mass></inertial>", "", "a centre of mass aside", true, true),
        (
            "",
            "<contact><collide_bitmask>0x00</collide_bitmask></contact>",
            "a shape that touches nothing",
            false,
            false,
        ),
        ("", "<contact><collide_bitmask>0x02</collide_bitmask></contact>", "", true, true),
        ("", "<friction><ode><slip1>0.1</slip1></ode></friction>", "slip and softness", true, true),
        ("", "<friction><ode><slip1>0</slip1></ode></friction>", "", true, true),
    ] {
        let folder = folder(&[("w.sdf", world(&body("thing", link, surface)).as_bytes())]);
        let made = map(&folder, "w.sdf", &[]).expect("a map");
        let thing = made.solids.iter().find(|solid| solid.name == "thing");
        assert_eq!(thing.map(|thing| thing.is_movable), stays.then_some(moves), "{link}{surface}");
        let is_said =
            if note.is_empty() { made.notes.is_empty() } else { made.notes.iter().any(|it| it.contains(note)) };
        assert!(is_said, "{link}{surface}: {:?}", made.notes);
    }
}

#[test]
fn a_height_map_is_ground_with_the_first_row_of_its_picture_at_the_left() {
    // A peak in the first row and the last column, which is at the left (+y) and ahead (+x).
    let mut picture = Vec::new();
    let mut encoder = png::Encoder::new(&mut picture, 3, 3);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header().expect("a picture");
    writer.write_image_data(&[0, 0, 255, 0, 51, 0, 0, 0, 0]).expect("a picture");
    drop(writer);
    let ground = |uri: &str| {
        format!(
            "<model name='hill'><static>1</static><link name='l'><collision name='c'><geometry><heightmap><uri>{uri}</uri>\
             <size>8 4 2</size><pos>10 0 1</pos></heightmap></geometry></collision></link></model>"
        )
    };
    let models = ground("file://media/hill.png") + &ground("model://media/hill.tif");
    let folder =
        folder(&[("hill.world", world(&models).as_bytes()), ("media/hill.png", &picture), ("media/hill.tif", b"II")]);
    let made = map(&folder, "hill.world", &[]).expect("a map");
    assert!(made.notes.iter().any(|note| note.starts_with("height map `hill.tif` is left out")), "{:?}", made.notes);
    let file = folder.path().join("map.toml");
    for (name, content) in &made.meshes {
        std::fs::write(folder.path().join(name), content).expect("a mesh");
    }
    let start = "\n[[start]]\nname = \"s\"\nposition = [0.0, 0.0, -3.0]\n";
    std::fs::write(&file, made.text + start).expect("a map");
    let def = scene_loader::map(&file.display().to_string(), &[]).unwrap_or_else(|error| panic!("{error}"));
    let hill = def.solids.iter().find(|solid| solid.name == "hill").expect("a hill");
    let Shape::Mesh { vertices, triangles } = &hill.shape else { panic!("{:?}", hill.shape) };
    let highest = vertices.iter().min_by(|a, b| a[2].total_cmp(&b[2])).expect("corners");
    let pose = hill.pose();
    let top = pose * nalgebra::Point3::from(*highest);
    // z is down, and y to the right.
    let far = [top.x - 14.0, top.y + 2.0, top.z + 3.0].map(f64::abs);
    assert!(triangles.len() == 8 && far.iter().all(|far| *far < 1e-5), "{top}: {vertices:?}");
    assert!(vertices.iter().any(|vertex| (vertex[2] + 0.4).abs() < 1e-5), "{vertices:?}");
}

#[test]
fn meshes_of_every_exporter_are_the_same_box() {
    let input = "<input semantic='VERTEX' source='#v' offset='0'/>";
    let polygons = ["0 1 3 2", "4 6 7 5", "0 4 5 1", "2 3 7 6", "0 2 6 4", "1 5 7 3"];
    let fans: String = polygons.iter().map(|p| format!("<p>{p}</p>")).collect();
    let list =
        format!("<polylist count='6'>{input}<vcount>4 4 4 4 4 4</vcount><p>{}</p></polylist>", polygons.join(" "));
    let strips =
        format!("<tristrips count='3'>{input}<p>0 1 2 3 6 7 4 5 0 1</p><p>1 5 3 7</p><p>0 2 4 6</p></tristrips>");
    let corners = [
        [2.5, -0.5, 0.0],
        [2.5, -0.5, 1.0],
        [2.5, 0.5, 0.0],
        [2.5, 0.5, 1.0],
        [3.5, -0.5, 0.0],
        [3.5, -0.5, 1.0],
        [3.5, 0.5, 0.0],
        [3.5, 0.5, 1.0_f32],
    ];
    let quads: [[usize; 4]; 6] = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles: Vec<[usize; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mut binary = b"solid made by an exporter".to_vec();
    binary.resize(80, b' ');
    binary.extend((triangles.len() as u32).to_le_bytes());
    let mut text = "SOLID x y\n".to_owned();
    for triangle in &triangles {
        binary.extend([0; 12]);
        text += "FACET NORMAL 0 0 0\nOUTER LOOP\n";
        for corner in triangle.map(|it| corners[it]) {
            corner.iter().for_each(|part| binary.extend(part.to_le_bytes()));
            text += &format!("VERTEX {:E} {} {}\n", corner[0], corner[1], corner[2]);
        }
        binary.extend([0; 2]);
        text += "ENDLOOP\nENDFACET\n";
    }
    let mut obj: String = corners.iter().map(|[x, y, z]| format!("v {x} {y} {z} 0.5 0.5 0.5\n")).collect();
    for [a, b, c, d] in quads {
        obj += &format!("f {}/1 \\\n {}/2 {}/3 {}/4\n", a as i32 - 8, b + 1, c + 1, d + 1);
    }
    let files: [(&str, Vec<u8>); 7] = [
        ("same-id.dae", collada(&list).into_bytes()),
        ("polygons.dae", collada(&format!("<polygons count='6'>{input}{fans}</polygons>")).into_bytes()),
        ("fans.dae", collada(&format!("<trifans count='6'>{input}{fans}</trifans>")).into_bytes()),
        ("strips.dae", collada(&strips).into_bytes()),
        ("binary.stl", binary),
        ("upper.stl", text.into_bytes()),
        ("spec.obj", obj.into_bytes()),
    ];
    let listed: Vec<(&str, &[u8])> = files.iter().map(|(name, content)| (*name, content.as_slice())).collect();
    let folder = folder(&listed);
    for (name, _) in &files {
        let made = map(&folder, name, &[]).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(
            made.text.contains("size = [1.0, 1.0, 1.0]") && made.text.contains("position = [3.0, 0.0, -0.5]"),
            "{name}: {}",
            made.text
        );
        if name.ends_with(".dae") {
            assert_eq!(made.solids[0].name, "Crate", "{name}");
        }
    }
}

#[test]
fn gltf_is_read_whose_positions_are_in_it_quantised_or_sparse() {
    let quads: [[u16; 4]; 6] = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let indices: Vec<u8> =
        quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).flat_map(u16::to_le_bytes).collect();
    // x ahead, y up, z to the right: a box of 1 x 2 x 0.5 m.
    let corner = |bits: usize| [2.5 + (bits >> 2) as f32, 2.0 * (bits & 1) as f32, 0.25 - 0.5 * (bits >> 1 & 1) as f32];
    let floats: Vec<u8> = (0..8).flat_map(corner).flat_map(f32::to_le_bytes).collect();
    let shorts: Vec<u8> = (0..8)
        .flat_map(|bits| corner(bits).map(|part| (part * 1000.0) as i16).into_iter().chain([0]))
        .flat_map(i16::to_le_bytes)
        .collect();
    let text = |positions: usize, accessor: &str, view: &str, node: &str, buffer: &str, more: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"name":"Crate","mesh":0{node}}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
            "accessors":[{{"count":8,"type":"VEC3",{accessor}}},{{"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}}],
            "bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{positions}{view}}},{{"buffer":0,"byteOffset":{positions},"byteLength":72}}],
            "buffers":[{{"byteLength":{},{buffer}}}]{more}}}"#,
            positions + 72
        )
    };
    let of_floats = "\"bufferView\":0,\"componentType\":5126";
    let base64 = |bytes: &[u8]| {
        let letters: Vec<char> = ('A'..='Z').chain('a'..='z').chain('0'..='9').chain(['+', '/']).collect();
        let group = |chunk: &[u8]| {
            let bits = chunk.iter().fold(0_u32, |bits, byte| bits << 8 | u32::from(*byte)) << (8 * (3 - chunk.len()));
            let digits = (0..4).map(|digit| letters[(bits >> (18 - 6 * digit) & 63) as usize]);
            digits.take(chunk.len() + 1).chain(std::iter::repeat_n('=', 3 - chunk.len())).collect::<String>()
        };
        bytes.chunks(3).map(group).collect::<String>()
    };
    let embedded = format!(
        "\"uri\":\"data:application/octet-stream;base64,{}\"",
        base64(&[floats.clone(), indices.clone()].concat())
    );
    let sparse = r#""componentType":5126,"sparse":{"count":8,"indices":{"bufferView":2,"componentType":5121},"values":{"bufferView":0}}"#;
    let sparse_text = text(96, sparse, "", "", "\"uri\":\"with%20order.bin\"", "")
        .replace("\"byteLength\":72}]", "\"byteLength\":72},{\"buffer\":0,\"byteOffset\":168,\"byteLength\":8}]")
        .replace("\"byteLength\":168,", "\"byteLength\":176,");
    let quantised =
        r#","extensionsUsed":["KHR_mesh_quantization","KHR_x"],"extensionsRequired":["KHR_mesh_quantization","KHR_x"]"#;
    let files: [(&str, Vec<u8>); 6] = [
        ("embedded.gltf", text(96, of_floats, "", "", &embedded, "").into_bytes()),
        (
            "quantised.gltf",
            text(
                64,
                "\"bufferView\":0,\"componentType\":5122",
                ",\"byteStride\":8",
                ",\"scale\":[0.001,0.001,0.001]",
                "\"uri\":\"short.bin\"",
                quantised,
            )
            .into_bytes(),
        ),
        ("sparse.gltf", sparse_text.into_bytes()),
        ("short.bin", [shorts, indices.clone()].concat()),
        ("with order.bin", [floats, indices, (0..8).collect()].concat()),
        (
            "draco.gltf",
            text(
                96,
                of_floats,
                "",
                "",
                "\"uri\":\"with order.bin\"",
                r#","extensionsRequired":["KHR_draco_mesh_compression"]"#,
            )
            .into_bytes(),
        ),
    ];
    let listed: Vec<(&str, &[u8])> = files.iter().map(|(name, content)| (*name, content.as_slice())).collect();
    let folder = folder(&listed);
    for name in ["embedded.gltf", "quantised.gltf", "sparse.gltf"] {
        let made = map(&folder, name, &[]).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(
            made.text.contains("size = [1.0, 0.5, 2.0]") && made.text.contains("position = [3.0, 0.0, -1.0]"),
            "{name}: {}",
            made.text
        );
    }
    let error = map(&folder, "draco.gltf", &[]).expect_err("it is compressed");
    assert!(error.contains("compressed by Draco"), "{error}");
}

#[test]
fn the_cases_that_the_field_reported_are_read() {
    let Some(captures) = std::env::var_os("USARSIM_CAPTURES") else {
        return eprintln!("not tested: USARSIM_CAPTURES is not set");
    };
    let cases = Path::new(&captures).parent().expect("a folder").join("cases");
    if !cases.is_dir() {
        return eprintln!("not tested: there is no {}", cases.display());
    }
    let mut urdfs = Vec::new();
    for case in std::fs::read_dir(&cases).expect("cases").flatten() {
        let files = std::fs::read_dir(case.path()).into_iter().flatten().flatten().map(|file| file.path());
        urdfs.extend(files.filter(|file| file.extension().is_some_and(|ending| ending == "urdf")));
    }
    // The mesh of one is made by a program.
    urdfs.retain(|file| !file.ends_with("fine-meshes.urdf"));
    assert!(urdfs.len() > 8, "{urdfs:?}");
    for file in urdfs {
        scene_loader::robot(&file.display().to_string(), &[]).unwrap_or_else(|error| panic!("{error}"));
    }
}
