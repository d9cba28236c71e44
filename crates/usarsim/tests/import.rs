//! `usarsim import`: robots from description packages of ROS.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use scene::{Footing, JointKind, RobotDef, Steering};
use scene_loader::{Content, Import, Imported, Packages};
use sim_core::{Options, World};
use system_tests::{apply, init, run};

fn packages() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/packages")
}

/// Runs `usarsim import FILE ...` in a folder.
fn import(folder: &Path, file: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_usarsim"));
    command.arg("import").arg(file).args(arguments).current_dir(folder);
    command.env_remove("ROS_PACKAGE_PATH").env_remove("AMENT_PREFIX_PATH");
    // `PATH=.. cargo test` would build every crate anew that depends on Python.
    if let (Some(xacro), Some(path)) = (std::env::var_os("XACRO_FOLDER"), std::env::var_os("PATH")) {
        let folders = std::iter::once(PathBuf::from(xacro)).chain(std::env::split_paths(&path));
        command.env("PATH", std::env::join_paths(folders).expect("folders"));
    }
    command.output().expect("usarsim runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Imports a package by the program, loads the folder, and returns a world with that class, and what was said.
fn imported(file: &str, class: &str, arguments: &[&str]) -> (World, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let output = import(folder.path(), &packages().join(file), &[&["--class", class], arguments].concat());
    let said = text(&output.stdout);
    assert!(output.status.success(), "{said}{}", text(&output.stderr));
    let robot = folder.path().join(class).join("robot.toml");
    scene_loader::check(&robot).unwrap_or_else(|error| panic!("{error}"));
    let scene = scene_loader::load("smooth", &[&robot]).unwrap_or_else(|error| panic!("{error}"));
    (World::new(scene, Options::default()), said)
}

fn assert_said(said: &str, expected: &[&str]) {
    for part in expected {
        assert!(said.contains(part), "{part}:\n{said}");
    }
}

/// Spawns the robot, waits until it stands, drives, and returns how far it came and how much it turned.
fn drives(world: &mut World, class: &str, left: f64, right: f64) -> (f64, f64) {
    let robot = init(world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,0}}"));
    run(world, 1.0);
    let before = world.snapshot().robots[0].body.pose;
    assert!(before.rotation.angle() < 0.03, "it stands: {before}");
    apply(world, robot, &format!("DRIVE {{Left {left}}} {{Right {right}}}"));
    run(world, 2.0);
    let after = world.snapshot().robots[0].body.pose;
    ((before.inverse() * after).translation.x, (before.rotation.inverse() * after.rotation).euler_angles().2)
}

#[test]
fn a_package_becomes_a_robot_that_drives() {
    let (mut world, said) = imported("cart/urdf/cart.urdf", "Cart", &[]);
    assert_said(
        &said,
        &[
            "Cart/robot.toml\nCart/robot.urdf\nCart/meshes/wheel.obj\n",
            "guessed: steered by the sides of its wheels; its driven wheels are front_left_joint, front_right_joint",
            "guessed: actuators are chains of joints with servos: mast (2 joints)",
            "replaced: link front_left_wheel: no mass: it gets 1.000 kg and is a box of 0.200 x 0.050 x 0.200 m",
            "replaced: link mast: `inertia` has the principal moments 0, 0 and 0 kg m²: it gets that of a box of 0.040 x 0.040 x 0.200 m",
            "replaced: link head: `inertia` has the principal moments 0.001, 0.001 and 0.009 kg m²",
            "replaced: link left: its mass of 0.00001 kg is taken as 0.000121 kg, as others are heavy",
            "replaced: link right: no mass: it gets 0.010 kg",
            "left out: mesh `package://cart_description/meshes/absent.stl`: no such file",
            "package `other_description` is not found: name its folder by --package other_description=FOLDER",
            "left out: link head: a colliding shape: a hull of 4 points in one plane: expected a volume",
            "left out: joint mast_pan: a second <limit>, as the first counts",
            "left out: 1 <gazebo> not used",
            "Cart: skid, 17.0 kg, 4 driven wheels, 0 casters, 4 joints",
        ],
    );
    let def = &world.def().robots["Cart"];
    let joint = |name: &str| def.links.iter().find(|link| link.name == name).and_then(|link| link.joint.as_ref());
    assert_eq!(joint("mast_pan").and_then(|joint| joint.limits), Some([-1.0, 1.0]));
    assert!(joint("right_finger").is_some_and(|joint| joint.coupling.is_some()));
    let wheel = def.wheels().next().expect("a wheel");
    assert!((wheel.radius - 0.1).abs() < 1e-6 && (wheel.width - 0.05).abs() < 1e-6, "{wheel:?}");
    let (ahead, turned) = drives(&mut world, "Cart", 4.0, 4.0);
    assert!((ahead - 0.8).abs() < 0.05 && turned.abs() < 0.01, "{ahead} m, {turned} rad");
}

#[test]
#[ignore = "needs Python's xacro"]
fn a_xacro_file_is_expanded_with_its_arguments_and_its_casters_roll() {
    let (mut world, said) = imported("rover/urdf/rover.urdf.xacro", "Rover", &["radius:=0.06"]);
    assert_said(
        &said,
        &[
            "guessed: rear_caster_joint is a caster, a ball of 0.0300 m that turns freely",
            "guessed: front_caster is a caster, a ball of 0.0200 m that turns freely",
            "left out: package `camera_description` is not found, so its files are not included",
            "left out: mesh `package://camera_description/meshes/camera.stl`: package `camera_description` is not found",
            "Rover: skid, 7.2 kg, 2 driven wheels, 2 casters, 0 joints",
        ],
    );
    let (ahead, _) = drives(&mut world, "Rover", 5.0, 5.0);
    assert!((ahead - 0.6).abs() < 0.03, "{ahead} m");
    let (mut world, _) = imported("rover/urdf/rover.urdf.xacro", "Rover", &[]);
    let (ahead, turned) = drives(&mut world, "Rover", 2.0, -2.0);
    // Wheels of 0.08 m, 0.3 m apart.
    let expected = 2.0 * 2.0 * 2.0 * 0.08 / 0.3;
    assert!((turned / expected - 1.0).abs() < 0.05, "{turned} rad of {expected}, {ahead} m");
}

#[test]
fn a_xacro_file_without_xacro_says_what_to_install() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = packages().join("rover/urdf/rover.urdf.xacro");
    let mut command = Command::new(env!("CARGO_BIN_EXE_usarsim"));
    command.args(["import", "--class", "Rover"]).arg(file).current_dir(folder.path()).env("PATH", folder.path());
    let output = command.output().expect("usarsim runs");
    assert_eq!(output.status.code(), Some(1));
    assert_said(&text(&output.stderr), &["pip install xacro"]);
    assert!(!folder.path().join("Rover").exists());
}

