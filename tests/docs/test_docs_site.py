"""The documentation's site, theory, how-tos, keys of a summary: every page, link, name and number is the program's."""

import importlib
import re
import runpy
import shlex
from pathlib import Path

import pytest

import flangeway
from flangeway.cases import CASES, load_case
from flangeway.cases.case_file import FORMAT
from flangeway.railway.profiles.profile_file import READABLE
from flangeway.tables import write_table
from flangeway_studies.cook import NEARLY_INCOMPRESSIBLE_WORK, CookCode, solve_cook
from tests.tables.conftest import few_points, small

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
MENU = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:\n")[2]
FOLDERS = {path.parent.name for path in Path(flangeway.__file__).parent.glob("*/*.py")} - {"cli", "report"}
LAST_EQUATION = 139  # of chapter 3
MAX_PICTURE = 150_000


def name_of(path):
    return path.relative_to(DOCS).as_posix()


def table_rows():
    """Rows of the table of equations: number, what it is, and what computes it."""
    text = (DOCS / "theory" / "equations.md").read_text(encoding="utf-8")
    return re.findall(r"^\| \(3\.(\d+)\) \| (.+?) \| (.+) \|$", text, flags=re.MULTILINE)


def found(path):
    """Return what a dotted path names, importing as many of its parts as are modules."""
    parts = path.split(".")
    for n_modules in range(len(parts), 0, -1):
        try:
            thing = importlib.import_module(".".join(parts[:n_modules]))
        except ModuleNotFoundError:
            continue
        for part in parts[n_modules:]:
            if part in getattr(thing, "__dataclass_fields__", {}):
                return part
            thing = getattr(thing, part)
        return thing
    raise AssertionError(f"{path} is not there")


def anchors_of(page):
    """Anchors of a page's headings, as the site makes them."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    headings = re.findall(r"^#+ (.+)$", text, flags=re.MULTILINE)
    return {re.sub(r"[\s-]+", "-", re.sub(r"[^\w\s-]", "", each.replace("`", "")).strip().lower()) for each in headings}


def test_every_page_is_in_the_menu_once():
    """The menu names each page of the documentation once, and no other."""
    listed = re.findall(r"[\w/-]+\.md", MENU)
    notebooks = {name_of(path.with_suffix(".md")) for path in DOCS.glob("notebooks/*.ipynb")}
    assert sorted(listed) == sorted({name_of(page) for page in PAGES} | notebooks)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_link_within_the_site_leads_somewhere(page):
    """Every relative link leads to a file in the site, and to a heading or a name that is there."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target, _, anchor in (link.partition("#") for link in re.findall(r"\]\(([^)\s:]+)\)", text)):
        file = (page.parent / target).resolve() if target else page
        if file.parent.name == "notebooks":  # a page that docs/hooks.py makes
            file = file.with_suffix(".ipynb")
        if file.parent == DOCS / "examples":  # a notebook that it makes of an example
            assert (DOCS.parent / "examples" / "gallery" / f"{file.stem}.py").is_file(), target
            continue
        assert file.is_file(), target
        assert file.is_relative_to(DOCS), f"{target} is not part of the site"
        if anchor.startswith(("flangeway.", "flangeway_studies.")):
            assert file.stem in anchor.split(".")[:2], anchor
            assert found(anchor) is not None, anchor
        elif anchor:
            assert anchor in anchors_of(file), f"{target}#{anchor}"


def test_every_equation_of_chapter_3_has_its_row_in_order():
    """The table has each number from (3.1) to the last once, in order, with words and what computes it."""
    rows = table_rows()
    assert [int(number) for number, _, _ in rows] == list(range(1, LAST_EQUATION + 1))
    assert all(what.strip() for _, what, _ in rows)


def test_what_computes_an_equation_can_be_imported_under_the_name_shown():
    """Each row links a function or class by its name, or says that none computes the equation, and why."""
    for number, _, cell in table_rows():
        links = re.findall(r"\[`([\w.]+)`\]\(\.\./reference/(\w+)\.md#([\w.]+)\)", cell)
        assert links, number
        for shown, page, anchor in links:
            assert anchor.startswith((f"flangeway.{page}.", f"{page}.")), anchor
            assert found(anchor) is not None
            # a field of frozen data is explained with its class
            home = anchor if anchor.endswith(shown) else f"{anchor}.{shown.rpartition('.')[2]}"
            assert home.endswith(shown), f"(3.{number}): {shown} at {anchor}"
            assert found(home) is not None
        assert not cell.startswith("*none*") or len(cell.partition(": ")[2]) > 10, number


