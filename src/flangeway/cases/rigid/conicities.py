"""Equivalent conicity over the amplitude, from profiles or from a file of a rolling radius difference."""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from flangeway.cases.case import Case
from flangeway.errors import InputError
from flangeway.railway.rigid.conicity import (
    REFERENCE_AMPLITUDE_MM,
    RollingRadiusDifference,
    conicity_by_regression,
    equivalent_conicity,
    motion_middles,
    read_rolling_radius_difference,
)
from flangeway.system.versions import versions
from flangeway.types import Floats

STEP_MM = 0.1
FIRST_MM = 0.5


@dataclass(frozen=True, eq=False)
class Conicities:
    """Equivalent conicity over the amplitude.

    Parameters
    ----------
    amplitudes_mm, integration, regression
        Amplitudes, and conicity by integration and by linear regression, (n,); empty if the wheelset does not steer.
    notices
        Sentences on amplitudes without a conicity.

    """

    amplitudes_mm: Floats
    integration: Floats
    regression: Floats
    notices: tuple[str, ...]

    def at_reference(self) -> dict[str, float] | None:
        """Conicity at the reference amplitude; None where it is not computed."""
        at = np.flatnonzero(np.abs(self.amplitudes_mm - REFERENCE_AMPLITUDE_MM) < 1e-6)
        if not len(at):
            return None
        found = (float(each[at[0]]) for each in (self.amplitudes_mm, self.integration, self.regression))
        return dict(zip(("amplitude_mm", "integration", "regression"), found, strict=True))


def conicities_of(difference: RollingRadiusDifference, maximum_mm: float | None) -> Conicities:
    """Conicity at amplitudes 0.1 mm apart, as far as the difference is given.

    Parameters
    ----------
    difference
        Rolling radius difference.
    maximum_mm
        Maximum amplitude; None: as far as the difference goes.

    """
    none: Floats = np.zeros(0)
    try:
        middle = difference.centred_mm
    except InputError as error:
        return Conicities(none, none, none, (f"no equivalent conicity: {error.given}",))
    room = min(middle - float(difference.lateral_mm[0]), float(difference.lateral_mm[-1]) - middle)
    maximum = room if maximum_mm is None else min(maximum_mm, room)
    amplitudes = np.arange(round(FIRST_MM / STEP_MM), math.floor(maximum / STEP_MM + 1e-9) + 1.0) * STEP_MM
    outside = np.isnan(motion_middles(difference, amplitudes))
    amplitudes = amplitudes[: np.argmax(outside)] if outside.any() else amplitudes
    notices = []
    reached = float(amplitudes[-1]) if len(amplitudes) else 0.0
    if maximum_mm is not None and reached < math.floor(maximum_mm / STEP_MM + 1e-9) * STEP_MM - 1e-6:
        notices.append(f"conicity only up to an amplitude of {reached:.1f} mm")
    found = equivalent_conicity(difference, amplitudes) if len(amplitudes) else none
    pushed = amplitudes[np.isnan(found)]
    if len(pushed):
        notices.append(
            f"no equivalent conicity by integration at {len(pushed)} amplitudes from {pushed[0]:.1f} to "
            f"{pushed[-1]:.1f} mm: the rolling radius difference pushes the wheelset away from the middle"
        )
    regression = conicity_by_regression(difference, amplitudes) if len(amplitudes) else none
    return Conicities(amplitudes, found, regression, tuple(notices))


@dataclass(frozen=True, eq=False)
class ConicityRun:
    """Equivalent conicity from a file.

    Parameters
    ----------
    difference
        Content of the file.
    conicities
        Conicity over the amplitude.
    summary
        Content of ``geometry.json``.

    """

    difference: RollingRadiusDifference
    conicities: Conicities
    summary: dict[str, Any]


class ConicityCase(Case):
    """Inputs for the conicity of a rolling radius difference."""

    name: ClassVar[str] = "conicity"
    title: ClassVar[str] = "Equivalent conicity of a rolling radius difference"

    unit: Literal["mm", "cm", "m", "in", "ft"] | None = Field(
        None, description="unit of both columns; that of the file if left out"
    )
    maximum_amplitude_mm: float | None = Field(
        None, ge=FIRST_MM, le=30.0, description="maximum amplitude; as far as the difference is given if left out"
    )


def run_conicity(file: Path, values: Mapping[str, Any]) -> ConicityRun:
    """Read a rolling radius difference and compute its conicity.

    Parameters
    ----------
    file
        See `flangeway.railway.rigid.conicity.read_rolling_radius_difference`.
    values
        Inputs of a `ConicityCase`.

    Raises
    ------
    InputError
        If the file cannot be read as a rolling radius difference, or an input is wrong.

    """
    start = time.perf_counter()
    case = ConicityCase.from_values(values)
    difference = read_rolling_radius_difference(file, case.unit)
    conicities = conicities_of(difference, case.maximum_amplitude_mm)
    summary = {
        "case": file.stem,
        "title": f"Equivalent conicity of the rolling radius difference in {file.name}",
        "inputs": {"file": str(file), **case.model_dump()},
        "lateral_without_difference_mm": difference.centred_mm if len(conicities.amplitudes_mm) else None,
        "equivalent_conicity": conicities.at_reference(),
        "notices": list(conicities.notices),
        "versions": versions(),
        "timings_s": {"total": time.perf_counter() - start},
    }
    return ConicityRun(difference, conicities, summary)