/// A folder with modules of Python's names, each of which leaves a trace. No import runs one.
#[test]
fn programs_of_the_folder_one_stands_in_are_not_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let trace = at("trace");
    for module in ["json", "xacro", "resource", "types", "site", "sitecustomize", "yaml"] {
        let code = format!("open({:?}, 'a').write({module:?})\n", trace.display().to_string());
        std::fs::write(at(&format!("{module}.py")), code).expect("a module");
    }
    let program = format!("#!/bin/sh\necho python3 >> {}\n", trace.display());
    std::fs::write(at("python3"), program).expect("a program");
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(at("python3"), mode).expect("a program");
    let cart = std::fs::read_to_string(packages().join("cart/urdf/cart.urdf")).expect("a URDF");
    let declared = cart.replacen("<robot ", "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\" ", 1);
    let used = declared.replacen("<link ", "<xacro:property name=\"x\" value=\"1\"/><link ", 1);
    let path = |more: &str| format!("{more}:{}", std::env::var("PATH").unwrap_or_default());
    let own = folder.path().display().to_string();
    let runs: [(&str, &str, &str, &[i32]); 7] = [
        ("plain.urdf", &format!("{cart}<!-- ${{5}} -->"), "", &[0]),
        ("declared.urdf", &declared, "", &[0]),
        ("undeclared.urdf", &cart.replacen("0.3", "${0.3}", 1), "", &[65]),
        // Without xacro on this machine, 1; with it the file is good.
        ("used.urdf", &used, "", &[0, 1]),
        ("used.xacro", &used, "", &[0, 1]),
        ("empty.xacro", &used, ":", &[0, 1]),
        ("own.xacro", &used, &own, &[0, 1]),
    ];
    for (number, (name, text, python_path, codes)) in runs.into_iter().enumerate() {
        std::fs::write(at(name), text).expect("a file");
        let mut command = Command::new(env!("CARGO_BIN_EXE_usarsim"));
        command.args(["import", name, "--class", &format!("Robot{number}")]).current_dir(folder.path());
        command.env("PYTHONPATH", python_path).env("PATH", path(if number % 2 == 0 { "" } else { "." }));
        let output = command.output().expect("usarsim runs");
        let code = output.status.code().expect("an exit code");
        assert!(codes.contains(&code), "{name}: {code}: {}", text_of(&output));
        let ran = std::fs::read_to_string(&trace).unwrap_or_default();
        assert_eq!(ran, "", "{name}");
    }
}

