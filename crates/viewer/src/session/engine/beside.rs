//! What goes on beside the picture: its samples are kept in a file, its plan is measured, kept
//! pictures are looked back to and compared with.

use std::path::PathBuf;
use std::sync::Arc;

use lightbox_core::image_io::tone_mapped;
use lightbox_core::{Image, part};

use super::super::history::Point;
use super::super::keeper::Keeper;
use super::super::look::Look;
use super::super::{Kept, Patches, Reference, Referring, Snapshot, lock};
use super::Engine;
use crate::aov::Aov;
use crate::savings::Trial;

impl Engine<'_> {
    /// Keeps the samples of the picture in a file from now on.
    pub(super) fn keep(&mut self, path: PathBuf) {
        let checked = part::check_writable(&path).and_then(|()| match &self.picture {
            Some(picture) if picture.film.samples() > 0 => Ok(picture),
            _ => Err("there are no samples to save yet".into()),
        });
        match checked {
            Ok(picture) => {
                if let Some(before) = self.keeper.take() {
                    before.close(self.shared, picture.progress.seconds);
                }
                let (view, film, tone) = (&picture.view, picture.film.clone(), self.look.tone);
                self.keeper = Some(Keeper::new(path, view, tone, film, 0));
                self.tend(true);
            }
            Err(message) => self.shared.notify(message, true),
        }
    }

    /// Has the samples written if it is time to, or `now`.
    pub(super) fn tend(&mut self, now: bool) {
        let (Some(keeper), Some(picture)) = (&mut self.keeper, &self.picture) else {
            return;
        };
        let rests = now || self.paused || picture.is_done();
        keeper.tend(self.shared, picture.progress.seconds, rests);
    }

    /// Takes note of how a writing went.
    pub(super) fn kept(&mut self, (path, kept): Kept) {
        let Some(keeper) = self.keeper.as_mut().filter(|k| k.path() == path) else {
            return;
        };
        match kept {
            Ok(samples) if keeper.written(samples) => {
                let path = keeper.path().display();
                let text =
                    format!("saved {path}; kept up to date as long as the picture is the same");
                self.shared.notify(text, false);
            }
            Ok(_) => {}
            Err(message) => {
                self.keeper = None;
                self.shared.notify(message, true);
            }
        }
    }

    /// Sets up what the plan of the present view is measured by.
    pub(super) fn measure_plan(&mut self) {
        let Some(picture) = &self.picture else { return };
        match Trial::new(&picture.view, &picture.camera) {
            Ok(trial) => self.trial = trial,
            Err(message) => self.shared.notify(message, true),
        }
    }

    /// Readies the picture that is looked back to.
    pub(super) fn look_back(&mut self) {
        let kept = self.past.and_then(|moment| self.history.picture(moment));
        let past = kept.map(|(point, image)| {
            self.snapshots += 1;
            Arc::new(still(image, self.look, self.snapshots, Some(*point)))
        });
        lock(&self.shared.outbox).past = past;
    }

    /// Readies the reference to be shown beside the picture.
    pub(super) fn show_other(&mut self) {
        let reference = self.reference.as_ref().filter(|_| self.compares);
        let other = reference.map(|reference| {
            self.snapshots += 1;
            Arc::new(still(&reference.image, self.look, self.snapshots, None))
        });
        lock(&self.shared.outbox).other = other;
        (self.shared.wake)();
    }

    pub(super) fn refer(&mut self, referring: Referring) {
        self.reference = match (referring, &self.picture) {
            (Referring::To(reference), _) => Some(reference),
            (Referring::ToPresent, Some(picture)) if picture.film.samples() > 0 => {
                let settings = &picture.view.settings;
                Some(Arc::new(Reference {
                    image: self.pool.install(|| picture.film.develop()).into(),
                    name: format!("{} spp {}", picture.film.samples(), settings.method),
                    stream: Some((settings.sampler, settings.seed)),
                }))
            }
            (Referring::ToPresent, _) => return,
            (Referring::ToNone, _) => None,
        };
        Arc::make_mut(&mut self.history).refer(self.reference.as_deref());
        if let Some(picture) = &mut self.picture {
            picture.refer(self.reference.clone());
            // Measured anew as it is drawn.
            self.stale |= picture.film.samples() > 0;
        }
    }
}

/// A picture that no longer changes, as it is shown.
fn still(image: &Image, look: Look, number: u64, past: Option<Point>) -> Snapshot {
    let size = [image.width as usize, image.height as usize];
    Snapshot {
        size,
        patches: Patches::from_rgb(size, &tone_mapped(image, look.tone)),
        picture: size,
        preview: None,
        past,
        aov: Aov::COLOR,
        number,
    }
}
