// SPDX-License-Identifier: MIT
//! Closures and traits of the caller's, as the C library calls them. No panic leaves this file
//! towards C: it is kept, and goes on once the library has returned.

use crate::{Intersect, Ray};
use htree_sys as sys;
use std::any::Any;
use std::ffi::c_void;
use std::ops::ControlFlow;
use std::panic::{catch_unwind, resume_unwind, AssertUnwindSafe};
use std::ptr::null_mut;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A parallel loop of your own, in place of the library's threads; see
/// [`Options::tasks`](crate::Options::tasks).
///
/// ```
/// struct InTurn;
///
/// impl htree::Tasks for InTurn {
///     fn run(&self, count: u32, task: &(dyn Fn(u32) + Sync)) {
///         (0..count).for_each(task);
///     }
/// }
/// ```
pub trait Tasks: Send + Sync {
    /// Calls `task(i)` for every `0 <= i < count`, in any order, on any threads, and returns when
    /// all are done. What it leaves out is done on the calling thread; what it calls twice is done
    /// once.
    ///
    /// ```
    /// # struct Chunks;
    /// impl htree::Tasks for Chunks {
    ///     fn run(&self, count: u32, task: &(dyn Fn(u32) + Sync)) {
    ///         std::thread::scope(|scope| {
    ///             for first in 0..2 {
    ///                 scope.spawn(move || (first..count).step_by(2).for_each(task));
    ///             }
    ///         });
    ///     }
    /// }
    /// ```
    fn run(&self, count: u32, task: &(dyn Fn(u32) + Sync));
}

/// Memory of your own; see [`Options::allocator`](crate::Options::allocator).
///
/// # Safety
///
/// `allocate` returns NULL or memory as it says, which nothing else uses until `release`.
///
/// ```
/// use std::alloc::{alloc, dealloc, Layout};
///
/// /// Everything at 64 bytes, since `release` is not told the alignment.
/// struct Lines;
///
/// unsafe impl htree::Allocator for Lines {
///     fn allocate(&self, bytes: usize, alignment: usize) -> *mut u8 {
///         assert!(alignment <= 64);
///         unsafe { alloc(Layout::from_size_align(bytes.max(1), 64).unwrap()) }
///     }
///     unsafe fn release(&self, memory: *mut u8, bytes: usize) {
///         unsafe { dealloc(memory, Layout::from_size_align(bytes.max(1), 64).unwrap()) }
///     }
/// }
///
/// let tree = htree::Tree::build(
///     &htree::Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
///     &htree::Options::default().allocator(Lines),
/// )?;
/// # Ok::<(), htree::Error>(())
/// ```
pub unsafe trait Allocator: Send + Sync {
    /// `bytes` bytes at a multiple of `alignment`, a power of two, or NULL: then the build fails
    /// with [`ErrorKind::Memory`](crate::ErrorKind::Memory). Called from any thread.
    ///
    /// ```
    /// # struct Nothing;
    /// unsafe impl htree::Allocator for Nothing {
    ///     fn allocate(&self, _bytes: usize, _alignment: usize) -> *mut u8 {
    ///         std::ptr::null_mut()
    ///     }
    ///     unsafe fn release(&self, _memory: *mut u8, _bytes: usize) {}
    /// }
    /// let error = htree::Tree::build(
    ///     &htree::Mesh::new(&[]),
    ///     &htree::Options::default().allocator(Nothing),
    /// );
    /// assert_eq!(error.unwrap_err().kind(), htree::ErrorKind::Memory);
    /// ```
    fn allocate(&self, bytes: usize, alignment: usize) -> *mut u8;

    /// Takes back what `allocate` gave for as many bytes. A panic here is swallowed.
    ///
    /// # Safety
    ///
    /// `memory` comes from `allocate(bytes, _)` and is not used again.
    ///
    /// ```
    /// # use std::alloc::{alloc, dealloc, Layout};
    /// # struct Lines;
    /// # fn lines(bytes: usize) -> Layout {
    /// #     Layout::from_size_align(bytes.max(1), 64).unwrap()
    /// # }
    /// unsafe impl htree::Allocator for Lines {
    /// #   fn allocate(&self, bytes: usize, _alignment: usize) -> *mut u8 {
    /// #       unsafe { alloc(lines(bytes)) }
    /// #   }
    ///     unsafe fn release(&self, memory: *mut u8, bytes: usize) {
    ///         unsafe { dealloc(memory, lines(bytes)) }
    ///     }
    /// }
    /// # let options = htree::Options::default().allocator(Lines);
    /// # htree::Tree::build(&htree::Mesh::new(&[[0.0; 3]; 3]), &options)?;
    /// # Ok::<(), htree::Error>(())
    /// ```
    unsafe fn release(&self, memory: *mut u8, bytes: usize);
}

