//! The only door to the SIMD crate: which widths there are, lane vectors, missing lane operations.

use fearless_simd::{Level, Simd};

/// An instruction set that the kernels can be told to use. Every one of them computes the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kernel {
    /// Plain code, four lanes at a time in arrays.
    Scalar,
    /// 4 lanes: SSE up to 4.2, the project's baseline.
    Sse4,
    /// 8 lanes: AVX2.
    Avx2,
    /// 16 lanes: AVX-512 as of Ice Lake and Zen 4.
    Avx512,
}

impl Kernel {
    /// All, weakest first.
    pub const ALL: [Kernel; 4] = [Kernel::Scalar, Kernel::Sse4, Kernel::Avx2, Kernel::Avx512];

    /// What the command line and the overlay call it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Kernel::Scalar => "scalar",
            Kernel::Sse4 => "sse4",
            Kernel::Avx2 => "avx2",
            Kernel::Avx512 => "avx512",
        }
    }

    /// The strongest one that this CPU has.
    #[must_use]
    pub fn best() -> Kernel {
        *Kernel::available()
            .last()
            .expect("the scalar kernel runs everywhere")
    }

    /// Those that this CPU has, weakest first; never empty.
    #[must_use]
    pub fn available() -> Vec<Kernel> {
        Kernel::ALL
            .into_iter()
            .filter(|k| k.level().is_some())
            .collect()
    }

    /// The proof that this CPU has the instructions, or `None`.
    fn level(self) -> Option<Level> {
        let level = Level::new();
        match self {
            Kernel::Scalar => Some(Level::fallback()),
            Kernel::Sse4 => level.as_sse4_2().map(Simd::level),
            Kernel::Avx2 => level.as_avx2().map(Simd::level),
            Kernel::Avx512 => level.as_avx512().map(Simd::level),
        }
    }
}
