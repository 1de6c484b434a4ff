use super::*;
use crate::api::assembler::Primitive;

fn vertex(x: f32) -> Vertex {
    Vertex { position: Vec3::splat(x), normal: Vec3::ZERO, tex_coord: Vec2::ZERO, color: Vec4::ONE }
}

#[test]
fn absent_attributes_stay_absent_and_late_ones_are_filled_up() {
    let mut builder = MeshBuilder::default();
    for x in 0..3 {
        builder.push_vertex(&vertex(x as f32), &[]).unwrap();
    }
    assert!(builder.mesh.normals.is_empty() && builder.mesh.colors.is_empty());
    let red = Vec4::new(1.0, 0.0, 0.0, 1.0);
    builder.push_vertex(&Vertex { color: red, ..vertex(3.0) }, &[]).unwrap();
    builder.push_vertex(&vertex(4.0), &[]).unwrap();
    assert_eq!(builder.mesh.colors, [Vec4::ONE, Vec4::ONE, Vec4::ONE, red, Vec4::ONE]);
    assert!(builder.mesh.normals.is_empty());
}

#[test]
fn streams_have_one_entry_per_vertex_or_triangle_whatever_the_order() {
    let mut builder = MeshBuilder::default();
    let triangle = |builder: &mut MeshBuilder, shader, captures: &mut [Capture]| {
        builder.open(shader, captures).unwrap();
        let mut assembler = Assembler::new(Primitive::Triangles);
        for x in 0..3 {
            builder.vertex(&mut assembler, &vertex(x as f32), shader, captures).unwrap();
        }
    };
    let mut captures = [
        Capture::new(0, ParamScope::Vertex, 2, [1.0, 2.0, 0.0, 0.0]),
        Capture::new(3, ParamScope::Triangle, 1, [7.0, 0.0, 0.0, 0.0]),
    ];
    triangle(&mut builder, 1, &mut []);
    triangle(&mut builder, 2, &mut captures);
    triangle(&mut builder, 1, &mut []);
    captures[1].value[0] = 8.0;
    triangle(&mut builder, 2, &mut captures);
    triangle(&mut builder, 1, &mut []);
    builder.finish().unwrap();
    let mesh = builder.into_mesh();
    assert_eq!(mesh.shader_of_triangle, [1, 2, 1, 2, 1]);
    assert_eq!(mesh.params.len(), 2);
    assert_eq!(mesh.params[0].data.len(), 30);
    assert_eq!(mesh.params[0].data[6..12], [1.0, 2.0, 1.0, 2.0, 1.0, 2.0]);
    assert_eq!(mesh.params[0].data[12..18], [0.0; 6]);
    assert_eq!(mesh.params[1].data, [0.0, 7.0, 0.0, 8.0, 0.0]);
}

#[test]
fn plain_vertices_make_the_same_mesh() {
    for primitive in [Primitive::Triangles, Primitive::QuadStrip] {
        let build = |may_be_plain: bool| {
            let mut builder = MeshBuilder::default();
            builder.open(7, &mut []).unwrap();
            let mut assembler = Assembler::new(primitive);
            let mut plain = 0;
            for i in 0..1000 {
                let mut v = vertex(i as f32);
                if i == 900 {
                    v.color = Vec4::ZERO;
                }
                let is_plain = may_be_plain && i != 900;
                if is_plain && builder.plain_vertex(&mut assembler, v.position, 7) {
                    plain += 1;
                } else {
                    builder.vertex(&mut assembler, &v, 7, &[]).unwrap();
                }
            }
            (builder.into_mesh(), plain)
        };
        let ((one, none), (other, plain)) = (build(false), build(true));
        assert!(none == 0 && (800..900).contains(&plain), "{plain}: none after the colour");
        assert_eq!((one.positions, one.triangles), (other.positions, other.triangles));
        assert_eq!(other.colors.len(), 1000);
        assert_eq!((one.shader_of_triangle, one.colors), (other.shader_of_triangle, other.colors));
    }
}

#[test]
fn rewind_restores_every_length() {
    let mut builder = MeshBuilder::default();
    builder.push_vertex(&vertex(0.0), &[]).unwrap();
    let mark = builder.mark().unwrap();
    let mut assembler = Assembler::new(Primitive::TriangleFan);
    for _ in 0..5 {
        let v = Vertex { normal: Vec3::Z, tex_coord: Vec2::ONE, color: Vec4::ZERO, ..vertex(1.0) };
        builder.vertex(&mut assembler, &v, 0, &[]).unwrap();
    }
    builder.rewind(&mark);
    let mesh = builder.into_mesh();
    assert_eq!((mesh.positions.len(), mesh.triangles.len(), mesh.shader_of_triangle.len()), (1, 0, 0));
    assert!(mesh.normals.is_empty() && mesh.tex_coords.is_empty() && mesh.colors.is_empty());
}
