"""Evolution of profiles over distance: wear of all states, adaptive steps, limits, and a file to go on from."""

import json
import sqlite3
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from flangeway.errors import InputError
from flangeway.railway.damage.collective import Collective, SurfaceKey
from flangeway.railway.damage.wear_laws import PatchDamage, WearLaw, patch_damage, row_wear
from flangeway.railway.damage.worn_surface import (
    FILTER_MM,
    LIMITS,
    SPACING_MM,
    Limits,
    WornSurface,
    reached,
    worn_measures,
)
from flangeway.railway.track.wheelset_problem import Role
from flangeway.railway.wheelset.running_surfaces import ElasticBodies, running_surfaces
from flangeway.railway.wheelset.spatial_result import SpatialResult, solve_position
from flangeway.railway.wheelset.spatial_wheelset import SpatialWheelset
from flangeway.railway.wheelset.wheelset_newton import RollingPlace
from flangeway.records import NotNegative, Positive, Record
from flangeway.system.disk_cache import Cache, content_key
from flangeway.types import Floats, Progress

MM_PER_KM = 1e6
MAX_COMPLIANCE_WEAR_MM = 1.0
"""Depth up to which the compliance of the new bodies is kept; beyond it is made anew from the worn body.

Hollows of 1 mm in S1002 and 60E1: p0 of the greatest patch changes by 0.16 %, that of a lesser one by 0.9 %."""
OVER_PIECES = ("rates", "damage", "damage_rates")
"""Numbers of a step by the pieces of its surfaces."""
SAFETY_FACTOR, GROWTH = 0.9, 2.0
"""Next step relative to the one that the estimated error allows, and relative to the one before, at most."""


class EvolutionSettings(Record):
    """How far and how finely profiles evolve."""

    end: Positive
    """distance in km that the wheels run, or number of axles where rails wear alone"""
    axles_per_km: Positive | None = None
    """axles that pass a point of the rails while a wheel runs 1 km; needed where both wear"""
    max_depth_mm: Positive = 0.05
    """maximum depth of one step: wear evens out what the contact is compressed by, some 0.05 mm, and longer steps
    overshoot"""
    max_error_mm: Positive = 0.01
    """maximum estimated error of the depth in one step: how far the rates at its end change its depth"""
    filter_mm: NotNegative = FILTER_MM
    """wavelengths of the depth below it are filtered; 0 filters nothing"""
    spacing_mm: Positive = SPACING_MM
    """length of the pieces of the surfaces"""
    limits: Limits = Limits()
    """measures of the profiles at which the evolution ends"""


@dataclass(frozen=True, eq=False)
class StateDamage:
    """One state on the profiles of a step: its patches, why it has none, and where the wheelset rolls."""

    name: str
    patches: tuple[PatchDamage, ...]
    message: str = ""
    place: RollingPlace | None = None


@dataclass(frozen=True, eq=False)
class EvolutionStep:
    """Profiles after a distance, and what all states do on them.

    - `position`: distance in km, or axles.
    - `surfaces`: by role and side.
    - `rates`: filtered depth over the position, mm per km or axle, shape of the depth.
    - `damage`: net T-gamma damage summed over the distance before, by piece; below 0 wear has taken it off.
    - `states`: in the order of the collective.
    - `reached`: limits.
    - `error_mm`: estimated error of the depth in the step that ends here.
    """

    position: float
    surfaces: Mapping[SurfaceKey, WornSurface]
    rates: Mapping[SurfaceKey, Floats]
    damage: Mapping[SurfaceKey, Floats]
    damage_rates: Mapping[SurfaceKey, Floats]
    states: tuple[StateDamage, ...]
    t_gamma_N: float  # noqa: N815
    reached: tuple[str, ...] = ()
    error_mm: float = 0.0

    @property
    def unconverged(self) -> tuple[str, ...]:
        """Names of the states without equilibrium."""
        return tuple(f"{state.name}: " + state.message for state in self.states if state.message)

    @property
    def row(self) -> dict[str, float]:
        """Numbers for a table: depths, areas, measures, mean T-gamma and maximum pressure."""
        row = {"position": self.position, "t_gamma_N": self.t_gamma_N}
        pressures = [patch.max_pressure_MPa for state in self.states for patch in state.patches]
        row["max_pressure_MPa"] = max(pressures, default=float("nan"))
        indices = [
            patch.fatigue_index for state in self.states for patch in state.patches if patch.fatigue_index is not None
        ]
        row["max_fatigue_index"] = max(indices, default=float("nan"))
        for (role, side), surface in self.surfaces.items():
            numbers = {"depth_mm": float(surface.depth.max()), "area_mm2": surface.worn_area_mm2}
            numbers |= worn_measures(surface) | {"max_damage": float(self.damage[role, side].max())}
            row |= {f"{side}_{role}_{name}": value for name, value in numbers.items()}
        return row


