//! Visuals of robots: shapes and meshes of every format.

use std::path::{Path, PathBuf};

use scene::{RobotDef, Shape};

const CART: &str = r#"
description = "a box on two wheels"
steering = "skid"
[[part]]
name = "Box"
mass = 4.0
size = [0.3, 0.2, 0.08]
material = "aluminium"
[wheels]
radius = 0.06
width = 0.03
mass = 0.3
material = "rubber-tyre"
max_speed = 10.0
gain = 1.0
max_torque = 3.0
[[wheel]]
name = "L"
side = "left"
position = [0.0, -0.13, 0.0]
[[wheel]]
name = "R"
side = "right"
position = [0.0, 0.13, 0.0]
[[visual]]
"#;

/// Returns a folder with a box of 2 x 1 x 0.5 m in the corner of its axes, z up, in every format.
fn meshes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes")
}

/// Loads the cart with this visual, in a folder with the test meshes and an optional extra one.
fn load(visual: &str, mesh: Option<(&str, &[u8])>) -> Result<RobotDef, String> {
    let folder = tempfile::tempdir().expect("a folder");
    for file in std::fs::read_dir(meshes()).expect("meshes").flatten() {
        std::fs::copy(file.path(), folder.path().join(file.file_name())).expect("a copy");
    }
    if let Some((name, bytes)) = mesh {
        std::fs::write(folder.path().join(name), bytes).expect("a file");
    }
    let path = folder.path().join("robot.toml");
    std::fs::write(&path, format!("{CART}{visual}")).expect("a file");
    scene_loader::robot(&path.display().to_string(), &[]).map_err(|error| error.to_string())
}

#[test]
fn a_mesh_of_every_format_is_the_same_box() {
    let (red, blue, plain) = ([0.8, 0.1, 0.1], [0.1, 0.1, 0.8], [0.72, 0.72, 0.74]);
    let check = |file: &str, colours: &[[f64; 3]]| {
        let robot =
            load(&format!("mesh = \"{file}\"\nscale = 0.5"), None).unwrap_or_else(|error| panic!("{file}: {error}"));
        let (mut corners, mut area) = (Vec::new(), 0.0);
        for visual in &robot.links[0].visuals {
            let Shape::Mesh { vertices, triangles } = &visual.shape else { panic!("{file}: {visual:?}") };
            for triangle in triangles {
                let [a, b, c] = triangle.map(|corner| nalgebra::Vector3::from(vertices[corner as usize]));
                area += (b - a).cross(&(c - a)).norm() / 2.0;
                corners.extend([a, b, c]);
            }
            assert!(
                colours.iter().any(|it| it.iter().zip(visual.colour).all(|(a, b)| (a - b).abs() < 1e-3)),
                "{visual:?}"
            );
        }
        let ends = |axis: usize| {
            let all = corners.iter().map(|corner| corner[axis]);
            [all.clone().fold(f64::MAX, f64::min), all.fold(f64::MIN, f64::max)]
        };
        // The box is half as large, and z is down: y and z change their sign.
        for (axis, expected) in [[0.0, 1.0], [-0.5, 0.0], [-0.25, 0.0]].into_iter().enumerate() {
            let got = ends(axis);
            assert!(got.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{file}: {got:?} for {expected:?}");
        }
        assert!((area - 2.0 * (0.5 + 0.25 + 0.125)).abs() < 1e-6, "{file}: {area} m²");
    };
    check("box.stl", &[plain]);
    check("box.obj", &[plain]);
    check("box.dae", &[red, blue]);
    check("box.glb", &[red, blue]);
    check("box.gltf", &[red, blue]);
}

#[test]
fn a_visual_is_of_its_link_and_of_one_shape() {
    let robot = load("link = \"L\"\nradius = 0.05\nlength = 0.02\ncolour = [1.0, 0.0, 0.5]", None).expect("a cart");
    let drawn: Vec<_> = robot.drawn().collect();
    let colours: Vec<_> = drawn.iter().map(|(link, pieces)| (link.name.as_str(), pieces[0].colour[0])).collect();
    // The body and the right wheel keep their colours, the left wheel has that of its visual.
    assert_eq!(colours, [("body", 0.93), ("L", 1.0), ("R", drawn[2].1[0].colour[0])]);
    assert_eq!(
        drawn[1].1[0].geometry,
        scene::Geometry::Shape(std::borrow::Cow::Owned(Shape::Cylinder { radius: 0.05, length: 0.02 }))
    );
    for (visual, expected) in [
        ("size = [1.0, 1.0, 1.0]\nradius = 0.1", "a visual of no shape or of more than one"),
        ("link = \"R\"", "a visual of no shape or of more than one"),
        ("link = \"Rr\"\nradius = 0.1", "(did you mean `R`?)"),
        ("radius = -1.0", "`radius` is -1"),
        ("radius = 0.1\ncolour = [2.0, 0.0, 0.0]", "`colour` is [2, 0, 0]"),
        ("radius = 0.1\nspin = 2000.0", "`spin` is 2000"),
        ("mesh = \"box.fbx\"", "expected a file that ends in .stl, .obj, .dae, .glb or .gltf"),
        ("mesh = \"none.dae\"", "none.dae"),
        ("mesh = \"box.stl\"\nscale = 0.0", "`scale` is 0"),
        ("mesh = \"box.stl\"\nscael = 1.0", "(did you mean `scale`?)"),
    ] {
        let error = load(visual, None).map(|_| ()).expect_err(visual);
        assert!(error.lines().count() == 1 && error.contains(expected), "{visual}: {error}");
    }
}

#[test]
fn a_visual_can_spin() {
    let speed = |visual: &str| load(visual, None).expect("a cart").links[0].visuals[0].spin.to_bits();
    assert_eq!(speed("radius = 0.1"), 0.0_f64.to_bits());
    assert_eq!(speed("radius = 0.1\nspin = -7.5"), (-7.5_f64).to_bits());
}

#[test]
fn a_class_like_another_adds_visuals() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.toml");
    std::fs::write(&path, "like = \"P3AT\"\n[[visual]]\nradius = 0.1\n").expect("a file");
    let like = scene_loader::robot(&path.display().to_string(), &[]).expect("a robot");
    let of_other = scene_loader::robot("P3AT", &[]).expect("a P3AT").links[0].visuals.len();
    assert_eq!(like.links[0].visuals.len(), of_other + 1);
    assert_eq!(like.links[0].visuals[of_other].shape, Shape::Ball { radius: 0.1 });
}

#[test]
fn a_damaged_mesh_is_an_error_or_a_mesh() {
    for name in ["box.dae", "box.glb", "box.gltf"] {
        let whole = std::fs::read(meshes().join(name)).expect("a mesh");
        let mut refused = 0;
        for place in (0..whole.len()).step_by(7) {
            let mut changed = whole.clone();
            changed[place] ^= 0x15;
            for bytes in [&whole[..place], &changed] {
                refused += usize::from(load(&format!("mesh = \"{name}\""), Some((name, bytes))).is_err());
            }
        }
        assert!(refused > whole.len() / 14, "{name}: {refused}");
    }
}
