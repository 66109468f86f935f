// SPDX-License-Identifier: MIT
use crate::{Aabb, Error, ErrorKind, Ray, Result};
use htree_sys as sys;
use std::fmt;
use std::sync::Arc;

/// What a build reads: triangles, and objects of your own if any. Borrows every slice.
///
/// ```
/// use htree::{Mesh, Tree};
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let square = Mesh::new(&corners).indices(&[[0, 1, 2], [0, 2, 3]]);
/// assert_eq!(Tree::new(&square)?.stats()?.triangles, 2);
/// # Ok::<(), htree::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Mesh<'a> {
    positions: &'a [f32],
    position_stride: u64,
    indices: Option<&'a [u32]>,
    objects: Option<Objects<'a>>,
}

impl<'a> Mesh<'a> {
    /// Triangle i is the vertices 3i, 3i + 1, 3i + 2, until [`indices`](Self::indices) says otherwise.
    ///
    /// ```
    /// let mesh = htree::Mesh::new(&[[0.0; 3], [1.0; 3], [2.0; 3]]);
    /// ```
    pub fn new(positions: &'a [[f32; 3]]) -> Self {
        Self::from_floats(bytemuck::cast_slice(positions))
    }

    /// As [`new`](Self::new), from a flat slice: x y z of every vertex.
    ///
    /// ```
    /// let mesh = htree::Mesh::from_floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    /// ```
    pub fn from_floats(positions: &'a [f32]) -> Self {
        Self { positions, position_stride: 0, indices: None, objects: None }
    }

    /// Bytes from one vertex to the next, for vertices that carry more than a position; a multiple
    /// of 4, at least 12. A slice of such vertices is made floats by `bytemuck::cast_slice`.
    ///
    /// ```
    /// // x y z, and a weight.
    /// let vertices = [[0.0, 0.0, 0.0, 9.0], [1.0, 0.0, 0.0, 9.0], [0.0, 1.0, 0.0, 9.0_f32]];
    /// let mesh = htree::Mesh::from_floats(bytemuck::cast_slice(&vertices)).position_stride(16);
    /// assert_eq!(htree::Tree::new(&mesh)?.bounds().hi, [1.0, 1.0, 0.0]);
    /// # Ok::<(), htree::Error>(())
    /// ```
    #[must_use]
    pub fn position_stride(mut self, bytes: u64) -> Self {
        self.position_stride = bytes;
        self
    }

    /// Three vertices for each triangle.
    ///
    /// ```
    /// let mesh = htree::Mesh::new(&[[0.0; 3], [1.0; 3], [2.0; 3]]).indices(&[[2, 1, 0]]);
    /// ```
    #[must_use]
    pub fn indices(self, indices: &'a [[u32; 3]]) -> Self {
        self.flat_indices(bytemuck::cast_slice(indices))
    }

    /// As [`indices`](Self::indices), from a flat slice.
    ///
    /// ```
    /// let mesh = htree::Mesh::new(&[[0.0; 3], [1.0; 3], [2.0; 3]]).flat_indices(&[2, 1, 0]);
    /// ```
    #[must_use]
    pub fn flat_indices(mut self, indices: &'a [u32]) -> Self {
        self.indices = Some(indices);
        self
    }

    /// Objects beside the triangles.
    ///
    /// ```
    /// use htree::{Mesh, Objects, Ray};
    /// let nothing = Objects::new(&[], |_object: u32, _ray: &Ray| None);
    /// let mesh = Mesh::new(&[]).objects(nothing);
    /// ```
    #[must_use]
    pub fn objects(mut self, objects: Objects<'a>) -> Self {
        self.objects = Some(objects);
        self
    }

    pub(crate) fn intersect(&self) -> Option<Arc<dyn Intersect>> {
        self.objects.as_ref().map(|objects| Arc::clone(&objects.intersect))
    }

    pub(crate) fn boxes(&self) -> &'a [Aabb] {
        self.objects.as_ref().map_or(&[], |objects| objects.boxes)
    }

    /// How many vertices lie wholly in the slice. The C library refuses a bad stride before it
    /// reads the first.
    fn vertex_count(&self) -> Result<u64> {
        let bytes = std::mem::size_of_val(self.positions) as u64;
        let stride = if self.position_stride == 0 { 12 } else { self.position_stride };
        if stride == 12 && bytes % 12 != 0 {
            let text = format!("{} floats are not three a vertex", self.positions.len());
            return Err(Error::new(ErrorKind::Argument, text));
        }
        Ok(bytes.checked_sub(12).map_or(0, |rest| rest / stride + 1))
    }

    /// The mesh without its objects, valid as long as the slices.
    pub(crate) fn to_raw(&self) -> Result<sys::htree_mesh> {
        let vertex_count = self.vertex_count()?;
        let triangle_count = match self.indices {
            Some(indices) if indices.len() % 3 != 0 => {
                let text = format!("{} indices are not three a triangle", indices.len());
                return Err(Error::new(ErrorKind::Argument, text));
            }
            Some(indices) => indices.len() as u64 / 3,
            // Rounded up, so that the library refuses vertices that are left over.
            None => vertex_count / 3 + u64::from(vertex_count % 3 != 0),
        };
        Ok(sys::htree_mesh {
            positions: self.positions.as_ptr(),
            position_stride: self.position_stride,
            vertex_count,
            indices: self.indices.map_or(std::ptr::null(), <[u32]>::as_ptr),
            triangle_count,
            objects: std::ptr::null(),
            reserved: [0; 2],
        })
    }
}

