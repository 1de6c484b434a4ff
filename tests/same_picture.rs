//! The picture is the same, bit for bit, for any number of threads, any instruction set and any structure.
//!
//! One animated scene with a mirror, glass, soft shadows, instances of several kinds and a mesh whose vertices move; three frames of it, since
//! structures that are updated in place differ from new ones only after the first.

#[path = "common/skip.rs"]
mod skip;

use glam::{DVec3, Vec3};
use openrt::Context;
use openrt::api::{
    Config, Level, Mode, Motion, Name, ObjectParameter, PixelFormat, PixelKind, Primitive, Strategy, TopLevelKind,
};
use skip::skipped;
use std::process::Command;

const SIZE: u32 = 64;
const FRAMES: u32 = 3;
/// Squares along each side of the moving mesh.
const SHEET: u32 = 24;

/// FNV-1a, 64 bit.
fn hash(bytes: &[u8], start: u64) -> u64 {
    bytes.iter().fold(start, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01B3))
}

/// A shader of a built-in class; `values` are its parameters.
fn shader(cx: &mut Context, class: &str, values: &[(&str, &[f32])]) -> Name {
    cx.gen_new_shader_class(class).expect("a built-in class");
    let name = cx.gen_new_shader().expect("a class is bound");
    for (parameter, value) in values {
        let handle = cx.parameter_handle(parameter).expect("a parameter of the class");
        cx.parameter_f(handle, value).expect("a value of its type");
    }
    name
}

/// A unit sphere with normals, of the shader that is bound.
fn sphere(cx: &mut Context, name: Name) {
    let (slices, stacks) = (20, 10);
    cx.new_object(name, Mode::Compile, Motion::Affine).expect("a new object");
    for stack in 0..stacks {
        cx.begin(Primitive::QuadStrip).expect("begin");
        for slice in 0..=slices {
            for edge in [stack + 1, stack] {
                let up = std::f32::consts::PI * (edge as f32 / stacks as f32 - 0.5);
                let turn = std::f32::consts::TAU * (slice % slices) as f32 / slices as f32;
                let p = Vec3::new(up.cos() * turn.cos(), up.sin(), -up.cos() * turn.sin());
                cx.normal(p).expect("a normal");
                cx.vertex3(p.x, p.y, p.z).expect("a vertex");
            }
        }
        cx.end().expect("end");
    }
    cx.end_object().expect("end of the object");
}

fn sheet_positions(frame: u32) -> Vec<Vec3> {
    let time = frame as f32;
    let side = SHEET + 1;
    (0..side * side)
        .map(|k| {
            let (x, z) = ((k % side) as f32 / 3.0 - 4.0, (k / side) as f32 / 3.0 - 4.0);
            Vec3::new(x, 0.3 * (x * 1.3 + time).sin() * (z + 0.7 * time).cos() - 1.2, z)
        })
        .collect()
}

fn sheet(cx: &mut Context, name: Name) {
    let positions = sheet_positions(0);
    cx.new_object(name, Mode::Compile, Motion::Unstructured).expect("a new object");
    cx.begin(Primitive::Triangles).expect("begin");
    // Every triangle has vertices of its own, so vertex numbers are those of `sheet_corners`.
    for corner in sheet_corners() {
        let p = positions[corner as usize];
        cx.vertex3(p.x, p.y, p.z).expect("a vertex");
    }
    cx.end().expect("end");
    cx.end_object().expect("end of the object");
}

fn sheet_corners() -> Vec<u32> {
    let side = SHEET + 1;
    let squares = (0..SHEET).flat_map(|j| (0..SHEET).map(move |i| j * side + i));
    squares.flat_map(|a| [a, a + side, a + 1, a + 1, a + side, a + side + 1]).collect()
}

fn check(result: openrt::api::Result<()>) {
    result.expect("a valid call");
}

/// A floor of tiles, each a static object of its own. Returns the first name.
fn tiles(cx: &mut Context, side: u32) -> Name {
    let first = cx.gen_objects((side * side) as i32).expect("names");
    for tile in 0..side * side {
        cx.new_object(first + tile, Mode::Compile, Motion::Static).expect("a new object");
        cx.begin(Primitive::Quads).expect("begin");
        for (x, z) in [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)] {
            cx.vertex3(x, 0.1 * x * z, z).expect("a vertex");
        }
        cx.end().expect("end");
        cx.end_object().expect("end of the object");
    }
    first
}

