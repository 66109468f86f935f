// SPDX-License-Identifier: MIT
use htree_sys as sys;
use std::borrow::Cow;
use std::ffi::CStr;
use std::fmt;

/// `Result` with this crate's [`Error`].
///
/// ```
/// fn kind(name: &str) -> htree::Result<htree::Kind> {
///     name.parse()
/// }
/// assert!(kind("kd").is_ok());
/// ```
pub type Result<T> = std::result::Result<T, Error>;

/// Which way a call failed: the statuses of the C library.
///
/// ```
/// use htree::ErrorKind;
/// assert_eq!(ErrorKind::Geometry.code(), 4);
/// assert_eq!(ErrorKind::Geometry.name(), "bad geometry");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(i32)]
pub enum ErrorKind {
    /// A size, a flag or a number that the call does not take.
    Argument = sys::HTREE_ERROR_ARGUMENT,
    /// Out of memory.
    Memory = sys::HTREE_ERROR_MEMORY,
    /// More objects than the structure can address.
    Limit = sys::HTREE_ERROR_LIMIT,
    /// An index beyond the vertices; with [`Options::strict`](crate::Options::strict) bad numbers too.
    Geometry = sys::HTREE_ERROR_GEOMETRY,
    /// The progress closure asked to stop.
    Cancelled = sys::HTREE_ERROR_CANCELLED,
    /// The library lacks the kind that was asked for, or is of another version.
    Unsupported = sys::HTREE_ERROR_UNSUPPORTED,
    /// [`Tree::check`](crate::Tree::check) found a broken tree.
    Corrupt = sys::HTREE_ERROR_CORRUPT,
    /// No OpenCL here, or no device of that name.
    NoDevice = sys::HTREE_ERROR_NO_DEVICE,
    /// A call to the device failed.
    Device = sys::HTREE_ERROR_DEVICE,
    /// The device is gone, with all that was on it.
    DeviceLost = sys::HTREE_ERROR_DEVICE_LOST,
    /// The device's compiler refused a kernel, or it is wrong.
    Kernel = sys::HTREE_ERROR_KERNEL,
    /// A status that this crate does not know.
    Unknown = -1,
}

const KINDS: [ErrorKind; 11] = [
    ErrorKind::Argument,
    ErrorKind::Memory,
    ErrorKind::Limit,
    ErrorKind::Geometry,
    ErrorKind::Cancelled,
    ErrorKind::Unsupported,
    ErrorKind::Corrupt,
    ErrorKind::NoDevice,
    ErrorKind::Device,
    ErrorKind::DeviceLost,
    ErrorKind::Kernel,
];

impl ErrorKind {
    /// The number of the status in `htree.h`; -1 for [`ErrorKind::Unknown`].
    ///
    /// ```
    /// assert_eq!(htree::ErrorKind::Argument.code(), 1);
    /// ```
    pub const fn code(self) -> i32 {
        self as i32
    }

    /// The kind of that number.
    ///
    /// ```
    /// assert_eq!(htree::ErrorKind::from_code(5), htree::ErrorKind::Cancelled);
    /// assert_eq!(htree::ErrorKind::from_code(99), htree::ErrorKind::Unknown);
    /// ```
    pub fn from_code(code: i32) -> Self {
        let known = KINDS.iter().find(|kind| kind.code() == code);
        known.copied().unwrap_or(Self::Unknown)
    }

    /// What the C library calls it, for logs.
    ///
    /// ```
    /// assert_eq!(htree::ErrorKind::Memory.name(), "out of memory");
    /// ```
    pub fn name(self) -> &'static str {
        // SAFETY: the name is static and never NULL.
        let name = unsafe { CStr::from_ptr(sys::htree_status_name(self.code())) };
        name.to_str().unwrap_or("unknown status")
    }
}

impl fmt::Display for ErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Why a call failed: a kind, and a sentence for people.
///
/// ```
/// use htree::{ErrorKind, Mesh, Options, Tree};
/// let mesh = Mesh::new(&[[0.0; 3]; 3]).indices(&[[0, 1, 7]]);
/// let error = Tree::build(&mesh, &Options::default()).unwrap_err();
/// assert_eq!(error.kind(), ErrorKind::Geometry);
/// assert_eq!(error.to_string(), "bad geometry: triangle 0 refers to vertex 7 of 3");
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    kind: ErrorKind,
    code: i32,
    text: Cow<'static, str>,
}

impl Error {
    pub(crate) fn new(kind: ErrorKind, text: impl Into<Cow<'static, str>>) -> Self {
        let (code, text) = (kind.code(), text.into());
        Self { kind, code, text }
    }

    /// `Ok` or the last failure of this thread, right after the C call that returned `status`.
    pub(crate) fn check(status: sys::htree_status) -> Result<()> {
        if status == sys::HTREE_OK {
            return Ok(());
        }
        // SAFETY: never NULL, and valid until this thread's next failing call.
        let text = unsafe { CStr::from_ptr(sys::htree_error_text()) };
        Err(Self {
            kind: ErrorKind::from_code(status),
            code: status,
            text: Cow::Owned(text.to_string_lossy().into_owned()),
        })
    }

    /// Which way the call failed.
    ///
    /// ```
    /// let error = "cube".parse::<htree::Kind>().unwrap_err();
    /// assert_eq!(error.kind(), htree::ErrorKind::Argument);
    /// ```
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    /// The number of the status, also of one that this crate does not know.
    ///
    /// ```
    /// assert_eq!("cube".parse::<htree::Kind>().unwrap_err().code(), 1);
    /// ```
    pub fn code(&self) -> i32 {
        self.code
    }

    /// The sentence alone, without the name of the kind.
    ///
    /// ```
    /// let error = "cube".parse::<htree::Kind>().unwrap_err();
    /// assert_eq!(error.text(), "no kind is called \"cube\"");
    /// ```
    pub fn text(&self) -> &str {
        &self.text
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind, self.text)
    }
}

impl std::error::Error for Error {}
