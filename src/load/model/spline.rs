//! Kochanek–Bartels splines through positions, and their counterpart on unit quaternions.
//!
//! Kochanek, Bartels, "Interpolating Splines with Local Tension, Continuity, and Bias Control" (SIGGRAPH 1984),
//! eq. 8–11, with the correction for unevenly spaced keys as BART applies it: a tangent is scaled by twice the share
//! that its segment has in the two segments around the key. The first and the last key are never reached; they only
//! shape the tangents, and time is clamped to the keys between them.
//!
//! Rotations follow the same scheme with logarithms of quotients in place of differences, and Shoemake's
//! squad ("Animating Rotation with Quaternion Curves", SIGGRAPH 1985) in place of the cubic. As in BART, two
//! neighbouring keys are joined by the shorter arc, whatever number of turns their angles differ by: keys at 0° and 720°
//! do not turn at all, keys at 350° and 370° turn by 20°, keys at −180° and 180° are the same. When two keys are half a turn
//! apart, both arcs are equally short and the one in the direction of the growing angle is taken.
//!
//! Keys whose time lies before that of an earlier key can never be reached and are left out
//! (a search for the first segment that ends after t never finds them). Equal times make a cut.

use glam::{DQuat, DVec3};

/// Tension, continuity and bias at a key; all zero gives a Catmull–Rom spline.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tcb {
    pub tension: f64,
    pub continuity: f64,
    pub bias: f64,
}

impl Tcb {
    /// Weights of (the difference before, the difference after) in the tangent that leaves the key.
    fn outgoing(&self) -> (f64, f64) {
        let (t, c, b) = (self.tension, self.continuity, self.bias);
        (0.5 * (1.0 - t) * (1.0 + c) * (1.0 + b), 0.5 * (1.0 - t) * (1.0 - c) * (1.0 - b))
    }

