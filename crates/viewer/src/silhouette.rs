//! The outline of the selected mesh as the camera sees it: found in the background from which pixels
//! show the object, drawn as lines.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock, Weak};

use egui::{Context, Vec2};
use glam::Vec3;
use lightbox_core::geometry::Hit;
use lightbox_core::math::Aabb;
use lightbox_core::scene::{CameraDesc, Object, ObjectKind};
use lightbox_core::{Camera, Scene};

use crate::model::Model;
use crate::orbit;

/// How far a line may run beside the corners it leaves out, pixels: a staircase becomes a slope.
const SLACK: f32 = 0.75;

/// Closed lines, in shares of the picture.
pub type Loops = Vec<Vec<Vec2>>;

/// The newest outline, or the search for it.
#[derive(Default)]
pub struct Silhouette {
    search: Option<Search>,
}

struct Search {
    scene: Arc<Scene>,
    kind: ObjectKind,
    camera: CameraDesc,
    /// Pixels across and down.
    size: [u32; 2],
    found: Arc<OnceLock<Loops>>,
}

impl Silhouette {
    /// The outline of an object of the scene, once it is found; nothing while the scene lags behind
    /// the model, or where no pixel shows the object. It is looked for if the picture `is_still`.
    pub fn of(
        &mut self,
        ctx: &Context,
        scene: &Arc<Scene>,
        object: &Object,
        model: &Model,
        is_still: bool,
    ) -> Option<&Loops> {
        let ObjectKind::Mesh(i) = object.kind else {
            return None;
        };
        let (desc, render) = (&model.desc, &model.desc.render);
        let size = [render.width, render.height];
        let is_of = |search: &Search| {
            std::ptr::eq(search.scene.geometry(), scene.geometry())
                && (search.kind, search.camera, search.size) == (object.kind, desc.camera, size)
        };
        if desc.meshes.get(i) != scene.desc().meshes.get(i) {
            return None;
        }
        if !self.search.as_ref().is_some_and(is_of) {
            if !is_still {
                return None;
            }
            let found = Arc::default();
            let search = Search {
                scene: scene.clone(),
                kind: object.kind,
                camera: desc.camera,
                size,
                found,
            };
            search.start(ctx, object);
            self.search = Some(search);
        }
        let found = self.search.as_ref()?.found.get();
        found.filter(|loops| !loops.is_empty())
    }
}

impl Search {
    /// Looks in the background until nobody waits for it any more.
    fn start(&self, ctx: &Context, object: &Object) {
        let (scene, object, ctx) = (self.scene.clone(), object.clone(), ctx.clone());
        let (desc, size, found) = (self.camera, self.size, Arc::downgrade(&self.found));
        let run = move || {
            let Ok(camera) = Camera::new(&desc, size[0], size[1]) else {
                return;
            };
            let place = covered(&desc, size, &object.placed);
            let Some(mask) = mask(&scene, &camera, &object, place, &found) else {
                return;
            };
            let [x, y, ..] = place.map(|n| n as f32);
            let share = |p: Vec2| (p + Vec2::new(x, y)) / Vec2::from(size.map(|n| n as f32));
            let loops = loops(&mask, (place[2] - place[0]) as usize);
            let loops = loops
                .iter()
                .map(|l| simple(l).into_iter().map(share).collect());
            if let Some(found) = found.upgrade() {
                let _ = found.set(loops.collect()); // Nobody else sets it.
                ctx.request_repaint();
            }
        };
        let thread = std::thread::Builder::new().name("lightbox-outline".into());
        // Without a thread, the box around the mesh stays.
        let _ = thread.spawn(run);
    }
}

/// Left, top, right and bottom of the pixels that a box covers, or more.
fn covered(camera: &CameraDesc, [width, height]: [u32; 2], bounds: &Aabb) -> [u32; 4] {
    let all = [0, 0, width, height];
    let mut place: Option<[f32; 4]> = None;
    for corner in 0..8 {
        let pick = |axis: usize| match corner >> axis & 1 {
            0 => bounds.min[axis],
            _ => bounds.max[axis],
        };
        let corner = Vec3::new(pick(0), pick(1), pick(2));
        let Some(([x, y], _)) = orbit::projected(camera, corner) else {
            return all;
        };
        let [w, h] = [width as f32, height as f32];
        let [x, y] = [0.5 * w + x * h, 0.5 * h + y * h];
        let [left, top, right, bottom] = place.unwrap_or([x, y, x, y]);
        place = Some([left.min(x), top.min(y), right.max(x), bottom.max(y)]);
    }
    let Some([left, top, right, bottom]) = place else {
        return all;
    };
    // Saturates at zero.
    let [left, top] = [left - 1.0, top - 1.0].map(|n| n as u32);
    let [right, bottom] = [right + 2.0, bottom + 2.0].map(|n| n as u32);
    let (left, top) = (left.min(width), top.min(height));
    [
        left,
        top,
        right.clamp(left, width),
        bottom.clamp(top, height),
    ]
}

