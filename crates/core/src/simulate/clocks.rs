//! The clocks of a film of a run: real time, and a time in which the impacts before a Zeno point are evenly spaced.

use serde::{Deserialize, Serialize};

use crate::error::{Error, in_range, positive};
use crate::outcome::ZenoPoint;
use crate::serial::shown_as_written;
use crate::simulate::trajectory::Trajectory;
use crate::tolerance::{NEAREST_FRAME, NEAREST_FRAME_ROUNDINGS, TOUCH};

shown_as_written!(FilmClock);

/// Largest number of frames of a film: eleven minutes at 30 frames per second.
const MOST_FRAMES: usize = 20_000;

/// The clock by which a film shows a run.
///
/// | clock | the film at speed 1                                                                          |
/// | ----- | -------------------------------------------------------------------------------------------- |
/// | real  | one second of the film is one second of the run                                              |
/// | zeno  | one second of the film is a tenfold decrease of the time left to the next Zeno point; after the last Zeno point as real |
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FilmClock {
    /// Real time.
    #[default]
    Real,
    /// Decades of the time left to the next Zeno point.
    Zeno,
}

/// The way to a Zeno point, at which infinitely many impacts end. Times in s since the start of the run.
#[derive(Debug, Clone, Copy)]
struct Approach {
    /// The Zeno point before it, or the start of the run.
    from: f64,
    /// The Zeno point.
    to: f64,
    /// The shortest time left that the film shows before the Zeno point.
    nearest: f64,
    /// The time of the film at which it begins.
    begins: f64,
}

impl Approach {
    fn decades(&self) -> f64 {
        libm::log10((self.to - self.from) / self.nearest)
    }
}

/// The map between the time of a film and the time since the start of the run: first the ways to Zeno points, then real time.
#[derive(Debug, Clone)]
pub(crate) struct FilmTime {
    approaches: Vec<Approach>,
    /// Where real time begins: in the film, and in the run since its start.
    real: [f64; 2],
    /// The run's end since its start.
    end: f64,
}

impl FilmTime {
    /// The time of the film at which the run shows `elapsed`.
    pub(crate) fn of(&self, elapsed: f64) -> f64 {
        let next = self.approaches.partition_point(|way| way.to <= elapsed);
        match self.approaches.get(next) {
            Some(way) if elapsed >= way.from => {
                let left = (way.to - elapsed).max(way.nearest);
                way.begins + libm::log10((way.to - way.from) / left)
            }
            // Between two ways are the ends of intervals too short to be seen.
            Some(way) => way.begins,
            None => self.real[0] + (elapsed - self.real[1]).max(0.0),
        }
    }

    /// The time since the start that the film shows at `film`. The inverse of [`of`](Self::of).
    pub(crate) fn shows(&self, film: f64) -> f64 {
        let next = self.approaches.partition_point(|way| way.begins <= film);
        let way = next.checked_sub(1).map(|k| &self.approaches[k]);
        match way {
            Some(way) if film < way.begins + way.decades() => {
                let left = (way.to - way.from) * libm::exp10(way.begins - film);
                (way.to - left.max(way.nearest)).max(way.from)
            }
            _ => (self.real[1] + (film - self.real[0]).max(0.0)).min(self.end),
        }
    }
}

impl Trajectory {
    pub(crate) fn film(&self, clock: FilmClock) -> FilmTime {
        let mut film = FilmTime { approaches: Vec::new(), real: [0.0; 2], end: self.elapsed() };
        if clock == FilmClock::Real {
            return film;
        }
        for point in self.zeno_points().iter().filter(|point| point.is_infinite()) {
            let [begins, from] = film.real;
            let (to, nearest) = (point.elapsed, self.nearest(point, from));
            if to - from > nearest {
                let way = Approach { from, to, nearest, begins };
                film.real[0] += way.decades();
                film.approaches.push(way);
            }
            film.real[1] = to;
        }
        film
    }

    /// The shortest time left, in s, that a film by Zeno time shows before this point. The point before it, or the start, is at `from`.
    ///
    /// A fall from rest in this time has the height r²g/2 = [`TOUCH`] times the size of the body: nearer to the Zeno point no contact opens
    /// farther than a contact that counts as closed.
    fn nearest(&self, point: &ZenoPoint, from: f64) -> f64 {
        let fall = self.posture().and_then(|posture| {
            let gravity = posture.fields().gravity;
            (gravity > 0.0).then(|| (2.0 * TOUCH * posture.size() / gravity).sqrt())
        });
        let clock = point.time.abs().max(self.options().time.abs());
        fall.unwrap_or(NEAREST_FRAME * (point.elapsed - from))
            .max(NEAREST_FRAME_ROUNDINGS * f64::EPSILON * clock)
    }

