//! Numbers side by side: the shape in which loops over path vertices are fast. A loop over a
//! group whose body is free of branches and calls becomes SIMD code by the compiler's own means;
//! each lane is computed as it would be alone.

use glam::Vec3;

/// Lanes of a group: a few SIMD registers, and little enough to stay in the first cache.
pub(crate) const GROUP: usize = 64;

/// A number in each lane.
pub(crate) type Floats = [f32; GROUP];

/// A vector in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vectors {
    x: Floats,
    y: Floats,
    z: Floats,
}

impl Default for Vectors {
    fn default() -> Self {
        let [x, y, z] = [[0.0; GROUP]; 3];
        Self { x, y, z }
    }
}

impl Vectors {
    /// The vector of a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Sets the vector of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (v.x, v.y, v.z);
    }
}
