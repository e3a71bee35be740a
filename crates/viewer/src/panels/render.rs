//! How the picture is computed.

use egui::{DragValue, Ui};
use lightbox_core::settings::{MAX_SEED, UNLIMITED};
use lightbox_core::{AccelKind, Filter, FilterKind, Method, RenderSettings, SamplerKind};

use super::widgets::{RESTARTS, choice, labelled, row, section, slider};
use crate::model::{Model, PictureSize};

/// Depths the slider offers.
const DEPTHS: std::ops::RangeInclusive<u32> = 1..=64;

/// Depth, filter, method, accelerator, sampler and size.
pub fn render_ui(ui: &mut Ui, model: &mut Model) {
    section(ui, "Render", true, |ui| {
        let (settings, file) = (&mut model.desc.render, &model.file.render);
        depth(ui, settings, file);
        filter(ui, settings, file);
        let tip = format!(
            "How paths find light: naive samples surfaces, nee lights, mis both; caustics is mis \
             and traces paths from the lamps by way of mirror and glass; reuse is caustics, and \
             pixels share the light that their paths find. {RESTARTS}"
        );
        choice(ui, "Method", &tip, &mut settings.method, Method::ALL);
        let tip = format!(
            "How rays find surfaces: the same picture, sooner or later. Builds in the background. {RESTARTS}"
        );
        choice(ui, "Accelerator", &tip, &mut settings.accel, AccelKind::ALL);
        let tip = format!(
            "Where the random numbers come from: sobol is even, independent is not. {RESTARTS}"
        );
        choice(ui, "Sampler", &tip, &mut settings.sampler, SamplerKind::ALL);
        let tip = format!("Chooses the random numbers. {RESTARTS}");
        row(ui, "Seed", &tip, |ui| {
            ui.add(DragValue::new(&mut settings.seed).speed(0.1))
        });
        // Not a range of the field: large seeds would be rounded by looking at them.
        settings.seed = settings.seed.min(MAX_SEED);
        size(ui, model);
    });
}

fn depth(ui: &mut Ui, settings: &mut RenderSettings, file: &RenderSettings) {
    let tip =
        format!("Most segments of a path: 1 sees lights only, 2 adds direct light. {RESTARTS}");
    let mut unlimited = settings.depth == UNLIMITED;
    let usual = match file.depth {
        UNLIMITED => RenderSettings::default().depth,
        depth => depth,
    };
    row(ui, "Depth", &tip, |ui| {
        // Unlimited is the end of the scale, not a number.
        let mut shown = if unlimited {
            *DEPTHS.end()
        } else {
            settings.depth
        };
        let response = ui.add_enabled_ui(!unlimited, |ui| {
            slider(ui, &mut shown, usual, DEPTHS, |s| s.logarithmic(true))
        });
        let response = response.inner;
        if response.changed() {
            settings.depth = shown;
        }
        response
    });
    let tip = format!("Paths end by chance and by leaving the scene only. {RESTARTS}");
    let checkbox = labelled(ui, "", &tip, |ui| {
        ui.checkbox(&mut unlimited, "Unlimited depth")
            .on_hover_text(&tip)
    });
    if checkbox.changed() {
        settings.depth = if unlimited {
            UNLIMITED
        } else {
            RenderSettings::default().depth
        };
    }
}

fn filter(ui: &mut Ui, settings: &mut RenderSettings, file: &RenderSettings) {
    let tip = format!("How samples near a pixel are weighted: wider is smoother. {RESTARTS}");
    let mut kind = settings.filter.kind;
    labelled(ui, "Filter", &tip, |ui| {
        let combo = egui::ComboBox::from_id_salt("filter")
            .selected_text(kind.name())
            .width(ui.available_width());
        let response = combo.show_ui(ui, |ui| {
            for variant in FilterKind::ALL {
                ui.selectable_value(&mut kind, variant, variant.name());
            }
        });
        response
            .response
            .on_hover_text(&tip)
            .accessible_name("Filter");
    });
    if kind != settings.filter.kind {
        settings.filter = Filter::new(kind);
    }
    let usual = if file.filter.kind == kind {
        file.filter
    } else {
        Filter::new(kind)
    };
    let tip = format!("Half of the filter's width. {RESTARTS}");
    row(ui, "Radius", &tip, |ui| {
        slider(
            ui,
            &mut settings.filter.radius,
            usual.radius,
            Filter::RADII,
            |s| s.step_by(0.1).fixed_decimals(1).suffix(" px"),
        )
    });
}

fn size(ui: &mut Ui, model: &mut Model) {
    let tip = format!(
        "Pixels of the picture: those of its place in the window, or what the file says. {RESTARTS}"
    );
    labelled(ui, "Size", &tip, |ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        ui.selectable_value(&mut model.size, PictureSize::FitWindow, "fit window")
            .on_hover_text(&tip);
        ui.selectable_value(&mut model.size, PictureSize::AsInFile, "as in file")
            .on_hover_text(&tip);
    });
}
