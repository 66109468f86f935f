// SPDX-License-Identifier: MIT
use crate::{Error, Mesh, Options, Result, Tree};
use htree_sys as sys;
use std::marker::PhantomData;
use std::ops::Deref;
use std::sync::Arc;

/// How [`Tree::update`] brings a tree to a mesh.
///
/// ```
/// use htree::{How, Mesh, Tree};
/// let mut tree = Tree::new(&Mesh::new(&[]))?;
/// assert_eq!(tree.update(&Mesh::new(&[]), How::Rebuild)?, 1.0);
/// # Ok::<(), htree::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum How {
    /// As [`Tree::build`] would, in the memory of the builds before.
    Rebuild,
    /// WIDE: the same nodes around the new positions.
    Refit,
}

impl How {
    const fn code(self) -> i32 {
        match self {
            Self::Rebuild => sys::HTREE_REBUILD,
            Self::Refit => sys::HTREE_REFIT,
        }
    }
}

impl Tree {
    /// Brings the tree to new positions, or with [`How::Rebuild`] to any mesh at all, with the
    /// options that it was built with. An error leaves it as it was.
    ///
    /// Refitting is for a mesh of as many triangles and objects; the tree is rebuilt where it
    /// cannot do: other kinds, a compact tree, or other triangles than before that can be hit. The
    /// number is the expected cost of a ray over that when the tree was built: 1 after a rebuild;
    /// from about 1.5 on rebuilding pays.
    ///
    /// ```
    /// use htree::{How, Mesh, Ray, Tree};
    /// let mut corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mut tree = Tree::new(&Mesh::new(&corners))?;
    /// for z in [1.0, 2.0] {
    ///     corners.iter_mut().for_each(|corner| corner[2] = z);
    ///     tree.update(&Mesh::new(&corners), How::Refit)?;
    ///     let hit = tree.intersect_one(&Ray::new([0.2, 0.2, 9.0], [0.0, 0.0, -1.0]))?.unwrap();
    ///     assert_eq!(hit.t, 9.0 - z);
    /// }
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn update(&mut self, mesh: &Mesh<'_>, how: How) -> Result<f64> {
        self.change(|tree| {
            let quality = tree.update_raw(mesh, how)?;
            tree.complete_raw()?; // where a `LazyTree` became this tree: it is built lazily again
            Ok(quality)
        })
    }

    /// Runs calls of C that change the tree, and lets panics of hooks go on after them.
    fn change<R>(&mut self, call: impl FnOnce(&mut Self) -> Result<R>) -> Result<R> {
        let panics_before = self.base.panic_count();
        let result = call(self);
        self.base.resume_panic(panics_before);
        result
    }

    /// A lazy tree reads the slices from then on.
    fn update_raw(&mut self, mesh: &Mesh<'_>, how: How) -> Result<f64> {
        let hooks = self.base.with_objects(mesh.intersect());
        let mut raw_mesh = mesh.to_raw()?;
        let objects = hooks.to_objects(mesh.boxes());
        if hooks.has_objects() {
            raw_mesh.objects = &objects;
        }
        let mut quality = 1.0;
        // SAFETY: the slices live through the call, and the hooks longer than the tree refers to
        // them; `&mut` says that no query is running.
        Error::check(unsafe {
            sys::htree_update(self.as_mut_ptr(), &raw_mesh, how.code(), &mut quality)
        })?;
        self.hooks = Arc::clone(&hooks);
        Ok(quality)
    }

    fn complete_raw(&mut self) -> Result<()> {
        // SAFETY: `&mut` says that no query is running.
        Error::check(unsafe { sys::htree_complete(self.as_mut_ptr()) })
    }
}

/// A wide tree of which only the top is built, the rest by the first ray that gets there. It borrows the
/// slices of its mesh, and is queried as a [`Tree`]; the hits are the same.
///
/// The whole of a tree is built sooner, the first picture of it later. Other kinds are built at
/// once.
///
/// ```
/// use htree::{Kind, LazyTree, Mesh, Options, Ray};
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let tree = LazyTree::build(&Mesh::new(&corners), &Options::new(Kind::WIDE))?;
/// assert!(tree.intersect_one(&Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0]))?.is_some());
/// assert_eq!(tree.complete()?.view()?.prims, 1);
/// # Ok::<(), htree::Error>(())
/// ```
///
/// What the tree has borrowed does not change before it is complete:
///
/// ```compile_fail,E0506
/// use htree::{LazyTree, Mesh, Options};
/// let mut corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let tree = LazyTree::build(&Mesh::new(&corners), &Options::default())?;
/// corners[0] = [9.0; 3];
/// tree.check()?;
/// # Ok::<(), htree::Error>(())
/// ```
///
/// Nor does it end:
///
/// ```compile_fail,E0597
/// use htree::{LazyTree, Mesh, Options};
/// let tree = {
///     let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
///     LazyTree::build(&Mesh::new(&corners), &Options::default())?
/// };
/// tree.check()?;
/// # Ok::<(), htree::Error>(())
/// ```
#[derive(Debug)]
pub struct LazyTree<'m> {
    tree: Tree,
    mesh: PhantomData<Mesh<'m>>,
}

impl<'m> LazyTree<'m> {
    /// Builds the top of a tree.
    ///
    /// ```
    /// use htree::{LazyTree, Mesh, Options};
    /// let tree = LazyTree::build(&Mesh::new(&[]), &Options::default())?;
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn build(mesh: &Mesh<'m>, options: &Options) -> Result<Self> {
        let tree = Tree::build_reporting(mesh, options, sys::HTREE_LAZY, None)?;
        Ok(Self { tree, mesh: PhantomData })
    }

    /// Builds what rays have not reached yet, on all cores, and gives the slices back.
    ///
    /// ```
    /// use htree::{How, LazyTree, Mesh, Options};
    /// let mut corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mut tree = LazyTree::build(&Mesh::new(&corners), &Options::default())?.complete()?;
    /// corners[0] = [0.5, 0.0, 0.0];
    /// tree.update(&Mesh::new(&corners), How::Refit)?;
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn complete(mut self) -> Result<Tree> {
        self.tree.change(Tree::complete_raw)?;
        Ok(self.tree)
    }

    /// As [`Tree::update`], but what comes of it is lazy again, and borrows this mesh instead.
    ///
    /// ```
    /// use htree::{How, LazyTree, Mesh, Options};
    /// let frames = [1.0, 2.0].map(|x| [[0.0, 0.0, 0.0], [x, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    /// let mut tree = LazyTree::build(&Mesh::new(&frames[0]), &Options::default())?;
    /// assert_eq!(tree.update(&Mesh::new(&frames[1]), How::Rebuild)?, 1.0);
    /// assert_eq!(tree.bounds().hi, [2.0, 1.0, 0.0]);
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn update(&mut self, mesh: &Mesh<'m>, how: How) -> Result<f64> {
        self.tree.change(|tree| tree.update_raw(mesh, how))
    }
}

impl Deref for LazyTree<'_> {
    type Target = Tree;

    fn deref(&self) -> &Tree {
        &self.tree
    }
}
