//! Rows of the side panel: a name on the left, a control with the same accessible name on the
//! right, and a tooltip that says what a change costs.

use std::fmt::Display;
use std::ops::RangeInclusive;

use egui::emath::Numeric;
use egui::{
    Context, DragValue, Id, PointerButton, Pos2, Rect, Response, Slider, SliderClamping, Ui,
};
use glam::Vec3;

/// End of tooltips of what is applied to the samples there are.
pub const KEEPS: &str = "Keeps the samples.";

/// End of tooltips of what makes samples worthless.
pub const RESTARTS: &str = "Starts the picture anew.";

/// Numbers in scenes are no larger.
pub const LARGEST: f32 = 1e18;

/// Width of the names' column, points.
const NAMES: f32 = 84.0;

/// Width of the number beside a slider, points.
const NUMBERS: f32 = 62.0;

/// A section of the side panel that can be folded away.
pub fn section(ui: &mut Ui, title: &str, open: bool, add: impl FnOnce(&mut Ui)) {
    let header = egui::CollapsingHeader::new(egui::RichText::new(title).strong())
        .id_salt(title)
        .default_open(open);
    header.show_unindented(ui, |ui| {
        ui.add_space(2.0);
        add(ui);
        ui.add_space(6.0);
    });
}

/// A slider that neither rounds nor clamps what it only shows: looking at a file is no edit. What
/// is typed and is no number changes nothing. A double-click brings back what is `usual`.
pub fn slider<N: Numeric>(
    ui: &mut Ui,
    value: &mut N,
    usual: N,
    range: RangeInclusive<N>,
    shape: impl FnOnce(Slider<'_>) -> Slider<'_>,
) -> Response {
    let slider = Slider::new(&mut *value, range)
        .clamping(SliderClamping::Edits)
        .custom_parser(number)
        .custom_formatter(figure);
    let mut response = ui.add(shape(slider));
    let rail = egui::vec2(ui.spacing().slider_width, response.rect.height());
    let rail = Rect::from_min_size(response.rect.min, rail);
    let is_over =
        |pos: Pos2| response.enabled() && response.contains_pointer() && rail.contains(pos);
    let (clicked, doubled) = ui.input(|i| {
        let is_here = i.pointer.interact_pos().is_some_and(is_over);
        let primary = PointerButton::Primary;
        (
            (is_here && i.pointer.button_clicked(primary)).then_some(i.time),
            is_here && i.pointer.button_double_clicked(primary),
        )
    });
    if doubled && *value != usual {
        *value = usual;
        response.mark_changed();
    }
    if clicked.is_some() {
        let until = clicked.filter(|_| !doubled);
        ui.data_mut(|d| d.insert_temp(Id::unique("slider clicked"), until));
    }
    response
}

/// Whether a click on a slider, which has moved it, may be the first of two that bring it back: not two
/// edits but one.
pub fn may_be_reset(ctx: &Context) -> bool {
    let clicked: Option<f64> = ctx.data(|d| d.get_temp(Id::unique("slider clicked")).flatten());
    let delay = ctx.options(|o| o.input_options.max_double_click_delay);
    clicked.is_some_and(|clicked| ctx.input(|i| i.time - clicked <= delay))
}

/// A slider with its name in a row; whether it was moved.
pub fn slider_row<N: Numeric>(
    ui: &mut Ui,
    name: &str,
    tip: &str,
    value: &mut N,
    usual: N,
    range: RangeInclusive<N>,
) -> bool {
    row(ui, name, tip, |ui| slider(ui, value, usual, range, |s| s)).changed()
}

/// A finite number as people type it.
pub fn number(text: &str) -> Option<f64> {
    let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let number: f64 = text.replace('−', "-").parse().ok()?;
    number.is_finite().then_some(number)
}

/// A number as fields show it: with an exponent where it would be long, and no −0.
pub fn figure(x: f64, decimals: RangeInclusive<usize>) -> String {
    let text = if x.abs() < 1e7 || *decimals.end() == 0 {
        egui::emath::format_with_decimals_in_range(x, decimals)
    } else {
        // The least that reads back as the same number: who leaves a field sets what it shows.
        format!("{:e}", x as f32)
    };
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

/// A named control with a tooltip.
pub fn row(ui: &mut Ui, name: &str, tip: &str, add: impl FnOnce(&mut Ui) -> Response) -> Response {
    labelled(ui, name, tip, |ui| {
        let response = add(ui);
        let response = if tip.is_empty() {
            response
        } else {
            response.on_hover_text(tip)
        };
        response.accessible_name(name)
    })
}

/// A line with a name, for controls that have names of their own.
pub fn labelled<R>(ui: &mut Ui, name: &str, tip: &str, add: impl FnOnce(&mut Ui) -> R) -> R {
    let head = |ui: &mut Ui| {
        let label = ui.add(egui::Label::new(name).truncate().selectable(false));
        if !tip.is_empty() {
            label.on_hover_text(tip);
        }
        badge(ui, tip);
    };
    headed(ui, head, add)
}

/// At the end of the names' column: what a change costs, by the end of the tooltip.
pub fn badge(ui: &mut Ui, tip: &str) {
    let glyph = if tip.ends_with(RESTARTS) {
        "↺"
    } else if tip.ends_with(KEEPS) {
        "•"
    } else {
        return;
    };
    let left = egui::Layout::right_to_left(egui::Align::Center);
    ui.with_layout(left, |ui| {
        let text = egui::RichText::new(glyph).weak();
        let label = egui::Label::new(text).selectable(false);
        ui.add(label).on_hover_text(tip);
    });
}

/// A line with something in the place of its name.
pub fn headed<R>(ui: &mut Ui, head: impl FnOnce(&mut Ui), add: impl FnOnce(&mut Ui) -> R) -> R {
    ui.horizontal(|ui| {
        let height = ui.spacing().interact_size.y;
        let left = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(egui::vec2(NAMES, height), left, |ui| {
            ui.set_min_width(NAMES);
            head(ui);
        });
        // All number fields are equally wide; sliders take what is left.
        ui.spacing_mut().interact_size.x = NUMBERS;
        ui.spacing_mut().slider_width =
            (ui.available_width() - NUMBERS - ui.spacing().item_spacing.x).max(60.0);
        add(ui)
    })
    .inner
}

/// All choices side by side; one click takes one.
pub fn choice<T: Copy + PartialEq + Display>(
    ui: &mut Ui,
    name: &str,
    tip: &str,
    value: &mut T,
    all: &[T],
) {
    labelled(ui, name, tip, |ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        if all.len() > 4 {
            ui.spacing_mut().button_padding.x = 2.0; // Or they would not fit.
        }
        for variant in all {
            ui.selectable_value(value, *variant, variant.to_string())
                .on_hover_text(tip);
        }
    });
}

/// Three numbers along the axes; `speed` is what a point of dragging adds.
pub fn point(ui: &mut Ui, name: &str, tip: &str, value: &mut Vec3, speed: f64, suffix: &str) {
    labelled(ui, name, tip, |ui| {
        let width = thirds(ui);
        for (axis, x) in ["x", "y", "z"].into_iter().zip(value.as_mut()) {
            let drag = DragValue::new(x)
                .custom_parser(number)
                .custom_formatter(figure)
                .range(-LARGEST..=LARGEST)
                .clamp_existing_to_range(false)
                .speed(speed)
                .max_decimals(3)
                .suffix(suffix)
                .clip_text(true);
            let response = ui.add_sized([width, ui.spacing().interact_size.y], drag);
            response
                .on_hover_text(tip)
                .accessible_name(format!("{name} {axis}"));
        }
    });
}

/// At the end of what can be scrolled: brings into sight what the keyboard has come to.
pub fn follow_focus(ui: &Ui) {
    let key = ui.scope_id().with("focus");
    let focused = ui.memory(|m| m.focused());
    let last = |d: &mut egui::util::IdTypeMap| {
        std::mem::replace(d.get_temp_mut_or_default::<Option<Id>>(key), focused)
    };
    // What is clicked is in sight, and must not slip from under the pointer.
    if ui.data_mut(last) == focused || ui.input(|i| i.pointer.any_down()) {
        return;
    }
    let Some(response) = focused.and_then(|id| ui.ctx().read_response(id)) else {
        return;
    };
    let seen = response.interact_rect;
    // Elsewhere in the window something may stand where this would, were it not cut off.
    let is_elsewhere = seen.is_positive() && !ui.clip_rect().intersects(seen);
    if response.layer_id == ui.layer_id()
        && ui.min_rect().contains(response.rect.center())
        && !is_elsewhere
    {
        ui.scroll_to_rect(response.rect, None);
    }
}

/// Sets up a row for three numbers and returns the width of each, points: never wider than the
/// row, because a panel that grows would move the picture.
pub fn thirds(ui: &mut Ui) -> f32 {
    let spacing = ui.spacing_mut();
    spacing.item_spacing.x = 3.0;
    spacing.interact_size.x = 0.0;
    ((ui.available_width() - 2.0 * ui.spacing().item_spacing.x) / 3.0).floor()
}

#[cfg(test)]
mod tests {
    use super::{figure, number};

    #[test]
    fn numbers_fit_their_fields() {
        for (x, text) in [
            (1.5, "1.50"),
            (-0.001, "0.00"),
            (-0.0, "0.00"),
            (-2.0, "-2.00"),
            (1e18, "1e18"),
            (-1e30, "-1e30"),
        ] {
            assert_eq!(figure(x, 2..=2), text);
            assert!(number(text).is_some());
        }
        assert_eq!(figure(20_000_001.0, 0..=0), "20000001");
        for x in [695_700_032.0f32, 12_345_678.0, 1.234_567_9e17] {
            let text = figure(x.into(), 2..=2);
            assert_eq!(number(&text).map(|x| x as f32), Some(x), "{text}");
        }
    }

    #[test]
    fn only_numbers_are_numbers() {
        for (text, expected) in [
            ("1.5", Some(1.5)),
            (" −2 ", Some(-2.0)),
            ("1e3", Some(1000.0)),
            ("nan", None),
            ("inf", None),
            ("abc", None),
            ("", None),
        ] {
            assert_eq!(number(text), expected, "{text}");
        }
    }
}
