//! Clattering up to scale: orbits, exponents, fates and the bounds of the coupling.

use numpy::{IntoPyArray, PyArray1, PyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use standfast::Error;
use standfast::body::LocalModel;
use standfast::stability::{Exponents, Fate, Orbit, OrbitEnd, ReducedMap, SelfSimilar};

use crate::convert::{array, float, local_model};
use crate::error::to_py;
use crate::input;

/// The impacts of a motion, one by one, up to scale.
///
/// The units are chosen so that the coupling is symmetric. With k = weights (1 where ψ_1 = ψ_2), ĝ =
/// gravity and U = exp(log_sizes), after an impact at contact a
///
///     u_a = U/k_a    u_b = shapes[:, 0] U/k_b    h_b = shapes[:, 1] U²/(ĝ k_b)
///
/// and the time since impact k − 1 is flights[k] U[k − 1]/ĝ; flights[0]/ĝ is the time since the start.
///
/// Attributes
/// ----------
/// contacts : int array (n,)
///     The contact that is hit.
/// shapes : (n, 2) ndarray
///     Right after the impact: the rate of the other contact divided by the rate of this one, and
///     the gap of the other contact divided by the square of this rate, both dimensionless.
/// log_sizes : (n,) ndarray, ln(m/s)
///     Natural logarithm of the rate of this contact.
/// flights : (n,) ndarray
///     Time since the previous impact.
/// end : {"1-zeno", "tie"} or None
///     "1-zeno" if one contact bounces alone after the last impact, "tie" if both land at once,
///     None if all n impacts were found.
/// contact : int or None
///     The contact of the 1-Zeno.
#[pyclass(frozen, name = "Orbit", module = "standfast.theory")]
pub(crate) struct PyOrbit {
    pub(crate) map: ReducedMap,
    pub(crate) orbit: Orbit,
    pub(crate) asked: Asked,
}

/// The pickled form of a result: a call of a method of a model.
pub(crate) struct Asked {
    pub(crate) model: LocalModel,
    pub(crate) method: &'static str,
    pub(crate) gaps: [f64; 2],
    pub(crate) rates: [f64; 2],
    /// The arguments that are numbers of impacts.
    pub(crate) counts: Vec<usize>,
}

impl Asked {
    fn again<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let model = local_model(py, &self.model)?;
        let start = (self.gaps, self.rates).into_pyobject(py)?;
        let counts = PyTuple::new(py, &self.counts)?;
        Ok((model.getattr(self.method)?, start.add(counts)?.cast_into()?))
    }
}

fn end(end: Option<OrbitEnd>) -> Option<&'static str> {
    end.map(|end| match end {
        OrbitEnd::OneZeno(_) => "1-zeno",
        OrbitEnd::Tie => "tie",
    })
}

fn ended(text: Option<&str>) -> String {
    text.map_or(String::new(), |end| format!(", ends in a {end}"))
}

#[pymethods]
impl PyOrbit {
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let numbers: Vec<i64> =
            self.orbit.shapes.iter().map(|shape| shape.contact.number() as i64).collect();
        numbers.into_pyarray(py)
    }

    #[getter]
    fn shapes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let shapes = &self.orbit.shapes;
        let values = shapes.iter().flat_map(|shape| [shape.rate, shape.gap]).collect();
        array(py, values, &[shapes.len(), 2])
    }

    #[getter]
    fn log_sizes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.orbit.log_sizes.clone().into_pyarray(py)
    }

    #[getter]
    fn flights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.orbit.flights.clone().into_pyarray(py)
    }

    /// Derivatives of shapes[k + 1] by shapes[k], (n − 1, 2, 2). Their determinants are e²/f⁵, f the factor of the size.
    #[getter]
    fn tangents<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let steps = self.orbit.shapes.len().saturating_sub(1);
        let values: Vec<f64> = self.orbit.shapes[..steps]
            .iter()
            .filter_map(|shape| self.map.step(shape).ok())
            .flat_map(|step| step.tangent)
            .flatten()
            .collect();
        array(py, values, &[steps, 2, 2])
    }

    #[getter]
    fn end(&self) -> Option<&'static str> {
        end(self.orbit.end)
    }

    #[getter]
    fn contact(&self) -> Option<usize> {
        match self.orbit.end {
            Some(OrbitEnd::OneZeno(contact)) => Some(contact.number()),
            _ => None,
        }
    }

    #[getter]
    fn weights(&self) -> (f64, f64) {
        self.map.weights().into()
    }

    /// ĝ = √(g_1g_2), m/s².
    #[getter]
    fn gravity(&self) -> f64 {
        self.map.gravity()
    }

    fn __len__(&self) -> usize {
        self.orbit.shapes.len()
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        self.asked.again(py)
    }

    fn __repr__(&self) -> String {
        format!("<Orbit: {} impacts{}>", self.__len__(), ended(self.end()))
    }
}

