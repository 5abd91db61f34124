//! NPY 1.0 arrays, rows from top to bottom: `numpy.load` reads them.

use std::io::{self, Write};

use glam::DVec3;

use super::{for_each_rgb_row, rows};
use crate::camera::View;
use crate::frame::{Frame, Hit, Hits, MISS};
use crate::geometry::unit_normal;
use crate::scene::Triangle;

/// Header and data are apart by a multiple of this, as NumPy's own writer does it.
const ALIGNMENT: usize = 64;

/// `<u4`, H x W: triangle numbers, 0xffffffff for a miss.
pub(super) fn write_ids(hits: &Hits, out: &mut dyn Write) -> io::Result<()> {
    write_header(out, "<u4", &[hits.height, hits.width])?;
    write_rows(hits, out, |_, _, hit, row| row.extend(hit.id.to_le_bytes()))
}

/// `<f4`, H x W: distance from the eye along the ray in the scene's units, infinite for a miss.
pub(super) fn write_depth(hits: &Hits, view: &View, out: &mut dyn Write) -> io::Result<()> {
    write_header(out, "<f4", &[hits.height, hits.width])?;
    write_rows(hits, out, |x, y, hit, row| {
        row.extend(distance(hit, view.direction(x, y)).to_le_bytes());
    })
}

/// `<f4`, H x W x 3: unit normals on the side turned to the eye, 0 for a miss. `triangles` are all of the file's.
pub(super) fn write_normals(
    hits: &Hits,
    view: &View,
    triangles: &[Triangle],
    out: &mut dyn Write,
) -> io::Result<()> {
    write_header(out, "<f4", &[hits.height, hits.width, 3])?;
    write_rows(hits, out, |x, y, hit, row| {
        let normal = match hit.id {
            MISS => DVec3::ZERO,
            id => normal_to_eye(&triangles[id as usize], view.direction(x, y)),
        };
        for c in normal.as_vec3().to_array() {
            row.extend(c.to_le_bytes());
        }
    })
}

/// `|u1`, H x W x 3: the picture's R, G, B.
pub(super) fn write_colors(frame: &Frame, out: &mut dyn Write) -> io::Result<()> {
    write_header(out, "|u1", &[frame.height, frame.width, 3])?;
    for_each_rgb_row(frame, |row| out.write_all(row))
}

/// `t` counts in lengths of the pixel's `direction`.
fn distance(hit: Hit, direction: DVec3) -> f32 {
    if hit.id == MISS {
        return f32::INFINITY;
    }
    let distance = f64::from(hit.t) * direction.length();
    // Too far for f32 is still a hit: infinity means a miss.
    (distance as f32).min(f32::MAX)
}

fn normal_to_eye(triangle: &Triangle, direction: DVec3) -> DVec3 {
    let normal = unit_normal(&triangle.corners);
    if normal.dot(direction) > 0.0 {
        // Not `-normal`: 0 stays +0.
        DVec3::ZERO - normal
    } else {
        normal
    }
}

/// Calls `put(x, y, hit, bytes)` for every pixel; what it appends is written, a row at a time.
fn write_rows(
    hits: &Hits,
    out: &mut dyn Write,
    put: impl Fn(usize, usize, Hit, &mut Vec<u8>),
) -> io::Result<()> {
    let mut row = Vec::new();
    for (y, pixels) in rows(&hits.pixels, hits.width).enumerate() {
        row.clear();
        for (x, &hit) in pixels.iter().enumerate() {
            put(x, y, hit, &mut row);
        }
        out.write_all(&row)?;
    }
    Ok(())
}

/// Magic, version 1.0, and the text of a Python dictionary padded with blanks to end at a multiple of 64.
fn write_header(out: &mut dyn Write, descr: &str, shape: &[usize]) -> io::Result<()> {
    let shape: Vec<String> = shape.iter().map(usize::to_string).collect();
    let shape = shape.join(", ");
    let dict = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}");
    let before_dict = 10;
    let padded = (before_dict + dict.len() + 1).next_multiple_of(ALIGNMENT) - before_dict;
    let length = u16::try_from(padded).expect("the dictionary is a short line");
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&length.to_le_bytes())?;
    writeln!(out, "{dict:<width$}", width = padded - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::geometry::Aabb;

    #[test]
    fn the_header_ends_at_a_multiple_of_64_with_a_newline() {
        for shape in [&[1, 1][..], &[16384, 16384, 3]] {
            let mut file = Vec::new();
            write_header(&mut file, "<f4", shape).unwrap();
            assert_eq!(file.len() % 64, 0);
            assert_eq!(file.last(), Some(&b'\n'));
            let length = usize::from(u16::from_le_bytes([file[8], file[9]]));
            assert_eq!(length + 10, file.len());
        }
    }

    #[test]
    fn ids_and_distances_are_little_endian_rows() {
        let hits = Hits {
            width: 2,
            height: 1,
            pixels: vec![Hit { id: 7, t: 2.0 }, Hit::NONE],
        };
        let mut file = Vec::new();
        write_ids(&hits, &mut file).unwrap();
        assert!(file.starts_with(
            b"\x93NUMPY\x01\0\x76\0{'descr': '<u4', 'fortran_order': False, 'shape': (1, 2), }"
        ));
        assert_eq!(file[128..], [7, 0, 0, 0, 255, 255, 255, 255]);

        let view = Camera::default_for(Aabb::EMPTY).view(2, 1, false);
        let mut file = Vec::new();
        write_depth(&hits, &view, &mut file).unwrap();
        let values: Vec<f32> = file[128..]
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        let expected = 2.0 * view.direction(0, 0).length();
        assert_eq!(values, [expected as f32, f32::INFINITY]);
    }
}
