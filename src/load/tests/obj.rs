//! OBJ and MTL.

use super::kit::{Folder, data, load, read_text, warned};
use crate::api::Wrap;
use crate::load::{Mesh, SceneFile};
use glam::{Vec2, Vec3};

#[test]
fn obj_with_materials() {
    let scene = load(&data("box.obj"), 0.0).unwrap();
    assert_eq!(scene.warnings, [""; 0]);
    assert_eq!((scene.counts.mesh_triangles, scene.objects.len(), scene.textures.len()), (3, 1, 1));
    let painted = scene.materials.iter().find(|m| m.name == "painted").unwrap();
    assert_eq!((painted.shininess, painted.texture, painted.reflection), (40.0, Some(0), Vec3::splat(0.5)));
    let pane = scene.materials.iter().find(|m| m.name == "pane").unwrap();
    assert_eq!((pane.transmission, pane.ior), (0.75, 1.5));
    let mesh = &scene.objects[0].mesh;
    let used: Vec<&str> = mesh.materials.iter().map(|&m| scene.materials[m as usize].name.as_str()).collect();
    assert_eq!(used, ["painted", "painted", "pane"]);
}

/// Every statement that is understood.
pub const EVERYTHING: &str = "\
# every statement
mtllib all.mtl
o thing
v 0 0 0 1 0 0
v 1 0 0
v 1 1 0 1
v 0 1 0 0 0 1
v .5 .2 0
vt 0 0
vt 1 0 0
vt 1 \\
 1
vn 0 0 1
vn nan nan nan
g a b
s 1
usemtl first
f 1/1/1 2/2/1 3/3/1
f -1 -2 -3 -4
s off
usemtl the second
fo 1//1 2//2 3
f 1 2 5 3 4
l 1 2
";

/// Every statement of a library that is understood.
pub const EVERY_MATERIAL: &str = "\
newmtl first
Ka 1 1 1
Kd .5 .5
Ks 1
Ke xyz .1 .2 .3
Ns 10
Ni 1.5
Tf .9 .9 .9
d -halo .5
illum 7
map_Kd -s 2 2 2 -o .5 -clamp on -mm 0 1 checks.ppm
map_Ka checks.ppm
map_bump -bm .5 checks.ppm
sharpness 60
newmtl the second
Kd spectral a.rfl
Tr .25
Pr .5
";

/// A quad in the plane z = 0 from (0, 0) to (1, 1).
const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn mesh(scene: &SceneFile) -> &Mesh {
    &scene.objects[0].mesh
}

/// The material of the first triangle.
fn used(scene: &SceneFile) -> &crate::load::Material {
    &scene.materials[mesh(scene).materials[0] as usize]
}

fn area(mesh: &Mesh) -> f32 {
    let sides = mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize]));
    sides.map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
}

fn obj(text: impl AsRef<[u8]>) -> SceneFile {
    read_text("a.obj", text).unwrap()
}

/// A triangle with material `m` of this library.
fn with_library(library: impl AsRef<[u8]>) -> SceneFile {
    let folder = Folder::new();
    folder.write("a.mtl", library);
    folder.write("checks.ppm", "P3 1 1 255 1 2 3");
    load(&folder.write("a.obj", format!("mtllib a.mtl\n{QUAD}usemtl m\nf 1 2 3\n")), 0.0).unwrap()
}

