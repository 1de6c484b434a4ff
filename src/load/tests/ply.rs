//! PLY.

use super::kit::{Folder, data, load, read_text, warned};
use crate::load::{Mesh, SceneFile};
use glam::{Vec2, Vec3};

#[test]
fn ply_with_colours() {
    let scene = load(&data("quad.ply"), 0.0).unwrap();
    let mesh = &scene.objects[0].mesh;
    assert_eq!((mesh.triangles.len(), mesh.positions.len(), mesh.colors.len()), (3, 5, 5));
    assert_eq!(mesh.colors[2].truncate(), Vec3::Z);
}

/// A binary file with every kind of property.
pub fn everything() -> Vec<u8> {
    let header = "ply\nformat binary_big_endian 1.0\ncomment TextureFile checks.ppm\nelement vertex 4\nproperty double x\n\
                  property float y\nproperty short z\nproperty char nx\nproperty uint8 ny\nproperty int nz\nproperty ushort quality\n\
                  element face 2\nproperty list uchar uint vertex_indices\nproperty list uchar float texcoord\n\
                  property uchar red\nproperty uchar green\nproperty uchar blue\n\
                  element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    let mut bytes = header.as_bytes().to_vec();
    for [x, y] in [[0_u8, 0], [1, 0], [1, 1], [0, 1]] {
        bytes.extend(f64::from(x).to_be_bytes());
        bytes.extend(f32::from(y).to_be_bytes());
        bytes.extend([0, 0, 0, 0, 0, 0, 0, 1, 0, 9]);
    }
    for corners in [&[0_u32, 1, 2][..], &[0, 1, 2, 3]] {
        bytes.push(corners.len() as u8);
        bytes.extend(corners.iter().flat_map(|c| c.to_be_bytes()));
        bytes.push(2 * corners.len() as u8);
        bytes.extend(corners.iter().flat_map(|&c| [c as f32, 0.5]).flat_map(f32::to_be_bytes));
        bytes.extend([255, 128, 0]);
    }
    bytes.extend([5_i32, 0, 1, 2, -1, 3].iter().flat_map(|v| v.to_be_bytes()));
    bytes
}

/// A header of vertices and faces with these properties.
fn header(vertices: usize, more: &str, faces: usize, of_faces: &str) -> String {
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    format!(
        "ply\nformat ascii 1.0\nelement vertex {vertices}\n{xyz}{more}element face {faces}\n\
         property list uchar int vertex_indices\n{of_faces}end_header\n"
    )
}

const TRIANGLE: &str = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

fn mesh(scene: &SceneFile) -> &Mesh {
    &scene.objects[0].mesh
}

fn ply(text: impl AsRef<[u8]>) -> SceneFile {
    read_text("a.ply", text).unwrap()
}

fn fault(text: impl AsRef<[u8]>, words: &str) {
    let error = read_text("a.ply", text).unwrap_err().to_string();
    assert!(error.contains(words), "{words}: {error}");
}

#[test]
fn faults_name_their_line() {
    let plain = header(3, "", 1, "");
    fault(
        format!("{plain}0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n"),
        "a.ply:11: a value of a vertex is expected, found `zero`",
    );
    fault(format!("{plain}0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"), "a.ply:13: a face names vertex 3, but there are 3");
    fault(format!("{plain}0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"), "a.ply:13: a face names vertex -1");
    fault(format!("{plain}0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n"), "a.ply:13: a face names vertex a number with a fraction");
    fault(format!("{plain}0 0 0\n1 0 0\n0 1 0\n"), "a.ply:13: the file ends where the length of a list is expected");
    fault(format!("{plain}0 0 0\n1 0 0\n0 1 0\n3 0"), "a.ply:13: a face cannot have 3 values");
    fault(format!("{plain}0 0 0\n1 0 0\n0 1 0\n200000000 0 1 2\n"), "a.ply:13: a face cannot have 200000000 values");
    fault(plain.replace("vertex 3", "vertex 4000000000"), "4000000000 elements `vertex` cannot be in");
    fault(plain.replace("vertex 3", "vertex -3"), "a.ply:3: a name and a count are expected");
    fault(plain.replace("float z", "quad z"), "a.ply:6: unknown property `quad z`");
    fault(plain.replace("ascii", "utf8"), "a.ply:2: unknown format `utf8 1.0`");
    fault(format!("{plain}{TRIANGLE}").replace("float z", "float w"), "the vertices have no x, y and z");
    fault(
        format!("{plain}{TRIANGLE}").replace("vertex_indices", "corners"),
        "the elements `face` have no vertex_indices",
    );
    fault(plain.replace("end_header", "end"), "a.ply:10: the header has no `end_header`");
    fault(plain.replace("end_header\n", ""), "a.ply:9: the header has no `end_header`");
    fault("plx\n", "a.ply:1: the file does not begin with `ply`");
    fault("", "a.ply:1: the header has no `end_header`");
    fault("ply\nproperty int x\n", "a.ply:2: a property without an element");
    fault("ply\nelement vertex 0\nend_header\n", "the header has no `format`");
    fault("ply\nformat ascii 1.0\nend_header\n", "the file has no element `vertex`");
}