/// Panics that C must not see. A worker thread cannot tell which query it works for, so a panic is
/// counted, and goes on in every query that saw the count change: no wrong hits pass for right.
#[derive(Default)]
struct Panics {
    count: AtomicUsize,
    /// Whether one waits to go on; until it does, nothing of the caller's is called.
    waits: AtomicBool,
    first: Mutex<Option<Box<dyn Any + Send>>>,
}

impl Panics {
    fn catch<R>(&self, call: impl FnOnce() -> R) -> Option<R> {
        if self.waits.load(Ordering::Acquire) {
            self.count.fetch_add(1, Ordering::Release);
            return None;
        }
        match catch_unwind(AssertUnwindSafe(call)) {
            Ok(result) => Some(result),
            Err(panic) => {
                {
                    let mut first = self.lock();
                    first.get_or_insert(panic);
                    self.waits.store(true, Ordering::Release);
                }
                self.count.fetch_add(1, Ordering::Release);
                None
            }
        }
    }

    fn take(&self) -> Option<Box<dyn Any + Send>> {
        let mut first = self.lock();
        self.waits.store(false, Ordering::Release);
        first.take()
    }

    fn lock(&self) -> MutexGuard<'_, Option<Box<dyn Any + Send>>> {
        self.first.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The hooks of one tree, which C knows by address. Those of its options live until after
/// `htree_free`, objects until `htree_update` brings others.
pub(crate) struct Hooks {
    intersect: Option<Arc<dyn Intersect>>,
    tasks: Option<Arc<dyn Tasks>>,
    allocator: Option<Arc<dyn Allocator>>,
    panics: Arc<Panics>,
}

impl Hooks {
    pub(crate) fn new(
        tasks: Option<Arc<dyn Tasks>>,
        allocator: Option<Arc<dyn Allocator>>,
    ) -> Arc<Self> {
        Arc::new(Self { intersect: None, tasks, allocator, panics: Arc::default() })
    }

    /// The same hooks, and the objects of a mesh.
    pub(crate) fn with_objects(&self, intersect: Option<Arc<dyn Intersect>>) -> Arc<Self> {
        let (tasks, allocator) = (self.tasks.clone(), self.allocator.clone());
        Arc::new(Self { intersect, tasks, allocator, panics: Arc::clone(&self.panics) })
    }

    pub(crate) fn has_objects(&self) -> bool {
        self.intersect.is_some()
    }

    /// Whether code of the caller's runs in queries.
    pub(crate) fn run_in_queries(&self) -> bool {
        self.intersect.is_some() || self.tasks.is_some()
    }

    pub(crate) fn panic_count(&self) -> usize {
        self.panics.count.load(Ordering::Acquire)
    }

    /// Lets a panic go on that was caught since `panic_count` was `before`.
    pub(crate) fn resume_panic(&self, before: usize) {
        if self.panic_count() == before {
            return;
        }
        match self.panics.take() {
            Some(panic) => resume_unwind(panic),
            None => panic!("a hook or an object panicked in another query on this tree"),
        }
    }

    fn user(self: &Arc<Self>) -> *mut c_void {
        Arc::as_ptr(self) as *mut c_void
    }

    pub(crate) fn to_objects(self: &Arc<Self>, boxes: &[crate::Aabb]) -> sys::htree_objects {
        sys::htree_objects {
            boxes: boxes.as_ptr().cast(),
            count: boxes.len() as u64,
            intersect: Some(intersect_object),
            user: self.user(),
        }
    }

    pub(crate) fn to_tasks(self: &Arc<Self>) -> sys::htree_tasks {
        match self.tasks {
            Some(_) => sys::htree_tasks { run: Some(run_tasks), user: self.user() },
            None => sys::htree_tasks { run: None, user: null_mut() },
        }
    }

