//! What rays cost in structures over planes, counted and not timed: nodes or cells visited and blocks of triangles tested, beside those of the SAH tree.
//!
//! The walks here are plain ones over what the structures show of themselves, by the rules of the kernels (`trace/traverse_bvh`, `traverse_bsp`,
//! `traverse_grid`), which need no counters then. They find the kernels' hits, so they go where the kernels go.

#[allow(dead_code, reason = "shared with others")]
#[path = "common/meshes.rs"]
mod meshes;
#[allow(dead_code, reason = "shared with others")]
#[path = "common/places.rs"]
mod places;
#[path = "common/random.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod random;

use glam::{Affine3A, Vec3};
use openrt::accel::{BspTree, Bvh, ChildRef, Grid, Lattice, Structure, TwoLevel};
use openrt::scene::{Command, Instance, Mesh, Motion, Scene, Strategy};
use openrt::simd::Level;
use openrt::threads::Pool;
use openrt::trace::{PreparedRay, Ray, SLAB_PAD, Tracer, triangle};
use random::Random;

/// What rays have cost, added up.
#[derive(Clone, Copy, Debug, Default)]
struct Count {
    /// Nodes, or cells of a grid.
    nodes: u64,
    /// Of four triangles.
    blocks: u64,
}

impl Count {
    /// In units of a node or block.
    fn cost(&self) -> f64 {
        (self.nodes + self.blocks) as f64
    }
}

/// The closest distance so far.
fn test(ray: &PreparedRay, corners: [Vec3; 3], best: &mut f32) {
    if let Some(hit) = triangle::intersect(ray, corners) {
        *best = best.min(hit.t);
    }
}

/// Children still to be visited, nearest last, with the intervals of the ray in them.
type Pending = Vec<(f32, f32, ChildRef)>;

/// Puts children that were met on the stack, nearest last.
fn push(pending: &mut Pending, mut met: Pending) {
    met.sort_by(|a, b| b.0.total_cmp(&a.0));
    pending.append(&mut met);
}

fn through_bvh(bvh: &Bvh, ray: &PreparedRay, count: &mut Count) -> f32 {
    let mut best = ray.tmax;
    let mut pending: Pending = vec![(0.0, 0.0, ChildRef::ROOT)];
    while let Some((enter, _, child)) = pending.pop() {
        if enter > best * SLAB_PAD {
            continue;
        }
        if child.is_leaf() {
            for block in &bvh.blocks()[child.blocks()] {
                count.blocks += 1;
                (0..4).for_each(|lane| test(ray, block.corners(lane), &mut best));
            }
            continue;
        }
        count.nodes += 1;
        let node = &bvh.nodes()[child.index()];
        let met = (0..node.child_count()).filter_map(|lane| {
            let (enter, exit) = ray.slab(&node.child_bounds(lane));
            let enter = enter.max(ray.tmin);
            (enter <= exit.min(best) * SLAB_PAD).then_some((enter, exit, node.children[lane]))
        });
        push(&mut pending, met.collect());
    }
    best
}

fn through_bsp(bsp: &BspTree, whole: (f32, f32), ray: &PreparedRay, count: &mut Count) -> f32 {
    const PAD: f32 = 1.0 + 20.0 * f32::EPSILON;
    let mut best = ray.tmax;
    let mut pending: Pending = vec![(whole.0.max(ray.tmin), whole.1.min(best), ChildRef::ROOT)];
    while let Some((enter, exit, child)) = pending.pop() {
        if !(enter <= exit * PAD) || enter > best * PAD {
            continue;
        }
        if child.is_leaf() {
            for refs in &bsp.blocks()[child.blocks()] {
                count.blocks += 1;
                refs.iter().for_each(|r| test(ray, bsp.triangles()[*r as usize].corners(), &mut best));
            }
            continue;
        }
        count.nodes += 1;
        let node = &bsp.nodes()[child.index()];
        let mut met = Vec::new();
        for (lane, child) in node.children().iter().enumerate().filter(|(_, child)| !child.is_empty()) {
            let (mut enter, mut exit, mut plane) = (enter, exit, 0);
            for level in 0..3 {
                let above = lane >> (2 - level) & 1;
                if let Some((axis, at)) = node.plane(plane) {
                    let distance = (at - ray.org[axis]) * ray.inv_dir[axis];
                    if (ray.inv_dir[axis] < 0.0) == (above == 1) {
                        exit = exit.min(distance);
                    } else {
                        enter = enter.max(distance);
                    }
                }
                plane = 2 * plane + 1 + above;
            }
            if enter <= exit.min(best) * PAD {
                met.push((enter, exit, *child));
            }
        }
        push(&mut pending, met);
    }
    best
}