    /// The time of a film, in s at speed 1, at which it shows the run at time `t` on the clock of the run. Times outside the run count as
    /// its start or its end.
    ///
    /// With [`FilmClock::Real`] it is s = t − t₀. With [`FilmClock::Zeno`] let T_k be the Zeno points with infinitely many impacts, after
    /// T_0 = t₀:
    ///
    /// ```text
    /// s = S_(k-1) + log₁₀ (T_k − T_(k-1)) / (T_k − t)      T_(k-1) ≤ t ≤ T_k − r_k
    /// s = S_k     = S_(k-1) + log₁₀ (T_k − T_(k-1)) / r_k  T_k − r_k ≤ t ≤ T_k
    /// s = S_K + t − T_K                                    after the last one
    /// ```
    ///
    /// | symbol | meaning                                                                                       | unit |
    /// | ------ | --------------------------------------------------------------------------------------------- | ---- |
    /// | `t₀`   | the start of the run                                                                          | s    |
    /// | `S_k`  | the time of the film at the Zeno point T_k, S_0 = 0                                           | s    |
    /// | `r_k`  | √(2h/g), where h is the gap up to which a contact counts as touching; 10⁻¹² of the way without gravity or without a body; at least a few rounding errors of the clock | s |
    ///
    /// Impacts whose flights become shorter by the factor e are evenly spaced by log₁₀ 1/e. A Zeno point within r_k of the one before it
    /// takes no time of the film.
    ///
    /// ```
    /// use standfast::simulate::FilmClock;
    /// use standfast::{Contact, Options, Posture, PostureFields, State, simulate};
    ///
    /// // A ball falls from 5 m for 1 s. With restitution 1/2 its bounces last 1 s, 1/2 s, ..., up to the Zeno point at 3 s.
    /// let ball = Posture::new(PostureFields {
    ///     gyration_radius: 0.4,
    ///     contacts: vec![Contact::at(0.0, 0.0)],
    ///     restitution: 0.5,
    ///     gravity: 10.0,
    ///     ..PostureFields::default()
    /// })?;
    /// let run = simulate(&ball, &State::at_rest([0.0, 5.0, 0.0]), &Options::default())?;
    /// let decades = |t| run.film_time(t, FilmClock::Zeno);
    /// assert!((decades(1.0) - 1.5_f64.log10()).abs() < 1e-15);       // 3 s were left, now 2 s
    /// assert!((decades(2.0) - 3.0_f64.log10()).abs() < 1e-15);       // now 1 s, at the next impact
    /// # Ok::<(), standfast::Error>(())
    /// ```
    #[must_use]
    pub fn film_time(&self, t: f64, clock: FilmClock) -> f64 {
        let start = self.options().time;
        self.film(clock).of((t.clamp(start, self.time()) - start).min(self.elapsed()))
    }

    /// The time on the clock of the run, in s, that a film shows at its time `film`, in s at speed 1: the inverse of
    /// [`film_time`](Self::film_time). Times before and after the film count as its start and its end. Where a Zeno point is reached, at
    /// S_k, the film shows the Zeno point itself.
    #[must_use]
    pub fn time_in_film(&self, film: f64, clock: FilmClock) -> f64 {
        self.on_clock(self.film(clock).shows(film))
    }

    pub(crate) fn on_clock(&self, elapsed: f64) -> f64 {
        if elapsed >= self.elapsed() {
            return self.time();
        }
        (self.options().time + elapsed).clamp(self.options().time, self.time())
    }

