//! What is shown of a picture: its tiles in the colours of a look, all at once or a slice at a time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use lightbox_core::film::TileRect;
use lightbox_core::image_io::tone_mapped;
use lightbox_core::{Film, View};
use rayon::prelude::*;

use super::super::look::Look;
use super::super::preview::enlarge;
use super::super::{Patches, Snapshot};
use super::{Picture, SLICE, TILES};
use crate::aov::Scope;

impl Picture {
    /// Shows and measures all there is once more, with another look or reference: at once, or, where
    /// no samples are needed, as much as takes about [`SLICE`]; nothing if it was interrupted.
    pub fn redraw(&mut self, look: Look, cancel: &AtomicBool) -> Option<Snapshot> {
        if look.aov.needs_no_samples() {
            self.draw_on(look, cancel)?;
        } else {
            let all = self.order.clone();
            self.shown = Patches::default();
            self.drawn = (look.aov, all.len());
            self.draw(&all, look, &AtomicBool::new(false))?;
        }
        if self.is_drawn() {
            let all = self.order.clone();
            self.measure(&all);
            if self.next_tile == self.film.tiles() {
                self.measured = self.film.samples();
            }
        }
        Some(self.snapshot(look))
    }

    /// Whether everything is there of the view that was shown last.
    pub fn is_drawn(&self) -> bool {
        self.drawn.1 == self.film.tiles()
    }

    /// Goes on with a view that needs no samples.
    fn draw_on(&mut self, look: Look, cancel: &AtomicBool) -> Option<()> {
        if self.drawn.0 != look.aov {
            self.drawn = (look.aov, 0);
            // Other colours beside those of this view would mislead.
            self.shown = Patches::black(self.size());
        }
        let never = AtomicBool::new(false);
        let cancel = if self.is_shown { cancel } else { &never };
        let (order, start) = (self.order.clone(), Instant::now());
        while !self.is_drawn() && start.elapsed() < SLICE {
            let end = self.drawn.1 + TILES * rayon::current_num_threads();
            let end = end.min(order.len());
            self.draw(&order[self.drawn.1..end], look, cancel)?;
            self.drawn.1 = end;
        }
        Some(())
    }

    /// Brings some tiles of what is shown up to date; `None` if it was interrupted.
    pub(super) fn draw(&mut self, tiles: &[usize], look: Look, cancel: &AtomicBool) -> Option<()> {
        let [width, height] = self.film.size();
        if self.shown.is_empty() {
            self.shown = match &self.backdrop {
                Some((image, scale)) => {
                    let preview = tone_mapped(image, look.tone);
                    Patches::from_rgb(self.size(), &enlarge(&preview, *scale, width, height))
                }
                None => Patches::black(self.size()),
            };
        }
        let drawn = paint(
            look,
            &self.scope(look),
            &self.view,
            &self.film,
            tiles,
            cancel,
        )?;
        put(&mut self.shown, drawn);
        self.is_shown = true;
        Some(())
    }

    pub(super) fn scope(&self, look: Look) -> Scope<'_> {
        let View {
            scene,
            camera,
            settings,
            ..
        } = &self.view;
        let reference = self.reference.as_deref();
        Scope::new(scene, camera.eye(), settings, look.tone, reference)
    }

    pub(super) fn snapshot(&self, look: Look) -> Snapshot {
        let backdrop = self.backdrop.as_ref().map(|(_, scale)| *scale);
        Snapshot {
            size: self.size(),
            patches: self.shown.clone(),
            picture: self.size(),
            preview: match look.aov.needs_no_samples() {
                true => (!self.is_drawn()).then_some(1),
                false => backdrop.filter(|_| self.film.samples() == 0),
            },
            past: None,
            aov: look.aov,
            number: 0,
        }
    }
}

/// sRGB of the pixels of a tile.
pub(super) type Painted = (TileRect, Vec<[u8; 3]>);

/// The colours of some tiles of a picture; `None` if it was interrupted.
pub(super) fn paint(
    look: Look,
    scope: &Scope<'_>,
    view: &View,
    film: &Film,
    tiles: &[usize],
    cancel: &AtomicBool,
) -> Option<Vec<Painted>> {
    let drawn = tiles
        .par_iter()
        .filter(|_| !cancel.load(Ordering::Relaxed))
        .filter_map(|i| look.aov.tile(scope, view, film, *i));
    let drawn = drawn.collect();
    (!cancel.load(Ordering::Relaxed)).then_some(drawn)
}

/// Puts tiles where they belong in a picture.
pub(super) fn put(shown: &mut Patches, tiles: Vec<Painted>) {
    for (rect, pixels) in tiles {
        shown.put(rect, &pixels);
    }
}
