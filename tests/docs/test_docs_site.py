"""The documentation's site: every page in its menu, every link, every equation's function, every command."""

import importlib
import re
import shlex
from pathlib import Path

import pytest

import flangeway

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
        if anchor.startswith(("flangeway.", "studies.")):
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
            else ["studies" if name == "studies" else f"flangeway.{name}"]
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