def limit_positions(steps: Sequence[EvolutionStep], limits: Mapping[str, float]) -> dict[str, float]:
    """Positions at which the limits of the last step were reached; measures are linear over a step.

    By the names in `EvolutionStep.reached`.
    """
    last, positions = steps[-1], dict[str, float]()
    for key, surface in last.surfaces.items():
        for name in reached(surface, limits):
            whole, position = f"{key[0]}: {name}", last.position
            if len(steps) > 1:
                before, after = (worn_measures(step.surfaces[key])[LIMITS[name].measure] for step in steps[-2:])
                position -= (last.position - steps[-2].position) * (after - limits[name]) / (after - before)
            positions[whole] = min(position, positions.get(whole, position))
    return positions


@dataclass(frozen=True, eq=False)
class Evolution:
    """How profiles of a collective wear.

    Parameters
    ----------
    collective
        The states.
    laws
        Wear law of the wheels, the rails, or both; what has none keeps its profile.
    settings
        How far and how finely.

    Raises
    ------
    InputError
        If no body wears, states have different profiles of what wears, both wear without
        `EvolutionSettings.axles_per_km`, or a limit is one of what does not wear.

    """

    collective: Collective
    laws: Mapping[Role, WearLaw]
    settings: EvolutionSettings

    def __post_init__(self) -> None:
        if not self.laws:
            raise InputError("an evolution without wear laws", "a law for wheel, rail or both", "add one")
        self.collective.profiles(tuple(self.laws))
        if len(self.laws) == 2 and self.settings.axles_per_km is None:
            raise InputError(
                "wear of wheels and rails without axles_per_km",
                "axles that pass a point of the rails while a wheel runs 1 km",
                "give axles_per_km, or let one of them wear",
            )
        for name in self.settings.limits.written:
            role = LIMITS[name].role
            if role not in self.laws:
                raise InputError(f"limit {name} of {role}s, which do not wear", "limits of what wears", "leave it out")

    @property
    def unit(self) -> str:
        """Unit of the position."""
        return "km" if "wheel" in self.laws else "axles"

    def _per_unit(self, role: Role) -> float:
        """Distance in mm of a wheel, or axles on a rail, in one unit of the position."""
        if role == "wheel":
            return MM_PER_KM
        return 1.0 if self.unit == "axles" else float(self.settings.axles_per_km or 0.0)

    def run(self, file: Path | None = None, progress: Progress = lambda _: None) -> tuple[EvolutionStep, ...]:
        """Evolve to the end or the first limit.

        - `file`: SQLite file in which each step is stored when it is done; a run that was interrupted goes on from
          there with the same numbers. An `InputError` if it is that of other inputs.
        - `progress`: called with a sentence at each state.
        """
        store = None if file is None else StepStore(file, self.identity)
        steps = self._stored(store) if store else []
        if not steps:
            profiles = self.collective.profiles(tuple(self.laws))
            surfaces = {
                key: WornSurface(profile, spacing_mm=self.settings.spacing_mm) for key, profile in profiles.items()
            }
            none = {key: np.zeros(len(surface.depth)) for key, surface in surfaces.items()}
            steps.append(self._evaluated(0.0, surfaces, none, progress))
            if store:
                store.add(self._row_of(steps[-1]))
        while not self._ends(steps[-1]):
            steps.append(self._next(steps, progress))
            if store:
                store.add(self._row_of(steps[-1]))
        return tuple(steps)

    def _stored(self, store: "StepStore") -> list[EvolutionStep]:
        """Steps of a file up to the first one that ends the evolution: it may have run to another end or limit."""
        steps: list[EvolutionStep] = []
        try:
            for row in store.rows():
                steps.append(self._restored(row))
                if self._ends(steps[-1]):
                    break
        except (ValueError, KeyError, TypeError, sqlite3.Error) as reason:
            raise InputError(
                f"{store.file}: steps that cannot be read, {type(reason).__name__}",
                "steps as a run stored them",
                "take --fresh or another folder",
            ) from reason
        return steps

    def _ends(self, step: EvolutionStep) -> bool:
        return step.position >= self.settings.end or bool(step.reached)

    def _next(self, steps: list[EvolutionStep], progress: Progress) -> EvolutionStep:
        """Take a step by Heun's method, whose error is estimated by the difference from Euler's.

        Depth ``h (f0 + f1) / 2`` with rates ``f0`` at its start and ``f1`` after Euler's step ``h f0``; the difference
        ``h (f1 - f0) / 2`` falls with ``h^2``, and the next step is as long as it allows (Hairer, Norsett and Wanner,
        1993, Solving Ordinary Differential Equations I, II.4).
        """
        last, settings = steps[-1], self.settings
        fastest = max(float(rate.max()) for rate in last.rates.values())
        if fastest <= 0.0:
            raise InputError(
                "a collective in which nothing wears", "slip in some state", "check friction, curves and the laws"
            )
        way = min(settings.max_depth_mm / fastest, settings.end - last.position)
        if len(steps) > 1:
            way = min(way, (last.position - steps[-2].position) * self._stretch(last.error_mm))
        while True:
            # the end exactly, so that a run to it ends there
            end = settings.end if last.position + way >= settings.end * (1.0 - 1e-12) else last.position + way
            predicted = {key: surface.worn_by(way * last.rates[key]) for key, surface in last.surfaces.items()}
            there = self._evaluated(end, predicted, last.damage, progress, last.states)
            error = max(0.5 * way * float(np.abs(there.rates[key] - last.rates[key]).max()) for key in last.rates)
            if error <= settings.max_error_mm:
                break
            progress(f"an error of {error:.2g} mm is estimated: a shorter step")
            way *= self._stretch(error)
        half = 0.5 * way
        surfaces = {
            key: surface.worn_by(half * (last.rates[key] + there.rates[key])) for key, surface in last.surfaces.items()
        }
        damage = {
            key: summed + half * (last.damage_rates[key] + there.damage_rates[key])
            for key, summed in last.damage.items()
        }
        step = self._evaluated(end, surfaces, damage, progress, there.states)
        # what did not converge on the way is reported as well
        both = zip(step.states, there.states, strict=True)
        states = tuple(replace(state, message=state.message or other.message) for state, other in both)
        return replace(step, states=states, error_mm=error)

    def _stretch(self, error_mm: float) -> float:
        """Length of the next step over that of one with an error."""
        allowed = self.settings.max_error_mm / max(error_mm, np.finfo(float).tiny)
        return min(GROWTH, SAFETY_FACTOR * float(np.sqrt(allowed)))

    def _limits_of(self, surfaces: Mapping[SurfaceKey, WornSurface]) -> tuple[str, ...]:
        """Limits that are reached, with the role of the profile."""
        limits = self.settings.limits.written
        names = (f"{key[0]}: {name}" for key, surface in surfaces.items() for name in reached(surface, limits))
        return tuple(dict.fromkeys(names))

    def _evaluated(
        self,
        position: float,
        surfaces: Mapping[SurfaceKey, WornSurface],
        damage: Mapping[SurfaceKey, Floats],
        progress: Progress,
        near: Sequence[StateDamage] = (),
    ) -> EvolutionStep:
        """Solve all states on worn profiles.

        - `near`: states on profiles that differ little, from whose places the searches begin; without a place as anew.
        """
        deep = any(surface.depth.max() > MAX_COMPLIANCE_WEAR_MM for surface in surfaces.values())
        profiles = {key: surface.worn_body if deep else surface.worn for key, surface in surfaces.items()}
        if self.collective.is_symmetric:
            profiles = {(role, side): profiles[role, "right"] for role, side in profiles}
        rates, damage_rates = (
            {key: np.zeros(len(surface.depth)) for key, surface in surfaces.items()} for _ in range(2)
        )
        made, bodies = list[SpatialWheelset](), ElasticBodies()
        states, t_gamma, solved = [], 0.0, 0.0
        all_states, end = self.collective.states, self.settings.end
        for count, state in enumerate(all_states, 1):
            share = state.share
            progress(f"{position:.4g} of {end:.4g} {self.unit}, state {count} of {len(all_states)}")
            problem = self.collective.problem_with(state, profiles)
            start = near[count - 1].place if near else None
            try:
                result = _solved(SpatialWheelset(problem, {}), made, bodies, start)
                message = "" if result.status.converged else result.status.message
            except InputError as reason:
                message = reason.given
            if message:
                states.append(StateDamage(state.name, (), message))
                continue
            start = RollingPlace.of(result.equilibrium)
            states.append(StateDamage(state.name, tuple(patch_damage(result)), place=start))
            t_gamma += share * sum(patch.t_gamma_N for patch in states[-1].patches)
            solved += share
            for wear in row_wear(result, dict(self.laws)):
                widths = np.linalg.norm(np.diff(wear.ends, axis=1)[:, 0], axis=1)
                passes = wear.rates / np.where(wear.areas > 0.0, wear.areas, 1.0) if wear.role == "wheel" else 1.0
                for key, part in self.collective.worn_at(wear.role, wear.side).items():
                    surface, unit = surfaces[key], self._per_unit(wear.role) * share * part
                    rates[key] += unit * surface.deposited(wear.ends, wear.rates)
                    damage_rates[key] += unit * wear.damage * surface.deposited(wear.ends, widths * passes)
        if not solved:
            raise InputError(
                f"no state in equilibrium at {position:.4g} {self.unit}, {states[0].name}: {states[0].message}",
                "states that converge",
                "run the states as cases of their own",
            )
        # states without equilibrium wear as the mean of the others
        rates = {key: surfaces[key].filtered(rate / solved, self.settings.filter_mm) for key, rate in rates.items()}
        damage_rates = {key: rate / solved for key, rate in damage_rates.items()}
        return EvolutionStep(
            position,
            surfaces,
            rates,
            damage,
            damage_rates,
            tuple(states),
            t_gamma / solved,
            self._limits_of(surfaces),
        )

    @property
    def identity(self) -> str:
        """What the file of a run must agree in: version, states, laws and settings, but not the end and the limits."""
        settings = self.settings.model_dump(exclude={"end", "limits"})
        parts: list[object] = [
            OVER_PIECES,
            RollingPlace._fields,
            settings,
            self.laws,
            self.collective.separate,
            *(
                (state.share, state.problem, state.problem.track.rails, state.problem.wheels.profiles)
                for state in self.collective.states
            ),
        ]
        return content_key("evolution", *parts) or repr(self.laws)

    def _row_of(self, step: EvolutionStep) -> dict[str, Any]:
        """A step as JSON: numbers in it are kept to the last digit."""
        return {
            "position": step.position,
            "t_gamma_N": step.t_gamma_N,
            "error_mm": step.error_mm,
            "states": [asdict(state) for state in step.states],
            "depth": {" ".join(key): surface.depth.tolist() for key, surface in step.surfaces.items()},
            **{
                name: {" ".join(key): array.tolist() for key, array in getattr(step, name).items()}
                for name in OVER_PIECES
            },
        }

    def _restored(self, row: Mapping[str, Any]) -> EvolutionStep:
        profiles = self.collective.profiles(tuple(self.laws))

        def stored(name: str) -> dict[SurfaceKey, Floats]:
            return {key: np.array(row[name][" ".join(key)]) for key in profiles}

        depths = stored("depth")
        surfaces = {
            key: WornSurface(profile, depths[key], self.settings.spacing_mm) for key, profile in profiles.items()
        }
        states = tuple(
            StateDamage(
                state["name"],
                tuple(PatchDamage(**patch) for patch in state["patches"]),
                state["message"],
                None if state["place"] is None else RollingPlace(*state["place"]),
            )
            for state in row["states"]
        )
        return EvolutionStep(
            position=row["position"],
            surfaces=surfaces,
            states=states,
            t_gamma_N=row["t_gamma_N"],
            reached=self._limits_of(surfaces),
            error_mm=row["error_mm"],
            **{name: stored(name) for name in OVER_PIECES},
        )


