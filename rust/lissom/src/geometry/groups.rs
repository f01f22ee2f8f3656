//! Connected groups: what pairs hang together.

use super::rows::Rows;

/// The groups that `0..count` falls into, numbered by their first member.
#[derive(Debug, Clone)]
pub struct Groups {
    of: Vec<u32>,
    count: usize,
}

impl Groups {
    /// Joins `pairs` of `0..count`.
    pub fn joining(count: usize, pairs: impl IntoIterator<Item = [u32; 2]>) -> Self {
        fn root(parent: &mut [u32], mut v: u32) -> u32 {
            while parent[v as usize] != v {
                parent[v as usize] = parent[parent[v as usize] as usize];
                v = parent[v as usize];
            }
            v
        }
        let mut parent: Vec<u32> = (0..count as u32).collect();
        for [a, b] in pairs {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            // The lower one is the root, so that it is the first member.
            parent[a.max(b) as usize] = a.min(b);
        }
        let (mut of, mut groups) = (vec![0; count], 0);
        for v in 0..count as u32 {
            let first = root(&mut parent, v);
            if first == v {
                of[v as usize] = groups;
                groups += 1;
            } else {
                of[v as usize] = of[first as usize];
            }
        }
        Self { of, count: groups as usize }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The group of each element.
    pub fn of(&self) -> &[u32] {
        &self.of
    }

    /// The elements of each group, ascending.
    pub fn members(&self) -> Rows<u32> {
        Rows::sort(self.count, self.of.iter().copied().zip(0u32..))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_numbered_by_their_first_member() {
        let groups = Groups::joining(6, [[5, 1], [4, 2], [2, 5]]);
        assert_eq!((groups.of(), groups.count()), (&[0, 1, 1, 2, 1, 1][..], 3));
        assert_eq!(groups.members().of(1), [1, 2, 4, 5]);
    }
}
