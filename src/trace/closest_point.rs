//! The point of a scene that is nearest to a given one.
//!
//! A tree of boxes is searched depth first, the nearer child first; what lies farther than the best point so far is left out. Distances are those of the world,
//! in f64: boxes are in object space, where a distance `d` is at least `d / |N|` in the world, `N` being `object_from_world` and `|N|` a bound of its
//! spectral norm (the largest row sum of `NᵀN`, Gershgorin), exact for rotations and uniform scales. Triangles are transformed.

use super::{Hit, Scope};
use crate::accel::{ChildRef, InstanceRecord, ProximityTree, Space, TopLevel, WorldView};
use crate::scene::{Mesh, Name};
use glam::{Affine3A, DAffine3, DMat3, DVec3, Vec3};

/// The nearest point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    pub position: Vec3,
    /// From the point asked about.
    pub distance: f32,
    /// Barycentric weights of the triangle's second and third corner.
    pub u: f32,
    pub v: f32,
    /// Triangle number within the object.
    pub primitive: u32,
    pub object: Name,
    /// Number of the instance within the frame; 0 for a question about one object.
    pub instance: u32,
}

/// Room for [`bounds`] to be wrong by.
const ROUNDING: f64 = 1.0 - 1e-9;

/// What was found, and where it lies.
struct Search {
    point: DVec3,
    square: f64,
    order: u64,
    best: Option<(DVec3, [f64; 2], Name)>,
}

impl Search {
    fn new(point: Vec3, max_distance: f32) -> Option<Self> {
        // Written so that NaN fails.
        if !(point.is_finite() && max_distance >= 0.0) {
            return None;
        }
        let square = f64::from(max_distance) * f64::from(max_distance);
        Some(Self { point: point.as_dvec3(), square, order: u64::MAX, best: None })
    }

    fn answer(self) -> Option<ClosestPoint> {
        let (position, [u, v], object) = self.best?;
        let (instance, prim) = ((self.order >> 32) as u32, self.order as u32);
        let distance = self.square.sqrt() as f32;
        Some(ClosestPoint {
            position: position.as_vec3(),
            distance,
            u: u as f32,
            v: v as f32,
            primitive: prim,
            object,
            instance,
        })
    }

    /// The triangles of one object under a matrix.
    fn object(&mut self, tree: &ProximityTree, mesh: &Mesh, placed: &Placement, object: Name, instance: u32) {
        let nodes = tree.nodes();
        if nodes.is_empty() {
            return;
        }
        let local = placed.object_from_world.transform_point3(self.point);
        let bound = |node: usize| box_distance(&nodes[node].bounds, local) * placed.shrink;
        let mut stack = [(0u32, 0.0f64); ProximityTree::MAX_DEPTH + 1];
        let mut depth = 1;
        stack[0] = (0, bound(0));
        while depth > 0 {
            depth -= 1;
            let (node, least) = stack[depth];
            if least > self.square {
                continue;
            }
            let node = &nodes[node as usize];
            if node.count == 0 {
                let (a, b) = (node.first, node.first + 1);
                let (to_a, to_b) = (bound(a as usize), bound(b as usize));
                let [far, near] = if to_a < to_b { [(b, to_b), (a, to_a)] } else { [(a, to_a), (b, to_b)] };
                (stack[depth], stack[depth + 1]) = (far, near);
                depth += 2;
                continue;
            }
            for &prim in &tree.prims()[node.first as usize..][..node.count as usize] {
                let corners = mesh.corners(prim).map(|c| placed.world_from_object.transform_point3(c.as_dvec3()));
                let (position, weights) = nearest_on_triangle(corners, self.point);
                let (square, order) = (position.distance_squared(self.point), Hit::order(instance, prim));
                if square < self.square || square == self.square && (self.best.is_none() || order < self.order) {
                    (self.square, self.order, self.best) = (square, order, Some((position, weights, object)));
                }
            }
        }
    }
}

/// A matrix and what it does to distances.
struct Placement {
    world_from_object: DAffine3,
    object_from_world: DAffine3,
    /// Squares of distances in object space are at least as large in the world when multiplied by this.
    shrink: f64,
}

impl Placement {
    fn new(world_from_object: &Affine3A) -> Self {
        let column = |v: glam::Vec3A| Vec3::from(v).as_dvec3();
        let m = &world_from_object.matrix3;
        let matrix3 = DMat3::from_cols(column(m.x_axis), column(m.y_axis), column(m.z_axis));
        let world_from_object = DAffine3 { matrix3, translation: column(world_from_object.translation) };
        let object_from_world = world_from_object.inverse();
        let gram = object_from_world.matrix3.transpose() * object_from_world.matrix3;
        let row = |i: usize| gram.row(i).abs().element_sum();
        let norm = row(0).max(row(1)).max(row(2));
        // Of a matrix without inverse nothing is known: then nothing is left out.
        let shrink = if norm.is_finite() && object_from_world.is_finite() { ROUNDING / norm } else { 0.0 };
        Self {
            world_from_object,
            object_from_world: if shrink > 0.0 { object_from_world } else { DAffine3::IDENTITY },
            shrink,
        }
    }
}

