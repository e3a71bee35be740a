//! Pictures kept beside the present one: a strip of them, and ways to look at one and the other.

use std::sync::{Arc, Weak};

use egui::{
    Align2, Area, Button, Color32, ColorImage, Context, CursorIcon, Frame, Id, Image, Painter,
    Pos2, Rect, ScrollArea, Sense, Stroke, TextEdit, TextureHandle, TextureOptions, Ui, Vec2,
};
use lightbox_core::color::ToneMap;

use crate::overlay::tag;
use crate::panels::slider;
use crate::session::{Reference, Session, Snapshot};
use crate::texture::Texture;

/// Most pixels of a small picture across and down.
const SMALL: [usize; 2] = [112, 72];

/// Room for the strip's lines of text under it, points.
const ABOVE_EDGE: f32 = 36.0;

/// How the present picture and the one it is compared with are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Only the present one.
    #[default]
    Off,
    /// The other left of a line, the present one right of it.
    Wipe,
    /// Side by side.
    Beside,
    /// Only the other one.
    Instead,
}

impl Mode {
    /// Every mode with its name and what it does.
    const ALL: [(Self, &str, &str); 4] = [
        (Self::Off, "off", "Shows the present picture only."),
        (
            Self::Wipe,
            "wipe",
            "The chosen picture is left of a line, the present one right. B",
        ),
        (
            Self::Beside,
            "side by side",
            "The chosen picture is on the left, the present one on the right. Shift+B",
        ),
        (
            Self::Instead,
            "in its place",
            "The chosen picture takes the present one's place; so it does while V is held.",
        ),
    ];
}

/// A picture in the strip.
struct Kept {
    name: String,
    picture: Arc<Reference>,
    small: TextureHandle,
}

/// The strip, and what is compared how.
pub struct Compare {
    mode: Mode,
    /// Whether the other picture is glanced at for the moment, whatever the mode.
    pub is_glancing: bool,
    /// Where the wipe's line is, as a share of the picture's width.
    line: f32,
    /// Whether the strip is shown, if there is anything in it.
    is_open: bool,
    kept: Vec<Kept>,
    /// What was taken up last. It may have been forgotten since, while the engine still has it.
    last: Weak<Reference>,
    /// A picture is to be kept as soon as the engine's pass ends.
    is_keeping: bool,
    other: Texture,
}

impl Default for Compare {
    fn default() -> Self {
        Self {
            mode: Mode::Off,
            is_glancing: false,
            line: 0.5,
            is_open: true,
            kept: Vec::new(),
            last: Weak::new(),
            is_keeping: false,
            other: Texture::new("kept picture"),
        }
    }
}

impl Compare {
    /// Shows a mode, or ends it.
    pub fn toggle(&mut self, mode: Mode) {
        self.mode = if self.mode == mode { Mode::Off } else { mode };
    }

    fn mode(&self) -> Mode {
        if self.is_glancing {
            Mode::Instead
        } else {
            self.mode
        }
    }

    /// Shows or hides the strip.
    pub fn toggle_strip(&mut self) {
        self.is_open = !self.is_open;
    }

    /// Keeps the present picture, and compares with it.
    pub fn keep(&mut self, session: &Session) {
        self.is_open = true;
        self.is_keeping = true;
        session.keep_reference();
    }

    /// Whether a picture is about to be kept.
    pub fn is_keeping(&self) -> bool {
        self.is_keeping
    }

    /// The part of the window's space that the present picture gets.
    pub fn stage(&self, space: Rect, other: Option<&Snapshot>) -> Rect {
        match self.mode() {
            Mode::Beside if other.is_some() => space.with_min_x(space.center().x + 1.0),
            _ => space,
        }
    }

    /// Draws the other picture, the `reference`, where the present one takes up `rect` on its stage.
    pub fn draw(
        &mut self,
        ui: &Ui,
        space: Rect,
        rect: Rect,
        other: Option<&Snapshot>,
        reference: Option<&Arc<Reference>>,
    ) {
        let (Some(other), Some(reference)) = (other, reference) else {
            return;
        };
        let kept = self
            .kept
            .iter()
            .find(|kept| Arc::ptr_eq(&kept.picture, reference));
        let name = kept.map_or(&reference.name, |kept| &kept.name).clone();
        let name = name.as_str();
        match self.mode() {
            Mode::Off => {}
            Mode::Instead => {
                let painter = ui.painter().with_clip_rect(space);
                self.other.draw(&painter, rect, other);
                caption(ui, space, space.left_top(), name);
            }
            Mode::Wipe => {
                let x = rect.left() + self.line * rect.width();
                let clip = space.with_max_x(x);
                self.other
                    .draw(&ui.painter().with_clip_rect(clip), rect, other);
                self.wipe(ui, space, rect, x);
                caption(ui, space, space.left_top(), name);
                caption(ui, space.with_min_x(x), Pos2::new(x, space.top()), "now");
            }
            Mode::Beside => {
                let half = space.with_max_x(space.center().x - 1.0);
                // The same part of it, at the same size.
                let by = half.center() - self.stage(space, Some(other)).center();
                self.other.draw(
                    &ui.painter().with_clip_rect(half),
                    rect.translate(by),
                    other,
                );
                caption(ui, half, half.left_top(), name);
                let stage = self.stage(space, Some(other));
                caption(ui, stage, stage.left_top(), "now");
            }
        }
    }

