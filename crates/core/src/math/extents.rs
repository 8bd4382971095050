//! Boxes around things in the plane, in a binary tree: those near a place are found without a look at all of them.

use nalgebra::Vector2;
use smallvec::SmallVec;

use crate::tolerance::BOX_DISTANCE;

/// A box with sides along the axes, in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extent {
    low: Vector2<f64>,
    high: Vector2<f64>,
}

impl Extent {
    pub(crate) const NOTHING: Self = Self {
        low: Vector2::new(f64::INFINITY, f64::INFINITY),
        high: Vector2::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
    };
    pub(crate) const PLANE: Self = Self { low: Self::NOTHING.high, high: Self::NOTHING.low };

    /// The smallest box with these points.
    pub(crate) fn of(points: impl IntoIterator<Item = Vector2<f64>>) -> Self {
        points
            .into_iter()
            .fold(Self::NOTHING, |all, point| all.with(&Self { low: point, high: point }))
    }

    fn with(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// The box with a margin on all sides, in m.
    pub(crate) fn grown(&self, margin: f64) -> Self {
        let margin = Vector2::repeat(margin);
        Self { low: self.low - margin, high: self.high + margin }
    }

    /// Whether two boxes have a point in common; true if a number is undefined.
    pub(crate) fn meets(&self, other: &Self) -> bool {
        self.is_over(other) && !self.is_apart(other, 1)
    }

    /// Whether a vertical line meets both boxes; true if a number is undefined.
    pub(crate) fn is_over(&self, other: &Self) -> bool {
        !self.is_apart(other, 0)
    }

    fn is_apart(&self, other: &Self, axis: usize) -> bool {
        self.low[axis] > other.high[axis] || self.high[axis] < other.low[axis]
    }

    /// Distance from a point, in m, up to its rounding error; 0 within.
    fn distance(&self, at: &Vector2<f64>) -> f64 {
        let off = |k: usize| (self.low[k] - at[k]).max(at[k] - self.high[k]).max(0.0);
        libm::hypot(off(0), off(1))
    }

    /// The largest distance of its points from this one along an axis, in m.
    fn reach(&self, at: &Vector2<f64>) -> f64 {
        (self.low - at).amax().max((self.high - at).amax())
    }

    /// The largest way·(p − from) of its points, in m.
    pub(crate) fn farthest(&self, way: &Vector2<f64>, from: &Vector2<f64>) -> f64 {
        let end = |k: usize| if way[k] < 0.0 { self.low[k] } else { self.high[k] };
        way.dot(&(Vector2::new(end(0), end(1)) - from))
    }
}

/// Node k encloses the nodes 2k and 2k + 1; the things are the last nodes, in their order, before empty ones up to a power of two.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct ExtentTree {
    nodes: Vec<Extent>,
    first: usize,
    count: usize,
}

impl ExtentTree {
    pub(crate) fn new(things: impl ExactSizeIterator<Item = Extent>) -> Self {
        let count = things.len();
        let first = count.next_power_of_two();
        let mut nodes = vec![Extent::NOTHING; 2 * first];
        nodes.splice(first..first + count, things);
        for k in (1..first).rev() {
            nodes[k] = nodes[2 * k].with(&nodes[2 * k + 1]);
        }
        Self { nodes, first, count }
    }

