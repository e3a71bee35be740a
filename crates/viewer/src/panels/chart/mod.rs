//! The error chart: how the error fell, against what it cost.

mod changes;
mod curves;
mod plot;

use egui::{Align, Context, Layout, Pos2, Rect, Ui, Window};

use crate::keys::Action;
use crate::session::{Moment, Session, Status};
use curves::Axis;

/// Size at first, points.
const SIZE: [f32; 2] = [440.0, 300.0];

/// The chart's window.
#[derive(Default)]
pub struct ChartPanel {
    /// Whether it is shown.
    pub is_open: bool,
    axis: Axis,
    /// What is under the pointer.
    moment: Option<Moment>,
}

impl ChartPanel {
    /// Shows the window over the picture in `space` while it is open. Returns the kept picture
    /// under the pointer.
    pub fn ui(
        &mut self,
        ctx: &Context,
        space: Rect,
        session: &Session,
        status: &Status,
        actions: &mut Vec<Action>,
    ) -> Option<Moment> {
        let mut is_open = self.is_open;
        let corner = space.left_bottom() + egui::vec2(8.0, -8.0 - SIZE[1]);
        let window = Window::new("Error chart")
            .open(&mut is_open)
            .default_size(SIZE)
            .default_pos(Pos2::new(corner.x, corner.y.max(space.top())))
            .min_size([300.0, 180.0])
            .show(ctx, |ui| {
                self.controls(ui, session, status, actions);
                let history = session.history();
                plot::show(ui, &history, status.forecast, self.axis, self.moment)
            });
        self.is_open = is_open;
        self.moment = window.and_then(|w| w.inner?);
        self.moment
    }

    fn controls(
        &mut self,
        ui: &mut Ui,
        session: &Session,
        status: &Status,
        actions: &mut Vec<Action>,
    ) {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            for axis in Axis::ALL {
                ui.selectable_value(&mut self.axis, axis, axis.to_string())
                    .on_hover_text(axis.tip());
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.spacing_mut().item_spacing.x = 4.0;
                let clear = egui::Button::new("Clear");
                if ui
                    .add_enabled(!session.history().earlier.is_empty(), clear)
                    .on_hover_text("Drops the curves of earlier pictures.")
                    .clicked()
                {
                    session.clear_history();
                }
                reference_menu(ui, session, status, actions);
            });
        });
        if let Some(text) = reservation(status) {
            let text = egui::RichText::new(text).color(ui.visuals().warn_fg_color);
            ui.add(egui::Label::new(text).wrap());
        }
    }
}

/// Chooses what counts as right.
fn reference_menu(ui: &mut Ui, session: &Session, status: &Status, actions: &mut Vec<Action>) {
    let tip = "A picture that counts as right: with it the true error is drawn beside the noise. \
               It is as good as the reference is.";
    let menu = ui.menu_button("Reference", |ui| {
        if let Some(reference) = &status.reference {
            ui.label(format!("against {}", reference.name));
            ui.separator();
        }
        if ui.button("Load EXR…").clicked() {
            actions.push(Action::Reference);
        }
        let keep = egui::Button::new("Keep this picture");
        if ui
            .add_enabled(status.samples > 0, keep)
            .on_hover_text("Takes the picture as it is now for the reference.")
            .clicked()
        {
            session.keep_reference();
        }
        let drop = egui::Button::new("No reference");
        if ui.add_enabled(status.reference.is_some(), drop).clicked() {
            session.drop_reference();
        }
    });
    menu.response.on_hover_text(tip);
}

/// What to bear in mind about the reference, if anything.
fn reservation(status: &Status) -> Option<String> {
    let reference = status.reference.as_ref()?;
    let (settings, size) = (&status.desc.render, reference.size());
    if size != [settings.width, settings.height] {
        return Some(format!(
            "The reference has {} × {} px and the picture {} × {} px: not compared.",
            size[0], size[1], settings.width, settings.height
        ));
    }
    (reference.stream == Some((settings.sampler, settings.seed))).then(|| {
        "The reference was made with the same random numbers: the error looks smaller than it is. \
         Change the seed."
            .into()
    })
}
