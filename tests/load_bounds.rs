//! Readers of scene files take at most 64 bytes of memory for each byte of a file, whatever it says.
//!
//! An allocator counts; so this is a test program of its own, with one test.

#[path = "common/random.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod random;

use openrt::load::read;
use random::Random;
use std::alloc::{GlobalAlloc, Layout, System};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Bytes taken now, and most so far.
static TAKEN: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

struct Counting;

// SAFETY: all calls go to the system's allocator unchanged; the counters do not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the contract is the caller's.
        let place = unsafe { System.alloc(layout) };
        if !place.is_null() {
            let taken = TAKEN.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
            MOST.fetch_max(taken, Ordering::Relaxed);
        }
        place
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        TAKEN.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the contract is the caller's.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Bytes per byte of a file.
const MOST_PER_BYTE: usize = 64;
/// What any file may take, for paths and tables of the reader.
const ANYWAY: usize = 1 << 18;

struct Check {
    folder: PathBuf,
}

impl Check {
    /// Reads the file, with what it does to memory.
    fn read(&self, name: &str, text: impl AsRef<[u8]>) -> Result<openrt::load::SceneFile, String> {
        let text = text.as_ref();
        let path = self.folder.join(name);
        fs::write(&path, text).expect("the scratch folder can be written");
        let before = TAKEN.load(Ordering::Relaxed);
        MOST.store(before, Ordering::Relaxed);
        let result = read(&path);
        let taken = MOST.load(Ordering::Relaxed) - before;
        let allowed = text.len() * MOST_PER_BYTE + ANYWAY;
        let start = String::from_utf8_lossy(&text[..text.len().min(40)]).into_owned();
        if text.len() > 10_000 {
            println!("{name}: {taken} bytes for {} ({:.1} each)", text.len(), taken as f64 / text.len() as f64);
        }
        assert!(taken <= allowed, "{name} took {taken} bytes for {} of {start:?}", text.len());
        result.map_err(|e| e.to_string())
    }
}

#[test]
fn files_cost_memory_in_proportion() {
    let check = Check { folder: std::env::temp_dir().join(format!("openrt-bounds-{}", std::process::id())) };
    fs::create_dir_all(&check.folder).expect("a scratch folder");
    nff(&check);
    obj(&check);
    ply(&check);
    mutated(&check);
    let _ = fs::remove_dir_all(&check.folder);
}

fn nff(check: &Check) {
    let spheres = check.read("a.nff", "s 0 0 0 1\n".repeat(100_000)).expect("spheres");
    assert_eq!(spheres.counts.spheres, 100_000);
    check.read("cones.nff", "c 0 0 0 1 1 0 0 1\n".repeat(100_000)).expect("cones");
    // Every one of another kind, and every one of another material.
    let cones: String = (0..50_000).map(|i| format!("c 0 0 0 1 1 0 0 .{i}\n")).collect();
    check.read("kinds.nff", cones).expect("cones");
    let materials: String = (0..50_000).map(|i| format!("f 1 1 1 .{i} 0 0 0 0\ns 0 0 0 1\n")).collect();
    check.read("materials.nff", materials).expect("materials");
    check.read("polygons.nff", "p 3 0 0 0 1 0 0 0 1 0\n".repeat(50_000)).expect("polygons");
    check.read("triangles.nff", "pp 3 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1\n".repeat(50_000)).expect("triangles");
    check.read("keys.aff", "tpa 1 0 0 0 0 0 0 0 1 0 0 0 0 0 0 1 0 0 0 0\n".repeat(20_000)).expect("keys");
    check.read("nodes.aff", "x a { s 0 0 0 1 }\n".repeat(50_000)).expect("nodes");
    for (name, text) in [
        ("polygon.nff", "p 4000000000 0 0 0"),
        ("mesh.aff", "m vertices 4000000000 0 0 0"),
        ("keys.aff", "k a { transl 4000000000 0"),
        ("normals.aff", "m vertices 1 0 0 0 normals 4000000000"),
    ] {
        check.read(name, text).expect_err(name);
    }
    check.read("words.nff", (0..100_000).map(|i| format!("w{i}\n")).collect::<String>()).expect_err("random words");
}

