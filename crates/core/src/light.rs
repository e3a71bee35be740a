//! Choosing light: which emitter, and which point on it.
//!
//! Emitters are chosen in proportion to their power. Rectangles are sampled uniformly in solid
//! angle (Ureña, Fajardo & King 2013), spheres over the cone they fill, triangles and other
//! parallelograms over their area; every density is per solid angle at the reference point. A
//! light that is small as seen from there is sampled by area: the density is then almost
//! constant anyway, and solid angles of such size cannot be told from rounding.

use glam::Vec3;

use crate::geometry::{Primitive, Primitives, SurfacePoint};
use crate::math::{Frame, warp};
use crate::planted::{self, Bug};
use crate::shape::{Quad, Sphere, triangle_area, unit_normal};

/// Solid angle, sr, below which rectangles are sampled by area.
const SMALL: f32 = 0.01;

/// A direction towards a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Primitive id of the emitter.
    pub prim: u32,
    /// The point on it.
    pub point: SurfacePoint,
    /// Density of the direction, per solid angle at the reference point.
    pub pdf: f32,
}

/// The emitters of a scene.
#[derive(Debug, Default)]
pub struct Lights {
    /// Primitive ids.
    emitters: Vec<u32>,
    /// Power of the emitters up to and with each, in units of the scene's total: ends with 1.
    cumulative: Vec<f64>,
}

