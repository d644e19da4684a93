//! A file that grows by whole commits: a write that fails leaves nothing half-written behind.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};

/// Collects bytes in memory; `flush` puts them into the file, all or none.
pub struct Store {
    file: File,
    /// Length of the file: the end of the last commit \[bytes\].
    committed: u64,
    pending: Vec<u8>,
    /// After a failed commit the file is somebody else's to repair: nothing more is written.
    failed: bool,
}

impl Store {
    /// Appends to a file from `committed` on.
    pub fn new(mut file: File, committed: u64) -> io::Result<Self> {
        file.seek(SeekFrom::Start(committed))?;
        Ok(Self {
            file,
            committed,
            pending: vec![],
            failed: false,
        })
    }
}

impl Write for Store {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.pending.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.failed {
            return Err(io::Error::other("an earlier write to this file failed"));
        }
        let pending = std::mem::take(&mut self.pending);
        let result = self.file.write_all(&pending);
        match result {
            Ok(()) => self.committed += pending.len() as u64,
            Err(_) => {
                self.failed = true;
                // Best effort: the error that counts is the first one.
                let _ = self.file.set_len(self.committed);
            }
        }
        result
    }
}
