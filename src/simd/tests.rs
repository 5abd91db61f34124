use super::*;

/// Runs a test at every width that this CPU has.
macro_rules! at_every_width {
    ($simd:ident => $work:expr) => {
        for kernel in Kernel::available() {
            dispatch!(kernel, $simd => $work);
        }
    };
}

#[test]
fn a_look_up_finds_what_the_table_has() {
    let table: Vec<u32> = (0..100).map(|i| i * i).collect();
    let index: [u32; 16] = std::array::from_fn(|i| match i % 5 {
        0 => 99,
        1 => 100,
        2 => u32::MAX,
        3 => 1 << 31,
        _ => i as u32,
    });
    at_every_width!(simd => {
        let n = index.len().min(lanes_of(simd));
        for table in [&table[..], &[]] {
            let found = simd.look_up(table, &index[..n], 7);
            for (lane, &index) in index[..n].iter().enumerate() {
                let expected = table.get(index as usize).copied().unwrap_or(7);
                assert_eq!(found[lane], expected, "number {index}");
            }
        }
    });
}

#[test]
fn a_gather_takes_the_last_row_for_all_beyond() {
    let table: Vec<[f32; 4]> = (0..40)
        .map(|i| [0.0, 0.25, 0.5, 0.75].map(|k| i as f32 + k))
        .collect();
    let index: [u32; 16] = std::array::from_fn(|i| match i % 4 {
        0 => 39,
        1 => 40,
        2 => u32::MAX,
        _ => i as u32,
    });
    at_every_width!(simd => {
        let columns = simd.gather4(&table, &index);
        for (k, column) in columns.iter().enumerate() {
            for (lane, &index) in index[..lanes_of(simd)].iter().enumerate() {
                assert_eq!(column[lane], table[index.min(39) as usize][k]);
            }
        }
    });
}

#[test]
fn pairs_lie_in_turn_row_by_row() {
    at_every_width!(simd => put_pairs(simd));
}

#[inline(always)]
fn put_pairs<S: Lanes>(simd: S) {
    // A unit's pixels, as in memory: 4 a row, the left unit's, then the right one's.
    let of = |first: u32| {
        let numbers: [u32; 16] = std::array::from_fn(|i| first + i as u32);
        S::u32s::from_slice(simd, &numbers[..lanes::<S>()])
    };
    let mut rows = [[0; 16]; 4];
    simd.put_pairs([of(0), of(100)], [of(1000), of(1100)], &mut rows);
    for (y, row) in rows[..lanes::<S>().div_ceil(4)].iter().enumerate() {
        for x in 0..8 {
            let number = x / 4 * 100 + 4 * y + x % 4;
            assert_eq!(row[2 * x..2 * x + 2], [number as u32, number as u32 + 1000]);
        }
    }
}

#[test]
fn units_side_by_side_become_rows() {
    at_every_width!(simd => in_rows(simd));
}

#[inline(always)]
fn in_rows<S: Lanes>(simd: S) {
    let of = |unit: u32| {
        let numbers: [u32; 16] =
            std::array::from_fn(|i| i as u32 / 4 * 16 + 4 * unit + i as u32 % 4);
        S::u32s::from_slice(simd, &numbers[..lanes::<S>()])
    };
    let rows = simd.in_rows([of(0), of(1), of(2), of(3)]);
    for (i, row) in rows.iter().enumerate() {
        for lane in 0..lanes::<S>() {
            assert_eq!(row[lane] as usize, i * lanes::<S>() + lane);
        }
    }
}

#[test]
fn streaming_copies_every_word_wherever_it_starts() {
    let from: Vec<u32> = (0..200).collect();
    at_every_width!(simd => {
        for start in 0..20 {
            for length in [0, 1, 15, 16, 17, 64, 150] {
                let mut to = [u32::MAX; 200];
                simd.stream(&mut to[start..start + length], &from[..length]);
                raw::streamed();
                assert_eq!(to[start..start + length], from[..length]);
                assert!(to[..start].iter().all(|&w| w == u32::MAX));
                assert!(to[start + length..].iter().all(|&w| w == u32::MAX));
            }
        }
    });
}

fn lanes_of<S: Simd>(_: S) -> usize {
    lanes::<S>()
}
