//! What is worth a look in a scene much larger than it: where many of its triangles are together.

use crate::geom::Aabb;
use crate::scene::Scene;
use glam::DVec3;

/// The part of the triangles that may lie outside of a core, on either side of each axis.
const STRAY: f64 = 0.025;
/// How much smaller than the scene a core must be.
const SMALL: f64 = 1.0 / 3.0;
/// A crowd has at least this share of a scene's triangles.
const LEAST_SHARE: f64 = 0.25;
/// A crowd is this share of what is in the window around it that is [`HALVINGS`] times twice as wide: nothing else is near.
const ALONE: f64 = 0.95;
/// How many halvings of a window leave a crowd whole.
const HALVINGS: usize = 2;
/// Windows are not halved further than what f32 can tell apart.
const MOST_HALVINGS: usize = 20;
/// Triangles that are looked at, of many every so-manieth.
const SAMPLE: usize = 1 << 16;

/// The box around what is worth a look: around all but the outermost triangles, if it is small in the scene's (a thing on a floor);
/// or around a crowd that is far smaller and has nothing near it (a teapot in a stadium). Else the scene's, `bounds`.
pub(super) fn crowded(scene: &Scene, bounds: &Aabb) -> Aabb {
    let boxes = scene.boxes();
    core(&boxes, bounds).or_else(|| alone(&boxes, bounds)).unwrap_or(*bounds)
}

/// The box around all but the outermost triangles, if it is small in the scene's.
fn core(boxes: &[Aabb], bounds: &Aabb) -> Option<Aabb> {
    let stray = (boxes.len() as f64 * STRAY) as usize;
    let (mut least, mut greatest) = (DVec3::ZERO, DVec3::ZERO);
    for axis in 0..3 {
        let mut centres: Vec<f64> = boxes.iter().map(|b| b.centre()[axis]).collect();
        centres.sort_unstable_by(f64::total_cmp);
        (least[axis], greatest[axis]) = (centres[stray], centres[centres.len() - 1 - stray]);
    }
    // A floor's middle can lie among them, too.
    let longest = 2.0 * (greatest - least).length();
    let inside =
        |b: &&Aabb| b.extent().length() <= longest && b.centre().cmpge(least).all() && b.centre().cmple(greatest).all();
    let core = Aabb::union_of(boxes.iter().filter(inside));
    (core.is_valid() && core.extent().length() < SMALL * bounds.extent().length()).then_some(core)
}

/// The box around a crowd of triangles that is a quarter as wide as the scene or less, with nothing near it.
///
/// Windows are halved again and again, each time to the half, quarter by quarter along each axis, that holds most triangles. A
/// surface that is cut evenly loses half of them or more each time; where two halvings in a row lose next to none, what is left is
/// a thing by itself, and the window closes around it until it would lose some.
fn alone(boxes: &[Aabb], bounds: &Aabb) -> Option<Aabb> {
    let centres = boxes.iter().step_by(boxes.len().div_ceil(SAMPLE).max(1)).map(Aabb::centre).collect();
    let windows = halved(bounds, centres);
    let kept = |from: &(Window, usize), to: &(Window, usize)| to.1 as f64 >= ALONE * from.1 as f64;
    let is_crowd = |k: usize| windows.get(k + HALVINGS).is_some_and(|inner| kept(&windows[k], inner));
    let first = (0..windows.len()).find(|&k| is_crowd(k))?;
    if (windows[first].1 as f64) < LEAST_SHARE * windows[0].1 as f64 {
        return None;
    }
    let last = (first..windows.len()).take_while(|&k| kept(&windows[first], &windows[k])).last().unwrap_or(first);
    // With the few that the last halving may have lost; but not a floor, whose middle can lie among them, too.
    let window = windows[last - 1].0;
    let inside = |b: &&Aabb| window.holds(b.centre()) && b.extent().max_element() <= window.side;
    let crowd = Aabb::union_of(boxes.iter().filter(inside));
    crowd.is_valid().then_some(crowd)
}

/// A cube.
#[derive(Clone, Copy, Debug)]
struct Window {
    low: DVec3,
    side: f64,
}

impl Window {
    fn holds(&self, p: DVec3) -> bool {
        p.cmpge(self.low).all() && p.cmple(self.low + self.side).all()
    }