/// In the whole scene, among the instances that `scope` sees.
pub fn in_scene<'m>(
    scope: Scope<'_>,
    point: Vec3,
    max_distance: f32,
    mesh_of: impl Fn(Name) -> Option<&'m Mesh>,
) -> Option<ClosestPoint> {
    let mut search = Search::new(point, max_distance)?;
    let world = scope.view();
    let records = world.instances();
    let visit = |search: &mut Search, record: &InstanceRecord| {
        let Some(mesh) = mesh_of(record.object).filter(|_| scope.sees(record)) else { return };
        let tree = world.objects()[record.slot as usize].proximity(mesh);
        search.object(tree, mesh, &Placement::new(&record.world_from_object), record.object, record.instance);
    };
    // Those in the merged tree have no boxes of their own.
    let merged = |search: &mut Search| {
        for record in records.iter().filter(|r| matches!(r.space, Space::Merged) && r.instance != Hit::NO_INSTANCE) {
            visit(search, record);
        }
    };
    if world.merged().is_some() {
        merged(&mut search);
    }
    let others = |index: &u32| !matches!(records[*index as usize].space, Space::Merged);
    for &index in world.outliers() {
        visit(&mut search, &records[index as usize]);
    }
    let TopLevel::Bvh(tree) = world.top_level() else {
        for &index in world.boxed().iter().filter(|index| others(index)) {
            if box_distance(&world.boxes()[index as usize], search.point) <= search.square {
                visit(&mut search, &records[index as usize]);
            }
        }
        return search.answer();
    };
    if tree.is_empty() {
        return search.answer();
    }
    // Up to seven siblings wait on each level.
    let mut stack = [(ChildRef::ROOT, 0.0f64); 7 * crate::accel::MAX_DEPTH + 8];
    let mut depth = 1;
    while depth > 0 {
        depth -= 1;
        let (child, least) = stack[depth];
        if least > search.square {
            continue;
        }
        if child.is_leaf() {
            for index in tree.refs()[child.blocks()].iter().filter(|index| others(index)) {
                if box_distance(&world.boxes()[*index as usize], search.point) <= search.square {
                    visit(&mut search, &records[*index as usize]);
                }
            }
            continue;
        }
        let node = &tree.nodes()[child.index()];
        let first = depth;
        for lane in 0..node.child_count() {
            stack[depth] = (node.children[lane], box_distance(&node.child_bounds(lane), search.point));
            depth += 1;
        }
        stack[first..depth].sort_by(|a, b| b.1.total_cmp(&a.1));
    }
    search.answer()
}

/// On one object, in its own space.
pub fn on_mesh(view: &WorldView, object: Name, mesh: &Mesh, point: Vec3, max_distance: f32) -> Option<ClosestPoint> {
    let mut search = Search::new(point, max_distance)?;
    let record =
        view.instances().iter().find(|record| record.object == object && record.instance != Hit::NO_INSTANCE)?;
    let tree = view.objects()[record.slot as usize].proximity(mesh);
    search.object(tree, mesh, &Placement::new(&Affine3A::IDENTITY), object, 0);
    search.answer()
}

/// The square of the distance to a box.
fn box_distance(bounds: &crate::accel::Aabb, point: DVec3) -> f64 {
    let (lo, hi) = (bounds.lo.as_dvec3(), bounds.hi.as_dvec3());
    let outside = (lo - point).max(point - hi).max(DVec3::ZERO);
    outside.length_squared()
}

/// The point of a triangle nearest to `p`, and the weights of the second and third corner: by the region of the plane in which the projection of `p` lies
/// (Ericson, *Real-Time Collision Detection*, 2005, §5.1.5). Triangles without area are edges or points.
fn nearest_on_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> (DVec3, [f64; 2]) {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(ac);
    let area = normal.length_squared();
    if area > 0.0 {
        let v = ap.cross(ac).dot(normal) / area;
        let w = ab.cross(ap).dot(normal) / area;
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            return (a + ab * v + ac * w, [v, w]);
        }
    }
    let along = |from: DVec3, edge: DVec3| {
        let length = edge.length_squared();
        if length > 0.0 { ((p - from).dot(edge) / length).clamp(0.0, 1.0) } else { 0.0 }
    };
    let (s, t, r) = (along(a, ab), along(a, ac), along(b, c - b));
    let edges = [(a + ab * s, [s, 0.0]), (a + ac * t, [0.0, t]), (b + (c - b) * r, [1.0 - r, r])];
    let nearer = |x: (DVec3, [f64; 2]), y: (DVec3, [f64; 2])| {
        if y.0.distance_squared(p) < x.0.distance_squared(p) { y } else { x }
    };
    nearer(nearer(edges[0], edges[1]), edges[2])
}
