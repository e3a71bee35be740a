//! What the plan saves: small pictures of the same view, planned and with more of the model, in
//! turns, so that whatever else the machine does falls on all of them.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use lightbox_core::plan::Part;
use lightbox_core::scene::CameraDesc;
use lightbox_core::{RenderSettings, View};
use serde::Serialize;

/// Pixels of a small picture: enough for every thread to have some tiles.
const PIXELS: f64 = 8192.0;

/// Rounds are dealt out to so many groups; each tells of a saving by its fastest pictures, which
/// nothing else has held up. A saving counts as measured if all agree on it, one in 32 times by
/// chance, and if it is this share of the time.
const GROUPS: usize = 6;
const LEAST_SHARE: f64 = 0.005;

/// Least rounds, and time after which there are no more.
const ROUNDS: usize = 5 * GROUPS;
const PATIENCE: Duration = Duration::from_millis(600);

/// Time that is saved, milliseconds per sample of every pixel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Saving {
    /// Negative if it takes longer instead.
    pub ms: f64,
    /// Standard error.
    pub error: f64,
    /// Whether there is more to it than chance.
    pub is_measurable: bool,
}

/// What the plan saves of a view.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Savings {
    /// Milliseconds that a sample of every pixel takes with the full model.
    pub full_ms: f64,
    /// By all that is left out.
    pub total: Saving,
    /// By each part.
    pub parts: Vec<(Part, Saving)>,
}

/// A measurement in progress.
#[derive(Debug)]
pub struct Trial {
    /// The planned view, the full one, and the planned one with each part, if there are several.
    views: Vec<View>,
    parts: Vec<Part>,
    /// Of each round, by view.
    rounds: Vec<Vec<f64>>,
    took: Duration,
    /// Pixels of the picture for one of the small.
    scale: f64,
}

impl Trial {
    /// Sets up what a view from some camera is measured by. `None` if its plan leaves out nothing;
    /// the error is one line.
    pub fn new(view: &View, camera: &CameraDesc) -> Result<Option<Self>, String> {
        let RenderSettings { width, height, .. } = view.settings;
        let pixels = f64::from(width) * f64::from(height);
        let shrink = (PIXELS / pixels).sqrt().min(1.0);
        let small = |n: u32| ((f64::from(n) * shrink).round() as u32).max(1);
        let settings = RenderSettings {
            width: small(width),
            height: small(height),
            ..view.settings
        };
        let planned = View::new(view.scene.clone(), camera, settings)?;
        let parts: Vec<Part> = planned.plan().left_out().collect();
        if parts.is_empty() {
            return Ok(None);
        }
        let mut views = vec![planned.clone(), planned.full()?];
        // One part is the whole plan: two figures for one thing would differ by noise.
        for part in parts.iter().filter(|_| parts.len() > 1) {
            views.push(planned.with(*part)?);
        }
        Ok(Some(Self {
            views,
            parts,
            rounds: Vec::new(),
            took: Duration::ZERO,
            scale: pixels / (f64::from(settings.width) * f64::from(settings.height)),
        }))
    }

    /// Renders each small picture once, on the threads of the current rayon pool. Nothing is kept of
    /// a round that was interrupted.
    pub fn round(&mut self, cancel: &AtomicBool) {
        let start = Instant::now();
        let mut round = vec![0.0; self.views.len()];
        for i in 0..self.views.len() {
            // Each comes first in turn.
            let i = (i + self.rounds.len()) % self.views.len();
            let film = self.views[i].film();
            let start = Instant::now();
            self.views[i].render(&film, 1, cancel);
            round[i] = start.elapsed().as_secs_f64() * 1e3 * self.scale;
        }
        self.took += start.elapsed();
        if !cancel.load(Ordering::Relaxed) {
            self.rounds.push(round);
        }
    }

