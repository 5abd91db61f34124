//! Vectors whose memory comes straight from the system, in large pages, when there is much of it.
//!
//! New memory is cleared and mapped page by page: 2.4 µs for one of 4 KiB, 250 µs for one of 2 MiB, a fifth for each
//! byte (on a virtual machine). An allocator spoils the first large page of what it gives by a note of its own in it,
//! and an end that no large page fills is made of small ones; so much of it is asked of the system itself, in whole
//! large pages.

use std::fmt;
use std::marker::PhantomData;
use std::mem::ManuallyDrop;
use std::ops::{Deref, DerefMut};
use std::ptr::NonNull;

use super::{LARGE_PAGE, large_pages};

/// Below so many bytes an allocator may have memory that is warm.
const MUCH: usize = 12 << 20;

/// A vector of plain values. With much in it, its room is a whole number of large pages.
pub struct Pages<T: Copy> {
    first: NonNull<T>,
    len: usize,
    room: usize,
    /// Whether the memory is the system's; if not, it is that of a `Vec` with this room.
    mapped: bool,
    values: PhantomData<T>,
}

// SAFETY: it owns its values, as a `Vec` does, and hands them out by the same rules.
unsafe impl<T: Copy + Send> Send for Pages<T> {}
// SAFETY: as above.
unsafe impl<T: Copy + Sync> Sync for Pages<T> {}

impl<T: Copy> Pages<T> {
    /// Nothing, without memory.
    #[must_use]
    pub fn new() -> Pages<T> {
        Pages::of_vec(Vec::new())
    }

    /// Nothing, with room for at least `count` values. What is never used costs nothing.
    #[must_use]
    pub fn with_room(count: usize) -> Pages<T> {
        system::map(count, MUCH).unwrap_or_else(|| {
            let mut vec = Vec::with_capacity(count);
            large_pages(vec.spare_capacity_mut());
            Pages::of_vec(vec)
        })
    }

    /// Takes over memory and values.
    fn of_vec(vec: Vec<T>) -> Pages<T> {
        let mut vec = ManuallyDrop::new(vec);
        Pages {
            first: NonNull::new(vec.as_mut_ptr()).expect("a vector's pointer is never null"),
            len: vec.len(),
            room: vec.capacity(),
            mapped: false,
            values: PhantomData,
        }
    }

    /// For how many values there is room.
    #[must_use]
    pub fn room(&self) -> usize {
        self.room
    }

    /// Forgets all values from number `len` on.
    pub fn truncate(&mut self, len: usize) {
        self.len = self.len.min(len);
    }

    /// Forgets all values; the memory stays.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Nothing, with the memory of these values as its room if it is the system's: it is warm, and need not be cleared
    /// again.
    #[must_use]
    pub fn reused<U: Copy>(self) -> Pages<U> {
        const { assert!(size_of::<T>() > 0 && size_of::<U>() < LARGE_PAGE && align_of::<U>() <= 4096) };
        if !self.mapped || size_of::<U>() == 0 {
            return Pages::new();
        }
        let old = ManuallyDrop::new(self);
        Pages {
            first: old.first.cast(),
            len: 0,
            room: (old.room * size_of::<T>()).next_multiple_of(LARGE_PAGE) / size_of::<U>(),
            mapped: true,
            values: PhantomData,
        }
    }

    /// Room for at least `count` values in all.
    #[cold]
    pub fn make_room(&mut self, count: usize) {
        if count > self.room {
            let mut larger = Pages::with_room(count);
            larger.extend_from_slice(self);
            *self = larger;
        }
    }

    /// Puts `value` behind the others.
    #[inline(always)]
    pub fn push(&mut self, value: T) {
        self.extend_from_slice(&[value]);
    }

    /// Puts `values` behind the others.
    #[inline(always)]
    pub fn extend_from_slice(&mut self, values: &[T]) {
        if values.len() > self.room - self.len {
            self.make_room((self.len + values.len()).max(2 * self.room));
        }
        // SAFETY: there is room for as many values behind the `len` that are there, in memory that nobody else has.
        unsafe {
            let end = self.first.as_ptr().add(self.len);
            std::ptr::copy_nonoverlapping(values.as_ptr(), end, values.len());
        }
        self.len += values.len();
    }
}

impl Pages<u64> {
    /// So many zeros, in memory that is cleared when it is used. If that is the system's, there is room for `room`.
    #[must_use]
    pub fn zeros(count: usize, room: usize) -> Pages<u64> {
        let mapped = if count * size_of::<u64>() < LARGE_PAGE {
            None
        } else {
            system::map(count.max(room), LARGE_PAGE)
        };
        let Some(mut zeros) = mapped else {
            return Pages::of_vec(vec![0; count]);
        };
        // What the system gives is zeros, and there is room for as many.
        zeros.len = count;
        zeros
    }
}

impl<T: Copy> Default for Pages<T> {
    fn default() -> Pages<T> {
        Pages::new()
    }
}

