//! Compressed rows: items sorted by the row that they belong to.

/// Items row by row, those of one row in the order in which they were given.
#[derive(Debug, Clone)]
pub struct Rows<T> {
    start: Vec<u32>,
    items: Vec<T>,
}

impl<T: Copy> Rows<T> {
    /// Sorts `(row, item)` of `count` rows by counting: two passes, no comparison.
    ///
    /// # Panics
    ///
    /// Where a row is not below `count`.
    pub fn sort(count: usize, items: impl Iterator<Item = (u32, T)> + Clone) -> Self {
        let mut start = vec![0u32; count + 1];
        items.clone().for_each(|(row, _)| start[row as usize + 1] += 1);
        for row in 0..count {
            start[row + 1] += start[row];
        }
        let mut next = start.clone();
        let Some((_, any)) = items.clone().next() else { return Self { start, items: Vec::new() } };
        let mut sorted = vec![any; start[count] as usize];
        items.for_each(|(row, item)| {
            let place = &mut next[row as usize];
            sorted[*place as usize] = item;
            *place += 1;
        });
        Self { start, items: sorted }
    }

    /// How many rows there are.
    pub fn count(&self) -> usize {
        self.start.len() - 1
    }

    /// The items of one row.
    #[inline]
    pub fn of(&self, row: usize) -> &[T] {
        &self.items[self.range(row)]
    }

    /// The same, to write.
    pub fn of_mut(&mut self, row: usize) -> &mut [T] {
        let range = self.range(row);
        &mut self.items[range]
    }

    /// The rows, one after another.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[T]> + '_ {
        (0..self.count()).map(|row| self.of(row))
    }

    #[inline]
    fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.start[row] as usize..self.start[row + 1] as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_keep_their_order_within_rows() {
        let items = [(2, 'a'), (0, 'b'), (2, 'c'), (0, 'd'), (3, 'e')];
        let rows = Rows::sort(5, items.into_iter());
        let found: Vec<String> = rows.iter().map(|row| row.iter().collect()).collect();
        assert_eq!(found, ["bd", "", "ac", "e", ""]);
        assert_eq!(Rows::<u8>::sort(2, std::iter::empty()).of(1), []);
    }
}
