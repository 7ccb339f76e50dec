"""The FMU gives the table's forces in FMPy, needs no Python, and says what it cannot do."""

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from flangeway.errors import MissingLibraryError
from flangeway.tables.creep_table import SIDES
from flangeway.tables.table_outputs import refuse_without_compiler, start_values, write_fmu

STATE = {"lateral": 2e-4, "yaw": 0.0, "load": 1e5, "speed": 20.0, "rotation": 43.6, "lateral_velocity": 0.02}
STATE |= {"yaw_rate": 1e-3, "friction": 0.25}
INPUTS, OUTPUTS = tuple(STATE), ("fx", "fy", "fz", "mx", "my", "mz", "normal", "longitudinal", "lateral")
VARIABLES = ("time", *INPUTS, *(f"{side}_{name}" for side in SIDES for name in OUTPUTS), "outside", "clamp")
REFERENCES = {name: number for number, name in enumerate(VARIABLES)}


@pytest.fixture(scope="module")
def fmus(small, tmp_path_factory):
    """FMUs of the small table by version of FMI."""
    folder = tmp_path_factory.mktemp("fmu")
    for fmi in ("2.0", "3.0"):
        write_fmu(small[0], fmi, folder / f"{fmi}.fmu")
    return {fmi: folder / f"{fmi}.fmu" for fmi in ("2.0", "3.0")}


def expected(table, state):
    """Outputs of the table at a state of the FMU: axes ahead, right, down and SI units."""
    position = 1e3 * state["lateral"], -1e3 * state["yaw"], 1e-3 * state["load"]
    contacts = table.contacts(*position)
    motion = {"speed": 1e3 * state["speed"], "rotation": state["rotation"], "yaw_rate": -state["yaw_rate"]}
    creepages = table.creepages(contacts, position[1], lateral_velocity=1e3 * state["lateral_velocity"], **motion)
    forces = table.forces(*position, creepages, friction=state["friction"])
    push, moment = table.wrench(contacts, forces)
    rows = []
    for side in range(2):
        (right, up, ahead), (turning, yawing, rolling) = push[0, side], 1e-3 * moment[0, side]
        across = forces[0, side, :, 1].sum() * (1.0, -1.0)[side]
        sums = contacts["normal_force_N"][0, side].sum(), forces[0, side, :, 0].sum(), across
        rows += [ahead, right, -up, -rolling, -turning, -yawing, *sums]
    return np.array(rows)


@pytest.fixture
def slave(fmus, tmp_path):
    """The model by FMI 2 in this process: a function of inputs that returns status and outputs."""
    description, folder = fmpy.read_model_description(fmus["2.0"]), fmpy.extract(fmus["2.0"], tmp_path / "out")
    model = FMU2Slave(
        guid=description.guid, unzipDirectory=folder, modelIdentifier="WheelsetCreepForces", instanceName="test"
    )
    model.instantiate()
    model.setupExperiment(startTime=0.0)
    model.enterInitializationMode()
    model.exitInitializationMode()

    def outputs(**state):
        for name, value in (STATE | state).items():
            (model.setBoolean if name == "clamp" else model.setReal)([REFERENCES[name]], [value])
        model.doStep(0.0, 1e-3)
        return np.array(model.getReal([REFERENCES[f"{side}_{name}"] for side in SIDES for name in OUTPUTS]))

    yield outputs
    model.terminate()
    model.freeInstance()


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_fmpy_gives_the_forces_of_the_table(small, fmus, fmi):
    """By both versions of FMI, along a lateral motion, outputs are the table's to 1e-9; the description is valid."""
    assert validate_fmu(str(fmus[fmi])) == []
    names = [f"{side}_{name}" for side in SIDES for name in OUTPUTS]
    motion = np.array([(0.0, 0.0), (1.0, 4e-4)], dtype=[("time", float), ("lateral", float)])
    start = {name: value for name, value in STATE.items() if name != "lateral"}
    found = fmpy.simulate_fmu(
        str(fmus[fmi]), stop_time=1.0, output_interval=0.5, input=motion, start_values=start, output=names
    )
    for row, lateral in zip(found, (0.0, 0.0, 2e-4), strict=True):  # a step has the inputs of its beginning
        wanted = expected(small[0], STATE | {"lateral": lateral})
        np.testing.assert_allclose([row[name] for name in names], wanted, rtol=1e-9, atol=1e-6)


