// SPDX-License-Identifier: MIT
use crate::hooks::{Hooks, Progress, Report};
use crate::{Aabb, Error, Hit, Mesh, Options, Query, Ray, Result, Stats, View};
use htree_sys as sys;
use std::fmt;
use std::mem::{size_of, MaybeUninit};
use std::ops::ControlFlow;
use std::ptr::{null_mut, NonNull};
use std::sync::Arc;

/// A finished tree. Share it between any number of threads; only [`update`](Self::update) changes
/// it, which needs it for itself.
///
/// ```
/// use htree::{Hit, Mesh, Ray, Tree};
/// let tree = Tree::new(&Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))?;
/// let rays: Vec<Ray> =
///     (0..10).map(|i| Ray::new([0.1 * i as f32, 0.3, 1.0], [0.0, 0.0, -1.0])).collect();
/// let mut hits = vec![Hit::default(); rays.len()];
/// tree.intersect(&rays, &mut hits)?;
/// assert!(hits[1].is_hit() && !hits[9].is_hit());
/// # Ok::<(), htree::Error>(())
/// ```
pub struct Tree {
    tree: NonNull<sys::htree>,
    /// The threads of the options, which queries take unless they say otherwise.
    threads: u32,
    /// Of the options and the last mesh; what queries look at.
    pub(crate) hooks: Arc<Hooks>,
    /// Of the options. After `tree`, which C frees through them.
    pub(crate) base: Arc<Hooks>,
}

// SAFETY: a tree changes by `&mut` only, C lets any thread query and free it, and every hook that it
// holds is Send + Sync.
unsafe impl Send for Tree {}
unsafe impl Sync for Tree {}

impl Tree {
    /// Builds with the default options.
    ///
    /// ```
    /// let tree = htree::Tree::new(&htree::Mesh::new(&[]))?;
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn new(mesh: &Mesh<'_>) -> Result<Self> {
        Self::build(mesh, &Options::default())
    }

    /// Builds a tree over the mesh. Triangles with a NaN, infinite or oversize coordinate are
    /// skipped, those without area are never hit; both are counted in [`Stats`]. No triangles at all
    /// is fine: every ray misses.
    ///
    /// ```
    /// use htree::{Kind, Mesh, Options, Tree};
    /// let tree = Tree::build(&Mesh::new(&[]), &Options::new(Kind::KD))?;
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn build(mesh: &Mesh<'_>, options: &Options) -> Result<Self> {
        Self::build_reporting(mesh, options, 0, None)
    }

    /// As [`build`](Self::build); calls `report` with the share that is done, on this thread, and
    /// `Break` cancels.
    ///
    /// ```
    /// use htree::{ErrorKind, Mesh, Options, Tree};
    /// use std::ops::ControlFlow;
    /// let points: Vec<_> = (0..3000).map(|i| [i as f32, (i % 3) as f32, (i % 7) as f32]).collect();
    /// let stop = |_done: f64| ControlFlow::Break(());
    /// let error = Tree::build_with_progress(&Mesh::new(&points), &Options::default(), stop);
    /// assert_eq!(error.unwrap_err().kind(), ErrorKind::Cancelled);
    /// ```
    pub fn build_with_progress(
        mesh: &Mesh<'_>,
        options: &Options,
        mut report: impl FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Self> {
        Self::build_reporting(mesh, options, 0, Some(&mut report))
    }

    /// With these flags besides those of the options. If HTREE_LAZY is one of them, the mesh's slices
    /// must stay as they are until `complete`.
    pub(crate) fn build_reporting<'r>(
        mesh: &Mesh<'_>,
        options: &Options,
        flags: u32,
        report: Option<&'r mut Report<'r>>,
    ) -> Result<Self> {
        crate::verify_library()?;
        let base = options.to_hooks();
        let hooks = base.with_objects(mesh.intersect());
        let mut raw_mesh = mesh.to_raw()?;
        let objects = hooks.to_objects(mesh.boxes());
        if hooks.has_objects() {
            raw_mesh.objects = &objects;
        }
        let mut progress = Progress::new(&hooks, report);
        let mut raw_options = options.to_raw(&base)?;
        raw_options.flags |= flags;
        raw_options.progress = progress.as_hook();
        let mut out = null_mut();
        // SAFETY: the slices, options and hooks live through the call, and the hooks, which the
        // tree refers to, longer than it.
        let status = unsafe { sys::htree_build(&mut out, &raw_mesh, &raw_options) };
        let result = Error::check(status);
        let tree = NonNull::new(out).map(|tree| Self {
            tree,
            threads: raw_options.threads,
            hooks: Arc::clone(&hooks),
            base,
        });
        progress.finish();
        result.map(|()| tree.expect("C gives a tree or an error"))
    }