#[test]
fn bytes_of_any_kind_are_read() {
    let faces = "f 1 2 3 4\n";
    for (name, text) in [
        ("UTF-8 mark", format!("\u{feff}{QUAD}{faces}").into_bytes()),
        ("CR LF", format!("{QUAD}{faces}").replace('\n', "\r\n").into_bytes()),
        ("CR", format!("{QUAD}{faces}").replace('\n', "\r").into_bytes()),
        ("Latin-1", [b"# caf\xe9\n", QUAD.as_bytes(), b"g m\xf6bel\n", faces.as_bytes()].concat()),
        ("comments", format!("{QUAD}{faces}").replace('\n', " # text\n").into_bytes()),
        (
            "continuation",
            format!("{QUAD}{faces}").replace("1 0\n", "1 \\\n 0\n").replace("f 1 2", "f 1\\\n2").into_bytes(),
        ),
        ("tabs and padding", format!("\t{QUAD}{faces}\0\0").replace(' ', "\t").into_bytes()),
        ("fo", format!("{QUAD}fo 1 2 3 4\n").into_bytes()),
        ("negative", format!("{QUAD}f -4 -3 -2 -1\n").into_bytes()),
        ("vertices behind", format!("{faces}{QUAD}").into_bytes()),
        ("slashes", format!("{QUAD}f 1/ 2// 3 4/\n").into_bytes()),
        ("closed", format!("{QUAD}f 1 2 3 4 1\n").into_bytes()),
        ("weights", QUAD.replace(" 0\n", " 0 1\n").into_bytes().into_iter().chain(faces.bytes()).collect()),
    ] {
        let scene = obj(text);
        assert_eq!(scene.warnings, [""; 0], "{name}");
        assert_eq!(scene.bounds(0.0), Some((Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0))), "{name}");
        assert_eq!((mesh(&scene).triangles.len(), area(mesh(&scene))), (2, 1.0), "{name}");
    }
}

#[test]
fn what_is_no_text_is_refused() {
    let refused = |text: &[u8]| read_text("a.obj", text).unwrap_err().to_string();
    assert!(refused(b"\xff\xfev\0 \x000\0").contains("a.obj: the file is UTF-16"));
    assert!(refused(b"\x7fELF\x02\x01\0\0\0\x10 stuff").contains("binary"));
    assert!(refused(b"").contains("the file is empty"));
    assert!(refused(b"\n \n").contains("the file is empty"));
    assert!(refused(b"hello world\nit is not a mesh\n").contains("no line of the file is OBJ"));
    warned(&obj("# nothing\nv 0 0 0\n"), "a.obj: the file has no faces");
}

