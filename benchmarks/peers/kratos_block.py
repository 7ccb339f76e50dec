"""Press the block's meshes together with Kratos; run by the interpreter of its own environment.

``kratos_block.py FOLDER N_STEPS`` reads ``FOLDER/kratos.npz`` and prints seconds, pressures and force as JSON. The time
holds the solver's and the contact search's preparation and all steps, not the building of the nodes and elements.
"""

import json
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import KratosMultiphysics as KM  # noqa: N817 (the name in all of its documents)
import numpy as np
from KratosMultiphysics import ContactStructuralMechanicsApplication as Contact
from KratosMultiphysics.StructuralMechanicsApplication.structural_mechanics_analysis import StructuralMechanicsAnalysis

PARTS = ("upper", "lower", "cut", "base", "contact", "slave")


def parameters(folder: Path, stored: Any, n_steps: int) -> KM.Parameters:
    """Settings as in Kratos' own test of Hertz's problem, with its fastest linear solver in the wheels."""
    friction = float(stored["friction"])
    kind = "Frictional" if friction else "Frictionless"
    down = -float(stored["approach"])
    motions = [_held("cut", [0.0, f"{down!r}*t/{n_steps}.0", 0.0], n_steps if friction else "End")]
    if friction:  # then sideways
        motions.append(
            _held("cut", [f"{float(stored['shift'])!r}*(t-{n_steps}.0)/{n_steps}.0", down, 0.0], first=n_steps)
        )
    settings = {
        "problem_data": {
            "problem_name": "block",
            "parallel_type": "OpenMP",
            "start_time": 0.0,
            "end_time": (2 if friction else 1) * n_steps - 0.01,
            "echo_level": 0,
        },
        "solver_settings": {
            "model_part_name": "Structure",
            "domain_size": 2,
            "solver_type": "Static",
            "echo_level": 0,
            "analysis_type": "non_linear",
            "model_import_settings": {"input_type": "use_input_model_part"},
            "material_import_settings": {"materials_filename": str(folder / "kratos_materials.json")},
            "time_stepping": {"time_step": 1.0},
            "contact_settings": {"mortar_type": f"ALMContact{kind}", "fancy_convergence_criterion": False},
            "clear_storage": True,
            "reform_dofs_at_each_step": True,
            "convergence_criterion": "contact_residual_criterion",
            "displacement_relative_tolerance": 1e-5,
            "residual_relative_tolerance": 1e-5,
            "max_iteration": 30,
            "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"},
            "rotation_dofs": False,
        },
        "processes": {
            "constraints_process_list": [
                _held("base", [0.0, 0.0, 0.0]),
                *motions,
            ],
            "contact_process_list": [
                {
                    "python_module": "alm_contact_process",
                    "kratos_module": "KratosMultiphysics.ContactStructuralMechanicsApplication",
                    "Parameters": {
                        "model_part_name": "Structure",
                        "assume_master_slave": {"0": ["slave"]},
                        "contact_model_part": {"0": ["contact"]},
                        "contact_type": kind,
                        "friction_coefficients": {"0": friction},
                        # its own choice, boxes that overlap, misses the outer third of the contact on fine meshes
                        "search_parameters": {"type_search": "in_radius"},
                    },
                }
            ],
        },
    }
    return KM.Parameters(json.dumps(settings))


def _held(name: str, value: list[Any], last: float | str = "End", first: float = 0.0) -> dict[str, Any]:
    """Displacements given on the nodes of a part."""
    begin = first + 0.5 if first else 0.0
    return {
        "python_module": "assign_vector_variable_process",
        "kratos_module": "KratosMultiphysics",
        "Parameters": {
            "model_part_name": f"Structure.{name}",
            "variable_name": "DISPLACEMENT",
            "interval": [begin, last if isinstance(last, str) else last + 0.5],
            "constrained": [True, True, True],
            "value": value,
        },
    }


