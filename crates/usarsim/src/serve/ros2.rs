//! Options of `serve` for its node of ROS 2.

use std::ffi::OsString;
use std::net::Ipv4Addr;
use std::path::Path;

use clap::{ArgGroup, ValueEnum};
use ros2::{Controller, ControllerFile, Dds, LAST_DOMAIN, Namespaces, Options};
use scene::{Classes, WorldDef};

use crate::{Failure, exit};

/// Options of the node.
#[derive(clap::Args)]
#[command(group = ArgGroup::new("ros").multiple(true))]
pub(crate) struct Ros2Choice {
    /// Be a node of ROS 2, by DDS; nothing of ROS has to be installed. Topics, services and QoS: docs/howto-ros2.md. Only this machine is spoken
    /// to, whatever --host says: DDS has no password.
    #[arg(long, env = "USARSIM_ROS2", group = "ros")]
    ros2: bool,
    /// Let clients of rosbridge in on the page's port, `ws://localhost:8080/rosbridge`: the topics and services of --ros2 as JSON, for
    /// roslibpy, roslibjs and whoever has no DDS. It needs no --ros2.
    #[arg(long, env = "USARSIM_ROSBRIDGE", group = "ros", conflicts_with = "no_http", hide_short_help = true)]
    rosbridge: bool,
    /// Domain of the node.
    #[arg(long, env = "ROS_DOMAIN_ID", value_name = "0..101", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=i64::from(LAST_DOMAIN)), hide_short_help = true)]
    ros2_domain: u16,
    /// Speak at this address of this machine. Whoever reaches it can drive robots and stop the world.
    #[arg(long, env = "USARSIM_ROS2_INTERFACE", value_name = "ADDRESS", requires = "ros2", hide_short_help = true)]
    ros2_interface: Option<Ipv4Addr>,
    /// Topics and frames of a robot: below its name (`/R1/scan`), or, for the first robot, without (`/scan`).
    #[arg(
        long,
        env = "USARSIM_ROS2_NAMESPACE",
        value_name = "WHICH",
        default_value = "name",
        requires = "ros",
        hide_short_help = true
    )]
    ros2_namespace: Namespace,
    /// Publish the transform from `map` to each `odom`, as a perfect localisation would: for tests without SLAM and AMCL, which publish it
    /// themselves.
    #[arg(long, env = "USARSIM_ROS2_LOCALISED", requires = "ros", hide_short_help = true)]
    ros2_localised: bool,
    /// Drive robots of a class as a controller of ros2_control does, with the parameters of its YAML file: wheel separation, radius, their
    /// multipliers, limits, topics and frames of a diff_drive, mecanum_drive or ackermann_steering controller. Without a class it is that of
    /// the only --robot. May be given several times.
    #[arg(long, value_name = "[CLASS=]FILE.yaml", requires = "ros", hide_short_help = true)]
    ros2_controller: Vec<String>,
    /// Let ROS 2 in beside --token-file or --league, although DDS asks nobody for a token and shows every robot to every node.
    #[arg(long, env = "USARSIM_ROS2_UNGUARDED", requires = "ros", hide_short_help = true)]
    ros2_unguarded: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Namespace {
    Name,
    None,
}