/// A line that is not understood costs that line.
#[test]
fn broken_lines_cost_themselves() {
    let check = |line: &str, words: &str, triangles: usize| {
        let scene = obj(format!("{QUAD}f 1 2 3\n{line}\nf 1 3 4\n"));
        assert_eq!(mesh(&scene).triangles.len(), triangles, "{line}");
        warned(&scene, &format!("a.obj:6: {words}"));
    };
    check("f 1 2 9", "face with corner `9`, but there are 4 vertices", 2);
    check("f 1 2 x", "face with corner `x`, which is not a number", 2);
    check("f 1 2 0", "face with corner `0`, but there are 4 vertices", 2);
    check("f 1 2 -5", "face with corner `-5`", 2);
    check("f 1/2 2 3", "face with corner `1/2`, but there are 0 texture coordinates", 2);
    check("f 1 2", "a face needs 3 corners, this one has 2", 2);
    check("f 1/1/1/1 2 3", "face with corner `1/1/1/1`, which has more than three numbers", 2);
    check("v 1 2 zero", "this is not a vertex", 2);
    check("vn 1 2", "this is not a normal", 2);
    check("vt x", "this is not a texture coordinate", 2);
    check("hello", "unknown statement `hello` is left out", 2);
    check("p 1 2", "points (`p`) are left out", 2);
    check("l 1 2", "lines (`l`) are left out", 2);
    check("curv2 1", "free-form curves and surfaces are left out: `curv2`", 2);
    check("usemtl gone", "material `gone` is not defined", 2);
    check("usemtl b\nusemtl a\nusemtl b", "materials `a`, `b` are not defined", 2);
    // A broken vertex keeps its number, and takes its faces along.
    let scene = obj("v 0 0 0\nv 1 zero 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    assert_eq!((mesh(&scene).triangles.len(), area(mesh(&scene))), (1, 0.5));
    assert!(scene.warnings[1].contains("a.obj:5: this face uses a vertex whose line"), "{:?}", scene.warnings);
    // Each kind is told once, and what is told is bounded.
    warned(
        &obj(format!("{QUAD}f 1 2 3\n{}", "p 1\n".repeat(1000))),
        "a.obj:6: points (`p`) are left out (and 999 times more)",
    );
    assert!(obj(format!("{QUAD}f 1 2 3\n{}", "v x\n".repeat(1000))).warnings.len() < 30);
}

#[test]
fn vertices_have_colours() {
    let scene = obj("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
    assert_eq!(mesh(&scene).colors.iter().map(|c| c.truncate()).collect::<Vec<_>>(), [Vec3::X, Vec3::Y, Vec3::Z]);
    let some = obj("v 0 0 0\nv 1 0 0 0 1 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(mesh(&some).colors.iter().map(|c| c.truncate()).collect::<Vec<_>>(), [Vec3::ONE, Vec3::Y, Vec3::ONE]);
    let bytes = obj("v 0 0 0 255 0 0 255\nv 1 0 0 0 255 0 255\nv 0 1 0 0 0 51 255\nf 1 2 3\n");
    assert_eq!(mesh(&bytes).colors[2].truncate(), Vec3::Z * 0.2);
    assert_eq!((some.warnings.len(), bytes.warnings.len()), (0, 0));
}

#[test]
fn polygons_may_be_concave() {
    // An arrow head, from every corner on.
    let corners = ["0 0", "2 1", "0 2", "0.5 1"];
    for turn in 0..4 {
        let vertices: String = (0..4).map(|i| format!("v {} 0\n", corners[(i + turn) % 4])).collect();
        let scene = obj(format!("{vertices}f 1 2 3 4\n"));
        assert_eq!(area(mesh(&scene)), 1.5, "from corner {turn}");
    }
}

#[test]
fn normals_come_from_the_file_or_its_smoothing_groups() {
    let given = obj(format!("{QUAD}vn 0 0 2\nf 1//1 2//-1 3//1 4\n"));
    assert_eq!(mesh(&given).normals, [Vec3::Z * 2.0, Vec3::Z * 2.0, Vec3::Z * 2.0, Vec3::ZERO]);
    assert!(mesh(&obj(format!("{QUAD}f 1 2 3 4\n"))).normals.is_empty(), "flat");
    // Two squares at a right angle, joined along x.
    let bent = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\n";
    let smooth = obj(format!("{bent}s 1\nf 1 2 3 4\nf 2 1 5 6\n"));
    let at = |scene: &SceneFile, p: Vec3| -> Vec<Vec3> {
        let m = mesh(scene);
        (0..m.positions.len()).filter(|&i| m.positions[i] == p).map(|i| m.normals[i]).collect()
    };
    assert_eq!(at(&smooth, Vec3::ZERO), [Vec3::new(0.0, 1.0, 1.0).normalize()]);
    let edge = obj(format!("{bent}s 1\nf 1 2 3 4\ns 2\nf 2 1 5 6\ns off\nf 3 4 6\n"));
    assert_eq!(at(&edge, Vec3::ZERO), [Vec3::Z, Vec3::Y]);
    assert_eq!(at(&edge, Vec3::Y), [Vec3::Z, Vec3::ZERO]);
}

#[test]
fn libraries_are_found_however_they_are_named() {
    let red = "newmtl red\nKd 1 0 0\n";
    let blue = "newmtl blue\nKd 0 0 1\n";
    let check = |files: &[(&str, &str)], lines: &str| {
        let folder = Folder::new();
        for (name, text) in files {
            folder.write(name, text);
        }
        let text = format!("{QUAD}usemtl red\nf 1 2 3\nusemtl blue\nf 1 3 4\n");
        let before = load(&folder.write("a.obj", format!("{lines}\n{text}")), 0.0).unwrap();
        let behind = load(&folder.write("a.obj", format!("{text}{lines}\n")), 0.0).unwrap();
        for scene in [before, behind] {
            assert_eq!(scene.warnings, [""; 0], "{lines}");
            let colors = mesh(&scene).materials.iter().map(|&m| scene.materials[m as usize].diffuse);
            assert_eq!(colors.collect::<Vec<_>>(), [Vec3::X, Vec3::Z], "{lines}");
        }
    };
    let both = format!("{red}{blue}");
    check(&[("a.mtl", red), ("b.mtl", blue)], "mtllib a.mtl b.mtl");
    check(&[("a.mtl", red), ("b.mtl", blue)], "mtllib a.mtl\nmtllib b.mtl # and a comment");
    check(&[("my colours.mtl", red), ("b.mtl", blue)], "mtllib my colours.mtl b.mtl");
    check(&[("my colours.mtl", red), ("b.mtl", blue)], "mtllib my\\ colours.mtl b.mtl");
    check(&[("my colours.mtl", red), ("b.mtl", blue)], "mtllib \"my colours.mtl\" \"b.mtl\"");
    check(&[("Colours.MTL", &both)], "mtllib colours.mtl");
    check(&[("materials/All.mtl", &both)], "mtllib Materials\\all.mtl");
    check(&[("a.mtl", &format!("\u{feff}{both}").replace('\n', "\r\n"))], "mtllib a.mtl");
    check(&[("a#1.mtl", &both)], "mtllib a#1.mtl");
    check(&[("a.mtl", &both.replace("red", "red # the first").replace("blue", "blue  "))], "mtllib a.mtl");
    // Names of two words are names.
    let folder = Folder::new();
    folder.write("a.mtl", "newmtl Material #1\nKd 1 0 0\nnewmtl Material #2\nKd 0 0 1\n");
    let text = format!("mtllib a.mtl\n{QUAD}usemtl Material #2\nf 1 2 3\n");
    assert_eq!(used(&load(&folder.write("a.obj", text), 0.0).unwrap()).diffuse, Vec3::Z);
    // What is missing is named, and the mesh is there without it.
    let lost = load(&folder.write("lost.obj", format!("#\nmtllib lost.mtl a.mtl\n{QUAD}f 1 2 3\n")), 0.0).unwrap();
    warned(&lost, "lost.obj:2: material library `lost.mtl` does not exist");
    assert_eq!(lost.materials.len(), 3);
}

#[test]
fn no_material_is_the_default() {
    for text in ["usemtl\nf 1 2 3\n", "f 1 2 3\n", "usemtl \t \nf 1 2 3\n"] {
        let scene = obj(format!("{QUAD}{text}"));
        assert_eq!((scene.warnings.len(), mesh(&scene).materials[0]), (0, 0), "{text:?}");
    }
}

#[test]
fn colours_are_short_or_of_other_spaces() {
    assert_eq!(used(&with_library("newmtl m\nKd 0.5\n")).diffuse, Vec3::splat(0.5));
    assert_eq!(used(&with_library("newmtl m\nKd 0.5 0.25\n")).diffuse, Vec3::new(0.5, 0.25, 0.5));
    assert_eq!(used(&with_library("NEWMTL m\nKD 0 1 0 # green\n")).diffuse, Vec3::Y);
    // White of the standard illuminant D65.
    let white = used(&with_library("newmtl m\nKd xyz 0.9505 1.0 1.089\n")).diffuse;
    assert!((white - Vec3::ONE).length() < 1e-3, "{white}");
    let spectrum = with_library("newmtl m\nKd spectral ident.rfl 0.5\nKs 1 1 1\n");
    warned(&spectrum, "a.mtl:2: colours given as spectra are left out");
    let broken = with_library("newmtl m\nKd 1 x 1\nKs 0.25\nNs 10\n");
    warned(&broken, "a.mtl:2: this is not a colour: `Kd 1 x 1`");
    assert_eq!(used(&broken).specular, Vec3::splat(0.25), "the other lines count");
    warned(
        &with_library("newmtl m\nKd 1 1 1\nsparkle 3\nsparkle 4\n"),
        "a.mtl:3: unknown statement `sparkle` is left out (and once more)",
    );
}

#[test]
fn opacity_has_three_spellings() {
    for (line, transmission) in
        [("d 0.25", 0.75), ("Tr 0.75", 0.75), ("d 0.25\nTr 0.1", 0.75), ("Tr 0.1\nd 0.25", 0.75), ("", 0.0)]
    {
        let scene = with_library(format!("newmtl m\nKd 1 1 1\n{line}\n"));
        assert_eq!((used(&scene).transmission, scene.warnings.len()), (transmission, 0), "{line}");
    }
    let halo = with_library("newmtl m\nd -halo 0.5\n");
    assert_eq!(used(&halo).transmission, 0.5);
    warned(&halo, "a.mtl:2: `d -halo` is taken as `d`");
}

#[test]
fn highlights_need_an_exponent() {
    let highlight = |text: &str| {
        let scene = with_library(format!("newmtl m\nKd .2 .2 .2\nKs .8 .8 .8\n{text}"));
        (used(&scene).specular.x, used(&scene).shininess, used(&scene).reflection.x)
    };
    assert_eq!(highlight("Ns 0\n"), (0.0, 0.0, 0.0));
    assert_eq!(highlight("Ns -5\nillum 2\n"), (0.0, 0.0, 0.0));
    assert_eq!(highlight("Ns 0\nillum 3\n"), (0.0, 0.0, 0.8), "a mirror stays one");
    assert_eq!(highlight("Ns 20\n"), (0.8, 20.0, 0.0));
    assert_eq!(highlight("Ns 20\nillum 1\n"), (0.0, 20.0, 0.0));
    assert_eq!(highlight(""), (0.8, 30.0, 0.0));
}

#[test]
fn textures_lie_as_their_options_say() {
    let folder = Folder::new();
    folder.write("Checks.PPM", "P3 1 1 255 1 2 3");
    folder.write(
        "a.mtl",
        "newmtl m\nKd 0 0 0\nmap_Kd -s 2 3 1 -o 0.5 0 -clamp on checks.ppm # it\nnewmtl n\nmap_Kd checks.ppm\n",
    );
    let text = format!("mtllib a.mtl\n{QUAD}vt 1 1\nusemtl m\nf 1/1 2/1 3/1\nusemtl n\nf 1/1 3/1 4/1\n");
    let scene = load(&folder.write("a.obj", text), 0.0).unwrap();
    assert_eq!(scene.warnings, [""; 0]);
    let clamped = |t: usize| scene.textures[t].wrap == [Wrap::ClampToEdge; 2];
    assert_eq!((scene.textures.len(), clamped(0), clamped(1)), (2, true, false));
    assert_eq!(used(&scene).diffuse, Vec3::ONE, "black next to a texture is not meant");
    let m = mesh(&scene);
    assert!(m.tex_coords[..3].iter().all(|t| *t == Vec2::new(2.5, 3.0)), "{:?}", m.tex_coords);
    assert!(m.tex_coords[3..].iter().all(|t| *t == Vec2::ONE), "{:?}", m.tex_coords);
    let told = with_library("newmtl m\nmap_Kd -mm 0.2 2 checks.ppm\n");
    warned(&told, "a.mtl:2: option `-mm` of `map_Kd` is left out");
    assert!(used(&told).texture.is_some());
    let maps =
        with_library("newmtl m\nmap_Ka checks.ppm\nmap_Kd checks.ppm\nmap_Bump -bm 0.2 checks.ppm\nmap_d other.png\n");
    assert_eq!(maps.warnings.len(), 2, "{:?}", maps.warnings);
    assert!(maps.warnings[0].contains("a.mtl:4: `map_bump` is left out"), "{:?}", maps.warnings);
    warned(&with_library("newmtl m\nmap_Kd\n"), "a.mtl:2: `map_Kd` names no file");
    warned(&with_library("newmtl m\nmap_Kd lost.png\n"), "a.mtl:2: texture `lost.png` does not exist");
    assert!(used(&with_library("newmtl m\nmap_Kd C:\\work\\checks.ppm\n")).texture.is_some(), "found by its last part");
}
