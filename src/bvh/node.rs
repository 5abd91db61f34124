//! Nodes and leaves as the kernels read them: 64-byte lines.

use glam::Vec3;

/// Triangles in a leaf at most.
pub const MAX_LEAF: usize = 16;

/// Vertices in a leaf at most: no two corners shared.
pub const MAX_LEAF_VERTICES: usize = 3 * MAX_LEAF;

/// Children of a node at most.
pub const WIDTH: usize = 8;

/// An interior node: the boxes of eight children, one row a bound. 256 bytes.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Rows: smallest x, y, z, then largest x, y, z. The box of a child that is not there is inverted.
    pub bounds: [[f32; WIDTH]; 6],
    /// What each box holds.
    pub children: [Child; WIDTH],
}

impl Node {
    /// No children.
    pub const EMPTY: Node = Node {
        bounds: [
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        children: [Child::NONE; WIDTH],
    };
}

/// One child word: nothing, a node or a leaf.
///
/// Bit 31: leaf. Bits 27 and 28 of a leaf: how many times 16 vertices it has, less one (so that all its lines can
/// be asked for before the first has arrived). Bits 0..27: index of the node, or of the leaf's first line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Child(pub u32);

impl Child {
    /// Nothing.
    pub const NONE: Child = Child(Child::INDEX);
    const LEAF: u32 = 1 << 31;
    const INDEX: u32 = (1 << 27) - 1;

    /// The node with that index.
    ///
    /// # Panics
    /// From 2²⁷ − 1 on.
    #[must_use]
    pub fn node(index: usize) -> Child {
        assert!(index < Child::INDEX as usize, "too many nodes");
        Child(index as u32)
    }

    /// The leaf that starts at line `first` and has 1..=3 chunks of vertices.
    ///
    /// # Panics
    /// From 2²⁷ lines on.
    #[must_use]
    pub fn leaf(first: usize, chunks: usize) -> Child {
        assert!(first <= Child::INDEX as usize, "too many lines of leaves");
        assert!((1..=3).contains(&chunks), "a leaf has 1 to 48 vertices");
        Child(Child::LEAF | (chunks as u32 - 1) << 27 | first as u32)
    }

    /// True for a leaf.
    #[inline(always)]
    #[must_use]
    pub fn is_leaf(self) -> bool {
        self.0 & Child::LEAF != 0
    }

    /// Index of the node or of the leaf's first line.
    #[inline(always)]
    #[must_use]
    pub fn index(self) -> usize {
        (self.0 & Child::INDEX) as usize
    }

    /// Chunks of vertices of a leaf.
    #[inline(always)]
    #[must_use]
    pub fn chunks(self) -> usize {
        (self.0 >> 27 & 3) as usize + 1
    }

    /// The same child after `nodes` nodes and `lines` lines were put in front of everything.
    #[must_use]
    pub fn moved(self, nodes: usize, lines: usize) -> Child {
        if self == Child::NONE {
            self
        } else if self.is_leaf() {
            Child::leaf(self.index() + lines, self.chunks())
        } else {
            Child::node(self.index() + nodes)
        }
    }
}

/// 64 bytes of a leaf.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line(pub [u32; 16]);

/// A leaf: one line that says which corner is which vertex, then three lines (x, y, z) for every 16 vertices.
///
/// The first line: 16 bytes of vertex numbers for the corners A, as many for B and C (in the file's order of
/// corners: it is part of the arithmetic), the number of the first triangle in leaf order, the count of triangles
/// and of vertices. The coordinates are the file's very `f32`s. Unused places repeat the last used one, so that a
/// kernel may compute with them.
#[derive(Clone, Copy, Debug)]
pub struct Leaf<'a> {
    head: &'a Line,
    rest: &'a [Line],
}

impl<'a> Leaf<'a> {
    /// The leaf that starts at the first of `lines`.
    #[inline(always)]
    #[must_use]
    pub fn new(lines: &'a [Line]) -> Leaf<'a> {
        let (head, rest) = lines.split_first().expect("a leaf has a first line");
        Leaf { head, rest }
    }

    /// Triangles, 1..=16.
    #[inline(always)]
    #[must_use]
    pub fn count(self) -> usize {
        self.head.0[13] as usize
    }

    /// Vertices, 1..=48.
    #[inline(always)]
    #[must_use]
    pub fn vertex_count(self) -> usize {
        self.head.0[14] as usize
    }

    /// Lines in all.
    #[must_use]
    pub fn line_count(self) -> usize {
        1 + 3 * self.vertex_count().div_ceil(16)
    }

    /// Number of the first triangle in leaf order; the others follow.
    #[inline(always)]
    #[must_use]
    pub fn first_id(self) -> u32 {
        self.head.0[12]
    }

    /// The vertex numbers of corner `corner` (0..3) of all 16 triangles, 4 a word, lowest byte first.
    #[inline(always)]
    #[must_use]
    pub fn corner_words(self, corner: usize) -> [u32; 4] {
        let w = &self.head.0[4 * corner..4 * corner + 4];
        [w[0], w[1], w[2], w[3]]
    }

    /// The vertex number of one corner of one triangle.
    #[inline(always)]
    #[must_use]
    pub fn vertex_of(self, corner: usize, triangle: usize) -> usize {
        let word = self.head.0[4 * corner + triangle / 4];
        (word >> (8 * (triangle % 4)) & 255) as usize
    }

    /// The bits of coordinate `axis` (0..3) of the 16 vertices of chunk `chunk`.
    #[inline(always)]
    #[must_use]
    pub fn coordinate_bits(self, chunk: usize, axis: usize) -> &'a [u32; 16] {
        &self.rest[3 * chunk + axis].0
    }

    /// The corners of triangle `triangle` of the leaf.
    #[must_use]
    pub fn corners(self, triangle: usize) -> [Vec3; 3] {
        [0, 1, 2].map(|corner| {
            let v = self.vertex_of(corner, triangle);
            let c = |axis| f32::from_bits(self.coordinate_bits(v / 16, axis)[v % 16]);
            Vec3::new(c(0), c(1), c(2))
        })
    }
}
