//! A limit to what the process may allocate.

use rustix::process::{Resource, Rlimit, setrlimit};

use super::Ros2Error;

/// Address space that a bridge may have unless told otherwise \[MiB\]: shared memory of a run, the stacks of about
/// ten threads and their heaps, which reserve more than they use.
pub const MEMORY_LIMIT_MIB: u64 = 1024;

/// Limits the address space of this process; an allocation beyond it ends the process.
pub fn limit_memory(mebibytes: u64) -> Result<(), Ros2Error> {
    let bytes = Some(mebibytes << 20);
    let limit = Rlimit {
        current: bytes,
        maximum: bytes,
    };
    setrlimit(Resource::As, limit).map_err(|reason| Ros2Error::Memory {
        mebibytes,
        reason: reason.into(),
    })
}
