//! How much memory a step takes at its height, as the system counts it.

use std::fs;

/// What `work` gives, and how many bytes this process held at most while it ran beyond what it held before; `None`
/// where the system does not tell (anything but Linux). Memory that was freed before and kept for later counts as
/// held: for small scenes the figure is too low.
pub fn peak_of<T>(work: impl FnOnce() -> T) -> (T, Option<usize>) {
    // From here on the highest mark starts at what is held now.
    let reset = fs::write("/proc/self/clear_refs", "5").is_ok();
    let before = kibibytes("VmRSS:");
    let result = work();
    let peak = kibibytes("VmHWM:")
        .zip(before)
        .filter(|_| reset)
        .map(|(peak, before)| peak.saturating_sub(before) << 10);
    (result, peak)
}

/// A line of the process's status.
fn kibibytes(name: &str) -> Option<usize> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn memory_that_is_gone_again_counts() {
        let (sum, peak) = peak_of(|| {
            vec![1u8; 64 << 20]
                .iter()
                .map(|&b| usize::from(b))
                .sum::<usize>()
        });
        assert_eq!(sum, 64 << 20);
        // A system may forbid to reset the mark; other tests run beside this one, and may free what they held.
        assert!(peak.is_none_or(|peak| peak > 32 << 20), "{peak:?}");
    }
}
