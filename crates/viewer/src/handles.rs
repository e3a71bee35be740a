//! Handles at the selected object, in the picture: knobs that move it along an axis, turn it about
//! one, or scale it. What they do can be typed in the Object section too.

use std::f32::consts::FRAC_PI_2;

use egui::accesskit::Role;
use egui::{
    Color32, CursorIcon, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo,
};
use glam::Vec3;
use lightbox_core::scene::{CameraDesc, Object, ObjectKind};
use lightbox_core::{Scene, SceneDesc};

use crate::gestures::{ray, share};
use crate::model::Model;
use crate::overlay::seen;
use crate::panels::{RESTARTS, format};
use crate::{objects, orbit};

/// From the middle to the knobs that move, points; those that turn are at a share of that.
const REACH: f32 = 80.0;
const TURNS_AT: f32 = 0.75;

/// Where the knob is that scales, points from the middle.
const SCALES_AT: Vec2 = Vec2::new(-40.0, 40.0);

/// Size of a knob and of what can be grabbed around it, points.
const KNOB: f32 = 5.0;
const GRABBED: f32 = 18.0;

/// Sine of the angle to the line of sight under which nothing can be aimed at any more.
const TOO_STEEP: f32 = 0.12;

/// Points to the right that scale e-fold.
const GROWTH: f32 = 150.0;

/// Lines of an arc.
const ARC: u32 = 12;

const AXES: [(&str, Vec3, Color32); 3] = [
    ("x", Vec3::X, Color32::from_rgb(235, 85, 85)),
    ("y", Vec3::Y, Color32::from_rgb(120, 205, 80)),
    ("z", Vec3::Z, Color32::from_rgb(95, 150, 255)),
];

/// What a knob does, about or along which axis.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Knob {
    Move(usize),
    Turn(usize),
    Scale,
}

/// A knob that is being dragged.
struct Grab {
    knob: Knob,
    /// The scene when that began.
    start: SceneDesc,
    /// Where the pointer was then, in the knob's own measure.
    from: f32,
}

/// The knobs of the selected object.
#[derive(Default)]
pub struct Handles {
    grab: Option<Grab>,
}

impl Handles {
    /// Draws them over the picture in `rect` while the pointer is there, and applies a drag of one
    /// to the object; what that comes to, in words.
    pub fn ui(
        &mut self,
        ui: &Ui,
        painter: &Painter,
        rect: Rect,
        scene: &Scene,
        model: &mut Model,
    ) -> Option<String> {
        let place = Place::of(rect, scene, model);
        let is_wanted = self.grab.is_some() || ui.rect_contains_pointer(painter.clip_rect());
        let Some(place) = place.filter(|_| is_wanted) else {
            self.grab = None;
            return None;
        };
        let turns = !matches!(place.object.kind, ObjectKind::Sphere(_));
        let turns = [0, 1, 2].map(Knob::Turn).into_iter().filter(|_| turns);
        let moves = [0, 1, 2].map(Knob::Move);
        let held = self.grab.as_ref().map(|grab| grab.knob);
        let mut drag = None;
        for knob in turns.chain(moves).chain([Knob::Scale]) {
            // One that is held stays, wherever it comes to lie.
            let Some(lines) = place.lines(knob, held == Some(knob)) else {
                continue;
            };
            let is_other = held.is_some_and(|held| held != knob);
            if is_other || (held.is_none() && !painter.clip_rect().contains(lines.knob)) {
                continue;
            }
            let response = respond(ui, lines.knob, knob);
            draw(painter, &lines, knob, &response);
            if response.dragged() || response.drag_stopped() {
                drag = Some((knob, response.interact_pointer_pos()));
            }
        }
        let Some((knob, pointer)) = drag else {
            self.grab = None;
            return None;
        };
        let object = place.object;
        let start = self.grab.as_ref().map_or(&model.desc, |grab| &grab.start);
        let middle = objects::center(start, object.kind, &object.bounds)?;
        let now = place.measure(knob, middle, pointer?)?;
        let grab = self.grab.get_or_insert_with(|| Grab {
            knob,
            start: model.desc.clone(),
            from: now,
        });
        // From where it began: back there, all is as it was.
        objects::restore(&mut model.desc, object.kind, &grab.start);
        Some(apply(&mut model.desc, object, knob, now - grab.from))
    }
}

/// What the pointer does at a knob.
fn respond(ui: &Ui, at: Pos2, knob: Knob) -> Response {
    let (name, tip) = match knob {
        Knob::Move(i) => {
            let name = format!("Move along {}", AXES[i].0);
            (name, "Drag it along its line.")
        }
        Knob::Turn(i) => {
            let name = format!("Turn about {}", AXES[i].0);
            (name, "Drag it around the middle.")
        }
        Knob::Scale => (
            "Scale".to_owned(),
            "Drag it to the right to grow, to the left to shrink.",
        ),
    };
    let area = Rect::from_center_size(at, Vec2::splat(GRABBED));
    // The keyboard has the numbers of the panel.
    let response = ui.interact(area, ui.scope_id().with(&name), Sense::DRAG);
    let label = format!("{name} in the picture");
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &label));
    response
        .on_hover_text(format!("{name}. {tip} {RESTARTS}"))
        .on_hover_and_drag_cursor(CursorIcon::Grab)
}

