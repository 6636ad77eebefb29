//! Peak memory of the process.
//!
//! In: nothing. Out: bytes, where the system tells. Source: the VmHWM line of Linux's process status.

/// Largest resident memory of this process so far, bytes; `None` where the system does not tell.
pub fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kibibytes| kibibytes * 1024)
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_large_allocation_raises_the_peak() {
        let Some(before) = super::peak_bytes() else { return };
        let block = vec![1u8; 64 << 20];
        let after = super::peak_bytes().expect("the system told before");
        assert!(block.iter().map(|&b| u64::from(b)).sum::<u64>() == 64 << 20);
        assert!(after >= before.max(64 << 20), "{before} {after}");
    }
}
