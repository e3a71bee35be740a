//! From pointer events over the picture to camera moves and selections.

use egui::{Context, PointerButton, Pos2, Rect, Response, Ui, Vec2};
use glam::Vec3;
use lightbox_core::geometry::Hit;
use lightbox_core::math::Ray;
use lightbox_core::scene::CameraDesc;
use lightbox_core::{Camera, Scene};

use crate::model::{Model, Selection};
use crate::zoom::Zoom;
use crate::{flight, keys, orbit};

/// Points of wheel travel that change the distance e-fold.
const WHEEL: f32 = 200.0;

/// Duration of a glide in units of the style's animation time, which is zero where the user wants
/// no motion.
const GLIDE: f32 = 3.0;

/// Share of the scene's diagonal that is flown in a second, and what Shift and Alt make of it.
const FLIGHT: f32 = 0.2;
const FAST: f32 = 10.0;
const SLOW: f32 = 0.1;

/// Longest frame that is flown through, seconds: a stall must not throw the camera out of the room.
const STALL: f32 = 0.1;

/// What a ray through the picture finds.
#[derive(Clone, Copy, Debug)]
pub struct Pick {
    /// The surface.
    pub hit: Hit,
    /// The point on it.
    pub point: Vec3,
}

/// The ray through a place in the picture, given as shares of its width and height.
pub fn ray(camera: &CameraDesc, size: [u32; 2], at: [f32; 2]) -> Option<Ray> {
    let place = [at[0] * size[0] as f32, at[1] * size[1] as f32];
    let pixel = [0, 1].map(|i| (place[i].max(0.0) as u32).min(size[i] - 1));
    let offset = [0, 1].map(|i| place[i] - pixel[i] as f32 - 0.5);
    let camera = Camera::new(camera, size[0], size[1]).ok()?;
    Some(camera.ray(pixel, offset))
}

/// The surface at such a place. One ray, cast here and now.
pub fn pick(scene: &Scene, camera: &CameraDesc, size: [u32; 2], at: [f32; 2]) -> Option<Pick> {
    let ray = ray(camera, size, at)?;
    let hit = scene.intersect(&ray)?;
    Some(Pick {
        hit,
        point: ray.at(hit.t),
    })
}

/// Shares of a rectangle's width and height.
pub fn share(rect: Rect, pos: Pos2) -> [f32; 2] {
    [
        (pos.x - rect.left()) / rect.width(),
        (pos.y - rect.top()) / rect.height(),
    ]
}

struct Glide {
    from: CameraDesc,
    to: CameraDesc,
    /// Seconds of the input's clock.
    start: f64,
}

/// Camera moves in progress.
#[derive(Default)]
pub struct Gestures {
    glide: Option<Glide>,
    /// Depth of the point that a pan has grabbed, scene units.
    grabbed: f32,
    /// Whether the last move ran into a limit of distance.
    pub is_limited: bool,
    /// Whether one flies without holding a button.
    pub is_flying: bool,
    /// Whether the user has moved the camera or selected something once.
    pub is_known: bool,
    /// Where a region was begun, in shares of the picture.
    corner: Option<[f32; 2]>,
    /// Whether the right button is held over the picture.
    holds: bool,
    /// Whether the pixels are dragged, and not the camera.
    pans_pixels: bool,
}

impl Gestures {
    /// Moves the camera smoothly to another place.
    pub fn glide(&mut self, ui: &Context, model: &Model, to: CameraDesc) {
        self.is_limited = false;
        if to != model.desc.camera {
            self.glide = Some(Glide {
                from: model.desc.camera,
                to,
                start: ui.input(|i| i.time),
            });
            ui.request_repaint();
        }
    }

    /// Whether the camera moves or is being moved, so that its pivot is of interest.
    pub fn is_moving(&self, response: &Response) -> bool {
        self.is_gliding() || (response.dragged() && !self.pans_pixels)
    }

    /// Whether [`keys::FLIGHT`] fly.
    pub fn flies(&self) -> bool {
        self.is_flying || self.holds
    }

    /// Whether the camera is gliding somewhere.
    pub fn is_gliding(&self) -> bool {
        self.glide.is_some()
    }

    /// Leaves the camera where it is.
    pub fn halt(&mut self) {
        self.glide = None;
    }

