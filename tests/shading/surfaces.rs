//! Holes, textures, opacity, interpolated attributes.

use crate::kit::*;
use glam::{Affine3A, Vec3, Vec4};
use openrt::scene::*;

#[test]
fn a_texture_lies_the_right_way_up() {
    let mut w = World::new(4);
    let rgbw = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]];
    let image = texture(&mut w, rgbw, Filter::Nearest);
    let shader = w.shader("constant", &[("texture", ParamValue::Texture(image))]);
    // Exactly the field of view of the default camera.
    let side = 2.0 * 30f32.to_radians().tan();
    w.add(quad(Vec3::NEG_Z, Vec3::X * side, Vec3::Y * side, shader));
    let picture = w.render();
    assert_near(picture[0], [1.0, 0.0, 0.0, 1.0], 0.0);
    assert_near(picture[3], [0.0, 1.0, 0.0, 1.0], 0.0);
    assert_near(picture[12], [0.0, 0.0, 1.0, 1.0], 0.0);
    assert_near(picture[15], [1.0, 1.0, 1.0, 1.0], 0.0);
    // A texture that does not exist is white.
    let missing = w.shader("constant", &[("texture", ParamValue::Texture(77_777))]);
    w.frame.instances.clear();
    w.add(wall(-1.0, missing));
    assert_near(w.middle(), [1.0; 4], 0.0);
}

#[test]
fn a_fine_texture_far_away_is_its_mean() {
    let mut w = World::new(16);
    let [o, x] = [[0, 0, 0, 255], [255; 4]];
    let checker = texture(&mut w, [o, x, x, o], Filter::LinearMipmapLinear);
    let shader = w.shader("constant", &[("texture", ParamValue::Texture(checker))]);
    let mut mesh = wall(-2.0, shader);
    mesh.tex_coords.iter_mut().for_each(|t| *t *= 1000.0);
    w.add(mesh);
    for color in w.render() {
        // The 1 × 1 level of the checker is 128/255.
        assert_near(color, [128.0 / 255.0, 128.0 / 255.0, 128.0 / 255.0, 1.0], 1e-5);
    }
}

#[test]
fn holes_let_the_eye_and_the_light_through() {
    let mut w = World::new(1);
    let [o, x] = [[255, 255, 255, 0], [255; 4]];
    let mask = texture(&mut w, [o, x, x, o], Filter::Nearest);
    let leaf = w.shader("cutout", &[("texture", ParamValue::Texture(mask)), ("color", rgb(0.0, 1.0, 0.0))]);
    let white = w.shader("diffuse", &[("color", grey(1.0))]);
    w.add(wall(-2.0, white));
    w.light("directional", &[("direction", rgb(-1.0, 0.0, -1.0))]);
    let lit = 0.5f32.sqrt();
    // The ray to the light passes (1, 0, −1); the eye's ray stays at x = 0.
    let shadow_leaf = |dx: f32| quad(Vec3::new(1.0 + dx, 0.2, -1.0), Vec3::X * 1.6, Vec3::Y * 1.6, leaf);
    for (dx, share) in [(0.4, lit), (-0.4, 0.0)] {
        let mut v = World { scene: Scene::default(), frame: w.frame.clone(), next: 900 };
        v.scene.classes = w.scene.classes.clone();
        v.scene.shaders = w.scene.shaders.clone();
        v.scene.textures = w.scene.textures.clone();
        v.scene.objects = w.scene.objects.clone();
        v.add(shadow_leaf(dx));
        assert_near(v.middle(), [share, share, share, 1.0], 1e-5);
        let renderer = v.renderer();
        assert_eq!(renderer.framebuffer().pixel(0, 0).unwrap().instance, 0);
    }
    // In front of the eye: through the hole the wall, elsewhere the leaf, also for depth and names.
    w.add(quad(Vec3::new(0.4, 0.4, -1.0), Vec3::X * 1.6, Vec3::Y * 1.6, leaf));
    let renderer = w.renderer();
    assert!((renderer.framebuffer().pixel(0, 0).unwrap().depth - 2.0).abs() < 1e-5);
    assert_eq!(renderer.pick(&w.scene, 0.5, 0.5).expect("memory").expect("the wall lies behind the hole").instance, 0);
    w.frame.instances.pop();
    w.add(quad(Vec3::new(-0.4, 0.4, -1.0), Vec3::X * 1.6, Vec3::Y * 1.6, leaf));
    let renderer = w.renderer();
    let pixel = renderer.framebuffer().pixel(0, 0).unwrap();
    assert!((pixel.depth - 1.0).abs() < 1e-5 && pixel.instance == 1);
    assert_eq!(renderer.pick(&w.scene, 0.5, 0.5).expect("memory").expect("the leaf is hit").instance, 1);
    assert_near(Vec4::from_array(pixel.color), [0.0, lit, 0.0, 1.0], 1e-5);
}

