//! The checks of `usarsim validate`, with shorter drives.

use experiments::validation::{Stance, Subject, check, checks, reason};
use scene::DriveModel;
use sim_core::Options;

/// Loss of sideways push of a spinning wheel by rollers of 0.1 kg: each has to be spun up when it touches down.
const SPUN_UP: [(&str, f64); 1] = [("most acceleration aside, of mu g and the rollers' angle", 0.92)];

/// Check that the engine's bodies fail, and the least value that they reach. For a sliding contact the engine solves both tangents by their
/// own masses and then scales their length. So friction leans toward the direction across a roller, where the roller is light, and part of
/// Coulomb's limit is lost. It is named here, so nothing else may fail.
const KNOWN: [(&str, f64); 1] = [("most acceleration aside, of mu g and the rollers' angle", 0.85)];

fn subject(class: &str, drive_model: DriveModel) -> Subject {
    let mut robot = scene_loader::robot(class, &[]).unwrap_or_else(|error| panic!("{error}"));
    robot.drive_model = drive_model;
    let floor =
        scene_loader::map("rough", &[]).unwrap_or_else(|error| panic!("{error}")).solids.swap_remove(0).material;
    // The engine's bodies take thirty times as long as the other models.
    let seconds = if drive_model == DriveModel::Bodies { 2.0 } else { 5.0 };
    Subject { robot, floor, options: Options::default(), seconds }
}

fn run(class: &str, model: DriveModel, numbers: impl Iterator<Item = u32>, known: &[(&str, f64)]) {
    let subject = subject(class, model);
    let mut wrong = Vec::new();
    for finding in numbers.flat_map(|number| check(&subject, number).expect("a robot on wheels")) {
        let name = checks(&subject.robot)[finding.check as usize - 1];
        println!("{class} {} {name}: {} {:.4}", model.name(), finding.what, finding.measured);
        let excused = known.iter().any(|(what, least)| *what == finding.what && finding.measured > *least);
        if !finding.passes() && !excused {
            wrong.push(format!("{name}: {finding:?}"));
        }
    }
    assert!(wrong.is_empty(), "{class} {}: {wrong:#?}", model.name());
}

#[test]
fn the_analytic_model_passes_all_twelve() {
    run("KUKA_YouBot", DriveModel::Analytic, 1..=12, &[]);
    run("YouBot", DriveModel::Analytic, 1..=12, &[]);
}

#[test]
fn rollers_as_links_pass_all_twelve_but_for_what_it_takes_to_spin_them_up() {
    run("KUKA_YouBot", DriveModel::Articulated, 1..=12, &SPUN_UP);
    let mut light = subject("KUKA_YouBot", DriveModel::Articulated);
    light.robot.wheels_mut().filter_map(|wheel| wheel.rollers.as_mut()).for_each(|rollers| rollers.mass = 0.01);
    let wrong: Vec<_> = check(&light, 9).expect("a Mecanum robot").into_iter().filter(|it| !it.passes()).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn bodies_pass_all_but_what_is_known() {
    run("KUKA_YouBot", DriveModel::Bodies, 1..=12, &KNOWN);
}

/// The kinematic checks need no force but the base's own.
#[test]
fn the_kinematic_model_passes_the_kinematic_checks() {
    run("KUKA_YouBot", DriveModel::Kinematic, 1..=6, &[]);
}

#[test]
fn robots_on_plain_wheels_pass_all_nine() {
    for class in ["P3AT", "P2AT", "P2DX", "BasicSkidRobot", "CasterSkidRobot", "FrontAckerman", "BasicAckermanRobot"] {
        run(class, DriveModel::Articulated, 1..=9, &[]);
    }
}

/// Its flippers also touch the ground.
#[test]
fn a_kenaf_passes_all_nine() {
    run("Kenaf", DriveModel::Articulated, 1..=9, &[]);
}

/// Checks differ between robots, and a robot without wheels has none.
#[test]
fn a_check_that_a_robot_has_not_is_named() {
    let refused = |class: &str, number: u32| {
        let error = check(&subject(class, DriveModel::Articulated), number).expect_err("no such check");
        error.to_string()
    };
    assert_eq!(refused("P3AT", 12), "robot `P3AT` has no check 12: expected 1 to 9");
    assert_eq!(refused("KUKA_YouBot", 13), "robot `KUKA_YouBot` has no check 13: expected 1 to 12");
    assert_eq!(refused("AirRobot", 1), "robot `AirRobot`: expected one with driven wheels");
}

/// A small robot in the style of ROS: two wheels, and a skid that rubs on the floor.
#[test]
fn a_failed_check_says_what_it_means_and_what_rubs_on_the_floor() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/burger.urdf");
    let robot = scene_loader::robot(&file.display().to_string(), &[]).unwrap_or_else(|error| panic!("{error}"));
    let burger = Subject { robot, ..subject("P3AT", DriveModel::Articulated) };
    let findings: Vec<_> = [5, 6].into_iter().flat_map(|number| check(&burger, number).expect("wheels")).collect();
    let failed: Vec<_> = findings.iter().filter(|finding| !finding.passes()).collect();
    assert_eq!(failed.len(), 3, "{findings:#?}");
    for finding in &findings {
        let said = reason(&burger.robot, finding);
        assert_eq!(said.is_some(), !finding.passes(), "{finding:?}");
        let expected =
            ["something brakes wheels without a motor", "its wheels do not bring their friction to the floor"];
        assert!(said.is_none_or(|said| said.starts_with(expected[finding.check as usize - 5])), "{said:?}");
    }
    let remark = Stance::of(&burger).expect("it stands").remark(&burger.robot).expect("a remark");
    assert!(
        remark.starts_with("`skid_back_link` rubs on the floor with 5 % of the weight and friction 0.75"),
        "{remark}"
    );
}

#[test]
fn a_robot_that_stands_as_usual_has_no_remark() {
    for class in ["P3AT", "YouBot", "YouBotArm", "KUKA_YouBot", "Kenaf", "FrontAckerman"] {
        let subject = subject(class, DriveModel::Articulated);
        assert_eq!(Stance::of(&subject).expect("it stands").remark(&subject.robot), None, "{class}");
    }
}