def test_each_folder_has_a_page_in_the_reference():
    """The reference has a page for each folder that computes, made from the folder of that name."""
    pages = {page.stem: page.read_text(encoding="utf-8") for page in (DOCS / "reference").glob("*.md")}
    assert set(pages) >= FOLDERS
    for name, text in pages.items():
        assert re.findall(r"^::: (\S+)$", text, flags=re.MULTILINE) == (
            []
            if name in {"index", "command-line", "summary"}
            else ["flangeway_studies" if name == "studies" else f"flangeway.{name}"]
        )


def test_pictures_of_the_gallery_are_small_and_all_shown():
    """No picture of the gallery is larger than 150 kB, and none lies about unused."""
    text = (DOCS / "gallery.md").read_text(encoding="utf-8")
    pictures = list((DOCS / "images").glob("gallery-*.png"))
    assert len(pictures) >= 5
    for picture in pictures:
        assert picture.stat().st_size < MAX_PICTURE, picture.name
        assert picture.name in text


@pytest.mark.ci
def test_commands_of_the_gallery_write_the_pictures_it_names(call, tmp_path):
    """Each command of the gallery ends well and writes every picture that is named under it."""
    text = (DOCS / "gallery.md").read_text(encoding="utf-8")
    parts = re.findall(r"```sh\n.venv/bin/flangeway ([^\n]+)\n```\n(.*?)(?=\n## )", text, flags=re.DOTALL)
    assert len(parts) == text.count("```sh")
    for line, below in parts:
        arguments = shlex.split(line)
        code, _, err = call(*arguments)
        assert code == 0, err
        pictures = re.findall(r"^(?:.* )?`([\w-]+\.png)`:$", below, flags=re.MULTILINE)
        assert pictures, line
        folder = tmp_path / arguments[arguments.index("--out") + 1]
        assert all((folder / picture).stat().st_size > 0 for picture in pictures)


@pytest.mark.parametrize("page", [page for page in PAGES if "```" in page.read_text(encoding="utf-8")], ids=name_of)
def test_a_page_with_code_is_followed_by_a_test(page):
    """Some file of the tests names each page that has blocks of code, other than what programs print."""
    kinds = set(re.findall(r"^```(\w+)$", page.read_text(encoding="utf-8"), flags=re.MULTILINE))
    if kinds <= {"text", "console"}:
        return
    texts = [test.read_text(encoding="utf-8") for test in (ROOT / "tests").rglob("test_*.py")]
    names = f'"{page.name}"', f'"{page.stem}"', name_of(page)
    assert any(name in text for text in texts for name in names)


OF_EVERY_RUN = {"status", "case", "timings_s", "peak_memory_MB", "versions"}


SCRIPT = runpy.run_path(str(Path(__file__).parents[2] / ".ci" / "summary_page.py"))
"""What writes it."""


def keys_of(content):
    """Keys of numbers in mappings and in lists of mappings; those of tables are named in headings."""
    for key, value in content.items():
        rows = [value] if isinstance(value, dict) else value if isinstance(value, list) else []
        inner = [row for row in rows if isinstance(row, dict)]
        yield from (name for row in inner for name in keys_of(row)) if inner else (() if value == [] else (key,))


def test_the_page_is_what_the_quantities_say():
    """The page is the one that its script writes."""
    assert SCRIPT["PAGE"].read_text(encoding="utf-8") == SCRIPT["page"](), "run python .ci/summary_page.py"


@pytest.mark.parametrize(
    ("name", "inputs"),
    [
        ("hertz", {"size_mm": 1.0}),
        ("rolling-patch", {"cells_along": 8, "cells_across": 8, "curve_points": 3}),
        ("wheelset-tangent", {"size_scale": 8.0}),
        ("crane-wheel", {"order": 1}),
    ],
)
def test_every_key_of_a_run_is_on_the_page(name, inputs):
    """Numbers that a run reports are explained; sentences and names have their place in other tables."""
    run, text = load_case(name, **inputs).run(), SCRIPT["page"]()
    words = {"assumptions", "warnings", "notices", "notes", "name"}
    numbers = {key: value for key, value in run.summary.items() if key not in OF_EVERY_RUN | words}
    assert not [key for key in dict.fromkeys(keys_of(numbers)) if f"`{key}`" not in text]


__all__ = ["few_points", "small"]


