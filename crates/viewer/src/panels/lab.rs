//! The stability lab: where methods fail, what the naive one does there, and what lightbox does.

use std::path::PathBuf;
use std::sync::Arc;

use egui::{
    Color32, Context, Frame, Grid, Margin, Panel, ProgressBar, RichText, ScrollArea, TextureHandle,
    Ui, Window,
};
use lightbox_core::Image;
use lightbox_core::color::ToneMap;
use lightbox_core::image_io::tone_mapped;
use lightbox_core::lab::{AREAS, Case, Check, Figure, Verdict, cases, find, number};

use super::{follow_focus, format};
use crate::keys::Action;
use crate::lab::{Lab, Pair, Stand};

const GOOD: Color32 = Color32::from_rgb(90, 180, 100);
const BAD: Color32 = Color32::from_rgb(230, 90, 80);

/// Width of the list, points.
const LIST: f32 = 270.0;

/// The lab's window.
pub struct LabPanel {
    lab: Lab,
    /// Whether it is shown.
    pub is_open: bool,
    /// Id of the case that is looked at.
    chosen: &'static str,
    /// Its pictures on the graphics card.
    textures: Option<(&'static str, [TextureHandle; 2])>,
}

impl LabPanel {
    /// A closed window over a lab in which nothing was measured.
    pub fn new(ctx: &Context) -> Self {
        let ctx = ctx.clone();
        Self {
            lab: Lab::new(move || ctx.request_repaint()),
            is_open: false,
            chosen: cases().next().map_or("", |case| case.id),
            textures: None,
        }
    }

    /// Shows the window while it is open.
    pub fn ui(&mut self, ctx: &Context, actions: &mut Vec<Action>) {
        let mut is_open = self.is_open;
        Window::new("Stability lab")
            .open(&mut is_open)
            .default_size([840.0, 520.0])
            .collapsible(false)
            .show(ctx, |ui| {
                Panel::top("lab controls").show(ui, |ui| self.controls(ui));
                Panel::left("lab cases")
                    .exact_size(LIST)
                    .show(ui, |ui| self.list(ui));
                ScrollArea::vertical()
                    .id_salt("lab case")
                    .auto_shrink(false)
                    .show(ui, |ui| {
                        let Some(case) = find(self.chosen) else {
                            return;
                        };
                        Frame::new()
                            .inner_margin(Margin::symmetric(10, 4))
                            .show(ui, |ui| {
                                self.case(ui, case, actions);
                                follow_focus(ui);
                            });
                    });
            });
        self.is_open = is_open;
    }