    pub(crate) fn to_allocator(self: &Arc<Self>) -> sys::htree_allocator {
        let (allocate, release): (Option<_>, Option<_>) = match self.allocator {
            Some(_) => (Some(allocate as _), Some(release as _)),
            None => (None, None),
        };
        sys::htree_allocator { allocate, release, user: self.user() }
    }
}

/// SAFETY (of every use): C hands back the `user` of `Hooks::user`, while the tree or its build lives.
unsafe fn hooks_of<'a>(user: *mut c_void) -> &'a Hooks {
    unsafe { &*user.cast::<Hooks>() }
}

unsafe extern "C" fn intersect_object(
    user: *mut c_void,
    object: u32,
    ray: *const sys::htree_ray,
    hit: *mut sys::htree_hit,
) -> i32 {
    let hooks = unsafe { hooks_of(user) };
    let ray = unsafe { &*ray.cast::<Ray>() };
    let intersect = || hooks.intersect.as_ref().and_then(|it| it.intersect(object, ray));
    match hooks.panics.catch(intersect).flatten() {
        Some(found) => {
            let hit = unsafe { &mut *hit };
            (hit.t, hit.u, hit.v) = (found.t, found.u, found.v);
            1
        }
        None => 0,
    }
}

/// The library's `data` may go to any thread: that is the contract of its task.
#[derive(Clone, Copy)]
struct TaskData(*mut c_void);
unsafe impl Send for TaskData {}
unsafe impl Sync for TaskData {}

impl TaskData {
    fn pointer(self) -> *mut c_void {
        self.0
    }
}

unsafe extern "C" fn run_tasks(
    user: *mut c_void,
    count: u32,
    task: sys::htree_task,
    data: *mut c_void,
) {
    let hooks = unsafe { hooks_of(user) };
    let (task, data) = (task.expect("C hands over a task"), TaskData(data));
    // Once each, whatever a trait object does: C relies on it.
    let claimed: Vec<_> = (0..count).map(|_| AtomicBool::new(false)).collect();
    let once = |index: u32| {
        let claim = claimed.get(index as usize);
        if claim.map_or(false, |claim| !claim.swap(true, Ordering::Relaxed)) {
            unsafe { task(data.pointer(), index) }
        }
    };
    hooks.panics.catch(|| hooks.tasks.as_ref().map(|tasks| tasks.run(count, &once)));
    (0..count).for_each(once);
}

unsafe extern "C" fn allocate(user: *mut c_void, bytes: u64, alignment: u64) -> *mut c_void {
    let hooks = unsafe { hooks_of(user) };
    let (bytes, alignment) = match (bytes.try_into(), alignment.try_into()) {
        (Ok(bytes), Ok(alignment)) => (bytes, alignment),
        _ => return null_mut(), // more than the address space
    };
    let call = || hooks.allocator.as_ref().map(|it| it.allocate(bytes, alignment));
    hooks.panics.catch(call).flatten().map_or(null_mut(), <*mut u8>::cast)
}

unsafe extern "C" fn release(user: *mut c_void, memory: *mut c_void, bytes: u64) {
    let hooks = unsafe { hooks_of(user) };
    if let Some(allocator) = &hooks.allocator {
        let call = || unsafe { allocator.release(memory.cast(), bytes as usize) };
        let _ = catch_unwind(AssertUnwindSafe(call));
    }
}

pub(crate) type Report<'r> = dyn FnMut(f64) -> ControlFlow<()> + 'r;

/// A closure that hears of progress, for one call; it also ends a query in which a hook panicked.
pub(crate) struct Progress<'h, 'r> {
    hooks: &'h Hooks,
    panics_before: usize,
    report: Option<&'r mut Report<'r>>,
    panic: Option<Box<dyn Any + Send>>,
}

impl<'h, 'r> Progress<'h, 'r> {
    pub(crate) fn new(hooks: &'h Hooks, report: Option<&'r mut Report<'r>>) -> Self {
        Self { hooks, panics_before: hooks.panic_count(), report, panic: None }
    }

    /// Valid until `self` moves.
    pub(crate) fn as_hook(&mut self) -> sys::htree_progress {
        if self.report.is_none() && !self.hooks.run_in_queries() {
            return sys::htree_progress { report: None, user: null_mut() };
        }
        let user: *mut Self = self;
        sys::htree_progress { report: Some(report_progress), user: user.cast() }
    }

    /// After the call: lets go on what panicked in it.
    pub(crate) fn finish(self) {
        if let Some(panic) = self.panic {
            resume_unwind(panic);
        }
        self.hooks.resume_panic(self.panics_before);
    }
}

unsafe extern "C" fn report_progress(user: *mut c_void, fraction: f64) -> i32 {
    // SAFETY: on the thread that made the call, whose `Progress` nobody else uses meanwhile.
    let progress = unsafe { &mut *user.cast::<Progress>() };
    if progress.hooks.panic_count() != progress.panics_before {
        return 1;
    }
    let report = match progress.report.as_mut() {
        Some(report) => report,
        None => return 0,
    };
    match catch_unwind(AssertUnwindSafe(|| report(fraction))) {
        Ok(flow) => i32::from(flow.is_break()),
        Err(panic) => {
            progress.panic = Some(panic);
            1
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_that_waits_is_seen_by_every_query_beside_it() {
        let hooks = Hooks::new(None, None);
        let text = |before| {
            let panic = catch_unwind(AssertUnwindSafe(|| hooks.resume_panic(before))).err()?;
            panic.downcast_ref::<&str>().map(|text| text.to_string())
        };
        let guilty = hooks.panic_count();
        hooks.panics.catch(|| panic!("first"));
        let beside = hooks.panic_count(); // a query that starts while the panic waits
        assert!(hooks.panics.catch(|| ()).is_none());
        assert_eq!(text(guilty).as_deref(), Some("first"));
        assert!(text(beside).expect("misses for hits").contains("another query"));
        let after = hooks.panic_count();
        assert!(hooks.panics.catch(|| ()).is_some());
        assert_eq!(text(after), None);
    }
}
