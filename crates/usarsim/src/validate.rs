//! `usarsim validate`: physical checks of a robot on wheels.

use experiments::validation::{self, Finding, Stance, Subject};
use indicatif::{ProgressBar, ProgressStyle};
use scene::DriveModel;
use scene_loader::Override;
use serde_json::json;
use sim_core::Options;

use crate::values::within;
use crate::{Failure, exit, print};

/// Options of `validate`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  usarsim validate\n  usarsim validate --drive-model analytic --json\n  \
    usarsim validate --robot P3AT\n  usarsim validate --check 1 --check 7 --robot YouBot --set material.carpet.friction=0.5\n\n\
    A robot on Mecanum wheels has twelve checks, any other nine. Each failed check says why. Exit code 0 if every check passes, 1 if one fails. docs/validation.md describes the checks.")]
pub(crate) struct Arguments {
    /// A robot class with wheels, or the path of its robot.toml.
    #[arg(long, default_value = "YouBotArm", value_name = "NAME|FILE")]
    robot: String,
    /// Drive model: articulated, bodies, analytic or kinematic; by default the one in its robot.toml.
    #[arg(long, value_name = "MODEL", value_parser = crate::values::drive_model)]
    drive_model: Option<DriveModel>,
    /// Run only this check: 1 to 12, or 1 to 9 for a robot without Mecanum wheels. May be given several times.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=12))]
    check: Vec<u32>,
    /// Seconds of each measured drive.
    #[arg(long, default_value_t = 20.0, value_parser = seconds)]
    seconds: f64,
    /// Length of a time step, s.
    #[arg(long, default_value_t = sim_core::TIME_STEP, value_parser = crate::values::time_step)]
    dt: f64,
    /// Replace a number: robot.PATH, CLASS.PATH or material.PATH=VALUE. May be given several times.
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<Override>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    within(text, 1.0, 60.0)
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let broken = |error: &dyn std::fmt::Display| Failure::new(exit::BAD_CONFIGURATION, error);
    let options = Options { time_step: arguments.dt, ..Options::default() };
    let Arguments { robot, drive_model, set, seconds, .. } = arguments;
    let subject = Subject::load(robot, *drive_model, set, options, *seconds).map_err(|error| broken(&error))?;
    let model = subject.robot.drive_model;
    let names = validation::checks(&subject.robot);
    let all = || (1..=names.len() as u32).collect();
    let checks: Vec<u32> = if arguments.check.is_empty() { all() } else { arguments.check.clone() };
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg} ({elapsed})");
    let bar = ProgressBar::new(checks.len() as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let mut findings = Vec::new();
    for check in checks {
        bar.set_message(name_of(names, check));
        let found = validation::check(&subject, check);
        findings.extend(found.map_err(|error| broken(&error))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let failed = findings.iter().filter(|finding| !finding.passes()).count();
    let stance = if failed > 0 { Some(Stance::of(&subject).map_err(|error| broken(&error))?) } else { None };
    let remark = stance.and_then(|stance| stance.remark(&subject.robot));
    if arguments.json {
        let rows: Vec<_> = findings.iter().map(|finding| subject.to_json(finding)).collect();
        let (class, dt) = (&subject.robot.class, arguments.dt);
        print(json!({
            "robot": class, "drive_model": model.name(), "dt": dt, "failed": failed, "remark": remark, "findings": rows,
        }));
    } else {
        print_table(names, &findings, |finding| validation::reason(&subject.robot, finding));
        remark.iter().for_each(|remark| print(format_args!("look at this first: {remark}")));
    }
    if failed > 0 {
        return Err(Failure::new(
            exit::FAILURE,
            format_args!("{failed} of {} measured values are out of bounds", findings.len()),
        ));
    }
    Ok(())
}

/// Returns the name of a check. It is empty for a number out of range, which the run of the check refuses.
fn name_of(names: &[&'static str], check: u32) -> &'static str {
    names.get(check as usize - 1).copied().unwrap_or_default()
}

fn print_table(names: &[&'static str], findings: &[Finding], reason: impl Fn(&Finding) -> Option<&'static str>) {
    let mut last = 0;
    for finding in findings {
        if finding.check != last {
            last = finding.check;
            print(format_args!("{last}. {}", name_of(names, last)));
        }
        let verdict = if finding.passes() { "pass" } else { "FAIL" };
        let bounds = if finding.least.is_finite() {
            format!("{:.4} to {:.4}", finding.least, finding.most)
        } else {
            format!("at most {}", finding.most)
        };
        print(format_args!("   {:<58} {:>9.4}   {bounds:<20} {verdict}", finding.what, finding.measured));
        if let Some(reason) = reason(finding) {
            print(format_args!("        why: {reason}"));
        }
    }
}
