// SPDX-License-Identifier: MIT
use crate::hooks::{Hooks, Progress};
use crate::{Error, Intersect, Result, Tree};
use htree_sys as sys;
use std::mem::{size_of, MaybeUninit};
use std::ptr::null_mut;
use std::sync::Arc;

/// How to load a tree that [`Tree::save`] wrote.
///
/// ```
/// use htree::{LoadOptions, Mesh, Tree};
/// let file = Tree::new(&Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))?.save()?;
/// let tree = LoadOptions::new().threads(1).load(&file)?;
/// # Ok::<(), htree::Error>(())
/// ```
#[derive(Default)]
pub struct LoadOptions {
    threads: u32,
    intersect: Option<Arc<dyn Intersect>>,
}

impl LoadOptions {
    /// All cores, no objects.
    ///
    /// ```
    /// let options = htree::LoadOptions::new();
    /// ```
    pub fn new() -> Self {
        Self::default()
    }

    /// The threads of queries: 0 all cores, 1 the caller's, n at most n.
    ///
    /// ```
    /// let options = htree::LoadOptions::new().threads(2);
    /// ```
    #[must_use]
    pub fn threads(mut self, threads: u32) -> Self {
        self.threads = threads;
        self
    }

    /// What intersects the objects of the tree: as in [`Objects`](crate::Objects).
    ///
    /// ```
    /// use htree::{LoadOptions, ObjectHit, Ray};
    /// let options = LoadOptions::new().objects(|_object: u32, _ray: &Ray| None::<ObjectHit>);
    /// ```
    #[must_use]
    pub fn objects(mut self, intersect: impl Intersect + 'static) -> Self {
        self.intersect = Some(Arc::new(intersect));
        self
    }

    /// The tree that was saved: the same hits. It copies the bytes. Whatever they are, what is
    /// returned has been proved; [`ErrorKind::Corrupt`](crate::ErrorKind::Corrupt) says that they
    /// are no tree.
    ///
    /// ```
    /// use htree::{ErrorKind, LoadOptions};
    /// let error = LoadOptions::new().load(b"no tree").unwrap_err();
    /// assert_eq!(error.kind(), ErrorKind::Corrupt);
    /// ```
    pub fn load(&self, file: &[u8]) -> Result<Tree> {
        crate::verify_library()?;
        let base = Hooks::new(None, None);
        let hooks = base.with_objects(self.intersect.clone());
        let progress = Progress::new(&hooks, None);
        let mut options = MaybeUninit::<sys::htree_load_options>::uninit();
        let size = size_of::<sys::htree_load_options>() as u64;
        // SAFETY: options of that size, which C fills.
        let mut options = unsafe {
            Error::check(sys::htree_load_options_init(options.as_mut_ptr(), size))?;
            options.assume_init()
        };
        options.threads = self.threads;
        if hooks.has_objects() {
            let objects = hooks.to_objects(&[]);
            (options.intersect, options.user) = (objects.intersect, objects.user);
        }
        let mut out = null_mut();
        let (bytes, size) = (file.as_ptr().cast(), file.len() as u64);
        // SAFETY: the slice lives through the call, and the hooks longer than the tree.
        let status = unsafe { sys::htree_load(&mut out, bytes, size, &options) };
        let result = Error::check(status);
        progress.finish();
        result.map(|()| Tree::from_raw(out, self.threads, (base, Arc::clone(&hooks))))
    }
}

impl std::fmt::Debug for LoadOptions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LoadOptions").field("threads", &self.threads).finish_non_exhaustive()
    }
}

impl Tree {
    /// The tree as bytes, for [`load`](Self::load); objects are saved as their boxes.
    ///
    /// ```
    /// use htree::{Mesh, Tree};
    /// let tree = Tree::new(&Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))?;
    /// let file = tree.save()?;
    /// assert_eq!(Tree::load(&file)?.save()?, file);
    /// # Ok::<(), htree::Error>(())
    /// ```
    pub fn save(&self) -> Result<Vec<u8>> {
        let mut bytes = 0;
        // SAFETY: without room C only tells the size; then there is as much room as it says.
        unsafe {
            Error::check(sys::htree_save(self.as_ptr(), null_mut(), 0, &mut bytes))?;
            let mut file = vec![0; bytes as usize];
            let room = file.as_mut_ptr().cast();
            Error::check(sys::htree_save(self.as_ptr(), room, bytes, &mut bytes))?;
            Ok(file)
        }
    }

    /// Loads with the defaults of [`LoadOptions`], a tree without objects.
    ///
    /// ```
    /// use htree::{ErrorKind, Tree};
    /// assert_eq!(Tree::load(&[]).unwrap_err().kind(), ErrorKind::Corrupt);
    /// ```
    pub fn load(file: &[u8]) -> Result<Self> {
        LoadOptions::new().load(file)
    }
}