/// The same triangle in both byte orders, and its faults by byte.
#[test]
fn binary_files_of_both_orders() {
    let text = header(3, "property uchar red\nproperty uchar green\nproperty uchar blue\n", 1, "");
    for big in [false, true] {
        let name = if big { "binary_big_endian" } else { "binary_little_endian" };
        let head = text.replace("ascii", name).into_bytes();
        let mut bytes = head.clone();
        for p in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0_f32]] {
            bytes.extend(p.iter().flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() }));
            // A byte 10 or 13 is a value like any other.
            bytes.extend([255, 10, 13]);
        }
        bytes.push(3);
        bytes.extend([0, 1, 2_i32].iter().flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() }));
        let scene = ply(&bytes);
        assert_eq!((mesh(&scene).triangles.as_slice(), scene.warnings.len()), ([[0, 1, 2]].as_slice(), 0));
        assert_eq!(mesh(&scene).positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
        assert_eq!(mesh(&scene).colors[0].truncate(), Vec3::new(255.0, 10.0, 13.0) / 255.0);
        // Line ends of the header are those of its first line.
        let returns: Vec<u8> = head
            .iter()
            .map(|&b| if b == b'\n' { b'\r' } else { b })
            .chain(bytes[head.len()..].iter().copied())
            .collect();
        assert_eq!(mesh(&ply(returns)).positions[1], Vec3::X);
        let at = bytes.len() - 4;
        fault(&bytes[..at], &format!("at byte {}: a face cannot have 3 values", head.len() + 46));
        bytes[at..].fill(9);
        fault(&bytes, &format!("at byte {}: a face names vertex", bytes.len()));
        bytes.extend([0; 9]);
        fault(&bytes, "a face names vertex");
    }
}

#[test]
fn every_kind_of_property() {
    let scene = textured_bytes(&everything());
    assert_eq!((mesh(&scene).triangles.len(), mesh(&scene).normals[0]), (4, Vec3::Z));
    warned(&scene, "left out: quality of vertices");
}

#[test]
fn elements_go_over_lines() {
    let spread = format!("{}0\n0 0 1\n0 0\n\n0 1 0 3\r\n0 1\r2", header(3, "", 1, ""));
    let scene = ply(spread);
    assert_eq!((mesh(&scene).positions[2], mesh(&scene).triangles.len(), scene.warnings.len()), (Vec3::Y, 1, 0));
    warned(&ply(format!("{}{TRIANGLE}7 7\n", header(3, "", 1, ""))), "what follows the last element is left out");
}

#[test]
fn faces_may_come_first() {
    let text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\nelement vertex 3\n\
                property float x\nproperty float y\nproperty float z\nend_header\n3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n";
    let scene = ply(text);
    assert_eq!((mesh(&scene).triangles.len(), mesh(&scene).positions[1], scene.warnings.len()), (1, Vec3::X, 0));
}

#[test]
fn odd_faces_are_left_out() {
    let scene = ply(format!("{}0 0 0\n1 0 0\n0 1 0\nnan 1 0\n3 0 1 2\n2 0 1\n0\n1 2\n3 0 1 3\n", header(4, "", 5, "")));
    assert_eq!(mesh(&scene).triangles, [[0, 1, 2]]);
    assert!(
        scene.warnings[0].contains("a.ply:15: a face with fewer than 3 corners is left out (and 2 times more)"),
        "{:?}",
        scene.warnings
    );
    assert!(scene.warnings[1].contains("a.ply:18: a face with a corner that is not finite"), "{:?}", scene.warnings);
    let normals = "property float nx\nproperty float ny\nproperty float nz\n";
    let scene = ply(format!("{}0 0 0 nan nan nan\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n", header(3, normals, 1, "")));
    assert_eq!(mesh(&scene).normals, [Vec3::ZERO, Vec3::Z, Vec3::Z]);
    warned(&ply(header(0, "", 0, "")), "the file has no faces; its 0 points are not drawn");
}

/// A scene beside a texture.
fn textured(text: String) -> SceneFile {
    textured_bytes(text.replacen("ascii 1.0\n", "ascii 1.0\ncomment TextureFile checks.ppm\n", 1).as_bytes())
}

fn textured_bytes(bytes: &[u8]) -> SceneFile {
    let folder = Folder::new();
    folder.write("checks.ppm", "P3 1 1 255 1 2 3");
    folder.write("other.ppm", "P3 1 1 255 1 2 3");
    load(&folder.write("a.ply", bytes), 0.0).unwrap()
}