/// The cells of a lattice that a ray is in from `enter` to `exit`, with where it enters them, in order.
fn cells(lattice: &Lattice, ray: &PreparedRay, enter: f32, exit: f32) -> Vec<(f32, usize)> {
    let (numbers, step) = (lattice.cells(), lattice.step());
    let mut met = vec![(enter, exit, [0usize; 3])];
    for axis in 0..3 {
        let distance = |i: usize| {
            let plane = lattice.bounds().lo[axis] + step[axis] * i as f32;
            (plane - ray.org[axis]) * ray.inv_dir[axis]
        };
        let mut next = Vec::new();
        for (enter, exit, cell) in met {
            for i in 0..numbers[axis] {
                let low = if i == 0 { None } else { Some(distance(i)) };
                let high = if i + 1 == numbers[axis] { None } else { Some(distance(i + 1)) };
                let (near, far) = if ray.inv_dir[axis] < 0.0 { (high, low) } else { (low, high) };
                let enter = near.map_or(enter, |near| near.max(enter));
                let exit = far.map_or(exit, |far| (far * SLAB_PAD).min(exit));
                if enter <= exit {
                    let mut cell = cell;
                    cell[axis] = i;
                    next.push((enter, exit, cell));
                }
            }
        }
        met = next;
    }
    let mut met: Vec<_> = met.into_iter().map(|(enter, _, cell)| (enter, lattice.number(cell))).collect();
    met.sort_by(|a, b| a.0.total_cmp(&b.0));
    met
}

fn through_grid(grid: &Grid, ray: &PreparedRay, count: &mut Count) -> f32 {
    let mut best = ray.tmax;
    let Some(top) = grid.top() else { return best };
    let interval = |lattice: &Lattice, best: f32| {
        let (enter, exit) = ray.slab(lattice.bounds());
        (enter.max(ray.tmin), exit.min(best) * SLAB_PAD)
    };
    let (enter, exit) = interval(top, best);
    for (enter, number) in cells(top, ray, enter, exit) {
        if enter > best {
            break;
        }
        count.nodes += 1;
        let cell = &grid.cells()[number];
        let (enter, exit) = interval(&cell.lattice, best);
        for (enter, below) in cells(&cell.lattice, ray, enter, exit) {
            if enter > best {
                break;
            }
            count.nodes += u64::from(cell.lattice.count() > 1);
            let refs = grid.refs(cell, below);
            count.blocks += refs.len().div_ceil(4) as u64;
            refs.iter().for_each(|r| test(ray, grid.triangles()[*r as usize].corners(), &mut best));
        }
    }
    best
}

/// SAH tree, careful BSP, fast BSP, grid.
const STRUCTURES: [(&str, Strategy, Motion); 4] = [
    ("SAH", Strategy::Sah, Motion::Affine),
    ("BSP", Strategy::Bsp, Motion::Affine),
    ("fast BSP", Strategy::Bsp, Motion::Unstructured),
    ("grid", Strategy::Grid, Motion::Unstructured),
];

fn worlds(mesh: &Mesh, pool: &Pool) -> Vec<TwoLevel> {
    let build = |&(_, strategy, motion): &(&str, Strategy, Motion)| {
        let mut scene = Scene::default();
        scene.apply(Command::DefineObject { name: 1, mesh: mesh.clone(), motion });
        let mut world = TwoLevel::new(Level::detect());
        world.force_strategy(Some(strategy));
        pool.install(|| world.update(&scene, &[Instance::new(1, Affine3A::IDENTITY)]));
        world
    };
    STRUCTURES.iter().map(build).collect()
}