fn text_of(output: &Output) -> String {
    text(&output.stdout) + &text(&output.stderr)
}

/// The user's packages and absolute folders of PYTHONPATH hold a module `xacro` that prints a URDF.
#[test]
fn xacro_of_the_user_and_of_ros_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let base = folder.path().join("base");
    let asked = Command::new("python3")
        .args(["-c", "import site; print(site.getusersitepackages())"])
        .env("PYTHONUSERBASE", &base)
        .output();
    let Ok(asked) = asked else { return eprintln!("not tested: there is no python3") };
    let of_user = PathBuf::from(text(&asked.stdout).trim());
    let of_ros = folder.path().join("ros");
    let urdf = std::fs::read_to_string(packages().join("cart/urdf/cart.urdf")).expect("a URDF");
    let module = format!("import yaml\ndef parse():\n  pass\ndef main():\n  print({urdf:?})\n");
    for (number, (modules, variable)) in [(&of_user, "PYTHONUSERBASE"), (&of_ros, "PYTHONPATH")].into_iter().enumerate()
    {
        std::fs::create_dir_all(modules).expect("a folder");
        std::fs::write(modules.join("xacro.py"), &module).expect("a module");
        std::fs::write(modules.join("yaml.py"), "").expect("a module");
        let value = if variable == "PYTHONPATH" { modules } else { &base };
        let class = format!("Cart{number}");
        let work = folder.path().join(&class).join("work");
        std::fs::create_dir_all(&work).expect("a folder");
        let file = folder.path().join("cart.xacro");
        std::fs::write(&file, "<robot/>").expect("a file");
        let mut command = Command::new(env!("CARGO_BIN_EXE_usarsim"));
        command.arg("import").arg(&file).args(["--class", &class]).current_dir(&work);
        command.env_remove("PYTHONPATH").env_remove("PYTHONUSERBASE").env(variable, value);
        let output = command.output().expect("usarsim runs");
        assert!(output.status.success(), "{variable}: {}", text_of(&output));
        std::fs::remove_file(modules.join("xacro.py")).expect("a module");
    }
}

#[test]
#[ignore = "needs Python's xacro"]
fn hostile_xacro_files_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let robot =
        |content: &str| format!("<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">{content}</robot>");
    let file = folder.path().join("hostile.urdf.xacro");
    for (content, expected) in [
        ("<xacro:include filename=\"hostile.urdf.xacro\"/>", "xacro: "),
        ("<xacro:macro name=\"m\"><xacro:m/></xacro:macro><xacro:m/>", "xacro: "),
        ("<link name=\"${'x' * 5000000}\"/>", "xacro makes more than 4194304 bytes: expected a smaller robot"),
        ("<link name=\"${1 / 0}\"/>", "xacro: error: division by zero"),
    ] {
        std::fs::write(&file, robot(content)).expect("a file");
        let output = import(folder.path(), &file, &["--class", "Hostile"]);
        assert_eq!(output.status.code(), Some(65), "{content}");
        assert_said(&text(&output.stderr), &[expected]);
        assert!(!folder.path().join("Hostile").exists());
    }
}