/// Applies a drag of a knob to an object; what it comes to.
fn apply(desc: &mut SceneDesc, object: &Object, knob: Knob, by: f32) -> String {
    match knob {
        Knob::Move(i) => {
            let (name, axis, _) = AXES[i];
            objects::shift(desc, object.kind, axis * by);
            format!("{name} {}", signed(by, format::length))
        }
        Knob::Turn(i) => {
            let (name, axis, _) = AXES[i];
            objects::turn(desc, object.kind, &object.bounds, axis, by);
            // Not half a turn the other way.
            let turn = std::f32::consts::TAU;
            let degrees = (by - turn * (by / turn).round()).to_degrees();
            format!("about {name} {}°", signed(degrees, |x| format!("{x:.1}")))
        }
        Knob::Scale => {
            let factor = (by / GROWTH).exp();
            objects::grow(desc, object.kind, &object.bounds, factor);
            format!("{factor:.3} times as large")
        }
    }
}

fn signed(x: f32, text: impl FnOnce(f32) -> String) -> String {
    let sign = if x < 0.0 { "−" } else { "+" };
    format!("{sign}{}", text(x.abs()))
}

/// Where the selected object is seen.
struct Place<'a> {
    object: &'a Object,
    camera: CameraDesc,
    /// Pixels across and down.
    size: [u32; 2],
    rect: Rect,
    middle: Vec3,
    /// [`REACH`] in scene units.
    reach: f32,
}

/// How a knob is drawn.
struct Lines {
    knob: Pos2,
    stem: Vec<Pos2>,
}

impl<'a> Place<'a> {
    fn of(rect: Rect, scene: &'a Scene, model: &Model) -> Option<Self> {
        let object = model.selection?.object(scene)?;
        let desc = &model.desc;
        let middle = objects::center(desc, object.kind, &object.bounds)?;
        let (_, depth) = orbit::projected(&desc.camera, middle)?;
        let height = 2.0 * depth * (0.5 * desc.camera.fov).to_radians().tan();
        Some(Self {
            object,
            camera: desc.camera,
            size: [desc.render.width, desc.render.height],
            rect,
            middle,
            reach: REACH * height / rect.height(),
        })
    }

    /// Where a knob lies and what leads to it; `None` where it could not be aimed at, unless it is
    /// `held`.
    fn lines(&self, knob: Knob, held: bool) -> Option<Lines> {
        let sight = (self.middle - self.camera.eye).normalize_or_zero();
        let point = |point| seen(self.rect, &self.camera, point);
        let stem = match knob {
            Knob::Move(i) => {
                let axis = AXES[i].1;
                if !held && sight.cross(axis).length() < TOO_STEEP {
                    return None;
                }
                vec![point(self.middle)?, point(self.middle + axis * self.reach)?]
            }
            Knob::Turn(i) => {
                if !held && sight.dot(AXES[i].1).abs() < TOO_STEEP {
                    return None;
                }
                let arc = |step: u32| {
                    let [a, b] = across(i);
                    let (sin, cos) = (step as f32 / ARC as f32 * FRAC_PI_2).sin_cos();
                    point(self.middle + (a * cos + b * sin) * (self.reach * TURNS_AT))
                };
                (0..=ARC).map(arc).collect::<Option<_>>()?
            }
            // Not in the middle, where the next drag is to orbit.
            Knob::Scale => {
                let middle = point(self.middle)?;
                vec![middle, middle + SCALES_AT]
            }
        };
        let knob = match knob {
            Knob::Turn(_) => stem[stem.len() / 2],
            _ => *stem.last()?,
        };
        Some(Lines { knob, stem })
    }

    /// Where the pointer is in a knob's own measure: scene units along its axis, the angle about
    /// it, points to the right. `middle` is that of the object when the drag began.
    fn measure(&self, knob: Knob, middle: Vec3, pointer: Pos2) -> Option<f32> {
        let axis = match knob {
            Knob::Move(i) | Knob::Turn(i) => AXES[i].1,
            Knob::Scale => return Some(pointer.x),
        };
        let ray = ray(&self.camera, self.size, share(self.rect, pointer))?;
        let way = middle - ray.origin;
        if let Knob::Turn(i) = knob {
            let t = way.dot(axis) / ray.dir.dot(axis);
            let from = ray.dir * t - way;
            let [a, b] = across(i).map(|axis| from.dot(axis));
            return (t > 0.0 && t.is_finite()).then(|| b.atan2(a));
        }
        // Where the axis comes closest to the ray.
        let along = axis.dot(ray.dir);
        let least = 1.0 - along * along;
        let at = (along * ray.dir.dot(way) - axis.dot(way)) / least;
        let is_ahead = orbit::projected(&self.camera, middle + axis * at).is_some();
        (least > 1e-4 && is_ahead).then_some(at)
    }
}

fn draw(painter: &Painter, lines: &Lines, knob: Knob, response: &Response) {
    let color = match knob {
        Knob::Move(i) | Knob::Turn(i) => AXES[i].2,
        Knob::Scale => Color32::from_gray(235),
    };
    let is_lit = response.hovered() || response.dragged();
    let color = if is_lit { Color32::WHITE } else { color };
    for (wider, color) in [(1.0, Color32::from_black_alpha(110)), (0.0, color)] {
        let pen = Stroke::new(2.0 + 2.0 * wider, color);
        painter.add(Shape::line(lines.stem.clone(), pen));
        match knob {
            Knob::Move(_) => painter.circle_filled(lines.knob, KNOB + wider, color),
            Knob::Turn(_) => painter.circle_filled(lines.knob, KNOB - 1.0 + wider, color),
            Knob::Scale => {
                let square = Rect::from_center_size(lines.knob, Vec2::splat(2.0 * (KNOB + wider)));
                painter.rect_filled(square, 0.0, color)
            }
        };
    }
}

/// The axes that a turn about one goes from and to.
fn across(axis: usize) -> [Vec3; 2] {
    [AXES[(axis + 1) % 3].1, AXES[(axis + 2) % 3].1]
}