/// Mean growth per impact along an orbit up to scale.
///
/// A chaotic orbit in doubles soon differs from the exact orbit of its start, because an error grows by
/// exp(Λ_1) per impact. Its means are those of the attractor.
///
/// Attributes
/// ----------
/// sigma : float
///     Mean logarithm of the factor of all speeds.
/// lyapunov : (float, float)
///     (Λ_1, Λ_2), Λ_1 ≥ Λ_2, the Lyapunov exponents of the shape (rate, gap).
/// sigma_error, lyapunov_error : float
///     Their standard errors, from the scatter over 32 parts of the orbit.
/// hits : int
///     Number of impacts in the means; it is less than n if the orbit ends (the means are nan
///     without impacts).
/// end : {"1-zeno", "tie"} or None
///     How the orbit ends. For an orbit that does not end, Λ_1 + Λ_2 = 2⟨ln e⟩ − 5σ.
#[pyclass(frozen, eq, name = "Exponents", module = "standfast.theory")]
pub(crate) struct PyExponents {
    pub(crate) exponents: Exponents,
    pub(crate) asked: Asked,
}

impl PartialEq for PyExponents {
    fn eq(&self, other: &Self) -> bool {
        self.exponents == other.exponents
    }
}

#[pymethods]
impl PyExponents {
    #[getter]
    fn sigma(&self) -> f64 {
        self.exponents.sigma
    }

    #[getter]
    fn lyapunov(&self) -> (f64, f64) {
        self.exponents.lyapunov.into()
    }

    #[getter]
    fn sigma_error(&self) -> f64 {
        self.exponents.sigma_error
    }

    #[getter]
    fn lyapunov_error(&self) -> (f64, f64) {
        self.exponents.lyapunov_error.into()
    }

    #[getter]
    fn hits(&self) -> usize {
        self.exponents.hits
    }

    #[getter]
    fn end(&self) -> Option<&'static str> {
        end(self.exponents.end)
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        self.asked.again(py)
    }

    fn __repr__(&self) -> String {
        let x = &self.exponents;
        let ([one, two], [d_one, d_two]) = (x.lyapunov, x.lyapunov_error);
        format!(
            "<Exponents: sigma {:.3e} +- {:.0e}, lyapunov {one:.4} +- {d_one:.0e} and {two:.4} +- {d_two:.0e}, {} impacts{}>",
            x.sigma,
            x.sigma_error,
            x.hits,
            ended(self.end())
        )
    }
}

/// How a clattering motion ends.
///
/// Attributes
/// ----------
/// kind : {"1-zeno", "clattering", "self-similar", "other", "none"}
///     "1-zeno" (one contact bounces alone until it rests), "clattering" (both are hit in turn for
///     ever, and gravity becomes negligible), "self-similar" (the shape converges to an attracting
///     cycle), "other" (none of these within n impacts: a quasi-periodic or chaotic shape, or one
///     that converges slowly), "none" (both land at once, so that impacts have no order).
/// contact : int or None
///     The contact that comes to rest in a 1-Zeno.
/// certified : bool
///     Whether the kind is proved for the given start; this requires that earlier impacts amplify
///     the rounding of the start to at most 1e-6 of the shape.
/// hits : int
///     Number of impacts after the first until the kind is known.
/// period : int or None
///     Number of impacts after which shape and contact repeat.
/// sigma : float
///     Mean logarithm of the factor of all speeds per impact from then on; nan if not known.
#[pyclass(frozen, eq, name = "Fate", module = "standfast.theory")]
pub(crate) struct PyFate {
    pub(crate) fate: Fate,
    pub(crate) asked: Asked,
}

impl PartialEq for PyFate {
    fn eq(&self, other: &Self) -> bool {
        let known = |fate: Fate| Fate { sigma: 0.0, ..fate };
        let (one, two) = (self.fate.sigma, other.fate.sigma);
        known(self.fate) == known(other.fate) && (one == two || one.is_nan() && two.is_nan())
    }
}

#[pymethods]
impl PyFate {
    #[getter]
    fn kind(&self) -> &'static str {
        self.fate.kind.as_str()
    }

    #[getter]
    fn contact(&self) -> Option<usize> {
        self.fate.contact.map(standfast::outcome::ContactNumber::number)
    }

    #[getter]
    fn certified(&self) -> bool {
        self.fate.certified
    }

    #[getter]
    fn hits(&self) -> usize {
        self.fate.hits
    }

    #[getter]
    fn period(&self) -> Option<usize> {
        self.fate.period
    }

    #[getter]
    fn sigma(&self) -> f64 {
        self.fate.sigma
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        self.asked.again(py)
    }

    fn __repr__(&self) -> String {
        let contact = self.contact().map_or(String::new(), |i| format!(" of contact {i}"));
        let certified = if self.fate.certified { ", certified" } else { "" };
        format!(
            "<Fate: {}{contact}{certified}, known after {} impacts>",
            self.kind(),
            self.fate.hits
        )
    }
}

