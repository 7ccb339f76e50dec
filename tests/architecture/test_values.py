"""Objects are values: no class assigns to its attributes after construction, but for named exceptions."""

import ast
from collections.abc import Iterator

import pytest

from tests.architecture.conftest import FILES, parsed

CONSTRUCTORS = {"__init__", "__post_init__", "__new__", "__init_subclass__"}
MAKERS = {"copy", "replace", "cls", "new", "__new__"}
"""Functions besides classes whose result is a new object: the function that makes it may complete it."""
STATEMENTS = (ast.Assign, ast.AnnAssign, ast.AugAssign, ast.Delete, ast.For, ast.comprehension, ast.withitem, ast.Call)
"""Nodes that may change an attribute."""
MUTATORS = {"append", "appendleft", "extend", "insert", "add", "update"}
MUTATORS |= {"pop", "popitem", "popleft", "remove", "discard", "clear"}

EXCEPTIONS = {
    # caches: the same question has the same answer, found sooner
    "contact.rolling.rolling_contact.RollingContact": "cache of operators of its grid",
    "railway.rigid.rigid_geometry.RigidGeometry": "cache of paths",
    "records.Record": "cache of descriptions, read from the source when they are first shown",
    "solve.condensed.CondensedBodies": "cache of the flexibilities that were asked for last",
    "solve.linear.IndefiniteFactor": "cache of the second factor, made where the first one is not stable",
    "system.disk_cache.LatestValues": "cache",
    "tables.creep_sampling.SampledPatch": "cache of exact solutions",
    # what goes on in time
    "campaign.campaign_run._Run": "queue of rows and counts of what is done",
    "cli.common.Show": "progress: times of the stages that a user waits for",
    "live.engine.LiveEngine": "server: files and the newest request",
    "live.server.LiveServer": "server",
    "live.server._Server": "server",
    "system.workers.LocalWorkers": "pool of processes, started anew when one is lost",
    # objects of other programs
    "campaign.database._connected": "database handle",
    "cli": "environment of Matplotlib, before it is loaded",
    "cli.common.shows_results": "signature of a command, which typer reads",
    "cli.run_cases._command_on_a_case": "signature of a command, which typer reads",
    "report.page.html_page._template": "environment of Jinja",
    "system.operating_system.environment": "environment of processes",
    "system.workbook.write_workbook": "sheet of openpyxl",
    # readers: what a file or a case says is collected line by line
    "formats.abaqus_files._take": "model of an input file",
    "formats.abaqus_files._take_elements": "model of an input file",
    "formats.abaqus_files._take_nodes": "model of an input file",
    "formats.abaqus_files._take_surface": "model of an input file",
    "formats.dxf_files._arcs": "drawing of a file",
    "formats.dxf_files._draw": "drawing of a file",
}
"""Classes and functions of modules that assign to attributes, with the reason."""


def assigned(node: ast.AST) -> Iterator[ast.expr]:
    """What a statement binds or deletes, each part of a tuple by itself."""
    targets: list[ast.expr] = []
    if isinstance(node, ast.Assign | ast.Delete):
        targets = list(node.targets)
    elif isinstance(node, ast.AugAssign | ast.For | ast.comprehension) or (
        isinstance(node, ast.AnnAssign) and node.value is not None
    ):
        targets = [node.target]
    elif isinstance(node, ast.withitem) and node.optional_vars is not None:
        targets = [node.optional_vars]
    while targets:
        target = targets.pop()
        if isinstance(target, ast.Tuple | ast.List):
            targets += target.elts
        else:
            yield target.value if isinstance(target, ast.Starred) else target


def changed_objects(node: ast.AST) -> Iterator[ast.expr]:
    """Objects of which a node sets, deletes or fills an attribute."""
    for target in assigned(node):
        base = target
        while isinstance(base, ast.Subscript):
            base = base.value
        if isinstance(base, ast.Attribute):
            yield base.value
        elif isinstance(base, ast.Call) and last_name(base.func) == "vars" and base.args:
            yield base.args[0]
    if isinstance(node, ast.Call) and node.args and last_name(node.func) in ("setattr", "__setattr__"):
        yield node.args[0]
    if isinstance(node, ast.Call) and last_name(node.func) in MUTATORS and isinstance(node.func, ast.Attribute):
        filled = node.func.value
        if isinstance(filled, ast.Attribute) and isinstance(filled.value, ast.Name) and filled.value.id == "self":
            yield filled.value