    /// The line, to be dragged.
    fn wipe(&mut self, ui: &Ui, space: Rect, rect: Rect, x: f32) {
        let handle = space.intersect(Rect::from_x_y_ranges(x - 5.0..=x + 5.0, rect.y_range()));
        let response = ui.interact(handle, ui.scope_id().with("wipe"), Sense::drag());
        if response.hovered() || response.dragged() {
            ui.set_cursor_icon(CursorIcon::ResizeHorizontal);
        }
        if let Some(pos) = response
            .interact_pointer_pos()
            .filter(|_| response.dragged())
        {
            self.line = ((pos.x - rect.left()) / rect.width()).clamp(0.0, 1.0);
        }
        for (width, color) in [(3.0, Color32::from_black_alpha(160)), (1.0, Color32::WHITE)] {
            ui.painter()
                .vline(x, handle.y_range(), Stroke::new(width, color));
        }
    }

    /// Shows the strip over the lower edge of `space`, and tells the engine what is compared.
    pub fn ui(
        &mut self,
        ctx: &Context,
        space: Rect,
        session: &Session,
        reference: Option<&Arc<Reference>>,
        tone: ToneMap,
    ) {
        if let Some(reference) = reference {
            self.collect(ctx, reference, tone);
        }
        session.set_comparing(self.mode() != Mode::Off);
        if self.kept.is_empty() || !self.is_open {
            return;
        }
        let area = Area::new(Id::unique("strip"))
            .pivot(Align2::CENTER_BOTTOM)
            .fixed_pos(space.center_bottom() - Vec2::new(0.0, ABOVE_EDGE))
            .constrain_to(space);
        area.show(ctx, |ui| {
            let frame = Frame::window(ui.style()).inner_margin(6);
            frame.show(ui, |ui| {
                ui.set_max_width(space.width() - 40.0);
                self.modes(ui);
                let strip = ScrollArea::horizontal();
                strip.show(ui, |ui| self.strip(ui, session, reference));
            });
        });
    }

    /// Takes up what counts as right, wherever it came from.
    fn collect(&mut self, ctx: &Context, reference: &Arc<Reference>, tone: ToneMap) {
        if self.last.as_ptr() == Arc::as_ptr(reference) {
            return;
        }
        self.last = Arc::downgrade(reference);
        self.is_keeping = false;
        let is_there = |kept: &Kept| Arc::ptr_eq(&kept.picture, reference);
        if self.kept.iter().any(is_there) {
            return;
        }
        let small = small(reference, tone);
        let small = ctx.load_texture("small picture", small, TextureOptions::LINEAR);
        let same = |kept: &&Kept| kept.name == reference.name;
        let name = match self.kept.iter().filter(same).count() {
            0 => reference.name.clone(),
            n => format!("{} ({})", reference.name, n + 1),
        };
        self.kept.push(Kept {
            name,
            picture: reference.clone(),
            small,
        });
    }

    fn modes(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.strong("Compare");
            for (mode, name, tip) in Mode::ALL {
                ui.selectable_value(&mut self.mode, mode, name)
                    .on_hover_text(tip);
            }
            if self.mode == Mode::Wipe {
                slider(ui, &mut self.line, 0.5, 0.0..=1.0, |s| s.show_value(false))
                    .on_hover_text("Where the line is; it can be dragged in the picture too.")
                    .accessible_name("Wipe");
            }
        });
    }

    fn strip(&mut self, ui: &mut Ui, session: &Session, reference: Option<&Arc<Reference>>) {
        let mut removed = None;
        ui.horizontal(|ui| {
            for (i, kept) in self.kept.iter_mut().enumerate() {
                let is_chosen = reference.is_some_and(|r| Arc::ptr_eq(r, &kept.picture));
                ui.vertical(|ui| {
                    let image = Image::new(&kept.small).maintain_aspect_ratio(true);
                    let button = ui.add(Button::image(image).selected(is_chosen));
                    let tip = "Compares with this picture, or no longer.";
                    let button = button.on_hover_text(tip);
                    if button.clicked() && is_chosen {
                        session.drop_reference();
                    } else if button.clicked() {
                        session.set_reference(kept.picture.clone());
                    }
                    button.accessible_name(format!("Compare with {}", kept.name));
                    ui.horizontal(|ui| {
                        let width = (SMALL[0] as f32 - 20.0).max(40.0);
                        let field = TextEdit::singleline(&mut kept.name).desired_width(width);
                        let label = format!("Name of kept picture {}", i + 1);
                        ui.add(field).accessible_name(label);
                        let remove = ui.small_button("×").on_hover_text("Forgets this picture.");
                        if remove.clicked() {
                            removed = Some((i, is_chosen));
                        }
                        remove.accessible_name(format!("Forget {}", kept.name));
                    });
                });
            }
        });
        if let Some((i, was_chosen)) = removed {
            self.kept.remove(i);
            if was_chosen {
                session.drop_reference();
            }
        }
    }
}

fn caption(ui: &Ui, space: Rect, corner: Pos2, text: &str) {
    let painter: Painter = ui.painter().with_clip_rect(space);
    // Under the line that says whether it is a preview.
    tag(ui, &painter, corner + Vec2::new(0.0, 26.0), text);
}

/// A small picture, by the nearest pixels.
fn small(reference: &Reference, tone: ToneMap) -> ColorImage {
    let image = &reference.image;
    let [width, height] = [image.width as usize, image.height as usize];
    let scale = (width as f32 / SMALL[0] as f32)
        .max(height as f32 / SMALL[1] as f32)
        .max(1.0);
    let size = [width, height].map(|n| ((n as f32 / scale) as usize).max(1));
    let at = |i: usize, axis: usize| i * [width, height][axis] / size[axis];
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let pixels = pixels.map(|(x, y)| {
        let [r, g, b] = tone.apply(image.pixels[at(y, 1) * width + at(x, 0)]);
        Color32::from_rgb(r, g, b)
    });
    ColorImage::new(size, pixels.collect())
}