    /// Weights of (the difference before, the difference after) in the tangent that arrives at the key.
    fn incoming(&self) -> (f64, f64) {
        let (t, c, b) = (self.tension, self.continuity, self.bias);
        (0.5 * (1.0 - t) * (1.0 - c) * (1.0 + b), 0.5 * (1.0 - t) * (1.0 + c) * (1.0 - b))
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionKey {
    pub time: f64,
    pub value: DVec3,
    pub tcb: Tcb,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationKey {
    pub time: f64,
    pub axis: DVec3,
    pub degrees: f64,
    pub tcb: Tcb,
}

/// Least number of keys of a spline: two are reached, two shape the tangents.
pub const MIN_KEYS: usize = 4;

trait Key: Copy {
    fn time(&self) -> f64;
}

impl Key for PositionKey {
    fn time(&self) -> f64 {
        self.time
    }
}

impl Key for RotationKey {
    fn time(&self) -> f64 {
        self.time
    }
}

/// The keys that time reaches, in order.
fn reachable<K: Key>(keys: &[K]) -> Vec<K> {
    let mut latest = f64::NEG_INFINITY;
    keys.iter()
        .copied()
        .filter(|key| {
            let reached = key.time() >= latest;
            latest = latest.max(key.time());
            reached
        })
        .collect()
}

/// Twice the share of the segment [b, c] in [a, c]; 1 for even spacing.
fn spacing(segment: f64, both: f64) -> f64 {
    if both > 0.0 { 2.0 * segment / both } else { 1.0 }
}

/// Piece of a curve that is valid from `start` to `end`.
#[derive(Clone, Debug)]
struct Segment<C> {
    start: f64,
    end: f64,
    curve: C,
}

/// The segment for `time` and how far into it, 0 to 1; time is clamped to the first start and the last end.
fn locate<C>(segments: &[Segment<C>], time: f64) -> Option<(&C, f64)> {
    let i = segments.partition_point(|s| s.end <= time).min(segments.len().checked_sub(1)?);
    let s = &segments[i];
    Some((&s.curve, ((time - s.start) / (s.end - s.start)).clamp(0.0, 1.0)))
}

/// Cubic Hermite spline in the power basis: c0 + u (c1 + u (c2 + u c3)).
#[derive(Clone, Debug)]
pub struct PositionSpline {
    segments: Vec<Segment<[DVec3; 4]>>,
    /// Value when there is no segment of positive length.
    rest: DVec3,
}

impl PositionSpline {
    /// At least `MIN_KEYS` keys are expected; with fewer the curve rests at its first inner key.
    pub fn new(keys: &[PositionKey]) -> Self {
        let keys = reachable(keys);
        let segments = keys
            .windows(MIN_KEYS)
            .filter(|k| k[2].time > k[1].time)
            .map(|k| {
                let length = k[2].time - k[1].time;
                let delta = k[2].value - k[1].value;
                let (before, after) = k[1].tcb.outgoing();
                let leaving =
                    (before * (k[1].value - k[0].value) + after * delta) * spacing(length, k[2].time - k[0].time);
                let (before, after) = k[2].tcb.incoming();
                let arriving =
                    (before * delta + after * (k[3].value - k[2].value)) * spacing(length, k[3].time - k[1].time);
                let curve =
                    [k[1].value, leaving, 3.0 * delta - 2.0 * leaving - arriving, -2.0 * delta + leaving + arriving];
                Segment { start: k[1].time, end: k[2].time, curve }
            })
            .collect();
        let rest = keys.get(1).or(keys.first()).map_or(DVec3::ZERO, |k| k.value);
        Self { segments, rest }
    }

    pub fn at(&self, time: f64) -> DVec3 {
        match locate(&self.segments, time) {
            Some((c, u)) => c[0] + u * (c[1] + u * (c[2] + u * c[3])),
            None => self.rest,
        }
    }
}

/// Two ends and two inner control rotations of a squad.
#[derive(Clone, Copy, Debug)]
struct Squad {
    p: DQuat,
    a: DQuat,
    b: DQuat,
    q: DQuat,
}

#[derive(Clone, Debug)]
pub struct RotationSpline {
    segments: Vec<Segment<Squad>>,
    rest: DQuat,
}

impl RotationSpline {
    /// At least `MIN_KEYS` keys are expected; with fewer the curve rests at its first inner key.
    pub fn new(keys: &[RotationKey]) -> Self {
        let keys = reachable(keys);
        let rotations = short_arcs(&keys);
        let segments = keys
            .windows(MIN_KEYS)
            .zip(rotations.windows(MIN_KEYS))
            .filter(|(k, _)| k[2].time > k[1].time)
            .map(|(k, q)| {
                let length = k[2].time - k[1].time;
                let delta = log(q[1].conjugate() * q[2]);
                let (before, after) = k[1].tcb.outgoing();
                let leaving =
                    (before * log(q[0].conjugate() * q[1]) + after * delta) * spacing(length, k[2].time - k[0].time);
                let (before, after) = k[2].tcb.incoming();
                let arriving =
                    (before * delta + after * log(q[2].conjugate() * q[3])) * spacing(length, k[3].time - k[1].time);
                let curve = Squad {
                    p: q[1],
                    a: q[1] * exp(0.5 * (leaving - delta)),
                    b: q[2] * exp(0.5 * (delta - arriving)),
                    q: q[2],
                };
                Segment { start: k[1].time, end: k[2].time, curve }
            })
            .collect();
        let rest = rotations.get(1).or(rotations.first()).copied().unwrap_or(DQuat::IDENTITY);
        Self { segments, rest }
    }

    pub fn at(&self, time: f64) -> DQuat {
        match locate(&self.segments, time) {
            Some((s, u)) => slerp(slerp(s.p, s.q, u), slerp(s.a, s.b, u), 2.0 * u * (1.0 - u)).normalize(),
            None => self.rest,
        }
    }
}

/// Rotations of the keys, with signs such that neighbours are joined by the shorter arc.
fn short_arcs(keys: &[RotationKey]) -> Vec<DQuat> {
    let mut rotations: Vec<DQuat> = Vec::with_capacity(keys.len());
    // Whether the rotation before was negated. At half a turn the sign of the dot product is noise: keeping the
    // relative sign of the unaltered quaternions turns in the direction of the growing angle.
    let mut negated = false;
    for key in keys {
        let raw = match key.axis.try_normalize() {
            Some(axis) => DQuat::from_axis_angle(axis, key.degrees.to_radians()),
            None => DQuat::IDENTITY,
        };
        if let Some(before) = rotations.last() {
            let dot = before.dot(raw);
            if dot.abs() > 1e-9 {
                negated = dot < 0.0;
            }
        }
        rotations.push(if negated { -raw } else { raw });
    }
    rotations
}

/// Half the rotation vector (axis × half angle, half angle in [0, π]) of a unit quaternion.
fn log(q: DQuat) -> DVec3 {
    let v = q.xyz();
    let sine = v.length();
    if sine < 1e-12 { v } else { v * (sine.atan2(q.w) / sine) }
}

fn exp(v: DVec3) -> DQuat {
    let angle = v.length();
    let scale = if angle < 1e-12 { 1.0 } else { angle.sin() / angle };
    DQuat::from_vec4((v * scale).extend(angle.cos()))
}

/// Great arc from `p` to `q` as they are, without choosing the shorter one.
fn slerp(p: DQuat, q: DQuat, t: f64) -> DQuat {
    p * exp(t * log(p.conjugate() * q))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rot(time: f64, degrees: f64) -> RotationKey {
        RotationKey { time, axis: DVec3::Z, degrees, tcb: Tcb::default() }
    }

    fn pos(time: f64, x: f64) -> PositionKey {
        PositionKey { time, value: DVec3::X * x, tcb: Tcb::default() }
    }

    /// Angle about z in degrees, −180 to 180.
    fn angle(q: DQuat) -> f64 {
        let x = q * DVec3::X;
        x.y.atan2(x.x).to_degrees()
    }

    #[test]
    fn passes_through_inner_keys_and_clamps_outside() {
        let keys = [pos(0.0, 9.0), pos(1.0, 2.0), pos(2.5, 4.0), pos(3.0, -1.0), pos(9.0, 100.0)];
        let s = PositionSpline::new(&keys);
        for k in &keys[1..4] {
            assert!((s.at(k.time) - k.value).length() < 1e-12);
        }
        assert_eq!(s.at(-5.0), s.at(1.0));
        assert_eq!(s.at(99.0), s.at(3.0));
    }

    #[test]
    fn evenly_spaced_line_has_constant_speed() {
        let s = PositionSpline::new(&[pos(0.0, 0.0), pos(1.0, 1.0), pos(2.0, 2.0), pos(3.0, 3.0)]);
        assert!((s.at(1.25).x - 1.25).abs() < 1e-12);
        let r = RotationSpline::new(&[rot(0.0, 0.0), rot(1.0, 10.0), rot(2.0, 20.0), rot(3.0, 30.0)]);
        assert!((angle(r.at(1.3)) - 13.0).abs() < 1e-9);
    }

    #[test]
    fn uneven_keys_keep_the_velocity_continuous() {
        let s = PositionSpline::new(&[pos(0.0, 0.0), pos(1.0, 1.0), pos(1.2, 3.0), pos(4.0, 2.0), pos(6.0, 5.0)]);
        let h = 1e-6;
        let before = (s.at(1.2) - s.at(1.2 - h)) / h;
        let after = (s.at(1.2 + h) - s.at(1.2)) / h;
        assert!((before - after).length() < 1e-3 * before.length(), "{before} {after}");
    }

    #[test]
    fn full_tension_stops_at_the_key() {
        let mut keys = [pos(0.0, 0.0), pos(1.0, 1.0), pos(2.0, 5.0), pos(3.0, 3.0), pos(4.0, 0.0)];
        keys[2].tcb.tension = 1.0;
        let s = PositionSpline::new(&keys);
        assert!((s.at(2.0 + 1e-6) - s.at(2.0)).length() < 1e-9);
        // Bias 1 leaves the key in the direction of the segment before it.
        keys[2].tcb = Tcb { bias: 1.0, ..Tcb::default() };
        let s = PositionSpline::new(&keys);
        assert!(s.at(2.01).x > 5.0, "overshoots the key");
    }

    #[test]
    fn angles_beyond_half_a_turn_take_the_shorter_arc() {
        let r = RotationSpline::new(&[rot(0.0, 180.0), rot(1.0, 350.0), rot(2.0, 370.0), rot(3.0, 540.0)]);
        assert!(angle(r.at(1.5)).abs() < 1e-6, "{}", angle(r.at(1.5)));
        // A whole number of turns apart: at rest.
        let r = RotationSpline::new(&[rot(0.0, 0.0), rot(1.0, 0.0), rot(2.0, 720.0), rot(3.0, 720.0)]);
        assert!(angle(r.at(1.5)).abs() < 1e-9);
        let r = RotationSpline::new(&[rot(0.0, -180.0), rot(1.0, -180.0), rot(2.0, 180.0), rot(3.0, 180.0)]);
        assert!((angle(r.at(1.5)).abs() - 180.0).abs() < 1e-9);
    }

    #[test]
    fn half_turns_go_on_in_the_direction_of_the_angle() {
        let keys: Vec<_> = (0..12).map(|i| rot(f64::from(i), 180.0 * f64::from(i))).collect();
        let r = RotationSpline::new(&keys);
        for i in 1..10 {
            let turned = r.at(f64::from(i)).inverse() * r.at(f64::from(i) + 0.5);
            assert!((angle(turned) - 90.0).abs() < 1e-6, "key {i}: {}", angle(turned));
        }
    }

    #[test]
    fn keys_that_go_back_in_time_are_never_reached() {
        let keys =
            [pos(0.0, 0.0), pos(0.0, 0.0), pos(1.0, 1.0), pos(2.0, 2.0), pos(0.5, 50.0), pos(3.0, 3.0), pos(4.0, 4.0)];
        let s = PositionSpline::new(&keys);
        for i in 0..300 {
            assert!(s.at(f64::from(i) * 0.01).x < 3.1);
        }
        assert_eq!(s.at(3.0).x, 3.0);
    }

    #[test]
    fn equal_times_are_a_cut() {
        let keys = [pos(0.0, 0.0), pos(1.0, 0.0), pos(2.0, 0.0), pos(2.0, 8.0), pos(3.0, 8.0), pos(4.0, 8.0)];
        let s = PositionSpline::new(&keys);
        assert!(s.at(2.0).x > 7.9);
        assert!(s.at(1.5).is_finite() && s.at(2.5).is_finite());
    }

    #[test]
    fn too_few_keys_rest() {
        assert_eq!(PositionSpline::new(&[]).at(1.0), DVec3::ZERO);
        assert_eq!(PositionSpline::new(&[pos(0.0, 1.0), pos(1.0, 2.0), pos(2.0, 3.0)]).at(1.0).x, 2.0);
        assert!(angle(RotationSpline::new(&[rot(0.0, 30.0)]).at(0.0)) - 30.0 < 1e-9);
    }
}