def _solved(
    wheelset: SpatialWheelset, made: list[SpatialWheelset], bodies: ElasticBodies, near: RollingPlace | None
) -> SpatialResult:
    """Solve a state; equal bodies, and rigid geometry of equal wheelsets on equal tracks, are made once."""
    problem = wheelset.problem
    for other in made:
        if other.problem.bodies == problem.bodies:
            return solve_position(other.at(problem), {}, near=near)
    made.append(replace(wheelset, surfaces=running_surfaces(problem, cache=Cache.of_user(), done=bodies)))
    return solve_position(made[-1], {}, near=near)


class StepStore:
    """Steps of one evolution in an SQLite file; each is on the disk before the next one begins."""

    def __init__(self, file: Path, identity: str) -> None:
        self.file = file
        file.parent.mkdir(parents=True, exist_ok=True)
        try:
            with closing(sqlite3.connect(file)) as database, database:
                database.execute("CREATE TABLE IF NOT EXISTS evolution (identity TEXT NOT NULL)")
                database.execute("CREATE TABLE IF NOT EXISTS steps (number INTEGER PRIMARY KEY, content TEXT NOT NULL)")
                stored = database.execute("SELECT identity FROM evolution").fetchone()
                if stored is None:
                    database.execute("INSERT INTO evolution VALUES (?)", (identity,))
        except sqlite3.Error as reason:
            raise InputError(
                f"{file}: {reason}", "the file of an evolution, or none", "choose another folder"
            ) from reason
        if stored is not None and stored[0] != identity:
            raise InputError(
                f"{file} with steps of other inputs",
                "the inputs that it was begun with",
                "take --fresh or another folder",
            )

    def rows(self) -> list[dict[str, Any]]:
        """Stored steps in order."""
        with closing(sqlite3.connect(self.file)) as database:
            return [json.loads(text) for (text,) in database.execute("SELECT content FROM steps ORDER BY number")]

    def add(self, row: Mapping[str, Any]) -> None:
        """Store a step."""
        with closing(sqlite3.connect(self.file)) as database, database:
            database.execute("INSERT INTO steps (content) VALUES (?)", (json.dumps(row, default=float),))
