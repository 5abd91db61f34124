//! Triangles into the lines of a leaf.

use glam::Vec3;

use super::node::{Child, Line, MAX_LEAF, MAX_LEAF_VERTICES};
use crate::raw::Pages;
use crate::scene::Triangle;
use crate::simd::{Bytes, Simd, SimdBase, u32x4, u64x2};

/// Writes leaves. Kept from one to the next: to clear it all would take as long as filling it.
pub(super) struct Packer {
    vertices: VertexSet,
}

/// The vertices of a leaf, told apart by bit pattern: 0.0 and -0.0 stay two.
struct VertexSet {
    /// x, y above it, and z, in the order in which they came. Room for one more than there can be.
    bits: [[u64; 2]; VertexSet::ROOM],
    count: usize,
    /// A hash table with open addressing: one above the number of a vertex, 0 for a free place. Sparse enough that
    /// one look is nearly always enough.
    table: [u8; VertexSet::PLACES],
}

impl VertexSet {
    const PLACES: usize = 256;
    const ROOM: usize = 64;

    fn clear(&mut self) {
        self.count = 0;
        self.table = [0; VertexSet::PLACES];
    }

    /// The number of `p`, which is added when it is new.
    ///
    /// Half of them are, without a pattern: so the new ones take the same way as the others. `p` is put behind the
    /// last vertex in any case, and a free place stands for that one.
    #[inline(always)]
    fn number(&mut self, p: Vec3) -> u8 {
        const { assert!(MAX_LEAF_VERTICES < VertexSet::ROOM) };
        let [x, y, z] = p.to_array().map(|c| u64::from(c.to_bits()));
        let bits = [x | y << 32, z];
        self.bits[self.count % VertexSet::ROOM] = bits;
        // Odd factors without a pattern; the highest bits of the product depend on all bits.
        let mixed =
            bits[0].wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ z.wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        let mut place = (mixed >> 56) as usize;
        loop {
            let entry = &mut self.table[place % VertexSet::PLACES];
            let number = match usize::from(*entry) {
                0 => self.count,
                above => above - 1,
            };
            if self.bits[number % VertexSet::ROOM] == bits {
                *entry = number as u8 + 1;
                self.count += usize::from(number == self.count);
                return number as u8;
            }
            place += 1;
        }
    }
}

impl Packer {
    pub(super) fn new() -> Packer {
        Packer {
            vertices: VertexSet {
                bits: [[0; 2]; VertexSet::ROOM],
                count: 0,
                table: [0; VertexSet::PLACES],
            },
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
        vertices.clear();
        let mut index = [[0u8; MAX_LEAF]; 3];
        for (i, &number) in numbers.iter().enumerate() {
            let [a, b, c] = triangles[number as usize].corners;
            index[0][i % MAX_LEAF] = vertices.number(a);
            index[1][i % MAX_LEAF] = vertices.number(b);
            index[2][i % MAX_LEAF] = vertices.number(c);
        }
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
