"""Identifiers and texts use the terms of the field; words that were replaced by such a term do not come back."""

import ast
import itertools
import re
from pathlib import Path

import pytest

from tests.architecture.conftest import MODULES, PACKAGE, TREES

ROOT = PACKAGE.parents[1]
PAGES = sorted([*ROOT.glob("docs/**/*.md"), *ROOT.glob("*.md")])
RESOURCES = sorted(path for path in PACKAGE.glob("report/**/*.[hj]*") if "libraries" not in path.parts)

IN_NAMES = {
    "aside": "offset", "balance": "residual, equilibrium", "balances": "equilibria", "barycentre": "centre of gravity",
    "bears": "carries", "borne": "carried", "demands": "targets", "doubt": "check", "doubts": "checks",
    "farthest": "maximum", "journey": "continuation", "judged": "checked", "judgement": "checks",
    "lane": "position", "lanes": "positions", "largest": "maximum", "likewise": "the same",
    "mended": "repaired", "mending": "repair", "said": "reported", "say": "weight", "says": "reports",
    "scatters": "oscillates", "stand": "side pose", "stands": "side poses", "surroundings": "surface positions",
    "tells": "reports", "throat": "flange root", "told": "reported", "unlike": "different",
    "contact place": "contact position", "rail place": "position on the rail", "wheel place": "position on the wheel",
    "near places": "near positions", "rigid rest": "rigid equilibrium", "known rest": "cached equilibrium",
    "at rest": "in rigid equilibrium", "missed contact": "overlap outside the contact zone",
    "missed overlap": "overlap outside the contact zone",
}  # fmt: skip
"""Words of identifiers, keys and names of modules, one or two in a row, with the term to use instead."""

ALLOWED = {"out_of_balance"}
"""A term of the field that contains one of these words."""

IN_TEXTS = {
    r"told|tells": "reported, reports",
    r"barycentre": "centre of gravity",
    r"throats?": "flange root",
    r"borne|bears": "carried, carries",
    r"judged|judgement": "checked",
    r"doubts": "checks, warnings",
    r"mend(?:s|ed|ing)?": "repair",
    r"likewise": "in the same way",
    r"unlike": "different, not as",
    r"farthest(?! point from the axle)": "maximum",
    r"gives? way": "deflects",
    r"stands as": "used for",
    r"the seed": "Moherdaui (2021)",
    r"in balance|balance of (?:the )?forces|rigid balances?|resulting errors?": "equilibrium, residual",
    r"comes? to rest": "rigid equilibrium",
    r"scatter of the nodes|scatters (?:by|from node)": "pressure oscillation",
    r"largest (?:in-plane |shear |contact |von Mises )?"
    r"(?:stress(?:es)?|pressures?|shear|force|displacement|overlap|compression|tension|penetration)": "maximum",
    r"along the track \((?:right|left)": "lateral, in the track plane",
    r"what to believe": "validity and limits",
    r"beyond the scale": "out-of-range values are clipped",
    r"drawn closer together": "brought together",
    r"is kept off": "constraint enforcement",
}
"""Words in docstrings, messages, titles and pages, with what to write instead."""

NO_NAMES = {"each", "found", "insides", "mine"}
"""Names that do not say what a thing is: `solution`, `patch`, `rows_of_contact` do."""

TEXT = re.compile(rf"\b(?:{'|'.join(IN_TEXTS)})\b", re.IGNORECASE)


def names_of(tree: ast.Module) -> set[str]:
    """Return the names that a module defines or uses, and its texts that are keys or names for programs."""
    found = set()
    for node in ast.walk(tree):
        match node:
            case ast.ClassDef(name=name) | ast.FunctionDef(name=name) | ast.Name(id=name) | ast.alias(name=name):
                found.add(name)
            case ast.Attribute(attr=name) | ast.arg(arg=name) | ast.keyword(arg=str() as name):
                found.add(name)
            case ast.Constant(value=str() as name) if re.fullmatch(r"\w+_\w+|[a-z]+", name):
                found.add(name)
            case _:
                pass
    return found


def terms_for(name: str) -> list[str]:
    """Return the terms to use instead of the words of a name."""
    words = [part.lower() for part in re.findall(r"[a-z]+|[A-Z][a-z]*", name)]
    pairs = [" ".join(pair) for pair in itertools.pairwise(words)]
    return [IN_NAMES[word] for word in words + pairs if word in IN_NAMES]


def found_in(text: str) -> list[str]:
    """Return the words of a text that have a term of the field."""
    return [found.group() for found in TEXT.finditer(" ".join(text.split()))]


@pytest.mark.parametrize("module", MODULES)
def test_identifiers_and_keys_are_terms_of_the_field(module: str) -> None:
    """No identifier, no key and no name of a module has a word that was replaced; a failure shows the term to use."""
    names = names_of(TREES[module]) | {*module.split(".")}
    assert {name: terms_for(name) for name in sorted(names - ALLOWED) if terms_for(name)} == {}


@pytest.mark.parametrize("module", MODULES)
def test_names_say_what_a_thing_is(module: str) -> None:
    """No identifier and no key is a name that fits anything."""
    assert names_of(TREES[module]) & NO_NAMES == set()


@pytest.mark.parametrize("module", MODULES)
def test_texts_of_modules_are_in_terms_of_the_field(module: str) -> None:
    """No docstring, message or title has a word that was replaced."""
    texts = [node.value for node in ast.walk(TREES[module]) if isinstance(node, ast.Constant)]
    assert [word for text in texts if isinstance(text, str) for word in found_in(text)] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_pages_are_in_terms_of_the_field(page: Path) -> None:
    """No page of the documentation has a word that was replaced."""
    assert found_in(page.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("part", RESOURCES, ids=lambda path: path.name)
def test_texts_of_the_report_are_in_terms_of_the_field(part: Path) -> None:
    """No label or note of the report's page has a word that was replaced; "told" is an identifier of its scripts."""
    assert {*found_in(part.read_text(encoding="utf-8"))} <= {"told"}