    /// The numbers of the things whose boxes meet this one, in order.
    pub(crate) fn meeting(&self, limits: Extent) -> impl Iterator<Item = usize> + use<'_> {
        self.of_which(move |extent| extent.meets(&limits))
    }

    /// The numbers of the things whose boxes may have a property that all boxes around them share, in order.
    pub(crate) fn of_which<F: Fn(&Extent) -> bool>(
        &self,
        may: F,
    ) -> impl Iterator<Item = usize> + use<'_, F> {
        let mut left: SmallVec<[usize; 32]> = SmallVec::new();
        left.extend((self.count > 0).then_some(1));
        std::iter::from_fn(move || {
            while let Some(k) = left.pop() {
                if !may(&self.nodes[k]) {
                    continue;
                }
                if k < self.first {
                    left.push(2 * k + 1);
                    left.push(2 * k);
                } else if k < self.first + self.count {
                    return Some(k - self.first);
                }
            }
            None
        })
    }

    /// The least value of a thing, which is at least its distance from a point (m) up to rounding.
    pub(crate) fn least(&self, at: &Vector2<f64>, value: impl Fn(usize) -> f64) -> f64 {
        let (mut least, mut left) = (f64::INFINITY, SmallVec::<[(usize, f64); 32]>::new());
        let bound = |k: usize| self.nodes[k].distance(at) * (1.0 - BOX_DISTANCE);
        left.extend((self.nodes.len() > 1).then_some((1, 0.0)));
        while let Some((k, nearest)) = left.pop() {
            if nearest > least {
                continue;
            }
            if k >= self.first {
                least = least.min(value(k - self.first));
                continue;
            }
            let mut next = [2 * k, 2 * k + 1].map(|k| (k, bound(k)));
            next.sort_by(|one, other| other.1.total_cmp(&one.1));
            left.extend(next.into_iter().filter(|(_, bound)| *bound < f64::INFINITY));
        }
        least
    }

    /// The largest distance of a thing from this point along an axis, in m.
    pub(crate) fn reach(&self, at: &Vector2<f64>) -> f64 {
        self.nodes.get(1).map_or(0.0, |all| all.reach(at))
    }

    /// The largest way·(p − from) of all things that are points, in m; −∞ if there are none.
    pub(crate) fn farthest(&self, way: &Vector2<f64>, from: &Vector2<f64>) -> f64 {
        let (mut most, mut left) = (f64::NEG_INFINITY, SmallVec::<[usize; 32]>::new());
        left.extend((self.nodes.len() > 1).then_some(1));
        while let Some(k) = left.pop() {
            let bound = self.nodes[k].farthest(way, from);
            if !(bound > most) {
                continue;
            }
            match k >= self.first {
                true => most = bound,
                false => left.extend([2 * k, 2 * k + 1]),
            }
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    #[test]
    fn those_that_meet_a_box_are_found_in_order_and_no_others() {
        let mut random = Random(3);
        for count in [0, 1, 2, 3, 7, 8, 100] {
            let mut point = || Vector2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0));
            let things: Vec<Extent> =
                (0..count).map(|_| Extent::of([point()]).grown(0.05)).collect();
            let tree = ExtentTree::new(things.iter().copied());
            for _ in 0..50 {
                let limits = Extent::of([point(), point()]);
                let met = |&k: &usize| things[k].meets(&limits);
                assert!(tree.meeting(limits).eq((0..count).filter(met)));
            }
            assert!(tree.meeting(Extent::PLANE).eq(0..count));
            assert_eq!(tree.meeting(Extent::NOTHING).count(), 0);
            let unknown = Extent::of([Vector2::repeat(0.0)]).grown(f64::NAN);
            assert!(tree.meeting(unknown).eq(0..count));
        }
    }

    #[test]
    fn the_nearest_thing_is_found() {
        let mut random = Random(5);
        for count in [1, 2, 9, 200] {
            let mut point = || Vector2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0));
            let things: Vec<Vector2<f64>> = (0..count).map(|_| point()).collect();
            let tree = ExtentTree::new(things.iter().map(|p| Extent::of([*p])));
            for _ in 0..50 {
                let at = point() * 2.0;
                let distance = |k: usize| libm::hypot(things[k].x - at.x, things[k].y - at.y);
                let all = (0..count).map(distance).fold(f64::INFINITY, f64::min);
                assert_eq!(tree.least(&at, distance), all);
            }
        }
    }

    #[test]
    fn the_farthest_point_has_the_bits_of_a_look_at_all() {
        let mut random = Random(4);
        for count in [0, 1, 5, 64, 65] {
            let mut point = || Vector2::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0));
            let things: Vec<Vector2<f64>> = (0..count).map(|_| point()).collect();
            let tree = ExtentTree::new(things.iter().map(|p| Extent::of([*p])));
            for _ in 0..50 {
                let (way, from) = (point(), point());
                let all = things.iter().map(|p| way.dot(&(p - from)));
                assert_eq!(tree.farthest(&way, &from), all.fold(f64::NEG_INFINITY, f64::max));
            }
        }
    }
}
