//! Which strategy an object gets, and what a change of it asks for.
//!
//! `Auto` goes by the motion flag, which is the application's promise, and by what the object has done so far:
//!
//! * `Static` and `Affine` objects are built once: SAH.
//! * `Unstructured` objects begin with SAH as well, since the first frame builds everything anyway. Those whose vertices
//!   move are refit with rotations ([`super::rotate`]; 17–21 ns per triangle in Embree, a Morton build 60–70, SAH 250–330), which costs what a refit and the look
//!   at its wear cost before, and keeps builds off where bodies fly through each other: spheres of S7 take a third of the update that builds took. Where
//!   the tree is [`WORN`] times as costly to trace as after its build all the same, it is built anew, fast, if rays lose more than that costs (`object_accel/worth.rs`). A motion that wears the tree in every frame is
//!   answered by builds alone. Objects that no ray met in the frame before wait for one ([`super::waiting`]); large ones that rays met are left to the rays
//!   where that pays ([`super::by_rays`]). Those that are defined anew every
//!   frame are built fast, from the second time on.

use crate::scene::{LazyShape, Motion, Object, Strategy, TopLevelKind};

/// SAH cost after refits over cost after the build beyond which `Auto` builds anew. Embree's refit-only series on the soup of spheres
/// lose 20 % of trace time per frame; at 1.5 a build amortises over two or three frames.
pub(super) const WORN: f64 = 1.5;

/// How an object's structure is made and brought up to date.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    /// The object BSP; `fast` for the threshold that grows with depth.
    Bsp { fast: bool },
    /// The grid of grids.
    Grid,
    /// The 8-wide tree with cut triangles, built anew when anything changes.
    SpatialSplits,
    /// The 8-wide tree: by Morton order if `fast`, else by binned SAH.
    Bvh { fast: bool, moved: Moved },
    /// The tree that rays bring up to date.
    Lazy(LazyShape),
    /// The visibility field.
    Field,
}

/// What happens to an 8-wide tree when vertices have moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Moved {
    Rebuild,
    Refit,
    /// Refit with rotations, then build anew, fast, if the tree is worn all the same.
    Rotate,
    /// The same, and left alone while no ray comes, or to rays where that pays.
    Auto,
}

impl Method {
    /// Whether trees for key frames take turns: where a tree is kept while vertices move, and not built anew.
    pub fn follows_keys(self) -> bool {
        matches!(self, Method::Lazy(_) | Method::Bvh { moved: Moved::Refit, .. })
    }

    /// Whether a structure can follow vertices that move, by a refit or segment by segment; else it is built anew.
    pub fn follows_moves(self) -> bool {
        !matches!(self, Method::Bsp { .. } | Method::Grid | Method::SpatialSplits | Method::Field)
            && !matches!(self, Method::Bvh { moved: Moved::Rebuild, .. })
    }

    /// Whether an object that no ray meets is left alone while its vertices move, and a large one to the rays, part by part.
    pub fn may_wait(self) -> bool {
        matches!(self, Method::Bvh { moved: Moved::Auto, .. })
    }

    /// The method for `object`; `redefined`: it has been built before, for another topology.
    /// `forced` (from `OPENRT_ACCEL`) beats the object's own choice.
    pub fn choose(object: &Object, forced: Option<Strategy>, redefined: bool) -> Method {
        let unstructured = object.motion == Motion::Unstructured;
        match forced.unwrap_or(object.strategy) {
            Strategy::Auto | Strategy::Sah if object.spatial_splits && object.motion == Motion::Static => {
                Method::SpatialSplits
            }
            Strategy::Bsp => Method::Bsp { fast: unstructured },
            Strategy::Grid => Method::Grid,
            Strategy::Sah => Method::Bvh { fast: false, moved: Moved::Rebuild },
            Strategy::FastBuild => Method::Bvh { fast: true, moved: Moved::Rebuild },
            Strategy::Refit => Method::Bvh { fast: false, moved: Moved::Refit },
            Strategy::Rotate => Method::Bvh { fast: false, moved: Moved::Rotate },
            Strategy::Lazy => Method::Lazy(object.lazy),
            Strategy::VisibilityField => Method::Field,
            Strategy::Auto if unstructured => Method::Bvh { fast: redefined, moved: Moved::Auto },
            Strategy::Auto => Method::Bvh { fast: false, moved: Moved::Rebuild },
        }
    }
}

/// The strategy forced on all objects by the environment variable `OPENRT_ACCEL`, for tests and measurements. Unknown
/// names and `auto` force nothing.
pub(super) fn forced_by_environment() -> Option<Strategy> {
    let name = std::env::var("OPENRT_ACCEL").ok()?;
    Strategy::from_name(name.trim()).filter(|s| *s != Strategy::Auto)
}

/// The same for the top level, by `OPENRT_TOPLEVEL`.
pub(super) fn forced_top_level() -> Option<TopLevelKind> {
    let name = std::env::var("OPENRT_TOPLEVEL").ok()?;
    TopLevelKind::from_name(name.trim()).filter(|k| *k != TopLevelKind::Auto)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_motion_flag_decides_unless_something_is_said() {
        let object = |motion, strategy| Object { motion, strategy, ..Object::default() };
        let sah = Method::Bvh { fast: false, moved: Moved::Rebuild };
        let affine = object(Motion::Affine, Strategy::Auto);
        assert_eq!(Method::choose(&affine, None, false), sah);
        assert_eq!(Method::choose(&affine, Some(Strategy::Bsp), false), Method::Bsp { fast: false });
        let moving = object(Motion::Unstructured, Strategy::Auto);
        for redefined in [false, true] {
            let expected = Method::Bvh { fast: redefined, moved: Moved::Auto };
            assert_eq!(Method::choose(&moving, None, redefined), expected);
        }
        let chosen = object(Motion::Unstructured, Strategy::Refit);
        assert_eq!(Method::choose(&chosen, None, true), Method::Bvh { fast: false, moved: Moved::Refit });
        assert_eq!(Method::choose(&chosen, Some(Strategy::Bsp), true), Method::Bsp { fast: true });
        assert_eq!(Method::choose(&chosen, Some(Strategy::Sah), true), sah);
    }

    #[test]
    fn triangles_are_cut_on_request_where_nothing_moves() {
        let object = |motion, strategy| Object { motion, strategy, spatial_splits: true, ..Object::default() };
        for strategy in [Strategy::Auto, Strategy::Sah] {
            let resting = object(Motion::Static, strategy);
            assert_eq!(Method::choose(&resting, None, true), Method::SpatialSplits);
            let plain = Object { spatial_splits: false, ..resting };
            assert_ne!(Method::choose(&plain, None, true), Method::SpatialSplits);
            for motion in [Motion::Affine, Motion::Unstructured] {
                assert_ne!(Method::choose(&object(motion, strategy), None, false), Method::SpatialSplits);
            }
        }
        let other = object(Motion::Static, Strategy::Refit);
        assert_eq!(Method::choose(&other, None, false), Method::Bvh { fast: false, moved: Moved::Refit });
    }
}
