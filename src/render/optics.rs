//! What glass does with light: Snell's law, Fresnel's equations.

use glam::DVec3;

/// The direction of the refracted ray: `direction` and `normal` are unit vectors, the normal on the side that the ray comes
/// from; `eta` is the index of refraction there over the one behind (Snell's law). None beyond the critical angle, where all
/// light is reflected.
pub(super) fn refract(direction: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let cosine = -direction.dot(normal);
    let squared = 1.0 - eta * eta * (1.0 - cosine * cosine);
    (squared >= 0.0).then(|| (direction * eta + normal * (eta * cosine - squared.sqrt())).normalize())
}

/// The share of unpolarised light that the surface of a dielectric reflects (Fresnel's equations): `cosine` of the angle of
/// incidence, `eta` as for [`refract`]. 1 beyond the critical angle.
pub(super) fn fresnel(cosine: f64, eta: f64) -> f64 {
    let cosine = cosine.clamp(0.0, 1.0);
    let squared = 1.0 - eta * eta * (1.0 - cosine * cosine);
    if squared <= 0.0 {
        return 1.0;
    }
    let behind = squared.sqrt();
    let parallel = (cosine - eta * behind) / (cosine + eta * behind);
    let perpendicular = (eta * cosine - behind) / (eta * cosine + behind);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GLASS: f64 = 1.0 / 1.5;

    #[test]
    fn known_reflectances() {
        assert!((fresnel(1.0, GLASS) - 0.04).abs() < 1e-12, "straight on: ((n − 1)/(n + 1))²");
        assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-12, "the same from inside");
        assert!((fresnel(0.0, GLASS) - 1.0).abs() < 1e-12, "grazing");
        // At Brewster's angle, tan θ = n, the parallel part vanishes: half of ((n² − 1)/(n² + 1))² is left.
        let brewster = 1.0 / (1.0_f64 + 2.25).sqrt();
        assert!((fresnel(brewster, GLASS) - 0.5 * (1.25_f64 / 3.25).powi(2)).abs() < 1e-12);
        assert_eq!(fresnel(0.7, 1.0), 0.0, "no border, no reflection");
        assert_eq!(fresnel(0.5, 1.5), 1.0, "beyond the critical angle of 41.8°");
    }

    #[test]
    fn refraction_follows_snell_and_can_be_reversed() {
        for degrees in [0.0_f64, 10.0, 45.0, 80.0] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let down = DVec3::new(sine, -cosine, 0.0);
            let bent = refract(down, DVec3::Y, GLASS).unwrap();
            assert!((bent.x - sine / 1.5).abs() < 1e-12 && bent.is_normalized());
            let back = refract(-bent, DVec3::NEG_Y, 1.5).unwrap();
            assert!((back + down).length() < 1e-12);
        }
        let grazing = DVec3::new(0.8, -0.6, 0.0);
        assert_eq!(refract(grazing, DVec3::Y, 1.5), None, "total internal reflection");
        assert!((refract(grazing, DVec3::Y, 1.0).unwrap() - grazing).length() < 1e-15);
    }
}
