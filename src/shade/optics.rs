//! Mirrors and dielectrics: directions and Fresnel's equations.

use glam::Vec3;

/// `incoming` mirrored at the plane with unit normal `n`.
#[inline]
pub fn reflect(incoming: Vec3, n: Vec3) -> Vec3 {
    incoming - n * (2.0 * incoming.dot(n))
}

/// The refracted direction by Snell's law; `n` is on the side of `incoming`, `eta` = index outside / index inside,
/// seen from there. None on total internal reflection.
#[inline]
pub fn refract(incoming: Vec3, n: Vec3, eta: f32) -> Option<Vec3> {
    let cos_in = -incoming.dot(n);
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in).max(0.0);
    if sin2_out >= 1.0 {
        return None;
    }
    Some(incoming * eta + n * (eta * cos_in - (1.0 - sin2_out).sqrt()))
}

/// Reflected share of unpolarised light; `cos_in` is the cosine to the normal, `eta` as in [`refract`]. Total
/// reflection gives 1.
#[inline]
pub fn fresnel_dielectric(cos_in: f32, eta: f32) -> f32 {
    let cos_in = cos_in.clamp(0.0, 1.0);
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in);
    if sin2_out >= 1.0 {
        return 1.0;
    }
    let cos_out = (1.0 - sin2_out).sqrt();
    let parallel = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    let perpendicular = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// `direction`, turned so that it does not leave into the surface whose unit geometric normal is `n`: interpolated
/// normals can send a mirror ray below the horizon.
#[inline]
pub fn above(direction: Vec3, n: Vec3) -> Vec3 {
    let height = direction.dot(n);
    if height > 0.0 { direction } else { (direction - n * (1.001 * height)).normalize_or(n) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_at_normal_incidence_at_brewster_and_beyond_the_critical_angle() {
        let at_normal = ((1.5f32 - 1.0) / 2.5).powi(2);
        assert!((fresnel_dielectric(1.0, 1.0 / 1.5) - at_normal).abs() < 1e-6);
        assert!((fresnel_dielectric(1.0, 1.5) - at_normal).abs() < 1e-6);
        assert_eq!(fresnel_dielectric(0.0, 1.0 / 1.5), 1.0);
        // At Brewster's angle parallel light is not reflected; what is left is half the perpendicular share.
        let brewster = 1.5f32.atan();
        let perpendicular = (2.0 * brewster).cos().powi(2);
        assert!((fresnel_dielectric(brewster.cos(), 1.0 / 1.5) - 0.5 * perpendicular).abs() < 1e-6);
        let critical = (1.0f32 / 1.5).asin();
        assert_eq!(fresnel_dielectric((critical + 0.001).cos(), 1.5), 1.0);
        assert!(fresnel_dielectric((critical - 0.01).cos(), 1.5) < 1.0);
    }

    #[test]
    fn refraction_obeys_snell_and_keeps_the_plane() {
        let n = Vec3::Y;
        for degrees in [0.0f32, 10.0, 45.0, 80.0] {
            let a = degrees.to_radians();
            let d = Vec3::new(a.sin(), -a.cos(), 0.0);
            let t = refract(d, n, 1.0 / 1.5).unwrap();
            assert!((t.length() - 1.0).abs() < 1e-6 && t.z == 0.0);
            assert!((t.x - a.sin() / 1.5).abs() < 1e-6 && t.y < 0.0);
            // Reversed light takes the same way.
            let back = refract(-t, -n, 1.5).unwrap();
            assert!((back + d).length() < 1e-5);
        }
        let steep = Vec3::new(0.8, -0.6, 0.0);
        assert!(refract(steep, n, 1.5).is_none(), "0.8 · 1.5 > 1");
        assert_eq!(reflect(steep, n), Vec3::new(0.8, 0.6, 0.0));
    }

    #[test]
    fn directions_are_lifted_above_the_surface() {
        let d = above(Vec3::new(0.9, -0.1, 0.0).normalize(), Vec3::Y);
        assert!(d.y > 0.0 && (d.length() - 1.0).abs() < 1e-6);
        assert_eq!(above(Vec3::Y, Vec3::Y), Vec3::Y);
    }
}