impl Ros2Choice {
    /// Returns the settings of the node; `None` without one. `has_tokens` is true if clients need a token. The variables
    /// `ROS_AUTOMATIC_DISCOVERY_RANGE` and `ROS_LOCALHOST_ONLY` of ROS can only close DDS.
    pub(crate) fn options(&self, has_tokens: bool, world: &WorldDef) -> Result<Option<Options>, Failure> {
        let Self { ros2, rosbridge, .. } = *self;
        let asked = [(ros2, "--ros2", "DDS has no password"), (rosbridge, "--rosbridge", "ROS knows no teams")];
        let Some((_, option, why)) = asked.into_iter().find(|(is_asked, ..)| *is_asked) else { return Ok(None) };
        let guards = [(has_tokens, "--token-file"), (world.is_contest(), "--league")];
        if let Some((_, guard)) = guards.iter().find(|(is_there, _)| *is_there && !self.ros2_unguarded) {
            let text = format!(
                "{option} with {guard}: {why}, so every program that comes in could see and drive every robot; --ros2-unguarded allows it"
            );
            return Err(Failure::new(exit::USAGE, text));
        }
        let namespaces = match self.ros2_namespace {
            Namespace::Name => Namespaces::Names,
            Namespace::None => Namespaces::NoneForTheFirst,
        };
        let dds = if ros2 { self.dds()? } else { None };
        let controllers = self.controllers(&world.robots)?;
        let is_localised = self.ros2_localised;
        let options = Options { dds, rosbridge, namespaces, is_localised, controllers, ..Options::default() };
        Ok(Some(options).filter(|options| options.rosbridge || options.dds.is_some()))
    }

    /// Returns the settings of DDS; `None` if the variables of ROS turn it off.
    fn dds(&self) -> Result<Option<Dds>, Failure> {
        let range = std::env::var("ROS_AUTOMATIC_DISCOVERY_RANGE").unwrap_or_default();
        let is_local = range == "LOCALHOST" || std::env::var("ROS_LOCALHOST_ONLY").is_ok_and(|it| it == "1");
        if range == "OFF" {
            tracing::warn!("no node of ROS 2: ROS_AUTOMATIC_DISCOVERY_RANGE is OFF");
            return Ok(None);
        }
        let address = self.ros2_interface.unwrap_or(Ipv4Addr::LOCALHOST);
        let address = if !address.is_loopback() && is_local {
            tracing::warn!("ROS 2 stays on this machine: its variables say so, whatever --ros2-interface says");
            Ipv4Addr::LOCALHOST
        } else {
            address
        };
        if !address.is_loopback() {
            tracing::warn!("ROS 2 at {address}: whoever reaches it can drive robots, as DDS has no password");
        }
        let program =
            program().map_err(|error| Failure::new(exit::FAILURE, format!("ROS 2: this program: {error}")))?;
        Ok(Some(Dds { program, domain: self.ros2_domain, address }))
    }

    /// Reads the controllers, each with its class.
    fn controllers(&self, robots: &Classes) -> Result<Vec<(String, Controller)>, Failure> {
        let wrong =
            |file: &str, why: String| Failure::new(exit::BAD_CONFIGURATION, format!("--ros2-controller {file}: {why}"));
        let read = |given: &String| {
            let (class, file) =
                given.split_once('=').map_or((None, given.as_str()), |(class, file)| (Some(class), file));
            // Classes that are read at the start are those of files.
            let mut own = robots.read().map(|(name, _)| name);
            let class = match (class, own.next(), own.next()) {
                (Some(class), ..) => robots.find(class).cloned().ok_or_else(|| format!("no class `{class}`")),
                (None, Some(only), None) => Ok(only.clone()),
                (None, ..) => Err("which class? Expected CLASS=FILE.yaml, or one --robot".to_owned()),
            };
            let class = class.map_err(|why| wrong(file, why))?;
            let text = scene_loader::text(Path::new(file)).map_err(|error| wrong(file, error.to_string()))?;
            let robot = robots.get(&class).ok_or_else(|| wrong(file, format!("no class `{class}`")))?;
            let controller = ControllerFile::read(&text).and_then(|controller| controller.of(robot));
            Ok((class, controller.map_err(|why| wrong(file, why))?))
        };
        self.ros2_controller.iter().map(read).collect()
    }
}

/// Returns this program as the process of a node. In Python it is a module.
fn program() -> std::io::Result<Vec<OsString>> {
    let own = std::env::current_exe()?;
    let is_python = own.file_name().is_some_and(|name| name.to_string_lossy().starts_with("python"));
    let module: &[&str] = if is_python { &["-m", "usarsim"] } else { &[] };
    let arguments = module.iter().chain(&["ros2-node"]).map(OsString::from);
    Ok(std::iter::once(own.into_os_string()).chain(arguments).collect())
}
