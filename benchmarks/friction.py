"""A half cylinder pressed on a block and pushed sideways with friction, beside Kratos and CalculiX; and memory.

The meshes and the approach are those of the block without friction. The cut then moves to the right, until a fifth of
the contact's width slides. Every program has both motions as one step each, on the same nodes, and one thread. Times
are those of the processors, which other work on the machine changes little; of two runs the faster counts.

Accuracy is the root mean square difference of the tangential traction over mu p0 from that of flangeway on edges of
0.02 mm, 22,700 nodes, over the middle 95 % of the contact. On finer meshes CalculiX comes nearer to it too. The notes
have the error of the mean traction of the middle fifth from Cattaneo's and Mindlin's, which is no measure of accuracy:
blocks of this size differ by half a per cent from the half-planes of that theory, as much as the programs do.
"""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.hertz_block import STEEL, Block, Pressed, mesh_block, press_block
from benchmarks.hertz_block_peers import press_with_calculix, press_with_kratos
from benchmarks.hertz_block_times import QUICK
from benchmarks.measurement import NO_PEER, Measurement, fastest_in_turns, taken
from benchmarks.peers import PeerMissingError
from benchmarks.samples import resident_mb
from flangeway.contact import Contact, Multiplier, NodeToSegment, SegmentToSegment, Surface, press
from flangeway.elements import Lagrange
from flangeway.geometry import Placement
from flangeway.mesh import rectangle_grid
from flangeway.problems import Body, Part
from flangeway.solve import StepSettings

FRICTION = 0.3
SHIFT = 0.014  # mm
ROUNDS = 2
FINER, FINEST = (0.1, 0.3), (0.02, 0.2)  # size at the contact and growth: 5,100 and 22,700 nodes
MAX_UNKNOWNS = 12_000
"""Surface unknowns of the contact whose memory is measured."""
LAYERS = 40
"""Layers of elements of each block below its surface: thick blocks have 120,000 nodes each."""


def measurements() -> Iterator[Measurement]:
    """A mesh of 3,600 nodes, and the memory of a long surface."""
    finest = _pushed(*FINEST)
    yield from compare(mesh_block(*QUICK), finest, {"kratos": 5.0, "calculix": 10.0})
    yield from compare(mesh_block(*FINER), finest, {"calculix": 10.0})
    yield memory(MAX_UNKNOWNS)


def quick() -> Iterator[Measurement]:
    """A coarse mesh, and a short surface."""
    yield from compare(mesh_block(0.3, 0.4), _pushed(*QUICK), {"kratos": None, "calculix": None})
    yield memory(600)


def push_block(block: Block, approach: float) -> Pressed:
    """Press and push with flangeway: order 2, averaged gaps, multipliers, bodies condensed to their surfaces."""
    start, cpu_start = time.perf_counter(), time.process_time()
    upper = Part("cylinder", Body("cylinder", block.upper, Lagrange(2), STEEL, "cut"))
    lower = Part("block", Body("block", block.lower, Lagrange(2), STEEL, "base"))
    surfaces = (
        Surface(upper, block.zone(block.upper, "arc"), block.circle),
        Surface(lower, block.zone(block.lower, "top"), block.outline),
    )
    contact = Contact(surfaces[0], surfaces[1], SegmentToSegment(weighting="dual"), Multiplier(), FRICTION)
    path = [{upper: Placement(0.0, (0.0, -approach))}, {upper: Placement(0.0, (SHIFT, 0.0))}]
    found = press(
        [contact], path, path="condensed", steps=StepSettings()
    )  # whole steps, as the other programs take them
    if not found.status.converged:
        raise RuntimeError(f"the block's friction: {found.status.message}")
    found.unknowns(upper)
    seconds, cpu_seconds = time.perf_counter() - start, time.process_time() - cpu_start
    lin, state = found.state.linearisation, found.state
    assert state.friction is not None
    pairs, surface, loaded = lin.pairs[0], contact.secondary, state.forces > 0.0
    x = surface.part.body.nodes[surface.nodes[pairs.nodes[loaded]], 0]
    pressures, tractions = (each[loaded] / pairs.areas[loaded] for each in (state.forces, state.friction.forces))
    aside, up = np.abs(found.forces[0])
    return Pressed(
        seconds, x, pressures, float(up),
        tractions=tractions, tangential_force=float(aside), cpu_seconds=cpu_seconds,
    )  # fmt: skip