impl<T: Copy> Deref for Pages<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: the first `len` values are there, and borrowed with `self`.
        unsafe { std::slice::from_raw_parts(self.first.as_ptr(), self.len) }
    }
}

impl<T: Copy> DerefMut for Pages<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        // SAFETY: the first `len` values are there, and borrowed with `self`.
        unsafe { std::slice::from_raw_parts_mut(self.first.as_ptr(), self.len) }
    }
}

impl<T: Copy + fmt::Debug> fmt::Debug for Pages<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

impl<T: Copy> Drop for Pages<T> {
    fn drop(&mut self) {
        if self.mapped {
            system::unmap(self);
        } else {
            // SAFETY: pointer and room are those of a `Vec` that was taken over; its values need no dropping.
            drop(unsafe { Vec::from_raw_parts(self.first.as_ptr(), 0, self.room) });
        }
    }
}

#[cfg(target_os = "linux")]
mod system {
    use std::marker::PhantomData;
    use std::ptr::{self, NonNull};

    use rustix::mm::{Advice, MapFlags, ProtFlags, madvise, mmap_anonymous, munmap};

    use super::{LARGE_PAGE, Pages};

    /// Room for at least `count` values, if they have `least` bytes and the system gives it.
    pub(super) fn map<T: Copy>(count: usize, least: usize) -> Option<Pages<T>> {
        const { assert!(size_of::<T>() < LARGE_PAGE && align_of::<T>() <= 4096) };
        let bytes = count.checked_mul(size_of::<T>())?;
        if bytes < least {
            return None;
        }
        let bytes = bytes.checked_next_multiple_of(LARGE_PAGE)?;
        let (rights, flags) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::PRIVATE);
        // SAFETY: a new mapping, where the system chooses, touches nothing that is there.
        let memory = unsafe { mmap_anonymous(ptr::null_mut(), bytes, rights, flags) }.ok()?;
        // SAFETY: advice on our own mapping, which changes no content.
        let advised = unsafe { madvise(memory, bytes, Advice::LinuxHugepage) };
        // That it may be refused is no fault.
        let _ = advised;
        Some(Pages {
            first: NonNull::new(memory)?.cast(),
            len: 0,
            room: bytes / size_of::<T>(),
            mapped: true,
            values: PhantomData,
        })
    }

    /// Gives back what [`map`] gave.
    pub(super) fn unmap<T: Copy>(pages: &mut Pages<T>) {
        // The whole of the large pages: less than one value is missing from them.
        let bytes = (pages.room * size_of::<T>()).next_multiple_of(LARGE_PAGE);
        // SAFETY: this is the very mapping, which nobody uses after its owner is dropped.
        let unmapped = unsafe { munmap(pages.first.as_ptr().cast(), bytes) };
        debug_assert!(unmapped.is_ok(), "a mapping of our own");
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    use super::Pages;

    pub(super) fn map<T: Copy>(_count: usize, _least: usize) -> Option<Pages<T>> {
        None
    }

    pub(super) fn unmap<T: Copy>(_pages: &mut Pages<T>) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stay_while_the_room_grows() {
        let mut pages = Pages::new();
        let mut expected = Vec::new();
        for i in 0..700_000u64 {
            pages.push([i, !i]);
            expected.push([i, !i]);
        }
        pages.extend_from_slice(&expected[..1000]);
        expected.extend_from_within(..1000);
        assert!(pages.room() >= expected.len());
        assert_eq!(*pages, *expected);
        pages[5] = [0; 2];
        pages.truncate(6);
        assert_eq!(pages[4..], [[4, !4], [0; 2]]);
        pages.clear();
        assert!(pages.is_empty());
    }

    #[test]
    fn there_is_room_for_what_is_asked_whatever_the_size_of_values() {
        for count in [0, 1, 1000, 1 << 19, (1 << 19) + 1] {
            let mut threes: Pages<[u8; 24]> = Pages::with_room(count);
            assert!(threes.room() >= count && threes.is_empty());
            threes.extend_from_slice(&vec![[7; 24]; count]);
            assert!(threes.iter().all(|three| *three == [7; 24]));
            let zeros = Pages::zeros(count, 2 * count);
            assert_eq!(zeros.len(), count);
            assert!(zeros.iter().all(|&zero| zero == 0));
            let room = zeros.room();
            let mut threes: Pages<[u8; 24]> = zeros.reused();
            assert!(threes.is_empty());
            assert!(threes.room() == 0 || threes.room() >= room / 3);
            threes.extend_from_slice(&vec![[7; 24]; count]);
            assert!(threes.iter().all(|three| *three == [7; 24]));
            assert_eq!(threes.len(), count);
        }
    }

    #[test]
    fn values_without_a_size_are_counted() {
        let mut nothing = Pages::new();
        nothing.extend_from_slice(&[(); 100]);
        nothing.push(());
        assert_eq!(nothing.len(), 101);
    }
}