impl Lights {
    /// Collects emitters as (primitive id, power in any unit); those without power are left out.
    pub fn new(emitters: impl IntoIterator<Item = (u32, f64)>) -> Self {
        let mut lights = Self::default();
        let mut sum = 0.0;
        for (prim, power) in emitters {
            if power > 0.0 && power.is_finite() {
                sum += power;
                lights.emitters.push(prim);
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

    /// Chooses an emitter: its primitive id and the probability of the choice.
    pub(crate) fn pick(&self, u: f32) -> Option<(u32, f32)> {
        if self.emitters.len() == 1 {
            return Some((self.emitters[0], 1.0));
        }
        let i = self
            .cumulative
            .partition_point(|c| *c <= f64::from(u))
            .min(self.emitters.len().checked_sub(1)?);
        Some((self.emitters[i], self.probability_at(i)))
    }

    fn probability_at(&self, i: usize) -> f32 {
        (self.cumulative[i] - if i > 0 { self.cumulative[i - 1] } else { 0.0 }) as f32
    }

    /// Probability that [`Lights::sample`] chooses primitive `prim`.
    pub(crate) fn probability(&self, prim: u32) -> f32 {
        if self.emitters.len() == 1 && self.emitters[0] == prim {
            return 1.0;
        }
        // Ids were collected in rising order.
        self.emitters
            .binary_search(&prim)
            .map_or(0.0, |i| self.probability_at(i))
    }

    /// Draws a point on a light that may shine on `p` with its front. `None` where there is none.
    pub fn sample(
        &self,
        primitives: &Primitives,
        p: Vec3,
        pick: f32,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let (prim, probability) = self.pick(pick)?;
        let (point, pdf) = match primitives.get(prim) {
            Primitive::Triangle(triangle) => {
                let point = SurfacePoint::of_triangle(triangle, warp::triangle(u));
                (
                    point,
                    area_pdf(p, point.p, point.n, triangle_area(triangle))?,
                )
            }
            Primitive::Quad(quad) => sample_quad(&quad, p, u)?,
            Primitive::Sphere(sphere) => sample_sphere(&sphere, p, u)?,
        };
        let mut pdf = pdf * probability;
        if planted::has(Bug::PdfTimes1_02) {
            pdf *= 1.02;
        }
        (pdf > 0.0 && pdf.is_finite()).then_some(LightSample { prim, point, pdf })
    }

    /// Density with which [`Lights::sample`] draws the direction from `p` to the point `q` on the
    /// front of primitive `prim`; 0 if never.
    pub fn pdf(&self, primitives: &Primitives, p: Vec3, prim: u32, q: Vec3) -> f32 {
        let pdf = match primitives.get(prim) {
            Primitive::Triangle(t) => area_pdf(
                p,
                q,
                unit_normal(t[1] - t[0], t[2] - t[0]),
                triangle_area(t),
            ),
            Primitive::Quad(quad) => match RectangleFrom::new(&quad, p) {
                Some(rectangle) => Some(rectangle.pdf()),
                None => area_pdf(p, q, quad.normal(), quad.area()),
            },
            Primitive::Sphere(sphere) => Cone::new(&sphere, p).map(|cone| cone.pdf()),
        };
        pdf.unwrap_or(0.0) * self.probability(prim)
    }
}

/// Density per solid angle at `p` of a point `q` that is uniform over `area` with normal `n`;
/// `None` behind the surface and where the density is not finite.
fn area_pdf(p: Vec3, q: Vec3, n: Vec3, area: f32) -> Option<f32> {
    let d = p - q;
    let distance = d.length();
    let cos = d.dot(n) / distance;
    let pdf = distance * distance / (area * cos);
    (cos > 0.0 && pdf.is_finite()).then_some(pdf)
}

fn sample_quad(quad: &Quad, p: Vec3, u: [f32; 2]) -> Option<(SurfacePoint, f32)> {
    if let Some(rectangle) = RectangleFrom::new(quad, p) {
        let [s, t] = rectangle.sample(u);
        return Some((SurfacePoint::of_quad(quad, s, t), rectangle.pdf()));
    }
    let point = SurfacePoint::of_quad(quad, u[0], u[1]);
    Some((point, area_pdf(p, point.p, point.n, quad.area())?))
}

/// A rectangle seen from a point in front of it, in the terms of Ureña, Fajardo & King 2013. The
/// inner angles are kept as complex numbers e^{iγ}, known up to a positive factor without
/// arc cosines: their product has the argument that the sum of the angles would have. In f64,
/// because close to the rectangle all cosines crowd at 1.
struct RectangleFrom {
    /// Left and right bound in the rectangle's frame, from the foot of the point.
    x: [f64; 2],
    /// Lower and upper bound.
    y: [f64; 2],
    /// Distance of the point from the plane, positive.
    z: f64,
    solid_angle: f64,
    /// e^{i(γ₂+γ₃)}.
    corner: [f64; 2],
}

impl RectangleFrom {
    /// `None` if the quad is not a rectangle, does not face `p`, or is small as seen from there.
    fn new(quad: &Quad, p: Vec3) -> Option<Self> {
        let [a, b, _, d] = quad.corners();
        let (ex, ey, to_a) = (b - a, d - a, a - p);
        let (width, height) = (ex.length(), ey.length());
        let z = -to_a.dot(quad.normal());
        if !(z > 0.0) || ex.dot(ey).abs() > 1e-5 * width * height {
            return None;
        }
        let distance = (to_a + 0.5 * (ex + ey)).length();
        // From further than its size, the solid angle is close to area·cos/distance².
        let is_far = distance > width + height;
        if is_far && width * height * z <= SMALL * distance * distance * distance {
            return None;
        }
        let (width, height, z) = (f64::from(width), f64::from(height), f64::from(z));
        let (x0, y0) = (
            f64::from(to_a.dot(ex)) / width,
            f64::from(to_a.dot(ey)) / height,
        );
        let (x, y) = ([x0, x0 + width], [y0, y0 + height]);
        // For each corner, e^{iγ} ∝ ∓xy + i·z·|corner|.
        let angle = |i: usize, j: usize, sign: f64| {
            let (x, y) = (x[i], y[j]);
            unit([sign * x * y, z * (x * x + y * y + z * z).sqrt()])
        };
        let corner = times(angle(0, 1, 1.0), angle(0, 0, -1.0));
        let [re, im] = times(times(angle(1, 0, 1.0), angle(1, 1, -1.0)), corner);
        // The sum of the angles is 2π more than the solid angle, which is within (0, 2π).
        let angle = libm::atan2(im, re);
        let solid_angle = if angle < 0.0 {
            angle + std::f64::consts::TAU
        } else {
            angle
        };
        (solid_angle > 0.0).then_some(Self {
            x,
            y,
            z,
            solid_angle,
            corner,
        })
    }

    /// Density per solid angle.
    fn pdf(&self) -> f32 {
        (1.0 / self.solid_angle) as f32
    }

    /// Maps the unit square to coordinates (u, v) in [0, 1]² of the rectangle, uniformly in solid
    /// angle.
    fn sample(&self, u: [f32; 2]) -> [f32; 2] {
        let ([x0, x1], [y0, y1], z) = (self.x, self.y, self.z);
        let (sin, cos) = libm::sincos(f64::from(u[0]) * self.solid_angle);
        // The angle uΩ − (γ₂ + γ₃).
        let [re, im] = self.corner;
        let [sin, cos] = [sin * re - cos * im, cos * re + sin * im];
        let b0 = y0 / (z * z + y0 * y0).sqrt();
        let b1 = y1 / (z * z + y1 * y1).sqrt();
        let fu = -(cos * b0 + b1) / sin;
        // cu/√(1−cu²) with cu = ±1/√(fu² + b0²).
        let tangent = (fu * fu + b0 * b0 - 1.0).max(0.0).sqrt();
        let xu = (z.copysign(fu) / tangent).clamp(x0, x1);
        let xu = if xu.is_nan() { x0 } else { xu };
        let d2 = xu * xu + z * z;
        let (h0, h1) = (y0 / (d2 + y0 * y0).sqrt(), y1 / (d2 + y1 * y1).sqrt());
        let hv = h0 + f64::from(u[1]) * (h1 - h0);
        let rest = 1.0 - hv * hv;
        let yv = if rest > 0.0 {
            (hv * (d2 / rest).sqrt()).clamp(y0, y1)
        } else {
            y1
        };
        [(xu - x0) / (x1 - x0), (yv - y0) / (y1 - y0)].map(|x| (x as f32).clamp(0.0, 1.0))
    }
}

/// Product of two complex numbers.
fn times([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}

/// A complex number over its absolute value.
fn unit([re, im]: [f64; 2]) -> [f64; 2] {
    let length = (re * re + im * im).sqrt();
    [re / length, im / length]
}

/// The cone that a sphere fills, seen from outside.
struct Cone {
    /// Unit vector from the sphere's centre to the apex.
    axis: Vec3,
    sin2_max: f32,
    /// 1 − cos of the half-angle, without cancellation.
    one_minus_cos: f32,
}

impl Cone {
    /// `None` from inside or on the sphere.
    fn new(sphere: &Sphere, p: Vec3) -> Option<Self> {
        let to_p = p - sphere.center;
        let distance = to_p.length();
        let ratio = sphere.radius / distance;
        let sin2_max = ratio * ratio;
        if !(sin2_max < 1.0) {
            return None;
        }
        let cos_max = ((1.0 - ratio) * (1.0 + ratio)).sqrt();
        Some(Self {
            axis: to_p / distance,
            sin2_max,
            one_minus_cos: sin2_max / (1.0 + cos_max),
        })
    }

    fn pdf(&self) -> f32 {
        1.0 / (std::f32::consts::TAU * self.one_minus_cos)
    }
}

fn sample_sphere(sphere: &Sphere, p: Vec3, u: [f32; 2]) -> Option<(SurfacePoint, f32)> {
    let cone = Cone::new(sphere, p)?;
    let one_minus_cos = u[0] * cone.one_minus_cos;
    let (cos, sin2) = (1.0 - one_minus_cos, one_minus_cos * (2.0 - one_minus_cos));
    // The point that the direction hits first, by its angle α at the centre from the axis: by the
    // law of sines sin(θ + α) = sin θ/sin θ_max, expanded so that nothing cancels near the sphere.
    let (sin, sin_max) = (sin2.max(0.0).sqrt(), cone.sin2_max.sqrt());
    let cos_sum = (1.0 - sin2 / cone.sin2_max).max(0.0).sqrt();
    let cos_alpha = sin2 / sin_max + cos * cos_sum;
    let sin_alpha = sin * (cos / sin_max - cos_sum);
    let (sin_phi, cos_phi) = libm::sincosf(std::f32::consts::TAU * u[1]);
    let local = Vec3::new(sin_alpha * cos_phi, sin_alpha * sin_phi, cos_alpha);
    let n = Frame::around(cone.axis).world_from_local(local).normalize();
    Some((
        SurfacePoint::of_sphere(sphere, sphere.center + sphere.radius * n),
        cone.pdf(),
    ))
}
