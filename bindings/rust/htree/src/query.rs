// SPDX-License-Identifier: MIT
use crate::hooks::{Hooks, Progress, Report};
use crate::{Counters, Error, ErrorKind, Result};
use htree_sys as sys;
use std::fmt;
use std::mem::{size_of, MaybeUninit};
use std::ops::ControlFlow;
use std::ptr::null_mut;

/// How to query, for [`Tree::intersect_with`](crate::Tree::intersect_with) and
/// [`Tree::occluded_with`](crate::Tree::occluded_with).
///
/// ```
/// use htree::{Counters, Hit, Mesh, Query, Ray, Tree};
/// let tree = Tree::new(&Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))?;
/// let rays = [Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0])];
/// let (mut hits, mut counters) = ([Hit::default()], [Counters::default()]);
/// tree.intersect_with(&rays, &mut hits, Query::new().threads(1).counters(&mut counters))?;
/// assert_eq!(counters[0].intersections, 1);
/// # Ok::<(), htree::Error>(())
/// ```
#[derive(Default)]
pub struct Query<'a> {
    threads: Option<u32>,
    counters: Option<&'a mut [Counters]>,
    progress: Option<Box<Report<'a>>>,
}

impl<'a> Query<'a> {
    /// The defaults: the threads of the tree's options, no counters, no progress.
    ///
    /// ```
    /// let query = htree::Query::new();
    /// ```
    pub fn new() -> Self {
        Self::default()
    }

    /// 0 all cores, 1 the calling thread, n at most n.
    ///
    /// ```
    /// let query = htree::Query::new().threads(1);
    /// ```
    #[must_use]
    pub fn threads(mut self, threads: u32) -> Self {
        self.threads = Some(threads);
        self
    }

    /// Writes there what each ray cost, one for each ray. Counting costs a little time.
    ///
    /// ```
    /// let mut counters = vec![htree::Counters::default(); 8];
    /// let query = htree::Query::new().counters(&mut counters);
    /// ```
    #[must_use]
    pub fn counters(mut self, counters: &'a mut [Counters]) -> Self {
        self.counters = Some(counters);
        self
    }

    /// Calls `report` with the share that is done, on the calling thread; `Break` cancels the query,
    /// and then the answers are unspecified.
    ///
    /// ```
    /// use std::ops::ControlFlow;
    /// let deadline = std::time::Instant::now() + std::time::Duration::from_millis(5);
    /// let query = htree::Query::new().progress(|_done| {
    ///     if std::time::Instant::now() > deadline { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    /// });
    /// ```
    #[must_use]
    pub fn progress(mut self, report: impl FnMut(f64) -> ControlFlow<()> + 'a) -> Self {
        self.progress = Some(Box::new(report));
        self
    }

    /// Calls C with this query over `rays` rays and as many answers, and lets panics go on.
    pub(crate) fn run(
        mut self,
        hooks: &Hooks,
        threads: u32,
        (rays, answers): (usize, usize),
        call: impl FnOnce(*const sys::htree_query) -> sys::htree_status,
    ) -> Result<()> {
        let counters = self.counters.as_ref().map_or(rays, |counters| counters.len());
        if answers != rays || counters != rays {
            let text =
                format!("{rays} rays, {answers} answers, {counters} counters: must be equal");
            return Err(Error::new(ErrorKind::Argument, text));
        }
        let report = self.progress.as_mut().map(|report| &mut **report as _);
        let mut progress = Progress::new(hooks, report);
        let mut query = MaybeUninit::<sys::htree_query>::uninit();
        // SAFETY: a query of its size, which C fills unless it fails.
        let query = unsafe {
            Error::check(sys::htree_query_init(query.as_mut_ptr(), size_of_val(&query)))?;
            query.assume_init_mut()
        };
        query.threads = self.threads.unwrap_or(threads);
        query.counters = self.counters.map_or(null_mut(), |it| it.as_mut_ptr().cast());
        query.progress = progress.as_hook();
        let result = Error::check(call(query));
        progress.finish();
        result
    }
}

const fn size_of_val<T>(_: &MaybeUninit<T>) -> u64 {
    size_of::<T>() as u64
}

impl fmt::Debug for Query<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Query")
            .field("threads", &self.threads)
            .field("counters", &self.counters.is_some())
            .field("progress", &self.progress.is_some())
            .finish()
    }
}