def test_cubics_over_positions_are_those_of_the_table(small, tmp_path):
    """Five lateral positions and three loads, one interval not joined: outputs are the table's to 1e-9 everywhere."""
    shape, values = (5, 1, 3), {}
    for name, array in small[0].values.items():  # the axes and `joined` are replaced below
        rows = array[np.arange(5) % len(array)] if array.ndim > 3 else array
        factor = 1.0 + 0.02 * np.sin(np.arange(15.0)).reshape(5, 1, 3, *[1] * max(array.ndim - 3, 0))
        values[name] = rows * factor if array.ndim > 3 else rows
    joined = np.ones((4, 1, 2, 2), dtype=np.bool_)
    joined[2, 0, 1, 1] = False
    axes = {"lateral_mm": np.array([0.0, 0.5, 0.8, 1.4, 2.0]), "load_kN": np.array([80.0, 100.0, 130.0])}
    table = replace(small[0], values=values | axes | {"joined": joined})
    assert table.values["forces"].shape[:3] == shape
    write_fmu(table, "2.0", tmp_path / "wide.fmu")
    names = [f"{side}_{name}" for side in SIDES for name in OUTPUTS]
    random = np.random.default_rng(4)
    lateral, load = 1e-3 * random.uniform(0.0, 2.0, 20), 1e3 * random.uniform(80.0, 130.0, 20)
    rows = [(float(k), *each) for k, each in enumerate(zip(lateral, load, strict=True))]
    motion = np.array(rows, dtype=[("time", float), ("lateral", float), ("load", float)])
    start = {name: value for name, value in STATE.items() if name not in ("lateral", "load")}
    found = fmpy.simulate_fmu(
        str(tmp_path / "wide.fmu"), stop_time=19.0, output_interval=1.0, input=motion, start_values=start, output=names
    )
    for row, one, other in zip(found[1:], lateral, load, strict=False):
        wanted = expected(table, STATE | {"lateral": one, "load": other})
        np.testing.assert_allclose([row[name] for name in names], wanted, rtol=1e-9, atol=1e-6)


@pytest.mark.skipif(shutil.which("ldd") is None, reason="ldd tells what a library needs")
def test_a_host_needs_no_python(fmus, tmp_path):
    """The library needs none of Python's."""
    library = Path(fmpy.extract(fmus["2.0"], tmp_path)) / "binaries" / "linux64" / "WheelsetCreepForces.so"
    needs = subprocess.run(["ldd", library], check=True, capture_output=True, text=True).stdout
    assert "libm" in needs
    assert "python" not in needs


def test_the_start_is_free_rolling_in_the_middle(small, slave):
    """At its start values the wheelset carries the load of the middle, and creep forces ahead cancel each other."""
    found = slave(**start_values(small[0]))
    assert found[[2, 11]].sum() == pytest.approx(-start_values(small[0])["load"], rel=1e-3)
    assert abs(found[[0, 9]].sum()) < 0.02 * found[6]


def test_backwards_is_the_mirror_image_of_ahead(slave):
    """A wheelset that runs backwards has the forces of one ahead seen in a mirror across the track."""
    ahead = slave()
    back = slave(speed=-20.0, rotation=-43.6, yaw_rate=-1e-3)
    signs = np.tile([-1, 1, 1, 1, -1, -1, 1, -1, 1], 2)
    np.testing.assert_allclose(back, signs * ahead, rtol=1e-12, atol=1e-9)


def test_standstill_has_finite_forces_within_the_cone(slave):
    """Without speed a wheel that spins slides: its creep force is at most friction times its normal force."""
    found = slave(speed=0.0, rotation=5.0, yaw_rate=0.0, lateral_velocity=0.0)
    assert np.isfinite(found).all()
    assert (np.abs(found[[7, 16]]) <= 0.25 * found[[6, 15]] * (1 + 1e-9)).all()
    assert (np.abs(found[[7, 16]]) > 0.8 * 0.25 * found[[6, 15]]).all()


def test_at_rest_there_is_no_creep_force(slave):
    """A wheel that neither moves nor turns has no creep force; towards it the force of rolling falls with the speed."""
    rest = {"rotation": 0.0, "yaw_rate": 0.0, "lateral_velocity": 0.0}
    found = slave(speed=0.0, **rest)
    normal = found[[6, 15]]
    assert np.abs(found[[7, 8, 16, 17]]).max() < 1e-9 * normal.max()
    assert np.abs(found[[0, 9]]).max() < 1e-9 * normal.max()
    assert found[[2, 11]].sum() == pytest.approx(-STATE["load"], rel=1e-3)


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_a_token_of_another_model_is_refused(fmus, fmi, tmp_path):
    """An instance needs the token of the model description (FMI 2.0: guid, FMI 3.0: instantiationToken)."""
    description, folder = fmpy.read_model_description(fmus[fmi]), fmpy.extract(fmus[fmi], tmp_path / "out")
    right = description.guid if fmi == "2.0" else description.instantiationToken
    kind = FMU2Slave if fmi == "2.0" else FMU3Slave
    for token, accepted in ((right, True), ("{00000000-0000-0000-0000-000000000000}", False), ("", False)):
        names = {"unzipDirectory": folder, "modelIdentifier": "WheelsetCreepForces", "instanceName": "test"}
        model = kind(guid=token, **names)
        if accepted:
            model.instantiate()
            model.freeInstance()
        else:
            with pytest.raises(Exception, match="nstantiate"):
                model.instantiate()


@pytest.mark.parametrize(
    "wrong",
    [{"load": -1e3}, {"load": float("nan")}, {"yaw": 1e-3}, {"friction": -1.0}],
)
def test_what_the_table_does_not_have_is_an_error(slave, wrong):
    """Lift-off, what is no number, and positions beyond the table end the step with an error."""
    with pytest.raises(fmpy.fmi1.FMICallException):
        slave(**wrong)


def test_clamp_takes_the_end_of_the_table(slave):
    """With clamp a position beyond the table has the forces of its end."""
    np.testing.assert_array_equal(slave(load=9e4, clamp=True), slave())


def test_without_a_compiler_the_message_says_what_to_do(monkeypatch):
    """The variable CC names a compiler that is not there."""
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(MissingLibraryError, match="no-such-compiler"):
        refuse_without_compiler()
