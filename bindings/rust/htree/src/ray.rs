// SPDX-License-Identifier: MIT
//! The bytes that C and Rust share.

use bytemuck::{Pod, Zeroable};
use htree_sys as sys;
use std::mem::{align_of, size_of};

/// The `prim` of a miss.
///
/// ```
/// assert_eq!(htree::Hit::default().prim, htree::NONE);
/// ```
pub const NONE: u32 = sys::HTREE_NONE;

/// 2^60: triangles with larger coordinates are skipped, rays from farther away miss.
///
/// ```
/// assert_eq!(htree::COORDINATE_MAX, 2f32.powi(60));
/// ```
pub const COORDINATE_MAX: f32 = sys::HTREE_COORDINATE_MAX;

/// The points `org + t * dir` with `tmin <= t <= tmax`; `dir` need not be normalised.
///
/// A ray with a NaN, or with `tmin > tmax`, misses. `Ray` is `Pod`, so a buffer of bytes or floats
/// can be cast to rays and back.
///
/// ```
/// let floats = [0.0, 0.0, 5.0, 0.0, 0.0, 0.0, -1.0, 9.0_f32];
/// let rays: &[htree::Ray] = bytemuck::cast_slice(&floats);
/// assert_eq!((rays[0].org[2], rays[0].tmax), (5.0, 9.0));
/// ```
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where t is 0.
    pub org: [f32; 3],
    /// Least t that counts; may be negative.
    pub tmin: f32,
    /// Where to, and the length that t is measured in.
    pub dir: [f32; 3],
    /// Greatest t that counts; may be infinite.
    pub tmax: f32,
}

impl Ray {
    /// The ray from `org` without end.
    ///
    /// ```
    /// let ray = htree::Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
    /// assert_eq!((ray.tmin, ray.tmax), (0.0, f32::INFINITY));
    /// ```
    pub const fn new(org: [f32; 3], dir: [f32; 3]) -> Self {
        Self { org, tmin: 0.0, dir, tmax: f32::INFINITY }
    }

    /// The same ray with other ends.
    ///
    /// ```
    /// let ray = htree::Ray::new([0.0; 3], [0.0, 0.0, 1.0]).between(-1.0, 1.0);
    /// assert_eq!((ray.tmin, ray.tmax), (-1.0, 1.0));
    /// ```
    #[must_use]
    pub const fn between(self, tmin: f32, tmax: f32) -> Self {
        Self { org: self.org, tmin, dir: self.dir, tmax }
    }

    /// The point at `t`.
    ///
    /// ```
    /// assert_eq!(htree::Ray::new([1.0; 3], [0.0, 0.0, 2.0]).at(3.0), [1.0, 1.0, 7.0]);
    /// ```
    pub fn at(&self, t: f32) -> [f32; 3] {
        let ([x, y, z], [dx, dy, dz]) = (self.org, self.dir);
        [x + t * dx, y + t * dy, z + t * dz]
    }
}

/// The closest hit: on a triangle `(v0, v1, v2)` the point `(1 - u - v) v0 + u v1 + v v2`.
///
/// A miss has `prim == NONE` and the ray's `tmax` as `t`.
///
/// ```
/// let hits = vec![htree::Hit::default(); 2];
/// assert!(!hits[0].is_hit());
/// ```
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Where along the ray.
    pub t: f32,
    /// Share of the second corner.
    pub u: f32,
    /// Share of the third corner.
    pub v: f32,
    /// Triangle i of the mesh is i, object j is j + the number of triangles.
    pub prim: u32,
}

impl Hit {
    /// Whether anything was hit.
    ///
    /// ```
    /// assert!(htree::Hit { t: 1.0, u: 0.0, v: 0.0, prim: 7 }.is_hit());
    /// ```
    pub const fn is_hit(&self) -> bool {
        self.prim != NONE
    }
}

impl Default for Hit {
    fn default() -> Self {
        Self { t: 0.0, u: 0.0, v: 0.0, prim: NONE }
    }
}

/// What one ray cost, in the paper's terms; see [`Query::counters`](crate::Query::counters).
///
/// ```
/// assert_eq!(htree::Counters::default().traversal_steps, 0);
/// ```
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// N_TS: nodes (cells) visited, leaves included.
    pub traversal_steps: u32,
    /// N_ETS: leaves (cells) visited.
    pub leaf_steps: u32,
    /// N_IT: triangles and objects tested.
    pub intersections: u32,
    reserved: u32,
}

/// An axis-aligned box.
///
/// ```
/// let unit = htree::Aabb { lo: [0.0; 3], hi: [1.0; 3] };
/// assert!(!unit.is_empty());
/// ```
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Least corner.
    pub lo: [f32; 3],
    /// Greatest corner.
    pub hi: [f32; 3],
}

impl Aabb {
    /// Whether it contains nothing, as the bounds of a tree without triangles.
    ///
    /// ```
    /// let nothing = htree::Tree::new(&htree::Mesh::new(&[]))?;
    /// assert!(nothing.bounds().is_empty());
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.lo[axis] > self.hi[axis])
    }
}

macro_rules! pod {
    ($($ours:ty = $theirs:ty,)+) => {$(
        // SAFETY: repr(C) of 4-byte numbers only: no padding, and any bits are a value.
        unsafe impl Zeroable for $ours {}
        unsafe impl Pod for $ours {}
        const _: () = assert!(size_of::<$ours>() == size_of::<$theirs>());
        const _: () = assert!(align_of::<$ours>() == align_of::<$theirs>());
    )+};
}

pod! {
    Ray = sys::htree_ray,
    Hit = sys::htree_hit,
    Counters = sys::htree_counters,
    Aabb = sys::htree_box,
}

#[cfg(test)]
mod tests {
    use super::*;

    // With equal sizes, distinct values in every field show that the fields stand at equal places.
    #[test]
    fn fields_stand_where_c_has_them() {
        let ray = Ray { org: [1.0, 2.0, 3.0], tmin: 4.0, dir: [5.0, 6.0, 7.0], tmax: 8.0 };
        let words: [f32; 8] = bytemuck::cast(ray);
        // SAFETY: both are eight floats.
        let theirs: sys::htree_ray = unsafe { std::mem::transmute(words) };
        assert_eq!(theirs.org, ray.org);
        assert_eq!((theirs.tmin, theirs.dir, theirs.tmax), (ray.tmin, ray.dir, ray.tmax));

        let hit = Hit { t: 1.0, u: 2.0, v: 3.0, prim: 4 };
        // SAFETY: both are three floats and a number.
        let theirs: sys::htree_hit = unsafe { std::mem::transmute(hit) };
        assert_eq!((theirs.t, theirs.u, theirs.v, theirs.prim), (1.0, 2.0, 3.0, 4));

        let cost = Counters { traversal_steps: 1, leaf_steps: 2, intersections: 3, reserved: 0 };
        // SAFETY: both are four numbers.
        let theirs: sys::htree_counters = unsafe { std::mem::transmute(cost) };
        assert_eq!((theirs.traversal_steps, theirs.leaf_steps, theirs.intersections), (1, 2, 3));
    }
}