    /// A tree that C has given.
    pub(crate) fn from_raw(
        tree: *mut sys::htree,
        threads: u32,
        (base, hooks): (Arc<Hooks>, Arc<Hooks>),
    ) -> Self {
        let tree = NonNull::new(tree).expect("C gives a tree or an error");
        Self { tree, threads, hooks, base }
    }

    /// Writes the closest hit of every ray: `hits[i]` of `rays[i]`. Spreads a large batch over cores.
    ///
    /// ```
    /// use htree::{Hit, Mesh, Ray, Tree};
    /// let tree = Tree::new(&Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))?;
    /// let mut hits = [Hit::default()];
    /// tree.intersect(&[Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0])], &mut hits)?;
    /// assert_eq!(hits[0].t, 1.0);
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<()> {
        self.intersect_with(rays, hits, Query::new())
    }

    /// As [`intersect`](Self::intersect), with threads, counters and progress of its own.
    ///
    /// ```
    /// use htree::{Hit, Mesh, Query, Ray, Tree};
    /// let tree = Tree::new(&Mesh::new(&[]))?;
    /// let mut hits = [Hit::default()];
    /// tree.intersect_with(&[Ray::new([0.0; 3], [1.0; 3])], &mut hits, Query::new().threads(1))?;
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn intersect_with(&self, rays: &[Ray], hits: &mut [Hit], query: Query<'_>) -> Result<()> {
        let hit = hits.as_mut_ptr().cast();
        query.run(&self.hooks, self.threads, (rays.len(), hits.len()), |query| {
            // SAFETY: as many hits and counters as rays.
            unsafe {
                sys::htree_intersect(
                    self.as_ptr(),
                    ray_pointer(rays),
                    rays.len() as u64,
                    hit,
                    query,
                )
            }
        })
    }

    /// The closest hit of one ray, or `None`.
    ///
    /// ```
    /// use htree::{Mesh, Ray, Tree};
    /// let tree = Tree::new(&Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))?;
    /// assert!(tree.intersect_one(&Ray::new([5.0, 5.0, 1.0], [0.0, 0.0, -1.0]))?.is_none());
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn intersect_one(&self, ray: &Ray) -> Result<Option<Hit>> {
        let mut hit = Hit::default();
        self.intersect(std::slice::from_ref(ray), std::slice::from_mut(&mut hit))?;
        Ok(Some(hit).filter(Hit::is_hit))
    }

