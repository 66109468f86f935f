// SPDX-License-Identifier: MIT
use crate::hooks::Hooks;
use crate::{Allocator, Error, ErrorKind, Result, Tasks};
use htree_sys as sys;
use std::ffi::{CStr, CString};
use std::fmt;
use std::mem::{size_of, MaybeUninit};
use std::str::FromStr;
use std::sync::Arc;

/// Which structure to build, or what for.
///
/// ```
/// use htree::Kind;
/// assert_eq!(Kind::BVH_SAH.to_string(), "bvh-sah");
/// assert_eq!("ah".parse::<Kind>()?, Kind::AH);
/// # Ok::<(), htree::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Kind(sys::htree_kind);

impl Kind {
    /// Uniform grid.
    pub const UG: Self = Self(sys::HTREE_UG);
    /// kd-tree by the surface area heuristic (SAH).
    pub const KD: Self = Self(sys::HTREE_KD);
    /// Bounding volume hierarchy, spatial median.
    pub const BVH_MEDIAN: Self = Self(sys::HTREE_BVH_MEDIAN);
    /// Bounding volume hierarchy, SAH over buckets of centroids.
    pub const BVH_SAH: Self = Self(sys::HTREE_BVH_SAH);
    /// Spatial kd-tree: two planes a node.
    pub const SKD: Self = Self(sys::HTREE_SKD);
    /// H-tree: spatial kd-tree with sparse bounding volumes.
    pub const H: Self = Self(sys::HTREE_H);
    /// H-tree by a 3D grid and a summed-area table: O(N log log N).
    pub const AH: Self = Self(sys::HTREE_AH);
    /// Eight children a node, eight triangles a leaf: for vector units.
    pub const WIDE: Self = Self(sys::HTREE_WIDE);
    /// Build every frame, trace a few rays a triangle.
    pub const FAST: Self = Self(sys::HTREE_FAST);
    /// The default.
    pub const BALANCED: Self = Self(sys::HTREE_BALANCED);
    /// Build once, trace for long.
    pub const BEST: Self = Self(sys::HTREE_BEST);

    /// The number of the kind in `htree.h`.
    ///
    /// ```
    /// assert_eq!(htree::Kind::KD.code(), 2);
    /// ```
    pub const fn code(self) -> i32 {
        self.0
    }

    /// The kind of that number. One that the library does not know is refused by the build.
    ///
    /// ```
    /// assert_eq!(htree::Kind::from_code(2), htree::Kind::KD);
    /// ```
    pub const fn from_code(code: i32) -> Self {
        Self(code)
    }

    /// Its name, or `None` for a number that is no kind.
    ///
    /// ```
    /// assert_eq!(htree::Kind::H.name(), Some("h"));
    /// assert_eq!(htree::Kind::from_code(99).name(), None);
    /// ```
    pub fn name(self) -> Option<&'static str> {
        // SAFETY: any number is allowed; the name is NULL or static.
        let name = unsafe { sys::htree_kind_name(self.0).as_ref() }?;
        unsafe { CStr::from_ptr(name) }.to_str().ok()
    }
}

impl Default for Kind {
    fn default() -> Self {
        Self::BALANCED
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.pad(name),
            None => write!(f, "kind {}", self.0),
        }
    }
}

impl FromStr for Kind {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        // SAFETY: a string that ends in 0.
        let kind =
            CString::new(name).map_or(0, |it| unsafe { sys::htree_kind_from_name(it.as_ptr()) });
        if kind == 0 {
            return Err(Error::new(ErrorKind::Argument, format!("no kind is called {name:?}")));
        }
        Ok(Self(kind))
    }
}

/// How to build. Starts from the library's defaults for a [`Kind`]; the build checks every number.
///
/// ```
/// use htree::{Kind, Mesh, Options, Tree};
/// let options = Options::new(Kind::AH).threads(1).strict(true);
/// let tree = Tree::build(&Mesh::new(&[]), &options)?;
/// assert_eq!(tree.stats()?.kind, Kind::AH);
/// # Ok::<(), htree::Error>(())
/// ```
#[derive(Clone)]
pub struct Options {
    /// Its hooks are zero; `to_raw` fills them.
    raw: sys::htree_options,
    /// Why the library has no defaults for the kind; the build says so.
    refused: Option<Error>,
    tasks: Option<Arc<dyn Tasks>>,
    allocator: Option<Arc<dyn Allocator>>,
}