#[test]
fn opacity_blends_with_what_lies_behind() {
    let mut w = World::new(1);
    let back = w.shader("constant", &[("color", rgb(0.0, 0.0, 1.0))]);
    let red = [("emission", rgb(1.0, 0.0, 0.0)), ("diffuse", grey(0.0)), ("opacity", float(0.25))];
    let front = w.shader("phong", &red);
    w.add(wall(-1.0, front));
    assert_near(w.middle(), [0.25, 0.0, 0.0, 0.25], 1e-6);
    w.add(wall(-2.0, back));
    assert_near(w.middle(), [0.25, 0.0, 0.75, 1.0], 1e-6);
}

#[test]
fn vertex_colors_and_normals_are_interpolated() {
    let mut w = World::new(9);
    let constant = w.shader("constant", &[]);
    let side = 2.0 * 30f32.to_radians().tan();
    let mut mesh = quad(Vec3::NEG_Z, Vec3::X * side, Vec3::Y * side, constant);
    mesh.colors =
        vec![Vec4::W, Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(1.0, 1.0, 0.0, 1.0), Vec4::new(0.0, 1.0, 0.0, 1.0)];
    w.add(mesh);
    for (i, color) in w.render().into_iter().enumerate() {
        let (x, y) = ((i % 9) as f32 + 0.5, (i / 9) as f32 + 0.5);
        assert_near(color, [x / 9.0, y / 9.0, 0.0, 1.0], 1e-5);
    }

    let normals = w.shader("normals", &[]);
    let [a, b] = [Vec3::new(-1.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 1.0)];
    let mut mesh = quad(Vec3::NEG_Z, Vec3::X * side, Vec3::Y * side, normals);
    mesh.normals = vec![a, b, b, a];
    let smooth = w.object(mesh);
    // Stretched, turned and mirrored instances: normals follow the inverse transpose, and stay on their side.
    let flat_scale = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.25));
    let mirrored = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    for (place, factor) in [(Affine3A::IDENTITY, 1.0), (flat_scale, 4.0), (mirrored, 1.0)] {
        let mut v = World { scene: std::mem::take(&mut w.scene), frame: w.frame.clone(), next: 2000 };
        v.frame.instances.clear();
        let lifted = Affine3A::from_translation(Vec3::Z * (place.matrix3.z_axis.z - 1.0)) * place;
        v.place(smooth, lifted);
        for (i, color) in v.render().into_iter().enumerate() {
            let x = ((i % 9) as f32 + 0.5) / 9.0;
            let n = Vec3::new(2.0 * x - 1.0, 0.0, factor).normalize();
            let expected = compass(n);
            assert_near(color, [expected.x, expected.y, expected.z, 1.0], 2e-3);
        }
        w.scene = v.scene;
    }
}

#[test]
fn glass_keeps_its_inside_in_mirrored_instances() {
    let mut w = World::new(16);
    w.use_compass();
    let glass = w.shader("glass", &[]);
    let ball = w.object(sphere(Vec3::new(0.0, 0.0, -3.0), 1.0, 32, glass));
    w.place(ball, Affine3A::IDENTITY);
    let right = w.render();
    w.frame.instances.clear();
    w.place(ball, Affine3A::from_scale(Vec3::new(1.0, -1.0, 1.0)));
    let mirrored = w.render();
    for y in 0..16 {
        for x in 0..16 {
            let (a, b) = (right[y * 16 + x], mirrored[(15 - y) * 16 + x]);
            assert!((a.x - b.x).abs() < 0.05 && (a.z - b.z).abs() < 0.05, "{x} {y}: {a} {b}");
        }
    }
}
