//! The error of serving.

/// The reason why serving did not start, or stopped by itself.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The server cannot listen on the address.
    #[error("cannot listen on {host}:{port}: {reason}; is another server running? Port 0 takes a free one")]
    Listen {
        /// The address.
        host: String,
        /// The port.
        port: u16,
        /// The operating system's error.
        reason: std::io::Error,
    },
    /// The log cannot be written.
    #[error(transparent)]
    Log(#[from] recorder::RecordError),
    /// The saved state does not fit the scene.
    #[error("the saved world: {0}")]
    Saved(#[from] sim_core::LoadError),
    /// The runtime or a thread cannot be started.
    #[error("cannot start: {0}")]
    Start(std::io::Error),
    /// The node of ROS 2 cannot be started.
    #[cfg(feature = "ros2")]
    #[error(transparent)]
    Ros2(#[from] ros2::StartError),
    /// The world's thread ended without a report.
    #[error("the world stopped unexpectedly")]
    WorldStopped,
    /// The world's thread panicked: a defect of this program.
    #[error("a defect: the world panicked at {time:.3} s: {reason}; {report}")]
    WorldPanicked {
        /// Simulated time, s.
        time: f64,
        /// The panic's message.
        reason: String,
        /// Path of the report, or the reason why there is none.
        report: String,
    },
}
