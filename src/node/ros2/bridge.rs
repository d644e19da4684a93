//! The bridge itself: between a run in shared memory and a DDS domain, until told to stop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::dds::Participant;
use super::outward::Outward;
use super::traffic::{Counters, Traffic};
use super::{Settings, inward};
use crate::node::NodeError;
use crate::node::shared_memory::RunName;

/// Longest wait between looks at the stop flag.
const LOOK: Duration = Duration::from_millis(50);
/// How long an answer under way may take when the bridge ends.
const LAST_ANSWER: Duration = Duration::from_secs(1);
/// How often the counts are told.
const BEAT: Duration = Duration::from_millis(500);

/// Carries the channels of a run to DDS and commands and requests back, whether or not the run is there yet,
/// until `stop` is set. The counts go to `beat` twice a second and at the end.
pub fn bridge(
    run: &RunName,
    settings: &Settings,
    stop: &Arc<AtomicBool>,
    beat: &mut dyn FnMut(&Traffic),
) -> Result<Traffic, NodeError> {
    let counters = Arc::new(Counters::default());
    let mut participant = Participant::join(settings)?;
    let mut outward = Outward::new(run.clone(), &mut participant, settings, &counters)?;
    let inward = inward::start(run, &mut participant, settings, &counters, stop)?;
    participant.announce()?;
    let mut told = Instant::now();
    beat(&counters.traffic());
    while !stop.load(Ordering::Relaxed) {
        outward.pass(&mut participant, LOOK)?;
        if told.elapsed() >= BEAT {
            told = Instant::now();
            beat(&counters.traffic());
        }
    }
    // What was published before the stop is still to go out.
    outward.pass(&mut participant, Duration::ZERO)?;
    inward.finish(LAST_ANSWER);
    let traffic = counters.traffic();
    beat(&traffic);
    Ok(traffic)
}