    /// Writes for every ray whether it hits anything; faster than the closest hit.
    ///
    /// ```
    /// use htree::{Mesh, Ray, Tree};
    /// let tree = Tree::new(&Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))?;
    /// let to_light = Ray::new([0.2, 0.2, -1.0], [0.0, 0.0, 1.0]);
    /// let mut shadow = [false, true];
    /// tree.occluded(&[to_light, to_light.between(0.0, 0.5)], &mut shadow)?;
    /// assert_eq!(shadow, [true, false]);
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) -> Result<()> {
        self.occluded_with(rays, occluded, Query::new())
    }

    /// As [`occluded`](Self::occluded), with threads, counters and progress of its own.
    ///
    /// ```
    /// use htree::{Mesh, Query, Ray, Tree};
    /// let tree = Tree::new(&Mesh::new(&[]))?;
    /// let mut shadow = [true];
    /// tree.occluded_with(&[Ray::new([0.0; 3], [1.0; 3])], &mut shadow, Query::new().threads(1))?;
    /// assert_eq!(shadow, [false]);
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn occluded_with(
        &self,
        rays: &[Ray],
        occluded: &mut [bool],
        query: Query<'_>,
    ) -> Result<()> {
        let answer = occluded.as_mut_ptr().cast();
        query.run(&self.hooks, self.threads, (rays.len(), occluded.len()), |query| {
            // SAFETY: as many answers and counters as rays, and C writes 0 or 1, which are bools.
            unsafe {
                sys::htree_occluded(
                    self.as_ptr(),
                    ray_pointer(rays),
                    rays.len() as u64,
                    answer,
                    query,
                )
            }
        })
    }

    /// Whether one ray hits anything.
    ///
    /// ```
    /// use htree::{Mesh, Ray, Tree};
    /// let tree = Tree::new(&Mesh::new(&[]))?;
    /// assert!(!tree.occluded_one(&Ray::new([0.0; 3], [1.0; 3]))?);
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn occluded_one(&self, ray: &Ray) -> Result<bool> {
        let mut occluded = false;
        self.occluded(std::slice::from_ref(ray), std::slice::from_mut(&mut occluded))?;
        Ok(occluded)
    }

    /// Bounds of everything that can be hit.
    ///
    /// ```
    /// use htree::{Mesh, Tree};
    /// let tree = Tree::new(&Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]))?;
    /// assert_eq!(tree.bounds().hi, [1.0, 2.0, 0.0]);
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn bounds(&self) -> Aabb {
        let mut bounds = Aabb { lo: [f32::INFINITY; 3], hi: [f32::NEG_INFINITY; 3] };
        let raw: *mut Aabb = &mut bounds;
        // SAFETY: fails for NULL only.
        let status = unsafe { sys::htree_get_bounds(self.as_ptr(), raw.cast()) };
        debug_assert_eq!(status, sys::HTREE_OK);
        bounds
    }

    /// Counts the tree's parts; walks all of it.
    ///
    /// ```
    /// use htree::{Mesh, Tree};
    /// let tree = Tree::new(&Mesh::new(&[[0.0; 3], [0.0; 3], [0.0; 3]]))?;
    /// assert_eq!(tree.stats()?.degenerate, 1);
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn stats(&self) -> Result<Stats> {
        let size = size_of::<sys::htree_stats>() as u32;
        let mut stats = sys::htree_stats { size, ..sys::htree_stats::default() };
        // SAFETY: stats of that size.
        Error::check(unsafe { sys::htree_get_stats(self.as_ptr(), &mut stats) })?;
        Ok(Stats::from_raw(&stats))
    }

    /// The arrays of the tree, for devices, viewers and files; they borrow it. Fails with
    /// [`ErrorKind::Unsupported`](crate::ErrorKind::Unsupported) for a [`LazyTree`](crate::LazyTree),
    /// and for a tree that is [`compact`](crate::Options::compact).
    ///
    /// ```
    /// use htree::{Kind, Mesh, Options, Tree};
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let tree = Tree::build(&Mesh::new(&corners), &Options::new(Kind::H))?;
    /// assert_eq!(tree.view()?.triangles, [corners]);
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn view(&self) -> Result<View<'_>> {
        let mut view = MaybeUninit::<sys::htree_view>::zeroed();
        // SAFETY: zeros are a view of nothing, which C fills unless it fails.
        let view = unsafe {
            (*view.as_mut_ptr()).size = size_of::<sys::htree_view>() as u32;
            Error::check(sys::htree_get_view(self.as_ptr(), view.as_mut_ptr()))?;
            view.assume_init()
        };
        // SAFETY: the arrays are as long as they say, and live and stay the same while borrowed.
        Ok(unsafe { View::from_raw(&view) })
    }

    /// Proves the structure: every box and plane contains what lies below it, every triangle is
    /// reached. For tests; walks all of the tree.
    ///
    /// ```
    /// htree::Tree::new(&htree::Mesh::new(&[]))?.check()?;
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn check(&self) -> Result<()> {
        let panics_before = self.hooks.panic_count();
        // SAFETY: a finished tree.
        let result = Error::check(unsafe { sys::htree_check(self.as_ptr()) });
        self.hooks.resume_panic(panics_before);
        result
    }

    /// The tree as C knows it, for functions that this crate lacks; valid as long as `self`.
    ///
    /// ```
    /// use htree::sys;
    /// let tree = htree::Tree::new(&htree::Mesh::new(&[]))?;
    /// assert_eq!(unsafe { sys::htree_check(tree.as_ptr()) }, sys::HTREE_OK);
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn as_ptr(&self) -> *const sys::htree {
        self.tree.as_ptr()
    }

    /// For the calls that change it.
    pub(crate) fn as_mut_ptr(&mut self) -> *mut sys::htree {
        self.tree.as_ptr()
    }
}

fn ray_pointer(rays: &[Ray]) -> *const sys::htree_ray {
    rays.as_ptr().cast()
}

impl Drop for Tree {
    fn drop(&mut self) {
        // SAFETY: C gave it, nobody frees it twice, and queries borrow it, so none is running.
        unsafe { sys::htree_free(self.tree.as_ptr()) }
    }
}

impl fmt::Debug for Tree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut fields = f.debug_struct("Tree");
        if let Ok(view) = self.view() {
            fields.field("kind", &view.kind).field("prims", &view.prims);
        }
        fields.field("bounds", &self.bounds()).finish_non_exhaustive()
    }
}
