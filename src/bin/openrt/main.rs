//! `openrt`: looks at, renders and plays scene files through the public API of the library.
#![forbid(unsafe_code)]

mod loaders;
mod scene;

fn main() {
    let path = std::env::args().nth(1).unwrap();
    match loaders::load(std::path::Path::new(&path), 0.0) {
        Ok(s) => {
            println!("{:?} tri {}\nnamed {} nodes {} lights {} objs {} mats {} tex {}\nwarn {:?}\nnotes {:?}", s.counts, s.counts.triangles(), s.named_transforms.len(), s.nodes.len(), s.lights.len(), s.objects.len(), s.materials.len(), s.textures.len(), s.warnings, s.notes);
            println!("{:?}", s.bounds(0.0));
        }
        Err(e) => println!("{e}"),
    }
}