    /// The times on the clock of the run, in s, of the frames of a film with `fps` frames per second. The film is `speed` times as fast as
    /// [`film_time`](Self::film_time) says. The first frame is the start of the run, the last its end; with [`FilmClock::Zeno`] the first
    /// frame that comes to a Zeno point, or after it, shows the Zeno point itself.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] unless 0 < `fps` ≤ 1000 and 0 < `speed`, both finite; [`Error::Unusable`] for more than 20 000 frames and if
    /// nothing was recorded.
    pub fn frame_times(&self, fps: f64, speed: f64, clock: FilmClock) -> Result<Vec<f64>, Error> {
        in_range("fps", fps, 0.0 < fps && fps <= 1000.0, "finite and > 0, at most 1000")?;
        positive("speed", speed)?;
        self.pieces()?;
        let film = self.film(clock);
        let whole = film.of(self.elapsed());
        let intervals = (whole / speed * fps).ceil();
        if intervals >= MOST_FRAMES as f64 {
            return Err(Error::Unusable {
                field: "speed".into(),
                value: format!("{speed:?}"),
                allowed: format!(
                    "at most {MOST_FRAMES} frames, and this film would have {}; raise speed",
                    counted(intervals + 1.0)
                ),
            });
        }
        let mut ways = film.approaches.iter().peekable();
        let mut shown: Vec<f64> = Vec::with_capacity(intervals as usize + 1);
        for frame in 0..intervals as usize {
            let mut elapsed = film.shows(frame as f64 * speed / fps);
            while let Some(way) = ways.next_if(|way| way.to <= elapsed) {
                if ways.peek().is_none_or(|next| next.to > elapsed) {
                    elapsed = way.to;
                }
            }
            shown.push(self.on_clock(elapsed));
        }
        shown.push(self.time());
        Ok(shown)
    }
}