    /// All cases at once, and how far that is.
    fn controls(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            if let Some([done, wanted]) = self.lab.progress() {
                if ui
                    .button("Cancel")
                    .on_hover_text("Finishes the case in work and drops the others.")
                    .clicked()
                {
                    self.lab.cancel();
                }
                ui.add(ProgressBar::new(done as f32 / wanted as f32).desired_width(120.0))
                    .accessible_name("Lab progress");
                ui.label(format!("{done} of {wanted}"));
            } else if ui
                .button("Run all")
                .on_hover_text("Measures every case, in the background.")
                .clicked()
            {
                self.lab.measure(cases());
            }
            ui.separator();
            let stands: Vec<Stand> = cases().map(|case| self.lab.stand(case)).collect();
            let count = |of| stands.iter().filter(|s| **s == Stand::Settled(of)).count();
            let (hold, fail) = (count(Verdict::Holds), count(Verdict::Fails));
            let all = format::counted(stands.len() as u64, "case");
            ui.label(format!("{all}, {hold} measured and held"));
            if fail > 0 {
                ui.colored_label(BAD, format!("{fail} not held"));
            }
        });
    }

    fn list(&mut self, ui: &mut Ui) {
        ScrollArea::vertical()
            .id_salt("lab list")
            .auto_shrink(false)
            .show(ui, |ui| {
                for (area, cases) in AREAS {
                    ui.add_space(4.0);
                    ui.strong(*area);
                    for case in *cases {
                        self.entry(ui, case);
                    }
                }
                follow_focus(ui);
            });
    }

    fn entry(&mut self, ui: &mut Ui, case: &'static Case) {
        ui.horizontal(|ui| {
            let weak = ui.visuals().weak_text_color();
            let (mark, color) = match self.lab.stand(case) {
                Stand::Settled(Verdict::Holds) => ("√", GOOD),
                Stand::Settled(Verdict::Fails) => ("×", BAD),
                Stand::Settled(Verdict::ByTest) => ("t", weak),
                Stand::Settled(Verdict::Absent) => ("–", weak),
                Stand::Running => ("→", weak),
                Stand::Waiting => ("…", weak),
                Stand::Unknown => ("", weak),
            };
            let height = ui.spacing().interact_size.y;
            let place = egui::Layout::centered_and_justified(egui::Direction::TopDown);
            ui.allocate_ui_with_layout(egui::vec2(14.0, height), place, |ui| {
                ui.label(RichText::new(mark).color(color));
            });
            let text = format!("{}  {}", case.id, case.title);
            let button = egui::Button::selectable(self.chosen == case.id, text).truncate();
            if ui.add(button).on_hover_text(case.title).clicked() {
                self.chosen = case.id;
            }
        });
    }

    fn case(&mut self, ui: &mut Ui, case: &'static Case, actions: &mut Vec<Action>) {
        ui.heading(format!("{}  {}", case.id, case.title));
        self.verdict(ui, case, actions);
        for (title, text) in [
            ("What fails", case.failure),
            ("What lightbox does", case.cure),
        ] {
            ui.add_space(6.0);
            ui.strong(title);
            ui.label(text);
        }
        if let Some(figures) = self.lab.figures(case) {
            ui.add_space(8.0);
            figures_ui(ui, &figures);
        }
        if case.picture.is_some() {
            ui.add_space(8.0);
            self.pictures(ui, case);
        }
    }

    /// The verdict in words, and what can be done.
    fn verdict(&mut self, ui: &mut Ui, case: &'static Case, actions: &mut Vec<Action>) {
        let stand = self.lab.stand(case);
        ui.horizontal_wrapped(|ui| {
            // Buttons first: they must not move under the pointer when the verdict comes.
            if matches!(case.check, Check::Probe(_)) {
                let is_idle = !matches!(stand, Stand::Waiting | Stand::Running);
                let run = ui.add_enabled(is_idle, egui::Button::new("Run"));
                if run.clicked() {
                    self.lab.measure([case]);
                }
            }
            if let Some(scene) = case.scene
                && ui
                    .button("Open as scene")
                    .on_hover_text("Shows it in the window behind.")
                    .clicked()
            {
                actions.push(Action::OpenPath(PathBuf::from(scene)));
            }
            match (&case.check, stand) {
                (Check::Test(name), _) => ui.label(format!("held by the test {name}")),
                (Check::Absent(why), _) => ui.label(format!("cannot happen here: {why}")),
                (Check::Probe(_), Stand::Unknown) => ui.weak("not measured yet"),
                (Check::Probe(_), Stand::Waiting) => ui.weak("waits for its turn"),
                (Check::Probe(_), Stand::Running) => ui.weak("being measured"),
                (_, Stand::Settled(Verdict::Holds)) => ui.colored_label(GOOD, "holds"),
                (_, Stand::Settled(_)) => ui.colored_label(BAD, "does not hold"),
            }
        });
    }

    /// Naive beside lightbox.
    fn pictures(&mut self, ui: &mut Ui, case: &'static Case) {
        if self.textures.as_ref().is_none_or(|(id, _)| *id != case.id) {
            match self.lab.pictures(case) {
                Some(Some(pair)) => self.textures = Some((case.id, upload(ui, &pair))),
                Some(None) => {
                    ui.colored_label(BAD, "Drawing the pictures broke by a defect in lightbox.");
                    return;
                }
                None => {
                    ui.weak("The pictures are being drawn…");
                    return;
                }
            }
        }
        let Some((_, textures)) = &self.textures else {
            return;
        };
        let spacing = ui.spacing().item_spacing.x;
        let width = ((ui.available_width() - spacing) / 2.0).max(60.0);
        ui.horizontal_top(|ui| {
            for (texture, name) in textures.iter().zip(["naive", "lightbox"]) {
                ui.vertical(|ui| {
                    let image = egui::Image::from_texture(texture)
                        .max_width(width)
                        .alt_text(format!("{} {name}", case.id));
                    ui.add(image);
                    ui.weak(name);
                });
            }
        });
    }
}

fn upload(ui: &Ui, pair: &Arc<Pair>) -> [TextureHandle; 2] {
    [0, 1].map(|i| {
        let image: &Image = &pair[i];
        let size = [image.width as usize, image.height as usize];
        let rgb = tone_mapped(image, ToneMap::default());
        let image = egui::ColorImage::from_rgb(size, &rgb);
        ui.ctx()
            .load_texture("lab", image, egui::TextureOptions::NEAREST)
    })
}

fn figures_ui(ui: &mut Ui, figures: &[Figure]) {
    Grid::new("figures")
        .num_columns(4)
        .striped(true)
        .spacing([16.0, 4.0])
        .show(ui, |ui| {
            for title in ["measured", "naive", "lightbox", "must be"] {
                ui.strong(title);
            }
            ui.end_row();
            for figure in figures {
                ui.label(figure.what);
                let naive = figure.naive.map_or_else(|| "–".into(), number);
                match figure.naive_fails() {
                    Some(true) => ui.colored_label(BAD, naive),
                    _ => ui.label(naive),
                };
                let color = if figure.holds() { GOOD } else { BAD };
                ui.colored_label(color, number(figure.lightbox));
                ui.label(figure.bound.to_string());
                ui.end_row();
            }
        });
}