fn obj(check: &Check) {
    check.read("points.obj", "v 0 0 0\n".repeat(100_000)).expect("vertices");
    check.read("colours.obj", "v 0 0 0 1 1 1\n".repeat(100_000)).expect("vertices with colours");
    check.read("faces.obj", format!("v 0 0 0\n{}", "f 1 1 1\n".repeat(100_000))).expect("faces");
    check
        .read("smooth.obj", format!("{}s 1\n{}", "v 0 0 0\n".repeat(99), "f 1 2 99\n".repeat(100_000)))
        .expect("faces");
    check.read("polygon.obj", format!("v 0 0 0\nv 1 0 0\nf {}\n", "1 2 ".repeat(100_000))).expect("a polygon");
    let own: String = (1..50_000).map(|i| format!("v {i} 0 0\nv 0 {i} 0\nf -1 -2 1\n")).collect();
    check.read("soup.obj", own).expect("triangles of their own");
    check
        .read("uses.obj", format!("v 0 0 0\n{}", (0..100_000).map(|i| format!("usemtl {i}\n")).collect::<String>()))
        .expect("names");
    check
        .read("words.obj", format!("v 0 0 0\n{}", (0..100_000).map(|i| format!("w{i}\n")).collect::<String>()))
        .expect("words");
    check.read("lines.obj", "\\\n".repeat(200_000)).expect_err("nothing but continuations");
    check.read("libraries.obj", format!("v 0 0 0\n{}", "mtllib a b c\n".repeat(2000))).expect("libraries");
    check.read("blanks.obj", format!("v 0 0 0\nmtllib {}", "a ".repeat(2000))).expect("libraries");
}

fn ply(check: &Check) {
    let header = |format: &str, vertices: &str, faces: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty uchar x\nproperty uchar y\nproperty uchar z\n\
             element face {faces}\nproperty list uchar uchar vertex_indices\nend_header\n"
        )
    };
    let binary = |vertices: usize, faces: &[u8], count: usize| {
        let mut bytes = header("binary_little_endian", &vertices.to_string(), &count.to_string()).into_bytes();
        bytes.extend((0..vertices * 3).map(|i| i as u8));
        bytes.extend(faces.iter().copied().cycle().take(faces.len() * count));
        bytes
    };
    check.read("points.ply", binary(100_000, &[], 0)).expect("vertices of three bytes");
    check.read("faces.ply", binary(3, &[3, 0, 1, 2], 100_000)).expect("faces of four bytes");
    check.read("empty.ply", binary(3, &[0], 100_000)).expect("faces of one byte");
    let many: Vec<u8> = std::iter::once(255).chain((0..255).map(|i| i % 3)).collect();
    check.read("polygons.ply", binary(3, &many, 1000)).expect("polygons");
    let text = format!("{}{}", header("ascii", "3", "100000"), "0 0 0 ".repeat(3)) + &"3 0 1 2 ".repeat(100_000);
    check.read("text.ply", text).expect("faces of text");
    let long = header("ascii", "3", "1").replace("uchar uchar", "uint uchar")
        + &"0 0 0 ".repeat(3)
        + "300000 "
        + &"0 1 2 ".repeat(100_000);
    check.read("long.ply", long).expect("a polygon of many corners");
    // What a count says is not believed.
    for (vertices, faces) in [("4000000000", "1"), ("3", "4000000000"), ("18446744073709551615", "1")] {
        for format in ["ascii", "binary_little_endian"] {
            check.read("count.ply", header(format, vertices, faces) + "0 0 0 0 0 0 0 0 0 ").expect_err("a count");
        }
    }
    let list = header("binary_little_endian", "0", "1").replace("uchar uchar", "uint uchar").into_bytes();
    check.read("list.ply", [list, vec![0xff; 4]].concat()).expect_err("a list of four billion");
    let none = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nelement odd 4000000000\nend_header\n";
    check.read("none.ply", none).expect("elements without properties take nothing");
}

/// Bytes of small files changed at random.
fn mutated(check: &Check) {
    let seed = Random::seed(14);
    println!("OPENRT_SEED={seed}");
    let mut random = Random::new(seed);
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    for name in ["every.aff", "box.obj", "quad.ply"] {
        let original = fs::read(data.join(name)).expect("a file of the tests");
        for _ in 0..500 {
            let mut bytes = original.clone();
            for _ in 0..=random.below(8) {
                let at = random.below(bytes.len());
                match random.below(3) {
                    0 => bytes[at] = random.below(256) as u8,
                    1 => bytes[at] = b"0123456789- \n"[random.below(13)],
                    // Another digit makes large counts of small ones.
                    _ => bytes.insert(at, b'9'),
                }
            }
            let _ = check.read(name, bytes);
        }
    }
}