/// A number of frames, in digits as long as these can be read.
fn counted(frames: f64) -> String {
    if frames < 1e15 { format!("{frames:.0}") } else { format!("{frames:.1e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::contact::Contact;
    use crate::body::fields::PostureFields;
    use crate::body::local_model::{LocalModel, LocalModelFields, LocalState};
    use crate::body::posture::Posture;
    use crate::body::state::State;
    use crate::options::{Options, Stop};
    use crate::simulate::{simulate, simulate_local};

    /// Rounding errors of a logarithm, and of the times of impacts that are at most 2²⁰ times closer to the Zeno point than the start.
    const ROUNDING: f64 = 1e-9;

    /// A ball of size 0.4 m that falls from 5 m for 1 s onto the ground and bounces with restitution 1/2: 3 s up to its Zeno point.
    fn ball(gravity: f64) -> Posture {
        Posture::new(PostureFields {
            mass: 1.0,
            gyration_radius: 0.4,
            center_of_mass: [0.0, 0.0],
            contacts: vec![Contact::at(0.0, 0.0)],
            restitution: 0.5,
            gravity,
            ..PostureFields::default()
        })
        .expect("a ball")
    }

    fn bounced(options: Options) -> Trajectory {
        simulate(&ball(10.0), &State::at_rest([0.0, 5.0, 0.0]), &options).expect("a run")
    }

    /// √(2h/g) with the height h = 1e-12 · 0.4 m and g = 10 m/s².
    fn nearest() -> f64 {
        8e-14_f64.sqrt()
    }

    #[test]
    fn impacts_before_a_zeno_point_are_evenly_spaced() {
        let run = bounced(Options::default());
        let impact = |n: i32| 3.0 - 2.0 * libm::exp2(-f64::from(n));
        let first = run.film_time(impact(0), FilmClock::Zeno);
        assert!((first - libm::log10(1.5)).abs() < ROUNDING);
        for n in 0..20 {
            let spacing = run.film_time(impact(n + 1), FilmClock::Zeno)
                - run.film_time(impact(n), FilmClock::Zeno);
            assert!((spacing - libm::log10(2.0)).abs() < ROUNDING, "impact {n}: {spacing}");
        }
    }

    #[test]
    fn the_way_to_a_zeno_point_ends_where_no_gap_is_seen() {
        let run =
            bounced(Options { stop: Stop::Time, time_limit: Some(5.0), ..Options::default() });
        let decades = libm::log10(3.0 / nearest());
        for (t, film) in [
            (0.0, 0.0),
            (3.0 - 1.1 * nearest(), decades - libm::log10(1.1)),
            (3.0 - 0.9 * nearest(), decades),
            (3.0, decades),
            (4.0, decades + 1.0),
            (5.0, decades + 2.0),
            (f64::INFINITY, decades + 2.0),
            (-1.0, 0.0),
        ] {
            let found = run.film_time(t, FilmClock::Zeno);
            assert!((found - film).abs() < ROUNDING, "{t}: {found} and not {film}");
        }
        assert_eq!(run.film_time(4.5, FilmClock::Real), 4.5);
        assert!(run.time_in_film(decades - ROUNDING, FilmClock::Zeno) < 3.0);
        assert!((run.time_in_film(decades + ROUNDING, FilmClock::Zeno) - 3.0) < 2.0 * ROUNDING);
    }

    #[test]
    fn both_ways_are_inverse() {
        let shifted = Options { time: 100.0, ..Options::default() };
        let on = Options { stop: Stop::Time, time_limit: Some(5.0), ..Options::default() };
        for options in [Options::default(), shifted, on] {
            let run = bounced(options);
            for clock in [FilmClock::Real, FilmClock::Zeno] {
                let whole = run.film_time(run.time(), clock);
                for k in 0..=1000 {
                    let film = whole * f64::from(k) / 1000.0;
                    let t = run.time_in_film(film, clock);
                    // A time left of some roundings of the clock has an error of some tenths.
                    let left = (options.time + 3.0 - t).abs().max(nearest());
                    let error = 4.0 * f64::EPSILON * t / left + ROUNDING;
                    let back = run.film_time(t, clock);
                    assert!((back - film).abs() < error, "{clock:?} {film}: {back}");
                }
            }
        }
    }

    #[test]
    fn frames_are_evenly_spaced_and_show_the_zeno_point() {
        let run =
            bounced(Options { stop: Stop::Time, time_limit: Some(5.0), ..Options::default() });
        let real = run.frame_times(10.0, 2.0, FilmClock::Real).unwrap();
        assert_eq!(real.len(), 26); // 5 s in 2.5 s of film
        for (k, t) in real.iter().enumerate() {
            assert!((t - 0.2 * k as f64).abs() < ROUNDING, "{k}");
        }
        let zeno = run.frame_times(25.0, 1.0, FilmClock::Zeno).unwrap();
        assert_eq!((zeno[0], zeno[zeno.len() - 1]), (0.0, 5.0));
        assert!(zeno.is_sorted());
        let at = zeno.iter().position(|&t| t == 3.0).expect("the Zeno point is shown");
        assert_eq!(at, (25.0 * libm::log10(3.0 / nearest())).ceil() as usize);
        for pair in zeno[..at].windows(2).take(150) {
            let spacing = libm::log10((3.0 - pair[0]) / (3.0 - pair[1]));
            assert!((spacing - 0.04).abs() < ROUNDING, "{pair:?}");
        }
        assert!(3.0 - zeno[at - 1] < 1.1 * nearest() && zeno[at + 1] > 3.0);
    }

    #[test]
    fn a_run_of_no_time_is_one_frame() {
        let run = simulate(&ball(10.0), &State::at_rest([0.0; 3]), &Options::default()).unwrap();
        for clock in [FilmClock::Real, FilmClock::Zeno] {
            assert_eq!(run.frame_times(30.0, 1.0, clock).unwrap(), [0.0]);
        }
    }

    #[test]
    fn without_a_body_the_film_shows_twelve_decades() {
        let model = LocalModel::new(LocalModelFields {
            gravity: [10.0; 2],
            psi: [0.1; 2],
            restitution: [0.5; 2],
            ..LocalModelFields::default()
        })
        .unwrap();
        let options = Options { stop: Stop::Zeno, ..Options::default() };
        let run = simulate_local(
            &model,
            &LocalState { gaps: [5.0, 4.0], rates: [0.0; 2], ..LocalState::default() },
            &options,
        )
        .unwrap();
        assert!(!run.zeno_points().is_empty());
        let points = run.zeno_points().iter().filter(|point| point.is_infinite()).count();
        let whole = run.film_time(run.time(), FilmClock::Zeno);
        assert!((whole - 12.0 * points as f64).abs() < ROUNDING, "{whole}");
    }

    #[test]
    fn a_film_has_limits() {
        let run = bounced(Options::default());
        let message = |fps, speed| {
            run.frame_times(fps, speed, FilmClock::Real).map(|_| ()).unwrap_err().to_string()
        };
        let fps = "outside its range: finite and > 0, at most 1000";
        for wrong in [0.0, -1.0, f64::NAN, 1000.1] {
            assert_eq!(message(wrong, 1.0), format!("fps = {wrong:?} is {fps}"));
        }
        assert!(message(30.0, 0.0).starts_with("speed = 0.0 is outside its range"));
        // 3 s at speed 3/20000: 20 000 s.
        assert_eq!(
            message(1.0, 3.0 / 20_000.0),
            "speed = 0.00015 cannot be used: at most 20000 frames, and this film would have 20001; raise speed"
        );
        assert!(message(1.0, 1e-100).contains("would have 3.0e100; raise speed"));
        assert_eq!(run.frame_times(1.0, 3.0 / 19_999.0, FilmClock::Real).unwrap().len(), 20_000);
        let unrecorded = bounced(Options { record: false, ..Options::default() });
        let error = unrecorded.frame_times(30.0, 1.0, FilmClock::Real).unwrap_err();
        assert!(error.to_string().starts_with("record = false"));
    }
}