    /// The result, once there are enough rounds.
    pub fn savings(&self) -> Option<Savings> {
        if self.rounds.len() < ROUNDS || self.took < PATIENCE {
            return None;
        }
        let fastest = |group: usize, view: usize| {
            let rounds = self.rounds.iter().skip(group).step_by(GROUPS);
            rounds
                .map(|round| round[view])
                .fold(f64::INFINITY, f64::min)
        };
        let n = GROUPS as f64;
        let full_ms = (0..GROUPS).map(|group| fastest(group, 1)).sum::<f64>() / n;
        let saving = |view: usize| {
            let saved: [f64; GROUPS] =
                std::array::from_fn(|group| fastest(group, view) - fastest(group, 0));
            let ms = saved.iter().sum::<f64>() / n;
            let squares = saved.iter().map(|s| (s - ms).powi(2)).sum::<f64>();
            let agree = saved.iter().all(|s| *s > 0.0) || saved.iter().all(|s| *s < 0.0);
            Saving {
                ms,
                error: (squares / (n * (n - 1.0))).sqrt(),
                is_measurable: agree && ms.abs() > LEAST_SHARE * full_ms,
            }
        };
        let total = saving(1);
        let parts = match self.parts.as_slice() {
            [part] => vec![(*part, total)],
            parts => (2..).zip(parts).map(|(i, p)| (*p, saving(i))).collect(),
        };
        Some(Savings {
            full_ms,
            total,
            parts,
        })
    }
}

impl Savings {
    /// One line: the saving of the whole plan.
    pub fn text(&self) -> String {
        if self.total.is_measurable {
            format!(
                "{:.2} ± {:.2} ms of {:.2} ms per sample of every pixel",
                self.total.ms, self.total.error, self.full_ms
            )
        } else {
            format!(
                "nothing measurable of {:.2} ms per sample of every pixel",
                self.full_ms
            )
        }
    }
}

impl Saving {
    /// In a few characters.
    pub fn text(&self) -> String {
        if self.is_measurable {
            format!("{:.2} ms", self.ms)
        } else {
            "nothing measurable".into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial<const N: usize>(parts: &[Part], rounds: &[[f64; N]]) -> Trial {
        Trial {
            views: Vec::new(),
            parts: parts.to_vec(),
            rounds: rounds.iter().map(|round| round.to_vec()).collect(),
            took: PATIENCE,
            scale: 1.0,
        }
    }

    #[test]
    fn savings_are_told_from_chance() {
        // Planned, full, with a tree, with a choice: the machine slows down by and by.
        let rounds: Vec<[f64; 4]> = (0..ROUNDS as u8)
            .map(|i| {
                let (slow, jitter) = (1.0 + 0.1 * f64::from(i), f64::from(i % 3) - 1.0);
                let (planned, full) = (10.0 * slow, 12.0 * slow);
                [planned, full, planned + 0.3 * jitter, 11.5 * slow]
            })
            .collect();
        let parts = [Part::Tree, Part::LightChoice];
        let savings = trial(&parts, &rounds).savings().expect("enough rounds");
        assert!(savings.total.is_measurable, "{savings:?}");
        assert!((2.0..5.0).contains(&savings.total.ms));
        let (part, saving) = savings.parts[0];
        assert!(part == Part::Tree && !saving.is_measurable, "{saving:?}");
        assert_eq!(saving.text(), "nothing measurable");
        let (part, saving) = savings.parts[1];
        assert!(
            part == Part::LightChoice && saving.is_measurable,
            "{saving:?}"
        );
        assert!(trial(&parts, &rounds[..ROUNDS - 1]).savings().is_none());
        // One part saves what the plan saves.
        let two: Vec<[f64; 2]> = rounds.iter().map(|r| [r[0], r[1]]).collect();
        let savings = trial(&parts[..1], &two).savings().expect("enough rounds");
        assert_eq!(savings.parts, [(Part::Tree, savings.total)]);
    }

    #[test]
    fn a_view_is_measured_with_each_part() {
        let path = "builtin:cornell-box.toml".as_ref();
        let scene = lightbox_core::scene::load(path)
            .and_then(|source| source.build(&lightbox_core::scene::unwatched))
            .map(std::sync::Arc::new)
            .expect("a shipped scene");
        let camera = scene.desc().camera;
        let view = View::of(scene).expect("a view");
        let mut trial = Trial::new(&view, &camera)
            .expect("a view")
            .expect("a plan that leaves out something");
        trial.round(&AtomicBool::new(true));
        assert!(trial.rounds.is_empty(), "an interrupted round was kept");
        let never = AtomicBool::new(false);
        while trial.savings().is_none() {
            trial.round(&never);
        }
        let savings = trial.savings().expect("enough rounds");
        let left_out: Vec<Part> = view.plan().left_out().collect();
        let measured: Vec<Part> = savings.parts.iter().map(|(part, _)| *part).collect();
        assert_eq!(measured, left_out);
        assert!(savings.full_ms > 0.0);
        let mut full = view;
        full.settings.full_model = true;
        assert!(Trial::new(&full, &camera).expect("a view").is_none());
    }
}