/// Hash of all pixels of all frames: colour, depth and what was hit. `strategy` is forced on every object.
fn frames_hash(mut cx: Context, strategy: Option<Strategy>, top: TopLevelKind) -> u64 {
    check(cx.top_level(top));
    check(cx.set_frame_size(SIZE, SIZE));
    check(cx.samples_per_pixel(2));
    check(cx.perspective(50.0, 1.0, 0.1, 100.0));
    check(cx.look_at(DVec3::new(0.0, 2.5, 7.0), DVec3::new(0.0, 0.3, 0.0), DVec3::Y));
    let lamp = shader(&mut cx, "area", &[("position", &[3.0, 6.0, 3.0]), ("color", &[0.7, 0.7, 0.6])]);
    let sun = shader(&mut cx, "directional", &[("direction", &[-1.0, -1.0, -0.5]), ("color", &[0.4, 0.4, 0.5])]);
    let sky = shader(&mut cx, "gradient", &[]);
    check(cx.use_light(lamp));
    check(cx.use_light(sun));
    check(cx.use_environment_shader(sky));

    let objects = cx.gen_objects(4).expect("names");
    for (i, (class, values)) in [
        ("mirror", &[][..]),
        ("glass", &[("ior", &[1.5][..])]),
        ("phong", &[("diffuse", &[0.7, 0.2, 0.1][..]), ("reflection", &[0.3, 0.3, 0.3])]),
    ]
    .into_iter()
    .enumerate()
    {
        shader(&mut cx, class, values);
        sphere(&mut cx, objects + i as u32);
    }
    shader(&mut cx, "phong", &[("diffuse", &[0.3, 0.5, 0.3]), ("reflection", &[0.2, 0.2, 0.2])]);
    let water = objects + 3;
    sheet(&mut cx, water);
    if let Some(strategy) = strategy {
        for object in objects..objects + 4 {
            check(cx.object_parameter(object, ObjectParameter::Strategy(strategy)));
        }
    }

    let side = 5;
    let floor = tiles(&mut cx, side);

    let mut sum = 0xCBF2_9CE4_8422_2325;
    for frame in 0..FRAMES {
        let positions = sheet_positions(frame);
        let moved: Vec<Vec3> = sheet_corners().into_iter().map(|corner| positions[corner as usize]).collect();
        check(cx.update_vertices(water, 0, &moved));
        check(cx.instantiate_object(water));
        for tile in 0..side * side {
            check(cx.push_matrix());
            check(cx.translate(DVec3::new(f64::from(tile % side) - 2.5, -0.9, f64::from(tile / side) - 2.5)));
            check(cx.rotate(20.0, DVec3::new(1.0, 0.5, 0.2)));
            // The last frame moves one of them.
            check(cx.scale(DVec3::splat(if tile == 7 && frame == 2 { 0.5 } else { 0.9 })));
            check(cx.instantiate_object(floor + tile));
            check(cx.pop_matrix());
        }
        for i in 0..9 {
            check(cx.push_matrix());
            check(cx.rotate(f64::from(40 * i + 7 * frame), DVec3::new(0.1, 1.0, 0.0)));
            check(cx.translate(DVec3::new(2.6, 0.2, 0.0)));
            check(cx.scale(DVec3::new(0.6, 0.8, 0.6)));
            check(cx.instantiate_object(objects + i % 3));
            check(cx.pop_matrix());
        }
        cx.render().expect("a frame");
        for kind in [
            PixelKind::Color(PixelFormat::Rgba32F),
            PixelKind::Depth,
            PixelKind::Normal,
            PixelKind::ObjectId,
            PixelKind::InstanceId,
        ] {
            let mut bytes = vec![0; (SIZE * SIZE) as usize * kind.bytes_per_pixel()];
            check(cx.read_pixels(0, 0, SIZE, SIZE, kind, 0, &mut bytes));
            sum = hash(&bytes, sum);
            assert!(bytes.iter().any(|&b| b != bytes[0]), "{kind:?} of frame {frame} shows something");
        }
    }
    sum
}

fn context(threads: usize, level: Level) -> Context {
    let mut config = Config::with_threads(threads);
    config.simd = Some(level);
    Context::with_config(config).expect("a context")
}

#[test]
fn threads_instruction_sets_and_structures_give_the_same_picture() {
    let expected = frames_hash(context(1, Level::Scalar), Some(Strategy::Sah), TopLevelKind::Bsp);
    let mut faults = Vec::new();
    for level in Level::ALL {
        if level > Level::strongest() {
            skipped(format_args!("the picture with {}, this processor lacks it", level.name()));
            continue;
        }
        for threads in [1, 2, 3, 7] {
            for strategy in [None].into_iter().chain(Strategy::ALL.map(Some)) {
                let top = TopLevelKind::ALL[threads % 2];
                if frames_hash(context(threads, level), strategy, top) != expected {
                    let strategy = strategy.map_or("auto", Strategy::name);
                    faults.push(format!("{} × {threads} threads × {strategy} below {top:?}", level.name()));
                }
            }
        }
    }
    assert!(faults.is_empty(), "another picture than scalar × 1 thread × sah: {}", faults.join(", "));
}

/// Prints the hash of the default context; the test below runs it in processes of other environments.
#[test]
fn hash_in_this_environment() {
    println!("picture {:016x}", frames_hash(Context::new().expect("a context"), None, TopLevelKind::Auto));
}

#[test]
fn environment_variables_do_not_change_the_picture() {
    let hash_with = |variables: &[(&str, &str)]| {
        let program = std::env::current_exe().expect("the test knows its path");
        let mut command = Command::new(program);
        command.args(["--exact", "hash_in_this_environment", "--nocapture"]);
        command.env_remove("OPENRT_NUM_THREADS").env_remove("OPENRT_SIMD").env_remove("OPENRT_ACCEL");
        command.env_remove("OPENRT_TOPLEVEL").env_remove("OPENRT_MERGE");
        let output = command.envs(variables.iter().copied()).output().expect("the test can run itself");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        // The runner may print on the same line, before the hash.
        let hash = text.split("picture ").nth(1).and_then(|rest| rest.get(..16)).map(str::to_owned);
        hash.unwrap_or_else(|| panic!("{variables:?}: no hash in {text}{}", String::from_utf8_lossy(&output.stderr)))
    };
    let expected = hash_with(&[]);
    for [threads, simd, accel, top, merge] in [
        ["3", "scalar", "bsp", "bsp", "never"],
        ["1", "avx2", "auto", "bsp", "now"],
        ["7", "sse", "refit", "bvh", "now"],
        ["2", "avx512", "sah", "bvh", "now"],
        ["2", "avx2", "fast_build", "bsp", "never"],
    ] {
        let variables = [
            ("OPENRT_NUM_THREADS", threads),
            ("OPENRT_SIMD", simd),
            ("OPENRT_ACCEL", accel),
            ("OPENRT_TOPLEVEL", top),
            ("OPENRT_MERGE", merge),
        ];
        assert_eq!(hash_with(&variables), expected, "{variables:?}");
    }
}
