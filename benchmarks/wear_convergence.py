"""What steps, spacing of the collective and cells change in worn profiles.

``python -m benchmarks.wear_convergence FILE FOLDER [NAME...]`` runs a damage file as it is, with half the steps (half
the depth, a quarter of the error), half the spacing of its states, and cells of half the size, or those named of these.
It prints a table in Markdown: the depth at the end, and the greatest change of the depth of a profile over the depth of
the run as it is, and the change of the worn area. Steps are kept in the folder; what was interrupted goes on.
"""

import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from flangeway.cases.damage_file import DamageFile
from flangeway.railway.damage.collective import COLLECTIVES, ranges_of
from flangeway.railway.damage.evolution import EvolutionSettings, EvolutionStep

VARIANTS = ("as it is", "half the steps", "half the spacing", "half the cells")


def varied(file: DamageFile, variant: str) -> DamageFile:
    """Return the file of a variant."""
    data = {key: value for key, value in file.data.items() if key not in ("collective", "strategies")}
    states = COLLECTIVES.get(file.data.get("collective", "")) or data["states"]
    evolution, inputs = dict(data["evolution"]), dict(data["inputs"])
    if variant == "half the spacing":
        states = [state | {"parts": 2 * state.get("parts", 1)} if ranges_of(state) else state for state in states]
    elif variant == "half the steps":
        for key, part in (("max_depth_mm", 2.0), ("max_error_mm", 4.0)):
            evolution[key] = evolution.get(key, getattr(EvolutionSettings(end=1.0), key)) / part
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
