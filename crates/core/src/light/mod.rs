//! Choosing light: which emitter, and which point on it.
//!
//! Emitters are chosen in proportion to their power. Rectangles are sampled uniformly in solid
//! angle, spheres over the cone they fill, triangles and other parallelograms over their area;
//! every density is per solid angle at the reference point. A rectangle that is small as seen
//! from there is sampled by area: the density is then almost constant anyway, and solid angles
//! of such size cannot be told from rounding.

mod casters;
mod cone;
mod guide;
mod rectangle;
mod reflection;

use glam::Vec3;
use serde::Serialize;

use crate::geometry::{Primitive, Primitives, SurfacePoint, SurfacePoints};
use crate::math::{Floats, GROUP, Vectors, warp};
use crate::planted::{self, Bug};
use crate::sampler::{Dim, Samplers};
use crate::shape::{Quad, Sphere, triangle_area, triangle_normal};
pub(crate) use casters::Casters;
use cone::Cone;
pub(crate) use guide::{Guide, Mark};
use rectangle::Rectangle;
pub(crate) use reflection::Reflection;

/// A direction towards a light.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct LightSample {
    /// Primitive id of the emitter.
    pub prim: u32,
    /// The point on it.
    pub point: SurfacePoint,
    /// Density of the direction, per solid angle at the reference point.
    pub pdf: f32,
}

/// Directions towards lights, side by side.
#[derive(Debug)]
pub(crate) struct LightSamples {
    /// The emitters.
    pub prims: [u32; GROUP],
    /// The points on them.
    pub points: SurfacePoints,
    /// Densities of the directions; 0 where there is none.
    pub pdf: Floats,
}

impl Default for LightSamples {
    fn default() -> Self {
        Self {
            prims: [0; GROUP],
            points: SurfacePoints::default(),
            pdf: [0.0; GROUP],
        }
    }
}

/// An emitting primitive, prepared for sampling.
#[derive(Debug)]
enum Shape {
    Triangle {
        corners: [Vec3; 3],
        n: Vec3,
        area: f32,
    },
    Parallelogram(Quad),
    Rectangle(Box<Rectangle>),
    Sphere(Sphere),
}

impl Shape {
    fn of(primitive: Primitive) -> Self {
        match primitive {
            Primitive::Triangle(corners) => Self::Triangle {
                corners,
                n: triangle_normal(corners),
                area: triangle_area(corners),
            },
            Primitive::Quad(quad) => match Rectangle::new(quad) {
                Some(rectangle) => Self::Rectangle(Box::new(rectangle)),
                None => Self::Parallelogram(quad),
            },
            Primitive::Sphere(sphere) => Self::Sphere(sphere),
        }
    }

    /// A point that may shine on `p`, and the density of its direction.
    #[inline]
    fn sample(&self, p: Vec3, u: impl FnOnce() -> [f32; 2]) -> Option<(SurfacePoint, f32)> {
        match self {
            Self::Triangle { corners, n, area } => {
                let [b1, b2] = warp::triangle(u());
                let point = SurfacePoint::of_triangle_with(*corners, *n, [b1, b2]);
                Some((point, area_pdf(p, point.p, *n, *area)))
            }
            Self::Parallelogram(quad) => {
                let [s, t] = u();
                let point = SurfacePoint::of_quad(quad, s, t);
                Some((point, area_pdf(p, point.p, quad.normal(), quad.area())))
            }
            Self::Rectangle(rectangle) => Some(rectangle.sample(p, u())),
            Self::Sphere(sphere) => {
                let cone = Cone::new(sphere, p)?;
                let q = sphere.center + sphere.radius * cone.sample(u());
                let point = SurfacePoint::of_sphere(sphere, q);
                // Rounding may put it behind its horizon where `p` all but touches the sphere.
                let is_in_sight = (p - point.p).dot(point.n) > 0.0;
                is_in_sight.then(|| (point, cone.pdf()))
            }
        }
    }

