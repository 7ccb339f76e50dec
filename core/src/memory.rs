//! Memory that a piece of work needs, asked for before any of it is taken.
//!
//! A vector for which there is no memory ends the process, so each piece of work estimates what it
//! takes at its peak, compares that with what its caller allows, and takes one block of that size
//! and gives it back. Where that fails, as under a limit of the address space, it is an error.

use crate::error::FactorError;
use faer::dyn_stack::{MemBuffer, StackReq};
use std::hint::black_box;
use std::sync::Mutex;

/// Address space of the products of dense blocks in one thread, little of which becomes resident.
const PRODUCT_BYTES: u64 = 64 << 20;
/// Room for the stack of one thread and what the allocator sets aside for it.
const BYTES_A_THREAD: u64 = 4 << 20;

/// Refuses work that needs more than `most` bytes, or more than there are.
pub fn ask(needed: u64, most: u64) -> Result<(), FactorError> {
    ask_for_threads(needed, most, 1)
}

/// The same for work on so many threads.
pub fn ask_for_threads(needed: u64, most: u64, n_threads: u64) -> Result<(), FactorError> {
    if needed > most {
        return Err(FactorError::NoMemory { needed });
    }
    let total = needed.saturating_add(n_threads * PRODUCT_BYTES);
    let bytes = usize::try_from(total).unwrap_or(usize::MAX);
    // never written, so that no page of it becomes resident; hidden, or the optimiser leaves it out
    black_box(&mut Vec::<u8>::new())
        .try_reserve_exact(bytes)
        .map_err(|_| FactorError::NoMemory { needed: total })
}

/// Starts the threads, once; an error where the system has no room for them.
pub fn start_threads() -> Result<(), FactorError> {
    static STARTED: Mutex<bool> = Mutex::new(false);
    let mut started = STARTED
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    if !*started {
        let n_threads = std::thread::available_parallelism().map_or(1, |n| n.get());
        let needed = BYTES_A_THREAD * n_threads as u64;
        ask(needed, u64::MAX)?;
        rayon::ThreadPoolBuilder::new()
            .build_global()
            .map_err(|_| FactorError::NoMemory { needed })?;
        *started = true;
    }
    Ok(())
}

/// Scratch memory, or the error that the problem is too large.
pub fn scratch(need: StackReq) -> Result<MemBuffer, FactorError> {
    MemBuffer::try_new(need).map_err(|_| FactorError::NoMemory {
        needed: need.size_bytes() as u64,
    })
}

/// A zero vector, or the error that the problem is too large.
pub fn zeros(len: usize) -> Result<Vec<f64>, FactorError> {
    let mut vector = Vec::new();
    vector
        .try_reserve_exact(len)
        .map_err(|_| FactorError::NoMemory {
            needed: 8 * len as u64,
        })?;
    vector.resize(len, 0.0);
    Ok(vector)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_allowed_and_there_is_granted() {
        assert_eq!(ask(1000, 1000), Ok(()));
        assert_eq!(ask(1001, 1000), Err(FactorError::NoMemory { needed: 1001 }));
        let impossible = 1 << 60;
        let refused = Err(FactorError::NoMemory {
            needed: impossible + PRODUCT_BYTES,
        });
        assert_eq!(ask(impossible, u64::MAX), refused);
        assert_eq!(
            ask(u64::MAX, u64::MAX),
            Err(FactorError::NoMemory { needed: u64::MAX })
        );
    }

    #[test]
    fn threads_start_once() {
        assert_eq!(start_threads(), Ok(()));
        assert_eq!(start_threads(), Ok(()));
    }
}
