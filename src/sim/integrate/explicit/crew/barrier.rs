//! Where threads wait for each other without going to sleep: they meet some times in every substep, and to be woken by the
//! system would take a good part of one.

use std::hint::spin_loop;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::{panicking, yield_now};

/// Looks after which a thread lets others have the processor in between.
const PATIENCE: u32 = 10_000;

/// A meeting point of so many threads.
pub struct Barrier {
    threads: usize,
    arrived: AtomicUsize,
    round: AtomicUsize,
    broken: AtomicBool,
}

impl Barrier {
    /// For so many threads.
    pub fn new(threads: usize) -> Self {
        Self {
            threads,
            arrived: AtomicUsize::new(0),
            round: AtomicUsize::new(0),
            broken: AtomicBool::new(false),
        }
    }

    /// Waits until all threads are here; what each wrote before, all may read afterwards.
    ///
    /// # Panics
    ///
    /// If another thread panicked and will never come.
    pub fn wait(&self) {
        let round = self.round.load(Ordering::Acquire);
        if self.arrived.fetch_add(1, Ordering::AcqRel) + 1 == self.threads {
            self.arrived.store(0, Ordering::Relaxed);
            self.round.store(round.wrapping_add(1), Ordering::Release);
            return;
        }
        let mut looks = 0;
        while self.round.load(Ordering::Acquire) == round {
            assert!(
                !self.broken.load(Ordering::Relaxed),
                "another thread of the step panicked"
            );
            if looks < PATIENCE {
                looks += 1;
                spin_loop();
            } else {
                yield_now();
            }
        }
    }

    /// While this lives, a panic of its thread lets the others go.
    pub fn guard(&self) -> Guard<'_> {
        Guard(self)
    }
}

/// Breaks a barrier when its thread panics.
pub struct Guard<'a>(&'a Barrier);

impl Drop for Guard<'_> {
    fn drop(&mut self) {
        if panicking() {
            self.0.broken.store(true, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod test {
    use std::sync::atomic::{AtomicU64, Ordering};
    use std::thread;

    use super::Barrier;

    #[test]
    fn nobody_goes_on_before_all_are_there() {
        const THREADS: u64 = 3;
        let (barrier, sum) = (Barrier::new(THREADS as usize), AtomicU64::new(0));
        let (barrier, sum) = (&barrier, &sum);
        thread::scope(|scope| {
            for _ in 0..THREADS {
                scope.spawn(move || {
                    for round in 1..=1000 {
                        sum.fetch_add(1, Ordering::Relaxed);
                        barrier.wait();
                        assert_eq!(sum.load(Ordering::Relaxed), THREADS * round);
                        barrier.wait();
                    }
                });
            }
        });
    }

    #[test]
    fn a_thread_that_panics_keeps_nobody_waiting() {
        let barrier = Barrier::new(2);
        thread::scope(|scope| {
            let waits = scope.spawn(|| barrier.wait());
            let panics = scope.spawn(|| {
                let _guard = barrier.guard();
                panic!("on purpose");
            });
            assert!(panics.join().is_err());
            assert!(waits.join().is_err());
        });
    }
}