    /// A point uniform over the area.
    fn sample_area(&self, u: [f32; 2]) -> SurfacePoint {
        match self {
            Self::Triangle { corners, n, .. } => {
                SurfacePoint::of_triangle_with(*corners, *n, warp::triangle(u))
            }
            Self::Parallelogram(quad) => SurfacePoint::of_quad(quad, u[0], u[1]),
            Self::Rectangle(rectangle) => SurfacePoint::of_quad(rectangle.quad(), u[0], u[1]),
            Self::Sphere(sphere) => {
                let p = sphere.center + sphere.radius * warp::uniform_sphere(u);
                SurfacePoint::of_sphere(sphere, p)
            }
        }
    }

    /// Square scene units.
    fn area(&self) -> f32 {
        match self {
            Self::Triangle { area, .. } => *area,
            Self::Parallelogram(quad) => quad.area(),
            Self::Rectangle(rectangle) => rectangle.quad().area(),
            Self::Sphere(sphere) => sphere.area(),
        }
    }

    /// Density with which [`Shape::sample`] draws the direction from `p` to `q`.
    fn pdf(&self, p: Vec3, q: Vec3) -> f32 {
        match self {
            Self::Triangle { n, area, .. } => area_pdf(p, q, *n, *area),
            Self::Parallelogram(quad) => area_pdf(p, q, quad.normal(), quad.area()),
            Self::Rectangle(rectangle) => rectangle.pdf(p, q),
            Self::Sphere(sphere) => Cone::new(sphere, p).map_or(0.0, |cone| cone.pdf()),
        }
    }
}

/// Density per solid angle at `p` of a point `q` that is uniform over `area` with normal `n`;
/// 0 behind the surface and where the density is not finite.
#[inline(always)]
fn area_pdf(p: Vec3, q: Vec3, n: Vec3, area: f32) -> f32 {
    let d = p - q;
    let distance = d.length();
    let cos = d.dot(n) / distance;
    let pdf = distance * distance / (area * cos);
    if (cos > 0.0) & (pdf < f32::INFINITY) {
        pdf
    } else {
        0.0
    }
}

/// A density as the integrator is told it.
#[inline(always)]
fn told(pdf: f32) -> f32 {
    if planted::has(Bug::PdfTimes1_02) {
        pdf * 1.02
    } else {
        pdf
    }
}

/// Counts of emitters by how they are sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct LightKinds {
    /// Rectangles, in solid angle.
    pub rectangles: usize,
    /// Other parallelograms, over their area.
    pub parallelograms: usize,
    /// Triangles, over their area.
    pub triangles: usize,
    /// Spheres, over their cone.
    pub spheres: usize,
}

impl LightKinds {
    /// All of them.
    pub fn total(&self) -> usize {
        self.rectangles + self.parallelograms + self.triangles + self.spheres
    }
}

/// The emitters of a scene.
#[derive(Debug, Default)]
pub struct Lights {
    /// Primitive ids, ascending.
    emitters: Vec<u32>,
    /// By emitter.
    shapes: Vec<Shape>,
    /// Power of the emitters up to and with each, in units of the scene's total: ends with 1.
    cumulative: Vec<f64>,
}

impl Lights {
    /// Collects emitters as (primitive id in ascending order, power in any unit); those without
    /// power are left out.
    pub fn new(primitives: &Primitives, emitters: impl IntoIterator<Item = (u32, f64)>) -> Self {
        let mut lights = Self::default();
        let mut sum = 0.0;
        for (prim, power) in emitters {
            if power > 0.0 && power.is_finite() {
                sum += power;
                lights.emitters.push(prim);
                lights.shapes.push(Shape::of(primitives.get(prim)));
                lights.cumulative.push(sum);
            }
        }
        for c in &mut lights.cumulative {
            *c /= sum;
        }
        lights
    }

    /// Whether nothing emits.
    pub fn is_empty(&self) -> bool {
        self.emitters.is_empty()
    }

    /// Number of emitting primitives.
    pub fn len(&self) -> usize {
        self.emitters.len()
    }

    /// How many there are of each kind.
    pub(crate) fn kinds(&self) -> LightKinds {
        let mut kinds = LightKinds::default();
        for shape in &self.shapes {
            *match shape {
                Shape::Triangle { .. } => &mut kinds.triangles,
                Shape::Parallelogram(_) => &mut kinds.parallelograms,
                Shape::Rectangle(_) => &mut kinds.rectangles,
                Shape::Sphere(_) => &mut kinds.spheres,
            } += 1;
        }
        kinds
    }