/// Where a ray meets an object: `t`, and two numbers of your own that come back in the
/// [`Hit`](crate::Hit).
///
/// ```
/// let hit = htree::ObjectHit { t: 2.5, u: 0.0, v: 0.0 };
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectHit {
    /// Least t of the object with `tmin <= t <= tmax`.
    pub t: f32,
    /// Handed through.
    pub u: f32,
    /// Handed through.
    pub v: f32,
}

/// Intersects objects with rays; closures `Fn(u32, &Ray) -> Option<ObjectHit>` do.
///
/// ```
/// use htree::{Aabb, Intersect, Mesh, ObjectHit, Objects, Ray, Tree};
///
/// /// Horizontal unit squares at given heights.
/// struct Shelves(Vec<f32>);
///
/// impl Intersect for Shelves {
///     fn intersect(&self, object: u32, ray: &Ray) -> Option<ObjectHit> {
///         let t = (self.0[object as usize] - ray.org[2]) / ray.dir[2];
///         let [x, y, _] = ray.at(t);
///         let inside = (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y);
///         (inside && ray.tmin <= t && t <= ray.tmax).then_some(ObjectHit { t, u: x, v: y })
///     }
/// }
///
/// let boxes = [1.0, 2.0].map(|z| Aabb { lo: [0.0, 0.0, z], hi: [1.0, 1.0, z] });
/// let tree = Tree::new(&Mesh::new(&[]).objects(Objects::new(&boxes, Shelves(vec![1.0, 2.0]))))?;
/// let hit = tree.intersect_one(&Ray::new([0.5, 0.5, 9.0], [0.0, 0.0, -1.0]))?.unwrap();
/// assert_eq!((hit.prim, hit.t), (1, 7.0));
/// # Ok::<(), htree::Error>(())
/// ```
pub trait Intersect: Send + Sync {
    /// The first point of object `object` on the ray, if any. Must depend on its arguments only;
    /// the point must lie in the object's box. Called from any thread that works for a query; a
    /// panic cancels the queries that run on the tree, and goes on in each of them.
    ///
    /// ```
    /// use htree::{Intersect, ObjectHit, Ray};
    /// let everywhere = |_object: u32, ray: &Ray| Some(ObjectHit { t: ray.tmin, u: 0.0, v: 0.0 });
    /// assert!(everywhere.intersect(0, &Ray::new([0.0; 3], [1.0; 3])).is_some());
    /// ```
    fn intersect(&self, object: u32, ray: &Ray) -> Option<ObjectHit>;
}

impl<F: Fn(u32, &Ray) -> Option<ObjectHit> + Send + Sync> Intersect for F {
    fn intersect(&self, object: u32, ray: &Ray) -> Option<ObjectHit> {
        self(object, ray)
    }
}

/// Objects of your own, known by box and callback: spheres, cones, terrain, ...
///
/// ```
/// use htree::{Aabb, ObjectHit, Objects, Ray};
/// let boxes = [Aabb { lo: [-1.0; 3], hi: [1.0; 3] }];
/// let objects = Objects::new(&boxes, |_object: u32, _ray: &Ray| None::<ObjectHit>);
/// ```
#[derive(Clone)]
pub struct Objects<'a> {
    boxes: &'a [Aabb],
    intersect: Arc<dyn Intersect>,
}

impl<'a> Objects<'a> {
    /// One object for each box; the boxes are borrowed for the build, `intersect` lives as long as
    /// the tree.
    ///
    /// ```
    /// let boxes = [htree::Aabb { lo: [0.0; 3], hi: [1.0; 3] }];
    /// let objects = htree::Objects::new(&boxes, |_object: u32, _ray: &htree::Ray| None);
    /// ```
    pub fn new(boxes: &'a [Aabb], intersect: impl Intersect + 'static) -> Self {
        Self { boxes, intersect: Arc::new(intersect) }
    }
}

impl fmt::Debug for Objects<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Objects").field("boxes", &self.boxes).finish_non_exhaustive()
    }
}
