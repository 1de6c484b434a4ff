//! Which structure lies over the instances.

/// The structure over the instances of a frame. All give the same picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TopLevelKind {
    /// The one that was measured to be faster.
    #[default]
    Auto,
    /// The BSP of Wald03 §4.5.
    Bsp,
    /// The 8-wide bounding volume hierarchy.
    Bvh,
}

impl TopLevelKind {
    /// Every kind that can be forced, for tests that loop over all of them.
    pub const ALL: [TopLevelKind; 2] = [TopLevelKind::Bsp, TopLevelKind::Bvh];

    /// Lower-case name, as accepted by the environment variable `OPENRT_TOPLEVEL`.
    pub fn name(self) -> &'static str {
        match self {
            TopLevelKind::Auto => "auto",
            TopLevelKind::Bsp => "bsp",
            TopLevelKind::Bvh => "bvh",
        }
    }

    /// Inverse of [`TopLevelKind::name`].
    pub fn from_name(name: &str) -> Option<Self> {
        [TopLevelKind::Auto].into_iter().chain(Self::ALL).find(|kind| kind.name() == name)
    }
}
