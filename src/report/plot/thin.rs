//! Fewer points that look the same.

/// How far a curve may be off where points are left out, in units of the grid.
const OFF: f64 = 2.0;

/// Of points on a grid of whole numbers those that carry the picture: what lies on a straight line between others goes; of
/// what is still more than `most`, the lowest and highest of each column stay, so that a spike of one sample is seen.
pub(super) fn thin(points: &[(f64, f64)], most: usize, width: f64) -> Vec<(i64, i64)> {
    let straight = straightened(points);
    let kept = if straight.len() > most { columns(points, (most / 2).max(1), width) } else { straight };
    let mut whole: Vec<(i64, i64)> = kept.into_iter().map(|(x, y)| (x.round() as i64, y.round() as i64)).collect();
    whole.dedup();
    whole
}

/// Without points that are no further than [`OFF`] from the line that is drawn past them.
fn straightened(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let Some(&first) = points.first() else { return Vec::new() };
    let (mut kept, mut anchor, mut before) = (vec![first], first, first);
    let open = (f64::NEG_INFINITY, f64::INFINITY);
    let mut cone = open;
    let slope = |from: (f64, f64), to: (f64, f64), off: f64| (to.1 + off - from.1) / (to.0 - from.0);
    for &point in &points[1..] {
        let steep = point.0 <= before.0;
        let direction = slope(anchor, point, 0.0);
        if before != anchor && (steep || direction < cone.0 || direction > cone.1) {
            kept.push(before);
            (anchor, cone) = (before, open);
        }
        if point.0 > anchor.0 {
            cone = (cone.0.max(slope(anchor, point, -OFF)), cone.1.min(slope(anchor, point, OFF)));
        } else {
            kept.push(point);
            (anchor, cone) = (point, open);
        }
        before = point;
    }
    if kept.last() != Some(&before) {
        kept.push(before);
    }
    kept
}

/// The lowest and highest point of each column, in their order, and both ends.
fn columns(points: &[(f64, f64)], count: usize, width: f64) -> Vec<(f64, f64)> {
    let column = |point: &(f64, f64)| (point.0 / width * count as f64).floor();
    let mut kept = Vec::new();
    for group in points.chunk_by(|a, b| column(a) == column(b)) {
        let by_height = |a: &usize, b: &usize| group[*a].1.total_cmp(&group[*b].1);
        let low = (0..group.len()).min_by(by_height).unwrap_or(0);
        let high = (0..group.len()).max_by(by_height).unwrap_or(0);
        kept.push(group[low.min(high)]);
        if low != high {
            kept.push(group[low.max(high)]);
        }
    }
    let ends = [points.first(), points.last()];
    if let [Some(&first), Some(&last)] = ends {
        if kept.first() != Some(&first) {
            kept.insert(0, first);
        }
        if kept.last() != Some(&last) {
            kept.push(last);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_is_two_points_and_a_corner_stays() {
        let line: Vec<(f64, f64)> = (0..1000).map(|k| (f64::from(k), f64::from(k) * 0.5)).collect();
        assert_eq!(thin(&line, 5000, 1000.0), [(0, 0), (999, 500)]);
        let roof: Vec<(f64, f64)> = (0..1000_i32).map(|k| (f64::from(k), f64::from((k - 500).abs()))).collect();
        let kept = thin(&roof, 5000, 1000.0);
        assert!(kept.len() <= 5 && kept.iter().any(|&(x, y)| (x - 500).abs() <= 3 && y <= 3), "{kept:?}");
    }

    #[test]
    fn no_kept_line_is_further_off_than_allowed() {
        let wave: Vec<(f64, f64)> = (0..4000).map(|k| (f64::from(k), 900.0 * (f64::from(k) * 0.01).sin())).collect();
        let kept = straightened(&wave);
        assert!(kept.len() < 600, "{}", kept.len());
        for pair in kept.windows(2) {
            for &(x, y) in wave.iter().filter(|point| (pair[0].0..=pair[1].0).contains(&point.0)) {
                let on = pair[0].1 + (x - pair[0].0) / (pair[1].0 - pair[0].0) * (pair[1].1 - pair[0].1);
                assert!((on - y).abs() <= OFF + 1e-9, "{x}: {on} for {y}");
            }
        }
    }

    #[test]
    fn a_spike_in_noise_stays() {
        let rough = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 24);
        let mut points: Vec<(f64, f64)> = (0..50_000).map(|k| (f64::from(k) / 5.0, rough(k))).collect();
        points[23_457].1 = 4000.0;
        let kept = thin(&points, 2000, 10_000.0);
        assert!(kept.len() <= 2002 && kept.iter().any(|point| point.1 == 4000), "{}", kept.len());
    }
}