/// What the rays cost in each structure. They find what the kernels find.
fn counts(worlds: &[TwoLevel], rays: &[Ray]) -> Vec<Count> {
    let mut counts = vec![Count::default(); worlds.len()];
    for ((structure, ..), (world, count)) in STRUCTURES.iter().zip(worlds.iter().zip(&mut counts)) {
        let tracer = Tracer::new(world);
        for ray in rays {
            let prepared = PreparedRay::new(ray).expect("a usable ray");
            let best = match world.objects()[0].structure() {
                Structure::Bvh(bvh) => through_bvh(bvh, &prepared, count),
                Structure::Bsp(bsp) => {
                    through_bsp(bsp.tree().expect("memory"), prepared.slab(&bsp.bounds()), &prepared, count)
                }
                Structure::Grid(grid) => through_grid(grid, &prepared, count),
                other => panic!("{other:?} was not asked for"),
            };
            let hit = tracer.intersect(ray).map_or(ray.tmax, |hit| hit.t);
            assert_eq!(best.to_bits(), hit.to_bits(), "{structure}, {ray:?}: the walk finds {best}, the kernel {hit}");
        }
    }
    counts
}

fn scaled(mut mesh: Mesh, scale: f32) -> Mesh {
    mesh.positions.iter_mut().for_each(|p| *p *= scale);
    mesh
}

fn meshes_to_count() -> Vec<(&'static str, Mesh)> {
    let cloth = places::sheet(120, 120, |u, v| {
        Vec3::new(u, 0.2 * (9.0 * u).sin() * (7.0 * v).cos() + 0.02 * (60.0 * u + 30.0 * v).sin(), v)
    });
    vec![
        ("hall", places::hall()),
        ("stadium", places::stadium()),
        ("machine", places::machine(&mut Random::new(33))),
        ("hair", places::hair(&mut Random::new(34))),
        ("statue", places::statue()),
        ("cloth", cloth),
    ]
}

fn rays_towards(mesh: &Mesh, random: &mut Random, count: usize) -> Vec<Ray> {
    let (lo, hi) =
        mesh.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
    let (center, half) = ((lo + hi) * 0.5, (hi - lo) * 0.5);
    (0..count)
        .map(|i| {
            let org = center + random.vec() * half * if i % 2 == 0 { 2.0 } else { 1.0 };
            let way = center + random.vec() * half - org;
            // About 1 long, so that the kernels take the ray as it is.
            Ray::new(org, way / way.abs().max_element())
        })
        .collect()
}

#[test]
fn rays_cost_a_small_multiple_of_what_they_do_in_the_sah_tree() {
    let pool = Pool::new(Some(2)).expect("two threads");
    let most = [1.0, 3.0, 4.0, 8.0];
    for (name, mesh) in meshes_to_count() {
        for scale in [1.0, 1e-20, 1e15] {
            let mesh = scaled(mesh.clone(), scale);
            let rays = rays_towards(&mesh, &mut Random::new(5), 400);
            let counts = counts(&worlds(&mesh, &pool), &rays);
            let mut text = format!("{name} of size {scale:e}:");
            for ((structure, ..), count) in STRUCTURES.iter().zip(&counts) {
                let per = |n: u64| n as f64 / rays.len() as f64;
                text += &format!(" {structure} {:.1} + {:.1},", per(count.nodes), per(count.blocks));
            }
            println!("{text}");
            for ((structure, ..), (count, most)) in STRUCTURES.iter().zip(counts.iter().zip(most)) {
                assert!(
                    count.cost() <= most * counts[0].cost(),
                    "{structure} takes more than {most} times SAH: {text}"
                );
            }
        }
    }
}

#[test]
fn short_rays_cost_alike_wherever_they_are() {
    let pool = Pool::new(Some(2)).expect("two threads");
    const SLABS: usize = 10;
    for (name, mesh) in meshes_to_count() {
        let worlds = worlds(&mesh, &pool);
        let bounds = worlds[0].objects()[0].bounds();
        for axis in 0..3 {
            for slab in 0..SLABS {
                let mut random = Random::new(5);
                let rays: Vec<Ray> = (0..200)
                    .map(|_| {
                        let mut at = Vec3::new(random.unit(), random.unit(), random.unit());
                        at[axis] = (slab as f32 + at[axis]) / SLABS as f32;
                        let dir = random.vec() * bounds.extent() * 0.02;
                        Ray { tmax: 1.0, ..Ray::new(bounds.lo + at * bounds.extent(), dir) }
                    })
                    .collect();
                let counts = counts(&worlds, &rays);
                for ((structure, ..), count) in STRUCTURES.iter().zip(&counts) {
                    let (here, sah) = (count.cost() / 200.0, counts[0].cost() / 200.0);
                    assert!(
                        here <= 4.0 * sah + 6.0,
                        "{name}, slab {slab} on axis {axis}: {here:.1} in the {structure}, {sah:.1} in the SAH tree"
                    );
                }
            }
        }
    }
}
