//! Options of `serve` for its node of ROS 2.

use std::ffi::OsString;
use std::net::Ipv4Addr;

use clap::ValueEnum;
use ros2::{LAST_DOMAIN, Namespaces, Options};

use crate::{Failure, exit};

/// Options of the node.
#[derive(clap::Args)]
pub(crate) struct Ros2Choice {
    /// Be a node of ROS 2, by DDS; nothing of ROS has to be installed. Topics, services and QoS: docs/howto-ros2.md. Only this machine is spoken
    /// to, whatever --host says: DDS has no password.
    #[arg(long, env = "USARSIM_ROS2")]
    ros2: bool,
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
        requires = "ros2",
        hide_short_help = true
    )]
    ros2_namespace: Namespace,
    /// Publish the transform from `map` to each `odom`, as a perfect localisation would: for tests without SLAM and AMCL, which publish it
    /// themselves.
    #[arg(long, env = "USARSIM_ROS2_LOCALISED", requires = "ros2", hide_short_help = true)]
    ros2_localised: bool,
    /// Let ROS 2 in beside --token-file, although DDS asks nobody for a token.
    #[arg(long, env = "USARSIM_ROS2_UNGUARDED", requires = "ros2", hide_short_help = true)]
    ros2_unguarded: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Namespace {
    Name,
    None,
}

impl Ros2Choice {
    /// Returns the settings of the node; `None` without one. `has_tokens` is true if clients need a token. The variables
    /// `ROS_AUTOMATIC_DISCOVERY_RANGE` and `ROS_LOCALHOST_ONLY` of ROS can only close it.
    pub(crate) fn options(&self, has_tokens: bool) -> Result<Option<Options>, Failure> {
        if !self.ros2 {
            return Ok(None);
        }
        if has_tokens && !self.ros2_unguarded {
            let text = "--ros2 with --token-file: DDS asks nobody for a token, so every program of this machine could drive; \
                        --ros2-unguarded allows it";
            return Err(Failure::new(exit::USAGE, text));
        }
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
        let namespaces = match self.ros2_namespace {
            Namespace::Name => Namespaces::Names,
            Namespace::None => Namespaces::NoneForTheFirst,
        };
        let is_localised = self.ros2_localised;
        let program =
            program().map_err(|error| Failure::new(exit::FAILURE, format!("ROS 2: this program: {error}")))?;
        Ok(Some(Options { program, domain: self.ros2_domain, address, namespaces, is_localised, ..Options::default() }))
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
