"""What stands at the end of the last step of an Abaqus deck: refusals, amplitudes, and rows that steps replace."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flangeway.errors import InputError
from flangeway.mesh.abaqus_assembly import DeckBlock

Label = tuple[str, str]
"""What a row is about: a set, and a component or a type of load."""

LABELLED = ("BOUNDARY", "CLOAD", "DSLOAD", "DLOAD")
READ = (
    *("PART", "END PART", "ASSEMBLY", "END ASSEMBLY", "INSTANCE", "END INSTANCE", "NODE", "ELEMENT", "NSET", "ELSET"),
    *("SURFACE", "SOLID SECTION", "MATERIAL", "ELASTIC", "DENSITY", "SURFACE INTERACTION", "SURFACE BEHAVIOR"),
    *("FRICTION", "CONTACT PAIR", "AMPLITUDE", "STEP", "STATIC", "END STEP", *LABELLED),
)
PASSED = (
    *("HEADING", "PREPRINT", "SECTION CONTROLS", "HOURGLASS STIFFNESS", "EXPANSION", "CONDUCTIVITY", "SPECIFIC HEAT"),
    *("DAMPING", "CONTACT CONTROLS", "CONTROLS", "RESTART", "PRINT", "FILE FORMAT", "MONITOR", "TIME POINTS", "FILTER"),
    *("OUTPUT", "NODE OUTPUT", "ELEMENT OUTPUT", "CONTACT OUTPUT", "ENERGY OUTPUT", "NODE PRINT", "EL PRINT"),
    *("CONTACT PRINT", "SECTION PRINT", "ENERGY PRINT", "NODE FILE", "EL FILE", "CONTACT FILE", "SECTION FILE"),
    *("ENERGY FILE", "ELEMENT MATRIX OUTPUT", "DIAGNOSTICS", "PHYSICAL CONSTANTS"),
)
"""Keywords without effect on a static, linear answer."""

ALLOWED = {
    "NSET": ("NSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"),
    "ELSET": ("ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"),
    "BOUNDARY": ("OP", "AMPLITUDE"),
    "CLOAD": ("OP", "AMPLITUDE"),
    "DSLOAD": ("OP", "AMPLITUDE"),
    "DLOAD": ("OP", "AMPLITUDE"),
    "STATIC": ("DIRECT", "SOLVER", "STABILIZE", "ALLSDTOL", "CONTINUE", "FULLY PLASTIC"),
    "STEP": ("NAME", "NLGEOM", "INC", "AMPLITUDE", "UNSYMM", "EXTRAPOLATION", "CONVERT SDI", "SOLVER"),
    "AMPLITUDE": ("NAME", "TIME", "VALUE", "DEFINITION"),
    "FRICTION": (),
    "SURFACE BEHAVIOR": ("PRESSURE-OVERCLOSURE", "AUGMENTED LAGRANGE", "PENALTY", "DIRECT"),
    "CONTACT PAIR": (
        *("INTERACTION", "TYPE", "SMALL SLIDING", "SMOOTH", "TRACKING", "MECHANICAL CONSTRAINT", "CPSET", "ADJUST"),
        *("NO THICKNESS", "SUPPLEMENTARY CONSTRAINTS", "HCRIT", "EXTENSION ZONE", "GEOMETRIC CORRECTION"),
    ),
}
"""Parameters of keywords of which others would change the answer."""


@dataclass(frozen=True)
class Row:
    """A data line that stands at the end.

    Parameters
    ----------
    block
        Its keyword.
    number
        Its place among the keyword's data lines.
    factor
        Value of its amplitude at the end of its step.

    """

    block: DeckBlock
    number: int
    factor: float

    @property
    def where(self) -> str:
        """Its set or surface."""
        return self.block.rows[self.number][0]


class DeckHistory:
    """Steps of a deck.

    Parameters
    ----------
    file
        The deck, for messages.
    blocks
        Its keywords, parts written out.

    Raises
    ------
    InputError
        If there is a keyword or a parameter that may change the answer and is not read.

    """

    def __init__(self, file: Path, blocks: Sequence[DeckBlock]) -> None:
        self.file, self.blocks = file, blocks
        for block in blocks:
            self._refuse(block)
        self.steps: list[list[DeckBlock]] = [[]]
        for block in blocks:
            if block.keyword == "STEP":
                self.steps.append([])
            self.steps[-1].append(block)

    def last(self, keyword: str, labels: Callable[[DeckBlock, int], Iterable[Label]]) -> Iterator[tuple[Label, Row]]:
        """Labels and rows of a keyword that stand at the end of the last step.

        A step takes over all rows of the steps before it. ``OP=NEW`` removes them; a row of a label that has one
        already replaces it. Rows of one step with one label stand together.

        Parameters
        ----------
        keyword
            The keyword.
        labels
            Of a block and the number of a row, what the row is about; one row about several things is given for each.

        """
        standing: dict[Label, tuple[int, list[Row]]] = {}
        for number, step in enumerate(self.steps):
            mine = [block for block in step if block.keyword == keyword]
            if any(block.parameters.get("OP", "MOD").upper() == "NEW" for block in mine):
                standing = {}
            for block in mine:
                factor = self._factor(block, step)
                for row in range(len(block.rows)):
                    for label in labels(block, row):
                        since, rows = standing.get(label, (number, []))
                        kept = rows if since == number else []
                        standing[label] = (number, [*kept, Row(block, row, factor)])
        for label, (_, rows) in standing.items():
            for found in rows:
                yield label, found

    def wrong(self, block: DeckBlock, given: str, allowed: str, advice: str = "") -> InputError:
        """Error that names the deck, the keyword and its line."""
        return InputError(
            f"{self.file}, {block.place}: {given}",
            allowed,
            advice or "change it, or write a case file that names the deck as file and says the rest",
        )

    def _refuse(self, block: DeckBlock) -> None:
        if block.keyword not in (*READ, *PASSED):
            allowed = "linear elastic bodies in frictionless contact pairs, in static steps"
            raise self.wrong(block, f"*{block.keyword}", allowed)
        parameters = ALLOWED.get(block.keyword)
        for name, value in block.parameters.items():
            if parameters is not None and name not in parameters:
                raise self.wrong(block, f"the parameter {name}", ", ".join(parameters) or "no parameter")
            if name == "ADJUST" and not _is_zero(value):
                raise self.wrong(block, f"ADJUST={value}", "nodes where they are", "move them in the deck")
            if (name, value.upper()) == ("VALUE", "ABSOLUTE"):
                raise self.wrong(block, "VALUE=ABSOLUTE", "relative amplitudes")
        if block.keyword == "SURFACE":
            self._refuse_surface(block)

    def _refuse_surface(self, block: DeckBlock) -> None:
        kind = block.parameters.get("TYPE", "ELEMENT").upper()
        if kind not in ("ELEMENT", "NODE"):
            raise self.wrong(block, f"TYPE={kind}", "ELEMENT or NODE")
        faces = [row[1].upper() for row in block.rows if kind == "ELEMENT" and len(row) > 1]
        for face in faces:
            if face not in ("", "S1", "S2", "S3", "S4"):
                raise self.wrong(block, f"the face {face}", "S1 to S4, or none for the whole rim of the elements")

    def _factor(self, block: DeckBlock, step: Sequence[DeckBlock]) -> float:
        """Value of a block's amplitude at the end of its step; 1 without."""
        name = block.parameters.get("AMPLITUDE", "").upper()
        if not name:
            return 1.0
        for curve in self.blocks:
            if curve.keyword == "AMPLITUDE" and curve.parameters.get("NAME", "").upper() == name:
                kinds = [curve.parameters.get(key, "").upper() for key in ("DEFINITION", "TIME")]
                if kinds[0] not in ("", "TABULAR", "SMOOTH STEP") or kinds[1] not in ("", "STEP TIME"):
                    raise self.wrong(curve, f"an amplitude of {kinds[0] or kinds[1]}", "tables over the time of a step")
                words = [self._real(curve, word) for row in curve.rows for word in row if word]
                times, values = words[::2], words[1::2]
                if not values or len(times) != len(values) or (np.diff(times) <= 0.0).any():
                    raise self.wrong(curve, f"{len(words)} numbers", "pairs of time and value, times rising")
                if kinds[0] == "SMOOTH STEP" and self._period(step) < times[-1]:
                    raise self.wrong(curve, "a step that ends before the smooth step", "its last time in the step")
                return float(np.interp(self._period(step), times, values))
        raise self.wrong(
            block, f"the amplitude {name}", "an amplitude of the deck", "add *AMPLITUDE, or correct the name"
        )

    def _period(self, step: Sequence[DeckBlock]) -> float:
        for block in step:
            if block.keyword == "STATIC" and block.rows and len(block.rows[0]) > 1 and block.rows[0][1]:
                return self._real(block, block.rows[0][1])
        return 1.0

    def _real(self, block: DeckBlock, word: str) -> float:
        try:
            return float(word.upper().replace("D", "E"))
        except ValueError as reason:
            raise self.wrong(block, word, "numbers") from reason


def _is_zero(word: str) -> bool:
    try:
        return float(word) == 0.0
    except ValueError:
        return False