    /// Where the camera glides to, or stands.
    pub fn destination(&self, model: &Model) -> CameraDesc {
        self.glide.as_ref().map_or(model.desc.camera, |g| g.to)
    }

    /// Applies this frame's events over the picture, shown in `rect`, to the model, or to what is
    /// seen of the picture.
    pub fn update(
        &mut self,
        ui: &Ui,
        response: &Response,
        rect: Rect,
        scene: &Scene,
        model: &mut Model,
        zoom: &mut Zoom,
    ) {
        let before = model.desc.camera;
        self.holds = response.is_pointer_button_down_on()
            && ui.input(|i| i.pointer.button_down(PointerButton::Secondary));
        let way = self.way(ui.ctx());
        let flies = way.is_some() || self.is_flying;
        let pans = response.dragged_by(PointerButton::Middle)
            || response.dragged_by(PointerButton::Secondary);
        self.pans_pixels = pans && zoom.is_close() && !flies;
        if self.pans_pixels {
            zoom.pan(response.drag_delta(), rect);
            ui.ctx().request_repaint(); // The picture is placed already.
        } else if !self.mark(ui, response, rect, model) {
            self.drag(response, rect, scene, model, way.is_some());
        }
        self.fly(ui, scene, model, way);
        self.wheel(ui, response, rect, scene, model);
        if model.desc.camera != before {
            self.glide = None;
        }
        self.is_known |= model.desc.camera != before || response.clicked();
        self.click(ui, response, rect, scene, model);
        self.advance(ui, model);
    }

    /// Marks the region that is rendered first while Shift and the left button drag; whether they do.
    fn mark(&mut self, ui: &Ui, response: &Response, rect: Rect, model: &mut Model) -> bool {
        let primary = PointerButton::Primary;
        let has_shift = ui.input(|i| i.modifiers.shift);
        let at = response.interact_pointer_pos();
        let at = at.map(|p| share(rect, p).map(|x| x.clamp(0.0, 1.0)));
        if response.drag_started_by(primary) && has_shift && !self.is_flying {
            let pressed = ui.input(|i| i.pointer.press_origin());
            let pressed = pressed.map(|p| share(rect, p).map(|x| x.clamp(0.0, 1.0)));
            self.corner = pressed.or(at);
        }
        let (Some([x, y]), Some([to_x, to_y])) = (self.corner, at) else {
            self.corner = None;
            return false;
        };
        model.region = Some([x.min(to_x), y.min(to_y), x.max(to_x), y.max(to_y)]);
        if !response.dragged_by(primary) {
            self.corner = None;
        }
        true
    }

    /// Where the keys that are held fly to: right, up and forwards. `None` if none is.
    fn way(&self, ctx: &Context) -> Option<Vec3> {
        if !self.flies() || ctx.text_edit_focused() {
            return None;
        }
        let [w, a, s, d, q, e] = keys::FLIGHT.map(|key| ctx.input(|i| i.key_down(key)));
        let along = |to: bool, from: bool| f32::from(u8::from(to)) - f32::from(u8::from(from));
        let is_held = [w, a, s, d, q, e].contains(&true);
        is_held.then(|| Vec3::new(along(d, a), along(e, q), along(w, s)))
    }

    fn fly(&mut self, ui: &Ui, scene: &Scene, model: &mut Model, way: Option<Vec3>) {
        let Some(way) = way else { return };
        let (seconds, modifiers) = ui.input(|i| (i.stable_dt.min(STALL), i.modifiers));
        let pace = match (modifiers.shift, modifiers.alt) {
            (true, _) => FAST,
            (_, true) => SLOW,
            _ => 1.0,
        };
        let camera = &model.desc.camera;
        let diagonal = scene.geometry().bounds().diagonal();
        let size = if diagonal > 0.0 {
            diagonal
        } else {
            camera.eye.distance(camera.target)
        };
        model.desc.camera = flight::flown(camera, way * (size * FLIGHT * pace * seconds));
        self.is_limited = false;
        ui.ctx().request_repaint();
    }

