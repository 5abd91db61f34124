//! What must hold for any bytes; shared by the fuzz target `parse` and tests/scene_format_properties.rs.

use raybomb::scene::{ParseErrors, locate_triangles, parse, write};

/// Reads `text`. A scene must survive being written and read; errors must have places that can be shown.
pub fn parse_and_write(text: &[u8]) {
    match parse(text) {
        Ok(scene) => {
            let mut written = Vec::new();
            write(&scene, &mut written).expect("what was read is finite");
            let again = parse(&written).expect("what was written can be read");
            assert_eq!(again, scene);
            let mut rewritten = Vec::new();
            write(&again, &mut rewritten).expect("what was read is finite");
            // Unlike `==` on scenes, this tells 0 from -0.
            assert!(
                rewritten == written,
                "written once: {written:?}, twice: {rewritten:?}"
            );
            let places = locate_triangles(text, 0..scene.triangles.len());
            assert_eq!(places.len(), scene.triangles.len());
        }
        Err(errors) => {
            assert!((1..=ParseErrors::MAX).contains(&errors.errors.len()));
            for error in &errors.errors {
                assert!(error.span.start <= error.span.end && error.span.end <= text.len());
                assert!(error.line >= 1 && error.column >= 1);
            }
            let shown = errors.render("fuzz", text, false);
            assert!(
                shown.len() <= 2000 * (ParseErrors::MAX + 1),
                "too much to read"
            );
        }
    }
}