def test_the_page_runs_from_top_to_bottom(follow, small, tmp_path, monkeypatch):
    """Its Python reads the table and runs the FMU, and prints what the page shows."""
    pytest.importorskip("fmpy")
    monkeypatch.chdir(tmp_path)
    write_table(small[0], tmp_path / "out" / "creep-table-wheelset", fmu=True)
    done = follow("how-to/tables-for-multibody.md", skip=("flangeway creep-table", "creep-table: "))
    assert done == {"python": 2, "text": 2, "matlab": 1}


SOURCE = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "src" / "flangeway").rglob("*.py"))
PLACES = (r"(?:class|def) (\w+)", r"^\s*(\w+)\s*[:=]", r'"(\w+)"[:,]', r"flangeway\.(\w+)")
DEFINED = {name for place in PLACES for name in re.findall(place, SOURCE, re.MULTILINE)}
THEORY = ("contact.md", "elasticity.md", "elements.md", "torsion.md", "wheel-rail-geometry.md")


@pytest.mark.parametrize("page", THEORY)
def test_every_name_on_the_page_is_in_the_program(page):
    """Each identifier in backticks is in the package: a class, a function, a field or a key; each path exists."""
    text = (ROOT / "docs" / "theory" / page).read_text(encoding="utf-8")
    quoted = re.findall(r"`([A-Za-z_][\w./]*)(?:\([^`]*\))?`", re.sub(r"```.*?```", "", text, flags=re.DOTALL))
    names = {word for word in quoted if "_" in word or "." in word or re.match(r"[A-Z][a-z]+[A-Z]?", word)}
    assert len(names) > 10
    for name in names:
        if "/" in name:
            assert (ROOT / name).exists() or (ROOT / "src" / "flangeway" / name).exists(), name
        elif name.endswith(".csv"):
            continue
        elif name.endswith(".json"):
            assert f"``{name}``" in SOURCE, name
        else:
            for part in name.removeprefix("fw.").removeprefix("flangeway.").split("."):
                assert part in DEFINED, f"{name} on {page}"


HOW_TOS = Path(__file__).parents[2] / "docs" / "how-to"
OF_ALL_COMMANDS = ("--help", "--out", "--quiet", "--json", "--no-pictures", "--units", "--xlsx")


def text_of(name):
    return (HOW_TOS / f"{name}.md").read_text(encoding="utf-8")


def test_the_page_of_case_files_names_all_cases_and_the_format():
    """Each case is in the table, and the number of the format is the program's."""
    for words in (*CASES, f"flangeway = {FORMAT}"):
        assert f"`{words}`" in text_of("write-a-case-file")


def test_commands_on_case_files(call, tmp_path):
    """`schema` writes what it prints; `check` finds profiles beside a case file; all cases are listed."""
    assert call("init", "cook")[0] == 0
    assert call("check", "cook.toml")[1].startswith("cook.toml: a case two-bodies")
    status, out, _ = call("schema")
    assert (status, out[0]) == (0, "{")
    assert call("schema", "--to", "s.json")[0] == 0
    assert (tmp_path / "s.json").read_text(encoding="utf-8") == out
    (tmp_path / "elsewhere").mkdir()
    assert call("profile", "S1002", "--to", "elsewhere/mine.whl", "--no-pictures")[0] == 0
    own = 'case = "wheelset"\n[wheelset]\nwheel = { file = "mine.whl", body = "S1002" }\n'
    (tmp_path / "elsewhere" / "own.toml").write_text(own, encoding="utf-8")
    assert call("check", "elsewhere/own.toml")[0] == 0


def test_the_page_of_profiles_names_all_options_and_formats(call):
    """Each option of the command and each ending of a format is explained on the page."""
    text, (_, shown, _) = text_of("bring-your-profile"), call("profile", "--help")
    for option in set(re.findall(r"--[a-z-]+", shown)).difference(OF_ALL_COMMANDS):
        assert f"`{option}" in text or f" {option} " in text, option
    for ending in READABLE:
        assert f"`{ending}`" in text, ending


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize(("method", "words"), [("F", "triangles"), ("V", "dual polygons")])
def test_the_table_of_nearly_incompressible_numbers_is_computed(method, words, order):
    """The rows of the page's table for the two coarser meshes are those of the program, to their last digit."""
    (row,) = re.findall(rf"^\| {words}, order {order} \|(.*)\|$", text_of("nearly-incompressible"), flags=re.MULTILINE)
    for level, given in enumerate(re.findall(r"-[\d.]+", row)[:2], start=1):
        work = solve_cook(CookCode(method, level, order).space(), 0.4999).load_work
        error = 100.0 * (work / NEARLY_INCOMPRESSIBLE_WORK - 1.0)
        assert error == pytest.approx(float(given), abs=1.5 * 10.0 ** -len(given.partition(".")[2]))