/// Which pixels of a place show an object, row by row; `None` if nobody waits for it any more.
fn mask(
    scene: &Scene,
    camera: &Camera,
    object: &Object,
    [left, top, right, bottom]: [u32; 4],
    waiting: &Weak<OnceLock<Loops>>,
) -> Option<Vec<bool>> {
    let slots = object.first_slot..object.first_slot + object.slots;
    let (mut mask, mut hits) = (Vec::new(), Vec::new());
    for y in top..bottom {
        if waiting.strong_count() == 0 {
            return None;
        }
        let rays: Vec<_> = (left..right)
            .map(|x| camera.ray([x, y], [0.0; 2]))
            .collect();
        scene.intersect_all(&rays, &mut hits);
        let shows = |hit: &Option<Hit>| {
            let slot = hit.as_ref().map(|hit| scene.slot(hit.prim));
            slot.is_some_and(|slot| slots.contains(&slot))
        };
        mask.extend(hits.iter().map(shows));
    }
    Some(mask)
}

/// The lines between what is set in a mask and what is not, each with the set pixels to its left:
/// the middles of the sides of pixels along them.
fn loops(mask: &[bool], width: usize) -> Vec<Vec<Vec2>> {
    let height = mask.len().checked_div(width).unwrap_or(0);
    let at = |x: i64, y: i64| {
        let is_in = (0..width as i64).contains(&x) && (0..height as i64).contains(&y);
        is_in && mask[y as usize * width + x as usize]
    };
    // Sides by the corner that they start from; two where pixels touch by their corners.
    let mut sides: HashMap<[i64; 2], Vec<[i64; 2]>> = HashMap::new();
    let mut starts = Vec::new();
    for y in 0..height as i64 {
        for x in (0..width as i64).filter(|x| at(*x, y)) {
            for (is_inside, from, to) in [
                (at(x, y - 1), [x + 1, y], [x, y]),
                (at(x - 1, y), [x, y], [x, y + 1]),
                (at(x, y + 1), [x, y + 1], [x + 1, y + 1]),
                (at(x + 1, y), [x + 1, y + 1], [x + 1, y]),
            ] {
                if !is_inside {
                    sides.entry(from).or_default().push(to);
                    starts.push(from);
                }
            }
        }
    }
    let mut loops = Vec::new();
    for start in starts {
        let mut line = Vec::new();
        let mut from = start;
        while let Some(to) = sides.get_mut(&from).and_then(Vec::pop) {
            let middle = [0, 1].map(|i| (from[i] + to[i]) as f32 * 0.5);
            line.push(Vec2::from(middle));
            from = to;
        }
        if !line.is_empty() {
            loops.push(line);
        }
    }
    loops
}

