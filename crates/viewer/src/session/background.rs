//! Work on threads of their own: reading files, building accelerators.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use lightbox_core::scene::{Phase, Watcher};

use super::{Inbox, Outbox, Shared, lock};

/// Work under way, for display.
#[derive(Clone, Debug)]
pub(super) struct Loading {
    /// Tells it from what has stood in its place before.
    number: u64,
    /// What is loaded.
    pub label: String,
    /// How far it is.
    pub phase: Phase,
}

impl Shared {
    /// Starts work whose place is `slot`; whatever stood there is superseded, and its result will
    /// not be delivered. `deliver` puts the result into the inbox, with the number returned here.
    pub(super) fn start<T: 'static>(
        self: &Arc<Self>,
        slot: fn(&mut Outbox) -> &mut Option<Loading>,
        label: String,
        work: impl FnOnce(Watcher<'_>) -> Result<T, String> + Send + 'static,
        deliver: fn(&mut Inbox, u64, Result<T, String>),
    ) -> u64 {
        let number = {
            let mut outbox = lock(&self.outbox);
            outbox.works += 1;
            let number = outbox.works;
            *slot(&mut outbox) = Some(Loading {
                number,
                label: label.clone(),
                phase: Phase::Reading,
            });
            number
        };
        let shared = self.clone();
        let run = move || {
            let progress = |phase| {
                let mut outbox = lock(&shared.outbox);
                match slot(&mut outbox).as_mut().filter(|l| l.number == number) {
                    Some(loading) => loading.phase = phase,
                    None => return ControlFlow::Break(()),
                }
                drop(outbox);
                (shared.wake)();
                ControlFlow::Continue(())
            };
            // A panic must not leave the window waiting for ever.
            let result = catch_unwind(AssertUnwindSafe(|| work(&progress))).unwrap_or_else(|_| {
                Err(format!(
                    "{label}: opening it failed by a defect in lightbox; please report it"
                ))
            });
            let mut outbox = lock(&shared.outbox);
            if slot(&mut outbox).take_if(|l| l.number == number).is_none() {
                return; // The user has asked for something else since.
            }
            // Under the lock: nothing that is started later can be delivered before.
            shared.send(true, |inbox| deliver(inbox, number, result));
            drop(outbox);
            (shared.wake)();
        };
        if let Err(e) = std::thread::Builder::new()
            .name("lightbox-load".into())
            .spawn(run)
        {
            *slot(&mut lock(&self.outbox)) = None;
            self.notify(format!("cannot start a thread ({e})"), true);
        }
        number
    }
}
