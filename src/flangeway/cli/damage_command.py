"""``flangeway damage``."""

import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flangeway.cli.app import app
from flangeway.cli.common import (
    Fresh,
    Out,
    Show,
    command_typed,
    completion,
    results_folder,
    shows_results,
)

if TYPE_CHECKING:
    from flangeway.cases.damage.damage_file import DamageInputs

STEPS_FILE = "damage.sqlite"


@app.command()
@shows_results
def damage(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="A file with states, wear laws and an end (.toml).",
            autocompletion=completion(list, ".toml"),
        ),
    ],
    out: Out = None,
    fresh: Fresh = False,
    *,
    show: Show,
) -> bool:
    """Let the profiles of wheels and rails wear over a collective of states: depths, limits, fatigue (out/FILE)."""
    from flangeway.cases.damage.damage_file import DamageFile  # noqa: PLC0415

    return run_strategies(DamageFile.read(file).strategies(), results_folder(out, file.stem), show, fresh=fresh)


def run_strategies(strategies: "dict[str, DamageInputs]", folder: Path, show: Show, *, fresh: bool) -> bool:
    """Let profiles wear by all strategies and show what was found; whether all states converged."""
    from flangeway.report.damage.damage_record import damage_record  # noqa: PLC0415
    from flangeway.report.damage.strategies_record import strategies_record  # noqa: PLC0415

    units, runs = show.units or "metric", {}
    for name, inputs in strategies.items():
        into = results_folder(folder / name if len(strategies) > 1 else folder, name)
        store = into / STEPS_FILE
        if fresh:
            store.unlink(missing_ok=True)
        begun = time.perf_counter()
        with show.progress(f"what is done is kept in {store}") as progress:
            steps = inputs.evolution.run(store, progress)
        record = damage_record(inputs, steps, command_typed(), time.perf_counter() - begun, units)
        show.record(record, into, partial(list, [store]), last=len(strategies) == 1)
        runs[name] = steps, record
    if len(runs) > 1:
        show.record(strategies_record(strategies, runs, command_typed(), units), folder)
    return all(record.converged for _, record in runs.values())