def _pushed(size: float, growth: float) -> Pressed:
    block = mesh_block(size, growth)
    return push_block(block, press_block(block).approach)


def compare(block: Block, finest: Pressed, asked: dict[str, float | None]) -> Iterator[Measurement]:
    """Pressed and pushed beside peers, with the ratios asked; accuracy is that beside the finest mesh."""
    with tempfile.TemporaryDirectory() as folder:
        approach = press_block(block).approach
        peers = {"kratos": press_with_kratos, "calculix": press_with_calculix}
        peer_of = {name: partial(each, friction=FRICTION, shift=SHIFT) for name, each in peers.items()}
        jobs = {"ours": partial(push_block, block, approach)}
        jobs |= {name: partial(peer_of[name], block, approach, Path(folder)) for name in asked}
        found = fastest_in_turns(jobs, dict.fromkeys(jobs, ROUNDS), _seconds)
    ours = taken(found["ours"])
    work = f"a half cylinder pressed on a block and pushed with friction, {block.n_nodes} nodes"
    error = ours.traction_difference(finest, FRICTION)
    centre = f"tangential over normal force, and error of the centre from Cattaneo's: ours {_centre(ours)}"
    for name, ratio in asked.items():
        peer = found[name]
        if isinstance(peer, PeerMissingError):
            yield Measurement(work, name, _seconds(ours), None, error, None, str(peer), asked=ratio)
            continue
        theirs = peer.traction_difference(finest, FRICTION)
        note = f"{centre}, the peer's {_centre(peer)}"
        yield Measurement(
            work, name, _seconds(ours), _seconds(peer), error, theirs, note, peer_version=peer.note, asked=ratio
        )


def _centre(pressed: Pressed) -> str:
    error = pressed.centre_traction_error(FRICTION)
    return f"{pressed.tangential_force / pressed.force:.4f} and {100.0 * error:.2f} %"


def _seconds(pressed: Pressed) -> float:
    assert pressed.cpu_seconds is not None
    return pressed.cpu_seconds


def memory(n_unknowns: int) -> Measurement:
    """Peak memory of a contact with friction of surfaces with so many unknowns, in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.friction", str(n_unknowns)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    told = json.loads(done.stdout.splitlines()[-1])
    work = f"two blocks pressed and pushed with friction, {told['unknowns']} unknowns on the surfaces, all closed"
    more = {"peak_memory_MB": told["peak_MB"], "asked_peak_memory_MB": 4000.0}
    return Measurement(work, NO_PEER, told["cpu_s"], None, None, None, "time of the processors", more=more)


def _press_long_surfaces(n_unknowns: int) -> None:
    """Press two blocks of many surface nodes until all are closed, and push them; print the peak."""
    n = n_unknowns // 4
    meshes = [rectangle_grid(0.02 * n, 4.0, n - 1, LAYERS, origin=(0.0, y)) for y in (0.0, -4.0)]
    upper, lower = (
        Part(name, Body(name, mesh, Lagrange(1), STEEL, held))
        for name, mesh, held in zip(("upper", "lower"), meshes, ("top", "bottom"), strict=True)
    )
    surfaces = Surface(upper, meshes[0].edge_sets["bottom"]), Surface(lower, meshes[1].edge_sets["top"])
    contact = Contact(surfaces[0], surfaces[1], NodeToSegment(), Multiplier(), FRICTION)
    path = [{upper: Placement(0.0, (0.0, -1e-3))}, {upper: Placement(0.0, (5e-4, 0.0))}]
    found = press([contact], path, steps=StepSettings())
    if not found.status.converged:
        raise RuntimeError(found.status.message)
    unknowns = 2 * sum(len(surface.nodes) for surface in surfaces)
    closed = int((found.state.forces > 0.0).sum())
    told = {"unknowns": unknowns, "closed": closed, "peak_MB": resident_mb(), "cpu_s": time.process_time()}
    print(json.dumps(told))


if __name__ == "__main__":
    _press_long_surfaces(int(sys.argv[1]))
