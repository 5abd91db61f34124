//! Triangles into the lines of a leaf.

use super::node::{Child, Line, MAX_LEAF, MAX_LEAF_VERTICES};
use crate::raw::Pages;
use crate::scene::Triangle;
use crate::simd::{Bytes, Simd, SimdBase, u32x4, u64x2};

/// Writes leaves. Kept from one to the next: to clear its memory would take as long as filling it.
pub(super) struct Packer {
    vertices: Vertices,
}

/// Coordinates bit by bit, so that 0.0 and -0.0 stay two: x, y above it, and z.
type Bits = [u64; 2];

/// Numbers of vertices: of the corners A of 16 triangles, then B, then C.
type Index = [[u8; MAX_LEAF]; 3];

/// The corners of a leaf and the vertices that they share.
///
/// A corner's place: four places a triangle, the last of which is not used.
struct Vertices {
    corners: [Bits; Vertices::PLACES],
    hashes: [u16; Vertices::PLACES],
    /// For each hash, the first corner that has it. Never cleared: what is read for a leaf was written for it.
    table: [u8; Vertices::HASHES],
    /// The vertices, in the order of the triangles. Room for one more than there can be.
    bits: [Bits; Vertices::PLACES],
    count: usize,
    /// Of a corner that is the first at a vertex: the number of that.
    numbers: [u8; Vertices::PLACES],
}

impl Vertices {
    const PLACES: usize = 4 * MAX_LEAF;
    /// So many that two vertices of a leaf seldom share one.
    const HASHES: usize = 1 << 12;

    const NONE: Vertices = Vertices {
        corners: [[0; 2]; Vertices::PLACES],
        hashes: [0; Vertices::PLACES],
        table: [0; Vertices::HASHES],
        bits: [[0; 2]; Vertices::PLACES],
        count: 0,
        numbers: [0; Vertices::PLACES],
    };

    /// Takes the corners of the triangles with these numbers; returns the vertex of each corner A, B and C.
    ///
    /// Half of them are new vertices, without a pattern: so nothing branches on that, and no corner waits for the one
    /// before it. All write to the table, the last one first; then each looks who was the last to write.
    #[inline(always)]
    fn find(&mut self, triangles: &[Triangle], numbers: &[u32]) -> Index {
        const { assert!(MAX_LEAF_VERTICES < Vertices::PLACES && Vertices::PLACES.is_power_of_two()) };
        for (t, &number) in (0..MAX_LEAF).zip(numbers).rev() {
            let corners = &triangles[number as usize].corners;
            for corner in [2, 1, 0] {
                let i = 4 * t + corner;
                let [x, y, z] = corners[corner].to_array().map(|c| u64::from(c.to_bits()));
                let bits = [x | y << 32, z];
                let hash = Vertices::hash(bits);
                self.corners[i] = bits;
                self.hashes[i] = hash as u16;
                self.table[hash] = i as u8;
            }
        }
        // Not in its place yet: to count there takes 3 % longer to build.
        let mut count = 0;
        let mut different = 0;
        let mut index = [[0; MAX_LEAF]; 3];
        for t in 0..MAX_LEAF.min(numbers.len()) {
            for (corner, row) in index.iter_mut().enumerate() {
                let i = 4 * t + corner;
                let first = self.first_with_hash_of(i);
                let ([a, b], [c, d]) = (self.corners[i], self.corners[first]);
                different |= (a ^ c) | (b ^ d);
                row[t] = self.number(i, first, &mut count);
            }
        }
        self.count = count;
        if different != 0 {
            self.find_slowly(numbers.len(), &mut index);
        }
        index
    }

    #[inline(always)]
    fn hash([xy, z]: Bits) -> usize {
        // Odd factors without a pattern; the highest bits of the product depend on all bits.
        let mixed = xy.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ z.wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        (mixed >> 52) as usize % Vertices::HASHES
    }

    #[inline(always)]
    fn first_with_hash_of(&self, corner: usize) -> usize {
        let hash = usize::from(self.hashes[corner]);
        usize::from(self.table[hash % Vertices::HASHES]) % Vertices::PLACES
    }

    /// The number of the vertex of `corner`, where `first` is the first corner like it. `count`: vertices so far.
    #[inline(always)]
    fn number(&mut self, corner: usize, first: usize, count: &mut usize) -> u8 {
        // It is put behind the last vertex in any case, and stays there when it is a new one.
        self.bits[*count % Vertices::PLACES] = self.corners[corner];
        self.numbers[corner] = *count as u8;
        *count += usize::from(first == corner);
        self.numbers[first]
    }

    /// The same where some vertices have one hash.
    #[cold]
    fn find_slowly(&mut self, triangles: usize, index: &mut Index) {
        let mut count = 0;
        for t in 0..triangles {
            for (corner, row) in index.iter_mut().enumerate() {
                let i = 4 * t + corner;
                let first = self.first_with_hash_of(i);
                let bits = self.corners[i];
                row[t] = if self.corners[first] == bits {
                    self.number(i, first, &mut count)
                } else if let Some(n) = self.bits[..count].iter().position(|&v| v == bits) {
                    n as u8
                } else {
                    self.number(i, i, &mut count)
                };
            }
        }
        self.count = count;
    }
}