/// Fates as a structured array.
pub(crate) fn fate_table<'py>(
    py: Python<'py>,
    fates: &[Fate],
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let dtype = PyList::empty(py);
    for (name, kind) in [
        ("kind", "U12"),
        ("contact", "i8"),
        ("certified", "?"),
        ("hits", "i8"),
        ("period", "i8"),
        ("sigma", "f8"),
    ] {
        dtype.append((name, kind))?;
    }
    let table = py.import("numpy")?.call_method1("empty", (fates.len(), dtype))?;
    let count = |of: fn(&Fate) -> usize| -> Bound<'py, PyArray1<i64>> {
        fates.iter().map(|fate| of(fate) as i64).collect::<Vec<_>>().into_pyarray(py)
    };
    table.set_item("kind", PyList::new(py, fates.iter().map(|fate| fate.kind.as_str()))?)?;
    table.set_item("contact", count(|fate| fate.contact.map_or(0, |i| i.number())))?;
    let certified: Vec<bool> = fates.iter().map(|fate| fate.certified).collect();
    table.set_item("certified", certified.into_pyarray(py))?;
    table.set_item("hits", count(|fate| fate.hits))?;
    table.set_item("period", count(|fate| fate.period.unwrap_or(0)))?;
    let sigma: Vec<f64> = fates.iter().map(|fate| fate.sigma).collect();
    table.set_item("sigma", sigma.into_pyarray(py))?;
    table.call_method1("reshape", (shape.to_vec(),))
}

/// The self-similar orbit of two contacts with equal restitution and equal reduced gravity.
///
/// Each impact exchanges the contacts, multiplies all speeds by `factor`, and all gaps by its square.
///
/// Attributes
/// ----------
/// factor : float
///     c.
/// stable : bool
///     Whether the orbit attracts neighbouring orbits.
/// rate, gap : float
///     Those of the other contact right after an impact with take-off rate 1, at gravity 1.
#[pyclass(frozen, eq, name = "SelfSimilar", module = "standfast.theory")]
pub(crate) struct PySelfSimilar {
    orbit: SelfSimilar,
    restitution: f64,
    psi: f64,
}

impl PartialEq for PySelfSimilar {
    fn eq(&self, other: &Self) -> bool {
        self.orbit == other.orbit
    }
}

#[pymethods]
impl PySelfSimilar {
    #[getter]
    fn factor(&self) -> f64 {
        self.orbit.factor
    }

    #[getter]
    fn stable(&self) -> bool {
        self.orbit.stable
    }

    #[getter]
    fn rate(&self) -> f64 {
        self.orbit.rate
    }

    #[getter]
    fn gap(&self) -> f64 {
        self.orbit.gap
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let asked = (self.restitution, self.psi).into_pyobject(py)?;
        Ok((py.import("standfast.theory")?.getattr("self_similar")?, asked))
    }

    fn __repr__(&self) -> String {
        let SelfSimilar { factor, stable, rate, gap } = self.orbit;
        let stable = if stable { "stable" } else { "unstable" };
        format!(
            "<SelfSimilar: {stable}, factor {}, rate {}, gap {}>",
            float(factor),
            float(rate),
            float(gap)
        )
    }
}

fn in_range(field: &str, value: f64, holds: bool, allowed: &'static str) -> PyResult<()> {
    let wrong = || to_py(&Error::OutOfRange { field: field.into(), value, allowed });
    if holds { Ok(()) } else { Err(wrong()) }
}

fn restitutions(e: [f64; 2]) -> PyResult<[f64; 2]> {
    for value in e {
        in_range("restitution", value, (0.0..1.0).contains(&value), "0 <= restitution < 1")?;
    }
    Ok(e)
}

fn coupling(psi: f64) -> PyResult<f64> {
    in_range("psi", psi, (-1.0..=1.0).contains(&psi), "-1 <= psi <= 1")?;
    Ok(psi)
}

/// The coupling ψ = ±√(ψ_1ψ_2) above which clattering converges: both contacts are hit in turn for ever
/// and gravity becomes negligible [Or & Rimon 2008, (10)]. It is (e^⅓ + e^⅔)/(1 + e), or for two
/// restitutions √((e_1 + e_2 + (e_1e_2)^⅓ + (e_1e_2)^⅔)/((1+e_1)(1+e_2))).
///
/// Parameters
/// ----------
/// restitution : float or (2,) array_like, in [0, 1)
///     e, or (e_1, e_2).
///
/// Raises
/// ------
/// ValueError
///     Names `restitution`.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> round(sf.theory.clattering_bound(0.125), 15)         # (1/2 + 1/4)/(9/8)
/// 0.666666666666667
#[pyfunction]
pub(crate) fn clattering_bound(
    #[pyo3(from_py_with = input::restitutions)] restitution: [f64; 2],
) -> PyResult<f64> {
    Ok(standfast::stability::clattering_bound(restitutions(restitution)?))
}

