"""What steps, spacing of the collective and cells change in worn profiles.

``python -m benchmarks.wear_convergence FILE FOLDER [NAME...]`` runs a damage file as it is, with half the steps (half
the depth, a quarter of the error), half the spacing of its states, and cells of half the size, or those named of these.
It prints a table in Markdown: the depth at the end, and the greatest change of the depth of a profile over the depth of
the run as it is, and the change of the worn area. Steps are kept in the folder; what was interrupted goes on.
"""

import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flangeway.cases.damage.damage_file import DamageFile
from flangeway.railway.damage.collective import COLLECTIVES
from flangeway.railway.damage.evolution import EvolutionSettings, EvolutionStep

RADIUS, SHARE = "curve_radius_m", "share"
VARIANTS = ("as it is", "half the steps", "half the spacing", "half the cells")


def moved(states: Sequence[Mapping[str, Any]], offset: float) -> list[dict[str, Any]]:
    """Return the inputs of states (n,) towards their neighbours, with their shares as they are.

    Neighbours are next in gauge and yaw on straight track, and next in curvature in curves of one hand. All inputs that
    these have as numbers move together, by an offset in the mean distance of both neighbours, along curvature and not
    radius. An offset up to 1/2 leads no curve beyond half of its curvature.
    """
    found = [dict(state) for state in states]
    groups: dict[float, list[int]] = {}
    for number, state in enumerate(states):
        groups.setdefault(float(np.sign(state.get(RADIUS, 0.0))), []).append(number)
    for hand, members in groups.items():
        members.sort(key=lambda number: _order(states[number]))
        common = [key for key in states[members[0]] if all(_is_number(states[number].get(key)) for number in members)]
        linear = [key for key in common if key != SHARE]
        rows = np.array([[_linear(key, states[number][key]) for key in linear] for number in members])
        slopes = np.gradient(rows, axis=0) if len(members) > 1 else np.zeros_like(rows)
        for number, row, slope in zip(members, rows, slopes, strict=True):
            share = 1.0
            if hand and slope[linear.index(RADIUS)]:
                at = linear.index(RADIUS)
                share = min(1.0, abs(row[at] / slope[at]))
            inputs = (row + offset * share * slope).tolist()
            found[number] |= {key: _linear(key, value) for key, value in zip(linear, inputs, strict=True)}
    return found


def _order(state: Mapping[str, Any]) -> tuple[float, ...]:
    return (1.0 / state[RADIUS],) if RADIUS in state else (state.get("gauge_mm", 0.0), state.get("yaw_mrad", 0.0))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _linear(key: str, value: float) -> float:
    """Curvature of a radius, and radius of a curvature; other inputs as they are."""
    return 1.0 / value if key == RADIUS else float(value)


def halved(states: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Two states for each, a quarter of the way to both of its neighbours, so that their mean is it."""
    both = zip(*(moved(states, offset) for offset in (-0.25, 0.25)), strict=True)
    return [{**state, SHARE: state[SHARE] / 2.0} for pair in both for state in pair]


def varied(file: DamageFile, variant: str) -> DamageFile:
    """Return the file of a variant."""
    data = {key: value for key, value in file.data.items() if key not in ("collective", "strategies")}
    bundled = COLLECTIVES.get(file.data.get("collective", ""), ())
    states = [state.values | {SHARE: state.share} for state in bundled] or data["states"]
    evolution, inputs = dict(data["evolution"]), dict(data["inputs"])
    if variant == "half the spacing":
        states = halved(states)
    elif variant == "half the steps":
        for key, part in (("max_depth_mm", 2.0), ("max_error_mm", 4.0)):
            evolution[key] = evolution.get(key, getattr(EvolutionSettings(1.0), key)) / part
    elif variant == "half the cells":
        inputs["patch_cells"] *= 2
    return replace(file, data=data | {"states": states, "evolution": evolution, "inputs": inputs})


def main(file: DamageFile, folder: Path, variants: Sequence[str]) -> None:
    """Print the table."""
    print("| run | states | steps | unconverged | processor, s | depth, mm | change of the profile | of the area |")
    print("|---|---|---|---|---|---|---|---|")
    base: EvolutionStep | None = None
    for variant in variants:
        begun = time.process_time()
        evolution = varied(file, variant).damage().evolution
        steps = evolution.run(folder / f"{variant.replace(' ', '-')}.sqlite", lambda text: print(text, file=sys.stderr))
        seconds, last = time.process_time() - begun, steps[-1]
        base = base or last
        unconverged = sum(len(step.unconverged) for step in steps)
        for (role, side), surface in last.surfaces.items():
            other = base.surfaces[role, side]
            change = 100.0 * np.abs(surface.depth - other.depth).max() / other.depth.max()
            area = 100.0 * (surface.worn_area_mm2 / other.worn_area_mm2 - 1.0)
            print(
                f"| {variant}: {side} {role} | {len(last.states)} | {len(steps) - 1} | {unconverged} | {seconds:.0f} "
                f"| {surface.depth.max():.3f} | {change:.1f} % | {area:+.1f} % |",
                flush=True,
            )


if __name__ == "__main__":
    main(DamageFile.read(Path(sys.argv[1])), Path(sys.argv[2]), sys.argv[3:] or VARIANTS)