#[test]
fn mistakes_have_their_exit_codes_and_leave_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let cart = packages().join("cart/urdf/cart.urdf");
    let broken = folder.path().join("broken.urdf");
    std::fs::write(&broken, "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/></robot>").expect("a file");
    let absent = folder.path().join("absent.urdf");
    let check = |file: &Path, arguments: &[&str], code: i32, expected: &str| {
        let before = std::fs::read_dir(folder.path()).expect("a folder").count();
        let output = import(folder.path(), file, arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", text(&output.stderr));
        assert_said(&text(&output.stderr), &[expected]);
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), before, "{arguments:?}");
    };
    check(&cart, &[], 2, "--class");
    check(&cart, &["--class", "a/b"], 2, "expected 1 to 64 letters");
    check(&cart, &["--class", ".."], 2, "expected 1 to 64 letters");
    check(&cart, &["--class", "p3at"], 2, "a built-in robot has this name");
    check(&cart, &["--class", "Cart", "radius:=1"], 2, "expected arguments of a xacro file only");
    check(&cart, &["--class", "Cart", "radius"], 2, "expected NAME:=VALUE");
    check(&cart, &["--class", "Cart", "--package", "other"], 2, "expected NAME=FOLDER");
    check(&cart, &["--class", "Cart", "--package", "other=nowhere"], 65, "nowhere: cannot be read");
    check(&absent, &["--class", "Cart"], 65, "absent.urdf: cannot be read");
    check(&broken, &["--class", "Cart"], 65, "broken.urdf:1:1: 2 links without a parent");
    std::fs::create_dir(folder.path().join("Cart")).expect("a folder");
    check(&cart, &["--class", "Cart"], 1, "Cart: exists already");
    assert_eq!(std::fs::read_dir(folder.path().join("Cart")).expect("a folder").count(), 0);
    let output = import(folder.path(), &cart, &["--class", "Json", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((json["steering"].as_str(), json["wheels"].as_array().map(Vec::len)), (Some("skid"), Some(4)));
    assert_eq!(json["files"][2], "Json/meshes/wheel.obj");
}

/// Imports a variant of a URDF of the cart's package. What is made loads.
fn variant(urdf: &str) -> Result<Imported, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let package = folder.path().join("src/cart_ws");
    for (from, to) in
        [("package.xml", "package.xml"), ("meshes/wheel.obj", "meshes/wheel.obj"), ("package.xml", "urdf/secret.stl")]
    {
        let to = package.join(to);
        std::fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
        std::fs::copy(packages().join("cart").join(from), to).expect("a copy");
    }
    std::fs::copy(packages().join("cart/meshes/wheel.obj"), folder.path().join("outside.obj")).expect("a copy");
    let file = package.join("urdf/robot.urdf");
    std::fs::write(&file, urdf).expect("a file");
    let packages = Packages::around(&file, &[], &[]).map_err(|error| error.to_string())?;
    let imported = scene_loader::import(&Import {
        file: &file,
        text: urdf,
        class: "Variant",
        packages: &packages,
        wheels: &[],
        drive: None,
    })
    .map_err(|error| error.to_string())?;
    let made = folder.path().join("Variant");
    std::fs::create_dir_all(made.join("meshes")).expect("a folder");
    for (name, content) in &imported.files {
        let written = match content {
            Content::Text(text) => std::fs::write(made.join(name), text),
            Content::CopyOf(path) => std::fs::copy(path, made.join(name)).map(drop),
        };
        written.expect("a file");
    }
    let RobotDef { steering, footing, .. } =
        scene_loader::robot(&made.join("robot.toml").display().to_string(), &[]).map_err(|error| error.to_string())?;
    assert_eq!((steering, footing), (imported.robot.steering, imported.robot.footing));
    Ok(imported)
}

/// A base with four wheels whose links have this name.
fn base(wheel: &str, extra: &str) -> String {
    let mut text = "<robot name=\"base\"><link name=\"base\"><inertial><mass value=\"20\"/><inertia ixx=\"0.5\" ixy=\"0\" ixz=\"0\" \
                    iyy=\"0.8\" iyz=\"0\" izz=\"1\"/></inertial><collision><geometry><box size=\"0.6 0.3 0.1\"/></geometry></collision></link>"
        .to_owned();
    for (name, x, y) in [("a", -0.2, 0.2), ("b", -0.2, -0.2), ("c", 0.2, 0.2), ("d", 0.2, -0.2)] {
        text += &format!(
            "<joint name=\"{name}\" type=\"continuous\"><origin xyz=\"{x} {y} 0\"/><parent link=\"base\"/>\
             <child link=\"{wheel}_{name}\"/><axis xyz=\"0 1 0\"/></joint><link name=\"{wheel}_{name}\"><inertial>\
             <mass value=\"1\"/><inertia ixx=\"3e-3\" ixy=\"0\" ixz=\"0\" iyy=\"5e-3\" iyz=\"0\" izz=\"3e-3\"/></inertial>\
             <collision><origin rpy=\"1.5707963 0 0\"/><geometry><cylinder radius=\"0.1\" length=\"0.05\"/></geometry></collision></link>"
        );
    }
    text + extra + "</robot>"
}

