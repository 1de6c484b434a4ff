//! What one frame cost.

/// Times in seconds, of wall clock; counts of this frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameStats {
    /// Bringing the structures up to date, top level included.
    pub update_seconds: f64,
    /// Top level alone.
    pub top_level_seconds: f64,
    /// Tiles: rays and shading together.
    pub render_seconds: f64,
    pub total_seconds: f64,
    pub primary_rays: u64,
    pub shadow_rays: u64,
    /// Reflection, refraction and other rays sent by shaders.
    pub secondary_rays: u64,
    pub instances: u64,
    /// Triangles after instancing.
    pub triangles: u64,
    /// Object structures built anew or brought up to date in place.
    pub objects_built: u32,
    pub objects_refitted: u32,
    /// Objects whose vertices have moved and that no ray met in the frame before, so that their structures (strategy `Auto`) wait for one.
    pub objects_waiting: u32,
    /// Objects with the strategy `Auto` whose structures are left to the rays, as those with `Lazy` are, since the times of updates and rays say that it pays.
    pub objects_by_rays: u32,
    pub nodes_updated: u64,
    /// Subtrees of objects with the strategy `Lazy` or left to the rays, and objects that waited for a ray, that rays of this frame reached first, and so had updated; the
    /// nodes in them are not in `nodes_updated`. Likewise subfields of `VisibilityField`, and the references in them.
    pub subtrees_touched: u64,
    pub nodes_touched: u64,
    /// Static instances whose triangles have been merged into one structure.
    pub merged_instances: u32,
    /// Bytes held by acceleration structures.
    pub structure_bytes: u64,
    /// Share of the picture that shows all that the frame asks for, 0 to 1; the rest has only had its primary rays, for want
    /// of time.
    pub refined: f64,
    /// One pixel in each block of so many on a side was sampled.
    pub subsampling: u32,
    /// The frame was cancelled; some tiles keep what they showed before.
    pub cancelled: bool,
}
