//! Symmetric sparse matrices with a pattern that is built once and values that are summed in a fixed order.

/// Slot of an entry that is not stored: a degree of freedom is prescribed.
pub const NO_SLOT: u32 = u32::MAX;

/// Lower triangle of a symmetric matrix in compressed columns.
#[derive(Clone, Debug)]
pub struct Pattern {
    column_starts: Vec<u32>,
    rows: Vec<u32>,
}

impl Pattern {
    /// The pattern that couples all degrees of freedom within each group, each diagonal entry included.
    /// Entries of a group that equal [`NO_SLOT`] are skipped.
    pub fn from_groups<'a>(size: usize, groups: impl Iterator<Item = &'a [u32]> + Clone) -> Self {
        let mut columns: Vec<Vec<u32>> = (0..size as u32).map(|i| vec![i]).collect();
        for group in groups {
            for &column in group.iter().filter(|&&i| i != NO_SLOT) {
                let below = group.iter().filter(|&&i| i != NO_SLOT && i > column);
                columns[column as usize].extend(below);
            }
        }
        let mut column_starts = vec![0u32];
        let mut rows = vec![];
        for mut column in columns {
            column.sort_unstable();
            column.dedup();
            rows.extend_from_slice(&column);
            column_starts.push(rows.len() as u32);
        }
        Self {
            column_starts,
            rows,
        }
    }

    /// Number of rows and columns.
    pub fn size(&self) -> usize {
        self.column_starts.len() - 1
    }

    /// Number of stored entries.
    pub fn entries(&self) -> usize {
        self.rows.len()
    }

    /// Column starts, shape \[size + 1\].
    pub fn column_starts(&self) -> &[u32] {
        &self.column_starts
    }

    /// Row of each entry, sorted within a column.
    pub fn rows(&self) -> &[u32] {
        &self.rows
    }

    /// Index into the values of entry (i, j) or (j, i); [`NO_SLOT`] if either is prescribed or not stored.
    pub fn slot(&self, i: u32, j: u32) -> u32 {
        if i == NO_SLOT || j == NO_SLOT {
            return NO_SLOT;
        }
        let (row, column) = (i.max(j), i.min(j) as usize);
        let (start, end) = (
            self.column_starts[column] as usize,
            self.column_starts[column + 1] as usize,
        );
        match self.rows[start..end].binary_search(&row) {
            Ok(k) => (start + k) as u32,
            Err(_) => NO_SLOT,
        }
    }

    /// The same entries as an upper triangle in compressed columns.
    pub fn upper(&self) -> Self {
        let mut columns: Vec<Vec<u32>> = vec![vec![]; self.size()];
        for column in 0..self.size() {
            let range =
                self.column_starts[column] as usize..self.column_starts[column + 1] as usize;
            for &row in &self.rows[range] {
                columns[row as usize].push(column as u32);
            }
        }
        let mut column_starts = vec![0u32];
        for column in &columns {
            column_starts.push(column_starts[column_starts.len() - 1] + column.len() as u32);
        }
        Self {
            column_starts,
            rows: columns.concat(),
        }
    }
}