#[test]
fn wheels_are_told_from_other_joints() {
    let check = |urdf: &str, steering: Steering, driven: &[&str], said: &str| {
        let Imported { robot, guessed, .. } = variant(urdf).unwrap_or_else(|error| panic!("{error}"));
        let wheels: Vec<&str> = robot.driven().map(|wheel| wheel.name).collect();
        assert_eq!((robot.steering, wheels.as_slice()), (steering, driven), "{guessed:#?}");
        assert!(guessed.iter().any(|guess| guess.contains(said)), "{said}: {guessed:#?}");
    };
    let link = |name: &str, x: &str, shape: &str| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><origin xyz=\"{x}\"/><parent link=\"base\"/><child link=\"{name}_link\"/>\
             <axis xyz=\"0 1 0\"/></joint><link name=\"{name}_link\"><inertial><mass value=\"1\"/><inertia ixx=\"3e-3\" ixy=\"0\" \
             ixz=\"0\" iyy=\"5e-3\" iyz=\"0\" izz=\"3e-3\"/></inertial><collision>{shape}</collision></link>"
        )
    };
    let ball = "<geometry><sphere radius=\"0.05\"/></geometry>";
    let arm = "<origin xyz=\"0.3 0 0\"/><geometry><box size=\"0.7 0.05 0.05\"/></geometry>";
    let all = ["a", "b", "c", "d"];
    check(&base("wheel", ""), Steering::Skid, &all, "steered by the sides");
    check(&base("wheel", &link("drum", "0 0.1 0.4", ball)), Steering::Skid, &all, "joint drum is above the ground");
    check(&base("wheel", &link("arm", "0 0.3 0", arm)), Steering::Skid, &all, "joint arm is not round about its axis");
    check(&base("wheel", &link("nose", "0.4 0 -0.05", ball)), Steering::Skid, &all, "nose is a caster");
    let hub = link("hub", "0 0 0", ball).replacen("base", "wheel_a", 1);
    check(&base("wheel", &hub), Steering::Skid, &["b", "c", "d"], "joint a carries other joints, so it is no wheel");
    let gear = link("gear", "0 0.1 0.4", ball).replacen(
        "<axis xyz=\"0 1 0\"/>",
        "<axis xyz=\"1 0 0\"/><mimic joint=\"a\"/>",
        1,
    );
    check(&base("wheel", &gear), Steering::Skid, &all, "joint gear follows a wheel and is held");
    // Omni wheels are ordered front left, front right, back left, back right.
    let omni = ["c", "d", "a", "b"];
    check(&base("mecanum", ""), Steering::Omni, &omni, "Mecanum wheels, as names");
    let diagonal = "<gazebo reference=\"wheel_a\"><fdir1>1 -1 0</fdir1></gazebo>";
    check(&base("wheel", diagonal), Steering::Omni, &omni, "rollers are guessed: 6 on each wheel");
    let ahead = diagonal.replace("-1", "0");
    check(&base("wheel", &ahead), Steering::Skid, &all, "steered by the sides");
    check(&base("caster_wheel", ""), Steering::Skid, &all, "wheels that are called casters are driven");
}

