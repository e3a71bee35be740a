//! Which scene is rendered: that of another file, or an edited one, with as little new work as the
//! edit allows.

use std::sync::Arc;

use lightbox_core::{RenderSettings, Scene, SceneDesc, View};

use super::super::keeper::{Keeper, Taken};
use super::super::picture::Picture;
use super::super::preview::Governor;
use super::super::{Loaded, Shown, lock};
use super::Engine;

impl Engine<'_> {
    /// Goes over to another file.
    pub(super) fn open(&mut self, loaded: Loaded) {
        let Loaded {
            source,
            scene,
            tone,
            opening,
            taken,
        } = loaded;
        self.abandon_rebuild();
        self.source = Some(source);
        self.opening = opening;
        self.scene = Some(scene.clone());
        self.governor = Governor::default();
        self.look.tone = tone.unwrap_or(self.look.tone);
        self.desc = Arc::new(scene.desc().clone());
        self.opened += 1;
        {
            let mut outbox = lock(&self.shared.outbox);
            outbox.status.opened = self.opened;
            outbox.status.tone = tone;
            outbox.status.scene = Some(scene);
            outbox.status.desc = self.desc.clone();
        }
        self.begin(taken);
    }

    /// Goes over to a scene with edited shapes.
    pub(super) fn take_up(&mut self, number: u64, scene: Result<Scene, String>) {
        let Some((_, wanted)) = self.rebuilding.take_if(|(n, _)| *n == number) else {
            return; // It has been superseded.
        };
        match scene {
            Ok(scene) => {
                self.scene = Some(Arc::new(scene));
                // Edits may have come while the accelerator was built.
                self.edit(self.desc.clone());
            }
            Err(message) => {
                self.shared.notify(message, true);
                if wanted != self.desc {
                    // What was wrong may have been put right while the accelerator was built.
                    self.edit(self.desc.clone());
                }
            }
        }
    }

    /// Goes over to an edited description with as little new work as it allows.
    pub(super) fn edit(&mut self, desc: Arc<SceneDesc>) {
        let Some(mut scene) = self.scene.clone() else {
            return;
        };
        self.desc = desc.clone();
        if scene.rebuilds_for(&desc) {
            self.rebuild(&scene, desc.clone());
            // The old shapes from the new place, until the new are ready.
            let shows = |picture: &Picture| {
                picture.camera == desc.camera && Arc::ptr_eq(&picture.view.scene, &scene)
            };
            if !self.picture.as_ref().is_some_and(shows) {
                self.restart();
            }
            return;
        }
        self.abandon_rebuild();
        let same_surfaces = (&desc.materials, desc.background)
            == (&scene.desc().materials, scene.desc().background)
            && desc.same_assignments(scene.desc());
        if !same_surfaces {
            match scene.edit((*desc).clone(), &lightbox_core::scene::unwatched) {
                Ok(edited) => scene = Arc::new(edited),
                Err(e) => return self.shared.notify(e.to_string(), true),
            }
            self.scene = Some(scene.clone());
        }
        match &mut self.picture {
            Some(picture)
                if Arc::ptr_eq(&picture.view.scene, &scene)
                    && picture.camera == desc.camera
                    && desc.render
                        == (RenderSettings {
                            samples: desc.render.samples,
                            ..picture.view.settings
                        }) =>
            {
                picture.view.settings.samples = desc.render.samples;
                self.budget();
            }
            _ => self.restart(),
        }
    }

    /// Has an accelerator built in the background. One at a time: a drag would start one for each
    /// frame and see none. What has changed since is seen to when it is there.
    fn rebuild(&mut self, scene: &Arc<Scene>, desc: Arc<SceneDesc>) {
        if self.rebuilding.is_some() {
            return;
        }
        let (scene, edited) = (scene.clone(), desc.clone());
        let number = self.shared.start(
            |outbox| &mut outbox.rebuilding,
            scene.path().display().to_string(),
            move |watcher| {
                scene
                    .edit((*edited).clone(), watcher)
                    .map_err(|e| e.to_string())
            },
            |inbox, number, scene| inbox.rebuilt = Some((number, scene)),
        );
        self.rebuilding = Some((number, desc));
    }

    /// Drops an accelerator in the making: what asked for it has been taken back.
    fn abandon_rebuild(&mut self) {
        if self.rebuilding.take().is_some() {
            lock(&self.shared.outbox).rebuilding = None;
        }
    }

    /// Starts the present description's picture anew.
    fn restart(&mut self) {
        self.begin(None);
    }

    /// Starts the present description's picture, with the samples that the file it was opened from
    /// holds.
    pub(super) fn begin(&mut self, taken: Option<Taken>) {
        let Some(scene) = self.scene.clone() else {
            return;
        };
        match View::new(scene, &self.desc.camera, self.desc.render) {
            Ok(view) => {
                self.tend(true); // What is left behind is kept to its last sample.
                let kept = self.keeper.take();
                (self.trial, self.savings) = (None, None);
                let mut picture = Picture::new(view, self.desc.camera, &self.governor);
                picture.refer(self.reference.clone());
                picture.prefer(self.region);
                self.stale |= taken.is_some() || self.look.aov.needs_no_samples();
                if let Some(taken) = taken {
                    picture.take_up(taken);
                    let (path, film) = (picture.view.scene.path().to_owned(), &picture.film);
                    let saved = film.samples();
                    let tone = self.look.tone;
                    let keeper = Keeper::new(path, &picture.view, tone, film.clone(), saved);
                    self.keeper = Some(keeper);
                } else if let Some(keeper) = kept {
                    let path = keeper.path().display();
                    let text = format!("{path}: keeps the picture as it was; save this one anew");
                    self.shared.notify(text, false);
                }
                let is_edited = self.source.as_ref().is_some_and(|source| {
                    let (camera, render) = (source.desc.camera, source.desc.render);
                    let desc = picture.view.scene.desc().clone();
                    source.desc
                        != (SceneDesc {
                            camera,
                            render,
                            ..desc
                        })
                });
                let mut outbox = lock(&self.shared.outbox);
                outbox.status.is_edited = is_edited;
                outbox.shown = Some(Shown {
                    view: picture.view.clone(),
                    camera: picture.camera,
                    film: picture.film.clone(),
                    is_edited,
                });
                drop(outbox);
                let was_done = self.picture.as_ref().is_some_and(Picture::is_done);
                let path = picture.view.scene.path().to_owned();
                Arc::make_mut(&mut self.history).begin(self.desc.clone(), path, was_done);
                self.picture = Some(picture);
                self.budget();
            }
            Err(message) => self.shared.notify(message, true),
        }
    }
}