def last_name(function: ast.expr) -> str:
    """Name of a function that is called, without the object before it."""
    return function.id if isinstance(function, ast.Name) else getattr(function, "attr", "")


def makes_an_object(value: ast.expr | None) -> bool:
    """Whether an expression is a call of a class, or of a function that returns a new object."""
    if not isinstance(value, ast.Call):
        return False
    name = last_name(value.func)
    return name[:1].isupper() or name in MAKERS


def rewrites(function: ast.AST, name: str) -> bool:
    """Whether a function changes an attribute of an object that it has not made itself."""
    nodes = [node for node in ast.walk(function) if isinstance(node, STATEMENTS)]
    made = {
        target.id
        for node in nodes
        if isinstance(node, ast.Assign | ast.AnnAssign) and makes_an_object(node.value)
        for target in assigned(node)
        if isinstance(target, ast.Name)
    }
    made |= {"self", "cls"} if name in CONSTRUCTORS else set()
    return any(ast.unparse(changed) not in made for node in nodes for changed in changed_objects(node))


def rewriting(tree: ast.Module, module: str) -> set[str]:
    """Classes, functions outside of them, and the module itself, that change attributes after construction."""
    found: set[str] = set()

    def visit(body: list[ast.stmt], scope: str, *, in_class: bool) -> None:
        for node in body:
            if isinstance(node, ast.ClassDef):
                visit(node.body, f"{module}.{node.name}", in_class=True)
            elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                if rewrites(node, node.name):
                    found.add(scope if in_class else f"{scope}.{node.name}")
            elif rewrites(node, ""):
                found.add(scope)

    visit(tree.body, module, in_class=False)
    return found


def test_no_class_assigns_to_its_attributes_after_construction() -> None:
    """Objects are values but for caches, progress, servers, objects of other programs and readers, each named."""
    found = set().union(*(rewriting(parsed(path), name) for name, path in FILES.items()))
    assert sorted(found - set(EXCEPTIONS)) == []
    assert sorted(set(EXCEPTIONS) - found) == []  # none is named that is no exception


REWRITING = {
    "assignment": "def go(self): self.x = 1",
    "annotated": "def go(self): self.x: int = 1",
    "addition": "def go(self): self.x += 1",
    "one of several": "def go(self): a, (self.x, *self.y) = 1, (2, 3)",
    "deletion": "def go(self): del self.x",
    "entry": "def go(self): self.x[0] = 1",
    "list": "def go(self): self.x.append(1)",
    "loop": "def go(self):\n    for self.x in (1, 2): pass",
    "context": "def go(self):\n    with open('a') as self.x: pass",
    "frozen": "def go(self): object.__setattr__(self, 'x', 1)",
    "by name": "def go(self): setattr(self, 'x', 1)",
    "dictionary": "def go(self): vars(self)['x'] = 1",
    "property": "@property\ndef go(self):\n    self.x = 1",
    "nested": "def go(self):\n    def inner(): self.x = 1\n    inner()",
    "another object": "def go(self, other): other.x = 1",
    "an object from elsewhere": "def go(self):\n    other = self.found()\n    other.x = 1",
    "an inner object": "def __init__(self, other): other.inner.x = 1",
}
CONSTRUCTING = {
    "constructor": "def __init__(self): self.x = 1",
    "frozen": "def __post_init__(self): object.__setattr__(self, 'x', 1)",
    "copy": "def go(self):\n    result = copy(self)\n    result.x = 1\n    return result",
    "class": "def go(self):\n    result = Other()\n    result.x = 1\n    return result",
    "array": "def go(self):\n    values = self.values.copy()\n    values[0] = 1\n    return values",
}


@pytest.mark.parametrize("text", REWRITING.values(), ids=REWRITING)
def test_each_way_of_rewriting_is_seen(text: str) -> None:
    """A method that rewrites an attribute, whatever the statement, names its class."""
    body = "\n".join(f"    {line}" for line in text.splitlines())
    assert rewriting(ast.parse(f"class Probe:\n{body}"), "module") == {"module.Probe"}


@pytest.mark.parametrize("text", CONSTRUCTING.values(), ids=CONSTRUCTING)
def test_constructing_is_not_rewriting(text: str) -> None:
    """A constructor, and a function that completes an object of its own, change nothing that others have."""
    body = "\n".join(f"    {line}" for line in text.splitlines())
    assert rewriting(ast.parse(f"class Probe:\n{body}"), "module") == set()
