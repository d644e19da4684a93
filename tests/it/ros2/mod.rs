//! ROS 2: the real binary with its bridge process, and foreign peers, all on the loopback.

mod hostile;
mod measure;
mod peers;
mod rig;
mod services;
mod supervision;
