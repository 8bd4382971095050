//! Sums of products of doubles with an exact sign, and the side of a line on which a point lies.
//!
//! The signs are exact unless a product of two coordinates overflows or underflows.

use nalgebra::Vector2;

/// Bound of the rounding error of a sum of two products of differences. Unit: the sum of the absolute values of the products [Shewchuk
/// 1997, § 4.2].
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// Twice the area of a triangle, with its exact sign: positive if `c` lies on the left of the way from `a` to `b`.
pub(crate) fn area(a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>) -> f64 {
    let (one, two) = ((b.x - a.x) * (c.y - a.y), (b.y - a.y) * (c.x - a.x));
    let sum = one - two;
    if sum.abs() > ROUNDING * (one.abs() + two.abs()) { sum } else { precise_area(a, b, c) }
}

/// As [`area`], but also the size is precise: the error is a few ε times the area.
pub(crate) fn precise_area(a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>) -> f64 {
    sum_of_products([(b.x, c.y), (-b.x, a.y), (-a.x, c.y), (-b.y, c.x), (b.y, a.x), (a.y, c.x)])
}

/// (b − a)·(c − a) with its exact sign: positive if `c` lies on the way from `a` to `b` or beyond it.
pub(crate) fn along(a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>) -> f64 {
    let (one, two) = ((b.x - a.x) * (c.x - a.x), (b.y - a.y) * (c.y - a.y));
    let sum = one + two;
    if sum.abs() > ROUNDING * (one.abs() + two.abs()) {
        return sum;
    }
    sum_of_products([
        (b.x, c.x),
        (-b.x, a.x),
        (-a.x, c.x),
        (a.x, a.x),
        (b.y, c.y),
        (-b.y, a.y),
        (-a.y, c.y),
        (a.y, a.y),
    ])
}

/// Σ aᵢbᵢ of up to 8 products, with an error of a few ε times its value.
fn sum_of_products<const N: usize>(products: [(f64, f64); N]) -> f64 {
    // The exact sum is that of these parts, which do not overlap and increase in size [Shewchuk 1997, Theorem 10].
    let mut parts = [0.0_f64; 16];
    let mut count = 0;
    for (a, b) in products {
        let product = a * b;
        for new in [a.mul_add(b, -product), product] {
            let mut carry = new;
            for part in &mut parts[..count] {
                let sum = carry + *part;
                let of_part = sum - carry;
                (carry, *part) = (sum, (carry - (sum - of_part)) + (*part - of_part));
            }
            parts[count] = carry;
            count += 1;
        }
    }
    parts.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_beside_a_line_by_less_than_rounding() {
        let [a, b] = [Vector2::new(0.1, 0.1), Vector2::new(0.3, 0.3)];
        for (y, sign) in [(0.2_f64, 0.0), (0.2_f64.next_up(), 1.0), (0.2_f64.next_down(), -1.0)] {
            let value = area(&a, &b, &Vector2::new(0.2, y));
            assert_eq!(if value == 0.0 { 0.0 } else { value.signum() }, sign, "{y}");
        }
    }

    #[test]
    fn the_sign_of_a_dot_product_that_rounds_to_zero() {
        let (a, b) = (Vector2::new(0.0, 0.0), Vector2::new(1.0, 1.0));
        let least = f64::EPSILON / 2.0;
        assert!(along(&a, &b, &Vector2::new(1.0, -1.0 + least)) > 0.0);
        assert!(along(&a, &b, &Vector2::new(1.0, -1.0 - 2.0 * least)) < 0.0);
        assert_eq!(along(&a, &b, &Vector2::new(1.0, -1.0)), 0.0);
        // Far from the origin the differences are rounded.
        let (far, up) = (Vector2::new(1e16, 0.0), Vector2::new(1e16 + 2.0, 1.0));
        assert!(along(&far, &up, &Vector2::new(1.0, 2e16)) > 0.0);
    }

    #[test]
    fn the_area_keeps_its_digits() {
        // (1 + ε)² − 1·(1 + 2ε) = ε²
        let (e, o) = (f64::EPSILON, Vector2::zeros());
        let value =
            precise_area(&o, &Vector2::new(1.0 + e, 1.0), &Vector2::new(1.0 + 2.0 * e, 1.0 + e));
        assert_eq!(value, e * e);
    }
}
