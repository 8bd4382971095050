//! Impacts that accumulate, followed one by one or summed at one instant.

use standfast::options::Impact;
use standfast::{
    Contact, Lamina, Model, Options, Posture, PostureFields, State, Trajectory, simulate,
};

/// A run on level ground, impact by impact by Poisson's law, with so little friction that it is Newton's. The feet are in one line with
/// the centre of mass.
fn run(feet: &[f64], [e, rho]: [f64; 2], height: f64, qdot: [f64; 3]) -> Trajectory {
    let rod = Posture::rod(
        1.0,
        &Lamina { gyration_radius: Some(rho), restitution: e, ..Lamina::default() },
    )
    .expect("a rod");
    let foot = |&x: &f64| Contact { friction: 1e-300, ..Contact::at(x, 0.0) };
    let contacts = feet.iter().map(foot).collect();
    let posture = Posture::new(PostureFields { contacts, ..rod.fields().clone() });
    let options = Options { impact: Impact::Poisson, model: Model::Full, ..Options::default() };
    let start = State::new([0.0, height, 0.0], qdot);
    simulate(&posture.expect("a posture"), &start, &options).expect("a run")
}

/// √(2h/g)(1 + e)/(1 − e).
#[test]
fn bounces_followed_one_by_one_end_with_their_geometric_series() {
    for e in [0.1, 0.5, 0.9] {
        let found = run(&[0.0], [e, 0.3], 0.2, [0.5, 0.0, 0.0]).zeno_points()[0].elapsed;
        let expected = (2.0 * 0.2 / 9.81_f64).sqrt() * (1.0 + e) / (1.0 - e);
        assert!((found / expected - 1.0).abs() < 1e-14, "{found} {expected}");
    }
}

/// Contact 1 rests and contact 2 lands. The speeds decrease by some percent at each impact, for P = (1+e)ψ is a little above
/// 2√e. The sum of all is a plastic impact: only the sliding is left.
#[test]
fn impacts_in_one_instant_are_summed_to_the_projection_of_the_velocity() {
    let found = run(&[-1.0, 1.0], [0.7, 0.07], 0.0, [0.7, -0.5, -0.5]);
    let (hits, v) = (found.impacts().len(), found.state().qdot);
    assert!((64..250).contains(&hits), "{hits}");
    assert!(found.elapsed() == 0.0);
    assert!(v.x == 0.7 && v.y.abs() < 1e-14 && v.z.abs() < 1e-14, "{v}");
}