    /// Chooses an emitter: its index and the probability of the choice.
    #[inline]
    pub(crate) fn pick(&self, u: impl FnOnce() -> f32) -> Option<(usize, f32)> {
        let last = self.emitters.len().checked_sub(1)?;
        let u = f64::from(u());
        let i = self.cumulative.partition_point(|c| *c <= u).min(last);
        Some((i, self.probability(i)))
    }

    pub(crate) fn probability(&self, i: usize) -> f32 {
        (self.cumulative[i] - if i > 0 { self.cumulative[i - 1] } else { 0.0 }) as f32
    }

    /// Draws a point on a light that may shine on `p` with its front. `None` where there is none.
    /// `pick` and `u` give numbers in [0, 1); what is not needed is not drawn.
    #[inline]
    pub fn sample(
        &self,
        p: Vec3,
        pick: impl FnOnce() -> f32,
        u: impl FnOnce() -> [f32; 2],
    ) -> Option<LightSample> {
        let (i, probability) = self.pick(pick)?;
        let (point, pdf) = self.shapes[i].sample(p, u)?;
        let (prim, pdf) = (self.emitters[i], told(pdf * probability));
        (pdf > 0.0 && pdf.is_finite()).then_some(LightSample { prim, point, pdf })
    }

    /// [`Self::sample`] for the first `count` lanes of a group that shades at `p`; without a
    /// choice if there `is_one` light.
    #[inline(always)]
    pub(crate) fn sample_many(
        &self,
        p: &Vectors,
        count: usize,
        samplers: &Samplers,
        bounce: u32,
        is_one: bool,
        samples: &mut LightSamples,
    ) {
        if is_one && let ([Shape::Rectangle(rectangle)], [prim]) = (&*self.shapes, &*self.emitters)
        {
            // Copied, so that the compiler need not fear for it when samples are written.
            let rectangle = **rectangle;
            let [x, y] = samplers.get_2d(Dim::LightPoint(bounce));
            for lane in 0..GROUP {
                let (point, pdf) = rectangle.sample(p.get(lane), [x[lane], y[lane]]);
                samples.points.set(lane, &point);
                samples.pdf[lane] = told(pdf);
            }
            samples.prims = [*prim; GROUP];
            return;
        }
        for lane in 0..count {
            let sampler = samplers.get(lane);
            let pick = || match is_one {
                true => 0.0,
                false => sampler.get_1d(Dim::LightPick(bounce)),
            };
            let u = || sampler.get_2d(Dim::LightPoint(bounce));
            samples.pdf[lane] = 0.0;
            if let Some(LightSample { prim, point, pdf }) = self.sample(p.get(lane), pick, u) {
                samples.points.set(lane, &point);
                (samples.pdf[lane], samples.prims[lane]) = (pdf, prim);
            }
        }
    }

    /// Draws a point on a light, uniform over its area: the emitter, the point, and the density per
    /// unit of area. For light that takes a detour, of which a solid angle would say nothing.
    #[inline]
    pub(crate) fn sample_area(
        &self,
        pick: impl FnOnce() -> f32,
        u: impl FnOnce() -> [f32; 2],
    ) -> Option<(u32, SurfacePoint, f32)> {
        let (i, probability) = self.pick(pick)?;
        let shape = &self.shapes[i];
        let pdf = probability / shape.area();
        Some((self.emitters[i], shape.sample_area(u()), told(pdf)))
    }

    /// Density with which [`Lights::sample`] draws the direction from `p` to the point `q` on the
    /// front of primitive `prim`; 0 if never.
    pub fn pdf(&self, p: Vec3, prim: u32, q: Vec3) -> f32 {
        self.emitters
            .binary_search(&prim)
            .map_or(0.0, |i| self.shapes[i].pdf(p, q) * self.probability(i))
    }

    /// Density per unit of area with which [`Lights::sample_area`] draws a point on primitive
    /// `prim`; 0 if never.
    pub(crate) fn area_pdf(&self, prim: u32) -> f32 {
        self.emitters
            .binary_search(&prim)
            .map_or(0.0, |i| self.probability(i) / self.shapes[i].area())
    }
}
