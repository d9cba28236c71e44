//! Patterns of materials: how light or dark a surface is from place to place, made by code as the page's (`viewer/src/view/textures.ts`; the
//! names are those of `surfaces.ts` beside it).

use std::f64::consts::TAU;
use std::sync::LazyLock;

/// Texels along the edge of a pattern.
const EDGE: usize = 256;
/// Exponent by which screens show light (sRGB, about). A pattern is of light, colours are of the screen.
const GAMMA: f64 = 2.2;
/// Part of a pattern's edge that looks half as strong once it is no larger than a sample.
const DETAIL: f64 = 1.0 / 64.0;

/// A pattern that repeats.
pub(crate) struct Pattern {
    /// Edge of what it covers, m.
    pub(crate) tile: f64,
    /// Deviations of the texels' brightness from the mean, as parts of it.
    texels: Vec<f32>,
}

impl Pattern {
    fn new(tile: f64, shade: impl Fn(f64, f64) -> f64) -> Self {
        let part = |index: usize| index as f64 / EDGE as f64;
        let lights: Vec<f64> =
            (0..EDGE * EDGE).map(|at| shade(part(at % EDGE), part(at / EDGE)).clamp(0.0, 1.0)).collect();
        let mean = lights.iter().sum::<f64>() / lights.len() as f64;
        Self { tile, texels: lights.iter().map(|light| ((light / mean - 1.0) / GAMMA) as f32).collect() }
    }

    /// Returns the pattern of a material by its name.
    pub(crate) fn of(material: &str) -> Option<&'static Self> {
        let name = material.to_lowercase();
        let (_, pattern) = NAMED.iter().find(|(names, _)| names.iter().any(|known| name.contains(known)))?;
        pattern.map(|pattern| &**pattern)
    }

    /// Returns the factor of the brightness at a place on the surface, m, along the grain and across. A sample covers `breadth`, m.
    pub(crate) fn factor(&self, [along, across]: [f64; 2], breadth: f64) -> f64 {
        let [u, v] = [along, across].map(|at| (at / self.tile - (at / self.tile).floor()) * EDGE as f64);
        let [left, top] = [u, v].map(|at| at.floor() as usize);
        let texel = |column: usize, row: usize| {
            self.texels.get(row % EDGE * EDGE + column % EDGE).copied().map_or(0.0, f64::from)
        };
        let (right, down) = (u - left as f64, v - top as f64);
        let mix = |one: f64, other: f64, part: f64| one + (other - one) * part;
        let row = |row: usize| mix(texel(left, row), texel(left + 1, row), right);
        let lost = breadth / (self.tile * DETAIL);
        1.0 + mix(row(top), row(top + 1), down) / (1.0 + lost * lost)
    }
}

/// Returns a number of 0 to 1 that belongs to a point of a lattice.
fn random(x: u32, y: u32, seed: u32) -> f64 {
    let bits = x.wrapping_mul(374_761_393) ^ y.wrapping_mul(668_265_263) ^ seed.wrapping_mul(2_147_483_647);
    let bits = (bits ^ (bits >> 13)).wrapping_mul(1_274_126_177);
    f64::from(bits ^ (bits >> 16)) / f64::from(u32::MAX)
}

/// Returns smooth noise of 0 to 1 that repeats after so many cells along u and v.
fn noise(u: f64, v: f64, [cells_u, cells_v]: [u32; 2], seed: u32) -> f64 {
    let (x, y) = (u * f64::from(cells_u), v * f64::from(cells_v));
    let (left, top) = (x.floor(), y.floor());
    let smooth = |part: f64| part * part * (3.0 - 2.0 * part);
    let (right, down) = (smooth(x - left), smooth(y - top));
    let at = |i: u32, j: u32| random((left as u32 + i) % cells_u, (top as u32 + j) % cells_v, seed);
    let upper = at(0, 0) + (at(1, 0) - at(0, 0)) * right;
    let lower = at(0, 1) + (at(1, 1) - at(0, 1)) * right;
    upper + (lower - upper) * down
}

/// Returns blotches of several sizes.
fn cloudy(u: f64, v: f64) -> f64 {
    0.45 * noise(u, v, [5; 2], 1) + 0.3 * noise(u, v, [13; 2], 2) + 0.25 * noise(u, v, [37; 2], 3)
}

fn grains(u: f64, v: f64, seed: u32) -> f64 {
    noise(u, v, [256; 2], seed)
}