impl Packer {
    pub(super) fn new() -> Packer {
        Packer {
            vertices: Vertices::NONE,
        }
    }

    /// Writes a leaf of the triangles with these numbers, 1 to 16, the first of which is number `first_id` in leaf
    /// order; returns its child word, with lines counted from the start of `out`.
    #[inline(always)]
    pub(super) fn leaf<S: Simd>(
        &mut self,
        simd: S,
        triangles: &[Triangle],
        numbers: &[u32],
        first_id: u32,
        out: &mut Pages<Line>,
    ) -> Child {
        assert!(
            (1..=MAX_LEAF).contains(&numbers.len()),
            "a leaf has 1 to 16 triangles"
        );
        let vertices = &mut self.vertices;
        let mut index = vertices.find(triangles, numbers);
        for row in &mut index {
            let last = row[numbers.len() - 1];
            row[numbers.len()..].fill(last);
        }
        let mut head = [0u32; 16];
        for (words, row) in head.chunks_exact_mut(4).zip(&index) {
            for (word, bytes) in words.iter_mut().zip(row.chunks_exact(4)) {
                *word = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            }
        }
        head[12] = first_id;
        head[13] = numbers.len() as u32;
        head[14] = vertices.count as u32;
        let first = out.len();
        let chunks = vertices.count.div_ceil(16);
        let last = vertices.bits[vertices.count - 1];
        vertices.bits[vertices.count..16 * chunks].fill(last);
        out.push(Line(head));
        for chunk in vertices.bits[..16 * chunks].chunks_exact(16) {
            let mut lines = [Line([0; 16]); 3];
            for (four, at) in chunk.chunks_exact(4).zip((0..).step_by(4)) {
                let (a, b) = (
                    u64x2::load_array(simd, four[0]),
                    u64x2::load_array(simd, four[1]),
                );
                let (c, d) = (
                    u64x2::load_array(simd, four[2]),
                    u64x2::load_array(simd, four[3]),
                );
                let (xy0, z0, xy1, z1) = (a.zip_low(b), a.zip_high(b), c.zip_low(d), c.zip_high(d));
                let (xy0, xy1): (u32x4<S>, u32x4<S>) = (xy0.bitcast(), xy1.bitcast());
                let (z0, z1): (u32x4<S>, u32x4<S>) = (z0.bitcast(), z1.bitcast());
                xy0.unzip_low(xy1).store_slice(&mut lines[0].0[at..at + 4]);
                xy0.unzip_high(xy1).store_slice(&mut lines[1].0[at..at + 4]);
                z0.unzip_low(z1).store_slice(&mut lines[2].0[at..at + 4]);
            }
            out.extend_from_slice(&lines);
        }
        Child::leaf(first, chunks)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::bvh::Leaf;
    use crate::color::Rgb;
    use crate::math::Random;
    use crate::simd::{Kernel, dispatch};

    #[test]
    fn a_leaf_holds_each_vertex_once_and_every_corner_to_the_bit() {
        let mut random = Random::new(11);
        let mut slow = 0;
        for round in 0..2000 {
            // From all corners shared to none; zeros of both signs.
            let points: Vec<Vec3> = (0..[3, 20, 500][round % 3])
                .map(|i| match i {
                    0 => Vec3::ZERO,
                    1 => -Vec3::ZERO,
                    _ => random.point(),
                })
                .collect();
            let mut point = || points[random.below(points.len() as u32) as usize];
            let triangles: Vec<Triangle> = (0..20)
                .map(|_| Triangle {
                    corners: [(); 3].map(|()| point()),
                    color: Rgb::BLACK,
                })
                .collect();
            let numbers: Vec<u32> = (0..1 + round as u32 % 16).map(|i| 19 - i).collect();
            let bits = |p: Vec3| p.to_array().map(f32::to_bits);
            let corners = |number: u32| triangles[number as usize].corners.map(bits);
            let mut expected: Vec<_> = numbers.iter().flat_map(|&n| corners(n)).collect();
            expected.sort_unstable();
            expected.dedup();
            let hash = |&[x, y, z]: &[u32; 3]| {
                Vertices::hash([u64::from(x) | u64::from(y) << 32, u64::from(z)])
            };
            let mut hashes: Vec<_> = expected.iter().map(hash).collect();
            hashes.sort_unstable();
            hashes.dedup();
            slow += usize::from(hashes.len() < expected.len());
            for kernel in Kernel::available() {
                let (mut packer, mut lines) = (Packer::new(), Pages::new());
                dispatch!(kernel, simd => packer.leaf(simd, &triangles, &numbers, 7, &mut lines));
                let leaf = Leaf::new(&lines);
                assert_eq!((leaf.count(), leaf.first_id()), (numbers.len(), 7));
                assert_eq!(leaf.vertex_count(), expected.len(), "round {round}");
                for (i, &number) in numbers.iter().enumerate() {
                    assert_eq!(leaf.corners(i).map(bits), corners(number), "round {round}");
                }
            }
        }
        assert!(slow > 50, "{slow} leaves with two vertices of one hash");
    }
}