    /// The half that begins so many quarters along each axis.
    fn half(&self, quarters: [usize; 3]) -> Self {
        Self { low: self.low + DVec3::from(quarters.map(|q| q as f64)) * (self.side / 4.0), side: self.side / 2.0 }
    }
}

/// A window around all, the fullest half of it, of that again the fullest half, and so on, each with how many of `centres` it
/// holds.
fn halved(bounds: &Aabb, mut centres: Vec<DVec3>) -> Vec<(Window, usize)> {
    let side = bounds.extent().max_element();
    let mut window = Window { low: bounds.centre() - side / 2.0, side };
    let mut windows = vec![(window, centres.len())];
    for _ in 0..MOST_HALVINGS {
        let mut counts = [[[0; 3]; 3]; 3];
        for p in &centres {
            // A half that begins at quarter q holds the quarters q and q + 1.
            let quarter = ((p - window.low) * (4.0 / window.side)).clamp(DVec3::ZERO, DVec3::splat(3.0));
            let halves = quarter.to_array().map(|at| (at as usize).saturating_sub(1)..=(at as usize).min(2));
            for x in halves[0].clone() {
                for y in halves[1].clone() {
                    for z in halves[2].clone() {
                        counts[x][y][z] += 1;
                    }
                }
            }
        }
        let at = |i: usize| [i / 9, i / 3 % 3, i % 3];
        let count = |i: usize| counts[at(i)[0]][at(i)[1]][at(i)[2]];
        // The middle one first: of equals it is it.
        let fullest = [13].into_iter().chain(0..27).reduce(|a, b| if count(b) > count(a) { b } else { a });
        window = window.half(at(fullest.unwrap_or(13)));
        centres.retain(|&p| window.holds(p));
        windows.push((window, centres.len()));
    }
    windows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Triangle;
    use glam::Vec3;

    /// A square of side 1 in `n` × `n` cells of two triangles, moved and scaled.
    fn sheet(n: u8, at: Vec3, scale: f32) -> Vec<Triangle> {
        let corner = |i: u8, j: u8| at + Vec3::new(f32::from(i), 0.0, f32::from(j)) * (scale / f32::from(n));
        let cell = |i, j| {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            [Triangle::new(a, b, c), Triangle::new(a, c, d)]
        };
        (0..n).flat_map(|i| (0..n).flat_map(move |j| cell(i, j))).collect()
    }

    fn found(triangles: Vec<Triangle>) -> (Aabb, Aabb) {
        let scene = Scene { triangles, ..Scene::load("gen:soup:1").unwrap() };
        (crowded(&scene, &scene.bounds()), scene.bounds())
    }

    #[test]
    fn a_small_thing_is_found_on_a_floor_of_few_triangles_or_many() {
        for cells in [1, 60] {
            for at in [Vec3::new(41.0, 0.5, 77.0), Vec3::new(50.0, 0.5, 50.0), Vec3::new(0.1, 0.5, 99.0)] {
                let thing = sheet(40, at, 0.4);
                let whole = Aabb::union_of(thing.iter().map(Triangle::aabb).collect::<Vec<_>>().iter());
                let mut triangles = sheet(cells, Vec3::ZERO, 100.0);
                triangles.extend(thing);
                let crowd = found(triangles).0;
                assert!(whole.contains(&crowd), "{cells} {at}: {crowd:?}");
                assert!(crowd.surface_area() > 0.8 * whole.surface_area(), "{cells} {at}: {crowd:?}");
            }
        }
    }

    #[test]
    fn what_is_even_few_or_not_alone_is_seen_whole() {
        let (crowd, bounds) = found(sheet(60, Vec3::ZERO, 1.0));
        assert_eq!(crowd, bounds);
        let mut few = sheet(60, Vec3::ZERO, 100.0);
        few.extend(sheet(10, Vec3::new(40.0, 0.5, 40.0), 0.4));
        let (crowd, bounds) = found(few);
        assert_eq!(crowd, bounds);
        let ball = Scene::load("gen:spheres:5000").unwrap();
        let (crowd, bounds) = found(ball.triangles);
        assert_eq!(crowd, bounds);
        let (crowd, bounds) = found(sheet(1, Vec3::ZERO, 0.0));
        assert_eq!(crowd, bounds);
    }
}