def materials(young: float, poisson: float) -> str:
    """Plane strain for both bodies."""
    return json.dumps(
        {
            "properties": [
                {
                    "model_part_name": f"Structure.{name}",
                    "properties_id": number,
                    "Material": {
                        "constitutive_law": {"name": "LinearElasticPlaneStrain2DLaw"},
                        "Variables": {"YOUNG_MODULUS": young, "POISSON_RATIO": poisson, "THICKNESS": 1.0},
                        "Tables": {},
                    },
                }
                for number, name in ((1, "upper"), (2, "lower"))
            ]
        }
    )


def build(part: KM.ModelPart, stored: Any) -> None:
    """Nodes, elements, contact conditions and the parts that name them."""
    for number, (x, y) in enumerate(stored["points"].tolist(), start=1):
        part.CreateNewNode(number, x, y, 0.0)
    of = {name: part.CreateSubModelPart(name) for name in PARTS}
    number = 0
    for name, properties in (("upper", 1), ("lower", 2)):
        material = part.CreateNewProperties(properties)
        for corners in (stored[f"{name}_triangles"] + 1).tolist():
            number += 1
            part.CreateNewElement("SmallDisplacementElement2D3N", number, corners, material)
    first = 0
    for name in ("upper", "lower"):
        triangles = stored[f"{name}_triangles"]
        of[name].AddNodes((np.unique(triangles) + 1).tolist())
        of[name].AddElements(list(range(first + 1, first + len(triangles) + 1)))
        first += len(triangles)
    plain = part.CreateNewProperties(0)
    conditions = [
        part.CreateNewCondition("LineCondition2D2N", number, ends, plain).Id
        for number, ends in enumerate((stored["contact_edges"] + 1).tolist(), start=1)
    ]
    slaves = np.unique(stored["contact_edges"][stored["slave"]]) + 1
    for name in ("cut", "base"):
        of[name].AddNodes((stored[name] + 1).tolist())
    of["contact"].AddNodes((np.unique(stored["contact_edges"]) + 1).tolist())
    of["contact"].AddConditions(conditions)
    of["slave"].AddNodes(slaves.tolist())
    of["slave"].AddConditions(np.array(conditions)[stored["slave"]].tolist())


def main(folder: Path, n_steps: int) -> None:
    """Solve and print."""
    KM.Logger.GetDefaultOutput().SetSeverity(KM.Logger.Severity.WARNING)
    with np.load(folder / "kratos.npz") as file:
        stored = dict(file)
    (folder / "kratos_materials.json").write_text(
        materials(float(stored["young"]), float(stored["poisson"])), encoding="utf-8"
    )
    model = KM.Model()
    analysis = StructuralMechanicsAnalysis(model, parameters(folder, stored, n_steps))
    part = model["Structure"]
    build(part, stored)
    start, cpu_start = time.perf_counter(), time.process_time()
    analysis.Initialize()
    analysis.RunSolutionLoop()
    seconds, cpu_seconds = time.perf_counter() - start, time.process_time() - cpu_start
    nodes = [part.Nodes[int(i) + 1] for i in np.unique(stored["contact_edges"][stored["slave"]])]
    nodes = [node for node in nodes if node.Is(KM.ACTIVE)]
    pressures = np.array([-node.GetValue(Contact.AUGMENTED_NORMAL_CONTACT_PRESSURE) for node in nodes])
    reaction = [part.Nodes[int(i) + 1].GetSolutionStepValue(KM.REACTION_Y) for i in stored["base"]]
    aside = [part.Nodes[int(i) + 1].GetSolutionStepValue(KM.REACTION_X) for i in stored["base"]]
    traction = Contact.AUGMENTED_TANGENT_CONTACT_PRESSURE
    tractions = [node.GetValue(traction)[0] for node in nodes] if float(stored["friction"]) else []
    print(
        json.dumps(
            {
                "seconds": seconds,
                "cpu_seconds": cpu_seconds,
                "x": [node.X0 for node in nodes],
                "pressures": pressures.tolist(),
                "force": float(np.sum(reaction)),
                "tractions": tractions,
                "tangential_force": float(np.sum(aside)),
                "version": version("KratosMultiphysics"),
            }
        )
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
