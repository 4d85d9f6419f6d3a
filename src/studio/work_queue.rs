//! Work that is done one request after the other, on all threads of a pool; of requests on one subject that wait only
//! the newest is worked on.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};

/// Work for one request.
pub(super) type Job = Box<dyn FnOnce() + Send>;

/// Subject of requests of which only the newest counts.
#[derive(Debug, Default)]
pub(super) struct Subject(AtomicU64);

/// A request that was the newest of its subject.
#[derive(Debug)]
pub(super) struct NewestRequest {
    subject: Arc<Subject>,
    number: u64,
}

impl Subject {
    /// The newest request so far.
    pub(super) fn newest(self: &Arc<Self>) -> NewestRequest {
        NewestRequest { subject: Arc::clone(self), number: self.0.load(Ordering::SeqCst) }
    }
}

impl NewestRequest {
    /// Whether a newer one has come.
    pub(super) fn is_superseded(&self) -> bool {
        self.subject.0.load(Ordering::SeqCst) != self.number
    }
}

/// Requests that wait for the thread that does the work.
#[derive(Debug)]
pub(super) struct WorkQueue(Sender<Job>);

impl WorkQueue {
    /// A queue, and its work for the thread that does it.
    pub(super) fn new() -> (Self, Receiver<Job>) {
        let (sender, receiver) = channel();
        (Self(sender), receiver)
    }

    /// What `work` makes; none where a newer request on the same subject came before its turn.
    pub(super) fn newest<T: Send + 'static>(
        &self,
        subject: &Arc<Subject>,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Option<T> {
        let number = subject.0.fetch_add(1, Ordering::SeqCst) + 1;
        let (made, result) = channel();
        let subject = Arc::clone(subject);
        let job = move || {
            if subject.0.load(Ordering::SeqCst) == number {
                // (Who asked may be gone.)
                let _ = made.send(work());
            }
        };
        self.0.send(Box::new(job)).ok()?;
        result.recv().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    #[test]
    fn of_waiting_requests_only_the_newest_is_worked_on() {
        let (queue, jobs) = WorkQueue::new();
        let subject = Arc::<Subject>::default();
        let done = thread::scope(|scope| {
            let mut asked = Vec::new();
            for k in 1..=3 {
                let (queue, subject) = (&queue, &subject);
                asked.push(scope.spawn(move || queue.newest(subject, move || k)));
                while subject.0.load(Ordering::SeqCst) < k {
                    thread::yield_now();
                }
            }
            jobs.iter().take(3).for_each(|job| job());
            asked.into_iter().map(|asked| asked.join().unwrap()).collect::<Vec<_>>()
        });
        assert_eq!(done, [None, None, Some(3)]);
    }
}