/// The least coupling ψ = ±√(ψ_1ψ_2) for which impacts without gravity never end (Goyal's bound): (√e_1
/// + √e_2)/√((1+e_1)(1+e_2)), for one restitution 2√e/(1 + e).
///
/// Parameters
/// ----------
/// restitution : float or (2,) array_like, in [0, 1)
///     e, or (e_1, e_2).
///
/// Raises
/// ------
/// ValueError
///     Names `restitution`.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> round(sf.theory.chatter_bound(0.25), 15)
/// 0.8
#[pyfunction]
pub(crate) fn chatter_bound(
    #[pyo3(from_py_with = input::restitutions)] restitution: [f64; 2],
) -> PyResult<f64> {
    Ok(standfast::stability::chatter_bound(restitutions(restitution)?))
}

/// The restitution below which clattering converges at coupling psi: the inverse of
/// `clattering_bound`; 0 for psi ≤ 0.
///
/// Parameters
/// ----------
/// psi : float, in [−1, 1]
///     The coupling ψ.
///
/// Raises
/// ------
/// ValueError
///     Names `psi`.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> round(sf.theory.clattering_restitution(0.5), 12)     # 9 − 4√5: the uniform rod
/// 0.055728090001
#[pyfunction]
pub(crate) fn clattering_restitution(
    #[pyo3(from_py_with = input::coupling)] psi: f64,
) -> PyResult<f64> {
    Ok(standfast::stability::clattering_restitution(coupling(psi)?))
}

/// The restitution up to which impacts without gravity never end at coupling psi: the inverse of
/// `chatter_bound`; 0 for psi ≤ 0.
///
/// Parameters
/// ----------
/// psi : float, in [−1, 1]
///     The coupling ψ.
///
/// Raises
/// ------
/// ValueError
///     Names `psi`.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> round(sf.theory.chatter_restitution(0.8), 15)
/// 0.25
#[pyfunction]
pub(crate) fn chatter_restitution(
    #[pyo3(from_py_with = input::coupling)] psi: f64,
) -> PyResult<f64> {
    Ok(standfast::stability::chatter_restitution(coupling(psi)?))
}

/// The self-similar orbit of clattering below its bound: SelfSimilar, or None where there is none.
///
/// Its factor c is the root of c³ + Kc² + (1 − K − e)c − e = 0 between e and e^⅓, K = 1 + (1+e)ψ. It
/// appears at psi = `clattering_bound(e)`, where c = e^⅓, and loses its stability at
/// `neimark_sacker(e)`, where c = e^⅖.
///
/// Parameters
/// ----------
/// restitution : float, in [0, 1)
///     e, of both contacts.
/// psi : float, in [−1, 1]
///     The coupling ψ.
///
/// Raises
/// ------
/// ValueError
///     Names the field.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> orbit = sf.theory.self_similar(0.5, 0.9)
/// >>> round(orbit.factor, 6), orbit.stable
/// (0.790489, True)
#[pyfunction]
pub(crate) fn self_similar(
    #[pyo3(from_py_with = input::restitution)] restitution: f64,
    #[pyo3(from_py_with = input::coupling)] psi: f64,
) -> PyResult<Option<PySelfSimilar>> {
    let [e, _] = restitutions([restitution; 2])?;
    let found = standfast::stability::self_similar(e, coupling(psi)?);
    Ok(found.map(|orbit| PySelfSimilar { orbit, restitution, psi }))
}

/// The coupling at which the self-similar orbit changes its stability (a Neimark–Sacker bifurcation).
/// Below it the orbit repels neighbouring orbits. With c = e^⅖, 1 + (1+e)ψ = (e + ec − c − c³)/(c² −
/// c).
///
/// Parameters
/// ----------
/// restitution : float, in (0, 1)
///     e, of both contacts.
///
/// Raises
/// ------
/// ValueError
///     Names `restitution`.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> psi = sf.theory.neimark_sacker(0.5)
/// >>> sf.theory.self_similar(0.5, psi + 1e-6).stable, sf.theory.self_similar(0.5, psi - 1e-6).stable
/// (True, False)
#[pyfunction]
pub(crate) fn neimark_sacker(
    #[pyo3(from_py_with = input::restitution)] restitution: f64,
) -> PyResult<f64> {
    let holds = restitution > 0.0 && restitution < 1.0;
    in_range("restitution", restitution, holds, "0 < restitution < 1")?;
    Ok(standfast::stability::neimark_sacker(restitution))
}
