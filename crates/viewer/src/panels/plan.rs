//! The plan: what the scene uses, what the picture is made without, what is lost, and where the
//! time goes.

use egui::{Context, Grid, RichText, ScrollArea, Ui, Window};
use lightbox_core::plan::Part;
use lightbox_core::scene::Census;
use lightbox_core::settings::UNLIMITED;

use super::follow_focus;
use super::format::{count, counted, percent, percent_within, seconds};
use crate::model::Model;
use crate::session::Status;

/// Room for the window's title and edges, points.
const AROUND: f32 = 60.0;

/// Shows the window while it is open. Whether it is to be measured what the plan saves.
pub fn plan_ui(ctx: &Context, is_open: &mut bool, model: &mut Model, status: &Status) -> bool {
    let mut measure = false;
    let most = ctx.content_rect().height() - AROUND;
    Window::new("Plan")
        .open(is_open)
        .default_width(420.0)
        .collapsible(false)
        .resizable(false)
        .show(ctx, |ui| {
            let Some(scene) = &status.scene else { return };
            // Not the usual size of windows, but what it takes and there is.
            let room = ScrollArea::vertical().max_height(most);
            room.min_scrolled_height(most).show(ui, |ui| {
                title(ui, "What the scene uses");
                census(ui, scene.census());
                title(ui, "What the picture needs");
                parts(ui, status);
                measure = savings(ui, status);
                ui.checkbox(&mut model.desc.render.full_model, "Full model")
                    .on_hover_text("Leaves out nothing: the same picture, later. Starts it anew.");
                title(ui, "Light that is lost");
                lost(ui, status);
                title(ui, "Where the time goes");
                times(ui, status);
                follow_focus(ui);
            });
        });
    measure
}

fn title(ui: &mut Ui, text: &str) {
    ui.add_space(6.0);
    ui.strong(text);
}

/// A table whose first column is names.
fn table(ui: &mut Ui, id: &str, rows: &[(&str, String, String)]) {
    let grid = Grid::new(id).num_columns(3).spacing([16.0, 3.0]);
    grid.striped(true).show(ui, |ui| {
        for (name, value, note) in rows {
            ui.label(*name);
            ui.label(value);
            ui.label(note);
            ui.end_row();
        }
    });
}

/// Counts of what there is any of.
fn some(kinds: &[(usize, &str)]) -> String {
    let words = kinds.iter().filter(|(n, _)| *n > 0);
    let words: Vec<String> = words.map(|(n, noun)| counted(*n as u64, noun)).collect();
    if words.is_empty() {
        return "none".into();
    }
    words.join(", ")
}

fn census(ui: &mut Ui, census: &Census) {
    let (materials, lights) = (census.materials, census.lights);
    let shapes = [
        (census.triangles, "triangle"),
        (census.quads, "quad"),
        (census.spheres, "sphere"),
    ];
    let surfaces = [
        (materials.diffuse, "diffuse material"),
        (materials.blend, "blend"),
        (materials.mirror, "mirror material"),
        (materials.glass, "glass material"),
        (census.textures, "texture"),
    ];
    let lights = [
        (lights.rectangles, "rectangle"),
        (lights.parallelograms, "parallelogram"),
        (lights.triangles, "triangle"),
        (lights.spheres, "sphere"),
    ];
    let background = match census.background {
        true => "shines on what leaves the scene",
        false => "black: what leaves the scene costs nothing more",
    };
    let rows = [
        ("shapes", some(&shapes), String::new()),
        ("surfaces", some(&surfaces), String::new()),
        ("lights", some(&lights), String::new()),
        ("background", background.into(), String::new()),
    ];
    table(ui, "census", &rows);
}

fn parts(ui: &mut Ui, status: &Status) {
    let rows = Part::ALL.map(|part| {
        let is_left_out = status.left_out.contains(&part);
        let savings = status.savings.as_ref();
        let saving = savings.and_then(|s| s.parts.iter().find(|(p, _)| *p == part));
        (
            part.name(),
            if is_left_out { "left out" } else { "kept" }.to_owned(),
            saving.map_or_else(String::new, |(_, saving)| {
                format!("saves {}", saving.text())
            }),
        )
    });
    table(ui, "parts", &rows);
}

fn savings(ui: &mut Ui, status: &Status) -> bool {
    let text = match &status.savings {
        _ if status.is_measuring => "measuring…".into(),
        _ if status.left_out.is_empty() => "saves nothing".into(),
        Some(savings) => format!("saves {}", savings.text()),
        None => "not measured yet".into(),
    };
    ui.horizontal(|ui| {
        let can = !status.is_measuring && !status.left_out.is_empty();
        let button = ui.add_enabled(can, egui::Button::new("Measure"));
        let button = button.on_hover_text(
            "Renders small pictures with and without each part in turns, for a second. The picture rests meanwhile.",
        );
        ui.label(text);
        button.clicked()
    })
    .inner
}

fn lost(ui: &mut Ui, status: &Status) {
    let depth = status.desc.render.depth;
    let to_depth = match status.lost {
        _ if depth == UNLIMITED => ("nothing".into(), "there is no limit".into()),
        None => ("-".into(), "too few paths followed so far".into()),
        Some(lost) => {
            let verdict = status.noise.map(|noise| {
                let verdict = if lost.share > noise { "more" } else { "less" };
                format!("{verdict} than the noise, {}", percent(noise))
            });
            (
                percent_within(lost.share, lost.error),
                verdict.unwrap_or_default(),
            )
        }
    };
    let enough = status
        .enough_depth
        .map_or_else(|| "-".into(), |depth| format!("depth {depth}"));
    let rows = [
        ("to depth", to_depth.0, to_depth.1),
        (
            "to roulette",
            "nothing".into(),
            "survivors make up for it".into(),
        ),
        ("invalid samples", count(status.invalid), String::new()),
        (
            "enough",
            enough,
            "loses less than a tenth of the noise".into(),
        ),
    ];
    table(ui, "lost", &rows);
}

fn times(ui: &mut Ui, status: &Status) {
    let spent = &status.spent;
    let mut rows = vec![
        ("load", seconds(spent.load), String::new()),
        ("build", seconds(spent.build), String::new()),
    ];
    let stages = spent.stages();
    let all: f64 = stages.iter().map(|(_, s)| s).sum();
    rows.extend(stages.map(|(name, s)| {
        let share = if all > 0.0 { s / all } else { 0.0 };
        (name, seconds(s), percent(share))
    }));
    table(ui, "times", &rows);
    let threads = counted(status.threads as u64, "thread");
    ui.label(RichText::new(format!("From camera on, seconds of {threads} together.")).weak());
}
