//! What is shown of a picture: its tiles in the colours of a look, all at once or a slice at a time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use lightbox_core::film::TileRect;
use lightbox_core::image_io::tone_mapped;
use lightbox_core::{Film, View};
use rayon::prelude::*;

use super::super::Snapshot;
use super::super::look::Look;
use super::super::preview::enlarge;
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
            self.rgb.clear();
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
            let [width, height] = self.size();
            // Other colours beside those of this view would mislead.
            self.rgb = vec![0; 3 * width * height];
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
        if self.rgb.is_empty() {
            self.rgb = match &self.backdrop {
                Some((image, scale)) => {
                    enlarge(&tone_mapped(image, look.tone), *scale, width, height)
                }
                None => vec![0; 3 * width as usize * height as usize],
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
        put(&mut self.rgb, width as usize, drawn);
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
            image: Snapshot::image(self.size(), &self.rgb),
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

/// Puts tiles where they belong in a picture of some width.
pub(super) fn put(rgb: &mut [u8], width: usize, tiles: Vec<Painted>) {
    for (rect, pixels) in tiles {
        for (y, row) in (rect.y as usize..).zip(pixels.chunks_exact(rect.width as usize)) {
            let start = 3 * (y * width + rect.x as usize);
            rgb[start..start + 3 * row.len()].copy_from_slice(row.as_flattened());
        }
    }
}