#[test]
fn a_robot_on_legs_stands_and_an_arm_is_fixed() {
    let leg = |name: &str, x: f64, y: f64| {
        let joint = |joint: &str, parent: &str, child: &str, origin: &str| {
            format!(
                "<joint name=\"{name}_{joint}\" type=\"revolute\"><origin xyz=\"{origin}\"/><parent link=\"{parent}\"/><child \
                 link=\"{name}_{child}\"/><axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"1\" effort=\"50\" velocity=\"5\"/></joint>\
                 <link name=\"{name}_{child}\"><collision><origin xyz=\"0 0 -0.1\"/><geometry><box size=\"0.04 0.04 0.2\"/></geometry>\
                 </collision></link>"
            )
        };
        joint("hip", "base", "thigh", &format!("{x} {y} 0"))
            + &joint("knee", &format!("{name}_thigh"), "shin", "0 0 -0.2")
    };
    let body = "<robot name=\"legs\"><link name=\"base\"><collision><geometry><box size=\"0.6 0.3 0.1\"/></geometry></collision></link>";
    let dog = format!(
        "{body}{}{}{}{}</robot>",
        leg("fl", 0.25, 0.1),
        leg("fr", 0.25, -0.1),
        leg("bl", -0.25, 0.1),
        leg("br", -0.25, -0.1)
    );
    let Imported { robot, guessed, replaced, .. } = variant(&dog).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((robot.steering, robot.footing), (Steering::Legged, Footing::Free), "{guessed:#?}");
    assert_eq!(replaced.len(), 9, "{replaced:#?}");
    assert_eq!(robot.actuators.len(), 4, "{guessed:#?}");
    let one = format!("{body}{}</robot>", leg("arm", 0.0, 0.0));
    let RobotDef { steering, footing, .. } = variant(&one).unwrap_or_else(|error| panic!("{error}")).robot;
    assert_eq!((steering, footing), (Steering::None, Footing::Fixed));
}

#[test]
fn a_car_keeps_its_knuckles_and_a_swivel_is_held() {
    let knuckles: String = ["c", "d"]
        .iter()
        .zip([0.2, -0.2])
        .map(|(name, y)| {
            format!(
                "<joint name=\"turn_{name}\" type=\"revolute\"><origin xyz=\"0.2 {y} 0\"/><parent link=\"base\"/><child \
                 link=\"knuckle_{name}\"/><axis xyz=\"0 0 1\"/><limit lower=\"-0.5\" upper=\"0.5\" effort=\"20\" velocity=\"2\"/></joint>\
                 <link name=\"knuckle_{name}\"/>"
            )
        })
        .collect();
    let mut urdf = base("wheel", &knuckles);
    for (name, y) in [("c", "0.2"), ("d", "-0.2")] {
        let from =
            format!("<joint name=\"{name}\" type=\"continuous\"><origin xyz=\"0.2 {y} 0\"/><parent link=\"base\"/>");
        assert!(urdf.contains(&from), "{urdf}");
        urdf = urdf
            .replace(&from, &format!("<joint name=\"{name}\" type=\"continuous\"><parent link=\"knuckle_{name}\"/>"));
    }
    let Imported { robot, files, .. } = variant(&urdf).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(robot.steering, Steering::Ackermann);
    let steered = robot.links.iter().filter(|link| link.steered_axle() == Some(0));
    assert!(
        steered.count() == 2
            && robot.links.iter().all(|link| link.joint.as_ref().is_none_or(|it| it.kind != JointKind::Fixed))
    );
    let Content::Text(written) = &files[1].1 else { panic!("robot.urdf is a text") };
    assert!(written.contains("name=\"turn_c_FrontSteer\""), "{written}");
}

