//! Published measurements of real robots beside the simulation, and the files that hold them.

use experiments::real::{self, Measured, Row};

/// Returns the rows of a file of the project.
fn rows(id: &str) -> Vec<Row> {
    let files = real::files();
    let (name, text) = files.iter().find(|(name, _)| name.trim_end_matches(".toml") == id).expect("a file");
    let measured = Measured::read(name, text).unwrap_or_else(|error| panic!("{error}"));
    real::run(&measured).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[track_caller]
fn check(id: &str, within: impl Fn(&Row) -> f64) {
    for row in rows(id) {
        println!("{id}, {}: real {}, here {:.4}", row.what, row.real, row.ours);
        assert!((row.ours - row.real).abs() < within(&row), "{id}, {}: {} is not {}", row.what, row.ours, row.real);
    }
}

/// One tyre fits a Pioneer 3-AT at eight curvatures within 1 %. A rigid disc is 2.8 % off.
#[test]
fn a_pioneer_turns_as_the_real_one_at_every_curvature() {
    check("pioneer-3-at", |row| 0.01 * row.real);
    let (_, text) = real::files().into_iter().find(|(name, _)| name == "pioneer-3-at.toml").expect("a file");
    let mut measured = Measured::read("pioneer-3-at.toml", text).unwrap_or_else(|error| panic!("{error}"));
    measured.robot.tyre = None;
    let rigid = real::run(&measured).unwrap_or_else(|error| panic!("{error}"));
    let worst = rigid.iter().map(|row| row.percent().abs()).fold(0.0, f64::max);
    assert!((2.5..3.0).contains(&worst), "a rigid disc is {worst} % off");
}

/// Nothing of these is fitted: their dimensions, and the Pioneer's tyre in their size.
#[test]
fn five_robots_turn_on_the_spot_within_two_percent_of_the_real_ones() {
    for id in ["leo", "scout-2", "rosbot", "pioneer-3-at-maker", "jackal"] {
        check(id, |row| 0.02 * row.real);
    }
    for id in ["romi", "kobuki"] {
        check(id, |row| 0.01 * row.real);
    }
}

#[test]
fn a_warthog_turns_within_the_spread_of_the_real_one_at_seven_curvatures() {
    assert_eq!(rows("warthog").len(), 7);
    check("warthog", |row| row.spread.expect("a standard deviation"));
}

/// A robot on four driven wheels climbs what the maker says, and no more than friction allows: a slope of atan 0.8, and a step of
/// 2 mu² / (1 + mu²) of its radius.
#[test]
fn a_car_climbs_the_step_and_the_slope_that_its_maker_names() {
    let rows = rows("hunter-se");
    let most = [2.0 * 0.64 / 1.64 * 0.1375, 0.8_f64.atan()];
    for (row, most) in rows.iter().zip(most) {
        println!("{}: at least {}, here {:.4}, at most {most:.4}", row.what, row.real, row.ours);
        assert!(row.is_limit && row.agrees(), "{row:?}");
        assert!((0.9 * most..most).contains(&row.ours), "{row:?}, at most {most}");
    }
}

/// The friction of the rollers' bearings brakes sideways by sqrt(2) c g.
#[test]
fn a_mecanum_robot_without_power_is_braked_sideways_by_its_bearings() {
    let rows = rows("ftc-mecanum");
    let row = rows.iter().find(|row| row.what.starts_with("coasting")).expect("a row");
    let expected = 2.0_f64.sqrt() * 0.054 * 9.81;
    assert!((row.ours / expected - 1.0).abs() < 0.03 && row.agrees(), "{row:?}, expected {expected}");
}

/// Every file of the project reads, runs, and gives the same bits again.
#[test]
fn every_robot_of_the_project_is_compared() {
    for (name, _) in real::files() {
        let id = name.trim_end_matches(".toml");
        let (one, again) = (rows(id), rows(id));
        assert_eq!(one, again, "{id}");
        assert!(one.iter().all(|row| row.ours.is_finite() && row.ours > 0.0), "{id}: {one:?}");
    }
}

const ROBOT: &str = "[robot]\nmass = 30\nwheelbase = 0.3\ntrack = 0.4\nradius = 0.1\nwidth = 0.06\n";
const FLOOR: &str = "[floor]\nfriction = 0.6\nrolling_resistance = 0.03\n";
const TURN: &str = "[[turn]]\ncurvature = 0\nchi = 1.5\n";

#[test]
fn a_file_that_measures_nothing_or_nonsense_is_refused_by_name() {
    let head = "name = 'Robot'\nsource = 'a paper'\n";
    let with = |robot: &str, rest: &str| format!("{head}{robot}{FLOOR}{rest}");
    for (text, expected) in [
        (with(ROBOT, ""), "0 of [[turn]], [[strafe]] and [[figure]]: expected 1 to 1000"),
        (with(ROBOT, "[[strafe]]\nratio = 1.0\n"), "expected a Mecanum robot"),
        (with(ROBOT, "[[figure]]\nwhat = 'coasting'\nvalue = 1.0\n"), "ahead (m/s²) of a robot without `rollers`"),
        (with(ROBOT, "[[figure]]\nwhat = 'uphill'\nvalue = 1.0\nslope = 2\n"), "`slope` is 2: expected 0 to 0.5 rad"),
        (with(ROBOT, "[[figure]]\nwhat = 'weight'\nvalue = 1.0\n"), "unknown variant `weight`"),
        (with(ROBOT, &TURN.replace("curvature = 0", "curvature = -1")), "`curvature` is -1: expected 0 to 1000"),
        (with(ROBOT, &TURN.replace("1.5", "nan")), "a measured NaN: expected positive numbers"),
        (with(ROBOT, &TURN.replace("1.5", "0")), "a measured 0: expected positive numbers"),
        (with(&ROBOT.replace("mass = 30", "mass = 1e9"), TURN), "`mass` is 1000000000: expected 0.01 to 100000"),
        (with(&ROBOT.replace("radius = 0.1", "radius = -1"), TURN), "`radius` is -1"),
        (with(&ROBOT.replace("wheelbase = 0.3", "wheelbase = nan"), TURN), "`wheelbase` is NaN"),
        (with(&format!("{ROBOT}tyre = {{ stiffness = [0.0, 5.0], patch = [0.03, 0.02] }}\n"), TURN), "`stiffness`"),
        (
            with(&format!("{ROBOT}tyre = {{ stiffness = [5.0, 5.0], patch = [0.03, 0.2] }}\n"), TURN),
            "half width in `patch`",
        ),
        (with(&format!("{ROBOT}rollers = {{ count = 1000000000 }}\n"), TURN), "`count of rollers` is"),
        (with(&format!("{ROBOT}wheels = 4\n"), TURN), "unknown field `wheels`"),
        (with(ROBOT, TURN).replace("friction = 0.6", "friction = -1"), "friction"),
    ] {
        let error = Measured::read("my.toml", &text).expect_err(expected).to_string();
        assert!(error.starts_with("my.toml: ") && error.contains(expected), "{error}\nexpected {expected}");
    }
}