static CONCRETE: LazyLock<Pattern> = LazyLock::new(|| {
    Pattern::new(3.0, |u, v| {
        let pore = if grains(u, v, 5) > 0.985 { 0.16 } else { 0.0 };
        0.86 + 0.1 * (cloudy(u, v) - 0.5) + 0.07 * (grains(u, v, 4) - 0.5) - pore
    })
});
static WOOD: LazyLock<Pattern> = LazyLock::new(|| {
    Pattern::new(1.6, |u, v| {
        let bend = v + 0.03 * noise(u, v, [3, 4], 7);
        let rings = 0.5 + 0.5 * libm::sin(TAU * (9.0 * bend + 1.5 * noise(u, v, [2, 6], 8)));
        0.86 + 0.09 * (rings - 0.5) + 0.12 * (noise(u, v, [10, 128], 9) - 0.5)
    })
});
static CARPET: LazyLock<Pattern> = LazyLock::new(|| {
    Pattern::new(0.8, |u, v| 0.8 + 0.26 * (grains(u, v, 11) - 0.5) + 0.14 * (noise(u, v, [128, 64], 12) - 0.5))
});
static METAL: LazyLock<Pattern> = LazyLock::new(|| {
    Pattern::new(0.5, |u, v| 0.9 + 0.1 * (noise(u, v, [4, 256], 13) - 0.5) + 0.04 * (noise(u, v, [3; 2], 14) - 0.5))
});
static SAND: LazyLock<Pattern> =
    LazyLock::new(|| Pattern::new(1.2, |u, v| 0.84 + 0.12 * (cloudy(u, v) - 0.5) + 0.2 * (grains(u, v, 15) - 0.5)));
static ICE: LazyLock<Pattern> = LazyLock::new(|| {
    Pattern::new(2.5, |u, v| {
        let crack = if (noise(u, v, [4; 2], 16) - 0.5).abs() < 0.008 { 0.08 } else { 0.0 };
        0.93 + 0.08 * (cloudy(u, v) - 0.5) - crack
    })
});
static RUBBER: LazyLock<Pattern> = LazyLock::new(|| Pattern::new(0.3, |u, v| 0.9 + 0.12 * (grains(u, v, 17) - 0.5)));

/// Parts of the names of materials, and their patterns: the first that fits. Others are like concrete.
const NAMED: [(&[&str], Option<&LazyLock<Pattern>>); 9] = [
    (&["ice", "acrylic", "glass", "perspex"], Some(&ICE)),
    (&["wood", "ply", "board", "mdf", "osb", "timber", "parquet"], Some(&WOOD)),
    (&["carpet", "felt", "cloth", "grass", "foam"], Some(&CARPET)),
    (&["alumin", "steel", "metal", "iron", "brass", "copper"], Some(&METAL)),
    (&["rubber", "tyre", "tire", "roller"], Some(&RUBBER)),
    (&["sand", "gravel", "soil", "earth", "dirt", "mulch"], Some(&SAND)),
    (&["plastic", "nylon", "pvc", "abs", "polyamide", "delrin"], None),
    (&["concrete", "stone", "brick", "asphalt", "tile", "cement"], Some(&CONCRETE)),
    (&[""], Some(&CONCRETE)),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_repeat_with_a_mean_of_one_and_fade_from_afar() {
        for name in ["concrete", "plywood", "Carpet", "aluminium", "sand", "cast-acrylic", "rubber-tyre", "anything"] {
            let pattern = Pattern::of(name).expect(name);
            let places =
                || (0..40_000).map(|at| [at % 200, at / 200].map(|part| pattern.tile * f64::from(part) / 200.0));
            let factors: Vec<f64> = places().map(|place| pattern.factor(place, 0.0)).collect();
            let mean = factors.iter().sum::<f64>() / factors.len() as f64;
            assert!((mean - 1.0).abs() < 0.002, "{name}: {mean}");
            let [least, most] = [f64::min, f64::max].map(|pick| factors.iter().copied().fold(1.0, pick));
            assert!(least > 0.7 && most < 1.3 && most - least > 0.03, "{name}: {least} to {most}");
            for (place, factor) in places().zip(&factors).step_by(997) {
                let again = pattern.factor(place.map(|at| at - 3.0 * pattern.tile), 0.0);
                assert!((factor - again).abs() < 1e-6, "{name}: {factor} and {again}");
                assert!((pattern.factor(place, 10.0 * pattern.tile) - 1.0).abs() < 1e-4, "{name}");
            }
        }
        assert!(Pattern::of("nylon").is_none());
    }
}
