//! Rays, boxes, frames and warps: the geometry that everything else stands on. Knows glam only.

mod aabb;
mod frame;
mod group;
mod ray;
pub(crate) mod trig;
pub mod warp;

pub use aabb::Aabb;
pub use frame::Frame;
pub(crate) use group::{Floats, GROUP, Vectors};
pub use ray::Ray;
pub(crate) use ray::{gamma, offset_origin, round_along};