#[test]
fn lasers_and_cameras_of_gazebo_are_where_it_has_them() {
    let links = "<joint name=\"mount\" type=\"fixed\"><origin xyz=\"0.3 0.1 0.2\" rpy=\"0 0 1.5707963\"/><parent link=\"base\"/>\
                 <child link=\"laser\"/></joint><link name=\"laser\"/>";
    let sensor = |on: &str, kind: &str, content: &str| {
        format!(
            "{links}<gazebo reference=\"{on}\"><sensor name=\"the eye\" type=\"{kind}\"><update_rate>20</update_rate>{content}</sensor></gazebo>"
        )
    };
    let scan = "<pose>0.1 0 0 0 0 0</pose><ray><scan><horizontal><samples>181</samples><min_angle>0</min_angle><max_angle>1.5707963\
                </max_angle></horizontal></scan><range><min>0.1</min><max>8</max></range></ray>";
    let Imported { robot, .. } =
        variant(&base("wheel", &sensor("laser", "gpu_ray", scan))).unwrap_or_else(|error| panic!("{error}"));
    let eye = robot.sensors.last().expect("a sensor");
    let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    // The laser looks to the left, and the middle of its fan 45 degrees farther. Left is negative here.
    assert!(eye.name == "the_eye" && near(eye.position, [0.3, -0.2, -0.2]), "{eye:?}");
    assert!(near(eye.direction, [0.0, 0.0, -0.75 * std::f64::consts::PI]) && eye.scan_interval == 0.05, "{eye:?}");
    let scene::sensor::Config::RangeScanner(laser) = &eye.config else { panic!("{eye:?}") };
    assert_eq!((laser.max_range, laser.min_range, (laser.field_of_view / laser.resolution).round()), (8.0, 0.1, 180.0));
    let camera = sensor("laser", "camera", "<camera><horizontal_fov>1.2</horizontal_fov></camera>");
    let Imported { robot, guessed, .. } = variant(&base("wheel", &camera)).unwrap_or_else(|error| panic!("{error}"));
    assert!(
        matches!(&robot.sensors.last().expect("a sensor").config, scene::sensor::Config::Camera(it) if it.field_of_view == 1.2)
    );
    assert!(guessed.iter().any(|it| it == "sensor the_eye is Gazebo's, a Camera on body"), "{guessed:?}");
    for (on, kind, content, expected) in [
        ("laser", "contact", "", "sensor the eye: type `contact` is not read"),
        ("laser", "ray", "", "sensor the eye: no <horizontal> scan"),
        ("nothing", "ray", scan, "sensor the eye: link nothing is not found"),
        ("wheel_a", "ray", scan, "sensor the eye: it turns with a wheel"),
        ("laser", "camera", "<horizontal_fov>9</horizontal_fov>", "min_field_of_view <= field_of_view"),
    ] {
        let Imported { left_out, .. } =
            variant(&base("wheel", &sensor(on, kind, content))).unwrap_or_else(|error| panic!("{error}"));
        assert!(left_out.iter().any(|it| it.contains(expected)), "{expected}: {left_out:?}");
    }
}

#[test]
fn packages_are_found_by_their_manifests() {
    let alone = tempfile::tempdir().expect("a folder");
    let lost = alone.path().join("lost.urdf");
    std::fs::write(&lost, "<robot/>").expect("a file");
    let rover = packages().join("rover/urdf/rover.urdf.xacro");
    let named = [("cart_description".to_owned(), alone.path().to_owned())];
    let both: &[&str] = &["cart_description", "rover_description"];
    for (file, named, searched, expected) in [
        (&rover, &[][..], vec![], both),
        (&lost, &[], vec![], &[]),
        (&lost, &[], vec![packages()], both),
        (&lost, &named, vec![packages().join("rover")], both),
    ] {
        let found = Packages::around(file, named, &searched).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(found.folders().keys().collect::<Vec<_>>(), expected, "{}", file.display());
    }
    // A named package comes first.
    let found = Packages::around(&rover, &named, &[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(found.folders()["cart_description"], alone.path().canonicalize().expect("a folder"));
}

#[test]
fn meshes_stay_inside_of_packages() {
    let visual = |file: &str| {
        base("wheel", "").replacen(
            "<collision>",
            &format!("<visual><geometry><mesh filename=\"{file}\"/></geometry></visual><collision>"),
            1,
        )
    };
    let outside = "it is outside of every package: expected a file in one";
    for (file, expected) in [
        ("package://cart_description/meshes/wheel.obj", None),
        ("package://cart_description/urdf/../meshes/./wheel.obj", None),
        ("../meshes/wheel.obj", None),
        ("package://cart_description/../../outside.obj", Some(outside)),
        ("../../../outside.obj", Some(outside)),
        ("file:///etc/passwd", Some(outside)),
        ("package://cart_description", Some("no such file")),
        ("package://cart_description/meshes", Some("no such file")),
        ("package://cart_description/package.xml", Some("expected a file that ends in .stl")),
        ("package://cart_description/urdf/secret.stl", Some("secret.stl`: ")),
        (
            "package://absent/wheel.obj",
            Some("package `absent` is not found: name its folder by --package absent=FOLDER"),
        ),
    ] {
        let Imported { files, left_out, .. } = variant(&visual(file)).unwrap_or_else(|error| panic!("{error}"));
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        match expected {
            None => assert_eq!(
                (names.as_slice(), left_out.as_slice()),
                (&["robot.toml", "robot.urdf", "meshes/wheel.obj"][..], &[][..])
            ),
            Some(expected) => {
                assert_eq!(names, ["robot.toml", "robot.urdf"], "{file}");
                assert!(left_out.iter().any(|it| it.contains(expected)), "{file}: {left_out:?}");
            }
        }
    }
}
