//! The library without its feature `images`: all works but image files, whose calls say what is missing.
#![cfg(not(feature = "images"))]

use openrt::Context;
use openrt::api::ErrorCode;

#[test]
fn calls_for_image_files_say_what_is_missing() {
    let mut cx = Context::new().expect("threads");
    cx.set_frame_size(8, 8).expect("a size");
    cx.render().expect("a frame");
    let folder = std::env::temp_dir();
    let write = cx.write_image(folder.join("openrt_without_images.png")).expect_err("left out");
    let read = cx.load_texture(folder.join("openrt_without_images.png")).expect_err("left out");
    for error in [write, read] {
        assert_eq!(error.code, ErrorCode::InvalidOperation);
        assert!(error.message.contains("cargo feature `images`"), "{}", error.message);
    }
    assert_eq!(cx.render().expect("the context goes on").primary_rays, 64);
}
