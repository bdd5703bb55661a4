"""Self-sensing of a wire without prior measurements: a Kalman filter starts from a data sheet and calibrates itself.

    x = (T, ξ, ln ρ_M/ρ_M⁰, ln ρ_A/ρ_A⁰, ln h/h⁰, T_a - T_a⁰, δ)

Sigma points carry the model as in `unscented-kalman`; δ shifts the temperatures of the transformation to austenite, and
the temperatures of the reverse transformation in the opposite direction. The initial uncertainties are the tolerances
of the sheet as uniform distributions, with a standard deviation of 1/√3 of the tolerance. A common shift of all
temperatures of wire and environment cannot be observed. It is no unknown, because a filter would underestimate its
uncertainty; its deviation is added to the spreads of all temperatures.

An error of the diameter acts on the resistance as a resistivity and on the cooling as a film coefficient; both are
estimated for the diameter of the model.

The filter begins with a `Calibration`, during which it commands the signal of its drive. While the wire is cold, ξ = 1
and T = T_a. At the end of the soak ξ = 0 and T = T_h within `hot_deviation`. With the mean resistances R_M and R_A, and
the power P, which equals the heat loss,

    ln ρ_M = ln R_M - ln R(T_a, 1),   ln ρ_A = ln R_A - ln R(T_h, 0),   ln h = ln P - ln Q(T_h - T_a),

each with the error of its mean and the errors of T_h and T_a. The filter continues from there through the cooling, with
random walks that are `learning` times faster. Then the resistivities are considered, not estimated (Schmidt, 1966):
they keep their values, and their uncertainty counts. A filter that continued to fit both to one reading would be
biased, because sigma points that end at ξ = 1 pull ξ off a pure phase, and ρ_M with it.

In a pure phase ξ changes only with temperature: the random walk of ξ is √(4 ξ (1 - ξ)) times `fraction_noise`. `beta`
is 2, which is right for normal errors; sigma points at a kink of the hysteresis need it.

`trust.py` tests the innovations and computes the `confidence` of the estimates. Readings that fail the test contradict
the model, for example in a draught. Then T, ξ, h and T_a have the additional random walks `surprised_...`, so that the
filter learns the new heat loss in one motion. The lower bound of the heat loss, which the guard uses, falls with the
uncertainty of h and rises with its estimate.

Sources: joint estimation with sigma points, Julier and Uhlmann (2004); considered parameters, Schmidt (1966);
otherwise choices of this project, tested on random wires (`benchmarks.unknown_wires`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

from martensite.actuators.mechanisms.base import Output
from martensite.base.errors import ParameterError
from martensite.base.parameters import Number, Parametrised, option, param, part
from martensite.base.units import DEGREES
from martensite.control.observers import covariance, hidden_states
from martensite.control.observers.base import OBSERVERS, Column, Named, ObserverPeriod, list_required
from martensite.control.observers.calibration import COLD, HEAT, READY, SETTLE, SOAK, Calibration, CalibrationState
from martensite.control.observers.covariance import Matrix
from martensite.control.observers.filter import Forecast, FreeParameter
from martensite.control.observers.probing import Probing, ProbingState
from martensite.control.observers.trust import Trust, TrustState
from martensite.control.observers.unscented import UnscentedKalman
from martensite.kernels.dual import value_and_slope, values_and_slopes
from martensite.kernels.namespace import Namespace, Scalar

UNIFORM = 3.0**-0.5
"""Standard deviation of a uniform distribution over its half width."""
RESISTIVITIES, FILMS = (("rho_M", "r_M"), ("rho_A", "r_A")), ("h", "h0", "h1", "h2")
AROUND = ("environment.temperature",)
HALF = 0.5**0.5
"""Tolerance of the mean and half difference of two independent temperatures over their tolerance."""
ABOVE = 28.0
"""Soak temperature above the end of the transformation without stress, of which 17 K are for the stress [K]."""
FAR_AMBIENT = 2.0
"""Limit of the ambient temperature over its standard deviation; a uniform distribution ends at 1.7."""
GIVEN = 1e9
"""Soak temperature above which none is set [K]."""
TINY = 1e-12
"""Least power [W] and least resistance [ohm]."""
VOUCHED, UNSURE = 2.0, 0.2
"""Standard deviations of ln h from its estimate to its lower bound, and the largest one that counts."""
MIXED = 0.05
"""Martensite fraction above which the wire is colder than in the soak."""


States: TypeAlias = tuple[CalibrationState, TrustState, ProbingState]


def _split_memory(memory: Column) -> tuple[CalibrationState, TrustState, ProbingState, Column]:
    """Return the parts of the memory."""
    one, two, three = (len(kind._fields) for kind in (CalibrationState, TrustState, ProbingState))
    calibration, trust = CalibrationState(*memory[:one]), TrustState(*memory[one : one + two])
    return calibration, trust, ProbingState(*memory[one + two : one + two + three]), memory[one + two + three :]


class SheetTolerances(Parametrised):
    """Tolerances of a wire around its data sheet, in both directions."""

    resistivity: Number = param(
        "1", "relative tolerance of both resistivities over the section of the model; assumed", above=0.0, default=0.12
    )
    film: Number = param("1", "largest factor of the film coefficient, or its inverse; assumed", above=1.0, default=2.0)
    ambient: Number = param(DEGREES, "tolerance of the ambient temperature; assumed", above=0.0, default=10.0)
    transformation: Number = param(
        DEGREES, "tolerance of the transformation temperatures; assumed", above=0.0, default=5.0
    )


@OBSERVERS.register("self-sensing")
class SelfSensing(UnscentedKalman):
    """Self-calibrating filter for a wire without prior measurements, with a confidence."""

    beta: Number = param("1", "weight of the middle in the covariance", low=0.0, default=2.0)
    fraction_noise: Number = param("1/s^0.5", "random walk of ξ amid a transformation", low=0.0, default=0.01)
    temperature_noise: Number = param("K/s^0.5", "random walk of the temperature", low=0.0, default=0.15)
    first_fraction: Number = param("1", "standard deviation of a pure phase", low=0.0, default=0.001)
    first_temperature: Number = param(DEGREES, "standard deviation of T - T_a at the start", low=0.0, default=0.5)
    sheet: SheetTolerances = part("tolerances of the data sheet of the wire", default=SheetTolerances())
    start: str = option(
        "start with a calibration, or from the data sheet", "calibration", "sheet", default="calibration"
    )
    calibration: Calibration = part("calibration of the wire", default=Calibration())
    hot: Number = param("K", "soak temperature T_h; default: 28 K above A_f", above=0.0, default=math.inf)
    hot_deviation: Number = param(DEGREES, "standard deviation of the soak temperature", above=0.0, default=7.0)
    loss_deviation: Number = param("1", "relative standard deviation of P - Q", low=0.0, default=0.1)
    learning: Number = param("1", "factor of the random walks during the calibration", low=1.0, default=8.0)
    resistivity_walk: Number = param(
        "1/s^0.5", "random walk of the resistivities; once measured, of their spreads", low=0.0, default=0.0
    )
    film_walk: Number = param("1/s^0.5", "random walk of the film coefficient", low=0.0, default=0.0025)
    surprised_film: Number = param(
        "1/s^0.5", "random walk of the film coefficient while readings contradict the model", low=0.0, default=0.4
    )
    surprised_temperature: Number = param(
        "K/s^0.5", "random walk of the temperature while readings contradict the model", low=0.0, default=1.0
    )
    surprised_fraction: Number = param(
        "1/s^0.5", "random walk of the fraction while readings contradict the model", low=0.0, default=0.03
    )
    surprised_ambient: Number = param(
        "K/s^0.5", "random walk of the ambient temperature while readings contradict the model", low=0.0, default=0.3
    )
    ambient_walk: Number = param("K/s^0.5", "random walk of the ambient temperature", low=0.0, default=0.005)
    transformation_walk: Number = param(
        "K/s^0.5", "random walk of the transformation temperatures", low=0.0, default=0.02
    )
    trust: Trust = part("confidence in the estimates", default=Trust())
    probing: Probing = part("pulses that show an uncertain heat loss", default=Probing())

    def check(self) -> None:
        self.__dict__["_leaf_paths"] = tuple(leaf.path for leaf in self.model.leaves() if leaf.value != 0.0)
        self.__dict__["_matches"] = dict[tuple[str, ...], tuple[str, ...]]()
        super().check()
        if len(self.model.actuators()) != 1 or len(self.model.drives()) != 1:
            raise ParameterError("Observer `self-sensing` is for one element with one drive; take a Kalman filter.")
        names = [path.rsplit(".", 1)[-1] for one in self.free_parameters() for path in one.paths]
        for wanted, quantity in (*((n, "a resistivity") for n in RESISTIVITIES), (FILMS, "a film coefficient")):
            if not set(wanted) & set(names):
                raise ParameterError(f"Observer `self-sensing` estimates {quantity}, which its model does not have.")
        if math.isinf(self.hot) and "A_f" not in names:
            raise ParameterError("Observer `self-sensing`: its law has no `A_f`. Set the soak temperature `hot`.")

    def free_parameters(self) -> list[FreeParameter]:
        sheet = self.sheet
        # sinh ln F for ln F: 0.75 for 0.69 at a factor of 2.
        film = 0.5 * (sheet.film - 1.0 / sheet.film)
        rows = [
            *((names, "logarithm", sheet.resistivity, self.resistivity_walk) for names in RESISTIVITIES),
            (FILMS, "logarithm", film, self.film_walk),
        ]
        parameters = super().free_parameters()
        for names, scale, tolerance, walk in rows:
            paths = self._paths(names)
            more = self.surprised_film if names is FILMS else 0.0
            parameters += [FreeParameter(paths, scale, UNIFORM * tolerance, walk, surprised=more)] if paths else []
        # A common error of both transformation temperatures acts as an opposite error of the ambient temperature.
        common = HALF * sheet.transformation
        around = sheet.ambient + 0.5 * common * common / sheet.ambient
        parameters.append(
            FreeParameter(
                self._paths(AROUND),
                "offset",
                UNIFORM * around,
                self.ambient_walk,
                far=FAR_AMBIENT,
                surprised=self.surprised_ambient,
            )
        )
        heating, cooling = self._paths(("law.A_s", "law.A_f")), self._paths(("law.M_s", "law.M_f"))
        if heating and cooling:
            parameters.append(FreeParameter(heating, "offset", UNIFORM * common, self.transformation_walk, cooling))
        return parameters

    def _paths(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return the parameters of the model with these names, or these endings."""
        matches = self.__dict__["_matches"]
        if names not in matches:
            endings = tuple(f".{name}" for name in names)
            matches[names] = tuple(p for p in self.__dict__["_leaf_paths"] if p in names or p.endswith(endings))
        return matches[names]

    def commands(self) -> tuple[str, str] | None:
        return None if self.start == "sheet" else ("commanding", "probing")

    def estimates(self) -> dict[str, Output]:
        signal = self.model.drives()[0].unit
        return super().estimates() | {
            "calibrating": Output("1", "whether the wire is being calibrated", "c"),
            "commanding": Output("1", "whether the observer sets the signal", "c_u"),
            "phase": Output("1", "phase of the calibration: cold, pulse, heat, soak, settle, ready", "p"),
            "probing": Output(signal, "signal of the observer", "u_c"),
            "confidence": Output("1", "confidence in the estimates", "q"),
            "least_cooling": Output("1", "lower bound of the film coefficient, over that of the model", "κ"),
        }

    def first_covariance(self, xp: Namespace, variances: Sequence[Scalar], signals: Column) -> Matrix:
        matrix = covariance.build_diagonal(variances)
        k = self._index(AROUND)
        matrix[0][0] = matrix[0][0] + variances[k]
        matrix[0][k] = matrix[k][0] = variances[k]
        return matrix

    def hidden_walks(self, xp: Namespace, at: Sequence[Scalar], period: ObserverPeriod) -> list[Scalar]:
        room = xp.maximum(4.0 * at[1] * (1.0 - at[1]), 0.0)
        temperature = self.temperature_noise + period.surprise * self.surprised_temperature
        return [temperature, self.fraction_noise * xp.sqrt(room) + period.surprise * self.surprised_fraction]

    def rest(self, xp: Namespace, readings: Named, signals: Named) -> tuple[Column, Column]:
        calibration = self.calibration.rest(readings[self.reads()[0]])
        if self.start == "sheet":
            calibration = calibration._replace(phase=float(READY), done=1.0)
        first = self.first_forecast(xp, list_required(self, signals))
        return self._list_all(xp, first, 0.0, (calibration, TrustState(), ProbingState()), 1.0)

    def update(
        self, xp: Namespace, memory: Column, readings: Named, signals: Named, dt: Scalar, turns: int
    ) -> tuple[Column, Column]:
        before, trust, probing, memory = _split_memory(memory)
        faster = xp.where(before.phase < READY - 0.5, self.learning, 1.0)
        surprise = xp.where(before.phase < SETTLE - 0.5, 0.0, 1.0 - self.trust.test_innovations(xp, trust, dt))
        period = ObserverPeriod(list_required(self, signals), dt, turns, faster, surprise)
        expected = self.forecast(xp, self.unflatten_memory(memory), period)
        rows = self.pair_readings(xp, expected.mean, readings, dt)
        mean, matrix, nis = covariance.condition_on_readings(xp, expected.mean, expected.covariance, rows)
        i, value, variance, fresh = rows[0]
        heated = self._heat_share(xp, expected, period, value)
        own = self.calibration.advance(xp, before, value, fresh, dt, heated, self.reading_noise)
        mean, matrix = self._restart(xp, (before, own), expected, (mean, matrix), period)
        mean = self._limit_temperature(xp, own, mean, matrix)
        innovation = (value - expected.mean[i]) / xp.sqrt(expected.covariance[i][i] + variance)
        watched = xp.where(before.phase > SETTLE - 0.5, fresh, 0.0)
        trust = self.trust.advance(xp, trust, innovation, watched, dt)
        k, calibration = self._index(FILMS), self.calibration
        unsure = xp.both(matrix[k][k] > self.probing.unsure * self.probing.unsure, own.phase > READY - 0.5)
        heats = xp.both(own.done > 0.5, period.signals[0] > calibration.begin * calibration.probe)
        probing = self.probing.advance(xp, probing, xp.both(unsure, heats), heated, dt)
        there = self.place_unknowns(xp, expected.state, mean, matrix, period)
        return self._list_all(xp, there, nis, (own, trust, probing), dt)

    def _list_all(
        self, xp: Namespace, forecast: Forecast, nis: Scalar, states: States, dt: Scalar
    ) -> tuple[Column, Column]:
        own, trust, probing = states
        estimates, memory = self.list_estimates(xp, forecast, nis)
        estimates = self._count_common_shift(xp, estimates)
        active = xp.where(own.phase < READY - 0.5, 1.0, 0.0)
        spread = xp.sqrt(xp.maximum(forecast.covariance[1][1], 0.0))
        confidence = (1.0 - active) * own.done * self.trust.confidence(xp, trust, spread, dt)
        commands = xp.where(self.probing.is_active(probing), 1.0, active)
        pulse = xp.where(self.probing.is_pulse(probing), self.calibration.largest, own.signal)
        further = (active, commands, own.phase, pulse, confidence, self._find_least_cooling(xp, forecast, own))
        return [*estimates, *further], [*own, *trust, *probing, *memory]

    def _find_least_cooling(self, xp: Namespace, forecast: Forecast, own: CalibrationState) -> Scalar:
        """Return the lower bound of the cooling over the cooling of the model.

        It is the square of the bound of the sheet, which allows for a calm of factor 1/2; 1 during the pulse, whose
        energy limits it; the largest while R shows the end; then the estimate of h less its deviations, which grow as
        soon as readings contradict the model.
        """
        k, most = self._index(FILMS), self.sheet.film
        deviation = xp.minimum(xp.sqrt(xp.maximum(forecast.covariance[k][k], 0.0)), UNSURE)
        least = 1.0 / (most * most)
        film = xp.maximum(xp.exp(forecast.mean[k] - VOUCHED * deviation), least)
        sure = xp.where(xp.both(own.phase > READY - 0.5, own.done > 0.5), film, least)
        heats = xp.where(own.phase < HEAT - 0.5, 1.0, most)
        return xp.where(xp.both(own.phase > COLD + 0.5, own.phase < SETTLE - 0.5), heats, sure)

    def _heat_share(self, xp: Namespace, expected: Forecast, period: ObserverPeriod, reading: Scalar) -> Scalar:
        """Return the energy of a period, over the energy that heats the element to the soak without latent heat."""
        (port,), (one,) = self.model.actuators(), self.model.actuators().values()
        outputs = hidden_states.observe_model(xp, self.model, expected.state, period.signals)
        power, ohm = (outputs[self.model.label(port, name)] for name in ("power", "resistance"))
        energy = one.element.heat_capacity_total() * (
            self._choose_soak_temperature(xp) - self.model.value_of(AROUND[0])
        )
        return power * ohm / xp.maximum(reading, TINY) * period.dt / energy

    def _choose_soak_temperature(self, xp: Namespace) -> Scalar:
        above = self.model.value_of("A_f") + ABOVE if self._paths(("law.A_f",)) else self.hot
        return xp.where(self.hot < GIVEN, self.hot, above)

    def _count_common_shift(self, xp: Namespace, estimates: Column) -> list[Scalar]:
        """Return the estimates, with the uncertainty of the common shift in the spreads of temperatures."""
        common, names = UNIFORM * HALF * self.sheet.transformation, list(super().estimates())
        shifted = [hidden_states.list_names(self.model)[0], *self._paths((*AROUND, "law.A_s"))]
        rows = {names.index(f"{name}_std") for name in shifted if f"{name}_std" in names}
        return [xp.sqrt(x * x + common * common) if k in rows else x for k, x in enumerate(estimates)]

    def _limit_temperature(
        self, xp: Namespace, own: CalibrationState, mean: list[Scalar], matrix: Matrix
    ) -> list[Scalar]:
        """Return the unknowns, with a temperature at which martensite can exist if there is some.

        A wire at rest keeps its fraction at any estimate of the temperature. Without this limit a guard that holds the
        wire at rest would hide a draught: the temperature is too high, and with it the heat loss too low.
        """
        mixed = xp.both(own.phase > SETTLE - 0.5, mean[1] > MIXED)
        limited = covariance.put_unknown(xp, mean, matrix, 0, xp.minimum(mean[0], self._choose_soak_temperature(xp)))
        return [xp.where(mixed, x, y) for x, y in zip(limited, mean, strict=True)]

    def _restart(
        self,
        xp: Namespace,
        calibration: tuple[CalibrationState, CalibrationState],
        expected: Forecast,
        corrected: tuple[list[Scalar], Matrix],
        period: ObserverPeriod,
    ) -> tuple[list[Scalar], Matrix]:
        """Return the unknowns: initial while cold, austenite after the soak, then with fixed resistivities."""
        before, after = calibration
        if self.start == "sheet":
            return corrected
        cold = after.phase < COLD + 0.5
        # Put there all through the soak, so that the law has forgotten what a filter that knew nothing led it through.
        ended = xp.both(before.phase < SOAK + 0.5, after.phase > SETTLE - 0.5)
        soaks = xp.both(after.phase > SOAK - 0.5, after.phase < SOAK + 0.5)
        soaked = xp.both(xp.either(soaks, ended), after.done > 0.5)
        rest = [self.model.value_of(AROUND[0]), 1.0, *(one.start for one in self.free_parameters())]
        unsure = self.first_covariance(xp, [x * x for x in self.first_deviations()], period.signals)
        hot = self._austenite(xp, after, xp.maximum(before.clock, self.calibration.soak), expected, period)
        mean = covariance.put_unknown(xp, *corrected, 1, xp.clip(corrected[0][1], 0.0, 1.0))
        matrix, measured = [list(row) for row in corrected[1]], after.phase > SETTLE - 0.5
        measured_places = [self._index(names) for names in RESISTIVITIES]
        for i in measured_places:
            mean[i] = xp.where(measured, expected.mean[i], mean[i])
            for j in measured_places:
                matrix[i][j] = xp.where(measured, expected.covariance[i][j], matrix[i][j])
        for i in range(len(rest)):
            mean[i] = xp.where(cold, rest[i], xp.where(soaked, hot[0][i], mean[i]))
            for j in range(len(rest)):
                matrix[i][j] = xp.where(cold, unsure[i][j], xp.where(soaked, hot[1][i][j], matrix[i][j]))
        return mean, matrix

    def _austenite(
        self, xp: Namespace, own: CalibrationState, soaked: Scalar, expected: Forecast, period: ObserverPeriod
    ) -> tuple[list[Scalar], Matrix]:
        """Return the unknowns after a soak of some seconds, and their covariance."""
        around = self.model.value_of("environment.temperature")
        hot = self._choose_soak_temperature(xp)
        (port,) = self.model.actuators()
        ohm, loss, power = self.reads()[0], self.model.label(port, "heat_loss"), self.model.label(port, "power")

        def observe_at(xp: Namespace, temperature: Scalar, fraction: Scalar) -> dict[str, Scalar]:
            there = hidden_states.place_hidden(xp, self.model, expected.state, (temperature, fraction), period.signals)
            return hidden_states.observe_model(xp, self.model, there, period.signals)

        at_rest, rest_slope = value_and_slope(xp, lambda xp, t: observe_at(xp, t, 1.0)[ohm], around)
        (warm, lost), (warm_slope, lost_slope) = values_and_slopes(
            xp, lambda xp, t: [observe_at(xp, t, 0.0)[name] for name in (ohm, loss)], hot
        )
        # Readings may be absurd, and resistances are not: within a factor of ten of the model's.
        martensite = xp.clip(own.martensite, 0.1 * at_rest, 10.0 * at_rest)
        austenite = xp.clip(own.austenite, 0.1 * warm, 10.0 * warm)
        heated = xp.maximum(observe_at(xp, hot, 0.0)[power] * warm / austenite, TINY)
        mean = [hot, 0.0, *(one.start for one in self.free_parameters())]
        variances = [x * x for x in self.first_deviations()]
        k_M, k_A, k_h, k_a = (self._index(names) for names in (*RESISTIVITIES, FILMS, AROUND))
        mean[k_M], mean[k_A] = xp.log(martensite / at_rest), xp.log(austenite / warm)
        lost = xp.maximum(lost, TINY)
        mean[k_h] = xp.log(heated / lost)
        rho = self.reading_noise * self.reading_noise * period.dt
        variances[0], variances[1] = self.hot_deviation * self.hot_deviation, self.first_fraction * self.first_fraction
        variances[k_M], variances[k_A] = rho / self.calibration.cold, rho / soaked
        variances[k_h] = self.loss_deviation * self.loss_deviation
        rows = covariance.build_diagonal([1.0] * len(mean))
        rows[k_M][k_a], rows[k_A][0] = -rest_slope / at_rest, -warm_slope / warm
        rows[k_h][0], rows[k_h][k_a] = -lost_slope / lost, lost_slope / lost
        return mean, covariance.propagate_covariance(rows, covariance.build_diagonal(variances))

    def _index(self, names: tuple[str, ...]) -> int:
        count = len(hidden_states.list_names(self.model))
        return count + [one.path for one in self.free_parameters()].index(self._paths(names)[0])