#[test]
fn textures_with_coordinates_of_vertices_and_corners() {
    for names in ["s t", "u v", "texture_u texture_v"] {
        let (s, t) = names.split_once(' ').unwrap();
        let more = format!("property float {s}\nproperty float {t}\n");
        let scene = textured(format!("{}0 0 0 0 1\n1 0 0 1 0\n0 1 0 .5 .5\n3 0 1 2\n", header(3, &more, 1, "")));
        assert_eq!(scene.warnings, [""; 0]);
        assert_eq!(mesh(&scene).tex_coords, [Vec2::Y, Vec2::X, Vec2::splat(0.5)], "{names}");
        assert_eq!(scene.materials[mesh(&scene).materials[0] as usize].texture, Some(0));
    }
    let corners = "property list uchar float texcoord\n";
    let text = format!(
        "{}0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 0 0 1 1 0 .5\n",
        header(4, "", 2, corners)
    );
    let scene = textured(text.clone());
    assert_eq!(scene.warnings, [""; 0]);
    let m = mesh(&scene);
    let at = |triangle: usize| m.triangles[triangle].map(|v| (m.positions[v as usize], m.tex_coords[v as usize]));
    assert_eq!(at(0)[1], (Vec3::X, Vec2::X));
    assert_eq!(at(1)[2], (Vec3::Y, Vec2::new(0.0, 0.5)));
    assert_eq!(m.positions.len(), 4, "corners with equal coordinates are shared");
    // A list that is too short, or odd, is told; without an image they are left out.
    warned(
        &textured(text.replace("6 0 0 1 1 0 .5", "3 0 0 1")),
        "a.ply:17: a face has fewer texture coordinates than corners",
    );
    warned(&ply(text), "left out: texcoord of faces");
    warned(
        &textured(format!("{}{TRIANGLE}", header(3, "", 1, ""))),
        "a.ply:3: a texture is named, but there are no texture coordinates",
    );
}

#[test]
fn faces_choose_among_images() {
    let of_faces = "property list uchar float texcoord\nproperty int texnumber\n";
    let text = header(3, "", 2, of_faces).replacen("element", "comment TextureFile other.ppm\nelement", 1);
    let scene = textured(format!("{text}0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 1 1 1\n3 0 1 2 6 0 0 1 0 1 1 0\n"));
    let names = mesh(&scene).materials.iter().map(|&m| scene.materials[m as usize].name.as_str());
    assert_eq!(names.collect::<Vec<_>>(), ["other.ppm", "checks.ppm"]);
    let lost = text.replace("other.ppm", "lost.ppm");
    warned(
        &textured(format!("{lost}0 0 0\n1 0 0\n0 1 0\n3 0 1 2 0 0\n3 0 1 2 0 1\n")),
        "a.ply:4: texture `lost.ppm` does not exist",
    );
}

#[test]
fn faces_have_colours() {
    let colors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let text = format!("{}0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n", header(4, "", 2, colors));
    let scene = ply(text);
    let m = mesh(&scene);
    let of = |triangle: usize| m.triangles[triangle].map(|v| m.colors[v as usize].truncate());
    assert_eq!((of(0), of(1), m.positions.len()), ([Vec3::X; 3], [Vec3::Z; 3], 6));
    assert_eq!(scene.warnings, [""; 0]);
    let both =
        ply(format!("{}0 0 0 0 255 0\n1 0 0 0 255 0\n0 1 0 0 255 0\n3 0 1 2 255 0 0\n", header(3, colors, 1, colors)));
    assert_eq!(mesh(&both).colors[0].truncate(), Vec3::Y, "vertices say more");
    warned(&both, "left out: red of faces, green of faces, blue of faces");
}

#[test]
fn what_is_left_out_is_named() {
    let odd = header(3, "", 1, "").replace("element vertex", "Created by a program\nelement vertex");
    warned(&ply(format!("{odd}{TRIANGLE}")), "a.ply:3: unknown word `Created` in the header is left out");
    let more = "property float confidence\nproperty list uchar int neighbours\n";
    let text = header(3, more, 1, "property uchar flags\n")
        .replace("end_header", "element edge 1\nproperty int vertex1\nend_header");
    let scene = ply(format!("{text}0 0 0 .5 2 1 2\n1 0 0 .5 0\n0 1 0 .5 1 0\n3 0 1 2 7\n4\n"));
    warned(&scene, "left out: elements `edge`, confidence of vertices, neighbours of vertices, flags of faces");
    assert_eq!(mesh(&scene).triangles, [[0, 1, 2]]);
}

#[test]
fn strips_and_concave_polygons() {
    let strips = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                  element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                  0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 0 1 3\n";
    assert_eq!(mesh(&ply(strips)).triangles, [[0, 1, 2], [1, 3, 2], [0, 1, 3]]);
    let arrow = format!("{}0 0 0\n2 1 0\n0 2 0\n.5 1 0\n4 0 1 2 3\n", header(4, "", 1, ""));
    let scene = ply(arrow);
    let m = mesh(&scene);
    let sides = m.triangles.iter().map(|t| t.map(|i| m.positions[i as usize]));
    assert_eq!(sides.map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum::<f32>(), 1.5);
}
