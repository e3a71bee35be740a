//! The methods that fail: textbook formulas, and those of the report that lightbox grew out of.

use crate::math::Ray;
use crate::shape::Sphere;

/// The textbook quadratic, b² − 4ac in f32; then the report's rule for the root:
/// `t0·t1 ≥ 0 ? min : max`.
pub fn sphere(sphere: &Sphere, ray: &Ray) -> Option<f32> {
    let f = ray.origin - sphere.center;
    let a = ray.dir.dot(ray.dir);
    let b = 2.0 * ray.dir.dot(f);
    let c = f.dot(f) - sphere.radius * sphere.radius;
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let (t0, t1) = ((-b - root) / (2.0 * a), (-b + root) / (2.0 * a));
    Some(if t0 * t1 >= 0.0 {
        t0.min(t1)
    } else {
        t0.max(t1)
    })
}