/// A closed line with fewer corners that runs nowhere farther than [`SLACK`] beside it.
fn simple(line: &[Vec2]) -> Vec<Vec2> {
    let far = (0..line.len()).max_by(|a, b| {
        let [a, b] = [a, b].map(|i| (line[*i] - line[0]).length_sq());
        a.total_cmp(&b)
    });
    let Some(far) = far.filter(|_| line.len() > 3) else {
        return line.to_vec();
    };
    let mut keeps = vec![false; line.len()];
    (keeps[0], keeps[far]) = (true, true);
    // From the first corner to the farthest, and from there back to the first.
    let mut parts = vec![(0, far), (far, line.len())];
    while let Some((from, to)) = parts.pop() {
        let (a, b) = (line[from], line[to % line.len()]);
        let way = (b - a).normalized();
        let aside = |i: usize| (line[i] - a).dot(way.rot90()).abs();
        let worst = (from + 1..to).max_by(|i, j| aside(*i).total_cmp(&aside(*j)));
        if let Some(worst) = worst.filter(|i| aside(*i) > SLACK) {
            keeps[worst] = true;
            parts.extend([(from, worst), (worst, to)]);
        }
    }
    let kept = line.iter().zip(keeps).filter(|(_, keeps)| *keeps);
    kept.map(|(point, _)| *point).collect()
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use lightbox_core::scene;

    use super::*;

    /// A mask from a picture of it.
    fn drawn(rows: &[&str]) -> (Vec<bool>, usize) {
        let mask = rows.iter().flat_map(|row| row.chars().map(|c| c == '#'));
        (mask.collect(), rows[0].len())
    }

    fn area(line: &[Vec2]) -> f32 {
        let next = line.iter().cycle().skip(1);
        let twice = line.iter().zip(next).map(|(a, b)| a.x * b.y - b.x * a.y);
        -0.5 * twice.sum::<f32>()
    }

    #[test]
    fn lines_go_around_what_is_set_and_around_its_holes() {
        let (mask, width) = drawn(&["####.", "#..#.", "####.", "....#"]);
        let loops = loops(&mask, width);
        let mut sides: Vec<usize> = loops.iter().map(Vec::len).collect();
        sides.sort_unstable();
        // Corners that touch may be taken for one line or for two.
        assert!(sides == [4, 6, 14] || sides == [6, 18], "{sides:?}");
        let hole = loops.iter().find(|l| l.len() == 6).expect("the hole");
        assert!(area(hole) < 0.0, "the other way around");
        let all: f32 = loops.iter().map(|line| area(line)).sum();
        assert!((10.0..=11.0).contains(&all), "{all}");
        assert!(super::loops(&[], 0).is_empty() && super::loops(&[false; 6], 3).is_empty());
    }

    #[test]
    fn a_staircase_becomes_a_slope() {
        let size = 200;
        // Under a line that climbs a third.
        let mask: Vec<bool> = (0..size * size)
            .map(|i| (i / size) * 3 > (i % size) + 5)
            .collect();
        let loops = loops(&mask, size);
        assert_eq!(loops.len(), 1);
        let line = simple(&loops[0]);
        assert!(line.len() < 12, "{line:?}");
        assert!((area(&line) - area(&loops[0])).abs() < 200.0 * SLACK);
        let one = simple(&loops[0][..2]);
        assert_eq!(one, loops[0][..2]);
    }

    #[test]
    fn a_box_covers_no_pixel_less_than_it_is_seen_in() {
        let camera = CameraDesc {
            eye: Vec3::new(0.0, 0.0, 4.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            fov: 90.0,
        };
        let around = |at: [f32; 3], half: f32| Aabb {
            min: Vec3::from(at) - half,
            max: Vec3::from(at) + half,
        };
        let pixels = |bounds| covered(&camera, [80, 40], &bounds);
        let [left, top, right, bottom] = pixels(around([0.0; 3], 1.0));
        // At the front, three units away, it is as wide as a third of the height.
        let (x, y) = (40.0 - 20.0 / 3.0, 20.0 - 20.0 / 3.0);
        assert!((left as f32) < x && left as f32 > x - 3.0, "{left}");
        assert!(
            (top as f32) < y && bottom as f32 > 40.0 - y,
            "{top} {bottom}"
        );
        assert!(right as f32 > 80.0 - x);
        assert_eq!(pixels(around([0.0, 0.0, 4.0], 1.0)), [0, 0, 80, 40]);
        let [left, _, right, _] = pixels(around([99.0, 0.0, 0.0], 1.0));
        assert_eq!((left, right), (80, 80));
    }

    #[test]
    fn the_outline_of_a_mesh_is_where_it_is_seen() {
        let source = scene::load("builtin:teddy-diffuse.toml".as_ref()).unwrap();
        let scene = Arc::new(source.build(&scene::unwatched).unwrap());
        let mut model = Model::default();
        model.open(scene.desc(), None);
        let size = [160, 120];
        [model.desc.render.width, model.desc.render.height] = size;
        let mut objects = scene.objects().iter();
        let mesh = objects.find(|o| matches!(o.kind, ObjectKind::Mesh(_)));
        let mesh = mesh.expect("a mesh");
        let (ctx, mut outline) = (Context::default(), Silhouette::default());
        assert!(outline.of(&ctx, &scene, mesh, &model, false).is_none());
        assert!(outline.search.is_none(), "the picture is not at rest");
        let start = Instant::now();
        let loops = loop {
            if let Some(loops) = outline.of(&ctx, &scene, mesh, &model, true) {
                break loops.clone();
            }
            assert!(start.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(1));
        };
        let camera = Camera::new(&model.desc.camera, size[0], size[1]).unwrap();
        let shows = |i: u32| {
            let hit = scene.intersect(&camera.ray([i % size[0], i / size[0]], [0.0; 2]));
            hit.is_some_and(|hit| scene.object(hit.prim).kind == mesh.kind)
        };
        let seen = (0..size[0] * size[1]).filter(|i| shows(*i)).count() as f32;
        let pixels = |line: &Vec<Vec2>| -> Vec<Vec2> {
            let place = |share: &Vec2| *share * Vec2::new(160.0, 120.0);
            line.iter().map(place).collect()
        };
        let all: f32 = loops.iter().map(|line| area(&pixels(line))).sum();
        assert!(
            seen > 500.0 && (all / seen - 1.0).abs() < 0.05,
            "{all} {seen}"
        );

        // From elsewhere it is another, and while it is moved there is none.
        model.desc.camera.eye.x += 0.1;
        assert!(outline.of(&ctx, &scene, mesh, &model, false).is_none());
        model.desc.camera = scene.desc().camera;
        assert!(outline.of(&ctx, &scene, mesh, &model, false).is_some());
        model.desc.meshes[0].translate.x += 0.1;
        assert!(outline.of(&ctx, &scene, mesh, &model, true).is_none());
    }
}
