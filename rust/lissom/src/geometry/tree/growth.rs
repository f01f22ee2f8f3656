//! How a tree grows: what it holds is halved, twice a node, by place where it is widest.
//!
//! Of few, both sides of a sheet, which lie in the same place, are told apart by their normals first. Of many they are
//! not: front and back of a head are far apart, and halved by place they are so too.

/// Coordinates of normals that differ by this much are those of two sides of a sheet, ...
const TWO_SIDED: f32 = 1.6;

/// ... where there are no more of them than this.
const FEW: usize = 64;

/// Triangles that are worth a thread of their own.
const WORTH_A_THREAD: usize = 4096;

/// A triangle to be sorted.
pub struct Item {
    /// Its centre and its normal.
    pub key: [f32; 6],
    /// Which one it is.
    pub triangle: u32,
}

/// What is below a node.
pub enum Branch {
    /// One of the items, ...
    Leaf,
    /// ... or at most four branches, with their items in turn.
    Node(Vec<Branch>),
}

/// Sorts the items so that each branch has its own in a row.
pub fn grow(items: &mut [Item]) -> Branch {
    if items.len() == 1 {
        return Branch::Leaf;
    }
    if items.len() <= 4 {
        return Branch::Node(items.iter().map(|_| Branch::Leaf).collect());
    }
    let middle = halve(items);
    let (first, second) = items.split_at_mut(middle);
    let quarters = |half: &mut [Item]| {
        if half.len() <= 4 {
            return vec![grow(half)];
        }
        let middle = halve(half);
        let (first, second) = half.split_at_mut(middle);
        let (a, b) = in_parallel(first, second, grow);
        vec![a, b]
    };
    let (mut children, others) = in_parallel(first, second, quarters);
    children.extend(others);
    Branch::Node(children)
}

fn in_parallel<T: Send>(a: &mut [Item], b: &mut [Item], work: impl Fn(&mut [Item]) -> T + Sync) -> (T, T) {
    if a.len() + b.len() < WORTH_A_THREAD { (work(a), work(b)) } else { rayon::join(|| work(a), || work(b)) }
}

/// Sorts the items into two groups and returns the size of the first.
fn halve(items: &mut [Item]) -> usize {
    let nothing = ([f32::INFINITY; 6], [f32::NEG_INFINITY; 6]);
    let (low, high) = items.iter().fold(nothing, |(mut low, mut high), item| {
        (0..6).for_each(|k| {
            low[k] = low[k].min(item.key[k]);
            high[k] = high[k].max(item.key[k]);
        });
        (low, high)
    });
    let widest = |axes: std::ops::Range<usize>| {
        axes.max_by(|&a, &b| (high[a] - low[a]).total_cmp(&(high[b] - low[b]))).unwrap_or_default()
    };
    let normal = widest(3..6);
    if items.len() <= FEW && high[normal] - low[normal] > TWO_SIDED {
        let between = 0.5 * (low[normal] + high[normal]);
        // Both ends are there, so neither group is empty.
        let mut count = 0;
        for k in 0..items.len() {
            if items[k].key[normal] < between {
                items.swap(k, count);
                count += 1;
            }
        }
        return count;
    }
    let axis = widest(0..3);
    // Leaves come in fours.
    let middle = (items.len() / 2 + 2) / 4 * 4;
    items.select_nth_unstable_by(middle, |a, b| a.key[axis].total_cmp(&b.key[axis]));
    middle
}