// SAFETY: the pointers in `raw` are NULL, and the hooks are Send + Sync.
unsafe impl Send for Options {}
unsafe impl Sync for Options {}

/// A setter for each field that is a number, and its documentation.
macro_rules! setters {
    ($($(#[$doc:meta])+ $name:ident: $type:ty,)+) => {$(
        $(#[$doc])+
        #[must_use]
        pub fn $name(mut self, $name: $type) -> Self {
            self.raw.$name = $name;
            self
        }
    )+};
}

/// A switch for each flag.
macro_rules! flags {
    ($($(#[$doc:meta])+ $name:ident: $flag:expr,)+) => {$(
        $(#[$doc])+
        #[must_use]
        pub fn $name(mut self, on: bool) -> Self {
            self.raw.flags = if on { self.raw.flags | $flag } else { self.raw.flags & !$flag };
            self
        }
    )+};
}

impl Options {
    /// The defaults for `kind`.
    ///
    /// ```
    /// let options = htree::Options::new(htree::Kind::FAST);
    /// assert_eq!(options.kind(), htree::Kind::WIDE);
    /// ```
    pub fn new(kind: Kind) -> Self {
        let mut raw = MaybeUninit::<sys::htree_options>::zeroed();
        let size = size_of::<sys::htree_options>() as u64;
        // SAFETY: options of that size; zeros are a value too, where C leaves them.
        let (status, raw) = unsafe {
            let status = sys::htree_options_init(raw.as_mut_ptr(), size, kind.0);
            (Error::check(status), raw.assume_init())
        };
        Self { raw, refused: status.err(), tasks: None, allocator: None }
    }

    /// The structure that will be built: a preset stands for one of them.
    ///
    /// ```
    /// assert_eq!(htree::Options::default().kind(), htree::Kind::WIDE);
    /// ```
    pub fn kind(&self) -> Kind {
        Kind(self.raw.kind)
    }

    setters! {
        /// Threads of the build and of queries: 0 all cores, 1 the calling thread, n at most n.
        ///
        /// ```
        /// let options = htree::Options::default().threads(1);
        /// ```
        threads: u32,
        /// Cost is evaluated at one plane fewer than this along an axis, 2 to 64.
        ///
        /// ```
        /// let options = htree::Options::default().buckets(16);
        /// ```
        buckets: u32,
        /// 1: split along the widest extent of centroids only; 3: try all axes.
        ///
        /// ```
        /// let options = htree::Options::default().axes(3);
        /// ```
        axes: u32,
        /// C_SKD^T, traversing a node with two separating planes.
        ///
        /// ```
        /// let options = htree::Options::default().cost_skd(1.0);
        /// ```
        cost_skd: f32,
        /// C_2PN^T, clipping by two planes.
        ///
        /// ```
        /// let options = htree::Options::default().cost_bv2(1.0);
        /// ```
        cost_bv2: f32,
        /// C_6PN^T, clipping by six planes.
        ///
        /// ```
        /// let options = htree::Options::default().cost_bv6(1.2);
        /// ```
        cost_bv6: f32,
        /// C_IT, one test of a triangle or an object.
        ///
        /// ```
        /// let options = htree::Options::default().cost_intersect(1.2);
        /// ```
        cost_intersect: f32,
        /// Cells of the AH-tree's grid for each triangle, 1/64 to 64.
        ///
        /// ```
        /// let options = htree::Options::new(htree::Kind::AH).cells_per_prim(0.5);
        /// ```
        cells_per_prim: f32,
        /// Ranges of no more triangles are built as an H-tree, 1 to 2^20.
        ///
        /// ```
        /// let options = htree::Options::new(htree::Kind::AH).few_prims(64);
        /// ```
        few_prims: u32,
    }

    flags! {
        /// Refuse NaN, infinite and oversize coordinates instead of skipping them.
        ///
        /// ```
        /// use htree::{ErrorKind, Mesh, Options, Tree};
        /// let mesh = [[f32::NAN; 3]; 3];
        /// let error = Tree::build(&Mesh::new(&mesh), &Options::default().strict(true)).unwrap_err();
        /// assert_eq!(error.kind(), ErrorKind::Geometry);
        /// ```
        strict: sys::HTREE_STRICT,
        /// H, AH: bounding nodes of any of 63 sets of planes.
        ///
        /// ```
        /// let options = htree::Options::new(htree::Kind::H).any_planes(true);
        /// ```
        any_planes: sys::HTREE_ANY_PLANES,
        /// AH: planes as the grid gives them, half a cell wide.
        ///
        /// ```
        /// let options = htree::Options::new(htree::Kind::AH).loose_planes(true);
        /// ```
        loose_planes: sys::HTREE_LOOSE_PLANES,
        /// WIDE: Morton order below the grid: faster to build, slower to trace.
        ///
        /// ```
        /// let options = htree::Options::new(htree::Kind::WIDE).morton(true);
        /// ```
        morton: sys::HTREE_MORTON,
        /// WIDE: less than half of the memory, slower to build and to trace. Such a tree has no view,
        /// and no [`LazyTree`](crate::LazyTree) is built with this.
        ///
        /// ```
        /// let options = htree::Options::new(htree::Kind::WIDE).compact(true);
        /// ```
        compact: sys::HTREE_COMPACT,
        /// BVH, SKD, H, AH: collapses the finished tree into one of kind WIDE.
        ///
        /// ```
        /// use htree::{Kind, Mesh, Options, Tree};
        /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        /// let tree = Tree::build(&Mesh::new(&corners), &Options::new(Kind::AH).collapse(true))?;
        /// assert_eq!(tree.stats()?.kind, Kind::WIDE);
        /// # Ok::<(), htree::Error>(())
        /// ```
        collapse: sys::HTREE_COLLAPSE,
    }

    /// A parallel loop for the build and the queries of its tree, in place of the library's threads.
    ///
    /// ```
    /// struct InTurn;
    /// impl htree::Tasks for InTurn {
    ///     fn run(&self, count: u32, task: &(dyn Fn(u32) + Sync)) {
    ///         (0..count).for_each(task);
    ///     }
    /// }
    /// let options = htree::Options::default().tasks(InTurn);
    /// ```
    #[must_use]
    pub fn tasks(mut self, tasks: impl Tasks + 'static) -> Self {
        self.tasks = Some(Arc::new(tasks));
        self
    }

    /// Memory for the build and its tree.
    ///
    /// ```
    /// fn with(memory: impl htree::Allocator + 'static) -> htree::Options {
    ///     htree::Options::default().allocator(memory)
    /// }
    /// ```
    #[must_use]
    pub fn allocator(mut self, allocator: impl Allocator + 'static) -> Self {
        self.allocator = Some(Arc::new(allocator));
        self
    }

    /// Measures the four costs on this machine, in some milliseconds, in units of `cost_skd`. What it
    /// finds depends on timing, and so will the tree; the hits will not.
    ///
    /// ```
    /// let options = htree::Options::default().calibrate()?;
    /// assert_eq!(options.costs()[0], 1.0);
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn calibrate(mut self) -> Result<Self> {
        self.verify()?;
        // SAFETY: initialised options without hooks.
        Error::check(unsafe { sys::htree_calibrate(&mut self.raw) })?;
        Ok(self)
    }

    /// `cost_skd`, `cost_bv2`, `cost_bv6`, `cost_intersect`.
    ///
    /// ```
    /// assert_eq!(htree::Options::default().cost_bv2(3.0).costs()[1], 3.0);
    /// ```
    pub fn costs(&self) -> [f32; 4] {
        [self.raw.cost_skd, self.raw.cost_bv2, self.raw.cost_bv6, self.raw.cost_intersect]
    }

    fn verify(&self) -> Result<()> {
        self.refused.clone().map_or(Ok(()), Err)
    }

    /// The hooks of a tree with these options.
    pub(crate) fn to_hooks(&self) -> Arc<Hooks> {
        Hooks::new(self.tasks.clone(), self.allocator.clone())
    }

    pub(crate) fn to_raw(&self, hooks: &Arc<Hooks>) -> Result<sys::htree_options> {
        self.verify()?;
        let (tasks, allocator) = (hooks.to_tasks(), hooks.to_allocator());
        Ok(sys::htree_options { tasks, allocator, ..self.raw })
    }
}

impl Default for Options {
    fn default() -> Self {
        Self::new(Kind::default())
    }
}

impl fmt::Debug for Options {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Options")
            .field("kind", &self.kind())
            .field("flags", &self.raw.flags)
            .field("threads", &self.raw.threads)
            .field("buckets", &self.raw.buckets)
            .field("axes", &self.raw.axes)
            .field("costs", &self.costs())
            .field("cells_per_prim", &self.raw.cells_per_prim)
            .field("few_prims", &self.raw.few_prims)
            .finish_non_exhaustive()
    }
}
