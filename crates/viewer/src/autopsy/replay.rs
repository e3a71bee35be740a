//! One sample of the pixel, step by step.

use egui::{Color32, RichText, Ui};
use glam::Vec3;
use lightbox_core::Scene;
use lightbox_core::integrator::replay::{Segment, Strategy};

use super::draw::{COLORS, Canvas, SHADED};
use super::trace::{Found, Path};
use crate::panels::format::{count, length, short};
use crate::panels::slider_row;

/// Which path, and how far it is shown.
pub struct Replay {
    /// Index of its sample.
    sample: u64,
    /// Segments shown.
    step: usize,
    shows_all: bool,
}

impl Default for Replay {
    fn default() -> Self {
        Self {
            sample: 0,
            step: usize::MAX,
            shows_all: true,
        }
    }
}

impl Replay {
    /// Place in the list of the path that is looked at.
    fn chosen(&self, paths: &[Path]) -> usize {
        let place = paths.partition_point(|path| path.sample < self.sample);
        place.min(paths.len().saturating_sub(1))
    }

    /// Draws the paths into the picture.
    pub fn draw(&self, canvas: &Canvas<'_>, paths: &[Path]) {
        if self.shows_all {
            for path in paths {
                canvas.faint(&path.segments);
            }
        }
        if let Some(path) = paths.get(self.chosen(paths)) {
            canvas.path(&path.segments[..self.step.min(path.segments.len())]);
        }
    }

    /// The controls, and what each segment has found.
    pub fn ui(&mut self, ui: &mut Ui, scene: &Scene, found: &Found) {
        ui.add_space(6.0);
        ui.strong("One sample, step by step");
        let paths = &found.paths;
        if paths.is_empty() {
            return;
        }
        let mut place = self.chosen(paths);
        let tip = "Which of the traced paths: the first ones and the brightest.";
        if slider_row(ui, "Path", tip, &mut place, 0, 0..=paths.len() - 1) {
            self.sample = paths[place].sample;
            self.step = usize::MAX;
        }
        let path = &paths[self.chosen(paths)];
        let last = path.segments.len();
        let mut step = self.step.clamp(1, last);
        let tip = "How far the path is drawn, segment by segment from the camera.";
        if slider_row(ui, "Step", tip, &mut step, last, 1..=last) {
            self.step = step;
        }
        ui.horizontal(|ui| {
            let tip = "Goes to the brightest sample there is.";
            if ui.button("Brightest").on_hover_text(tip).clicked()
                && let Some(brightest) = found.paths.iter().max_by(|a, b| {
                    a.radiance
                        .element_sum()
                        .total_cmp(&b.radiance.element_sum())
                })
            {
                (self.sample, self.step) = (brightest.sample, usize::MAX);
            }
            ui.checkbox(&mut self.shows_all, "All paths")
                .on_hover_text("Draws the other paths too, faintly.");
        });
        ui.label(format!(
            "sample {}, RGB {}",
            count(path.sample),
            rgb(path.radiance)
        ));
        for segment in path.segments.iter().take(step) {
            if segment.is_branch {
                ui.weak(format!("Another way from {}.:", segment.number - 1));
            }
            line(ui, scene, segment);
        }
        if step == last {
            ui.weak(ending(path, scene.desc().render.depth));
        }
    }
}

fn rgb(v: Vec3) -> String {
    v.to_array().map(short).join(" ")
}

/// Where a segment ends, and what was found there.
fn line(ui: &mut Ui, scene: &Scene, segment: &Segment) {
    let number = segment.number;
    let place = match segment.end {
        Some((end, prim)) => format!(
            "{number}. {}, {} after {}; carries {}",
            scene.object(prim).label,
            scene.material_names()[scene.slot(prim) as usize],
            length(segment.from.distance(end)),
            rgb(segment.throughput),
        ),
        None => format!(
            "{number}. leaves the scene; carries {}",
            rgb(segment.throughput)
        ),
    };
    ui.label(place);
    let mut found = |color: Color32, text: String| {
        ui.label(RichText::new(format!("    {text}")).color(color));
    };
    if segment.met != Vec3::ZERO {
        let color = COLORS[Strategy::Met as usize];
        found(color, format!("met: {}", rgb(segment.met)));
    }
    for aim in &segment.aims {
        let light = &scene.object(aim.light).label;
        let how = match aim.strategy {
            Strategy::Met | Strategy::Aimed => format!("aimed at {light}"),
            Strategy::ByMirror => format!("aimed at {light} by mirror"),
        };
        let (color, what) = match aim.is_free {
            true => (COLORS[aim.strategy as usize], rgb(aim.radiance)),
            false => (SHADED, "in the shade".into()),
        };
        found(color, format!("{how}: {what}"));
    }
}

/// Why a path does not go on.
fn ending(path: &Path, depth: u32) -> &'static str {
    match path.segments.last() {
        Some(segment) if segment.end.is_none() => "It has left the scene.",
        Some(segment) if segment.number >= depth => "It has come to the depth of paths.",
        _ => "It ends here: absorbed, or by Russian roulette.",
    }
}