    fn drag(
        &mut self,
        response: &Response,
        rect: Rect,
        scene: &Scene,
        model: &mut Model,
        flies: bool,
    ) {
        let camera = model.desc.camera;
        let Vec2 { x, y } = response.drag_delta() / rect.height();
        // Half a turn for the height of the picture.
        let [yaw, pitch] = [x, y].map(|share| share * std::f32::consts::PI);
        let primary = response.dragged_by(PointerButton::Primary);
        if response.dragged() && (flies || (self.is_flying && primary)) {
            model.desc.camera = flight::looked(&camera, yaw, pitch);
            self.is_limited = false;
        } else if primary {
            let turn = if model.free_orbit {
                flight::tumbled
            } else {
                orbit::turned
            };
            model.desc.camera = turn(&camera, yaw, pitch);
            self.is_limited = false;
        } else if response.dragged() {
            if response.drag_started() {
                let grabbed = response
                    .interact_pointer_pos()
                    .and_then(|p| pick_in(rect, p, scene, model));
                let point = grabbed.map_or(camera.target, |g| g.point);
                let depth = orbit::projected(&camera, point).map(|(_, depth)| depth);
                self.grabbed = depth.unwrap_or_else(|| camera.eye.distance(camera.target));
            }
            model.desc.camera = orbit::panned(&camera, [x, y], self.grabbed);
            self.is_limited = false;
        }
    }

    fn wheel(
        &mut self,
        ui: &Ui,
        response: &Response,
        rect: Rect,
        scene: &Scene,
        model: &mut Model,
    ) {
        let Some(pos) = response.hover_pos() else {
            return;
        };
        // With Shift, the wheel arrives as horizontal scrolling.
        let (scroll, zoom) = ui.input(|i| (i.smooth_scroll_delta(), i.zoom_delta()));
        let factor = (-(scroll.x + scroll.y) / WHEEL).exp() / zoom;
        if factor == 1.0 {
            return;
        }
        let camera = model.desc.camera;
        let point = pick_in(rect, pos, scene, model)
            .map_or_else(|| beside_target(rect, pos, &camera), |p| p.point);
        let reach = orbit::reach(&scene.geometry().bounds(), &camera);
        (model.desc.camera, self.is_limited) = orbit::dollied(&camera, point, factor, reach);
    }

    fn click(
        &mut self,
        ui: &Ui,
        response: &Response,
        rect: Rect,
        scene: &Scene,
        model: &mut Model,
    ) {
        // With Ctrl, a click looks into the pixel.
        if !response.clicked_by(PointerButton::Primary) || ui.input(|i| i.modifiers.command) {
            return;
        }
        if ui.input(|i| i.modifiers.shift) {
            model.region = None;
            return;
        }
        let picked = response
            .interact_pointer_pos()
            .and_then(|p| pick_in(rect, p, scene, model));
        model.selection = picked.map(|p| Selection::of(scene, p.hit.prim));
        if let (true, Some(picked)) = (response.double_clicked_by(PointerButton::Primary), picked) {
            self.glide(
                ui.ctx(),
                model,
                orbit::aimed(&model.desc.camera, picked.point),
            );
        }
    }

    fn advance(&mut self, ui: &Ui, model: &mut Model) {
        let Some(glide) = &self.glide else { return };
        let duration = f64::from(ui.style().animation_time * GLIDE);
        let t = (ui.input(|i| i.time) - glide.start) / duration;
        // NaN if both are zero.
        let t = if t < 1.0 { t as f32 } else { 1.0 };
        model.desc.camera = orbit::blended(&glide.from, &glide.to, t * t * (3.0 - 2.0 * t));
        if t < 1.0 {
            ui.ctx().request_repaint();
        } else {
            self.glide = None;
        }
    }
}

fn pick_in(rect: Rect, pos: Pos2, scene: &Scene, model: &Model) -> Option<Pick> {
    let settings = &model.desc.render;
    pick(
        scene,
        &model.desc.camera,
        [settings.width, settings.height],
        share(rect, pos),
    )
}

/// The point under the cursor in the plane of the target, where there is no surface.
fn beside_target(rect: Rect, pos: Pos2, camera: &CameraDesc) -> Vec3 {
    let offset = (pos - rect.center()) / rect.height();
    // The target moves by the opposite of what a pan does.
    orbit::panned(
        camera,
        [-offset.x, -offset.y],
        camera.eye.distance(camera.target),
    )
    .target
}
